import pendpin as pp

scene = pp.Scene(
    duration=5.0,  # s
    # m, kg, m
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}),  # rad
    effects=[pp.effects.Gravity()],
)
dynamics = pp.bind(scene)
q, v = [0.7, 0.4], [1.3, -0.8]  # rad, rad/s
print(dynamics.wrenches(0.0, q, v))  # (joints, 6): N, then N m
print(dynamics.energy(q, v))  # J
