"""`follow`: a periodic orbit continued in a number of the scene, round folds, by pseudo-arclength.

The orbits are a curve in the space of start, number, and, without a drive, period. A step along its tangent is corrected
across it by Newton's method (H. B. Keller, in: Applications of Bifurcation Theory, Academic Press, 1977, 359).
"""

from dataclasses import dataclass
from itertools import product
from typing import Any, Literal, NamedTuple

import numpy as np

from pendpin.errors import InputError, RunError, brief, shown
from pendpin.graphics.style import BESIDE, PALE, new_figure, styled, with_unit
from pendpin.ground.arguments import axes
from pendpin.ground.arrays import Array
from pendpin.ground.keypaths import number_at, parsed
from pendpin.motions.periodic import CLOSED, FLAT, PeriodicOrbit, close_orbit, frequencies_of, over_a_period
from pendpin.scene import Scene, unit_of_key

FIRST, LONGEST, SHORTEST = 0.02, 0.05, 1e-7  # steps along the curve, where the way to the end of the number is about 1
STEPS, CORRECTIONS = 2000, 12  # at most
HALVINGS = 40  # to locate a fold or a change of stability
AT_DOUBLING = 1e-2  # of a multiplier from ±1: it changes with the root of what is left between the last two halvings
MIRRORED = 1e-5  # rad, rad/s: how well an orbit is its own mirror image
SHARES, SIZES = (1e-3, 3e-3, 1e-2, 3e-2), (1.0, 0.3, 3.0, -1.0)  # of the way; of an orbit of twice the period beside
APART, NEARBY = 1e-3, 1.0  # rad, rad/s: halves of such an orbit differ by this, and it is so near


class Change(NamedTuple):
    """Where orbits become stable, or unstable: at the number's value a multiplier leaves the unit circle, or enters it.

    Its kind is "fold" (the branch turns back), "period doubling" (at -1), "torus" (a pair), "symmetry breaking" (at 1, of
    an orbit that half a period later is its own mirror image), or "branch point" (at 1 otherwise).
    """

    value: float
    kind: str
    orbit: PeriodicOrbit


@dataclass(frozen=True, eq=False, repr=False)
class Branch:
    """Orbits along a curve, from the one that was given on."""

    key: str
    orbits: tuple[PeriodicOrbit, ...]
    values: Array  # (n,) of the number, that of the orbit first
    folds: Array  # values at which the curve turns back
    bifurcations: tuple[Change, ...]  # where the orbits become stable, or unstable

    @property
    def changes(self) -> Array:
        """Values at which the orbits become stable, or unstable, (k,)."""
        return np.array([change.value for change in self.bifurcations])

    @property
    def stable(self) -> Array:
        """Which of the orbits are stable, (n,)."""
        return np.array([orbit.stable for orbit in self.orbits])

    @styled()
    def plot(self, ax: Any = None) -> Any:
        """Draw the largest multiplier against the number on a matplotlib Axes, a new one if absent; returns it."""
        ax = axes("ax", ax) or new_figure(7.0, 4.0).subplots()
        size, stable = np.array([np.abs(orbit.multipliers).max() for orbit in self.orbits]), self.stable
        ax.plot(self.values, size, color=PALE, linewidth=1)
        ax.plot(self.values[stable], size[stable], "o", label="stable")
        ax.plot(self.values[~stable], size[~stable], "x", label="unstable")
        ax.set(xlabel=with_unit(self.key, unit_of_key(self.key, self.orbits[0].scene)))
        ax.set_ylabel("size of the largest multiplier")
        ax.legend(**BESIDE)
        return ax

    def __repr__(self) -> str:
        return brief(self.text())

    def text(self) -> str:
        """Where the branch leads, its folds and its changes of stability."""
        lines = [f"{len(self.orbits)} periodic orbits, {self.key} from {self.values[0]:.6g} to {self.values[-1]:.6g}"]
        lines += [f"fold at {place:.10g}" for place in self.folds] or ["no fold"]
        changes = [f"change of stability at {change.value:.10g}: {change.kind}" for change in self.bifurcations]
        lines += changes or ["no change of stability"]
        return "\n".join(lines)


class _Curve(NamedTuple):
    """What the curve is that is followed: a point is (start, [period over the first], s), the number `first + s way`."""

    scene: Scene
    key: str
    first: float
    way: float
    period: float
    free: bool  # the period is found with the orbit; else it is set, by the drive or by who gave it
    tuned: bool  # the number is the frequency of the drive: the period keeps its number of turns of the drive
    turns: Array

    def number(self, u: Array) -> float:
        """The number of the scene at a point."""
        return self.first + self.way * float(u[-1])

    def scene_at(self, u: Array) -> Scene:
        """The scene with the number of a point."""
        return self.scene.replace({self.key: self.number(u)})

    def period_at(self, u: Array) -> float:
        """The period in s at a point."""
        if self.tuned:
            return self.period * self.first / self.number(u)
        return self.period * float(u[-2]) if self.free else self.period

    def gap(self, u: Array) -> tuple[Array, Array]:
        """By how much the motion misses its start, (2 nv,), and the derivative by u."""
        size, period = len(self.turns), self.period_at(u)
        over_period = over_a_period(self.scene_at(u), u[:size], period, self.key)
        by_number = over_period.by_number - (over_period.rate * period / self.number(u) if self.tuned else 0.0)
        columns = [over_period.transition - np.eye(size), by_number[:, None] * self.way]
        if self.free:
            columns.insert(1, over_period.rate[:, None] * self.period)
        return over_period.end - u[:size] - self.turns, np.hstack(columns)

    def orbit(self, u: Array) -> PeriodicOrbit:
        """The orbit at a point, with its multipliers."""
        size = len(self.turns)
        return close_orbit(self.scene_at(u), u[:size], self.period_at(u), free=self.free)


