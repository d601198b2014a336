"""From a scene's model to Pinocchio's: joints, names, frames, rods on universal joints. Never changed afterwards."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from itertools import compress
from typing import Any

import numpy as np

from pendpin.effects import Bodies
from pendpin.equations.chain.kinematics import ChainInertia
from pendpin.equations.rod_tree import JointKind, RodTree
from pendpin.equations.trees import Tree
from pendpin.errors import InputError, amount, choices, find, shown
from pendpin.ground.arrays import EPS, TINY, Array, Mask
from pendpin.model.bodies import (
    Body,
    RodJoint,
    WrittenJoint,
    acting_limits,
    append_body,
    find_bodies,
    find_rods,
    mass_matrix,
    pinocchio,
    scale_masses,
    tree_of,
    twist_of,
)
from pendpin.model.urdf import content, read_urdf
from pendpin.scene import Chain, PinModel, Rod, Start, UrdfModel
from pendpin.scene.models import FARTHEST

FLIP = np.diag([1.0, -1.0, -1.0])  # W to the inertial frame I, and a rod's link frame to its body frame B: exact signs
SIGNS = np.diag(FLIP)
DATA_BYTES_PER_CUBE = 32  # Pinocchio's Data grows like nv³: docs/pinocchio_notes.md
MAX_DATA_BYTES = 1e9
SINGULAR = 4 * EPS  # for each joint: the least eigenvalue of a mass matrix with a unit diagonal
ROUNDING = 1e-12  # of a body's inertia: what rounding may leave below zero
CONFIGURATIONS = 200  # at which a mass matrix with negative inertia in it has to be positive definite


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """The computed model with the names of its joints. One angle (or slide) per joint, in model order."""

    joints: tuple[str, ...]
    # makes `pin`, where it is first needed; None for a chain too long for Pinocchio's memory
    make_pin: Callable[[], Any] | None
    chain: ChainInertia | None  # for rods of a scene in a row, all on universal joints
    rods: tuple[RodJoint, ...]  # those of a scene; of a URDF or a pin.Model those on universal joints
    bodies: tuple[Body, ...]
    notes: tuple[str, ...] = ()  # what the user should know
    findings: tuple[str, ...] = ()  # what no real body has, computed as written
    written: tuple[WrittenJoint, ...] | None = None  # what a URDF or pin.Model says of its joints; None of a chain
    home: Array | None = None  # (nv,), where joints begin that the start does not name; 0 if None
    rod_tree: RodTree | None = None  # for the rods of a scene, in a row or not

    def thin_at_pole(self, q: Array, near: float) -> str | None:
        """The first thin rod of a scene with |cos phi| < near at q (nv,), where its angles are singular; None without."""
        if self.rod_tree is None:
            return None
        thin = self.rod_tree.inertia[:, 2] == 0
        phis = np.array([rod.phi if rod.kind == "universal" else -1 for rod in self.rods])
        at_pole = thin & (phis >= 0) & (np.abs(np.cos(q[phis])) < near)
        return self.rods[int(np.argmax(at_pole))].link if at_pole.any() else None

    def __repr__(self) -> str:
        joints, bodies, rods = (len(part) for part in (self.joints, self.bodies, self.rods))
        parts = [amount(joints, "joint"), "1 body" if bodies == 1 else f"{bodies} bodies"]
        return f"Model of {', '.join(parts)}, {rods} {'rod on its joint' if rods == 1 else 'rods on their joints'}"

    @cached_property
    def pin(self) -> Any | None:
        """The pinocchio.Model with zero gravity, in a Dynamics with the constant fields; None for a chain too long for it.

        Chains on compiled equations run without it: importing Pinocchio takes longer than most of their runs.
        """
        return None if self.make_pin is None else self.make_pin()

    @cached_property
    def body_arrays(self) -> Bodies:
        """Its bodies as arrays, one row each."""
        return Bodies(*(np.array([getattr(body, name) for body in self.bodies]) for name in Bodies._fields))

    @cached_property
    def slides(self) -> Mask:
        """Which joints are prismatic, (nv,)."""
        return np.array([kind == "prismatic" for kind in self.tree.kinds], bool)

    @cached_property
    def alike(self) -> bool:
        """Whether its rods hang in a row, all on joints of one kind: their equations can be those of one rod."""
        tree = self.rod_tree
        return tree is not None and len(set(tree.kinds)) == 1 and tree.parents == tuple(range(-1, len(tree.kinds) - 1))

    @cached_property
    def lengths(self) -> Array:
        """The lengths of a scene's rods, (n,) m."""
        return -self.body_arrays.tip[:, 2]

    @cached_property
    def tree(self) -> Tree:
        """Its joints and links as plain data."""
        return tree_of(self.pin) if self.rod_tree is None else tree_of_rods(self.rod_tree)

    def index(self, name: str, where: str) -> int:
        """The place of a joint in model order; a single rod's may be written with _1. Raises InputError."""
        if set(self.joints) <= {"theta", "phi"} and str(name) in {"theta_1", "phi_1"}:
            name = name.removesuffix("_1")
        return find(self.joints, name, f"{where}: joint")

    def body(self, link: str, where: str) -> int:
        """The place of a link among the bodies; a single rod may be written rod_1. Raises InputError."""
        links = tuple(body.link for body in self.bodies)
        return find(links, "rod" if links == ("rod",) and link == "rod_1" else link, f"{where}: link")


