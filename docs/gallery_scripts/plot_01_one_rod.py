"""
One rod in three dimensions
===========================

A uniform rod of 1 m and 1 kg swings on a universal joint. The figure has the energy, the angles, the reactions and the path
of the tip.
"""

import pendpin as pp

scene = pp.Scene(
    duration=10.0,  # s
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),  # m, kg, m
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}, velocities={"theta": 1.3, "phi": -0.8}),  # rad, rad/s
    effects=[pp.effects.Gravity()],
)
run = pp.simulate(scene, tolerance=1e-10)
figure = run.plot()

# %%
# The motion:

run.animate()
