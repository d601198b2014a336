"""`linearize`: the linear model x' = A x + B u of a scene near a state; `stability`: its rests, or its driven motion."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.dynamics.derivatives import Jacobian, Variational, refuse_poles
from pendpin.dynamics.dynamics import Dynamics
from pendpin.dynamics.pace import NEGLIGIBLE, changes_with_time
from pendpin.dynamics.vibrations import is_stable, spectrum
from pendpin.effects import AsWritten, ContactEffect, Drag, Spring
from pendpin.engines import AngleEngine
from pendpin.equations import recursion
from pendpin.errors import InputError, PendpinError, choices, shown
from pendpin.ground.arrays import Array
from pendpin.ground.libraries import optional
from pendpin.ground.report import Report, Result, Table
from pendpin.model.build import Model, build, start_state
from pendpin.motions.periodic import PeriodicOrbit, frequencies_of, hanging_or_upright, periodic_orbit, rest_of, wrap
from pendpin.scene import Scene, Start, chosen_scene

ZERO = 1e-9  # degrees or m: what is less is 0 in words
FEW_JOINTS = 4  # that say where a rest is
MOST_ROWS = 24  # eigenvalues that are printed


def positions_in_words(model: Model, q: Array) -> str:
    """Positions (nv,) in rad or m in words: the first that are not 0."""
    places = zip(model.joints, np.where(model.slides, q, np.degrees(q)), model.slides, strict=True)
    parts = (f"{name} {x:.5g}{' m' if slides else '°'}" for name, x, slides in places if abs(x) > ZERO)
    return choices(parts, FEW_JOINTS) or "all 0"


def remarks(scene: Scene) -> tuple[str, ...]:
    """What the linear model of a scene leaves out or freezes, a sentence for each effect."""
    rows = []
    for i, effect in enumerate(scene.effects):
        if isinstance(effect, ContactEffect):
            rows.append(f"effects[{i}]: {effect.kind} is left out: it acts through events")
        if isinstance(effect, AsWritten) and not effect.smooth:
            rows.append(f"effects[{i}]: friction and limits as written are left out: they act through events")
        if isinstance(effect, Drag) and effect.quadratic and not any((*effect.wind, effect.gust)):
            why = "in still air its derivative at rest is 0, and it damps nothing that is small"
            rows.append(f"effects[{i}]: drag is quadratic: {why}")
        if not effect.idle and changes_with_time(effect, scene.start.time, scene.duration, NEGLIGIBLE):
            rows.append(f"effects[{i}]: {effect.kind} may change with time; here it is as at the start")
    return tuple(rows)


@dataclass(frozen=True, eq=False, repr=False)
class LinearModel(Result):
    """x' = A x + B u for small changes x of (q, v), with the effects as they are at one time.

    The inputs u are a torque about each joint, N m (a force along a slide, N), and the acceleration of the support, m/s²
    in W. The wind is no input: drag keeps that of the time.
    """

    A: Array  # (2 nv, 2 nv)
    B: Array  # (2 nv, nv + 3)
    states: tuple[str, ...]  # (2 nv,) joints, then their rates
    inputs: tuple[str, ...]  # (nv + 3,)
    q: Array  # (nv,) rad, about which it is
    v: Array  # (nv,) rad/s
    residual: Array  # (nv,) rad/s², the accelerations there: 0 at an equilibrium
    notes: tuple[str, ...]  # what is left out, or taken as it is at one time

    @cached_property
    def _spectrum(self) -> tuple[Array, Array]:
        """The eigenvalues and their rounding errors, the one that grows fastest first."""
        values, errors, _ = spectrum(self.A)
        growth = np.where(np.abs(np.real(values)) > errors, np.real(values), 0)
        order = np.lexsort((-np.imag(values), np.abs(values), -growth))
        return values[order], errors[order]

    @property
    def eigenvalues(self) -> Array:
        """The eigenvalues of A, (2 nv,) in 1/s, the one that grows fastest first."""
        return self._spectrum[0]

    @property
    def errors(self) -> Array:
        """The rounding errors (2 nv,) of the eigenvalues, in 1/s."""
        return self._spectrum[1]

    @property
    def stable(self) -> bool:
        """Whether no eigenvalue is right of the imaginary axis by more than its rounding error."""
        return is_stable(*self._spectrum)

    @property
    def neutral(self) -> bool:
        """Whether it is stable, but an eigenvalue is 0 within its rounding error: nothing brings such a motion back."""
        return self.stable and bool((np.abs(self.eigenvalues) <= self.errors).any())

    @property
    def at_equilibrium(self) -> bool:
        """Whether nothing moves or accelerates there."""
        return not self.v.any() and Jacobian(self.residual, *np.hsplit(self.A[len(self.q) :], 2)).balanced

    def to_control(self) -> Any:
        """The same as a StateSpace of python-control, whose outputs are the states. Raises MissingLibrary without it."""
        control = optional("control", "a model for python-control", "control")
        n, m = self.B.shape
        names = {"states": list(self.states), "inputs": list(self.inputs), "outputs": list(self.states)}
        return control.ss(self.A, self.B, np.eye(n), np.zeros((n, m)), **names)

    def report(self) -> Report:
        """The eigenvalues, whether the model is stable, and what it leaves out."""
        about = choices((f"{name} = {x:.6g}" for name, x in zip(self.states, self.q, strict=False)), FEW_JOINTS)
        rows = []
        for x, error in zip(*self._spectrum, strict=True):
            if x.imag < 0:
                continue
            real, imag = (0.0 if abs(x.real) <= error else x.real), (0.0 if abs(x) <= error else x.imag)
            size, swing = abs(complex(real, imag)), f" ± {imag:.6g}i" if imag else ""
            rows.append((f"{real:.6g}{swing}", f"{size:.6g}", f"{-real / size + 0.0:.6g}" if size else ""))
        neutral = "neutral: an eigenvalue is 0, and nothing brings such a motion back"
        unstable = "unstable: an eigenvalue is right of the imaginary axis"
        words = [neutral if self.neutral else "stable" if self.stable else unstable]
        if not self.at_equilibrium:
            i = int(np.argmax(np.abs(self.residual)))
            words.append(f"not an equilibrium: {self.states[i]} accelerates by {self.residual[i]:.3g} rad/s² (m/s²)")
        title = f"Linear model of {len(self.states)} states and {len(self.inputs)} inputs about {about}"
        table = Table(("eigenvalue (1/s)", "omega (rad/s)", "damping ratio"), rows).first(MOST_ROWS)
        values = [[float(x.real), float(x.imag)] for x in self.eigenvalues]
        data = {"eigenvalues": values, "stable": self.stable, "neutral": self.neutral, "notes": list(self.notes)}
        return Report((title, table, *words, *(f"note: {note}" for note in self.notes)), data)


def linearize(scene: Scene | str | Path, at: Start | str | None = None) -> LinearModel:
    """The linear model x' = A x + B u of a scene near a state, by exact derivatives of every effect.

    Effects that change with time act as at the start's time. Friction and stops are left out. `notes` say so.

    Args:
        scene: a Scene, or the path of a TOML file.
        at: None for the rest near the scene's start (`Start.at_rest`), "start" for the scene's own start, or a Start.

    Returns:
        The LinearModel: A (2 nv, 2 nv), B (2 nv, nv + 3), states, inputs, eigenvalues in 1/s, stable, and `residual` (nv,)
            in rad/s², how far the state is from an equilibrium.

    Raises:
        InputError: where there is no rest, where the equations have no finite derivative, for effects without derivatives.
        MissingLibrary: without llvmlite.
    """
    scene = chosen_scene(scene)
    if at is None:
        start = rest_of(scene)
    elif isinstance(at, Start):
        start = at
    elif isinstance(at, str) and at == "start":
        start = scene.start
    else:
        raise InputError(f'at: {shown(at)} is not a Start, nor "start", nor None for the rest near the start')
    scene = scene.model_copy(update={"start": start})
    equations = Variational(scene)
    q, v = start_state(equations.model, start)
    refuse_poles(equations.model, q)
    slopes, nv, joints = equations.jacobian(0.0, q, v), len(q), equations.model.joints
    A = np.block([[np.zeros((nv, nv)), np.eye(nv)], [slopes.of_q, slopes.of_v]])
    # the accelerations (nv, nv + 3) for a unit torque about each joint, and a unit acceleration of the support
    engine = Dynamics(build(scene.model), (), form="angles").engine
    assert isinstance(engine, AngleEngine)
    tree, still = engine.model.tree, np.zeros((3, nv))
    # (3, nv), to hold still in a unit field: a support's acceleration is minus one
    needed = recursion.along_axes(tree, recursion.wrenches(tree, np.tile(q, (3, 1)), still, still, np.eye(3)))
    of_torque = engine.compliance(q, np.arange(nv))
    B = np.concatenate([np.zeros((nv, nv + 3)), np.concatenate([of_torque, of_torque @ needed.T], 1)])
    states = (*joints, *(f"{name}_rate" for name in joints))
    inputs = (*(f"torque_{name}" for name in joints), "support_x", "support_y", "support_z")
    return LinearModel(A, B, states, inputs, q, v, slopes.acceleration, remarks(scene))


# --- the rests of a scene, or its driven periodic motion: pendpin stability ------------------------------------------

SAME = 1e-6  # rad: two rests that differ by less are one
NEAREST = "this is the periodic motion nearest to the start; a scene may have others, near other starts"
OTHER_TURNS = "a weak spring has rests in further turns too; these are not listed"
NEAR_START = "this is the rest nearest to the start; others are looked for in chains of up to four rods"
NO_PERIOD = "the scene is not driven by one frequency: its multipliers need a period in s (--period)"


@dataclass(frozen=True, eq=False, repr=False)
class Stability(Result):
    """The rests of a scene that has no period, or the periodic motion of one that is driven."""

    model: Model
    rests: tuple[LinearModel, ...]
    orbit: PeriodicOrbit | None
    notes: tuple[str, ...]  # what is left out, or taken as it is at the start

    def report(self) -> Report:
        """A line for each rest, or the start and the multipliers of the motion; then the notes."""
        notes = [f"note: {note}" for note in self.notes]
        if self.orbit is not None:
            motion, (q, _) = self.orbit.report(), start_state(self.model, self.orbit.scene.start)
            return Report((*motion.parts, f"It begins at {positions_in_words(self.model, q)}.", *notes), motion.data)
        cells = []
        for rest, row in zip(self.rests, self.rows(), strict=True):
            swing = "" if row["slowest"] is None else f"{row['slowest']:.6g}"
            verdict = "neutral" if rest.neutral else "stable" if row["stable"] else "unstable"
            cells.append((positions_in_words(self.model, rest.q), verdict, f"{row['growth']:.6g}", swing))
        head = ("rest", "", "fastest growth (1/s)", "slowest swing (rad/s)")
        return Report((Table(head, cells), *notes), {"rests": self.rows(), "notes": list(self.notes)})

    def rows(self) -> list[dict[str, Any]]:
        """Of each rest: degrees of angles, m of slides, stable or neutral, fastest growth in 1/s, slowest swing in rad/s."""
        rows = []
        for rest in self.rests:
            places = list(zip(rest.states[: len(rest.q)], rest.q.tolist(), self.model.slides.tolist(), strict=True))
            swings = np.abs(np.imag(rest.eigenvalues))
            swings = swings[swings > rest.errors]  # what is less is rounding of a real eigenvalue
            row: dict[str, Any] = {"degrees": {name: float(np.degrees(x)) for name, x, slides in places if not slides}}
            row |= {"m": {name: float(x) for name, x, slides in places if slides}}
            row |= {"stable": rest.stable, "neutral": rest.neutral}
            growth = 0.0 if rest.stable else float(np.real(rest.eigenvalues).max())
            rows.append(row | {"growth": growth, "slowest": float(swings.min()) if len(swings) else None})
        return rows


def stability(scene: Scene | str | Path, period: float | None = None) -> Stability:
    """The rests of a scene, stable or not; with a drive of one frequency or a period in s, its periodic motion.

    Rests are looked for from the stable one near the start and, in a chain of up to four rods, from every rod hanging or
    upright; the periodic motion from the start, then from those. Raises InputError and RunError.
    """
    scene = chosen_scene(scene)
    model, drives = build(scene.model), frequencies_of(scene)
    if period is not None or (len(drives) == 1 and None not in drives):
        return Stability(model, (), periodic_orbit(scene, period=period), (NEAREST,))
    few, springs = hanging_or_upright(scene), any(isinstance(effect, Spring) for effect in scene.effects)
    ends = [OTHER_TURNS] * bool(few and springs) or [NEAR_START] * (not few)  # where the list ends
    notes = (*remarks(scene), *[NO_PERIOD] * bool(drives), *ends)
    rests = list[LinearModel]()
    equations = Variational(scene.model_copy(update={"start": Start(time=scene.start.time)}))
    beside = (_corrected(equations, q) for q in few)
    for q in (start_state(model, rest_of(scene))[0], *(rest for rest in beside if rest is not None)):
        if not springs:  # which tell a turn from none
            q = np.where(model.slides, q, q - 2 * np.pi * np.ceil((q - np.pi - SAME) / (2 * np.pi)))
        rest = linearize(scene, at=Start(time=scene.start.time, positions=tuple(q.tolist())))
        if not any(np.abs(wrap(rest.q - other.q)).max() < SAME for other in rests):
            rests.append(rest)
    return Stability(model, tuple(rests), None, notes)


def _corrected(equations: Variational, q: Array) -> Array | None:
    """The rest (nv,) next to q, by Newton's method on the accelerations; None if there is none."""
    still = np.zeros(len(q))
    for _ in range(30):
        try:
            slopes = equations.jacobian(0.0, q, still)
            step = np.linalg.lstsq(slopes.of_q, -slopes.acceleration, rcond=1e-12)[0]
        except (PendpinError, np.linalg.LinAlgError):
            return None
        if not np.isfinite(step).all() or np.abs(step).max() > 1.0:
            return None
        q = q + step
        if np.abs(step).max() < 1e-14 * max(1.0, float(np.abs(q).max())):
            break
    return q if equations.jacobian(0.0, q, still).balanced else None
