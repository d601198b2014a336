"""
A rod on a carousel
===================

The world turns about the vertical at 1.5 rad/s. Seen in the turning frame, the path of the tip bends to one side.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_22_carousel.png"

import matplotlib.pyplot as plt

import pendpin as pp

figure, axes = plt.subplots(figsize=(5, 5), layout="constrained")
for rate in (0.0, 0.3, 1.5):  # rad/s
    scene = pp.Scene(
        duration=8.0,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]),
        start=pp.Start(positions={"phi": 0.6}),
        effects=[
            pp.effects.Gravity(),
            pp.effects.Rotation(rate=(0.0, 0.0, rate)),
        ],
    )
    run = pp.simulate(scene, accuracy=1e-7)
    axes.plot(run["tip_x"], run["tip_y"], linewidth=0.9, label=f"{rate} rad/s")
axes.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
axes.legend()

# %%
# The motion:

run.animate()
