"""
A cable of 50 links
===================

A cable of 10 m is drawn aside and released. Its free end whips. The picture shows its shape every 0.1 s.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_04_cable.png"

import matplotlib.pyplot as plt
import numpy as np

import pendpin as pp

run = pp.simulate(
    "examples/hanging_cable.toml", duration=4.0, samples=161
)
figure, axes = plt.subplots(figsize=(6, 5), layout="constrained")
for k in range(0, 81, 4):
    shape = np.vstack([[0, 0, 0], run.tips[k]])  # (rods + 1, 3) m
    axes.plot(
        shape[:, 1], shape[:, 2], color=plt.cm.viridis(k / 80), linewidth=1
    )
axes.set(xlabel="y (m)", ylabel="z (m)", aspect="equal")

# %%
# The motion:

run.animate()
