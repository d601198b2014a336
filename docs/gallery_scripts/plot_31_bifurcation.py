"""
A driven pendulum becomes chaotic
=================================

A damped pendulum is driven harder and harder and recorded once a period: one point, two, four, then a band.
"""

import numpy as np

import pendpin as pp

driven = pp.Scene(
    model=pp.Chain(
        rods=[pp.Rod(length=1.0, mass=1.0, com=1.0, inertia=(0, 0, 0))]
    ),
    start=pp.Start(positions={"theta": 0.2}),
    effects=[
        pp.effects.Gravity(acceleration=1.0),
        pp.effects.Viscous(coefficient=0.5, joints=["theta"]),
        pp.effects.Motor(joint="theta", amplitude=1.06, frequency=2 / 3),
    ],
    duration=10.0,
)
strobe = pp.sections.strobe(of=("theta",), count=60, skip=150)
diagram = pp.sections.bifurcation(
    driven,
    "effects[2].amplitude",
    np.linspace(1.055, 1.085, 121),
    strobe,
)
figure = diagram.plot().figure
