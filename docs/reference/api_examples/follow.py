import pendpin as pp

scene = pp.Scene(
    duration=10.0,
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.05)]),
    effects=[
        pp.effects.Gravity(),
        pp.effects.Viscous(coefficient=0.1),
        # N m, rad/s
        pp.effects.Motor(joint="theta", amplitude=0.5, frequency=2.0),
    ],
)
orbit = pp.periodic_orbit(scene)  # the period is that of the motor
branch = pp.follow(orbit, "effects[2].amplitude", 1.0)
print(branch.values[-1], branch.orbits[-1].stable)
