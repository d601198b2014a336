import pendpin as pp

scene = pp.Scene(
    duration=5.0,  # s
    # m, kg, m
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}),  # rad
    effects=[pp.effects.Gravity()],
)
# N m s/rad
damped = scene.replace(
    effects=[*scene.effects, pp.effects.Viscous(coefficient=0.1)]
)
run = pp.simulate(damped, energy_balance=True)
print(run.work["viscous"][-1])  # J
