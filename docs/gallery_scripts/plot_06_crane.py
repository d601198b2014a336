"""
A crane's load in gusts
=======================

A container of two tonnes on 20 m of rope is carried by a trolley that stops after 13 s. The wind blows across the track.
"""

# sphinx_gallery_thumbnail_path = "images/gallery/plot_06_crane.png"

import matplotlib.pyplot as plt
import numpy as np

import pendpin as pp

run = pp.simulate("examples/crane.toml", samples=451)
figure, (above, below) = plt.subplots(
    2, 1, figsize=(7, 5), sharex=True, layout="constrained"
)
above.plot(run.t, np.degrees(run["swing"]))
above.set(ylabel="swing (degrees)")
below.plot(run.t, run["R3_1"] / 1000)
below.set(xlabel="time (s)", ylabel="tension (kN)")

# %%
# The motion:

run.animate()
