"""Rests about which small motions are taken, their places in words, and what is not linear there."""

from collections.abc import Iterator

import numpy as np

from pendpin.dynamics.timing import NEGLIGIBLE, changes_with_time
from pendpin.effects import AsWritten, ContactEffect, Drag, Effect
from pendpin.errors import InputError, choices, shown
from pendpin.ground.arrays import Array
from pendpin.model.build import Model
from pendpin.motions.small_motions import rest_of
from pendpin.scene import Scene, Start

AT_START = "start"
ZERO = 1e-9  # degrees or m: what is less is 0 in words
FEW_JOINTS = 4  # that say where a rest is


def chosen_start(scene: Scene, at: Start | str | None) -> Start:
    """The start that `at` names: the rest near the scene's start for None, the scene's own for "start", or one given.

    Raises InputError for another value, and where there is no rest.
    """
    if at is None:
        return rest_of(scene)
    if isinstance(at, Start):
        return at
    if at == AT_START:
        return scene.start
    raise InputError(f'at: {shown(at)} is not a Start, nor "{AT_START}", nor None for the rest near the start')


def place_of(model: Model, q: Array) -> str:
    """Positions (nv,) in rad or m in words: the first that are not 0."""
    places = zip(model.joints, np.where(model.slides, q, np.degrees(q)), model.slides, strict=True)
    parts = [f"{name} {x:.5g}{' m' if slides else '°'}" for name, x, slides in places if abs(x) > ZERO]
    return choices(parts[:FEW_JOINTS] + ["..."] * (len(parts) > FEW_JOINTS)) or "all 0"


def remarks(scene: Scene) -> tuple[str, ...]:
    """What the linear model of a scene leaves out or freezes, a sentence for each effect."""
    return tuple(
        f"effects[{i}]: {text}" for i, effect in enumerate(scene.effects) for text in _remark_on(effect, scene)
    )


def _remark_on(effect: Effect, scene: Scene) -> Iterator[str]:
    if isinstance(effect, ContactEffect):
        yield f"{effect.kind} is left out: it acts through events"
    if isinstance(effect, AsWritten) and not effect.smooth:
        yield "friction and limits as written are left out: they act through events"
    if isinstance(effect, Drag) and effect.quadratic and not any((*effect.wind, effect.gust)):
        yield "drag is quadratic: in still air its derivative at rest is 0, and it damps nothing that is small"
    if not effect.idle and changes_with_time(effect, scene.start.time, scene.duration, NEGLIGIBLE):
        yield f"{effect.kind} is taken as it is at the start, though it may change with time"
