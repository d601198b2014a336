"""
Modes of a hanging chain
========================

The first four modes of a chain of 30 rods, beside the exact shapes of a hanging rope: J0(j sqrt(1 - s)), where j is a zero
of J0 and s is measured from the top.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import j0, jn_zeros

import pendpin as pp

scene = pp.Scene(
    model=pp.Chain(rods=[pp.Rod(length=1 / 30, mass=1 / 30)], copies=30),
    effects=[pp.effects.Gravity()],
)
modes = pp.modes(scene)
print(modes)

# %%
# Each frequency belongs to two modes, one for each direction. The frequencies of the rope are j / 2 sqrt(g / L).

s = np.linspace(0.0, 1.0, 200)
figure, axes = plt.subplots(
    1, 4, figsize=(8, 3.5), sharey=True, layout="constrained"
)
for k, (panel, zero) in enumerate(zip(axes, jn_zeros(0, 4), strict=True)):
    # rad: theta and phi of each rod against the one above
    angles = modes.shapes[2 * k].reshape(30, 2)
    # (rods, 2) m: the tips
    sideways = np.cumsum(np.cumsum(angles, axis=0), axis=0) / 30
    # 1 at the free end
    along = sideways @ sideways[-1] / (sideways[-1] @ sideways[-1])
    panel.plot(j0(zero * np.sqrt(1 - s)), -s, label="rope")
    panel.plot(along, -np.arange(1, 31) / 30, ".", label="chain")
    panel.set(
        xlabel=f"chain {modes.omega[2 * k]:.3f} rad/s\n"
        f"rope {zero / 2 * np.sqrt(9.81):.3f} rad/s",
        xticks=[],
    )
axes[0].set(ylabel="z / L")
axes[0].legend(fontsize=8)
