"""The effect of rounding errors of the start, the steps and the accelerations, which the motion may magnify.

A run is shifted by many units of rounding at its start and at later times. Its distance from another run shows how
much the motion magnifies rounding errors. The later shifts are needed: a rod that falls from near upright returns to it, and
rounding of its speed at the bottom then matters most. The errors of the steps add up like a random walk.

The first, coarsest run of a search is shifted, by a small part of the target: its distance from the next run is that of
their integration errors and of the shifts together, a bound that costs nothing. Where it is too large, rounding is measured
alone.
"""

from dataclasses import replace

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.dynamics import bind
from pendpin.engines import Engine
from pendpin.model.build import build, start_state
from pendpin.model.kinematics import marks, poses, tip_distance, tips
from pendpin.scene import Scene, Start
from pendpin.simulation.accuracy.runs import Attempt, Runs, gap, points
from pendpin.simulation.checkpoint import RunState
from pendpin.trajectory import Trajectory

EPS = float(np.finfo(float).eps)
START = 4.0  # units of rounding of the start, with a margin for directions in which shifts are magnified less
STEPS = 0.5  # of sqrt(steps): units of rounding of all of them
LINEAR = 0.05  # of the length: largest distance of two runs that is in proportion to the shifts
MANY = 1e5  # ratio of the shifts to the rounding errors, unless the motion magnifies them too much
LATER = 16  # shifts after the start, at least
STATES = 32  # at which the rounding of the accelerations is measured
FIRST = 0.5  # of the target: the shifts of the first run
LARGEST_FIRST = 1e-7  # the same, at most
GUESS = 100  # steps of the first run
RATE = 4.0  # units of rounding in the time that the motion takes, from the rounded numbers of the model
STATE = ("y", "series", "canonical")  # names of the state in what an integration carries


def first_run(runs: Runs, scene: Scene, target: float) -> tuple[Trajectory, float]:
    """The first run of a search, shifted by a part of the target, and by how many units of rounding."""
    dynamics = bind(scene)
    q, v = start_state(dynamics.model, scene.start)
    units = min(FIRST * target, LARGEST_FIRST) / EPS / max(1.0, float(np.abs(q).max()))
    one = _unit(dynamics.engine, np.zeros(1), q[None], v[None], scene.duration / GUESS)
    return runs.run(_shifted(scene, one, units), between=_LaterShifts(units, len(runs.times))), units


def bounded(gap: Array, units: float, fine: Trajectory, length: float) -> Array:
    """A bound (n,) on the rounding error of the run `fine`, from the gap (n,) of the first two runs; over the length."""
    found = np.where(gap > LINEAR, np.inf, gap * (_amount(fine) / units))
    return EPS + _of_rates(fine, length, len(gap)) + found


def _amount(run: Trajectory) -> float:
    """The units of rounding of a run."""
    return START + STEPS * float(np.sqrt(run.stats.steps))


def of_motion(runs: Runs, coarse: Attempt, fine: Attempt, target: float, length: float) -> Array:
    """The rounding error of the run `fine` at the times of `runs` (n,), over the length.

    It is measured beside the run `coarse`, which costs less. If shifts of MANY times the rounding move that too far,
    smaller ones are compared with `fine` in the same segments and without shifts.
    """
    best, times, amount = fine.run, MANY, _amount(fine.run)
    left = gap(coarse.run, _disturbed(runs, coarse.scene, best, times * amount), length, len(runs.times))
    if left[-1] > LINEAR and target > LINEAR / MANY:
        times = LINEAR / target
        still, other = _side_by_side(runs, fine, times)
        left = gap(still, other, length, len(runs.times))
        left = np.where(gap(best, still, length, len(left)) > LINEAR, np.inf, left)  # segments alone change the run
    return EPS + _of_rates(best, length, len(left)) + left / times


def of_motion_like(runs: Runs, lost: Attempt, target: float, length: float) -> Array:
    """The rounding error (n,) of a motion such as that of a run that is itself wrong, over the length."""
    times = min(MANY, LINEAR / target)
    still, other = _side_by_side(runs, lost, times)
    return gap(still, other, length, len(runs.times)) / times


