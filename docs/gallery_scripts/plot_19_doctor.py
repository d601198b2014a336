"""
A doctor's report
=================

One equation of a printed derivation has a wrong sign. The report names the term; the figure shows what the fault does.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import pendpin as pp

report = pp.diagnose(
    r"\theta'' = \frac{2 \theta' \phi' \sin\phi"
    r" - \frac{3 g}{2 l} \sin\theta}{\cos\phi}"
    "\n\n"
    r"\phi'' = \theta'^2 \sin\phi \cos\phi"
    r" - \frac{3 g}{2 l} \cos\theta \sin\phi",
    rod="thin",
)
print(report)

# %%
# The two motions:


def wrong(t, y):
    """The equations as printed: the sign of the second one is wrong."""
    theta, phi, theta_rate, phi_rate = y
    g = 1.5 * 9.81  # 3 g / 2 l
    return [
        theta_rate,
        phi_rate,
        (2 * theta_rate * phi_rate * np.sin(phi) - g * np.sin(theta))
        / np.cos(phi),
        theta_rate**2 * np.sin(phi) * np.cos(phi)
        - g * np.cos(theta) * np.sin(phi),
    ]


scene = pp.Scene(
    duration=5.0,
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]),
    start=pp.Start(positions={"theta": 0.7, "phi": 0.4}),
    effects=[pp.effects.Gravity()],
)
run = pp.simulate(scene, accuracy=1e-8)
printed = solve_ivp(wrong, (0, 5), [0.7, 0.4, 0, 0], t_eval=run.t, rtol=1e-9)
figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
axes.plot(run.t, run["phi"], label="right")
axes.plot(printed.t, printed.y[1], "--", label="as printed")
axes.set(xlabel="time (s)", ylabel="phi (rad)")
axes.legend()
