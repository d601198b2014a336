"""
A thick rod past the pole
=========================

A rod of 5 cm radius passes the pole at a distance. Its axial inertia is small, so theta
turns fast there. This is physics; it makes the equations stiff.
"""

import matplotlib.pyplot as plt

import pendpin as pp

figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
for aim in (0.3, 0.1, 0.03):  # rad/s of theta at the start
    scene = pp.Scene(
        duration=1.0,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.05)]),
        start=pp.Start(velocities={"theta": aim, "phi": 4.0}),
    )
    run = pp.simulate(scene, tolerance=1e-11, samples=1001)
    axes.plot(
        run.t, run["theta_rate"], label=f"theta' = {aim} rad/s at the start"
    )
axes.set(xlabel="time (s)", ylabel="theta' (rad/s)")
axes.legend()
