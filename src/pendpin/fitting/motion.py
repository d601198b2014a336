"""Many motions at once, from start to start: fixed steps of order 5 between given times, dry friction by its events.

A state has 2n + 1 rows: positions and rates of the n joints that move, and the time.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pendpin.fitting.equations import STAGES, TIMES, WEIGHTS, Equations
from pendpin.ground.arrays import Array, Mask

_MOST_EVENTS = 12  # within a step, of one motion
_MOST_ROOT_STEPS = 40
_ROUNDING = 1e-12
_AT_EVENT = 1e-12  # rad/s, or of what holds: an event is met
_AT_REST = 1e-10  # rad/s, or of what holds: too near to an event to be before it
_LATE = 1e-13  # rad/s: how far past 0 a rate goes before it counts as turned round


@dataclass
class _Columns:
    """C motions: states (2n + 1, C), parameters with the way that joints slide (nz + f, C), joints held (f, C)."""

    y: Array
    pars: Array
    held: Mask

    def some(self, chosen: Array) -> "_Columns":
        """Those of the C motions that are chosen, (k,)."""
        return _Columns(self.y[:, chosen], self.pars[:, chosen], self.held[:, chosen])

    def put(self, chosen: Array, other: "_Columns") -> None:
        """Write others over some of them, (k,)."""
        self.y[:, chosen], self.pars[:, chosen], self.held[:, chosen] = other.y, other.pars, other.held


def motions(equations: Equations, times: Array, starts: Array, z: Array, largest_step: float) -> Array:
    """States (M, 2n, C) at times (M, C) in s, from starts (2n, C), with search coordinates (nz, C).

    Times of a motion never fall; equal times are no step. Steps are cut to at most `largest_step` in s.
    """
    f, C = len(equations.rubbing), starts.shape[1]
    way = np.sign(starts[equations.rates])
    now = _Columns(np.vstack([starts, times[:1]]), np.vstack([z, way]), np.zeros((f, C), bool))
    out = np.empty((len(times), *starts.shape))
    out[0] = starts
    with np.errstate(all="ignore"):
        if f:
            _set_out(equations, now, np.flatnonzero((way == 0).any(0)))
        for m, h in enumerate(np.diff(times, axis=0), start=1):
            cuts = max(1, int(np.ceil(h.max() / largest_step - 1e-9)))
            for _ in range(cuts):
                _advance(equations, now, h / cuts)
            now.y[-1] = times[m]
            out[m] = now.y[:-1]
    return out


def _advance(equations: Equations, now: _Columns, h: Array) -> None:
    """One step of all motions, by h (C,) in s, with the events of dry friction in it."""
    after, slopes = _step(equations, now, h)
    if not equations.rubbing:
        now.y = after
        return
    busy = np.flatnonzero(_happens(equations, now, after) | _may_dip(equations, now, after, slopes))
    part = now.some(busy)
    now.y = after
    if busy.size:
        _through_events(equations, part, h[busy])
        now.put(busy, part)


def _through_events(equations: Equations, now: _Columns, h: Array) -> None:
    """One step of C motions in which something happens, from event to event; h (C,) in s."""
    left, going = h.copy(), np.arange(len(h))
    for _ in range(_MOST_EVENTS):
        part, spent = now.some(going), left[going]
        after, slopes = _step(equations, part, spent)
        cut = _first_dip(equations, part, after, slopes, spent)
        if (early := np.flatnonzero(cut < 1)).size:
            spent[early] *= cut[early]
            after[:, early] = _step(equations, part.some(early), spent[early])[0]
        fired = np.flatnonzero(_happens(equations, part, after))
        meeting = part.some(fired)
        part.y = after
        if fired.size:
            spent[fired] = _advance_to_event(equations, meeting, after[:, fired], spent[fired])
            part.put(fired, meeting)
        now.put(going, part)
        left[going] -= spent
        going = np.flatnonzero(left > 0)
        if not going.size:
            return
    now.y[:, going] = _step(equations, now.some(going), left[going])[0]


# --- a step ---------------------------------------------------------------------------------------------------------


def _step(equations: Equations, now: _Columns, h: Array) -> tuple[Array, Array]:
    """States (2n + 1, C) after one step by h (C,), and the accelerations (2, n, C) at its two ends."""
    n, C = len(equations.joints), len(h)
    values = equations.step(now.y, np.vstack([now.pars, h]))
    after, slopes = values[: 2 * n + 1], values[2 * n + 1 :].reshape(2, n, C)
    if now.held.any():
        some = np.flatnonzero(now.held.any(0))
        after[:, some], slopes[:, :, some] = _step_held(equations, now.some(some), h[some])
    return after, slopes


def _step_held(equations: Equations, now: _Columns, h: Array) -> tuple[Array, Array]:
    """As `_step`, of motions in which a joint is held; h (C,) in s."""
    n = len(equations.joints)
    stages = np.ones((6, *now.y.shape))
    for i, row in enumerate(STAGES):
        y = now.y + h * np.tensordot(row, stages[:i], 1)
        y[-1] = now.y[-1] + TIMES[i] * h
        stages[i, :n] = y[n:-1]
        stages[i, n:-1] = _accelerations(equations, _Columns(y, now.pars, now.held))[0]
    return now.y + h * np.tensordot(WEIGHTS, stages, 1), stages[[0, 5], n:-1]


def _accelerations(equations: Equations, now: _Columns) -> tuple[Array, Array]:
    """Accelerations (n, C) and, for held joints, the part of what can hold them that this takes (f, C)."""
    a, part = equations.rate(now.y, now.pars), np.zeros(now.held.shape)
    if not now.held.any():
        return a, part
    rows = list(equations.rubbing)
    columns, most = equations.compliance(now.y, now.pars)
    both = now.held.T[:, :, None] & now.held.T[:, None, :]
    matrix = np.where(both, columns[rows].transpose(2, 0, 1), np.eye(len(rows)))  # (C, f, f)
    torque = np.linalg.solve(matrix, np.where(now.held, -a[rows], 0.0).T[..., None])[..., 0].T
    a = a + np.einsum("nfc,fc->nc", columns, torque)
    a[rows] = np.where(now.held, 0.0, a[rows])
    return a, torque / np.maximum(most, 1e-300)


# --- events ---------------------------------------------------------------------------------------------------------


def _margins(equations: Equations, before: _Columns, y: Array) -> Array:
    """What an event brings below 0, (f, C): rates of sliding joints, what is left to hold the held ones."""
    rates = y[equations.rates] * before.pars[equations.nz :] + _LATE
    if not before.held.any():
        return rates
    part = _accelerations(equations, _Columns(y, before.pars, before.held))[1]
    return np.where(before.held, 1 + 3 * _ROUNDING - np.abs(part), rates)


def _happens(equations: Equations, before: _Columns, after: Array) -> Mask:
    """Whether in a step (C,) a sliding joint turned round or a held one came loose."""
    return np.any(_margins(equations, before, after) < 0, axis=0)


def _may_dip(equations: Equations, before: _Columns, after: Array, slopes: Array) -> Mask:
    """Whether in a step (C,) a rate of sliding falls and then rises, being above 0 at both ends."""
    way, rows = before.pars[equations.nz :], list(equations.rubbing)
    return np.any((slopes[0, rows] * way < 0) & (slopes[1, rows] * way > 0), axis=0)


def _first_dip(equations: Equations, before: _Columns, after: Array, slopes: Array, h: Array) -> Array:
    """The part of a step (C,) after which a rate of sliding is least, where it dips below 0 in between; 1 elsewhere.

    From the cubic through the rates and their slopes at both ends of the step.
    """
    way, rows = before.pars[equations.nz :], list(equations.rubbing)
    r0, r1 = before.y[equations.rates] * way, after[equations.rates] * way
    d0, d1 = h * slopes[0, rows] * way, h * slopes[1, rows] * way
    c3, c2 = 2 * (r0 - r1) + d0 + d1, 3 * (r1 - r0) - 2 * d0 - d1
    where = -d0 / (c2 + np.sqrt(c2**2 - 3 * c3 * d0))
    least = r0 + where * (d0 + where * (c2 + where * c3))
    dips = (r0 > 0) & (r1 > 0) & (d0 < 0) & (d1 > 0) & (least < 0)
    return np.where(dips, where, 1.0).min(0)


def _advance_to_event(equations: Equations, part: _Columns, after: Array, h: Array) -> Array:
    """Move motions to the first event in their step and change what is held there; the time (C,) that it took.

    The root of the least margin, by the Illinois form of regula falsi on exact steps.
    """
    meets = _margins(equations, part, after) < 0

    def least(y: Array) -> Array:
        """The least margin (C,) of the joints that meet the event, in states (2n + 1, C)."""
        return np.where(meets, _margins(equations, part, y), np.inf).min(0)

    y, tau, f_high = after, h, least(after)
    low, f_low = _find_time_before(equations, part, h, least)
    high, side = h.copy(), np.zeros_like(h)
    for _ in range(_MOST_ROOT_STEPS):
        tau = (low * f_high - high * f_low) / (f_high - f_low)
        y = _step(equations, part, tau)[0]
        f = least(y)
        if not (np.abs(f) > _AT_EVENT).any():
            break
        past = f < 0
        f_low = np.where(past, np.where(side < 0, f_low / 2, f_low), f)
        f_high = np.where(past, f, np.where(side > 0, f_high / 2, f_high))
        low, high, side = np.where(past, low, tau), np.where(past, tau, high), np.where(past, -1.0, 1.0)
    _turn(equations, part, y, meets & (_margins(equations, part, y) <= 2 * _AT_EVENT))
    return tau


def _find_time_before(
    equations: Equations, part: _Columns, h: Array, least: Callable[[Array], Array]
) -> tuple[Array, Array]:
    """A time (C,) before each event and the margin there: later than 0 where a joint has only just set out."""
    low = np.zeros_like(h)
    margin = least(part.y)
    for halving in range(1, _MOST_ROOT_STEPS):
        near = margin < _AT_REST
        if not near.any():
            break
        low = np.where(near, h / 2**halving, low)
        margin = least(_step(equations, part, low)[0])
    return low, np.maximum(margin, _LATE)


def _turn(equations: Equations, part: _Columns, y: Array, first: Mask) -> None:
    """Put joints that turn round (f, C) exactly at rest in states y (2n + 1, C), and choose how they go on."""
    y[equations.rates] = np.where(first | part.held, 0.0, y[equations.rates])
    part.y = y
    part.pars[equations.nz :] = np.where(first, 0.0, part.pars[equations.nz :])
    part.held = part.held & ~first
    _set_out(equations, part, np.arange(y.shape[1]), first)


def _set_out(equations: Equations, now: _Columns, some: Array, which: Mask | None = None) -> None:
    """Joints at rest (f, C) of some motions: hold those that static friction can hold, let the others slide.

    One joint is changed at a time, by Murty's least-index rule, as in dynamics/contacts.py.
    """
    part, f, rows = now.some(some), len(equations.rubbing), list(equations.rubbing)
    way = part.pars[equations.nz :]
    resting = (way == 0) & ~part.held if which is None else which[:, some]
    part.held |= resting
    for _ in range(4 * f + 4):
        a, share = _accelerations(equations, part)
        backwards = a[rows] * way < -_ROUNDING * (1 + np.abs(a).max(0, initial=0.0))
        unfit = resting & np.where(part.held, np.abs(share) > 1 + _ROUNDING, backwards)
        first = unfit & (np.cumsum(unfit, 0) == 1)
        if not first.any():
            break
        way[:] = np.where(first, np.where(part.held, -np.sign(share), 0.0), way)
        part.held ^= first
    now.put(some, part)
