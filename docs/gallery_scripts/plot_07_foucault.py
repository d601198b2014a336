"""
Foucault's pendulum
===================

28 kg on a wire of 67 m in Paris. In three hours the plane of the swing turns by 34 degrees, clockwise seen from above.
"""

import matplotlib.pyplot as plt
import numpy as np

import pendpin as pp

scene = pp.load_scene("examples/foucault.toml")
run = pp.simulate(scene, duration=10800.0, samples=10801)
figure, axes = plt.subplots(figsize=(5, 5), layout="constrained")
for hour in range(4):
    swings = abs(run.t - hour * 3584) < 17  # s
    axes.plot(
        run["tip_x"][swings], run["tip_y"][swings], label=f"after {hour} h"
    )
axes.set(xlabel="east (m)", ylabel="north (m)", aspect="equal")
axes.legend()
last = run.t > 10800 - 17
x, y = run["tip_x"][last], run["tip_y"][last]
turned = np.degrees(np.arctan2(*np.array([y, x])[:, np.argmax(x)]))
expected = 3 * 15.04 * np.sin(np.radians(48.85))  # degrees, in three hours
print(f"turned by {-turned:.1f} degrees; 45 sin(latitude) is {expected:.1f}")
