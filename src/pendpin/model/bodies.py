"""The bodies of a Pinocchio model and the rods among them that hang on universal joints."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from pendpin.equations.base import RodInertia
from pendpin.equations.rod_tree import JointKind
from pendpin.equations.trees import Tree
from pendpin.errors import MissingLibrary, find
from pendpin.ground.arrays import Array
from pendpin.scene.models import FARTHEST

NEAR = 1e-9  # of the largest length of a model: a tip this close to its joint counts as none
SMALL = 1e-10  # kg: with lighter bodies another unit of mass is taken
APART = 1e-150  # of the largest mass or inertia in kg, kg m²: lighter links are not looked at
LEAST_MASS = 1e-300  # kg, of a link that has one: its inverse and that times an inertia are finite


@dataclass(frozen=True, eq=False)
class Body:
    """A link with a mass or an inertia. Its frame is that of the joint that moves it."""

    link: str
    joint: int  # index in model order
    mass: float  # kg
    com: Array  # (3,) m, in the link frame
    inertia: Array  # (3, 3) kg m², central, in the link frame
    tip: Array  # (3,) m, its far end, in the link frame; 0 for a body that has none
    radius: float = 0.0  # m
    payload_radius: float = 0.0  # m, of the sphere at the tip; 0 where there is none


@dataclass(frozen=True, eq=False)
class RodJoint:
    """A rod on a universal joint, two perpendicular revolute joints at one point with a massless link between; or a hinge.

    A hinge is one revolute joint, theta or phi: the other is -1.
    """

    link: str
    theta: int  # index of the joint in model order
    phi: int
    frame: Array  # (3, 3), b1, b2, b3 as columns in the link frame
    sign: float  # -1 where the joint `theta` turns counter-clockwise about b1
    base: Array  # (3, 3), b1, b2, b3 at zero angles as columns in the frame of what the joint hangs on
    inertia: RodInertia | None  # None unless the centre of mass is on b3 and the inertia diagonal in B

    @property
    def kind(self) -> JointKind:
        """Universal, or the axis of a hinge."""
        return "x" if self.phi < 0 else "y" if self.theta < 0 else "universal"

    @property
    def first(self) -> int:
        """The joint next to what the rod hangs on."""
        return self.phi if self.theta < 0 else self.theta

    @property
    def last(self) -> int:
        """The joint that moves the rod."""
        return self.theta if self.phi < 0 else self.phi


class WrittenJoint(NamedTuple):
    """What a URDF or a pin.Model says of a joint, in force where a scene lists as_written; rad, or m if prismatic."""

    name: str
    damping: float  # N m s/rad
    friction: float  # N m
    lower: float  # -inf where nothing limits it
    upper: float

    def says(self, what: str) -> bool:
        """Whether it has a damping, a friction or limits."""
        limited = math.isfinite(self.lower) or math.isfinite(self.upper)
        return limited if what == "limits" else bool(getattr(self, what))


# What a file says of a joint: as a field of the effect as_written, in XML, and what acts.
WRITTEN = (
    ("damping", "<dynamics damping>", "damping"),
    ("friction", "<dynamics friction>", "dry friction"),
    ("limits", "<limit>", "stops"),
)


def acting_limits(lower: float, upper: float) -> tuple[float, float]:
    """The limits that act: none where both are equal, as a file has that means none, nor beyond FARTHEST."""
    if lower == upper:
        return -math.inf, math.inf
    low, high = (x if abs(x) < FARTHEST else math.copysign(math.inf, x) for x in (lower, upper))
    return low, high


def pinocchio() -> Any:
    """Pinocchio's module. Raises MissingLibrary with the command that brings the right one."""
    try:
        import pinocchio
    except ImportError as error:
        raise MissingLibrary(f"Pinocchio does not import ({error}): pip install pin") from None
    if not hasattr(pinocchio, "aba"):
        remedy = "pip uninstall pinocchio && pip install --force-reinstall pin"
        raise MissingLibrary(f"the installed `pinocchio` is another project: {remedy}")
    return pinocchio


