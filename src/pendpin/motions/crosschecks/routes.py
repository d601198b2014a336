"""The routes of a cross-check: each computes the same quantities at the same states, with its own equations.

An answer is a mapping from the name of a quantity to its values, one column for each place (joint or rod).
"""

from collections.abc import Callable, Mapping

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, loads_at, reactions
from pendpin.engines import LongChain, Revolute
from pendpin.equations import balances, lagrange, newton_euler, recursion
from pendpin.equations.base import RodInertia, exact
from pendpin.ground.arrays import Array
from pendpin.model.bodies import tree_of
from pendpin.model.build import Model

Answer = Mapping[str, Array]
Route = Callable[[Array, Array], Answer]  # q, v (n, nv) -> quantities (n, places)
HandRoute = Callable[[RodInertia, Array, Array, Array], Answer]  # one rod: rod, q, v (n, 2), field (3,) in I

REFERENCE = "50 digits"


def engine_routes(dynamics: Dynamics) -> dict[str, Route]:
    """Every route that covers the model: Pinocchio, the chain equations, the recursion."""
    model, loads = dynamics.model, dynamics.loads
    routes: dict[str, Route] = {}
    for name, engine, covers in (("pinocchio", Revolute, model.pin), ("chain", LongChain, model.chain)):
        if covers is not None:
            routes[name] = _engine_route(dynamics, engine(model, loads))
    if model.pin is not None:
        routes["recursion"] = recursion_route(dynamics, np)
    return routes


def _engine_route(dynamics: Dynamics, engine: Revolute | LongChain) -> Route:
    return lambda q, v: _named(dynamics, q, *engine.evaluate(np.zeros(len(q)), q, v))


def recursion_route(dynamics: Dynamics, xp) -> Route:
    """The articulated-body and Newton-Euler recursions on the numbers of xp."""
    tree, field = tree_of(dynamics.model.pin), dynamics.loads.field(0.0)

    def route(q: Array, v: Array) -> Answer:
        q_, v_, g = (xp.asarray(x) for x in (q, v, field))
        tau, external = (None if x is None else xp.asarray(x) for x in loads_at(dynamics, q, v))
        a = recursion.accelerations(tree, q_, v_, g, tau, external, xp=xp)
        wrench = recursion.wrenches(tree, q_, v_, a, g, external, xp=xp)
        return _named(dynamics, q_, a, wrench, xp)

    return route


def reference_route(dynamics: Dynamics) -> Route:
    """The recursion in 50 digits. Raises ImportError without mpmath."""
    return recursion_route(dynamics, exact(50))


def _named(dynamics: Dynamics, q: Array, a: Array, wrench: Array, xp=np) -> Answer:
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
    taken = {joint for rod in model.rods for joint in (rod.theta, rod.phi)}
    return [joint for joint in range(len(model.joints)) if joint not in taken]


def hand_routes(dynamics: Dynamics, users_routes: Mapping[str, HandRoute]) -> dict[str, Route]:
    """The routes for one rod, and the user's own, in the terms of the model's angles."""
    rod = dynamics.model.rods[0]
    inertia = rod.inertia
    assert inertia is not None
    turn = np.array([rod.sign, 1.0])
    field = rod.base.T @ dynamics.loads.field(0.0)

    def bound(route: HandRoute) -> Route:
        def answer(q: Array, v: Array) -> Answer:
            parts = {name: np.asarray(x, float) for name, x in route(inertia, q * turn, v * turn, field).items()}
            if "theta_dd" in parts:
                parts["theta_dd"] = rod.sign * parts["theta_dd"]
            return {name: x.reshape(-1, 1) for name, x in parts.items()}

        return answer

    return {name: bound(route) for name, route in (HAND_ROUTES | dict(users_routes)).items()}


def _lagrange(rod: RodInertia, q: Array, v: Array, field: Array) -> Answer:
    """Accelerations of one rod by Lagrange's equations, from q, v (n, 2) in a field (3,) in m/s²."""
    theta_dd, phi_dd = np.moveaxis(lagrange.accelerations(rod, q, v, field), -1, 0)
    return {"theta_dd": theta_dd, "phi_dd": phi_dd}


HAND_ROUTES: dict[str, HandRoute] = {
    "newton-euler": lambda *given: newton_euler.solve(*given)._asdict(),
    "balances": lambda *given: balances.solve(*given)._asdict(),
    "lagrange": _lagrange,
}
