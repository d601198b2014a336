"""
Forces in a joint
=================

A rod swings on a universal joint with damping. The reactions R1, R2, R3 hold it; gravity and damping turn it. The
generalised force of each effect on each joint is a quantity of the run.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_01_one_rod.png"

import numpy as np

import pendpin as pp

scene = pp.Scene(
    duration=6.0,  # s
    # m, kg, m
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),
    # rad, rad/s
    start=pp.Start(
        positions={"theta": 0.7, "phi": 0.4},
        velocities={"theta": 1.3, "phi": -0.8},
    ),
    # N m s/rad
    effects=[pp.effects.Gravity(), pp.effects.Viscous(coefficient=0.2)],
)
run = pp.simulate(scene)
figure = run.plot(
    "R1", "R2", "R3", "effort_gravity_theta", "effort_viscous_theta"
)

# %%
# The tension swings twice as fast as the angles, because it is largest at the bottom of every swing. Where the rod turns
# back, its rate is 0, and so is the torque of the damping.

turns = np.flatnonzero(np.diff(np.sign(run["theta_rate"])))
damping = abs(run["effort_viscous_theta"])  # N m
print(f"damping where theta turns: at most {damping[turns].max():.3f} N m")
print(f"damping at any time:       at most {damping.max():.3f} N m")

# %%
# The motion:

run.animate()
