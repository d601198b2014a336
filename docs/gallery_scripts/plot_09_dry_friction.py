"""
Dry friction that sticks
========================

A rod comes to rest away from the vertical, because its joints stick. The bars show where the energy went.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_09_dry_friction.png"

import matplotlib.pyplot as plt

import pendpin as pp

run = pp.simulate("examples/friction.toml", energy_balance=True)
figure, (left, right) = plt.subplots(
    1, 2, figsize=(8, 3), width_ratios=(2, 1), layout="constrained"
)
left.plot(run.t, run["theta"], run.t, run["phi"])
left.set(xlabel="time (s)", ylabel="theta, phi (rad)")
for t, _, kind in run.events:
    if kind == "stick":
        left.axvline(t, color="grey", linewidth=0.5)
right.bar(list(run.work), [work[-1] for work in run.work.values()])
right.set(ylabel="work (J)")
right.tick_params(axis="x", rotation=30)
for t, joint, kind in list(run.events)[-4:]:
    print(f"{t:.6f} s: {joint}: {kind}")

# %%
# The motion:

run.animate()
