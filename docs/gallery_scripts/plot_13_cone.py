"""
A conical pendulum
==================

A steady cone of a thin rod: the tip runs round a circle, and the tension is constant.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_13_cone.png"

import pendpin as pp

one = pp.Scene(
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]),
    effects=[pp.effects.Gravity()],
    duration=5.0,
)
run = pp.simulate(
    one.replace(start=pp.Start.conical(one, angle=0.9)), accuracy=1e-9
)
figure = run.plot("theta", "phi", "R3")
low, high = run.minimum("R3").value, run.maximum("R3").value
print("tension from", low, "to", high, "N")

# %%
# The motion:

run.animate()
