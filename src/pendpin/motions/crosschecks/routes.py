"""The routes of a cross-check: each computes the same quantities at the same states, with its own equations.

An answer is a mapping from the name of a quantity to its values, one column for each place (joint or rod).
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, loads_at, reactions
from pendpin.engines import LongChain, Revolute
from pendpin.equations import balances, lagrange, newton_euler, recursion, rod_tree
from pendpin.equations.base import RodInertia
from pendpin.equations.rod_tree import RodTree
from pendpin.errors import InputError, shown
from pendpin.ground.arguments import numbers
from pendpin.ground.arrays import TINY, Array, applied, cross
from pendpin.model import kinematics
from pendpin.model.bodies import pinocchio, with_gravity
from pendpin.model.build import SIGNS, Model

Answer = Mapping[str, Array]
Route = Callable[[Array, Array], Answer]  # q, v (n, nv) -> quantities (n, places)
HandRoute = Callable[[RodInertia, Array, Array, Array], Answer]  # one rod: rod, q, v (n, 2), field (3,) in I

REFERENCE = "50 digits"


def engine_routes(dynamics: Dynamics) -> dict[str, Route]:
    """Every route to a model that Pinocchio holds: its own, the equations of chains or of trees of rods, the recursion."""
    model = dynamics.model

    def by(engine: Revolute | LongChain) -> Route:
        return lambda q, v: _name_quantities(dynamics, q, *engine.evaluate(np.zeros(len(q)), q, v))

    routes = {"pinocchio": by(Revolute(model, dynamics.loads))}
    if model.chain is not None:
        routes["chain"] = by(LongChain(model, dynamics.loads))
    elif model.rod_tree is not None:
        routes["tree"] = _tree_route(dynamics, model.rod_tree)
    return routes | {"recursion": recursion_route(dynamics, np)}


def _tree_route(dynamics: Dynamics, tree: RodTree) -> Route:
    """The balances of a tree of rods. Of a universal joint the wrench on the rod stands for that on its massless cross."""
    model, field = dynamics.model, dynamics.loads.field(0.0) * SIGNS
    last = [rod.last for rod in model.rods]

    def route(q: Array, v: Array) -> Answer:
        tau, external = loads_at(dynamics, q, v)
        force = moment = None
        if external is not None:  # at the joints, in the links' frames
            force, moment = external[:, last, :3] * SIGNS, external[:, last, 3:] * SIGNS
            moment = moment - cross(tree.h[:, None] * np.array([0.0, 0.0, 1.0]), force)
        solved, wrench = rod_tree.solve(tree, q, v, field, tau, force, moment), np.zeros((*q.shape, 6))
        wrench[:, last] = np.concatenate([solved.force * SIGNS, solved.moment * SIGNS], -1)
        return _name_quantities(dynamics, q, solved.acceleration, wrench)

    return route


def recursion_route(dynamics: Dynamics, xp) -> Route:
    """The articulated-body and Newton-Euler recursions on the numbers of xp."""
    tree, field = dynamics.model.tree, dynamics.loads.field(0.0)

    def route(q: Array, v: Array) -> Answer:
        q_, v_, g = (xp.asarray(x) for x in (q, v, field))
        tau, external = (None if x is None else xp.asarray(x) for x in loads_at(dynamics, q, v))
        a = recursion.accelerations(tree, q_, v_, g, tau, external, xp=xp)
        wrench = recursion.wrenches(tree, q_, v_, a, g, external, xp=xp)
        return _name_quantities(dynamics, q_, a, wrench, xp)

    return route


def _name_quantities(dynamics: Dynamics, q: Array, a: Array, wrench: Array, xp=np) -> Answer:
    """Accelerations (n, nv) by joint; reactions by rod at universal joints, else forces and moments by joint."""
    model = dynamics.model
    if len(model.joints) == 2 and len(model.rods) == 1:
        answer = {"theta_dd": a[:, :1], "phi_dd": a[:, 1:]}
    else:
        answer = {"acceleration": a}
    rods = reactions(model, q, wrench, xp)
    if rods is not None:
        answer |= rods._asdict()
    if others := other_joints(model):
        n = len(q)
        answer |= {"force": wrench[:, others, :3].reshape(n, -1), "moment": wrench[:, others, 3:].reshape(n, -1)}
    return answer


def other_joints(model: Model) -> list[int]:
    """The joints that belong to no universal joint, by their places in model order."""
    taken = {joint for rod in model.rods for joint in (rod.theta, rod.phi) if joint >= 0}
    return [joint for joint in range(len(model.joints)) if joint not in taken]


def hand_routes(dynamics: Dynamics, users_routes: Mapping[str, HandRoute]) -> dict[str, Route]:
    """The routes for one rod, and the user's own, in the terms of the model's angles."""
    rod = dynamics.model.rods[0]
    inertia, turn, field = rod.inertia, np.array([rod.sign, 1.0]), rod.base.T @ dynamics.loads.field(0.0)
    assert inertia is not None

    def answer(name: str, route: HandRoute, q: Array, v: Array) -> Answer:
        given = route(inertia, q * turn, v * turn, field)
        if not isinstance(given, Mapping):
            raise InputError(f"routes: {name} returns {shown(given)}, not a mapping of quantities to values")
        parts = {what: numbers(f"routes: {name}: {what}", x) for what, x in given.items()}
        for what, x in parts.items():
            if x.size != len(q):
                raise InputError(f"routes: {name}: {what} has {x.size} values for {len(q)} states")
        if "theta_dd" in parts:
            parts["theta_dd"] = rod.sign * parts["theta_dd"]
        return {what: x.reshape(-1, 1) for what, x in parts.items()}

    return {name: partial(answer, name, route) for name, route in (HAND_ROUTES | dict(users_routes)).items()}


HAND_ROUTES: dict[str, HandRoute] = {
    "newton-euler": lambda *given: newton_euler.solve(*given)._asdict(),
    "balances": lambda *given: balances.solve(*given)._asdict(),
    "lagrange": lambda *given: dict(zip(("theta_dd", "phi_dd"), lagrange.accelerations(*given).T, strict=True)),
}


# --- the rounding scale of a quantity -------------------------------------------------------------------------------

ONE_PRODUCT = 0.01  # of a term: one rounding, where the bound of a comparison allows some hundred
MOST_PRODUCTS = 400_000  # states times joints squared that are computed at once: about 100 MB


class TreeScale(NamedTuple):
    """For states of a tree, (n, joints) each."""

    acceleration: Array  # |M^-1| times the terms of each joint's equation: its condition is in it
    force: Array  # N
    moment: Array  # N m


def tree_scale(
    model: Model, field: Array, q: Array, v: Array, a: Array, torque: Array | None = None, external: Array | None = None
) -> TreeScale:
    """The rounding scales of a tree's equations in a field (3,) in W, at q, v, a and torques (n, nv), wrenches (n, nv, 6).

    Each term is the norm of a vector, not the size of a component: where a component vanishes, such as gravity along a
    normal of its own, the rounding of the others is left in it, and each route leaves another.
    A joint's equation is the moment (the force, for a slide) along its axis: its terms are, over the bodies beyond it,
    mass times the norms of field and acceleration with their levers, inertia times angular acceleration and squared
    rate, and the loads. In Pinocchio's spatial vectors m v x v enters as well, with v the velocity of the joint's origin;
    it vanishes but for one rounding. |M^-1| bounds the effect of rounding errors in these terms on the accelerations, and
    |W M^-1| that on a joint's wrench, with W the wrenches for unit accelerations.
    """
    torque = np.zeros_like(q) if torque is None else torque
    external = np.zeros((*q.shape, 6)) if external is None else external
    size, loads = float(np.linalg.norm(field)), np.hypot.reduce(external.reshape(*q.shape, 2, 3), axis=-1)
    parts = np.array_split(np.arange(len(q)), -(-q.size * q.shape[1] // MOST_PRODUCTS))
    scales = [_scale(model, size, (q[i], v[i], a[i]), torque[i], loads[i]) for i in parts]
    return TreeScale(*(np.concatenate(column) for column in zip(*scales, strict=True)))


def _scale(model: Model, field: float, states: tuple[Array, Array, Array], torque: Array, loads: Array) -> TreeScale:
    """The sizes (n, k) at some states q, v, a (n, nv), with the norms of the field, and of forces and moments (n, k, 2)."""
    tree, nv = model.tree, len(model.joints)
    below = np.eye(nv)  # (k, k), 1 where body k hangs on joint j, or is moved by it
    for child in reversed(range(nv)):
        if tree.parents[child] >= 0:
            below[tree.parents[child]] += below[child]
    # Twists of the bodies and their rates in the joints' frames (n, k, 6), linear before angular.
    pin, rows, bodies = pinocchio(), [], with_gravity(model.pin, np.zeros(3))  # accelerations carry it, where it enters
    data = pin.Data(bodies)
    for state in zip(*states, strict=True):
        pin.forwardKinematics(bodies, data, *state)
        rows.append([[x.vector for x in each[1:]] for each in (data.v, data.a)])
    twists, bends = np.array(rows).swapaxes(0, 1)
    (linear, omega), (bend, alpha) = (np.split(x, 2, -1) for x in (twists, bends))
    # hypot, since squares below 1e-308 vanish
    sizes = [np.hypot.reduce(x, axis=-1) for x in (linear, omega, alpha, bend + np.cross(omega, linear))]
    for child, parent in enumerate(tree.parents):  # of a body and those it hangs on: rounding goes down the tree
        if parent >= 0:
            for size in sizes:
                size[:, child] = np.maximum(size[:, child], size[:, parent])
    speed, rate, turning, origin = sizes
    turning = turning + rate**2 + TINY  # 1/s²
    weight = tree.masses * (field + origin + turning * np.linalg.norm(tree.coms, axis=-1)) + loads[..., 0]
    poses = kinematics.joint_poses(model, states[0])  # of the joints, in W
    position, rotation = poses[..., :3, 3], poses[..., :3, :3]
    centre = position + applied(rotation, tree.coms)
    reach = np.linalg.norm(centre[:, None] - position[:, :, None], axis=-1)  # (n, joint, body)
    inertia = np.linalg.norm(tree.inertias, axis=(-1, -2))
    spin = inertia * turning + ONE_PRODUCT * tree.masses * speed**2 + loads[..., 1]
    forces, moments = weight @ below.T, applied(below * reach, weight) + spin @ below.T
    at_joint = np.where([kind == "prismatic" for kind in tree.kinds], forces, moments) + np.abs(torque) + TINY

    # The wrenches (n, nv, k, 6) for a unit acceleration of each joint, at rest and without gravity.
    wrenches = recursion.wrenches(tree, states[0][:, None], np.zeros(nv), np.eye(nv), np.zeros(3))
    mass_matrix = recursion.along_axes(tree, wrenches)
    unit = 1 / np.sqrt(np.diagonal(mass_matrix, axis1=-2, axis2=-1))  # by which its diagonal becomes 1
    unit = unit[:, :, None] * unit[:, None, :]
    inverse = unit * np.linalg.inv(unit * mass_matrix)
    in_world = (applied(rotation[:, None], x).transpose(0, 3, 2, 1) for x in np.split(wrenches, 2, -1))  # (n, 3, k, nv)
    through = (applied(np.abs(x @ inverse[:, None]), at_joint[:, None]) for x in in_world)
    force, moment = (np.hypot.reduce(x, axis=1) for x in through)  # of (n, 3, k)
    return TreeScale(applied(np.abs(inverse), at_joint), force + forces, moment + moments)
