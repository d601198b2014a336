"""From a scene's model to Pinocchio's: joints, names, frames, rods on universal joints. Never changed afterwards."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from pendpin.derivations.base import Array, RodInertia
from pendpin.errors import InputError, MissingLibrary, choices, shown
from pendpin.scene import Chain, Rod, Start, UrdfModel, Values
from pendpin.urdf import read_urdf

LINK_FROM_BODY = np.diag([1.0, -1.0, -1.0])  # a rod's link frame is its body frame B with y and z negated, exactly
MAX_DATA_BYTES = 4e9
DATA_BYTES_PER_CUBE = 64  # Pinocchio's Data holds four tensors of nv³ doubles, twice (docs/pinocchio_notes.md)


@dataclass(frozen=True)
class RodJoint:
    """A rod on a universal joint: two perpendicular revolute joints at one point with a massless link between."""

    name: str  # of the rod's link
    theta: int  # index of the joint in model order
    phi: int
    body: Array  # (3, 3), b1, b2, b3 as columns in the link frame
    sign: float  # -1 where the joint `theta` turns counter-clockwise about b1
    base: Array  # (3, 3), the axes b1, b2, b3 at zero angles as columns in the frame the joint is mounted on
    length: float  # m, joint to tip
    inertia: RodInertia | None  # None unless the centre of mass is on b3 and the inertia diagonal in B


@dataclass(frozen=True)
class Tip:
    """The far end of a body: a fixed point of the link that joint `joint` moves."""

    link: str
    joint: int
    offset: Array  # (3,) m, in the link frame


@dataclass(frozen=True)
class Model:
    """What Pinocchio computes with, and the names that the user sees. One angle (or slide) per joint."""

    joints: tuple[str, ...]
    pin: Any  # pinocchio.Model with gravity zero; whoever sets gravity copies it first
    rods: tuple[RodJoint, ...]
    tips: tuple[Tip, ...]
    notes: tuple[str, ...] = ()

    def index(self, name: str, where: str) -> int:
        """The place of a joint in model order; a single rod's may be written with _1. Raises InputError."""
        if name in self.joints:
            return self.joints.index(name)
        if self.joints == ("theta", "phi") and name in {"theta_1", "phi_1"}:
            return self.joints.index(name.removesuffix("_1"))
        raise InputError(f"{where}: joint {shown(name)} is not one of: {choices(self.joints[:12])}")


def pinocchio() -> Any:
    """Pinocchio's module. Raises MissingLibrary with the command that brings the right one."""
    try:
        import pinocchio
    except ImportError as error:
        raise MissingLibrary(f"Pinocchio does not import ({error}); it is the package `pin`: pip install pin") from None
    if not hasattr(pinocchio, "aba"):
        raise MissingLibrary(
            "the installed `pinocchio` is another project: pip uninstall pinocchio && pip install --force-reinstall pin"
        )
    return pinocchio


def build(model: Chain | UrdfModel) -> Model:
    """The model of a scene. Raises InputError for a model that cannot be simulated, with its place and the reason."""
    built = _from_urdf(model) if isinstance(model, UrdfModel) else _from_chain(model)
    _refuse_what_cannot_move(built, str(model.path) if isinstance(model, UrdfModel) else "model")
    return built


def start_state(model: Model, start: Start) -> tuple[Array, Array]:
    """Positions and velocities (nv,) of the start, in model order. Raises InputError for unknown joints."""
    return _values(model, start.positions, "start.positions"), _values(model, start.velocities, "start.velocities")


def _values(model: Model, values: Values, where: str) -> Array:
    if not isinstance(values, dict):
        if len(values) != len(model.joints):
            raise InputError(
                f"{where}: {len(values)} values for {len(model.joints)} joints: {choices(model.joints[:12])}"
            )
        return np.array(values)
    out = np.zeros(len(model.joints))
    for name, value in values.items():
        out[model.index(name, where)] = value
    return out


def _refuse_size(nv: int, where: str) -> None:
    size = DATA_BYTES_PER_CUBE * nv**3
    if size > MAX_DATA_BYTES:
        raise InputError(
            f"{where}: {nv} joints need about {size / 1e9:.3g} GB in Pinocchio, which grows with their cube; "
            f"the limit is {MAX_DATA_BYTES / 1e9:g} GB"
        )


