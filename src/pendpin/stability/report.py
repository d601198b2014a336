"""What `pendpin stability` says of a scene: its rests, or its driven periodic motion, and whether they are stable."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.dynamics.derivatives import Variational
from pendpin.effects import Spring
from pendpin.errors import PendpinError
from pendpin.ground.arrays import Array
from pendpin.ground.report import Report, Result, Table
from pendpin.model.build import Model, build, start_state
from pendpin.motions.periodic import PeriodicOrbit, frequencies_of, hanging_or_upright, periodic_orbit, turned
from pendpin.scene import Scene, Start, chosen_scene
from pendpin.stability.linearize import LinearModel, linearize, place_of, remarks, rest_of

CORRECTIONS = 30  # of Newton's method, from there to a rest
RESIDUAL = 1e-10  # of the accelerations that a turn by 1 rad causes: what is less is a rest
SAME = 1e-6  # rad: two rests that differ by less are one
NEAREST = "this is the periodic motion nearest to the start; a scene may have others, near other starts"
NO_PERIOD = "the scene is not driven by one frequency: its multipliers need a period in s (--period)"
HEAD = ("rest", "", "fastest growth (1/s)", "slowest swing (rad/s)")


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
            return Report((*motion.parts, f"It begins at {place_of(self.model, q)}.", *notes), motion.data)
        cells = []
        for rest, row in zip(self.rests, self.rows(), strict=True):
            swing = "" if row["slowest"] is None else f"{row['slowest']:.6g}"
            verdict = "neutral" if rest.neutral else "stable" if row["stable"] else "unstable"
            cells.append((place_of(self.model, rest.q), verdict, f"{row['growth']:.6g}", swing))
        return Report((Table(HEAD, cells), *notes), {"rests": self.rows(), "notes": list(self.notes)})

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
    notes, rests = (*remarks(scene), *[NO_PERIOD] * bool(drives)), list[LinearModel]()
    equations = Variational(scene.model_copy(update={"start": Start(time=scene.start.time)}))
    beside = (_corrected(equations, q) for q in hanging_or_upright(scene))
    for q in (start_state(model, rest_of(scene))[0], *(rest for rest in beside if rest is not None)):
        if not any(isinstance(effect, Spring) for effect in scene.effects):  # which tell a turn from none
            q = np.where(model.slides, q, q - 2 * np.pi * np.ceil((q - np.pi - SAME) / (2 * np.pi)))
        rest = linearize(scene, at=Start(time=scene.start.time, positions=tuple(q.tolist())))
        if not any(np.abs(turned(rest.q - other.q)).max() < SAME for other in rests):
            rests.append(rest)
    return Stability(model, tuple(rests), None, notes)


def _corrected(equations: Variational, q: Array) -> Array | None:
    """The rest (nv,) next to q, by Newton's method on the accelerations; None if there is none."""
    still = np.zeros(len(q))
    for _ in range(CORRECTIONS):
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
    slopes = equations.jacobian(0.0, q, still)
    return q if np.abs(slopes.acceleration).max() <= RESIDUAL * max(1.0, float(np.abs(slopes.of_q).max())) else None
