import pendpin as pp

scene = pp.Scene(
    duration=5.0,  # s
    # m, kg, m
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}),  # rad
    effects=[pp.effects.Gravity()],
)
report = pp.cost(scene, methods=["dop853", "rk4"])
print(report)
