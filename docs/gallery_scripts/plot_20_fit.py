"""
A fit with error bars
=====================

Noisy angles of a damped rod. The fit finds the centre of mass and the damping with standard errors, and shows the residuals.
"""

import numpy as np

import pendpin as pp

true = pp.Scene(
    duration=6.0,
    model=pp.Chain(
        rods=[
            pp.Rod(
                length=0.5, mass=0.3, com=0.3, inertia=(0.007, 0.007, 0.001)
            )
        ]
    ),
    start=pp.Start(positions={"theta": 1.0}),
    effects=[pp.effects.Gravity(), pp.effects.Viscous(coefficient=0.004)],
)
run = pp.simulate(true, accuracy=1e-8, samples=301)
data = {
    "t": run.t,
    "angle": run["theta"] + np.random.default_rng(0).normal(0, 2e-3, 301),
}
guess = true.replace(
    {"model.rods[0].com": 0.25, "effects[1].coefficient": 0.001}
)
fit = pp.fit(
    guess.replace(data={"columns": {"angle": ["theta"]}, "offsets": "zero"}),
    data,
    free=["model.rods[0].com", "effects[1].coefficient"],
)
print(fit)
figure = fit.plot()
