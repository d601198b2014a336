"""
What Euler does to the energy
=============================

The same rod with the same step of 2 ms by four methods. Semi-implicit Euler is common in games and robot simulators. Its
energy is wrong by far more than that of the others.
"""

import matplotlib.pyplot as plt

import pendpin as pp
from pendpin.scene.methods import METHODS

scene = pp.Scene(
    duration=20.0,
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.05)]),
    start=pp.Start(
        positions={"theta": 0.7, "phi": 0.4},
        velocities={"theta": 1.3, "phi": -0.8},
    ),
    effects=[pp.effects.Gravity()],
)
figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
for name in ("euler", "rk4", "gauss2", "gauss4"):
    run = pp.simulate(scene, method=name, step=0.002)
    energy = run["kinetic"] + run["potential"]
    axes.semilogy(
        run.t[1:],
        abs(energy - energy[0])[1:] + 1e-17,
        color=METHODS[name].color,
        label=name,
    )
axes.set(xlabel="time (s)", ylabel="energy error (J)")
axes.legend(ncols=4)
