import pendpin as pp

start = pp.Start(
    positions={"theta": 45}, velocities={"phi": 10}, unit="degrees"
)
scene = pp.Scene(
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]),
    effects=[pp.effects.Gravity()],
)
cone = scene.replace(start=pp.Start.conical(scene, angle=0.5))  # rad
print(pp.simulate(cone, duration=2.0).maximum("R3").value)  # N
