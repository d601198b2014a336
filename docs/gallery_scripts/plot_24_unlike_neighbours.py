"""
A light rod below a heavy one
=============================

Rods of 1 kg and 1 mg hang below each other. The mass matrix holds numbers a million times apart. Two engines
agree to rounding.
"""

import matplotlib.pyplot as plt
import numpy as np

import pendpin as pp

rods = [
    pp.Rod(length=1.0, mass=1.0, radius=0.02),
    pp.Rod(length=0.5, mass=1e-6, radius=0.001),
]
scene = pp.Scene(
    duration=2.0,
    model=pp.Chain(rods=rods),
    start=pp.Start(positions={"theta_1": 0.6, "theta_2": 0.3, "phi_2": 0.2}),
    effects=[pp.effects.Gravity()],
)
runs = [
    pp.simulate(scene.replace({"solver.engine": name}), tolerance=1e-12)
    for name in ("pinocchio", "chain")
]
figure, (above, below) = plt.subplots(
    2, 1, figsize=(7, 4.5), sharex=True, layout="constrained"
)
above.plot(runs[0].t, runs[0]["theta_1"], label="theta_1")
above.plot(runs[0].t, runs[0]["theta_2"], label="theta_2")
above.set(ylabel="angle (rad)")
above.legend()
below.semilogy(
    runs[0].t,
    np.linalg.norm(runs[0].tips - runs[1].tips, axis=2).max(axis=1) + 1e-18,
)
below.set(xlabel="time (s)", ylabel="difference (m)")