def build(model: Chain | UrdfModel | PinModel) -> Model:
    """The model of a scene. Raises InputError for a model that cannot be simulated, with its place and the reason."""
    if isinstance(model, PinModel):
        return _build_pin(model)
    if isinstance(model, UrdfModel):  # a run asks for it several times: it is loaded once while its file stays the same
        return _loaded(model, content(model))  # pyright: ignore[reportArgumentType]
    return _build_chain(model)  # pyright: ignore[reportArgumentType]


def start_state(model: Model, start: Start) -> tuple[Array, Array]:
    """Positions and velocities (nv,) of the start, rad, m and per s. InputError for joints or positions that cannot be."""
    q, v = _values(model, start.positions, "start.positions"), _values(model, start.velocities, "start.velocities")
    home = np.zeros(len(model.joints)) if model.home is None else model.home.copy()
    named = start.positions if isinstance(start.positions, dict) else model.joints
    home[[model.index(name, "start.positions") for name in named]] = 0.0  # of those that the start names
    if start.unit == "degrees":
        unit = np.where(model.slides, 1.0, np.pi / 180)
        q, v = q * unit, v * unit
    q = np.where(home == 0, q, home)
    for joint in np.flatnonzero(np.abs(q) > FARTHEST):
        name, apart = model.joints[joint], np.spacing(abs(q[joint]))
        reason = f"start.positions.{name}: {q[joint]:g} is beyond {FARTHEST:g}: doubles are {apart:.1g} apart there"
        raise InputError(reason)
    if model.chain is None:
        remedy = "lock it" if model.rod_tree is None else "give its rod a radius"
        _refuse_singular(mass_matrix(model.pin, q), model.joints, "start.positions", f"; begin elsewhere, or {remedy}")
    return q, v


def _values(model: Model, values: dict[str, float] | tuple[float, ...], where: str) -> Array:
    """One number for each joint (nv,) in the scene's unit, from a list or a table by name. Raises InputError."""
    if not isinstance(values, dict):
        if len(values) != len(model.joints):
            has = amount(len(model.joints), "joint")
            raise InputError(f"{where}: a list of {len(values)}, where the model has {has}")
        return np.array(values)
    out = np.zeros(len(model.joints))
    names: dict[int, str] = {}
    for name, value in values.items():
        joint = model.index(name, where)
        if joint in names:
            raise InputError(f"{where}: {names[joint]} and {name} are the same joint; give one of them")
        names[joint], out[joint] = name, value
    return out


def chain_names(count: int) -> tuple[tuple[str, str, str], ...]:
    """The names of each rod's joints and link: theta, phi, rod of a single one, else theta_1, phi_1, rod_1, ..."""
    if count == 1:
        return (("theta", "phi", "rod"),)
    return tuple((f"theta_{i}", f"phi_{i}", f"rod_{i}") for i in range(1, count + 1))


