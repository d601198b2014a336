"""
A thin rod through the pole
===========================

A thin rod turns through phi = 90 degrees, where the angles of a universal joint are singular. pendpin computes its
direction, which is regular there. The tension is compared with the exact one.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_11_through_the_pole.png"

import matplotlib.pyplot as plt
import numpy as np

import pendpin as pp

scene = pp.Scene(
    duration=3.0,
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]),  # radius 0: thin
    start=pp.Start(velocities={"phi": 9.0}),
    effects=[pp.effects.Gravity()],
)
run = pp.simulate(scene, accuracy=1e-10)
figure, (above, below) = plt.subplots(
    2, 1, figsize=(7, 4.5), sharex=True, layout="constrained"
)
above.plot(run.t, run["phi"])
above.axhline(np.pi / 2, color="grey", linewidth=0.5)
above.set(ylabel="phi (rad)")
# N: m l/2 phi'^2 + m g cos(phi)
exact = 0.5 * run.v[:, 1] ** 2 + 9.81 * np.cos(run["phi"])
below.plot(run.t, run["R3"], label="R3")
below.plot(run.t, exact, "--", label="exact")
below.set(xlabel="time (s)", ylabel="tension (N)")
below.legend()
print("largest difference", abs(run["R3"] - exact).max(), "N")

# %%
# The motion:

run.animate()