def mass_unit(masses: Sequence[float], inertias: Sequence[float]) -> float:
    """A power of 2 in kg in which no mass is small: Pinocchio adds up inertias (kg m²) wrongly below 2.2e-16 of its unit."""
    least = min((mass for mass in masses if mass > 0), default=1.0)
    heaviest = max((*masses, *inertias), default=1.0)
    return 1.0 if least > SMALL else 2.0 ** math.floor(math.log2(max(least, APART * heaviest, LEAST_MASS)))


def append_body(model: Any, joint: int, inertia: Any) -> None:
    """Hang a body on a joint of a pin.Model, in the joint's frame."""
    model.appendBodyToJoint(joint, inertia, pinocchio().SE3.Identity())
    model.inertias[joint] = inertia  # Pinocchio has added it to an inertia of 0, which is wrong for small ones


def scale_masses(model: Any, factor: float) -> Any:
    """A copy of a pin.Model with its masses and inertias times a factor."""
    pin = pinocchio()
    copy = pin.Model(model)
    for joint in range(1, model.njoints):
        body = copy.inertias[joint]  # a negative inertia can be written, not made
        body.mass, body.inertia = body.mass * factor, body.inertia * factor
    return copy


def in_mass_unit(model: Any) -> tuple[Any, float]:
    """A pin.Model with its masses in a unit in which they add up, and that unit in kg."""
    moments = [float(np.abs(body.inertia).max()) for body in model.inertias]
    unit = mass_unit([body.mass for body in model.inertias], moments)
    return (model if unit == 1.0 else scale_masses(model, 1 / unit)), unit


def mass_matrix(model: Any, q: Array) -> Array:
    """The mass matrix (nv, nv) of a pin.Model in kg m² at positions (nq,)."""
    pin, (scaled, unit) = pinocchio(), in_mass_unit(model)
    return mirror_upper(pin.crba(scaled, pin.Data(scaled), q)) * unit


def mirror_upper(matrix: Array) -> Array:
    """A symmetric matrix (n, n), of which Pinocchio has filled the upper triangle alone."""
    return np.where(np.tri(len(matrix), k=-1, dtype=bool), matrix.T, matrix)


def with_gravity(model: Any, field: Array) -> Any:
    """A copy of a pin.Model in a uniform field (3,) m/s²."""
    pin = pinocchio()
    copy = pin.Model(model)
    copy.gravity = pin.Motion(field, np.zeros(3))
    return copy


def find_bodies(model: Any, drawn: Mapping[str, tuple[Array, float]], tips: Mapping[str, Any]) -> tuple[Body, ...]:
    """The links with a mass or an inertia of a pin.Model, in model order.

    `drawn` gives the two ends (2, 3) m, in the link frame, and the radius of links that are drawn as rods; `tips` the
    tips that the user chose. A body's tip is that, else the far end of the longest rod that it, or a link fixed to it, is
    drawn with, else the farthest joint that hangs on it, else twice as far as its centre of mass. Frames do not count.
    Raises InputError for a tip of a link that does not move or does not exist.
    """
    hung: list[list[Array]] = [[] for _ in range(model.njoints)]  # (3,) m, the joints that hang on what a joint moves
    lengths = []  # from joint to joint and to centres of mass, and radii of gyration
    for joint, inertia in enumerate(model.inertias):
        if joint:
            place = np.array(model.jointPlacements[joint].translation)
            hung[model.parents[joint]].append(place)
            lengths += [np.linalg.norm(place), np.linalg.norm(inertia.lever)]
            lengths += [np.sqrt(abs(np.trace(inertia.inertia)) / inertia.mass)] if inertia.mass > 0 else []
    near, bodies = NEAR * float(max(lengths)), []
    for joint, inertia in enumerate(model.inertias):
        if not joint or not (inertia.mass > 0 or inertia.inertia.any()):
            continue
        com, radius = np.array(inertia.lever), 0.0
        tip = max(hung[joint], key=np.linalg.norm, default=np.zeros(3))
        tip = tip if np.linalg.norm(tip) > near else 2 * com
        links = [(link.placement, *drawn[link.name]) for link in _links_on(model, joint) if link.name in drawn]
        rods = [(placed.translation + ends @ placed.rotation.T, thick) for placed, ends, thick in links]
        if rods:
            ends, radius = max(rods, key=lambda rod: float(np.linalg.norm(rod[0][0] - rod[0][1])))
            tip = max(ends, key=np.linalg.norm)
        tip = tip if np.linalg.norm(tip) > near else np.zeros(3)
        name = _link(model, joint)
        tip = np.array(tips[name]) if name in tips else tip
        bodies.append(Body(name, joint - 1, inertia.mass, com, np.array(inertia.inertia), tip, radius))
    for link in tips:
        find(tuple(body.link for body in bodies), link, "model.tips: link")
    return tuple(bodies)


