"""Notes on what is allowed in a scene and is probably a mistake."""

import numpy as np

from pendpin.effects import Drag
from pendpin.errors import choices
from pendpin.model.build import Model, start_state
from pendpin.model.urdf_joints import SHOWN, homes, ignored
from pendpin.scene import Chain, Scene

TURN = 2 * np.pi


def notes(scene: Scene, model: Model) -> tuple[str, ...]:
    """What the user should know about a scene, a line each. Raises InputError for a start that does not fit the model."""
    q, _ = start_state(model, scene.start)
    far = np.flatnonzero((np.abs(q) > TURN) & ~model.slides)
    lines = [
        f"start.positions.{model.joints[joint]}: {q[joint]:.6g} rad is more than a whole turn; "
        'for degrees write unit = "degrees" in [start]'
        for joint in far[:1]
    ]
    lines += _homes_note(scene, model)
    if isinstance(scene.model, Chain):
        lines += [
            f"model.rods[{i}]: each of its {rod.copies} copies has the payload of {rod.payload:g} kg; "
            "for one load at the end give the last rod an entry of its own"
            for i, rod in enumerate(scene.model.rods)
            if rod.copies > 1 and rod.payload
        ]
    if isinstance(scene.model, Chain) and any(isinstance(effect, Drag) for effect in scene.effects):
        rods = enumerate(scene.model.all_rods)
        if points := [f"rod_{i + 1}" for i, rod in rods if rod.payload and not rod.payload_radius]:
            those = choices(points[:SHOWN])
            lines.append(f"the payload of {those} is a point without drag: payload_radius makes it a sphere")
    if not scene.effects:
        lines.append("effects: nothing acts in this scene; gravity must be listed too")
    return (*ignored(model.written or (), scene.effects), *model.notes, *lines)


def _homes_note(scene: Scene, model: Model) -> list[str]:
    """A note on joints of which the start says nothing, and which begin at a limit."""
    positions = scene.start.positions
    if positions and not isinstance(positions, dict):
        return []
    moved = homes(model.written or (), scene.effects)
    begin = [f"{name} at {position:g}" for name, position in moved.items() if name not in positions]
    if not begin:
        return []
    more = f", ... ({len(begin)} joints)" if len(begin) > SHOWN else ""
    return [f"limits leave out 0, so joints without a start begin at the nearer one: {choices(begin[:SHOWN])}{more}"]
