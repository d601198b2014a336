"""The motion near a motion: changes of the state with the start or with numbers of the scene, integrated beside it.

w' = df/dy w + df/dp along y' = f(t, y, p), by exact derivatives (pendpin.dynamics.derivatives) and the Runge-Kutta method
DOP853, with errors of every change measured by its own size.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from pendpin.dynamics.acting import expand_as_written
from pendpin.dynamics.contacts import Mode, Scales
from pendpin.dynamics.derivatives import Variational, refuse_poles
from pendpin.dynamics.dynamics import Dynamics
from pendpin.dynamics.falls import RATE, Guards, guards_of
from pendpin.dynamics.pace import paces_of
from pendpin.effects import ContactEffect, DryFriction
from pendpin.effects.pace import Pace
from pendpin.errors import InputError, RunError, choices, is_number, not_one_of, shown
from pendpin.ground.arguments import number_at, parsed
from pendpin.ground.arrays import EPS, Array
from pendpin.integrators import Run
from pendpin.integrators.adaptive import block_states, block_stepper
from pendpin.integrators.base import LEAST_RTOL
from pendpin.integrators.events import integrate_to_event
from pendpin.model.build import build, start_state
from pendpin.motions.continuation import at, margin_of_events, since_start, times_of_events
from pendpin.motions.search import extreme
from pendpin.runs.preparation import bind_for_run
from pendpin.runs.run import fill_in
from pendpin.scene import Scene, scene_of
from pendpin.trajectory import RunRecord, joined, samples_of

MOST_EVENTS = 100_000  # of one motion
AS_FAR = 1.05  # times the time between the last two events: the first steps towards the next
_SECANT = 1e-5  # of the time scale: half of a difference
_SURVEY = 1e-3  # the tolerance of a first integration, which finds how large the changes get
_LEAST = 1e-6  # of the largest change: smaller ones are as if they had this size
_ROUNDING = 10 * EPS  # of the state over the number: changes are not integrated closer, as by a mass that cancels


class Variations:
    """A scene whose motion is integrated with its K changes by numbers at key paths; times are since its start, in s.

    Joints stick and slip by dry friction. At such an event all changes jump (the saltation matrix: M. A. Aizerman,
    F. R. Gantmacher, Q. J. Mech. Appl. Math. 11 (1958), 498): a neighbour meets it earlier or later and moves on with other
    accelerations from there. The places `still` of the state (2 nv,) are 0. Use one in each thread. Raises InputError for
    stops, effects without derivatives, and keys that are not numbers of the scene; MissingLibrary without llvmlite.
    """

    def __init__(self, scene: Scene, keys: Sequence[str], still: tuple[int, ...] = ()) -> None:
        refuse_contacts(scene, DryFriction)
        self.scene, self.equations = scene, Variational(scene, keys, contacts=True, still=still)
        self.keys, self.nv = tuple(keys), self.equations.nv
        values = [1.0 if parsed(key)[0] == "start" else abs(number_at(scene, key)) for key in keys]
        self._numbers = np.array([value or np.inf for value in values])  # where one is 0, nothing cancels
        q, v = start_state(self.equations.model, scene.start)
        refuse_poles(self.equations.model, q)
        self._last = np.inf  # the number of evaluations that may not be passed
        self.start = np.concatenate([q, v])

    @cached_property
    def pace(self) -> Pace:
        """How fast what acts changes during the scene."""
        scene, (q, v) = self.scene, np.split(self.start, 2)
        dynamics = Dynamics(self.equations.model, scene.effects, start=scene.start.time)
        return paces_of(dynamics, scene.effects, q, v, scene.duration, None).pace

    def integrate(self, y: Array, w: Array, times: Array, tolerance: float) -> tuple[Array, Array]:
        """States (n, 2 nv) and changes (n, K, 2 nv) at times (n,) from y, w, these measured by their sizes. RunError."""
        states, survey = self.follow(y, w, times, _SURVEY, np.ones(w.size))
        sizes = np.abs(survey).max(0).reshape(len(w), 2, -1).max(-1)
        largest = sizes.max(1, initial=0.0)[:, None]
        sizes = np.maximum(np.repeat(sizes, self.nv, axis=1), np.where(largest > 0, _LEAST * largest, 1.0))
        of_state = np.repeat(np.abs(states).max(0).reshape(2, self.nv).max(1), self.nv)
        rounding = _ROUNDING / max(tolerance, LEAST_RTOL) * of_state / self._numbers[: len(w), None]
        return self.follow(y, w, times, tolerance, np.maximum(sizes, rounding).ravel())

    def follow(
        self, y: Array, w: Array, times: Array, tolerance: float, sizes: Array, most: float = np.inf
    ) -> tuple[Array, Array]:
        """States and changes at some times, with sizes (2 nv K,) of the changes; RunError after `most` evaluations."""
        block, contacts, nv = self.equations.block, self.equations.contacts, self.nv
        atol = tolerance * np.concatenate([np.ones(len(y)), sizes])
        state, rtol = np.concatenate([y, w.ravel()]), max(tolerance, LEAST_RTOL)
        mode = scales = None
        if contacts is not None:
            scales = contacts.scales(times, y[:nv], y[nv:], self.pace.varies)
            mode = contacts.choose(times[0], y[:nv], y[nv:], scales)
            state.reshape(-1, 2, nv)[:, 1, mode.held] = 0.0  # a joint that is held forgets a change of its rate
        rows = [state[None].copy()]
        self._last = block.calls + most
        block.on_progress(lambda t: bool(block.calls > self._last))
        try:
            for piece, due, longest in self.pace.pieces(times):
                if mode is None or scales is None:
                    part = block_states(block, rtol, atol, longest, state, piece)
                else:
                    part, mode = self._through_events(state, piece, mode, scales, rtol, atol, longest)
                if len(part) < len(piece) or not np.isfinite(part).all():
                    raise RunError(
                        f"the changes of the motion cannot be integrated beyond {piece[max(len(part), 1) - 1]:.6g} s: they "
                        "grow too large, take too many steps, or a thin rod is near phi = 90 degrees, where its angles are "
                        "singular"
                    )
                rows.append(part[1 : due + 1])
                state = part[-1]
        finally:
            self._last = np.inf  # evaluations between motions, as of accelerations, are not counted
        states = np.concatenate(rows)
        return states[:, : len(y)], states[:, len(y) :].reshape(len(times), *w.shape)

    def _through_events(
        self, state: Array, times: Array, mode: Mode, scales: Scales, rtol: float, atol: Array, longest: float
    ) -> tuple[Array, Mode]:
        """The states (n, size) at times (n,) from event to event, and the mode at the end."""
        contacts, nv = self.equations.contacts, self.nv
        assert contacts is not None
        t, end, parts, done = float(times[0]), float(times[-1]), [state[None]], 1
        first_step, ahead = 2 * rtol ** (1 / 8) / float((scales.rate / scales.position).max()), 0.0
        for _ in range(MOST_EVENTS):
            contacts.enter(mode)
            stepper = block_stepper(self.equations.block, rtol, atol, first_step, longest, self._refuse_more, ahead)
            guards = guards_of(contacts, state[:nv], mode, scales, rtol)
            segment = integrate_to_event(stepper, guards.values, guards.floor, t, state, end, times[done:])
            samples = segment.samples
            samples.reshape(len(samples), 1 + len(self.keys), 2, nv)[:, :, 1, mode.held] = 0.0
            ahead = AS_FAR * (segment.t - t)  # one swing lasts about as long as the one before it
            parts, done, t, state = [*parts, samples], done + len(samples), segment.t, segment.y.copy()
            if segment.failure or (segment.fired is None and t == end):
                break
            if segment.fired is not None:
                mode = self._cross(t, state, guards, scales, segment.fired)
        if done == len(times) - 1 and t == end:  # an event at the last time
            parts.append(state[None])
        return np.concatenate(parts), mode

    def _refuse_more(self) -> None:
        """RunError when as many evaluations were made as may be."""
        if self.equations.block.calls > self._last:
            raise RunError("the motion takes too many evaluations")

    def _cross(self, t: float, state: Array, guards: Guards, scales: Scales, fired: list[int]) -> Mode:
        """The mode after an event at t; the state (size,) is changed to that after it."""
        contacts, block, nv = self.equations.contacts, self.equations.block, self.nv
        assert contacts is not None
        y = state.reshape(-1, 2, nv)  # the state, then its K changes
        q, v = y[0]
        contacts.enter(guards.mode)
        rates, holding = (x[0] for x in block.evaluated(np.array([t]), state[None]))
        which = fired[0]
        joint, turned = int(guards.joint[which]), guards.turned[which]
        if guards.kind[which] == RATE:
            slope, changes = rates[nv + joint], y[1:, 1, joint].copy()
        else:  # a neighbour has another holding torque, and another limit
            h = _SECANT / float((scales.rate / scales.position).max())
            sides = np.array([state + h * rates, state - h * rates])
            late, early = block.evaluated(t + np.array([h, -h]), sides)[1][:, joint]
            slope = turned * (late - early) / (2 * h)
            changes = turned * holding.reshape(-1, nv)[1:, joint] + self.equations.static[:, joint]
        mode = contacts.choose(t, q, v, scales, guards.land(q, v, fired))
        contacts.enter(mode)
        after = block.evaluated(np.array([t]), state[None])[0][0]
        jump = (rates - after)[: 2 * nv].reshape(2, nv)
        if slope:
            y[1:] -= (changes / slope)[:, None, None] * jump
        y[1:, 1, mode.held] = 0.0
        return mode


def refuse_contacts(scene: Scene, *taken: type) -> None:
    """Raise InputError for effects that act at events, but for those `taken`."""
    for i, effect in enumerate(expand_as_written(build(scene.model), scene.effects)):
        if isinstance(effect, ContactEffect) and not isinstance(effect, taken):
            where = f"effects[{i}]" if i < len(scene.effects) else "as_written"
            raise InputError(f"{where}: {effect.kind} acts at events, where a motion has no derivative; leave it out")


def list_state_keys(nv: int) -> list[str]:
    """The key paths of the starts of nv joints: their angles, then their rates."""
    return [f"start.{part}[{i}]" for part in ("positions", "velocities") for i in range(nv)]


# --- how a run changes with its start and with the numbers of its scene ---------------------------------------------

TIGHT = 1e-10  # the tolerance beside a run with a fixed step, whose own error is larger
OF_POSITIONS = ("q", "tips", "swing", "potential")  # their rates do not jump where a joint sticks or slips
# what is a function of the state alone
OF_STATES = ("q", "v", "tips", "swing", "omega", "angular_momentum", "kinetic", "potential", "energy")
_STEP = 1e-3  # of differences, relative: their error is its fourth power, and rounding over it
_KINK = 4 * _STEP  # rad: a swing is an angle to a line, without sign; so near its ends differences cross them
_CENTRAL = ((-2, -1, 1, 2), (1 / 12, -2 / 3, 2 / 3, -1 / 12))
_FORWARD = ((0, 1, 2, 3, 4), (-25 / 12, 4.0, -3.0, 4 / 3, -1 / 4))  # where a number cannot be smaller, as a radius of 0

Statistic = Callable[[Array, Array], Array]
EXTREMES = {"max": 1.0, "min": -1.0}  # between the samples too: the sign for `extreme`
STATISTICS: dict[str, Statistic] = {  # derivatives (K,), from those (n, K) of a quantity at times (n,)
    **dict.fromkeys(EXTREMES, lambda t, dx: dx[-1]),  # the time of the extreme is the last
    "final": lambda t, dx: dx[-1],
    "mean": lambda t, dx: np.trapezoid(dx, t, axis=0) / (t[-1] - t[0]) if len(t) > 1 else dx[-1],
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
    y, times = np.concatenate([there.q[0], there.v[0]]), since_start(scene, np.array([t0, t1], float))
    return variations.integrate(y, np.eye(2 * nv), times, run.stats.tolerance or TIGHT)[1][-1].T


def sensitivity(run: RunRecord, keys: Sequence[str] | str, of: str | None) -> Array:
    """The derivatives of a run, or of one number of it, by numbers of its scene (Trajectory.sensitivity)."""
    if not isinstance(keys, Sequence):
        raise InputError(f"keys: {shown(keys)} is not a list of key paths of the scene")
    keys = [keys] if isinstance(keys, str) else list(keys)
    if not keys:
        raise InputError('keys: none is given; name a number of the scene, as "model.rods[0].length"')
    name, statistic = _quantity_and_statistic(run, of) if of is not None else ("", "")
    variations = Variations(scene_of(run), keys)
    if of is not None and variations.equations.contacts and run.places[name][0] not in OF_STATES:
        reason = f"of: {name} jumps where a joint sticks or slips; angles, rates, energies and tips have derivatives"
        raise InputError(reason)
    rows = run
    if statistic in EXTREMES:  # the samples before the extreme, and one at its time
        # The value changes as the quantity does at this time, held fixed (envelope theorem): there its rate is 0, or the
        # time is an end of the run. At an event at which the rate jumps, its time moves with the event.
        value, t = extreme(run, name, EXTREMES[statistic])
        if name == "swing" and min(value, np.pi - value) < _KINK:
            raise InputError(f"of: {of} is {value:.6g} rad, and swing has no derivative at 0 and at half a turn")
        beside = np.abs(times_of_events(run) - t) <= margin_of_events(run)
        if beside.any() and run.places[name][0] not in OF_POSITIONS:
            where = f"at {t:.6g} s, where a joint sticks or slips: it has no derivative there"
            raise InputError(f"of: {of} is reached {where}")
        rows = joined([samples_of(run, (run.t < t) | (np.arange(len(run.t)) == 0)), at(run, [t])])
    times = since_start(variations.scene, rows.t)
    start = np.concatenate([run.q[0], run.v[0]])
    _, changes = variations.integrate(start, variations.equations.starts, times, run.stats.tolerance or TIGHT)
    changes = np.moveaxis(changes, 1, 2)  # (n, 2 nv, K)
    if of is None:
        return changes
    if statistic in EXTREMES:
        rows, changes = samples_of(rows, slice(-1, None)), changes[-1:]
    shortest = float(np.min(variations.pace.shortest))
    series = np.stack([_change_of(rows, key, changes[..., k], name, shortest) for k, key in enumerate(keys)], -1)
    return STATISTICS[statistic](rows.t, series) if statistic else series


def _quantity_and_statistic(run: RunRecord, of: str) -> tuple[str, str]:
    """The quantity and the statistic, "" for none, that `of` names. Raises InputError."""
    if not isinstance(of, str):
        raise InputError(f"of: {shown(of)} is not the name of a quantity, such as R3_1.max")
    places = {name: place for name, place in run.places.items() if place[0] not in run.work}
    if of in places:
        return of, ""
    name, _, statistic = of.rpartition(".")
    if name and statistic not in STATISTICS:
        raise InputError(f"of: {of}: {not_one_of(statistic, STATISTICS)}")
    if (name or of) not in places:
        if (name or of).startswith(("work_", "effort_")):  # a sum over the motion; a part of what acts at a state
            reason = "derivatives of works and efforts are not computed; those of angles, forces, energies and tips are"
            raise InputError(f"of: {of}: {reason}")
        with_one = choices(f".{each}" for each in STATISTICS)
        raise InputError(f"of: {not_one_of(name or of, places)}; alone, or with {with_one}")
    return name, statistic


def _change_of(run: RunRecord, key: str, change: Array, name: str, shortest: float) -> Array:
    """The derivative (n,) of a quantity by one number, with that (n, 2 nv) of the state; of fourth order beside q and v."""
    (array, place), nv, scene = run.places[name], len(run.joints), scene_of(run)
    if array in ("q", "v"):
        return change[:, :nv][place] if array == "q" else change[:, nv:][place]
    path, states = parsed(key), np.concatenate([run.q, run.v], 1)
    starts = path[0] == "start" and path != ("start", "time")  # these enter by the state alone
    value = 0.0 if starts else number_at(scene, key)
    scale = shortest if path == ("start", "time") else abs(value)
    step = _STEP / max(float(np.abs(change).max(initial=0.0)), 1 / scale if 0 < scale < np.inf else 1.0)
    step = 2.0 ** np.floor(np.log2(step))  # so that its sum with a time of the calendar is exact
    for offsets, weights in (_CENTRAL, _FORWARD):
        try:
            scenes = [scene if starts else scene.replace({key: value + k * step}) for k in offsets]
        except InputError:
            continue
        total = []
        for moved, k, weight in zip(scenes, offsets, weights, strict=True):
            q, v = np.split(states + k * step * change, 2, axis=1)
            rows = fill_in(moved, bind_for_run(moved), None, Run.at_states(since_start(scene, run.t), q, v))
            total.append(weight * run.of(replace(rows, t=run.t))[name])
        return np.sum(total, 0) / step
    raise InputError(f"{key}: values near {value:g} are refused, so {name} has no derivative by it")
