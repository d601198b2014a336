"""
A rod that leaves the upright
=============================

A rod starts 1e-15 rad from upright, at rest. The distance grows exponentially until the rod falls. The slope is that of the
linear equation.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_14_upright.png"

import matplotlib.pyplot as plt
import numpy as np

import pendpin as pp

upright = pp.Scene(
    duration=9.5,
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.05)]),
    start=pp.Start(positions={"theta": 1e-15}),
    # up, so that theta = 0 is the upright
    effects=[pp.effects.Gravity(direction=(0.0, 0.0, 1.0))],
)
run = pp.simulate(upright, method="dop853", tolerance=1e-13)
figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
axes.semilogy(run.t, abs(run["theta"]), label="run")
rate = np.sqrt(9.81 * 0.5 / (1 / 3 + 0.05**2 / 4))  # 1/s
axes.semilogy(
    run.t, 1e-15 * np.cosh(rate * run.t), "--", label="linear equation"
)
axes.set(xlabel="time (s)", ylabel="theta (rad)", ylim=(1e-16, 100))
axes.legend()

# %%
# The motion:

run.animate()