@lru_cache(maxsize=16)  # one run asks for it several times
def _build_chain(chain: Chain) -> Model:
    rods, rod_tree = chain.all_rods, rod_tree_of(chain)
    has, names = rod_tree.angles, chain_names(len(rods))
    joints = tuple(name for own, given in zip(has.tolist(), names, strict=True) for name in compress(given, own))
    places = np.where(has, has.cumsum().reshape(has.shape) - 1, -1).tolist()
    properties = (rod.properties for rod in rods)
    on_joints = tuple(
        RodJoint(link, theta, phi, FLIP, 1.0, FLIP, own)
        for (_, _, link), (theta, phi), own in zip(names, places, properties, strict=True)
    )
    findings = [f"model.rods[{i}].inertia: {rod.impossible}" for i, rod in enumerate(chain.rods) if rod.impossible]
    findings += [
        f"model.rods[{i}].com: {rod.com:g} m is beyond the ends of the rod, 0 to {rod.length:g} m; computed as written"
        for i, rod in enumerate(chain.rods)
        if rod.com is not None and not 0 <= rod.com <= rod.length
    ]
    inertia = None
    if chain.in_a_row:
        lengths = np.array([rod.length for rod in rods])
        inertia = ChainInertia(rod_tree.m, rod_tree.h, lengths, *rod_tree.inertia.T)
    else:
        _refuse_size(len(joints), "model")
    fits = DATA_BYTES_PER_CUBE * len(joints) ** 3 <= MAX_DATA_BYTES
    make_pin = partial(_pin_rods, rod_tree, joints) if fits else None
    bodies = rod_bodies(rods, on_joints)
    return Model(joints, make_pin, inertia, on_joints, bodies, findings=tuple(findings), rod_tree=rod_tree)


def rod_tree_of(chain: Chain) -> RodTree:
    """The rods of a scene as plain data; with complex numbers where those of the scene are (dynamics/derivatives.py)."""
    m, h, *inertia = np.array([rod.properties for rod in chain.all_rods]).T
    kinds: tuple[JointKind, ...] = tuple(rod.turns for rod in chain.all_rods)
    return RodTree(chain.parents, kinds, np.array(chain.places), m, h, np.stack(inertia, -1))


def tree_of_rods(rods: RodTree) -> Tree:
    """The joints of rods and what they move: of a universal joint the first moves no mass. As `model.pin` has them."""
    rod, angle = np.nonzero(rods.angles)
    joints, last = np.arange(len(rod)), np.flatnonzero(np.diff(rod, append=len(rods.m)))
    is_first, is_last = np.diff(rod, prepend=-1) > 0, last[rod] == joints
    above = np.array([-1, *last])[np.array(rods.parents) + 1]  # of each rod, the joint that moves what it hangs on
    inertias = np.zeros((len(rod), 3, 3), np.result_type(rods.inertia, float))
    inertias[last] = rods.inertia[:, None] * np.eye(3)
    along_z = np.array([0.0, 0.0, 1.0])
    return Tree(
        parents=tuple(np.where(is_first, above[rod], joints - 1).tolist()),
        kinds=("revolute",) * len(rod),
        axes=np.array([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])[angle],
        rotations=np.tile(np.eye(3), (len(rod), 1, 1)),
        translations=np.where(is_first, -rods.at[rod], 0.0)[:, None] * along_z + 0.0,  # + 0.0 clears the sign of zeros
        masses=np.where(is_last, rods.m[rod], 0.0),
        coms=np.where(is_last, -rods.h[rod], 0.0)[:, None] * along_z + 0.0,
        inertias=inertias,
    )


def _pin_rods(rods: RodTree, names: tuple[str, ...]) -> Any:
    """A pin.Model of rods; a branch's joints stand together, without which Pinocchio's mass matrix is wrong.

    A universal joint is two revolute ones, not JointModelUniversal: that is 30 % faster, but loses digits in chains and has
    wrong derivatives (docs/pinocchio_notes.md, 1 and 3).
    """
    pin, tree = pinocchio(), tree_of_rods(rods)
    model = pin.Model()
    model.gravity = pin.Motion.Zero()
    for i, name in enumerate(names):
        mount = pin.SE3(np.eye(3), tree.translations[i])
        joint = model.addJoint(tree.parents[i] + 1, pin.JointModelRevoluteUnaligned(*tree.axes[i]), mount, name)
        if tree.masses[i]:
            append_body(model, joint, pin.Inertia(tree.masses[i], tree.coms[i], tree.inertias[i]))
    return model


