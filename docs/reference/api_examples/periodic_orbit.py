import pendpin as pp

scene = pp.Scene(
    duration=2.0,
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.05)]),
    start=pp.Start(positions={"theta": 0.7}),
    effects=[pp.effects.Gravity()],
)
orbit = pp.periodic_orbit(scene)
print(orbit.period)  # s
print(orbit.multipliers)
