import pendpin as pp

scene = pp.Scene(
    duration=5.0,  # s
    # m, kg, m
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}),  # rad
    effects=[pp.effects.Gravity()],
)
many = pp.simulate_many(
    scene, [[0.1, 0.2], [0.3, 0.4]], [[0.0, 0.0], [1.0, 0.0]], tolerance=1e-8
)
print(many.q.shape)  # (starts, samples, joints)
