"""How a run changes with its start and with the numbers of its scene."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from pendpin.errors import InputError, choices, is_number, not_one_of, shown
from pendpin.ground.arrays import Array
from pendpin.ground.keypaths import number_at, parsed
from pendpin.integrators import Run
from pendpin.motions.continuation import at
from pendpin.motions.variations import Variations, list_state_keys
from pendpin.runs.preparation import bind_for_run
from pendpin.runs.samples import fill_in
from pendpin.scene import Scene, scene_of
from pendpin.trajectory import RunRecord

TIGHT = 1e-10  # the tolerance beside a run with a fixed step, whose own error is larger
# what is a function of the state alone
OF_STATES = ("q", "v", "tips", "swing", "omega", "angular_momentum", "kinetic", "potential", "energy")
_STEP = 1e-3  # of differences, relative: their error is its fourth power, and rounding over it
_CENTRAL = ((-2, -1, 1, 2), (1 / 12, -2 / 3, 2 / 3, -1 / 12))
_FORWARD = ((0, 1, 2, 3, 4), (-25 / 12, 4.0, -3.0, 4 / 3, -1 / 4))  # where a number cannot be smaller, as a radius of 0

Statistic = Callable[[Array, Array, Array], Array]
STATISTICS: dict[str, Statistic] = {  # derivatives (K,) at times (n,) of a quantity x (n,) that changes by dx (n, K)
    "max": lambda t, x, dx: dx[np.argmax(x)],
    "min": lambda t, x, dx: dx[np.argmin(x)],
    "final": lambda t, x, dx: dx[-1],
    "mean": lambda t, x, dx: np.trapezoid(dx, t, axis=0) / (t[-1] - t[0]),
}


def state_transition(run: RunRecord, t0: float, t1: float) -> Array:
    """The derivatives (2 nv, 2 nv) of the state at t1 by that at t0 (Trajectory.state_transition)."""
    for name, t in (("t0", t0), ("t1", t1)):
        if not is_number(t) or not run.t[0] <= t <= run.t[-1]:
            raise InputError(f"{name}: {shown(t)} is not a time of the run, {run.t[0]:.6g} to {run.t[-1]:.6g} s")
    if t1 < t0:
        raise InputError(f"t1: {t1:.6g} s is before t0, {t0:.6g} s; invert the transition from t1 to t0 instead")
    scene, nv = scene_of(run), len(run.joints)
    variations = Variations(scene, list_state_keys(nv))
    there = at(run, [t0])
    y, times = np.concatenate([there.q[0], there.v[0]]), np.array([t0, t1]) - scene.start.time
    return variations.integrate(y, np.eye(2 * nv), times, _tolerance(run))[1][-1].T


def sensitivity(run: RunRecord, keys: Sequence[str] | str, of: str | None) -> Array:
    """The derivatives of a run, or of one number of it, by numbers of its scene (Trajectory.sensitivity)."""
    if not isinstance(keys, Sequence):
        raise InputError(f"keys: {shown(keys)} is not a list of key paths of the scene")
    keys = [keys] if isinstance(keys, str) else list(keys)
    if not keys:
        raise InputError('keys: none is given; name a number of the scene, as "model.rods[0].length"')
    name, statistic = _parts(run, of) if of is not None else ("", "")
    variations = Variations(scene_of(run), keys)
    if of is not None and variations.equations.contacts and run.places[name][0] not in OF_STATES:
        raise InputError(
            f"of: {name} jumps where a joint sticks or slips; angles, rates, energies and tips have derivatives"
        )
    times = run.t - variations.scene.start.time
    start = np.concatenate([run.q[0], run.v[0]])
    _, changes = variations.integrate(start, variations.equations.starts, times, _tolerance(run))
    changes = np.moveaxis(changes, 1, 2)  # (n, 2 nv, K)
    if of is None:
        return changes
    columns = [_change_of(run, variations.scene, key, changes[..., k], name) for k, key in enumerate(keys)]
    series = np.stack(columns, -1)
    return STATISTICS[statistic](run.t, run[name], series) if statistic else series


def _tolerance(run: RunRecord) -> float:
    return run.stats.tolerance or TIGHT


def _parts(run: RunRecord, of: str) -> tuple[str, str]:
    """The quantity and the statistic, "" for none, that `of` names. Raises InputError."""
    if not isinstance(of, str):
        raise InputError(f"of: {shown(of)} is not the name of a quantity, such as R3_1.max")
    if of in run.places:
        return of, ""
    name, _, statistic = of.rpartition(".")
    if name and statistic not in STATISTICS:
        raise InputError(f"of: {of}: {not_one_of(statistic, STATISTICS)}")
    if (name or of) not in run.places:
        with_one = choices(f".{each}" for each in STATISTICS)
        raise InputError(f"of: {not_one_of(name or of, run.places)}; alone, or with {with_one}")
    return name, statistic


def _change_of(run: RunRecord, scene: Scene, key: str, change: Array, name: str) -> Array:
    """The derivative (n,) of a quantity by one number, with that (n, 2 nv) of the state.

    Angles and rates change as the state does. Other quantities are functions of the state and the number in closed form:
    their change along it is a difference of fourth order.
    """
    nv = len(run.joints)
    for part, columns in (("q", slice(0, nv)), ("v", slice(nv, None))):
        array, place = run.places[name]
        if array == part:
            return change[:, columns][place]
    value = 0.0 if parsed(key)[0] == "start" else number_at(scene, key)
    step = _STEP / max(float(np.abs(change).max(initial=0.0)), 1 / abs(value) if value else 1.0)
    for offsets, weights in (_CENTRAL, _FORWARD):
        try:
            scenes = [
                scene if parsed(key)[0] == "start" else scene.replace({key: value + k * step}) for k in offsets
            ]  # starts enter by the state
        except InputError:
            continue
        terms = zip(scenes, offsets, weights, strict=True)
        return np.sum([w * _quantity(run, s, k * step * change, name) for s, k, w in terms], 0) / step
    raise InputError(f"{key}: values near {value:g} are refused, so {name} has no derivative by it")


def _quantity(run: RunRecord, scene: Scene, change: Array, name: str) -> Array:
    """A quantity (n,) at the states of a run moved by a change (n, 2 nv), in another scene."""
    q, v = np.split(np.concatenate([run.q, run.v], 1) + change, 2, axis=1)
    moved = fill_in(scene, bind_for_run(scene), None, Run.at_states(run.t - scene.start.time, q, v))
    return run.of(replace(moved, t=run.t))[name]
