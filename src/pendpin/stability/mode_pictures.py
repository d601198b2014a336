"""Modes as a figure of their shapes, and as something that moves."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from pendpin.dynamics.dynamics import Dynamics
from pendpin.effects import FrameEffect, Idle
from pendpin.errors import InputError
from pendpin.graphics.animation import Animation
from pendpin.graphics.figure import new_figure
from pendpin.graphics.panels import COLORS
from pendpin.ground import arguments
from pendpin.ground.arrays import Array
from pendpin.integrators import Run
from pendpin.model import kinematics
from pendpin.model.build import build
from pendpin.motions.trajectory import Trajectory
from pendpin.runs.samples import fill_in
from pendpin.scene import Scene

SHOWN = 6  # shapes in a figure
SWING = 0.12  # of the extent of the model: how far a shape is drawn from the rest
MOST_TURN = 0.6  # rad, or m: the largest entry of a shape that is drawn
PERIODS, FRAMES = 4, 40  # of an animation: periods, and samples of each
PALE = "#b8c2cf"


class Line(Protocol):
    """The modes of a line of the table."""

    @property
    def modes(self) -> tuple[int, ...]:
        """Their places, from 0."""
        ...


class Shapes(Protocol):
    """What a picture shows of `Modes`; each is described there."""

    @property
    def scene(self) -> Scene:
        """The scene, which starts at the rest."""
        ...

    @property
    def q(self) -> Array:
        """The rest, (nv,) rad."""
        ...

    @property
    def omega(self) -> Array:
        """The angular frequency of each mode, (k,) rad/s."""
        ...

    @property
    def hertz(self) -> Array:
        """The frequency of each mode, (k,) Hz."""
        ...

    @property
    def shapes(self) -> Array:
        """Displacements of the joints, (k, nv)."""
        ...

    def lines(self, most: int | None = None) -> Sequence[Line]:
        """The lines of the table, at most `most`: modes of one frequency and damping together."""
        ...


def draw_modes(modes: Shapes, chosen: list[int], ax: Any) -> Any:
    """A panel for each shape, seen across the plane in which it moves most: the rest pale, both ends of the swing."""
    places = chosen or [group.modes[0] for group in modes.lines(SHOWN)]
    if arguments.axes("ax", ax) is not None:
        if len(places) > 1 and chosen:
            raise InputError("ax: one axes takes one mode; give its number alone, as in plot(1, ax=ax)")
        _panel(ax, modes, places[0])
        return ax.figure
    figure = new_figure(figsize=(1.2 + 1.9 * len(places), 4.2), layout="constrained")
    panels = figure.subplots(1, len(places), sharey=True, squeeze=False)[0]
    for axes, place in zip(panels, places, strict=True):
        _panel(axes, modes, place)
    panels[0].set_ylabel("z (m)")
    return figure


def _panel(ax: Any, modes: Shapes, place: int) -> None:
    rest, moved = _displaced(modes, place)
    size = float(np.linalg.norm(moved, axis=-1).max()) or 1.0
    extent = float(np.linalg.norm(rest.reshape(-1, 3), axis=-1).max()) or 1.0
    axis, moved = int(np.argmax(np.abs(moved).reshape(-1, 3).max(0)[:2])), moved * SWING * extent / size
    for ends, color, width in ((rest - moved, COLORS[1], 1.0), (rest, PALE, 1.5), (rest + moved, COLORS[0], 1.8)):
        for body in ends:
            ax.plot(body[:, axis], body[:, 2], color=color, linewidth=width, solid_capstyle="round")
    ax.set_title(f"mode {place + 1}\n{modes.omega[place]:.4g} rad/s, {modes.hertz[place]:.4g} Hz", fontsize=9)
    ax.set_xlabel(f"{'xy'[axis]} (m)")
    middle = float(np.mean(rest[..., axis]))
    half = max(2 * SWING * extent, float(np.abs(rest[..., axis] - middle).max()) + 1.5 * SWING * extent)
    ax.set(aspect="equal", xlim=(middle - half, middle + half))
    ax.locator_params(axis="x", nbins=3)
    ax.tick_params(labelsize=7)


def _displaced(modes: Shapes, place: int) -> tuple[Array, Array]:
    """Both ends of every body at the rest, and how they move to first order with a shape, (bodies, 2, 3) m."""
    model, small = build(modes.scene.model), 1e-6
    poses = kinematics.poses(model, modes.q + np.array([[0.0], [small], [-small]]) * np.real(modes.shapes[place]))
    rest, ahead, behind = np.stack([poses[..., :3, 3], kinematics.tips(model, poses)], 2)
    return rest, (ahead - behind) / (2 * small)


def amplitude(modes: Shapes, place: int) -> float:
    """The factor with which a shape is played: some body moves by a share of the model's extent, no joint turns far."""
    rest, moved = _displaced(modes, place)
    size = float(np.linalg.norm(moved, axis=-1).max())
    extent = float(np.linalg.norm(rest.reshape(-1, 3), axis=-1).max()) or 1.0
    return min(SWING * extent / size if size else np.inf, MOST_TURN / float(np.abs(modes.shapes[place]).max()))


def animate_mode(modes: Shapes, place: int) -> Animation:
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
