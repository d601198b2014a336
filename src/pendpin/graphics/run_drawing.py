"""From a run to what is drawn: solids and their poses over time, the tip's path, joint forces, curves."""

import numpy as np

from pendpin.arrays import Array
from pendpin.effects import FrameEffect, Support
from pendpin.errors import InputError
from pendpin.graphics.drawing import Drawing, Plot, Shape
from pendpin.graphics.panels import BLACK, COLORS, joints_shown
from pendpin.graphics.shapes import rod_shapes, urdf_shapes
from pendpin.model import kinematics
from pendpin.model.build import Model
from pendpin.model.of_run import model_of
from pendpin.model.urdf_written import ignored
from pendpin.scene import Chain, Scene, UrdfModel, scene_of
from pendpin.trajectory import Trajectory
from pendpin.trajectory.columns import named_with_units


def drawing_of(trajectory: Trajectory) -> Drawing:
    """The drawing of a run, in the axes of W, over the ground where a support moves the pivot.

    Raises InputError where the run's model cannot be built again, as when its URDF is gone.
    """
    scene, known = _scene(trajectory)
    model = model_of(trajectory)
    extent = float(np.linalg.norm(trajectory.tips, axis=-1).max()) or 1.0
    position, velocity = (_of_pivot(scene, name, trajectory.t) for name in ("position", "velocity"))
    joints, shapes = _shapes(scene, model, extent)
    as_rods = joints is not None
    poses = kinematics.poses(model, trajectory.q) if as_rods else kinematics.joint_poses(model, trajectory.q)
    held = trajectory.wrench[:, joints if as_rods else slice(None), :3, None]
    forces = (poses[..., :3, :3] @ held)[..., 0]
    poses = np.pad(poses, ((0, 0), (0, 1), (0, 0), (0, 0)))
    poses[:, -1] = np.eye(4)
    poses[..., :3, 3] += position[:, None]
    return Drawing(
        title=trajectory.title + ("" if known else ", seen from the support"),
        t=trajectory.t,
        poses=poses,
        shapes=shapes,
        trail=trajectory.tips[:, -1] + position,
        extent=extent,
        velocity=_tip_velocity(model, trajectory) + velocity,
        forces=np.pad(forces, ((0, 0), (0, 1), (0, 0))),
        plots=_plots(trajectory),
        support=len(model.bodies) if as_rods else None,
        notes=ignored(model.written or (), scene.effects),  # limits among them, which a motion may be seen to pass
    )


def ends_of(run: Trajectory) -> Array:
    """Both ends of every body over the ground, (n, bodies, 2, 3) m. Raises InputError as `drawing_of`."""
    scene, _ = _scene(run)
    joints = kinematics.poses(model_of(run), run.q)[..., :3, 3]
    return np.stack([joints, run.tips], 2) + _of_pivot(scene, "position", run.t)[:, None, None]


def _scene(trajectory: Trajectory) -> tuple[Scene, bool]:
    """The scene of a run, or its model alone where the rest is gone, and whether the motion of the pivot is known."""
    try:
        return scene_of(trajectory), True
    except InputError:
        kinds = [effect.get("kind") for effect in trajectory.scene.get("effects") or ()]
        return Scene(model=trajectory.scene.get("model")), "support" not in kinds


def _of_pivot(scene: Scene, quantity: str, t: Array) -> Array:
    """The position or velocity of the pivot over the ground at times t (n,) in s: (n, 3) in m or m/s.

    Raises InputError for times that the csv of a support does not cover.
    """
    total = np.zeros((len(t), 3))
    for effect in scene.effects:
        if isinstance(effect, FrameEffect):
            of_time = getattr(effect, quantity)
            total += of_time(t) if isinstance(effect, Support) else [of_time(moment) for moment in t]
    if not np.isfinite(total).all():
        raise InputError("the times of the run are not those of its support")
    return total


def _shapes(scene: Scene, model: Model, extent: float) -> tuple[list[int] | None, tuple[Shape, ...]]:
    """The solids of a URDF that shows any, each on what a joint moves; else rods, and the joint of each of them."""
    if isinstance(scene.model, UrdfModel):
        shapes = tuple(urdf_shapes(scene.model.file, model))
        if any(shape.body < len(model.joints) for shape in shapes):
            return None, shapes
    payloads = (
        [rod.payload for rod in scene.model.all_rods] if isinstance(scene.model, Chain) else [0.0] * len(model.bodies)
    )
    return [body.joint for body in model.bodies], tuple(rod_shapes(model, extent, payloads))


def _tip_velocity(model: Model, trajectory: Trajectory) -> Array:
    """The velocity of the last tip, (n, 3) m/s, by a central difference along the rates."""
    step = (1e-6 / np.maximum(1.0, np.abs(trajectory.v).max(1, initial=0.0)))[:, None]
    ends = (kinematics.tips(model, kinematics.poses(model, trajectory.q + s * trajectory.v)) for s in (step, -step))
    after, before = (tips[:, -1] for tips in ends)
    return (after - before) / (2 * step)


def _plots(run: Trajectory) -> tuple[Plot, ...]:
    """Energies, the potential counted from its least so that both fill the plot, and the joints' positions."""
    potential, joints = run.potential - run.potential.min(), joints_shown(run)
    energies = np.stack([run.kinetic, potential, run.kinetic + potential], -1)
    names, unit = named_with_units(run, joints)
    left_out = f", {len(joints)} of {len(run.joints)} joints" * (len(joints) < len(run.joints))
    return (
        Plot(
            "Energy, potential above its least", "J", ("kinetic", "potential", "sum"), energies, (*COLORS[1::-1], BLACK)
        ),
        Plot(f"Position{left_out}", unit, names, run.q[:, joints], COLORS[: len(joints)]),
    )