def _refuse_what_cannot_move(model: Model, where: str) -> None:
    """A joint that moves no inertia has no acceleration; Pinocchio would answer NaN or a huge number."""
    pin, nv = pinocchio(), len(model.joints)
    data = model.pin.createData()
    generic = np.sin(1.0 + np.arange(nv))
    M = pin.crba(model.pin, data, generic)
    M = np.triu(M) + np.triu(M, 1).T
    diagonal = np.diag(M)
    for name, inertia in zip(model.joints, diagonal, strict=True):
        if not inertia > 0:
            raise InputError(
                f"{where}: joint {shown(name)} moves no inertia ({inertia:g} kg m²): its links are massless"
            )
    scale = 1 / np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(scale[:, None] * M * scale)
    if values[0] < 1e-15:
        worst = model.joints[int(np.argmax(np.abs(vectors[:, 0])))]
        raise InputError(
            f"{where}: the mass matrix is singular: joint {shown(worst)} can move without moving any inertia"
        )


# --- chains of rods -------------------------------------------------------------------------------------------------


def _from_chain(chain: Chain) -> Model:
    pin, rods = pinocchio(), chain.all_rods
    _refuse_size(2 * len(rods), "model")
    model = pin.Model()
    model.gravity = pin.Motion.Zero()
    joint, offset = 0, np.zeros(3)
    names = chain_names(len(rods))
    for rod, (theta, phi, _) in zip(rods, names, strict=True):
        joint = model.addJoint(joint, pin.JointModelRevoluteUnaligned(-1, 0, 0), pin.SE3(np.eye(3), offset), theta)
        joint = model.addJoint(joint, pin.JointModelRevoluteUnaligned(0, -1, 0), pin.SE3.Identity(), phi)
        m, h, *principal = rod.properties
        model.appendBodyToJoint(joint, pin.Inertia(m, np.array([0, 0, -h]), np.diag(principal)), pin.SE3.Identity())
        offset = np.array([0, 0, -rod.length])
    joints = tuple(name for theta, phi, _ in names for name in (theta, phi))
    return Model(joints, model, _chain_rods(rods, names), _chain_tips(rods, names), _impossible(rods))


@cache
def chain_names(count: int) -> tuple[tuple[str, str, str], ...]:
    """The names of each rod's two joints and its link: theta, phi, rod for a single one, else theta_1, phi_1, rod_1."""
    if count == 1:
        return (("theta", "phi", "rod"),)
    return tuple((f"theta_{i}", f"phi_{i}", f"rod_{i}") for i in range(1, count + 1))


def _chain_rods(rods: Iterable[Rod], names: Any) -> tuple[RodJoint, ...]:
    L = LINK_FROM_BODY
    return tuple(
        RodJoint(name[2], 2 * i, 2 * i + 1, L, 1.0, L, rod.length, rod.properties)
        for i, (rod, name) in enumerate(zip(rods, names, strict=True))
    )


def _chain_tips(rods: Iterable[Rod], names: Any) -> tuple[Tip, ...]:
    return tuple(
        Tip(name[2], 2 * i + 1, np.array([0, 0, -rod.length]))
        for i, (rod, name) in enumerate(zip(rods, names, strict=True))
    )


def _impossible(rods: Iterable[Rod]) -> tuple[str, ...]:
    return tuple(f"model.rods[{i}].inertia: {rod.impossible}" for i, rod in enumerate(rods) if rod.impossible)


# --- URDF trees -----------------------------------------------------------------------------------------------------


def _from_urdf(model: UrdfModel) -> Model:
    pin, urdf = pinocchio(), read_urdf(model.path)
    _refuse_size(len(urdf.moving_joints), urdf.source)
    try:
        loaded = pin.buildModelFromXML(urdf.text)
    except (ValueError, RuntimeError) as error:
        raise InputError(f"{urdf.source}: Pinocchio does not load it: {str(error).strip().splitlines()[0]}") from None
    loaded.gravity = pin.Motion.Zero()
    joints = tuple(loaded.names)[1:]
    if set(joints) != set(urdf.moving_joints) or loaded.nq != len(joints):
        lost = sorted(set(urdf.moving_joints) - set(joints))
        raise InputError(f"{urdf.source}: Pinocchio drops joints of it: {choices(map(shown, lost))}")
    tips = _urdf_tips(loaded)
    return Model(joints, loaded, _universal_joints(loaded, tips), tips, urdf.not_applied)