def rod_bodies(rods: Sequence[Rod], joints: Sequence[RodJoint]) -> tuple[Body, ...]:
    """Rods on their joints as bodies."""
    bodies = []
    for rod, joint in zip(rods, joints, strict=True):
        m, h, *principal = rod.properties
        com, tip = np.array([0, 0, -h]), np.array([0, 0, -rod.length])
        bodies.append(Body(joint.link, joint.last, m, com, np.diag(principal), tip, rod.radius, rod.payload_radius))
    return tuple(bodies)


def _build_pin(model: PinModel) -> Model:
    """A pin.Model of one's own as pendpin computes with it: each joint one plain angle or slide, no gravity of its own."""
    pin, given = pinocchio(), model.pin
    if not isinstance(given, pin.Model):
        raise InputError(f"model.pin: {shown(given)} is not a pin.Model")
    _refuse_size(given.nv, "model")
    if given.njoints < 2:
        raise InputError("model: the pin.Model has no joint")
    loaded, written = pin.Model(), []
    loaded.name, loaded.gravity = given.name, pin.Motion.Zero()
    branch = [0]  # from the root to the joint before
    for i in range(1, given.njoints):
        name, joint, body, above = given.names[i], given.joints[i], given.inertias[i], given.parents[i]
        if above not in branch:  # its mass matrix and derivatives would be wrong: docs/pinocchio_notes.md, 8
            other = "a joint of another branch was added between them; add each branch of a pin.Model in one go"
            raise InputError(f"model: joint {shown(name)} hangs on {shown(given.names[above])}, but {other}")
        branch = [*branch[: branch.index(above) + 1], i]
        slide, turn = np.split(twist_of(joint), 2) if joint.nv == 1 else np.zeros((2, 3))
        if slide.any() == turn.any():
            taken = "revolute, continuous and prismatic joints (a universal joint as two revolute ones)"
            raise InputError(f"model: joint {shown(name)} is a {joint.shortname()}; pendpin takes {taken}")
        plain = pin.JointModelRevoluteUnaligned(*turn) if turn.any() else pin.JointModelPrismaticUnaligned(*slide)
        loaded.addJoint(above, plain, given.jointPlacements[i], name)
        if not np.isfinite([body.mass, *body.lever, *np.ravel(body.inertia)]).all() or body.mass < 0:
            wrong = f"has the mass {body.mass:g} kg, or inertia that is not finite"
            raise InputError(f"model: what joint {shown(name)} moves {wrong}")
        append_body(loaded, i, body)
        v, q = joint.idx_v, joint.idx_q  # continuous joints, of two numbers, have no limits
        both = (given.lowerPositionLimit[q], given.upperPositionLimit[q]) if joint.nq == 1 else (0.0, 0.0)
        written.append(WrittenJoint(name, given.damping[v], given.friction[v], *acting_limits(*both)))
    for frame in list(given.frames)[1:]:
        if frame.type != pin.FrameType.JOINT:
            loaded.addFrame(pin.Frame(frame.name, frame.parentJoint, 0, frame.placement, frame.type), False)
    return _model_of_pin(loaded, "model", {}, {}, tuple(written))


@lru_cache(maxsize=16)
def _loaded(model: UrdfModel, content: bytes) -> Model:
    """The model of a URDF whose file has this content."""
    pin, urdf = pinocchio(), read_urdf(model)
    moving = {joint.name for joint in urdf.written}
    _refuse_size(len(moving), urdf.source)
    try:
        loaded = pin.buildModelFromXML(urdf.text)
    except (ValueError, RuntimeError) as error:
        raise InputError(f"{urdf.source}: Pinocchio does not load it: {error}") from None
    loaded = scale_masses(loaded, urdf.unit) if urdf.unit != 1.0 else loaded
    loaded.gravity = pin.Motion.Zero()
    names = list(loaded.names)[1:]
    if set(names) != moving or loaded.nq != len(names):
        reason = f"{urdf.source}: Pinocchio drops joints of it: {choices(map(shown, sorted(moving - {*names})))}"
        raise InputError(reason)
    built = _model_of_pin(loaded, urdf.source, urdf.drawn, model.tips, urdf.written)
    return replace(built, notes=urdf.notes, findings=(*urdf.findings, *built.findings))


