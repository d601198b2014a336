import pendpin as pp

scene = pp.Scene(
    duration=5.0,  # s
    # m, kg, m
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}),  # rad
    effects=[pp.effects.Gravity()],
)
found = pp.sweep(
    scene, {"model.rods[0].length": [0.5, 1.0, 2.0]}, ["swing", "R3.max"]
)
print(found["R3.max"].values)  # N
