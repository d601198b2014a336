"""`modes`: the natural frequencies, damping and shapes of the small motions of a scene about its rest."""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.dynamics.dynamics import Dynamics
from pendpin.dynamics.vibrations import Matrices
from pendpin.effects import FrameEffect, Idle
from pendpin.errors import InputError
from pendpin.graphics.style import COLORS, PALE, new_figure, styled, with_unit, write_figure
from pendpin.graphics.view import Animation
from pendpin.ground import arguments
from pendpin.ground.arrays import Array
from pendpin.ground.report import Report, Result, Table
from pendpin.integrators import Run
from pendpin.model import kinematics
from pendpin.model.build import Model, build
from pendpin.motions.periodic import small_motions
from pendpin.motions.trajectory import Trajectory
from pendpin.runs.run import fill_in
from pendpin.scene import Scene, chosen_scene
from pendpin.stability.linearize import positions_in_words, remarks

EQUAL = 1e-9  # of a frequency: two that are closer are one line of the table
NO_FREQUENCY = 1e-7  # of the largest: its square is rounding of the stiffness
MOST_ROWS = 20  # of a table that is printed
MOST_RODS = 2  # that a line names
SHOWN = 6  # shapes in a figure
SWING = 0.12  # of the extent of the model: how far a shape is drawn from the rest
MOST_TURN = 0.6  # rad, or m: the largest entry of a shape that is played
PERIODS, FRAMES = 4, 40  # of an animation: periods, and samples of each


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
        return self._shares(self.shapes)

    def _shares(self, shapes: Array) -> Array:
        """The share of each body in the kinetic energy, (n, bodies), of n modes with these shapes (n, nv)."""
        at_rest = np.broadcast_to(self.q, shapes.shape)
        parts = (kinematics.kinetic_energies(self._model, at_rest, v) for v in (np.real(shapes), np.imag(shapes)))
        energy = np.add(*parts)
        return energy / energy.sum(-1, keepdims=True)

    @cached_property
    def _model(self) -> Model:
        return build(self.scene.model)

    @cached_property
    def _groups(self) -> list[list[int]]:
        """The places of the modes, those of one frequency and damping together."""
        both, groups = np.stack([self.omega, self.damping_ratio], 1).tolist(), list[list[int]]()
        for i, mode in enumerate(both):
            pairs = zip(mode, both[groups[-1][0]] if groups else (np.nan, np.nan), strict=True)
            if all(x == first or abs(x - first) <= EQUAL * max(1.0, abs(x)) for x, first in pairs):
                groups[-1].append(i)
            else:
                groups.append([i])
        return groups

    def rows(self, most: int | None = None) -> list[list[str]]:
        """The rows of the table, at most so many: modes of one frequency and damping together."""
        rows = []
        for group in self._groups[:most]:
            share = self._shares(self.shapes[group]).mean(0)
            order = np.argsort(-share, kind="stable")  # the bodies until they have half of the energy
            count = min(MOST_RODS, 1 + int(np.searchsorted(np.cumsum(share[order]), 0.5)))
            where = ", ".join(f"{self._model.bodies[i].link} {share[i]:.0%}" for i in order[:count])
            first, last, omega = group[0] + 1, group[-1] + 1, float(self.omega[group[0]])
            which = f"{first}" if first == last else f"{first}{', ' if last == first + 1 else ' to '}{last}"
            numbers = [f"{omega:.7g}", f"{omega / (2 * np.pi):.6g}", f"{self.damping_ratio[group[0]]:.4g}"]
            rows.append([which, *numbers, f"{len(group)}", where])
        return rows

    def report(self, most: int | None = MOST_ROWS) -> Report:
        """The table, at most so many of its lines, and whether the rest is stable."""
        verdict = "is stable." if self.stable else "is unstable: small motions grow."
        if self.stable and self.neutral:
            some = f"{self.neutral} of {len(self.omega)} modes"
            verdict = f"is neutral: {some} have no frequency, nothing brings them back."
        where = positions_in_words(self._model, self.q)
        words = [f"The rest ({where}) {verdict}", *(f"note: {x}" for x in self.notes)]
        numbers = {"omega": self.omega.tolist(), "damping_ratio": self.damping_ratio.tolist()}
        data = numbers | {"stable": self.stable, "neutral": self.neutral}
        head, rows = ("mode", "rad/s", "Hz", "damping", "directions", "moves most"), self.rows(most)
        table = Table(head, rows, len(self._groups) - len(rows), "pendpin modes --all, or report(None) in Python")
        return Report((table, *words), data)

    @styled()
    def plot(self, *chosen: int, ax: Any = None) -> Any:
        """The shapes as a matplotlib Figure, the first six of them, or those at these places (from 1).

        Each is seen across the plane in which it moves most: the rest pale, both ends of the swing.
        """
        places = [self.place(k) for k in chosen] or [group[0] for group in self._groups[:SHOWN]]
        if arguments.axes("ax", ax) is not None:
            if len(chosen) > 1:
                raise InputError("ax: one axes takes one mode; give its number alone, as in plot(1, ax=ax)")
            self._draw_shape(ax, places[0])
            return ax.figure
        figure = new_figure(1.2 + 1.9 * len(places), 4.2)
        panels = figure.subplots(1, len(places), sharey=True, squeeze=False)[0]
        for panel, place in zip(panels, places, strict=True):
            self._draw_shape(panel, place)
        panels[0].set_ylabel("z (m)")
        return figure

    def _draw_shape(self, ax: Any, place: int) -> None:
        rest, moved, extent, size = self._ends_of_bodies(place)
        axis, moved = int(np.argmax(np.abs(moved).reshape(-1, 3).max(0)[:2])), moved * SWING * extent / (size or 1.0)
        for ends, color, width in ((rest - moved, COLORS[1], 1.0), (rest, PALE, 1.5), (rest + moved, COLORS[0], 1.8)):
            for body in ends:
                ax.plot(body[:, axis], body[:, 2], "-", color=color, linewidth=width, solid_capstyle="round")
        ax.set_title(f"mode {place + 1}\n{self.omega[place]:.4g} rad/s, {self.hertz[place]:.4g} Hz", fontsize=9)
        ax.set_xlabel(with_unit("xy"[axis], "m"))
        middle = float(np.mean(rest[..., axis]))
        half = max(2 * SWING * extent, float(np.abs(rest[..., axis] - middle).max()) + 1.5 * SWING * extent)
        ax.set(aspect="equal", xlim=(middle - half, middle + half))
        ax.locator_params(axis="x", nbins=3)

    def _ends_of_bodies(self, place: int) -> tuple[Array, Array, float, float]:
        """Both ends of every body at the rest, how they move to first order with a shape, (bodies, 2, 3) m; the sizes."""
        model, small = self._model, 1e-6
        poses = kinematics.poses(model, self.q + np.array([[0.0], [small], [-small]]) * np.real(self.shapes[place]))
        rest, ahead, behind = np.stack([poses[..., :3, 3], kinematics.tips(model, poses)], 2)
        moved = (ahead - behind) / (2 * small)
        extent, size = (float(np.linalg.norm(x, axis=-1).max()) for x in (rest, moved))
        return rest, moved, extent or 1.0, size

    def save_plot(self, path: str | Path) -> Path:
        """Write the figure of `plot` as .png, .pdf or .svg, whole or not at all. Raises InputError."""
        return write_figure(path, self.plot)

    def animate(self, k: int = 1) -> Any:
        """Mode k (from 1) as something that moves: in a notebook, or `.save(path)` as .html, .gif or .mp4.

        Some periods without damping, in slow motion or fast so that they last a few seconds; the support stays where it is.
        """
        place = self.place(k)
        model, omega, shape = self._model, self.omega[place] or 1.0, self.shapes[place]
        *_, extent, size = self._ends_of_bodies(place)  # some body moves by a share of the extent, no joint turns far
        amplitude = min(SWING * extent / size if size else np.inf, MOST_TURN / float(np.abs(shape).max()))
        phase = np.linspace(0.0, 2 * np.pi * PERIODS, PERIODS * FRAMES + 1)[:, None]
        moving = shape * amplitude * np.exp(1j * phase)
        q, v, t = self.q + moving.real, -omega * moving.imag, phase[:, 0] / omega
        changes = {
            "effects": tuple(Idle(kind=e.kind) if isinstance(e, FrameEffect) else e for e in self.scene.effects),
            "title": f"Mode {k}, {omega:.5g} rad/s",
            "start": self.scene.start.model_copy(update={"time": 0.0}),
        }
        scene = self.scene.sampled(len(t), duration=float(t[-1])).model_copy(update=changes)
        dynamics = Dynamics(model, scene.effects, form="angles")
        return Animation(Trajectory.of(fill_in(scene, dynamics, None, Run.at_states(t, q, v))))

    def place(self, k: int) -> int:
        """The place from 0 of mode k, from 1. Raises InputError for another number."""
        return arguments.whole_number("mode", k, most=len(self.omega)) - 1


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
