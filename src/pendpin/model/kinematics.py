"""Where the bodies are and what energy they have, from a model and states of it."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pendpin.equations.base import split_by_rod
from pendpin.equations.chain import kinematics
from pendpin.equations.trees import motions_in_links, place_joints
from pendpin.errors import InputError, did_you_mean, not_one_of, shown
from pendpin.ground.arguments import numbers
from pendpin.ground.arrays import Array, ArrayLike, across, applied, cross
from pendpin.model.bodies import NEAR, pinocchio
from pendpin.model.build import FLIP, SIGNS, Model, build
from pendpin.scene import Scene
from pendpin.trajectory import RunRecord
from pendpin.trajectory.columns import is_chain


def poses(model: Model, q: Array) -> Array:
    """Poses of the bodies' links, (n, bodies, 4, 4) in W, from q (n, nv)."""
    if model.chain is not None:
        at = kinematics.positions(model.chain, split_by_rod(q))
        return _chain_poses(at.frames, at.tips)
    return joint_poses(model, q, [body.joint for body in model.bodies])


def joint_poses(model: Model, q: Array, joints: Any = slice(None)) -> Array:
    """Poses of what each joint, or some joints, move, (n, joints, 4, 4) in W, from q (n, nv)."""
    axes, origin = (np.stack(x, 1)[:, joints] for x in zip(*place_joints(model.tree, q), strict=True))
    out = np.zeros((*origin.shape[:-1], 4, 4))
    out[..., :3, :3], out[..., :3, 3], out[..., 3, 3] = axes, origin, 1.0
    return out


def _chain_poses(frames: Array, chain_tips: Array) -> Array:
    """Poses (n, rods, 4, 4) in W of a chain's links, from the rods' frames (n, rods, 3, 3) and tips (n, rods, 3) in I."""
    out = np.zeros((*chain_tips.shape[:2], 4, 4))
    out[..., 3, 3] = 1
    out[..., :3, :3] = frames * np.outer(SIGNS, SIGNS)
    out[:, 1:, :3, 3] = chain_tips[:, :-1] * SIGNS
    return out


def tips(model: Model, link_poses: Array) -> Array:
    """The far ends of the bodies, (n, bodies, 3) m in W, from the poses of their links."""
    return np.einsum("nrij,rj->nri", link_poses[..., :3, :], np.insert(model.body_arrays.tip, 3, 1.0, axis=1))


def swings_at(model: Model, q: Array) -> Array:
    """The largest angle of any body that tilts, joint to tip, from straight down, (n,) rad; NaN where there is none."""
    if model.chain is not None:
        return swings_of_chain(q)
    some = np.sin(np.outer(np.arange(4), np.arange(1, len(model.joints) + 1)))  # (4, nv) rad or m, the first all 0
    axes = poses(model, np.concatenate([some, q]))[..., :3, :3]
    x, y, z = np.moveaxis(np.einsum("nrij,rj->nri", axes, model.body_arrays.tip), -1, 0)
    angles = np.arctan2(np.hypot(x, y), -z)  # (4 + n, bodies) rad
    tilting = model.body_arrays.tip.any(1) & (np.ptp(angles[:4], 0) > NEAR)
    return angles[4:, tilting].max(1) if tilting.any() else np.full(len(q), np.nan)


def swings_of_chain(q: Array) -> Array:
    """The same of a chain from its angles q (n, nv): straight down is turned into the frame of one rod after another."""
    x, y, z, largest = 0.0, 0.0, -1.0, np.zeros(len(q))
    for theta, phi in q.T.reshape(-1, 2, len(q)):
        s, c = np.sin(theta), np.cos(theta)
        y, z = c * y - s * z, s * y + c * z
        if phi.any():  # not in the plane of theta
            s, c = np.sin(phi), np.cos(phi)
            x, z = c * x + s * z, c * z - s * x
        np.maximum(largest, np.arctan2(np.hypot(x, y), -z), out=largest)
    return largest


