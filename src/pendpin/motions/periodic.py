"""`periodic_orbit`: a motion that comes back to its start after a period, and what happens near it and near a rest.

Newton's method on the return map y -> phi_T(y) - y, whose derivative is the state transition over a period less the unit
matrix. Its eigenvalues, the multipliers, tell how changes of the start grow over a period.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pendpin.dynamics.acting import expand_as_written
from pendpin.dynamics.derivatives import Variational, refuse_poles
from pendpin.dynamics.pace import changes_with_time
from pendpin.dynamics.vibrations import Matrices, Vibrations, is_stable, matrices, spectrum, vibrations
from pendpin.effects import ContactEffect
from pendpin.errors import InputError, RunError, shown
from pendpin.ground.arguments import numbers, seconds
from pendpin.ground.arrays import EPS, Array
from pendpin.ground.report import Report, Result, Table
from pendpin.model.build import build, start_state
from pendpin.motions import special_starts
from pendpin.motions.trajectory import simulate
from pendpin.motions.variations import Variations, list_state_keys, refuse_contacts
from pendpin.scene import Chain, Scene, Start, chosen_scene
from pendpin.trajectory import RunRecord

TIGHT = 1e-13  # the tolerance of the integration: Newton's method and the multipliers are as accurate as that
OFF = 100 * TIGHT  # of a transition over a period
STEPS = 40  # of Newton's method
LONGEST = 1.0  # rad, or rad/s: the longest of them; a longer one leaves where the derivatives are good
TURNS = 1e-5  # by which a period may miss a whole number of those of a drive, as one with the digits printed does
CLOSED = 1e-9  # of the size of the state: the largest gap between the start and the end of a closed orbit
MOVES = 1e-3  # rad/s, rad/s²: what changes faster is no rest
# Of the largest singular value: along such a way orbits are a family, which a step crosses the shortest way.
FLAT = 1e-7
MOST_RADIANS = 1e7  # of what is fastest, over a period: two million steps, some seconds for one rod
NEAR = 0.2  # of the largest distance: a return so near is a first guess
SAMPLES = 2000  # of the run in which a first guess of the period is looked for


@dataclass(frozen=True, eq=False, repr=False)
class PeriodicOrbit(Result):
    """A periodic motion of a scene. `angles` turn by whole turns in a period where it goes round."""

    scene: Scene  # which starts on the orbit and lasts a period
    period: float  # s
    free: bool  # whether nothing sets the period: it was found with the orbit
    multipliers: Array  # (2 nv,), the largest first; complex
    errors: Array  # (2 nv,) of them
    miss: float  # by how much it misses its start, rad and rad/s, the largest
    transition: Array  # (2 nv, 2 nv), over the period

    @cached_property
    def orbit(self) -> RunRecord:
        """The motion over one period."""
        return simulate(self.scene, tolerance=1e-12)

    @property
    def stable(self) -> bool:
        """Whether no multiplier is outside the unit circle by more than its own error."""
        return bool((np.abs(self.multipliers) <= 1 + self.errors).all())

    def report(self) -> Report:
        values, rows = self.multipliers.tolist(), []
        for value, error in zip(values, self.errors, strict=True):
            rows.append((f"{value.real:.10g} {value.imag:+.10g}i", f"{abs(value):.10g}", f"{error:.1e}"))
        title = f"Periodic orbit of {self.period:.10g} s, {'stable' if self.stable else 'unstable'}"
        parts = [[value.real, value.imag] for value in values]
        data = {"period": self.period, "multipliers": parts, "errors": self.errors.tolist(), "stable": self.stable}
        return Report((title, Table(("multiplier", "its size", "error"), rows)), data)


def periodic_orbit(
    scene: Scene | str | Path, guess: Start | Sequence[float] | None = None, period: float | None = None
) -> PeriodicOrbit:
    """The periodic motion near a guess, by Newton's method on the return map.

    Where orbits are a family, as without damping, it is one near the guess. Another may be nearer: each step is
    the shortest, their sum need not be.

    Args:
        scene: a Scene, or the path of a TOML file.
        guess: a Start, or (q, v) as (2 nv,) in rad and rad/s; if absent the scene's own start, then, for a period that is
            given or that of the drive, the rods hanging or upright next to it.
        period: s, a whole multiple of that of each drive; tables over time and effects of your own are assumed to repeat
            after it. If absent that of the drive, and without a drive it is found from the first return of a run.

    Returns:
        The PeriodicOrbit: period in s, multipliers (2 nv,), stable, and `orbit`, the RunRecord over one period.

    Raises:
        InputError: for a period or guess that cannot be, for friction and stops, for effects without derivatives.
        RunError: if no orbit is found.
    """
    scene = chosen_scene(scene)
    model = build(scene.model)
    if guess is None or isinstance(guess, Start):
        state = np.concatenate(start_state(model, scene.start if guess is None else guess))
    else:
        state, size = np.empty(0), 2 * len(model.joints)
        with suppress(InputError):
            state = numbers("guess", guess, finite=True)
        if state.shape != (size,):
            raise InputError(f"guess: {shown(guess)} is neither a Start nor {size} finite numbers, q then v")
    first = period_of(scene) if period is None else seconds("period", period, lasting=True)
    free = first is None
    if first is not None:
        scene = scene.replace(duration=first)  # a file of rates or positions has to last so long
    else:  # the time at which a run first comes near its start again
        start = Start.at_state(scene.start.time, *np.split(state, 2))
        run = simulate(scene.replace(start=start), samples=SAMPLES)
        states = np.concatenate([np.where(model.slides, run.q, np.sin(run.q)), run.v], 1)
        away = np.linalg.norm(states - states[0], axis=1)
        inner = away[1:-1]
        near = (inner <= away[:-2]) & (inner < away[2:]) & (inner < NEAR * away.max())
        if not near.any() or away.max() == 0:
            within = f"within {scene.duration:g} s"
            raise InputError(f"period: the scene does not come near its start again {within}; give one in s")
        first = run.t[1 + int(np.argmax(near))] - run.t[0]
    try:
        return close_orbit(scene, state, float(first), free)
    except RunError:
        if free or guess is not None:  # what is free would end as a rest, which has any period
            raise
        for other in sorted(hanging_or_upright(scene), key=lambda q: float(np.abs(wrap(q - state[: len(q)])).max())):
            with suppress(RunError):
                return close_orbit(scene, np.append(other, 0 * other), float(first), free)
        raise


MOST_RODS = 4  # of a chain, each tried hanging and upright


def hanging_or_upright(scene: Scene) -> list[Array]:
    """The angles (nv,) of few rods, each hanging or upright."""
    if not isinstance(scene.model, Chain) or scene.model.count > MOST_RODS:
        return []
    model, parents, starts = build(scene.model), np.array(scene.model.parents), []
    for upright in product((0.0, np.pi), repeat=len(parents)):
        q = np.zeros(len(model.joints))
        q[[rod.first for rod in model.rods]] = upright - np.array([*upright, 0.0])[parents]  # [-1] is the world
        starts.append(q)
    return starts


def wrap(angle: Array) -> Array:
    """Angles in rad from -pi to pi, without whole turns."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def close_orbit(scene: Scene, y: Array, period: float, free: bool) -> PeriodicOrbit:
    """The orbit next to a state y (2 nv,) by Newton's method; a period that is `free` is found too.

    Raises InputError for a period in s that is not a whole multiple of that of each sinusoid, RunError if there is none.
    """
    for i, effect in enumerate(scene.effects):
        frequency = getattr(effect, "frequency", None) if effect.sinusoidal and not effect.idle else None
        count = period * frequency / (2 * np.pi) if frequency else 1.0
        if frequency and abs(count - max(1, round(count))) > TURNS:
            own = f"of effects[{i}] ({effect.kind}), {2 * np.pi / frequency:.12g} s"
            raise InputError(f"period: {period:.12g} s is not a whole multiple of that {own}")
    turns, best, patience = None, None, 3
    for _ in range(STEPS):
        now = integrate_period(scene, y, period)
        turns = now.turns if turns is None else turns
        gap = now.end - y - turns
        if period * np.abs(now.rate).max() <= CLOSED and np.abs(now.rate).max() > MOVES:
            raise InputError(f"period: after {period:g} s the state is the same but for rounding; give a longer one")
        size = float(np.abs(gap).max())
        if best is None or size < best[0]:
            best, patience = (size, y, period, now.transition), 3
        else:
            patience -= 1
        if size <= 4 * EPS or patience == 0:
            break
        matrix = np.column_stack([now.transition - np.eye(len(y)), *[now.rate] * free])
        step = np.linalg.lstsq(matrix, -gap, rcond=FLAT)[0]
        step *= min(1.0, LONGEST / max(float(np.abs(step).max()), 1e-300))
        y = y + step[: len(y)]
        period = max(period + float(step[len(y)]), period / 2) if free else period
    assert best is not None
    size, y, period, transition = best
    if not size <= CLOSED * max(1.0, float(np.abs(transition).max())):
        miss = f"after {period:.6g} s the state misses its start by {size:.2g}"
        raise RunError(f"no periodic motion found near the guess: {miss}; give another start or period")
    values, errors, _ = spectrum(transition, OFF * max(1.0, float(np.linalg.norm(transition, 2))))
    order = np.lexsort((np.imag(values), -np.real(values), -np.round(np.abs(values), 9)))
    at = scene.replace(start=Start.at_state(scene.start.time, *np.split(y, 2)), duration=period)
    return PeriodicOrbit(at, period, free, values[order], errors[order], size, transition)