def _urdf_tips(model: Any) -> tuple[Tip, ...]:
    """The far end of each link with a mass: its farthest child joint or fixed frame, else twice its centre of mass."""
    ends: list[list[Array]] = [[] for _ in range(model.njoints)]
    for joint in range(1, model.njoints):
        ends[model.parents[joint]].append(np.array(model.jointPlacements[joint].translation))
    for frame in model.frames:
        ends[frame.parentJoint].append(np.array(frame.placement.translation))
    tips = []
    for joint in range(1, model.njoints):
        if model.inertias[joint].mass > 0:
            farthest = max(ends[joint], key=np.linalg.norm)
            offset = farthest if np.linalg.norm(farthest) > 1e-9 else 2 * np.array(model.inertias[joint].lever)
            tips.append(Tip(_link_name(model, joint), joint - 1, offset))
    return tuple(tips)


def _link_name(model: Any, joint: int) -> str:
    pin = pinocchio()
    names = [f.name for f in model.frames if f.parentJoint == joint and f.type == pin.FrameType.BODY]
    return names[0] if names else model.names[joint]


def _universal_joints(model: Any, tips: tuple[Tip, ...]) -> tuple[RodJoint, ...]:
    axes = _revolute_axes(model)
    length = {tip.joint: float(np.linalg.norm(tip.offset)) for tip in tips}
    found = []
    for phi in range(2, model.njoints):
        theta = model.parents[phi]
        mount = model.jointPlacements[phi]
        if theta == 0 or theta not in axes or phi not in axes or phi - 1 not in length:
            continue
        alone = sum(parent == theta for parent in model.parents) == 1
        cross = model.inertias[theta]
        perpendicular = abs(axes[theta] @ mount.rotation @ axes[phi]) < 1e-12
        if alone and perpendicular and cross.mass == 0 and not cross.inertia.any() and not mount.translation.any():
            found.append(_rod_joint(model, theta, phi, axes, length[phi - 1]))
    return tuple(found)


def _revolute_axes(model: Any) -> dict[int, Array]:
    axes, zero = {}, np.zeros(model.nq)
    for index in range(1, model.njoints):
        joint = model.joints[index]
        if joint.shortname().startswith("JointModelR"):
            data = joint.createData()
            joint.calc(data, zero)
            axes[index] = np.array(data.S).reshape(6)[3:]
    return axes


def _rod_joint(model: Any, theta: int, phi: int, axes: dict[int, Array], length: float) -> RodJoint:
    mount = model.jointPlacements[phi].rotation
    inertia = model.inertias[phi]
    b2 = axes[phi]
    b1 = -(mount.T @ axes[theta])
    sign = 1.0
    if np.cross(b1, b2) @ inertia.lever < 0:  # b3 points from the joint to the centre of mass
        b1, sign = -b1, -1.0
    body = np.array([b1, b2, np.cross(b1, b2)], float).T + 0.0  # + 0.0 clears the sign of zeros
    base = model.jointPlacements[theta].rotation @ mount @ body
    properties = _in_body(inertia, body)
    return RodJoint(_link_name(model, phi), theta - 1, phi - 1, body, sign, base, length, properties)


def _in_body(inertia: Any, body: Array) -> RodInertia | None:
    lever, tensor = body.T @ inertia.lever, body.T @ inertia.inertia @ body
    off_axis = np.abs(lever[:2]).max() > 1e-12 * np.linalg.norm(lever)
    not_diagonal = np.abs(tensor - np.diag(np.diag(tensor))).max() > 1e-12 * np.abs(tensor).max()
    if off_axis or not_diagonal:
        return None
    return RodInertia(float(inertia.mass), float(lever[2]), *(float(x) for x in np.diag(tensor)))
