"""`follow`: a periodic orbit continued in a number of the scene, round folds, by pseudo-arclength.

The orbits are a curve in the space of start, number, and, without a drive, period. A step along its tangent is corrected
across it by Newton's method (H. B. Keller, in: Applications of Bifurcation Theory, Academic Press, 1977, 359).
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal, NamedTuple

import numpy as np

from pendpin.errors import InputError, RunError, find, shown
from pendpin.graphics.style import BESIDE, PALE, new_figure, styled, with_unit
from pendpin.ground.arguments import axes, number, number_at, parsed
from pendpin.ground.arrays import Array
from pendpin.ground.report import Report, Result
from pendpin.motions.periodic import CLOSED, FLAT, PeriodicOrbit, close_orbit, frequencies_of, integrate_period
from pendpin.scene import Scene, unit_of_key

FIRST, LONGEST, SHORTEST = 0.02, 0.05, 1e-7  # steps along the curve, where the way to the end of the number is about 1
STEPS, CORRECTIONS = 2000, 12  # at most
HALVINGS = 40  # to locate a fold or a change of stability
AT_CHANGE = 1e-2  # of a multiplier from ±1: it changes with the root of what is left between the last two halvings
MIRRORED = 1e-5  # rad, rad/s: how well an orbit is its own mirror image
SHARES, SIZES = (1e-3, 3e-3, 1e-2, 3e-2), (1.0, 0.3, 3.0, -1.0)  # of the way to the end; of an orbit beside another
APART, NEARBY = 1e-3, 1.0  # rad, rad/s: an orbit on a new branch differs by this from one on the old, and it is so near
# Where a new branch begins: the multiplier there, the periods of the old orbits in one of the new, what it is called.
ONTO = {"doubled": (-1.0, 2, "a period doubling"), "asymmetric": (1.0, 1, "a symmetry breaking")}


class Change(NamedTuple):
    """Where orbits become stable, or unstable: at the number's value a multiplier leaves the unit circle, or enters it.

    Its kind is "fold" (the branch turns back), "period doubling" (at -1), "torus" (a pair), "symmetry breaking" (at 1, of
    an orbit that half a period later is its own mirror image), or "branch point" (at 1 otherwise).
    """

    value: float
    kind: str
    orbit: PeriodicOrbit


@dataclass(frozen=True, eq=False, repr=False)
class Branch(Result):
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
        ax.axhline(1.0, color=PALE, linewidth=1, linestyle=":")  # above it a motion is unstable
        ax.plot(self.values, size, color=PALE, linewidth=1)
        ax.plot(self.values[stable], size[stable], "o", label="stable")
        ax.plot(self.values[~stable], size[~stable], "x", label="unstable")
        ax.set(xlabel=with_unit(self.key, unit_of_key(self.key, self.orbits[0].scene)))
        ax.set_ylabel("size of the largest multiplier")
        ax.legend(**BESIDE)
        return ax

    def report(self) -> Report:
        """Where the branch leads, its folds and its changes of stability."""
        lines = [f"{len(self.orbits)} periodic orbits, {self.key} from {self.values[0]:.6g} to {self.values[-1]:.6g}"]
        lines += [f"fold at {place:.10g}" for place in self.folds] or ["no fold"]
        changes = [{"value": change.value, "kind": change.kind} for change in self.bifurcations]
        lines += [f"change of stability at {c['value']:.10g}: {c['kind']}" for c in changes]
        lines += [] if changes else ["no change of stability"]
        data = {"key": self.key, "values": self.values.tolist(), "stable": self.stable.tolist()}
        return Report(lines, data | {"folds": self.folds.tolist(), "changes": changes})


def follow(orbit: PeriodicOrbit, key: str, to: float, onto: Literal["doubled", "asymmetric"] | None = None) -> Branch:
    """The orbits that continue one as a number of its scene goes to another value, round folds.

    A period that was given, or is that of the drive, stays; one that was found changes along the branch. Folds and changes
    of stability are located to about ten digits, each change with its kind and the orbit there. The branch ends at `to`, or
    where it comes back to the first value.

    Args:
        orbit: a PeriodicOrbit, from `periodic_orbit`.
        key: key path of the number, such as "effects[1].amplitude[2]".
        to: the value at the end, in the number's unit.
        onto: which new branch to follow from branch.bifurcations[i].orbit: "doubled" from a period doubling, the orbits of
            twice its period; "asymmetric" from a symmetry breaking, orbits that are not their own mirror images.

    Returns:
        The Branch: orbits, values (n,), stable (n,), folds and changes (values of the number), bifurcations (value, kind,
        orbit).

    Raises:
        InputError: for a key or value that cannot be.
        RunError: where the orbits end on the way.
    """
    if not isinstance(orbit, PeriodicOrbit):
        raise InputError(f"orbit: {shown(orbit)} is not a periodic orbit; take one from periodic_orbit")
    to = number("to", to)
    if to == (first := number_at(orbit.scene, key)):
        raise InputError(f"to: {key} is {to:g} already")
    if onto is not None:
        find(tuple(ONTO), onto, "onto:")
        orbit = _orbit_on_new_branch(orbit, key, float(to), onto)
        first = number_at(orbit.scene, key)
    scene, y, tuned = orbit.scene, _state(orbit), _is_tuned(orbit.scene, key)
    if tuned and to * first <= 0:
        raise InputError(f"to: at {key} = 0 the drive has no period; give a number on the side of {first:g}")
    turns = integrate_period(scene, y, orbit.period).turns
    curve = _Curve(scene, key, first, float(to) - first, orbit.period, orbit.free, tuned, turns)
    points, orbits = [np.concatenate([y, [1.0] * orbit.free, [0.0]])], [orbit]
    tangent = curve.tangent(points[0], np.eye(len(points[0]))[-1])
    folds, changes, step = list[float](), list[Change](), FIRST
    for _ in range(STEPS):
        last = points[-1]
        u = curve.correct(last + step * tangent, tangent)
        if u is None:
            step /= 2
            if step < SHORTEST:
                raise RunError(f"the branch cannot be followed beyond {key} = {curve.number(last):.10g}")
            continue
        ends = not 0 <= u[-1] < 1
        if u[-1] >= 1:
            guess = last + (u - last) * (1 - last[-1]) / (u[-1] - last[-1])
            guess[-1] = 1.0
            landed = curve.correct(guess, np.eye(len(u))[-1])
            u = u if landed is None else landed
        way, here = curve.tangent(u, tangent), curve.orbit(u)

        # what lies between this point and the last: a fold, a change of stability
        length, fold = float(np.linalg.norm(u - last)), None
        if way[-1] * tangent[-1] < 0:
            place = curve.locate(last, tangent, length, lambda x: curve.tangent(x, tangent)[-1] * way[-1] > 0)  # noqa: B023
            folds.append(fold := curve.number(place))
        if here.stable != orbits[-1].stable:
            mirrored = max(_half_gap(each, -1.0) for each in (orbits[-1], here)) < MIRRORED
            within = curve.among_mirrored(last) if mirrored else curve
            place = within.locate(last, tangent, length, lambda x: within.orbit(x).stable == here.stable)  # noqa: B023
            value = curve.number(place)
            at_fold = fold is not None and abs(value - fold) < AT_CHANGE * max(abs(fold), abs(curve.way))
            changes.append(_change_at(value, within.orbit(place), at_fold))
        points.append(u)
        orbits.append(here)
        tangent = way
        if ends:
            break
        step = min(1.4 * step, LONGEST)
    return Branch(key, tuple(orbits), np.array([curve.number(u) for u in points]), np.array(folds), tuple(changes))


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
    image: float = 1.0  # -1 among orbits that end at their own mirror image: the period above is then half of theirs

    def among_mirrored(self, u: Array) -> "_Curve":
        """The curve on which orbits are their own mirror images, as that at u is."""
        # At a symmetry breaking others branch off: there Newton's matrix is singular, but not that of half a period.
        scene, y, period = self.at(u)
        turns = integrate_period(scene, y, period / 2, image=-1.0).turns
        return self._replace(period=self.period / 2, turns=turns, image=-1.0)

    def number(self, u: Array) -> float:
        """The number of the scene at a point."""
        return self.first + self.way * float(u[-1])

    def at(self, u: Array) -> tuple[Scene, Array, float]:
        """The scene at a point, the state (2 nv,) and the period in s."""
        number, period = self.number(u), self.period * (float(u[-2]) if self.free else 1.0)
        period = self.period * self.first / number if self.tuned else period
        return self.scene.replace({self.key: number}), u[: len(self.turns)], period

    def orbit(self, u: Array) -> PeriodicOrbit:
        """The orbit at a point, with its multipliers."""
        scene, y, period = self.at(u)
        return close_orbit(scene, y, period if self.image > 0 else 2 * period, free=self.free)

    def gap(self, u: Array) -> tuple[Array, Array]:
        """By how much the motion misses its start, (2 nv,), and the derivative by u."""
        scene, y, period = self.at(u)
        over_period = integrate_period(scene, y, period, self.key)
        by_number = over_period.by_number - (over_period.rate * period / self.number(u) if self.tuned else 0.0)
        columns = [over_period.transition - self.image * np.eye(len(y)), by_number[:, None] * self.way]
        if self.free:
            columns.insert(1, over_period.rate[:, None] * self.period)
        return over_period.end - self.image * y - self.turns, np.hstack(columns)

    def tangent(self, u: Array, before: Array) -> Array:
        """The direction of the curve at u: that of all along which orbits stay orbits which is nearest to `before`."""
        _, sizes, rows = np.linalg.svd(self.gap(u)[1])
        free = rows[np.count_nonzero(sizes > FLAT * sizes[0]) :]
        along = free.T @ (free @ before)
        return along / np.linalg.norm(along)

    def correct(self, guess: Array, across: Array) -> Array | None:
        """The point of the curve at which a guess is, without going along `across`; None where there is none."""
        u, before = guess, np.inf
        for _ in range(CORRECTIONS):
            try:
                gap, matrix = self.gap(u)
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

    def locate(self, last: Array, tangent: Array, length: float, is_behind: Callable[[Array], bool]) -> Array:
        """The point where `is_behind` becomes true, on the way of a length from the last point along its tangent."""
        low, high, place = 0.0, length, last
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            u = self.correct(last + middle * tangent, tangent)
            if u is None:
                break
            place = u
            low, high = (low, middle) if is_behind(u) else (middle, high)
        return place


def _orbit_on_new_branch(orbit: PeriodicOrbit, key: str, to: float, onto: str) -> PeriodicOrbit:
    """An orbit of the branch that begins at one, a little on the way to a value, along the way of the multiplier there."""
    multiplier, periods, kind = ONTO[onto]
    values, ways = np.linalg.eig(orbit.transition)
    nearest = int(np.argmin(np.abs(values - multiplier)))
    if abs(values[nearest] - multiplier) > AT_CHANGE or (periods == 1 and _half_gap(orbit, -1.0) > MIRRORED):
        beside = f"its multiplier next to {multiplier:g} is {values[nearest]:.6g}"
        raise InputError(f"onto: this orbit is not at {kind}: {beside}")
    first, y, way = number_at(orbit.scene, key), _state(orbit), np.real(ways[:, nearest])
    for share, size in product(SHARES, SIZES):
        number = first + share * (to - first)
        scene = orbit.scene.replace({key: number})
        period = periods * orbit.period * (first / number if _is_tuned(orbit.scene, key) else 1.0)
        try:
            other = close_orbit(scene, y + size * np.sqrt(share) * way, period, free=orbit.free)
            apart = _half_gap(other, -multiplier)
        except RunError:
            continue
        if apart > APART * np.sqrt(share) and np.abs(_state(other) - y).max() < NEARBY:
            return other
    way = f"from {key} = {first:.10g} towards {to:g}; on the other side there may be some"
    raise RunError(f"onto: no {onto} orbit was found next to this one, {way}")


def _change_at(value: float, orbit: PeriodicOrbit, at_fold: bool) -> Change:
    """The change of stability at an orbit, by the multiplier that is on the unit circle."""
    multipliers = orbit.multipliers
    if orbit.free:  # one is 1 along the orbit itself
        multipliers = np.delete(multipliers, np.argmin(np.abs(multipliers - 1)))
    crossing = multipliers[np.argmin(np.abs(np.abs(multipliers) - 1))]
    if abs(crossing.imag) > AT_CHANGE:
        return Change(value, "torus", orbit)
    if crossing.real < 0:
        return Change(value, "period doubling", orbit)
    if at_fold:
        return Change(value, "fold", orbit)
    return Change(value, "symmetry breaking" if _half_gap(orbit, -1.0) < MIRRORED else "branch point", orbit)


def _half_gap(orbit: PeriodicOrbit, image: float) -> float:
    """How far half a period later an orbit is from its start (image 1), or from its own mirror image (-1), but for turns."""
    y = _state(orbit)
    half = integrate_period(orbit.scene, y, orbit.period / 2, image=image)
    return float(np.abs(half.end - image * y - half.turns).max())


def _is_tuned(scene: Scene, key: str) -> bool:
    """Whether the number at a key path is the frequency of the drive. Raises InputError if it is one of several."""
    driven = frequencies_of(scene)
    path = parsed(key)
    if not driven or path[0] != "effects" or path[-1] != "frequency":
        return False
    if len(driven) > 1:
        raise InputError(f"{key}: the scene has other frequencies too, and no period follows from one of them")
    return number_at(scene, key) in driven


def _state(orbit: PeriodicOrbit) -> Array:
    start = orbit.scene.start
    return np.array([*start.positions, *start.velocities], float)
