"""A rod on a universal joint: simulate it, read its reactions, and let the routes check each other."""

import pendpin as pp

scene = pp.Scene(
    duration=10.0,  # s
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)]),  # m, kg, m
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}, velocities={"theta": 1.3, "phi": -0.8}),  # rad, rad/s
    effects=[pp.effects.Gravity()],
)

run = pp.simulate(scene, tolerance=1e-12)
reactions = run.reactions()
print(f"tip at the end     {run.tips[-1, 0]} m")
print(f"largest tension    {run.maximum('R3').value:.4f} N")
print(f"largest moment M3  {abs(reactions.M3).max():.2e} N m")
print(f"energy drift       {run.energy().drift:.1e}")

report = pp.crosscheck(scene, states=1000, seed=0)
worst = report.worst
print(f"routes             {', '.join(report.routes)}")
print(f"worst difference   {worst.relative:.1e} in {worst.quantity}, {worst.first} against {worst.second}")
