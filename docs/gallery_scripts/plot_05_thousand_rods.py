"""
A thousand rods
===============

The last 200 of a thousand rods of 1 m are drawn aside and released. The chain equations take a time that grows with the
number of rods; Pinocchio's memory would grow with its cube.
"""

import matplotlib.pyplot as plt

import pendpin as pp

run = pp.simulate("examples/thousand_rods.toml", duration=4.0, samples=9)
figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
for k, t in enumerate(run.t):
    tips = run.tips[k, 780:]
    axes.plot(
        tips[:, 1], tips[:, 2], color=plt.cm.viridis(k / 8), label=f"{t:.1f} s"
    )
axes.set(xlabel="y (m)", ylabel="z (m)", aspect="equal")
axes.legend(fontsize=7)
print(f"{run.stats.evaluations} evaluations, {run.stats.seconds:.2f} s")
