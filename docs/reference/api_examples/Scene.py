import pendpin as pp

scene = pp.Scene(
    duration=5.0,  # s
    # m, kg, m
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}),  # rad
    effects=[pp.effects.Gravity()],
)
faster = scene.replace(
    {"start.velocities.theta": 2.0, "model.rods[0].mass": 0.5}, duration=3.0
)
faster.save("faster.toml")
assert pp.load_scene("faster.toml") == faster