def _model_of_pin(
    loaded: Any, where: str, drawn: Mapping[str, tuple[Array, float]], tips: Any, written: tuple[WrittenJoint, ...]
) -> Model:
    """The model of a pin.Model; a finding if some inertia is negative.

    Raises InputError for a joint that moves no inertia: Pinocchio answers NaN.
    """
    pin, joints, generic = pinocchio(), tuple(loaded.names)[1:], np.sin(1.0 + np.arange(loaded.nq))
    a = pin.aba(loaded, pin.Data(loaded), generic, generic, np.zeros(loaded.nv))
    least = min(np.linalg.eigvalsh(x.inertia)[0] / (np.abs(x.inertia).max() or 1.0) for x in list(loaded.inertias)[1:])
    findings = ()
    if least < -ROUNDING:  # tried at multiples of 45 degrees, and others
        random, shape = np.random.default_rng(0), (CONFIGURATIONS // 2, loaded.nq)
        tried = np.concatenate([random.integers(0, 8, shape) * (np.pi / 4), random.uniform(-np.pi, np.pi, shape)])
        for M in (mass_matrix(loaded, q) for q in tried):
            value, joint = _least_eigenvalue(M) if np.isfinite(M).all() else (0.0, 0)
            if value < -ROUNDING:
                name = shown(joints[joint])
                raise InputError(f"{where}: joint {name} moves a negative inertia at some positions of the joints")
        unproved = f"the mass matrix is positive definite at {CONFIGURATIONS} positions; others are not known"
        findings = (f"negative inertia: {unproved}",)
    _refuse_singular(mass_matrix(loaded, generic), joints, where)
    if not np.isfinite(a).all():
        raise InputError(f"{where}: its masses, lengths or inertia are too far apart: the accelerations overflow")
    rods, bodies = find_rods(loaded), find_bodies(loaded, drawn, tips)
    return Model(joints, lambda: loaded, None, rods, bodies, findings=findings, written=written)


def _refuse_size(nv: int, where: str) -> None:
    if (needed := DATA_BYTES_PER_CUBE * nv**3) > MAX_DATA_BYTES:
        most = f"the limit of {MAX_DATA_BYTES / 1e9:g} GB; only rods on universal joints in a row may be more"
        raise InputError(f"{where}: {nv} joints need about {needed / 1e9:,.1f} GB in Pinocchio, above {most}")


def _refuse_singular(M: Array, joints: tuple[str, ...], where: str, remedy: str = "") -> None:
    """Raise InputError where a mass matrix (nv, nv) leaves some acceleration undefined."""
    if not np.isfinite(M).all():
        raise InputError(f"{where}: its masses, lengths or inertia are too large: the mass matrix overflows")
    for name, inertia in zip(joints, np.diag(M), strict=True):
        if not inertia > 0:
            why = "its links are massless, or points on its axis"
            raise InputError(f"{where}: joint {shown(name)} moves no inertia: {why}{remedy}")
    value, joint = _least_eigenvalue(M)
    if value < SINGULAR * len(M):
        name = shown(joints[joint])
        raise InputError(f"{where}: singular mass matrix: joint {name} can move without any inertia{remedy}")


def _least_eigenvalue(M: Array) -> tuple[float, int]:
    """Of a mass matrix (nv, nv) scaled to a diagonal of 1 or -1, and the joint that moves most in its direction."""
    scale = 1 / np.sqrt(np.maximum(np.abs(np.diag(M)), TINY))
    values, vectors = np.linalg.eigh(scale[:, None] * M * scale)
    return float(values[0]), int(np.argmax(np.abs(vectors[:, 0])))
