"""
A crane with two loads
======================

A second load hangs on a sling that is hinged to the rope above the first: a tree of rods, on universal joints and a hinge.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_28_two_loads.png"

import pendpin as pp

run = pp.simulate("examples/two_loads.toml", samples=401)
figure = run.plot("theta_1", "phi_1", "phi_3", "R3_1", "R3_3")

# %%
# The motion, with the forces in the joints after a click on "Reactions":

run.animate()