def follow(orbit: PeriodicOrbit, key: str, to: float, onto: Literal["doubled"] | None = None) -> Branch:
    """The orbits that continue one as a number of its scene goes to another value, round folds.

    A period that was given, or is that of the drive, stays; one that was found changes along the branch. Folds and changes
    of stability are located to about ten digits, each change with its kind and the orbit there. The branch ends at `to`, or
    where it comes back to the first value.

    Args:
        orbit: a PeriodicOrbit, from `periodic_orbit`.
        key: key path of the number, such as "effects[1].amplitude[2]".
        to: the value at the end, in the number's unit.
        onto: "doubled" from the orbit of a period doubling, branch.bifurcations[i].orbit: the orbits of twice its period
            that begin there are followed.

    Returns:
        The Branch: orbits, values (n,), stable (n,), folds and changes (values of the number), bifurcations (value, kind,
        orbit).

    Raises:
        InputError: for a key or value that cannot be.
        RunError: where the orbits end on the way.
    """
    if not isinstance(orbit, PeriodicOrbit):
        raise InputError(f"orbit: {shown(orbit)} is not a periodic orbit; take one from periodic_orbit")
    if isinstance(to, bool) or not isinstance(to, int | float) or not np.isfinite(to):
        raise InputError(f"to: {shown(to)} is not a finite number")
    first = number_at(orbit.scene, key)
    if to == first:
        raise InputError(f"to: {key} is {to:g} already")
    if onto not in (None, "doubled"):
        raise InputError(f"onto: {shown(onto)} is not 'doubled', the orbits of twice the period")
    if onto == "doubled":
        orbit = _doubled(orbit, key, first, float(to))
        first = number_at(orbit.scene, key)
    curve = _curve(orbit, key, first, float(to))
    start = np.concatenate([_state(orbit), [1.0] if curve.free else [], [0.0]])
    return _Walk(curve, start, orbit).branch()


def _doubled(orbit: PeriodicOrbit, key: str, first: float, to: float) -> PeriodicOrbit:
    """An orbit of twice the period next to one at a period doubling, a little on the way to another value.

    Along the way of the multiplier -1, whose size grows with the root of the distance. Raises InputError and RunError.
    """
    values, ways = np.linalg.eig(orbit.transition)
    nearest = int(np.argmin(np.abs(values + 1)))
    if abs(values[nearest] + 1) > AT_DOUBLING:
        raise InputError(
            f"onto: this orbit is not at a period doubling: its multiplier next to -1 is {values[nearest]:.6g}"
        )
    y, way = _state(orbit), np.real(ways[:, nearest])
    for share, size in product(SHARES, SIZES):
        number = first + share * (to - first)
        scene = orbit.scene.replace({key: number})
        period = 2 * orbit.period * (first / number if _is_tuned(orbit.scene, key) else 1.0)
        try:
            other = close_orbit(scene, y + size * np.sqrt(share) * way, period, free=orbit.free)
            half = over_a_period(other.scene, _state(other), other.period / 2)
        except RunError:
            continue
        apart = np.abs(half.end - half.turns - _state(other)).max()
        if apart > APART * np.sqrt(share) and np.abs(_state(other) - y).max() < NEARBY:
            return other
    raise RunError(
        f"onto: no orbit of twice the period was found next to this one, from {key} = {first:.10g} towards {to:g}"
    )


def _curve(orbit: PeriodicOrbit, key: str, first: float, to: float) -> _Curve:
    scene, y = orbit.scene, _state(orbit)
    tuned = _is_tuned(scene, key)
    if tuned and to * first <= 0:
        raise InputError(f"to: at {key} = 0 the drive has no period; give a number on the side of {first:g}")
    turns = over_a_period(scene, y, orbit.period).turns
    return _Curve(scene, key, first, to - first, orbit.period, orbit.free, tuned, turns)


def _is_tuned(scene: Scene, key: str) -> bool:
    """Whether the number at a key path is the frequency of the drive. Raises InputError if it is one of several."""
    driven = frequencies_of(scene)
    path = parsed(key)
    if not driven or path[0] != "effects" or path[-1] != "frequency":
        return False
    if len(driven) > 1:
        raise InputError(f"{key}: the scene has other frequencies too, and no period follows from one of them")
    return number_at(scene, key) in driven


