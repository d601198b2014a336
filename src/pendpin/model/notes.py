"""What the user should know of a scene or a run: probable mistakes, and what of a URDF's joints acts or is ignored."""

from collections.abc import Sequence

import numpy as np

from pendpin.effects import AsWritten, Drag, Effect, Motor, Push, Spring, Stop
from pendpin.errors import PendpinError, amount, choices, shown
from pendpin.model import kinematics
from pendpin.model.bodies import WRITTEN, WrittenJoint
from pendpin.model.build import Model, start_state
from pendpin.scene import Chain, Scene, scene_of
from pendpin.trajectory import RunRecord

TURN = 2 * np.pi
ANGLES = ("rest", "target", "lower", "upper")  # of springs, motors and stops
ONE_ROD = {"rod", "rod_1"}  # names of a single one
NEAR = 1e-12  # of a length: rounding
MOST_NAMED = 3  # in a note
FAR = 3.0  # of the length of the model: a slide that travels farther has left


def notes(scene: Scene, model: Model) -> tuple[str, ...]:
    """What the user should know about a scene, a line each. Raises InputError for a start that does not fit the model."""
    q, _ = start_state(model, scene.start)
    lines = [*ignored(model.written or (), scene.effects), *model.notes]
    for joint in np.flatnonzero((np.abs(q) > TURN) & ~model.slides)[:1]:
        turned = f"{q[joint]:.6g} rad is more than a whole turn"
        lines.append(f'start.positions.{model.joints[joint]}: {turned}; for degrees write unit = "degrees" in [start]')
    if not model.slides.any():
        lines += [
            f"effects[{i}].{name}: {getattr(effect, name):.6g} rad is more than a whole turn; effects have no degrees"
            for i, effect in enumerate(scene.effects)
            for name in ANGLES
            if isinstance(effect, Spring | Motor | Stop) and abs(getattr(effect, name, None) or 0.0) > TURN
        ]
    for i, effect in enumerate(scene.effects):
        if len(model.rods) == len(model.bodies) and isinstance(effect, Push) and effect.point is not None:
            named = [body for body in model.bodies if body.link == effect.link or {body.link, effect.link} == ONE_ROD]
            for body in named:
                length = float(np.linalg.norm(body.tip))
                if not 0 <= effect.point <= length * (1 + NEAR):
                    beyond = f"{effect.point:g} m is beyond the ends of {body.link}, 0 to {length:g} m"
                    lines.append(f"effects[{i}].point: {beyond}")
    positions, moved = scene.start.positions, homes(model.written or (), scene.effects)
    if isinstance(positions, dict) or not positions:
        begin = [f"{name} at {position:g}" for name, position in moved.items() if name not in positions]
        more = f", ... ({len(begin)} joints)" if len(begin) > MOST_NAMED else ""
        if begin:
            those = choices(begin[:MOST_NAMED])
            lines.append(f"limits leave out 0, so joints without a start begin at the nearer one: {those}{more}")
    if isinstance(scene.model, Chain):
        lines += [
            f"model.rods[{i}]: each of its {rod.copies} copies has the payload of {rod.payload:g} kg; "
            "for one load at the end give the last rod an entry of its own"
            for i, rod in enumerate(scene.model.rods)
            if rod.copies > 1 and rod.payload
        ]
    for drag in scene.effects:
        if isinstance(scene.model, Chain) and isinstance(drag, Drag):
            rods = [(f"rod_{i + 1}", rod) for i, rod in enumerate(scene.model.all_rods)]
            thin = [name for name, rod in rods if not rod.radius and rod.mass]  # a string has no mass
            if thin and drag.diameter is None and not drag.linear:
                those = choices(thin, MOST_NAMED)
                lines.append(f"drag does not act on {those}, of radius 0: give a radius, or the drag a diameter")
            if points := [name for name, rod in rods if rod.payload and not rod.payload_radius]:
                those = choices(points, MOST_NAMED)
                lines.append(f"the payload of {those} is a point without drag: payload_radius makes it a sphere")
    if not scene.effects:
        lines.append("effects: nothing acts in this scene; gravity must be listed too")
    return tuple(lines)


def ignored(joints: Sequence[WrittenJoint], effects: Sequence[Effect]) -> tuple[str, ...]:
    """One note on the damping, friction and limits that a file writes and the scene does not let act, if there are any."""
    listed = [effect for effect in effects if isinstance(effect, AsWritten)]
    parts = []
    for what, tag, _ in WRITTEN:
        names = [] if any(getattr(x, what) for x in listed) else [j.name for j in joints if j.says(what)]
        few = len(names) <= MOST_NAMED
        some = choices(map(shown, names)) if few else f"{len(names)} joints ({shown(names[0])}, ...)"
        parts += [f"{tag} of {some}"] if names else []
    if not parts:
        return ()
    return (f"{', '.join(parts)}: ignored; the effect as_written (--as-written, effects.AsWritten()) lets them act",)


def homes(joints: Sequence[WrittenJoint], effects: Sequence[Effect]) -> dict[str, float]:
    """Where joints begin that the start does not name, if limits that act as written leave out 0: at the nearer one."""
    if not any(isinstance(effect, AsWritten) and effect.limits for effect in effects):
        return {}
    nearest = {joint.name: min(max(joint.lower, 0.0), joint.upper) for joint in joints}
    return {name: position for name, position in nearest.items() if position}


def as_written(run: RunRecord) -> str:
    """What of the URDF's <dynamics> and <limit> acted in a run, in words; "" where nothing of them was listed."""
    joints, effects = _file_and_effects(run)
    listed = [effect for effect in effects if isinstance(effect, AsWritten)]
    acting = [(what, law) for what, _, law in WRITTEN if any(getattr(x, what) for x in listed)]
    counts = {law: sum(joint.says(what) for joint in joints) for what, law in acting}
    parts = [f"{law} of {amount(count, 'joint')}" for law, count in counts.items() if count]
    return choices(parts) or ("nothing: the file writes none" if listed else "")


def leaving(run: RunRecord) -> tuple[str, ...]:
    """The slides that nothing held, each with how far it went; none where the run's model cannot be built again."""
    try:
        model, (joints, effects) = kinematics.model_of(run), _file_and_effects(run)
    except PendpinError:
        return ()
    acting = any(isinstance(effect, AsWritten) and effect.limits for effect in effects)
    limited = set() if acting else {joint.name for joint in joints if joint.says("limits")}
    travelled = np.abs(run.q - run.q[:1]).max(0)
    left = np.flatnonzero(model.slides & (travelled > FAR * kinematics.scale(model)))
    remedy = "; with --as-written its limits act" if any(run.joints[joint] in limited for joint in left) else ""
    return tuple(f"{run.joints[joint]} slid {travelled[joint]:.3g} m, as no stop holds it{remedy}" for joint in left)


def _file_and_effects(run: RunRecord) -> tuple[tuple[WrittenJoint, ...], tuple[Effect, ...]]:
    """What the URDF of a run writes of its joints, and its effects; both empty where they cannot be built again."""
    try:
        scene = scene_of(run)
        return kinematics.model_of(run).written or (), scene.effects
    except PendpinError:
        return (), ()
