"""
How far can chaos be followed?
==============================

Three runs of a double pendulum at tolerances of 1e-6, 1e-9 and 1e-12, compared with one at 1e-14. Errors grow by the same
factor each second, so each three digits of tolerance buy the same time.
"""

import matplotlib.pyplot as plt
import numpy as np

import pendpin as pp

scene = pp.load_scene("examples/double_pendulum.toml").replace(
    duration=15.0
)
reference = pp.simulate(scene, method="dop853", tolerance=1e-14)
figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
for tolerance in (1e-6, 1e-9, 1e-12):
    run = pp.simulate(scene, method="dop853", tolerance=tolerance)
    distance = np.linalg.norm(run.tips - reference.tips, axis=2).max(axis=1)
    axes.semilogy(
        run.t[1:], distance[1:] + 1e-17, label=f"tolerance {tolerance:g}"
    )
axes.set(xlabel="time (s)", ylabel="distance of the tips (m)")
axes.legend()
