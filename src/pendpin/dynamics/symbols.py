"""A scene's equations of motion on a tape, in the state of its engine, with the numbers of the scene as parameters."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pendpin.arrays import Array, cross
from pendpin.dynamics.binding import bind_loads
from pendpin.dynamics.parameters import Numbers, Parameters
from pendpin.effects import Effect, Motion
from pendpin.engines import AngleEngine, Directions, Engine, Loads
from pendpin.engines.tape import Recording, Tape, Term, recorded
from pendpin.equations import newton_euler, recursion, thin_recursion
from pendpin.equations.base import RodInertia
from pendpin.equations.recursion import Tree
from pendpin.model.bodies import tree_of
from pendpin.model.build import FLIP, Model

SIGNS = np.diag(FLIP)

Right = Callable[[Any, Array], Array]  # t, y (size,) -> y' (size,), all terms
Acceleration = Callable[[Any, Array, Array], Array]  # t, q, v (nv,) -> q'' (nv,)


def record(engine: Engine, effects: Sequence[Effect], start: float, still: Sequence[int] = ()) -> Recording:
    """y' of an engine's state with all effects, at times since `start` in s; the places `still` of the state are 0.

    Raises InputError for an effect that does not run on symbols.
    """
    tape = Tape()
    right = _right_hand_side(engine, effects, start, Parameters(tape), recorded())
    size = len(engine.pack(*np.zeros((2, len(engine.model.joints)))))
    y = tape.state(size)
    y[list(still)] = 0.0
    return Recording(tape, list(right(tape.time(), y)), size)


def staying_zero(engine: Engine, effects: Sequence[Effect], start: float, zero: Sequence[int]) -> tuple[int, ...]:
    """Which of the places `zero` of a state stay 0 whatever the numbers of the scene: phi in a planar motion.

    Their rates are 0 by structure while they are 0 themselves.
    """
    still = tuple(zero)
    while still:
        try:
            rates = record(engine, effects, start, still).results
        except ArithmeticError:  # an effect that divides by one of them
            return ()
        if len(left := tuple(i for i in still if not isinstance(rates[i], Term) and rates[i] == 0)) == len(still):
            break
        still = left
    return still


def parameters_of(engine: Engine, effects: Sequence[Effect], start: float) -> Parameters:
    """The parameters of these equations, and their structure, without the equations."""
    parameters = Parameters()
    _right_hand_side(engine, effects, start, parameters, np)
    return parameters


def _right_hand_side(engine: Engine, effects: Sequence[Effect], start: float, numbers: Parameters, xp: Any) -> Right:
    """y' for the engine's state: angles and rates, or directions and angular velocities of thin rods.

    A single rod in fields alone goes by the closed form (measured at 12 digits: 15 % less time than the recursion).
    """
    model = engine.model
    numbers.constant((engine.name, model.joints, tuple(body.link for body in model.bodies)))
    loads = bind_loads(model, effects, xp, start, numbers)
    if isinstance(engine, Directions):
        return _in_directions(engine, loads, numbers)
    assert isinstance(engine, AngleEngine)
    alone = len(model.joints) == 2 and len(model.rods) == 1 and model.rods[0].inertia is not None
    free = loads.torque is None and loads.wrench is None
    made = _one_rod if alone and free else _of_tree
    acceleration = made(model, loads, numbers, xp)

    def right(t: Any, y: Array) -> Array:
        q, v = np.split(y, 2)
        return np.concatenate([v, acceleration(t, q, v)])

    return right


def _one_rod(model: Model, loads: Loads, numbers: Parameters, xp: Any) -> Acceleration:
    """q'' (2,) of a single rod in fields, by the closed form."""
    rod = model.rods[0]
    turn = np.array([rod.sign, 1.0])
    assert rod.inertia is not None
    for part in (turn, rod.base):
        numbers.constant(part)
    inertia = RodInertia(*map(numbers, rod.inertia))

    def acceleration(t: Any, q: Array, v: Array) -> Array:
        found = newton_euler.solve(inertia, turn * q, turn * v, rod.base.T @ loads.field(t), xp)
        return turn * np.array([found.theta_dd, found.phi_dd])

    return acceleration


def _of_tree(model: Model, loads: Loads, numbers: Parameters, xp: Any) -> Acceleration:
    """q'' (nv,) of any tree, by the articulated-body recursion."""
    tree = _with_numbers(tree_of(model.pin), numbers)
    external = None if loads.wrench is None else external_wrenches(model, loads, numbers, tree, xp)

    def acceleration(t: Any, q: Array, v: Array) -> Array:
        tau = None if loads.torque is None else loads.torque(t, q, v)
        return recursion.accelerations(tree, q, v, loads.field(t), tau, external and external(t, q, v), xp)

    return acceleration


def _with_numbers(tree: Tree, numbers: Parameters) -> Tree:
    """The tree with its numbers as parameters; the directions of its axes stay constants."""
    for part in (tree.parents, tree.kinds, tree.axes, tree.rotations):
        numbers.constant(part)
    changing = ("translations", "masses", "coms", "inertias")
    return tree._replace(**{name: numbers(getattr(tree, name)) for name in changing})


def external_wrenches(model: Model, loads: Loads, numbers: Numbers, tree: Tree, xp: Any) -> Acceleration:
    """Wrenches on the links, (n, 6), at the joints' origins, in the joints' frames."""
    joints, com = [body.joint for body in model.bodies], numbers(np.array([body.com for body in model.bodies]))
    wrench = loads.wrench
    assert wrench is not None

    def external(t: Any, q: Array, v: Array) -> Array:
        motion = Motion(*(part[joints] for part in recursion.motions(tree, q, v, xp)))
        linear, angular = ((part[:, None] @ motion.rotation)[:, 0] for part in wrench(t, motion))  # R^T x
        out = np.zeros((len(model.joints), 6), dtype=object)
        out[joints] = np.concatenate([linear, angular + cross(com, linear)], -1)
        return out

    return external


def _in_directions(engine: Directions, loads: Loads, numbers: Parameters) -> Right:
    """d' = omega x d and omega' = d x d'', in I: regular everywhere."""
    chain = thin_recursion.ThinRods(*(numbers(getattr(engine.chain, name)) for name in thin_recursion.ThinRods._fields))

    def right(t: Any, y: Array) -> Array:
        d, omega = (part.reshape(-1, 3) for part in np.split(y, 2))
        rate, external = cross(omega, d), ()
        if loads.wrench is not None:
            found = loads.wrench(t, thin_motion(chain.l[:, None], d, rate, omega))
            external = tuple(part * SIGNS for part in found)
        turning = thin_recursion.turning(chain, d, rate, loads.field(t) * SIGNS, *external)
        return np.concatenate([rate.reshape(-1), turning.reshape(-1)])

    return right


def thin_motion(length: Array, d: Array, rate: Array, omega: Array) -> Motion:
    """The motion of n thin rods from d, d', omega (n, 3) in I; of the axes only z = -d is set, the others are 0."""
    origin, velocity = (np.concatenate([np.zeros((1, 3)), np.cumsum(length * x, 0)[:-1]]) for x in (d, rate))
    axes = np.zeros((len(d), 3, 3), dtype=object)
    axes[..., 2] = -d * SIGNS
    return Motion(origin * SIGNS, axes, velocity * SIGNS, omega * SIGNS)