class Return(NamedTuple):
    """What a motion is after a period."""

    end: Array  # (2 nv,)
    transition: Array  # (2 nv, 2 nv), d(end)/d(start)
    by_number: Array  # (2 nv,), the derivative of the end by a number of the scene; 0 without one
    rate: Array  # (2 nv,), the derivative of the end by the period
    turns: Array  # (2 nv,) rad, the whole turns of the angles


def integrate_period(scene: Scene, y: Array, period: float, key: str | None = None, image: float = 1.0) -> Return:
    """The motion from y (2 nv,) after a period in s, with its derivative by the number at a key path, if there is one."""
    # `image` -1: it is to end at the mirror image of its start, but for whole turns.
    refuse_contacts(scene)
    size = len(y)
    start = Start.at_state(scene.start.time, *np.split(y, 2))
    lasting = scene.model_copy(update={"duration": period, "start": start})
    variations = Variations(lasting, [*list_state_keys(size // 2), *([] if key is None else [key])])
    first = np.eye(len(variations.keys), size)
    # The steps of an explicit method, which what decays fastest limits, would take minutes.
    _, rates = variations.equations.rates(np.zeros(1), variations.start[None], first[None])
    fastest = float(np.abs(np.linalg.eigvals(np.nan_to_num(rates[0, :size]))).max())
    if fastest * period > MOST_RADIANS:
        stiff = f"something in it settles within {1 / fastest:.1e} s, and the period is {period:.3g} s"
        remedy = "give what is damped or held more mass, or leave the damper or spring out"
        raise RunError(f"the motion takes too many steps: {stiff}; {remedy}")
    states, changes = variations.integrate(y, first, np.array([0.0, period]), TIGHT)
    end, slides = states[-1], np.tile(variations.equations.model.slides, 2)
    rate, _ = variations.equations.rates(np.array([period]), end[None], changes[-1:])
    by_number = np.zeros(size) if key is None else changes[-1, -1]
    whole = 2 * np.pi * np.round((end - image * y) / (2 * np.pi))
    angle = (np.arange(size) < size // 2) & ~slides
    return Return(end, changes[-1, :size].T, by_number, rate[0], np.where(angle, whole, 0.0))


def frequencies_of(scene: Scene) -> set[float | None]:
    """The frequencies in rad/s at which a scene is driven; None stands for a change with time that has no frequency."""
    run = scene.start.time, scene.duration, TIGHT
    driven = (effect for effect in scene.effects if changes_with_time(effect, *run))
    return {getattr(effect, "frequency", None) if effect.sinusoidal else None for effect in driven}


def period_of(scene: Scene) -> float | None:
    """The period in s of the drive; None where nothing changes with time. InputError if it is not one."""
    frequencies = frequencies_of(scene)
    if len(frequencies) > 1 or None in frequencies:
        own = "an effect of your own is steady if its `pace` is STEADY"
        raise InputError(f"period: the scene is not driven by one frequency; give its period in s ({own})")
    frequency = next(iter(frequencies), None)
    return 2 * np.pi / frequency if frequency else None


# --- the rest of a scene and the small motions about it -------------------------------------------------------------


class SmallMotions(NamedTuple):
    """The small motions of a scene about its rest."""

    scene: Scene  # which starts at the rest
    q: Array  # (nv,) rad, the rest
    matrices: Matrices
    vibrations: Vibrations


def rest_of(scene: Scene) -> Start:
    """The stable rest of a scene near its start; friction and stops are left out. Raises InputError if there is none."""
    acts = expand_as_written(build(scene.model), scene.effects)
    free = tuple(effect for effect in acts if not isinstance(effect, ContactEffect))
    return special_starts.Start.at_rest(scene.model_copy(update={"effects": free}))


def small_motions(scene: Scene) -> SmallMotions:
    """The small motions about the rest near the scene's start. Raises InputError without one, MissingLibrary."""
    rest = rest_of(scene)
    still, (q, v) = scene.model_copy(update={"start": rest}), start_state(build(scene.model), rest)
    refuse_poles(build(scene.model), q)
    linear = matrices(still, q, v, np.zeros(len(q)))
    return SmallMotions(still, q, linear, vibrations(linear))


def stable(scene: Scene) -> bool:
    """Whether a driven scene's periodic motion near its start is stable; without a drive, the rest there or near it."""
    if period_of(scene) is not None:
        return periodic_orbit(scene).stable
    equations = Variational(scene)
    q, v = start_state(equations.model, scene.start)
    refuse_poles(equations.model, q)
    jacobian = equations.jacobian(0.0, q, v)
    if v.any() or not jacobian.balanced:
        return small_motions(scene).vibrations.stable
    A = np.block([[np.zeros_like(jacobian.of_q), np.eye(len(q))], [jacobian.of_q, jacobian.of_v]])
    return is_stable(*spectrum(A)[:2])
