"""Notes on what is allowed in a scene and is probably a mistake."""

import numpy as np

from pendpin.model.build import Model, start_state
from pendpin.scene import Scene

TURN = 2 * np.pi


def notes(scene: Scene, model: Model) -> tuple[str, ...]:
    """What the user should know about a scene, a line each. Raises InputError for a start that does not fit the model."""
    q, _ = start_state(model, scene.start)
    far = np.flatnonzero((np.abs(q) > TURN) & ~model.slides)
    found = [
        f"start.positions.{model.joints[joint]}: {q[joint]:.6g} rad is more than a whole turn; "
        'for degrees write unit = "degrees" in [start]'
        for joint in far[:1]
    ]
    if not scene.effects:
        found.append("effects: nothing acts in this scene; gravity must be listed too")
    return (*model.notes, *found)
