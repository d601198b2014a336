"""Swing an acrobot up and hold it upright, by a torque at the hip alone.

First the energy of the free motion is looked at. Then a controller of one's own, a function of time, positions and rates,
pumps energy in until the acrobot is near the top, and a linear regulator catches it there.
Run it:   python examples/acrobot.py
"""

from pathlib import Path

import numpy as np
from scipy.linalg import solve_continuous_are

import pendpin as pp

free = pp.load_scene(Path(__file__).with_name("acrobot.toml"))
run = pp.simulate(free)
print(f"Let go, its energy drifts by {run.energy().drift:.0e} of what it exchanges.")

# Upright, at rest: x' = A x + B u for small changes x of the angles and rates, u the torque at the hip.
upright = np.array([np.pi, 0.0])  # rad
linear = pp.linearize(free, at=pp.Start(positions=upright.tolist()))
B = linear.B[:, linear.inputs.index("torque_theta_2")]
S = solve_continuous_are(linear.A, B[:, None], np.diag([10.0, 10.0, 1.0, 1.0]), np.eye(1))
gain = B @ S
dynamics = pp.bind(free)
top = sum(dynamics.energy(upright, np.zeros(2)))  # J


def control(t: float, q: np.ndarray, v: np.ndarray) -> tuple[float, float]:
    """The torques at bar and hip, N m, none at the bar: far from the top energy is pumped in, near it the regulator acts."""
    off = (q - upright + np.pi) % (2 * np.pi) - np.pi  # rad, whatever turns it has made
    x = np.concatenate([off, v])
    if x @ S @ x < 1000.0:
        return 0.0, -gain @ x
    lack = top - sum(dynamics.energy(q, v))  # J
    return 0.0, np.clip(-lack * v[0] - 10.0 * off[1] - v[1], -20.0, 20.0)


swung = pp.Scene(
    duration=10.0,
    model=free.model,
    start=pp.Start(positions={"theta_2": 0.01}),
    effects=[pp.effects.Gravity(), pp.effects.Torque(control, every=0.01)],  # s
    solver=pp.Solver(tolerance=1e-9),
)
run = pp.simulate(swung, energy_balance=True)
height = run.tips[:, -1, 2]  # m, of 3
print(f"The tip is above 2.99 m from {run.t[np.flatnonzero(height < 2.99)[-1]]:.1f} s on; the bar is at 0.")
print(f"The hip has done {run['work_torque'][-1]:.1f} J of work, of which {2 * top:.1f} J are the height.")
run.plot("theta_1", "theta_2").figure.savefig("acrobot.png")
