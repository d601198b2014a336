import pendpin as pp

scene = pp.Scene(
    duration=5.0,  # s
    # m, kg, m
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}),  # rad
    effects=[pp.effects.Gravity()],
)
many = pp.simulate_many(
    scene, [[0.1, 0.2], [0.3, 0.4]], [[0.0, 0.0], [1.0, 0.0]]
)
print(many.t[-1], many.tips().shape)  # s, (starts, samples, rods, 3)
