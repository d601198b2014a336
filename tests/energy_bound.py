"""The largest energy error of a run that its tolerance or step allows.

The quantity F = kinetic + potential - work is constant along the exact flow, from any state. So the local
error of a step changes F once and for all, however chaotic the motion, and the whole is at most the sum over steps:

    |F - F0| <= steps . sum_i |dF/dy_i| e (1 + |y_i|),

as a method with tolerance e keeps the local error of each of its numbers y_i below e (1 + |y_i|), in the mean. The sum
is taken where it is largest among the samples, by differences as large as the tolerance, so that what is of second
order (a stiff spring about its rest) is in it; e includes the rounding of doubles. A method with a step h has, with
Omega the fastest rate in the motion and T its duration, local errors of (Omega h)^(p + 1) of the energy and T / h
steps: (Omega h)^p Omega T in all.
"""

from typing import NamedTuple

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, bind
from pendpin.effects import Drag, Motor, Push, Rotation, Support
from pendpin.engines import Compiled
from pendpin.equations.chain.kinematics import place_along
from pendpin.ground.arrays import EPS, Array
from pendpin.model.build import FLIP
from pendpin.scene import Scene, method_of
from pendpin.trajectory import RunRecord, exchanged

STATES = 40  # samples at which slopes are taken
FEW = 6  # samples at which rates are taken
LEAST = 1e-7  # of a difference: below, rounding is larger


class Balance(NamedTuple):
    """The energy balance of a run, all in J."""

    off: float  # the largest departure
    bound: float  # what the setting allows
    moved: float  # the energy exchanged


def balance_of(scene: Scene, run: RunRecord) -> Balance | None:
    """The energy balance of a run; None if it has none."""
    if not (run.work or run.stats.conservative):
        return None
    total, works = run.energy().total, list(run.work.values())
    off = np.abs(total - total[0]) if run.stats.conservative else np.zeros(len(run.t))
    if run.work:
        off = np.maximum(off, np.abs(run.unbalanced))
    moved = run.kinetic + np.abs(run.potential - run.potential[0]) + np.abs(works).sum(0)
    size = float((moved + np.abs(run.potential)).max())
    dynamics = _dynamics(scene, run)
    own = _of_step(scene, dynamics, run, size) if run.stats.step else 0.0
    rounding = EPS * (run.stats.steps + 100) * size
    return Balance(
        float(off.max()),
        own + _of_tolerance(dynamics, run) + rounding,
        float(exchanged(run.kinetic, *works or [run.potential])[-1]),
    )


def _dynamics(scene: Scene, run: RunRecord) -> Dynamics:
    """The dynamics of the run, with its state."""
    solver = scene.solver.with_settings(method=run.stats.method, **_setting(run))
    return bind(scene.model_copy(update={"solver": solver}))


def _setting(run: RunRecord) -> dict[str, float | None]:
    return {"step": run.stats.step} if run.stats.step else {"tolerance": run.stats.tolerance}


def _of_tolerance(dynamics: Dynamics, run: RunRecord) -> float:
    e = (run.stats.tolerance or 0.0) + EPS
    slopes = max(_sum_of_slopes(dynamics, q, v, e) for q, v in _states(run, STATES))
    accounts = sum(1 + float(np.abs(work).max()) for work in run.work.values())
    return run.stats.steps * e * (slopes + accounts)


def _states(run: RunRecord, most: int) -> list[tuple[Array, Array]]:
    """States of the run, (nv,) each: evenly chosen samples, and that with the most kinetic energy."""
    chosen = {*np.linspace(0, len(run.t) - 1, most).astype(int), int(np.argmax(run.kinetic))}
    return [(run.q[i], run.v[i]) for i in sorted(chosen)]


def _sum_of_slopes(dynamics: Dynamics, q: Array, v: Array, e: float) -> float:
    """sum_i |dF/dy_i| (1 + |y_i|) in J, at one state, in the numbers that the engine integrates."""
    y = dynamics.engine.pack(q, v)
    steps = max(e, LEAST) * (1 + np.abs(y))
    both = np.concatenate([y + np.diag(steps), y - np.diag(steps), y[None]])
    energies = _energies(dynamics, both)
    changes = np.abs(energies[:-1] - energies[-1]).reshape(2, -1).max(0)
    return float(changes.sum()) / max(e, LEAST)


def _energies(dynamics: Dynamics, y: Array) -> Array:
    """Kinetic and potential energy (n,) in J of states of the engine (n, size)."""
    engine = dynamics.engine
    base = engine.base if isinstance(engine, Compiled) else engine
    if hasattr(base, "directions"):
        return _energies_of_thin(dynamics, *base.directions(y))
    q, v = np.split(y, 2, axis=1)
    return sum(dynamics.energies(q, v))


def _energies_of_thin(dynamics: Dynamics, d: Array, rate: Array) -> Array:
    """The same from directions and their rates (n, rods, 3) in I; only fields have a potential there."""
    chain = dynamics.model.chain
    assert chain is not None
    (centres, _), (speeds, _) = place_along(chain, d), place_along(chain, rate)
    kinetic = 0.5 * (chain.m * (speeds**2).sum(-1) + chain.I1 * (rate**2).sum(-1)).sum(-1)
    return kinetic - (chain.m * (centres @ (FLIP @ dynamics.loads.constant))).sum(-1)


def _of_step(scene: Scene, dynamics: Dynamics, run: RunRecord, size: float) -> float:
    h, order = run.stats.step, method_of(run.stats.method).order
    assert h is not None
    driven = [rate for effect in scene.effects for rate in _rates_of(effect)]
    fastest = max([_fastest(dynamics, *state) for state in _states(run, FEW)] + driven)
    return min(fastest * h, 1e30) ** order * (1 + fastest * scene.duration) * size


def _rates_of(effect: object) -> list[float]:
    """How fast an effect goes by itself, rad/s."""
    if isinstance(effect, Rotation):
        return [float(np.linalg.norm(effect.vector))]
    return [effect.frequency or 0.0] if isinstance(effect, Drag | Motor | Push | Support) else []


def _fastest(dynamics: Dynamics, q: Array, v: Array) -> float:
    """The largest of the rates and of the eigenvalues of y' in y, rad/s."""
    derivative, _ = dynamics.engine.derivative(lambda t: None)
    y, rows = dynamics.engine.pack(q, v), []
    steps = np.sqrt(EPS) * np.maximum(np.abs(y), 1.0)
    for state in [y, *(y + np.diag(steps))]:
        row = np.empty_like(y)
        derivative(row, 0.0, state)
        rows.append(row)
    slopes = ((np.array(rows[1:]) - rows[0]) / steps[:, None]).T
    return max(float(np.abs(np.linalg.eigvals(slopes)).max()), float(np.abs(v).max()))
