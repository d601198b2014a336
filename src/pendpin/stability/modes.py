"""`modes`: the natural frequencies, damping and shapes of the small motions of a scene about its rest."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.binding import bodies_of
from pendpin.dynamics.dynamics import Dynamics
from pendpin.dynamics.vibrations import Matrices
from pendpin.engines import Engine
from pendpin.errors import InputError, shown
from pendpin.ground.arrays import Array
from pendpin.ground.report import Report, Result, Table
from pendpin.model.build import Model, build
from pendpin.motions.small_motions import small_motions
from pendpin.scene import Scene, chosen_scene
from pendpin.stability.linearize import place_of, remarks

EQUAL = 1e-9  # of a frequency: two that are closer are one line of the table
MOST_ROWS = 20  # of a table that is printed
MOST_RODS = 2  # that a line names


class Line(NamedTuple):
    """A line of the table: a mode, or some with one frequency."""

    modes: tuple[int, ...]  # their places, from 0
    omega: float  # rad/s
    damping_ratio: float
    where: str  # which rods move most

    @property
    def cells(self) -> list[str]:
        """The line as text."""
        first, last = self.modes[0] + 1, self.modes[-1] + 1
        return [
            f"{first}" if first == last else f"{first}, {last}" if last == first + 1 else f"{first} to {last}",
            f"{self.omega:.7g}",
            f"{self.omega / (2 * np.pi):.6g}",
            f"{self.damping_ratio:.4g}",
            f"{len(self.modes)}",
            self.where,
        ]


HEAD = ["mode", "rad/s", "Hz", "damping", "directions", "moves most"]


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Result):
    """Small motions about a rest, one for each of k = nv degrees of freedom, by rising frequency.

    A shape holds the angles (slides) of the joints, in model order; its largest entry is 1. Shapes are complex where
    joints do not move in step: their phases then are those of the motion Re(shape exp(lambda t)).

    A damping ratio zeta and omega stand for the eigenvalues -zeta omega ± omega sqrt(zeta² - 1); a motion that leaves its
    rest at the rate r without swinging has omega = r and zeta = -1.
    """

    omega: Array  # (k,) rad/s
    damping_ratio: Array  # (k,)
    shapes: Array  # (k, nv)
    eigenvalues: Array  # (2 k,) 1/s
    stable: bool  # no eigenvalue is right of the imaginary axis by more than its rounding error
    joints: tuple[str, ...]
    q: Array  # (nv,) rad, the rest
    matrices: Matrices  # mass, damping and stiffness (nv, nv) there
    notes: tuple[str, ...]
    scene: Scene = field(repr=False)  # which starts at the rest

    @property
    def hertz(self) -> Array:
        """The frequencies, (k,) in Hz."""
        return self.omega / (2 * np.pi)

    @cached_property
    def participation(self) -> Array:
        """The share of each body in the kinetic energy of each mode, (k, bodies); rows add up to 1."""
        return np.array([self._shares(shape) for shape in self.shapes])

    @cached_property
    def _engine(self) -> Engine:
        model = build(self.scene.model)
        return Dynamics(model, (), "chain" if model.chain else "auto", "angles").engine

    def _shares(self, shape: Array) -> Array:
        """The share of each body in the kinetic energy (bodies,) of a mode with a shape (nv,)."""
        parts = [np.real(shape), np.imag(shape)] if np.iscomplexobj(shape) else [shape]
        energies = np.sum([_kinetic(self._engine, self.q, part) for part in parts], 0)
        return energies / energies.sum()

    def lines(self, most: int | None = None) -> list[Line]:
        """The lines of the table, at most so many: modes of one frequency and damping together."""
        lines: list[Line] = []
        for group in self._groups():
            if most is not None and len(lines) == most:
                break
            first = group[0]
            where = _strongest(self._engine.model, np.mean([self._shares(self.shapes[i]) for i in group], 0))
            lines.append(Line(tuple(group), float(self.omega[first]), float(self.damping_ratio[first]), where))
        return lines

    def _groups(self) -> Iterator[list[int]]:
        group: list[int] = []
        for i, (omega, ratio) in enumerate(zip(self.omega, self.damping_ratio, strict=True)):
            if group and not (_same(omega, self.omega[group[0]]) and _same(ratio, self.damping_ratio[group[0]])):
                yield group
                group = []
            group.append(i)
        yield group

    def report(self, most: int | None = MOST_ROWS) -> Report:
        """The table, at most so many of its lines, and whether the rest is stable."""
        left = sum(1 for _ in self._groups()) - most if most is not None else 0
        verdict = "is stable." if self.stable else "is unstable: small motions grow."
        words = [f"The rest ({place_of(self._engine.model, self.q)}) {verdict}", *(f"note: {x}" for x in self.notes)]
        data = {"omega": self.omega.tolist(), "damping_ratio": self.damping_ratio.tolist(), "stable": self.stable}
        return Report((Table(HEAD, [line.cells for line in self.lines(most)], max(left, 0)), *words), data)

    def plot(self, *chosen: int, ax: Any = None) -> Any:
        """The shapes as a matplotlib Figure, the first six of them, or those at these places (from 1)."""
        from pendpin.stability.mode_pictures import draw_modes

        return draw_modes(self, [self.place(k) for k in chosen], ax)

    def save_plot(self, path: str | Path) -> Path:
        """Write the figure of `plot` as .png, .pdf or .svg, whole or not at all. Raises InputError."""
        from pendpin.graphics.figure import write_figure

        return write_figure(path, self.plot)

    def animate(self, k: int = 1) -> Any:
        """Mode k (from 1) as something that moves: in a notebook, or `.save(path)` as .html, .gif or .mp4."""
        from pendpin.stability.mode_pictures import animate_mode

        return animate_mode(self, self.place(k))

    def place(self, k: int) -> int:
        """The place from 0 of mode k, from 1. Raises InputError for another number."""
        if isinstance(k, bool) or not isinstance(k, int | np.integer) or not 1 <= k <= len(self.omega):
            raise InputError(f"mode: {shown(k)} is not a whole number from 1 to {len(self.omega)}")
        return int(k) - 1


def modes(scene: Scene | str | Path) -> Modes:
    """The natural frequencies, damping and shapes of the small motions about the rest near a scene's start.

    M x'' + C x' + K x = 0 with exact derivatives M, C, K. Effects that change with time act as at the
    start's time. Friction and stops are left out. `notes` say so.

    Args:
        scene: a Scene, or the path of a TOML file.

    Returns:
        The Modes, by rising frequency: omega (nv,) in rad/s, damping_ratio (nv,), shapes (nv, nv), stable, and more.

    Raises:
        InputError: where there is no rest, for a joint that moves no inertia, for effects without derivatives, and for
            damped models of more than 500 degrees of freedom that are coupled.
        MissingLibrary: without llvmlite.
    """
    scene = chosen_scene(scene)
    motions = small_motions(scene)
    joints = build(scene.model).joints
    return Modes(*motions.vibrations, joints, motions.q, motions.matrices, remarks(scene), motions.scene)


def _same(one: float, other: float) -> bool:
    return one == other or bool(abs(one - other) <= EQUAL * max(1.0, abs(one)))


def _kinetic(engine: Engine, q: Array, v: Array) -> Array:
    """The kinetic energy of each body (bodies,) in J at q, v (nv,)."""
    bodies, motion = bodies_of(engine.model), engine.motion(engine.pack(q, v))
    spin = (motion.rotation.swapaxes(-1, -2) @ motion.spin[..., None])[..., 0]  # the spin in the link frames
    turning = (spin * (bodies.inertia @ spin[..., None])[..., 0]).sum(-1)
    return (bodies.mass * (motion.velocities(bodies.com) ** 2).sum(-1) + turning) / 2


def _strongest(model: Model, share: Array) -> str:
    """The bodies that take most part, by their names, until they have half of the energy."""
    order = np.argsort(-share, kind="stable")
    count = min(MOST_RODS, 1 + int(np.searchsorted(np.cumsum(share[order]), 0.5)))
    return ", ".join(f"{model.bodies[i].link} {share[i]:.0%}" for i in order[:count])
