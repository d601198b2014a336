"""
A cable in the wind
===================

A cable of eight rods in a wind of 12 m/s with gusts. At rest in a steady wind it would hang at an angle; the gusts shake it.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_21_cable_in_wind.png"

import matplotlib.pyplot as plt
import numpy as np

import pendpin as pp

scene = pp.Scene(
    duration=8.0,
    model=pp.Chain(
        rods=[pp.Rod(length=0.5, mass=0.05, radius=0.01)], copies=8
    ),
    effects=[
        pp.effects.Gravity(),
        pp.effects.Drag(
            wind=(0.0, 12.0, 0.0), gust=(0.0, 4.0, 0.0), frequency=3.0
        ),
        pp.effects.Viscous(coefficient=0.002),
    ],
)
run = pp.simulate(scene, tolerance=1e-7, samples=241)
figure, axes = plt.subplots(figsize=(5, 4.5), layout="constrained")
for k in range(0, 241, 12):
    shape = np.vstack([[0, 0, 0], run.tips[k]])
    axes.plot(
        shape[:, 1], shape[:, 2], color=plt.cm.viridis(k / 240), linewidth=1
    )
axes.set(xlabel="y, downwind (m)", ylabel="z (m)", aspect="equal")

# %%
# The motion:

run.animate()
