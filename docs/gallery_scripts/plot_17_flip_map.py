"""
When does it flip?
==================

A double pendulum is released from rest at 60 by 60 angles. The colour is the time at which a rod first turns over the
top. White cells do not turn over within 8 s.
"""

import matplotlib.pyplot as plt
import numpy as np

import pendpin as pp

scene = pp.load_scene("examples/double_pendulum.toml").replace(
    duration=8.0
)
angles = np.linspace(-3.1, 3.1, 60)
found = pp.sweep(
    scene,
    {"start.positions.theta_1": angles, "start.positions.theta_2": angles},
    ["flip_time"],
    tolerance=1e-8,
)
figure, axes = plt.subplots(figsize=(5.5, 4.5), layout="constrained")
image = axes.pcolormesh(angles, angles, found["flip_time"].T, cmap="viridis")
figure.colorbar(image, label="time of the first flip (s)")
axes.set(xlabel="theta_1 (rad)", ylabel="theta_2 (rad)", aspect="equal")
