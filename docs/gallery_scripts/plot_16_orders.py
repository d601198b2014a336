"""
Orders of convergence
=====================

Halving the step divides the error by 2 to the order. The rod swings in a plane, where the exact solution is known.
"""

import matplotlib.pyplot as plt
import numpy as np

import pendpin as pp
from pendpin.equations.exact import planar
from pendpin.scene.methods import METHODS

scene = pp.Scene(
    duration=1.5,
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.05)]),
    start=pp.Start(positions={"theta": 1.0}),
    effects=[pp.effects.Gravity()],
    solver=pp.Solver(samples=16),
)
# m: inertia about the joint over the first moment
reduced = (1 / 3 + 0.05**2 / 4) / 0.5
exact = planar(1.0, 0.0, reduced, 9.81, np.linspace(0.0, 1.5, 16))  # rad
steps = [0.01 / 2**k for k in range(6)]
figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
for name in ("euler", "gauss2", "rk4", "gauss4", "gauss6"):
    errors = [
        abs(pp.simulate(scene, method=name, step=step)["theta"] - exact).max()
        for step in steps
    ]
    axes.loglog(
        steps,
        errors,
        ".-",
        color=METHODS[name].color,
        label=f"{name}, order {METHODS[name].order:g}",
    )
axes.set(xlabel="step (s)", ylabel="error of theta (rad)")
axes.legend()