def _side_by_side(runs: Runs, attempt: Attempt, times: float) -> tuple[Trajectory, Trajectory]:
    """Two runs in the same segments, one of them shifted by so many times the rounding."""
    scene, run = attempt.scene, attempt.run
    return _disturbed(runs, scene, run, 0.0), _disturbed(runs, scene, run, times * _amount(run))


def _of_rates(run: Trajectory, length: float, count: int) -> Array:
    """The error (count,) of rounded numbers of the model, which make the motion a little faster or slower."""
    t, step = run.t - run.t[0], np.linalg.norm(np.diff(points(run), axis=0), axis=-1).max(-1, initial=0.0)
    speed = np.append(0.0, np.maximum.accumulate(step / np.diff(t))) / length if len(t) > 1 else np.zeros(1)
    return np.append(RATE * EPS * t * speed, np.full(count - len(t), np.inf))


def _disturbed(runs: Runs, scene: Scene, fine: Trajectory, units: float) -> Trajectory:
    """A run of the scene, shifted by so many units of rounding at its start and at later times."""
    some = np.unique(np.linspace(0, len(fine.t) - 1, STATES).astype(int))
    step = (fine.t[-1] - fine.t[0]) / max(fine.stats.steps, 1)
    one = _unit(bind(scene).engine, fine.t[some] - fine.t[0], fine.q[some], fine.v[some], step)
    return runs.run(_shifted(scene, one, units), between=_LaterShifts(units, len(runs.times)))


class _LaterShifts:
    """Shifts the state between segments of a few samples, each number by units of rounding of its largest value so far.

    Scenes with contacts are not shifted after their start.
    """

    def __init__(self, units: float, count: int) -> None:
        self._size, self._samples = units * EPS, max(1, count // LATER)
        self._random, self._largest = np.random.default_rng(3), dict[str, Array]()

    def __call__(self, done: RunState) -> RunState:
        if "ahead" not in done.carried:
            return done
        carried = done.carried | {"ahead": np.minimum(done.carried["ahead"], self._samples)}
        for name in STATE:
            if name in carried:
                y = carried[name]
                self._largest[name] = np.maximum(self._largest.get(name, 0.0), np.abs(y))
                shift = self._size * self._largest[name] * self._random.uniform(-1, 1, y.shape)
                carried[name] = y + shift * (done.n > 1)
        return replace(done, carried=carried)


def _shifted(scene: Scene, unit: tuple[Array, Array], units: float) -> Scene:
    """The scene with its start shifted by so many units of rounding (nv,) of positions and rates."""
    dynamics = bind(scene)
    q, v = start_state(dynamics.model, scene.start)
    dq, dv = unit
    at = q - units * dq * np.where(q == 0, _directions(len(q), 1), np.sign(q))  # towards 0: never beyond the farthest
    if dynamics.contacts is not None:
        at = np.clip(at, dynamics.contacts.lower, dynamics.contacts.upper)
    rates = v + units * dv * _directions(len(v), 2)
    start = Start(time=scene.start.time, positions=tuple(at.tolist()), velocities=tuple(rates.tolist()))
    return scene.model_copy(update={"start": start})


def _unit(engine: Engine, t: Array, q: Array, v: Array, step: float) -> tuple[Array, Array]:
    """The rounding errors of one step in positions and rates (nv,), from states q, v (n, nv) at t (n,).

    They are those of the largest values, and in the rates that of the accelerations over a step in s.
    """
    one, other = (engine.evaluate(t, q * (1 + x * EPS), v * (1 - x * EPS)).acceleration for x in (0, 1))
    return EPS * np.abs(q).max(0), EPS * np.abs(v).max(0) + step * np.abs(one - other).max(0)


def _directions(count: int, seed: int) -> Array:
    """Numbers (count,) from 0.5 to 1 with either sign, always the same."""
    random = np.random.default_rng(seed)
    return random.uniform(0.5, 1, count) * random.choice([-1.0, 1.0], count)


def of_start(scene: Scene, length: float) -> float:
    """How far half a unit of rounding of the start's positions moves the tips, over the length."""
    model = build(scene.model)
    q, _ = start_state(model, scene.start)
    one, other = (marks(model, tips(model, poses(model, x[None])), x[None]) for x in (q, q - EPS / 2 * q))
    return float(tip_distance(one, other, length)[0])
