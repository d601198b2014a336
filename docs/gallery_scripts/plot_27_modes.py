"""
Modes of a hanging chain
========================

The first four modes of a chain of 30 rods, beside the exact shapes of a hanging rope: J0(j sqrt(1 - s)), with j a zero of J0 and s
measured from the top.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import j0, jn_zeros

import pendpin as pp

scene = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1 / 30, mass=1 / 30)], copies=30), effects=[pp.effects.Gravity()])
modes = pp.modes(scene)
print(modes)

# %%
# The frequencies of the rope are j / 2 sqrt(g / L):

rope = jn_zeros(0, 4) / 2 * np.sqrt(9.81)  # rad/s
s = np.linspace(0.0, 1.0, 200)
figure, axes = plt.subplots(1, 4, figsize=(8, 3.5), sharey=True, layout="constrained")
for panel, zero, omega in zip(axes, jn_zeros(0, 4), rope, strict=True):
    panel.plot(j0(zero * np.sqrt(1 - s)), -s)
    panel.set(xlabel=f"{omega:.3f} rad/s", xticks=[])
axes[0].set(ylabel="z / L")
