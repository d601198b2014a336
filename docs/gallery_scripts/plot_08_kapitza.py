"""
Kapitza's pendulum
==================

The support is shaken up and down by 5 cm at 100 rad/s. The rod comes to rest upright, upside down.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_08_kapitza.png"

import matplotlib.pyplot as plt

import pendpin as pp

run = pp.simulate("examples/kapitza.toml", samples=1001)
figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
axes.plot(run.t, run["theta"], linewidth=0.8, label="theta")
axes.plot(run.t, run["phi"], linewidth=0.8, label="phi")
axes.axhline(3.14159, color="grey", linewidth=0.5)
axes.set(xlabel="time (s)", ylabel="angle (rad)")
axes.legend()

# %%
# The motion:

run.animate()
