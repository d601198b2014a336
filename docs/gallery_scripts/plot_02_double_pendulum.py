"""
A double pendulum
=================

Two rods swing in a plane. The motion is chaotic, so two correct runs drift apart after some time.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_02_double_pendulum.png"

import pendpin as pp

run = pp.simulate("examples/double_pendulum.toml")
figure = run.plot()

# %%
# The motion:

run.animate()
