"""The effect of rounding errors of the start, the steps and the accelerations, which the motion may magnify.

A second run starts at a state shifted by many units of rounding. Its distance to the first run shows how much the motion
magnifies rounding errors. The errors of the steps add up like a random walk.
"""

from dataclasses import dataclass

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.dynamics import bind
from pendpin.engines import Engine
from pendpin.model.build import build, start_state
from pendpin.model.kinematics import apart, marks, poses, tips
from pendpin.scene import Scene
from pendpin.simulation.accuracy.runs import points
from pendpin.trajectory import Trajectory

EPS = float(np.finfo(float).eps)
START = 4.0  # units of rounding of the start, with a margin for directions in which the shift is magnified less
LINEAR = 0.05  # of the length: distance of the two runs if the target is just met
MOST_UNITS = 1e6  # largest ratio of the shift to the rounding errors
STATES = 32  # at which the rounding of the accelerations is measured
RATE = 4.0  # units of rounding in the time that the motion takes, from the rounded numbers of the model


@dataclass(frozen=True, eq=False)
class Shift:
    """A scene with its start shifted by `units` of rounding; all rounding errors together are `amount` units."""

    scene: Scene
    units: float
    amount: float


def shifted(scene: Scene, run: Trajectory, target: float) -> Shift:
    """A shifted start for `scene`, from a run of it; the shift is large compared with errors of integration at `target`."""
    model = build(scene.model)
    q, v = start_state(model, scene.start)
    amount = START + float(np.sqrt(run.stats.steps))
    units = amount * min(LINEAR / target, MOST_UNITS)
    dynamics = bind(scene)
    dq, dv = _unit(dynamics.engine, run)
    at = q - units * dq * np.where(q == 0, _directions(len(q), 1), np.sign(q))  # towards 0: never beyond the farthest
    if dynamics.contacts is not None:
        at = np.clip(at, dynamics.contacts.lower, dynamics.contacts.upper)
    start = scene.start.model_copy(
        update={
            "positions": tuple(at.tolist()),
            "velocities": tuple((v + units * dv * _directions(len(v), 2)).tolist()),
        }
    )
    return Shift(scene.model_copy(update={"start": start}), units, amount)


def _unit(engine: Engine, run: Trajectory) -> tuple[Array, Array]:
    """The rounding errors of one step in positions and rates (nv,): of their largest values, and of the accelerations."""
    some = np.unique(np.linspace(0, len(run.t) - 1, STATES).astype(int))
    t, q, v = run.t[some] - run.t[0], run.q[some], run.v[some]
    step = (run.t[-1] - run.t[0]) / max(run.stats.steps, 1)
    one, other = (engine.evaluate(t, q * (1 + x * EPS), v * (1 - x * EPS)).acceleration for x in (0, 1))
    noise = np.abs(one - other).max(0)
    return EPS * np.abs(run.q).max(0), EPS * np.abs(run.v).max(0) + step * noise


def _directions(count: int, seed: int) -> Array:
    """Numbers (count,) from 0.5 to 1 with either sign, always the same."""
    random = np.random.default_rng(seed)
    return random.uniform(0.5, 1, count) * random.choice([-1.0, 1.0], count)


def of_motion(run: Trajectory, left: Array, shift: Shift, length: float) -> Array:
    """The rounding error at the output times (n,), over the length, from the distance `left` (n,) of the shifted run."""
    t, step = run.t - run.t[0], np.linalg.norm(np.diff(points(run), axis=0), axis=-1).max(-1, initial=0.0)
    speed = np.append(0.0, np.maximum.accumulate(step / np.diff(t))) / length if len(t) > 1 else np.zeros(1)
    rate = np.append(RATE * EPS * t * speed, np.full(len(left) - len(t), np.inf))
    return EPS + rate + left * (shift.amount / shift.units)


def of_start(scene: Scene, length: float) -> float:
    """How far half a unit of rounding of the start's positions moves the tips, over the length."""
    model = build(scene.model)
    q, _ = start_state(model, scene.start)
    one, other = (marks(model, tips(model, poses(model, x[None])), x[None]) for x in (q, q - EPS / 2 * q))
    return float(apart(one, other, length)[0])
