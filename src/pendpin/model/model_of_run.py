"""What the model of a run says of it, where the model can still be built."""

import numpy as np

from pendpin.effects import AsWritten, Effect
from pendpin.errors import InputError, PendpinError, not_one_of, shown
from pendpin.ground.arrays import Array, ArrayLike, applied, cross, transposed
from pendpin.model import kinematics
from pendpin.model.build import Model, build
from pendpin.model.urdf_joints import WrittenJoint, written_text
from pendpin.scene import Scene, scene_of
from pendpin.trajectory import RunRecord
from pendpin.trajectory.columns import is_chain

FRAMES = ("world", "parent", "child")
FAR = 3.0  # of the length of the model: a slide that travels farther has left
SIDES = {"child": 1.0, "parent": -1.0}  # action, and reaction


def model_of(run: RunRecord) -> Model:
    """The model of a run. Raises InputError where it cannot be built again, as when its URDF is gone."""
    scene = run.source if isinstance(run.source, Scene) else Scene(model=run.scene.get("model"))
    model = build(scene.model)
    if model.joints != run.joints or len(model.bodies) != run.tips.shape[1]:
        raise InputError("the run does not fit its model: its file has changed since, or is another of the same name")
    return model


def express_wrench(run: RunRecord, joint: str, frame: str, point: ArrayLike | None, on: str) -> Array:
    """The wrench (n, 6) of a joint in a frame and at a point; as `Trajectory.express`."""
    for name, value, choices in (("frame", frame, FRAMES), ("on", on, SIDES)):
        if value not in choices:
            raise InputError(f"{name}: {not_one_of(value, choices)}")
    model = model_of(run)
    at = model.index(joint, "express")
    child = kinematics.joint_frame(model, run.q, at)
    base = {"child": at, "parent": kinematics.parent_joint(model, at), "world": -1}[frame]
    axes, origin = np.split(kinematics.joint_frame(model, run.q, base)[:, :3], [3], axis=2)
    turn = transposed(axes) @ child[:, :3, :3]
    force, moment = (applied(turn, part) for part in np.split(run.wrench[:, at], 2, axis=1))
    if point is not None:
        arm = applied(transposed(axes), child[:, :3, 3] - origin[..., 0]) - _point(point)
        moment = moment + cross(arm, force)
    return SIDES[on] * np.concatenate([force, moment], axis=1)


def _point(point: ArrayLike) -> Array:
    try:
        numbers = np.asarray(point, float)
    except (TypeError, ValueError):
        numbers = np.empty(0)
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise InputError(f"point: {shown(point)} is not three finite numbers, in m")
    return numbers


def swings_of(run: RunRecord, model: Model | None = None) -> Array:
    """The largest angle of any rod from straight down, (n,) rad; of a run's model if none is given. Raises InputError."""
    model = model or model_of(run)
    if model.chain is not None:
        return kinematics.swings_of_chain(run.q)
    return kinematics.swings(model, kinematics.poses(model, run.q))


def spins_and_momentum_of(run: RunRecord) -> tuple[Array, Array]:
    """The rods' angular velocities (n, rods, 3) and the angular momentum (n, 3) of a chain. Raises InputError."""
    if not is_chain(run):
        raise InputError("this model is not a chain of rods, so it has neither omega nor angular_momentum")
    return kinematics.spins_and_momentum(model_of(run), run.q, run.v)


def as_written(run: RunRecord) -> str:
    """What of the URDF's <dynamics> and <limit> acted in a run, in words; "" where nothing of them was listed."""
    joints, effects = _file_and_effects(run)
    return written_text(joints, effects)


def leaving(run: RunRecord) -> tuple[str, ...]:
    """The slides that nothing held, each with how far it went; none where the run's model cannot be built again."""
    try:
        model, (joints, effects) = model_of(run), _file_and_effects(run)
    except PendpinError:
        return ()
    limited = {joint.name for joint in joints if joint.lower > -np.inf or joint.upper < np.inf}
    if any(isinstance(effect, AsWritten) and effect.limits for effect in effects):
        limited = set()
    travelled = np.abs(run.q - run.q[:1]).max(0)
    left = np.flatnonzero(model.slides & (travelled > FAR * kinematics.scale(model)))
    remedy = "; with --as-written its limits act" if any(run.joints[joint] in limited for joint in left) else ""
    return tuple(f"{run.joints[joint]} slid {travelled[joint]:.3g} m, as no stop holds it{remedy}" for joint in left)


def _file_and_effects(run: RunRecord) -> tuple[tuple[WrittenJoint, ...], tuple[Effect, ...]]:
    """What the URDF of a run writes of its joints, and the effects; empty where there are none in this process."""
    try:
        scene = scene_of(run)
        return model_of(run).written or (), scene.effects
    except PendpinError:
        return (), ()
