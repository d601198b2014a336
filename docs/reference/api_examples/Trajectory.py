import pendpin as pp

scene = pp.Scene(
    duration=5.0,  # s
    # m, kg, m
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}),  # rad
    effects=[pp.effects.Gravity()],
)
run = pp.simulate(scene)
print(run.summary())
print(run.at(1.234)["theta"])  # rad
print(run.crossings("theta", level=0.0, direction=+1).t)  # s
run.save("run.npz")
assert pp.Trajectory.load("run.npz") == run
