"""
A triple pendulum in space
==========================

Three rods of different lengths and masses. The last one starts out of the plane of the others.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_03_triple_pendulum.png"

import pendpin as pp

run = pp.simulate("examples/triple_pendulum.toml", samples=301)
figure = run.plot("theta_1", "theta_2", "theta_3", "R3_1", "R3_2", "R3_3")

# %%
# The motion:

run.animate()
