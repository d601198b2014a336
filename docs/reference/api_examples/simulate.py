import pendpin as pp

scene = pp.Scene(
    duration=5.0,  # s
    # m, kg, m
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}),  # rad
    effects=[pp.effects.Gravity()],
)
run = pp.simulate(scene, accuracy=1e-8)
print(run.stats.method, run.stats.error)
print(run.maximum("theta").value, run.maximum("R3").value)  # rad, N
