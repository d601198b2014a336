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
from pendpin.effects import FrameEffect, Idle
from pendpin.engines import Engine
from pendpin.errors import InputError, shown
from pendpin.graphics.animation import Animation
from pendpin.graphics.style import COLORS, PALE, new_figure, styled, with_unit, write_figure
from pendpin.ground import arguments
from pendpin.ground.arrays import Array
from pendpin.ground.report import Report, Result, Table
from pendpin.integrators import Run
from pendpin.model import kinematics
from pendpin.model.build import Model, build
from pendpin.motions.small_motions import small_motions
from pendpin.motions.trajectory import Trajectory
from pendpin.runs.run import fill_in
from pendpin.scene import Scene, chosen_scene
from pendpin.stability.linearize import place_of, remarks

EQUAL = 1e-9  # of a frequency: two that are closer are one line of the table
NO_FREQUENCY = 1e-7  # of the largest: its square is rounding of the stiffness
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

    @property
    def neutral(self) -> int:
        """How many modes have no frequency, but for rounding: nothing brings them back, and a push makes them drift."""
        return int((self.omega <= NO_FREQUENCY * self.omega.max(initial=0.0)).sum())

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
        if self.stable and self.neutral:
            verdict = (
                f"is neutral: {self.neutral} of {len(self.omega)} modes have no frequency, nothing brings them back."
            )
        words = [f"The rest ({place_of(self._engine.model, self.q)}) {verdict}", *(f"note: {x}" for x in self.notes)]
        data = {"omega": self.omega.tolist(), "damping_ratio": self.damping_ratio.tolist(), "stable": self.stable}
        data["neutral"] = self.neutral
        return Report((Table(HEAD, [line.cells for line in self.lines(most)], max(left, 0)), *words), data)

    def plot(self, *chosen: int, ax: Any = None) -> Any:
        """The shapes as a matplotlib Figure, the first six of them, or those at these places (from 1)."""
        return draw_modes(self, [self.place(k) for k in chosen], ax)

    def save_plot(self, path: str | Path) -> Path:
        """Write the figure of `plot` as .png, .pdf or .svg, whole or not at all. Raises InputError."""
        return write_figure(path, self.plot)

    def animate(self, k: int = 1) -> Any:
        """Mode k (from 1) as something that moves: in a notebook, or `.save(path)` as .html, .gif or .mp4."""
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


# --- modes as a figure of their shapes ------------------------------------------------------------------------------

SHOWN = 6  # shapes in a figure
SWING = 0.12  # of the extent of the model: how far a shape is drawn from the rest
MOST_TURN = 0.6  # rad, or m: the largest entry of a shape that is drawn
PERIODS, FRAMES = 4, 40  # of an animation: periods, and samples of each


@styled()
def draw_modes(modes: Modes, chosen: list[int], ax: Any) -> Any:
    """A panel for each shape, seen across the plane in which it moves most: the rest pale, both ends of the swing."""
    places = chosen or [group.modes[0] for group in modes.lines(SHOWN)]
    if arguments.axes("ax", ax) is not None:
        if len(places) > 1 and chosen:
            raise InputError("ax: one axes takes one mode; give its number alone, as in plot(1, ax=ax)")
        _panel(ax, modes, places[0])
        return ax.figure
    figure = new_figure(1.2 + 1.9 * len(places), 4.2)
    panels = figure.subplots(1, len(places), sharey=True, squeeze=False)[0]
    for axes, place in zip(panels, places, strict=True):
        _panel(axes, modes, place)
    panels[0].set_ylabel("z (m)")
    return figure


def _panel(ax: Any, modes: Modes, place: int) -> None:
    rest, moved = _displaced(modes, place)
    size = float(np.linalg.norm(moved, axis=-1).max()) or 1.0
    extent = float(np.linalg.norm(rest.reshape(-1, 3), axis=-1).max()) or 1.0
    axis, moved = int(np.argmax(np.abs(moved).reshape(-1, 3).max(0)[:2])), moved * SWING * extent / size
    for ends, color, width in ((rest - moved, COLORS[1], 1.0), (rest, PALE, 1.5), (rest + moved, COLORS[0], 1.8)):
        for body in ends:
            ax.plot(body[:, axis], body[:, 2], color=color, linewidth=width, solid_capstyle="round")
    ax.set_title(f"mode {place + 1}\n{modes.omega[place]:.4g} rad/s, {modes.hertz[place]:.4g} Hz", fontsize=9)
    ax.set_xlabel(with_unit("xy"[axis], "m"))
    middle = float(np.mean(rest[..., axis]))
    half = max(2 * SWING * extent, float(np.abs(rest[..., axis] - middle).max()) + 1.5 * SWING * extent)
    ax.set(aspect="equal", xlim=(middle - half, middle + half))
    ax.locator_params(axis="x", nbins=3)


def _displaced(modes: Modes, place: int) -> tuple[Array, Array]:
    """Both ends of every body at the rest, and how they move to first order with a shape, (bodies, 2, 3) m."""
    model, small = build(modes.scene.model), 1e-6
    poses = kinematics.poses(model, modes.q + np.array([[0.0], [small], [-small]]) * np.real(modes.shapes[place]))
    rest, ahead, behind = np.stack([poses[..., :3, 3], kinematics.tips(model, poses)], 2)
    return rest, (ahead - behind) / (2 * small)


def amplitude(modes: Modes, place: int) -> float:
    """The factor with which a shape is played: some body moves by a share of the model's extent, no joint turns far."""
    rest, moved = _displaced(modes, place)
    size = float(np.linalg.norm(moved, axis=-1).max())
    extent = float(np.linalg.norm(rest.reshape(-1, 3), axis=-1).max()) or 1.0
    return min(SWING * extent / size if size else np.inf, MOST_TURN / float(np.abs(modes.shapes[place]).max()))


def animate_mode(modes: Modes, place: int) -> Animation:
    """Some periods of one mode, without damping, in slow motion or fast so that they last a few seconds."""
    model, omega = build(modes.scene.model), modes.omega[place] or 1.0
    phase = np.linspace(0.0, 2 * np.pi * PERIODS, PERIODS * FRAMES + 1)[:, None]
    moving = modes.shapes[place] * amplitude(modes, place) * np.exp(1j * phase)
    q, v, t = modes.q + moving.real, -omega * moving.imag, phase[:, 0] / omega
    scene = _still(modes.scene, place, omega, float(t[-1]), len(t))
    dynamics = Dynamics(model, scene.effects, form="angles")
    nothing = np.zeros((len(t), 0))
    run = Run(t, q, v, None, nothing, 0, 0, 0, 0.0, "", "")
    return Animation(Trajectory.of(fill_in(scene, dynamics, None, run)))


def _still(scene: Scene, place: int, omega: float, duration: float, samples: int) -> Scene:
    """The scene that is drawn: its support stays where it is, and the title names the mode."""
    effects = tuple(Idle(kind=e.kind) if isinstance(e, FrameEffect) else e for e in scene.effects)
    title = f"Mode {place + 1}, {omega:.5g} rad/s"
    solver = scene.solver.model_copy(update={"samples": samples, "times": None})
    start = scene.start.model_copy(update={"time": 0.0})
    changes = {"effects": effects, "title": title, "duration": duration, "solver": solver, "start": start}
    return scene.model_copy(update=changes)