class _Walk:
    """Steps along a curve."""

    def __init__(self, curve: _Curve, start: Array, orbit: PeriodicOrbit) -> None:
        self.curve, self.points, self.orbits = curve, [start], [orbit]
        ahead = np.zeros(len(start))
        ahead[-1] = 1.0
        self.tangents = [self.tangent(start, ahead)]
        self.folds, self.changes = list[float](), list[Change]()

    def branch(self) -> Branch:
        """All orbits up to the end of the curve."""
        step = FIRST
        for _ in range(STEPS):
            u = self.ahead(step)
            if u is None:
                step /= 2
                if step < SHORTEST:
                    place = self.curve.number(self.points[-1])
                    raise RunError(f"the branch cannot be followed beyond {self.curve.key} = {place:.10g}")
                continue
            if u[-1] >= 1.0:
                self.take(self.landed(u))
                break
            self.take(u)
            if u[-1] < 0:
                break
            step = min(1.4 * step, LONGEST)
        values = np.array([self.curve.number(u) for u in self.points])
        return Branch(self.curve.key, tuple(self.orbits), values, np.array(self.folds), tuple(self.changes))

    def tangent(self, u: Array, before: Array) -> Array:
        """The direction of the curve at u: that of all along which orbits stay orbits which is nearest to `before`."""
        _, sizes, rows = np.linalg.svd(self.curve.gap(u)[1])
        free = rows[np.count_nonzero(sizes > FLAT * sizes[0]) :]
        along = free.T @ (free @ before)
        return along / np.linalg.norm(along)

    def ahead(self, step: float) -> Array | None:
        """The point of the curve a step beyond the last; None where Newton's method does not find it."""
        guess = self.points[-1] + step * self.tangents[-1]
        return self.corrected(guess, self.tangents[-1])

    def corrected(self, u: Array, across: Array) -> Array | None:
        """The point of the curve at which u is, without going along `across`."""
        guess, before = u, np.inf
        for _ in range(CORRECTIONS):
            try:
                gap, matrix = self.curve.gap(u)
            except (InputError, RunError):
                return None
            size = float(np.abs(gap).max())
            if size <= 1e-11 or (size <= CLOSED and size > before / 2):
                return u
            if size > 10 * before:
                return None
            rows = np.vstack([matrix, across])
            u = u + np.linalg.lstsq(rows, -np.append(gap, across @ (u - guess)), rcond=FLAT)[0]
            before = size
        return None

    def landed(self, u: Array) -> Array:
        """The point of the curve at the end of the number, near u."""
        last = self.points[-1]
        guess = last + (u - last) * (1 - last[-1]) / (u[-1] - last[-1])
        guess[-1] = 1.0
        orbit = self.corrected(guess, np.eye(len(u))[-1])
        return u if orbit is None else orbit

    def take(self, u: Array) -> None:
        """Add a point, and what lies between it and the last: a fold, a change of stability."""
        tangent, orbit = self.tangent(u, self.tangents[-1]), self.curve.orbit(u)
        length = float(np.linalg.norm(u - self.points[-1]))
        fold = None
        if tangent[-1] * self.tangents[-1][-1] < 0:
            place = self.located(length, lambda x: self.tangent(x, self.tangents[-1])[-1] * tangent[-1] > 0)
            self.folds.append(fold := self.curve.number(place))
        if orbit.stable != self.orbits[-1].stable:
            place = self.located(length, lambda x: self.curve.orbit(x).stable == orbit.stable)
            self.changes.append(self.change_at(place, fold))
        self.points.append(u)
        self.tangents.append(tangent)
        self.orbits.append(orbit)

    def located(self, length: float, behind: Any) -> Array:
        """The point where `behind` becomes true on the way of a length from the last point."""
        low, high, place = 0.0, length, self.points[-1]
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            u = self.ahead(middle)
            if u is None:
                break
            place = u
            low, high = (low, middle) if behind(u) else (middle, high)
        return place

    def change_at(self, u: Array, fold: float | None) -> Change:
        """The change of stability at a point, next to which the branch may have a fold."""
        orbit, value = self.curve.orbit(u), self.curve.number(u)
        multipliers = orbit.multipliers
        if orbit.free:  # one is 1 along the orbit itself
            multipliers = np.delete(multipliers, np.argmin(np.abs(multipliers - 1)))
        crossing = multipliers[np.argmin(np.abs(np.abs(multipliers) - 1))]
        if abs(crossing + 1) < AT_DOUBLING:
            return Change(value, "period doubling", orbit)
        if abs(crossing - 1) > AT_DOUBLING:
            return Change(value, "torus", orbit)
        if fold is not None and abs(value - fold) < AT_DOUBLING * max(abs(fold), abs(self.curve.way)):
            return Change(value, "fold", orbit)
        y, half = _state(orbit), over_a_period(orbit.scene, _state(orbit), orbit.period / 2)
        size = len(y) // 2
        apart = half.end + y
        apart[:size] -= 2 * np.pi * np.round(apart[:size] / (2 * np.pi))
        return Change(value, "symmetry breaking" if np.abs(apart).max() < MIRRORED else "branch point", orbit)


def _state(orbit: PeriodicOrbit) -> Array:
    start = orbit.scene.start
    return np.array([*start.positions, *start.velocities], float)