def _links_on(model: Any, joint: int) -> list[Any]:
    """The frames of the links that a joint moves."""
    body = pinocchio().FrameType.BODY
    return [frame for frame in model.frames if frame.parentJoint == joint and frame.type == body]


def _link(model: Any, joint: int) -> str:
    return next((frame.name for frame in _links_on(model, joint)), model.names[joint])


def find_rods(model: Any) -> tuple[RodJoint, ...]:
    """The rods on universal joints of a pin.Model, in model order."""
    joints = [_kind_and_axis(model.joints[i]) for i in range(1, model.njoints)]
    axes = {i: axis for i, (kind, axis) in enumerate(joints, start=1) if kind == "revolute"}
    children = np.bincount(list(model.parents)[1:], minlength=model.njoints)
    rods = []
    for phi in range(2, model.njoints):
        theta, mount = model.parents[phi], model.jointPlacements[phi]
        if theta not in axes or phi not in axes or children[theta] != 1:
            continue
        cross = model.inertias[theta]
        perpendicular = abs(axes[theta] @ mount.rotation @ axes[phi]) < 1e-12
        if perpendicular and cross.mass == 0 and not cross.inertia.any() and not mount.translation.any():
            body, b2, b1, sign = model.inertias[phi], axes[phi], -(mount.rotation.T @ axes[theta]), 1.0
            if np.cross(b1, b2) @ body.lever < 0:  # b3 points from the joint to the centre of mass
                b1, sign = -b1, -1.0
            frame = np.array([b1, b2, np.cross(b1, b2)], float).T + 0.0  # + 0.0 clears the sign of zeros
            base = model.jointPlacements[theta].rotation @ mount.rotation @ frame
            lever, tensor = frame.T @ body.lever, frame.T @ body.inertia @ frame
            principal = np.diag(tensor)
            off_axis = np.abs(lever[:2]).max() > 1e-12 * np.linalg.norm(lever)
            not_diagonal = np.abs(tensor - np.diag(principal)).max() > 1e-12 * np.abs(tensor).max()
            in_frame = RodInertia(float(body.mass), float(lever[2]), *map(float, principal))
            inertia = None if off_axis or not_diagonal else in_frame
            rods.append(RodJoint(_link(model, phi), theta - 1, phi - 1, frame, sign, base, inertia))
    return tuple(rods)


def tree_of(model: Any) -> Tree:
    """The plain data of a pin.Model whose joints all have one degree of freedom."""
    joints = range(1, model.njoints)
    kinds, axes = zip(*(_kind_and_axis(model.joints[i]) for i in joints), strict=True)
    places, inertias = [model.jointPlacements[i] for i in joints], [model.inertias[i] for i in joints]
    return Tree(
        parents=tuple(int(model.parents[i]) - 1 for i in joints),
        kinds=kinds,
        axes=np.array(axes),
        rotations=np.array([place.rotation for place in places]),
        translations=np.array([place.translation for place in places]),
        masses=np.array([inertia.mass for inertia in inertias]),
        coms=np.array([inertia.lever for inertia in inertias]),
        inertias=np.array([inertia.inertia for inertia in inertias]),
    )


def twist_of(joint: Any) -> Array:
    """The twist (v, omega), (6,), of a Pinocchio joint of one degree of freedom at unit rate, in its frame."""
    data = joint.createData()
    joint.calc(data, np.array([1.0, 0.0][: joint.nq]))
    return np.array(data.S).ravel()


def _kind_and_axis(joint: Any) -> tuple[Literal["revolute", "prismatic"], Array]:
    """Whether a Pinocchio joint turns or slides, and its axis (3,) in its frame."""
    slide, turn = np.split(twist_of(joint), 2)
    return ("revolute", turn) if turn.any() else ("prismatic", slide)
