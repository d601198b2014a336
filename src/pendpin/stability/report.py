"""What `pendpin stability` says of a scene: its rests, or its driven periodic motion, and whether they are stable."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.derivatives import Variational
from pendpin.equations.base import THETA
from pendpin.errors import PendpinError, brief
from pendpin.scene import Chain, Scene, Start, chosen_scene
from pendpin.simulation.periodic import PeriodicOrbit, drive_of, periodic_orbit
from pendpin.stability.linearize import LinearModel, linearize
from pendpin.stability.rests import rest_of

MOST_RODS = 4  # of a chain, each tried hanging and upright
CORRECTIONS = 30  # of Newton's method, from there to a rest
RESIDUAL = 1e-10  # of the accelerations that a turn by 1 rad causes: what is less is a rest
SAME = 1e-6  # rad: two rests that differ by less are one


@dataclass(frozen=True, eq=False, repr=False)
class Stability:
    """The rests of a scene that was not driven, or the periodic motion of one that is."""

    rests: tuple[LinearModel, ...]
    orbit: PeriodicOrbit | None

    def __repr__(self) -> str:
        return brief(self.text())

    def text(self) -> str:
        """A line for each rest, or the multipliers of the motion."""
        if self.orbit is not None:
            return self.orbit.text()
        lines = [f"{'rest (degrees)':<44} {'':<9} {'fastest growth (1/s)':>21} {'slowest swing (rad/s)':>22}"]
        for row in self.rows():
            place = ", ".join(f"{name} {angle:.5g}" for name, angle in row["degrees"].items() if abs(angle) > 1e-9)
            verdict, growth, swing = "stable" if row["stable"] else "unstable", row["growth"], row["slowest"]
            swing = "" if swing is None else f"{swing:.6g}"
            lines.append(f"{place or 'all 0':<44} {verdict:<9} {growth:>21.6g} {swing:>22}")
        return "\n".join(lines)

    def rows(self) -> list[dict[str, Any]]:
        """Of each rest: its angles in degrees, whether it is stable, fastest growth in 1/s, slowest swing in rad/s."""
        found = []
        for rest in self.rests:
            names, values = rest.states[: len(rest.q)], rest.eigenvalues
            swings, growths = np.abs(np.imag(values)), np.real(values)
            found.append(
                {
                    "degrees": {name: float(np.degrees(x)) for name, x in zip(names, rest.q, strict=True)},
                    "stable": rest.stable,
                    "growth": 0.0 if rest.stable else float(growths.max()),
                    "slowest": float(swings[swings > 0].min()) if (swings > 0).any() else None,
                }
            )
        return found


def stability(scene: Scene | str | Path) -> Stability:
    """The rests of a scene, stable or not; with a drive of one frequency, the motion of its period near the start.

    Rests are looked for from the stable one near the start and, in a chain of up to four rods, from every rod hanging or
    upright. Raises InputError for effects without derivatives and where there is no rest, RunError where no periodic
    motion is found.
    """
    scene = chosen_scene(scene)
    if drive_of(scene) is not None:
        return Stability((), periodic_orbit(scene))
    found: list[LinearModel] = []
    for start in _candidates(scene):
        model = linearize(scene, at=start)
        if not any(np.abs(_apart(model.q, other.q)).max() < SAME for other in found):
            found.append(model)
    return Stability(tuple(found), None)


def _candidates(scene: Scene) -> Iterator[Start]:
    """Rests: the one near the start, then those next to every rod hanging or upright."""
    yield rest_of(scene)
    if not isinstance(scene.model, Chain) or len(scene.model.all_rods) > MOST_RODS:
        return
    equations = Variational(scene.model_copy(update={"start": Start(time=scene.start.time)}))
    for upright in product((0.0, np.pi), repeat=len(scene.model.all_rods)):
        q = np.zeros(equations.nv)
        q[THETA] = np.diff(upright, prepend=0.0)
        if (rest := _corrected(equations, q)) is not None:
            yield Start(time=scene.start.time, positions=tuple(rest.tolist()))


def _corrected(equations: Variational, q: Array) -> Array | None:
    """The rest (nv,) next to q, by Newton's method on the accelerations; None if there is none."""
    still = np.zeros(len(q))
    for _ in range(CORRECTIONS):
        try:
            found = equations.jacobian(0.0, q, still)
            step = np.linalg.lstsq(found.of_q, -found.acceleration, rcond=1e-12)[0]
        except (PendpinError, np.linalg.LinAlgError):
            return None
        if not np.isfinite(step).all() or np.abs(step).max() > 1.0:
            return None
        q = q + step
        if np.abs(step).max() < 1e-14 * max(1.0, float(np.abs(q).max())):
            break
    found = equations.jacobian(0.0, q, still)
    return q if np.abs(found.acceleration).max() <= RESIDUAL * max(1.0, float(np.abs(found.of_q).max())) else None


def _apart(q: Array, other: Array) -> Array:
    """The differences of angles, without whole turns."""
    return (q - other + np.pi) % (2 * np.pi) - np.pi
