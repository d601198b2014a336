"""
Which number matters most?
==========================

The derivative of the angle by four numbers of the scene, each for a change of 1 %. The derivatives are exact.
"""

import matplotlib.pyplot as plt

import pendpin as pp

scene = pp.Scene(
    duration=8.0,
    model=pp.Chain(
        rods=[
            pp.Rod(
                length=1.0,
                mass=1.0,
                radius=0.05,
                com=0.55,
                inertia=(0.09, 0.09, 0.001),
            )
        ]
    ),
    start=pp.Start(positions={"theta": 0.8}),
    effects=[pp.effects.Gravity(), pp.effects.Viscous(coefficient=0.05)],
)
run = pp.simulate(scene, tolerance=1e-10)
keys = {
    "model.rods[0].com": 0.55,
    "model.rods[0].mass": 1.0,
    "effects[1].coefficient": 0.05,
    "effects[0].acceleration": 9.81,
}
slopes = run.sensitivity(list(keys), of="theta")  # (n, 4) rad per unit
figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
for k, (key, value) in enumerate(keys.items()):
    axes.plot(run.t, 0.01 * value * slopes[:, k], label=key)
axes.set(xlabel="time (s)", ylabel="change of theta for 1 % (rad)")
axes.legend(fontsize=8)