def tilts_of_chain(q: Array, v: Array) -> tuple[Array, Array]:
    """sin²(angle / 2) of each rod's angle from straight down, and its rate per s, (..., rods), at q, v (..., nv)."""
    x, y, z = np.zeros(q.shape[:-1]), np.zeros(q.shape[:-1]), np.full(q.shape[:-1], -1.0)
    dx, dy, dz = np.zeros((3, *q.shape[:-1]))
    squares, rates = np.empty((2, *q.shape[:-1], q.shape[-1] // 2))
    for k in range(q.shape[-1] // 2):
        s, c, turn = np.sin(q[..., 2 * k]), np.cos(q[..., 2 * k]), v[..., 2 * k]
        y, z = c * y - s * z, s * y + c * z
        dy, dz = c * dy - s * dz - turn * z, s * dy + c * dz + turn * y
        s, c, turn = np.sin(q[..., 2 * k + 1]), np.cos(q[..., 2 * k + 1]), v[..., 2 * k + 1]
        x, z = c * x + s * z, c * z - s * x
        dx, dz = c * dx + s * dz + turn * z, c * dz - s * dx - turn * x
        squares[..., k] = np.where(z < 0, (x * x + y * y) / (2 - 2 * z), (1 + z) / 2)
        rates[..., k] = dz / 2
    return squares, rates


def chain_length(model: Model) -> float:
    """How far from W's origin a body's far end can get, m: the length of a chain; 0 where nothing has a length."""
    if model.chain is not None:
        return float(model.chain.l.sum())
    away = {-1: 0.0}
    for joint, (parent, place) in enumerate(zip(model.tree.parents, model.tree.translations, strict=True)):
        away[joint] = away[parent] + float(np.linalg.norm(place))
    return max(away[body.joint] + float(np.linalg.norm(body.tip)) for body in model.bodies)


def scale(model: Model) -> float:
    """What distances are compared with, m: `chain_length`, and 1 m where that is 0."""
    return chain_length(model) or 1.0


def marks_at(model: Model, q: Array) -> Array:
    """The marks of states q (n, nv), (n, bodies, 3) m in W."""
    if model.chain is not None:
        s, c = (function(np.ascontiguousarray(q.T)) for function in (np.sin, np.cos))
        x, y, z = np.eye(3)[..., None]  # the axes of the rods so far, (3, n) in I
        tip, out = 0.0, np.empty((len(q), len(model.rods), 3))
        for k, length in enumerate(model.chain.l.tolist()):  # all states at once, and no frames are kept
            y, z = c[2 * k] * y - s[2 * k] * z, s[2 * k] * y + c[2 * k] * z
            x, z = c[2 * k + 1] * x - s[2 * k + 1] * z, s[2 * k + 1] * x + c[2 * k + 1] * z
            tip = tip + length * z
            out[:, k] = tip.T
        return out * SIGNS
    return marks(model, tips(model, poses(model, q)), q)


def marks(model: Model, link_tips: Array, q: Array) -> Array:
    """The points by which motions q (n, nv) are compared, (n, bodies, 3) m in W, from their tips.

    They are the tips. A body whose tip its own joint does not move, as a flywheel on its axis, is compared by a point
    across the axis, as far from its tip as the model is long: so an error in the angle counts as that of a rod.
    """
    if model.rod_tree is not None:
        return link_tips
    offsets, tree, length = np.zeros((len(model.bodies), 3)), model.tree, scale(model)
    for offset, body in zip(offsets, model.bodies, strict=True):  # in the link frames
        axis = tree.axes[body.joint]
        if tree.kinds[body.joint] == "revolute" and np.linalg.norm(np.cross(axis, body.tip)) <= NEAR * length:
            offset[:] = length * across(axis)
    if not offsets.any():
        return link_tips
    return link_tips + np.einsum("nrij,rj->nri", poses(model, q)[..., :3, :3], offsets)


def evaluate_each(points: Callable[[Model, Array], Array], models: Sequence[Model], q: Array) -> Array:
    """points(model, q (n, nv)) of c motions q (c, n, nv), each of its own model; in one call where they share it."""
    if all(model is models[0] for model in models):
        flat = points(models[0], q.reshape(-1, q.shape[-1]))
        return flat.reshape(*q.shape[:2], *flat.shape[1:])
    return np.array([points(model, rows) for model, rows in zip(models, q, strict=True)])


def tip_distance(one: Array, other: Array, length: float) -> Array:
    """The largest distance of any tip at each time, over a length, (n,), from tips (n, rods, 3)."""
    return np.sqrt(np.square(one - other).sum(-1).max(-1)) / length


def poses_and_energy(model: Model, q: Array, v: Array) -> tuple[Array, Array]:
    """Poses of the bodies' links (n, bodies, 4, 4) in W, and the kinetic energy (n,) in J, of states q, v (n, nv)."""
    if model.chain is not None:
        moving = kinematics.motion(model.chain, split_by_rod(q), split_by_rod(v))
        return _chain_poses(moving.frames, moving.tips), kinematics.kinetic_energy(model.chain, moving)
    return poses(model, q), kinetic_energies(model, q, v).sum(-1)


def kinetic_energies(model: Model, q: Array, v: Array) -> Array:
    """The kinetic energy of each body, (n, bodies) in J, at states q, v (n, nv)."""
    bodies, (velocity, spin) = model.body_arrays, _motion_of_bodies(model, q, v)
    return (bodies.mass * (velocity**2).sum(-1) + (spin * applied(bodies.inertia, spin)).sum(-1)) / 2


def _motion_of_bodies(model: Model, q: Array, v: Array) -> tuple[Array, Array]:
    """Velocities of the bodies' centres and spins (n, bodies, 3) in the links' frames, at q, v (n, nv)."""
    joints, (_, velocity, spin, _) = [body.joint for body in model.bodies], motions_in_links(model.tree, q, v)
    velocity, spin = velocity[:, joints], spin[:, joints]
    return velocity + cross(spin, model.body_arrays.com), spin


def spins_and_momentum(run: RunRecord) -> tuple[Array, Array]:
    """Angular velocities (n, rods, 3) in B, angular momentum (n, 3) kg m²/s about the support in W. InputError."""
    if not is_chain(run):
        raise InputError("this model is not a chain of rods, so it has neither omega nor angular_momentum")
    model = model_of(run)
    tree = model.rod_tree
    assert tree is not None
    if model.chain is not None:
        moving = kinematics.motion(model.chain, split_by_rod(run.q), split_by_rod(run.v))
        omega, frames = moving.omega, moving.frames
        orbital = cross(moving.centres, tree.m[:, None] * moving.centre_velocities) * SIGNS
    else:
        placed, (velocity, spin) = poses(model, run.q), _motion_of_bodies(model, run.q, run.v)
        centres = np.einsum("nrij,rj->nri", placed[..., :3, :], np.insert(model.body_arrays.com, 3, 1.0, axis=1))
        omega, frames = spin * SIGNS, FLIP @ placed[..., :3, :3] @ FLIP
        orbital = cross(centres, tree.m[:, None] * applied(placed[..., :3, :3], velocity))
    turned = np.einsum("nrij,nrj->ni", frames, omega * tree.inertia)
    return omega, turned * SIGNS + orbital.sum(1)


def field_potential(model: Model, link_poses: Array, field: Array) -> Array:
    """Potential energy (n,) in J of the bodies in a uniform field (3,) m/s², W; zero at W's origin."""
    centres = np.insert(model.body_arrays.com, 3, 1.0, axis=1)
    weights = -model.body_arrays.mass[:, None, None] * (np.array([*field, 0.0])[:, None] * centres[:, None])
    # Not `@`: BLAS adds up in another order for another number of rows, and a sample's energy must not depend on how many
    # are computed with it (with OpenBLAS 1, 2, 3, 6 and 7 rows of 48 numbers have other bits than among 9).
    return np.einsum("ni,i->n", link_poses.reshape(len(link_poses), -1), np.ravel(weights))


# --- of a run, whose model is built again ---------------------------------------------------------------------------

FRAMES = ("world", "parent", "child")
SIDES = {"child": 1.0, "parent": -1.0}  # action, and reaction


def model_of(run: RunRecord) -> Model:
    """The model of a run. Raises InputError where it cannot be built again, as when its URDF is gone."""
    scene = run.source if isinstance(run.source, Scene) else Scene(model=run.scene.get("model"))
    model = build(scene.model)
    if model.joints != run.joints or len(model.bodies) != run.tips.shape[1]:
        raise InputError("the run does not fit its model: its file has changed since, or is another of the same name")
    return model


def express_wrench(run: RunRecord, joint: str, frame: str, point: ArrayLike | None, on: str) -> Array:
    """The wrench (n, 6) of a joint in a frame and at a point (Trajectory.express)."""
    for name, value, choices in (("frame", frame, FRAMES), ("on", on, SIDES)):
        if not isinstance(value, str) or value not in choices:
            raise InputError(f"{name}: {not_one_of(value, choices)}")
    model = model_of(run)
    at = model.index(joint, "express")
    base = {"child": at, "parent": model.tree.parents[at], "world": -1}[frame]
    world = np.tile(np.eye(4), (len(run.q), 1, 1))
    child, of_base = (world if joint < 0 else joint_poses(model, run.q, [joint])[:, 0] for joint in (at, base))
    axes, origin = np.split(of_base[:, :3], [3], axis=2)
    turn = axes.mT @ child[:, :3, :3]
    force, moment = (applied(turn, part) for part in np.split(run.wrench[:, at], 2, axis=1))
    if point is not None:
        if (place := numbers("point", point, finite=True)).shape != (3,):
            raise InputError(f"point: {shown(point)} is not three finite numbers, in m")
        arm = applied(axes.mT, child[:, :3, 3] - origin[..., 0]) - place
        moment = moment + cross(arm, force)
    return SIDES[on] * np.concatenate([force, moment], axis=1)


def configurations(run: RunRecord, pin_model: Any) -> Array:
    """The configurations (n, nq) of a run on a Pinocchio model (Trajectory.configurations).

    A joint of the model that the run lacks stands where it is locked, or at neutral.
    Raises InputError for a model that is not a pin.Model, and for a joint of the run that the model lacks, or has in
    another kind.
    """
    pin = pinocchio()
    if not isinstance(pin_model, pin.Model):
        raise InputError(f"configurations: {shown(pin_model)} is not a pin.Model")
    names = list(pin_model.names)[1:]
    if lost := [name for name in run.joints if name not in names]:
        raise InputError(f"configurations: the pin.Model has no joint {shown(lost[0])}{did_you_mean(lost[0], names)}")
    out = np.tile(pin.neutral(pin_model), (len(run.t), 1))
    places = {name: run.q[:, j] for j, name in enumerate(run.joints)}
    places |= {name: np.full(len(run.t), float(at)) for name, at in (run.scene["model"].get("lock") or {}).items()}
    for name, angle in places.items():
        if name not in names:
            continue
        joint = names.index(name) + 1
        first, size = pin_model.idx_qs[joint], pin_model.nqs[joint]
        if size > 2:
            reason = f"configurations: joint {shown(name)} takes {size} numbers in the pin.Model, and 1 in the run"
            raise InputError(reason)
        # an angle or slide, or the cosine and sine of an angle
        out[:, first : first + size] = np.stack([angle] if size == 1 else [np.cos(angle), np.sin(angle)], -1)
    return out
