"""Where a quantity of a run crosses a level: found among the samples, then integrated to the instant."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pendpin.errors import InputError, is_number, shown
from pendpin.ground.arrays import Array
from pendpin.motions.continuation import Continuation
from pendpin.motions.sign_changes import Changes, Quantity, resolved, sign_changes
from pendpin.trajectory import RunRecord, samples_of

JUMP = 1e-3  # of the offsets around it: what is still on the other side has not crossed but jumps
AFTER = 1e-13  # of the times: how far behind a jump the state is taken
CLOSE = 2.0  # units in the last place of an instant: two ends of an interval so close are one
MOST = 120  # times an interval is cut: a jump is found by halving


def crossings(run: RunRecord, name: str, level: float, direction: int) -> RunRecord:
    """As `Trajectory.crossings`."""
    if not is_number(level) or not np.isfinite(level):
        raise InputError(f"level: {shown(level)} is not a finite number")
    if direction not in {-1, 0, 1}:
        raise InputError(f"direction: {shown(direction)} is not 1 (upwards), -1 (downwards) or 0 (both)")
    run[name]  # an unknown name is refused before anything is integrated

    def offset(rows: RunRecord) -> Array:
        return rows[name] - level

    more = resolved(run)
    changes = sign_changes(more, offset, abs(level))
    chosen = np.isin(np.sign(changes.after), [direction] if direction else [-1, 1])
    instants = np.unique(_instants(more, offset, Changes(*(x[chosen] for x in changes))))
    if not len(instants):
        return replace(samples_of(run, slice(0, 0)), stats=replace(run.stats, steps=0, evaluations=0, events=0))
    return more.at(instants)


def first_crossings(more: Continuation, quantities: Sequence[Quantity]) -> Array:
    """The first instant in s at which each of k quantities of a run that is `resolved` changes its sign, (k,); else NaN."""
    first = np.full(len(quantities), np.nan)
    for i, quantity in enumerate(quantities):
        changes = Changes(*(x[:1] for x in sign_changes(more, quantity)))
        if len(changes.begin):
            first[i] = _instants(more, quantity, changes)[0]
    return first


def _instants(more: Continuation, quantity: Quantity, changes: Changes) -> Array:
    """The instants (k,) of sign changes; of a jump, the instant after it.

    All at once, by inverse quadratic interpolation or halving (T. R. Chandrupatla, Advances in Engineering Software 28
    (1997)).
    """
    a, b, fa, fb = (x.copy() for x in (changes.begin, changes.end, changes.before, changes.after))
    share, open_ = fa / (fa - fb), np.ones(len(a), bool)
    for _ in range(MOST):
        least = CLOSE * np.spacing(np.maximum(np.abs(a), np.abs(b))) / np.maximum(np.abs(b - a), 1e-300)
        open_ &= (least < 0.5) & (fa != 0) & (fb != 0)
        if not open_.any():
            break
        t = a + np.clip(share, least, 1 - least) * (b - a)
        f = fa.copy()
        f[open_] = _values(more, quantity, t[open_])
        same = np.sign(f) == np.sign(fa)
        c, fc = np.where(same, a, b), np.where(same, fa, fb)
        b, fb = np.where(open_ & ~same, a, b), np.where(open_ & ~same, fa, fb)
        a, fa = np.where(open_, t, a), np.where(open_, f, fa)
        share = _next_share((a, b, c), (fa, fb, fc))
    return _choose_ends(changes, (a, b), (fa, fb))


def _values(more: Continuation, quantity: Quantity, t: Array) -> Array:
    """The quantity at times (k,) in any order."""
    times, place = np.unique(t, return_inverse=True)
    return quantity(more.at(times))[place]


@np.errstate(divide="ignore", invalid="ignore")
def _next_share(t: tuple[Array, Array, Array], f: tuple[Array, Array, Array]) -> Array:
    """Where to cut between the first two of three times: at the zero of the quadratic through all, if it is monotone."""
    (a, b, c), (fa, fb, fc) = t, f
    xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
    smooth = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
    quadratic = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
    return np.where(smooth & np.isfinite(quadratic), quadratic, 0.5)


def _choose_ends(changes: Changes, t: tuple[Array, Array], f: tuple[Array, Array]) -> Array:
    """The better of the two ends of each interval; behind it where the quantity has jumped and not passed 0."""
    nearer = np.abs(f[0]) <= np.abs(f[1])
    instant, off = np.where(nearer, *t), np.where(nearer, *f)
    jumped = (off * changes.after < 0) & (
        np.abs(off) > JUMP * np.maximum(np.abs(changes.before), np.abs(changes.after))
    )
    behind = instant + AFTER * np.maximum(changes.end - changes.begin, np.abs(instant))
    return np.where(jumped, np.minimum(changes.end, behind), instant)
