"""
A stop that chatters
====================

A rod falls on a stop with a restitution of 0.7. The bounces come faster and faster, and end: infinitely many in a finite
time. The time of each bounce is exact to rounding.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_10_stop.png"

import matplotlib.pyplot as plt

import pendpin as pp

scene = pp.Scene(
    duration=4.0,
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.02)]),
    start=pp.Start(positions={"theta": 1.2}),
    effects=[
        pp.effects.Gravity(),
        pp.effects.Stop(
            lower=0.3, upper=2.0, restitution=0.7, joints=["theta"]
        ),
    ],
)
run = pp.simulate(scene, tolerance=1e-10, samples=801)
hits = [t for t, joint, kind in run.events if kind == "stop"]
figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
axes.plot(run.t, run["theta"])
axes.plot(hits, [0.3] * len(hits), "|", color="black")
axes.set(xlabel="time (s)", ylabel="theta (rad)")
print(f"{len(hits)} hits, the last at {hits[-1]:.6f} s")

# %%
# The motion:

run.animate()
