"""
An acrobot, let go
==================

Two rods on hinges move in one plane, as a gymnast on a bar does. Each joint has one angle.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_29_acrobot.png"

import pendpin as pp

run = pp.simulate("examples/acrobot.toml", samples=301)
figure = run.plot("theta_1", "theta_2", "R3_1", "R3_2")
print(f"energy drift {run.energy().drift:.0e} of the energy exchanged")

# %%
# The motion:

run.animate()
