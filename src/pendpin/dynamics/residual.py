"""The mass, damping and stiffness matrices of a scene at a state: the exact derivatives of its inverse dynamics.

The residual r(q, v, a) is the torque about each joint that the motion needs, by the recursion of Newton-Euler, less what
the effects give; a motion has r = 0. Its derivatives by a, v and q are the matrices M, C and K of small motions
M x'' + C x' + K x = 0 about a rest.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.binding import Binding
from pendpin.dynamics.compiling import look_up
from pendpin.dynamics.derivatives import differentiable
from pendpin.dynamics.dynamics import choose_engine
from pendpin.dynamics.parameters import Parameters, begin_tape, list_parameters
from pendpin.dynamics.symbols import external_wrenches, records_by_rod, tree_with_numbers
from pendpin.effects import Effect
from pendpin.engines import Engine, Values
from pendpin.engines.machine.tangents import STATE, add_tangents
from pendpin.engines.machine.tape import Recording
from pendpin.equations import recursion
from pendpin.equations.base import JOINTS
from pendpin.ground.arrays import Array
from pendpin.model.build import build
from pendpin.scene import Scene

PARTS = 3  # of what is given: positions, rates, accelerations
TOGETHER = 128  # directions that are computed at once: what they need stays small

Residual = Callable[[Any, Array, Array, Array], Array]  # t, q, v, a (nv,) -> (nv,) N m


class Matrices(NamedTuple):
    """Derivatives (nv, nv) of the residual torques at a state."""

    mass: Array  # by accelerations, kg m²
    damping: Array  # by rates, N m s/rad
    stiffness: Array  # by positions, N m/rad


def matrices(scene: Scene, q: Array, v: Array, a: Array) -> Matrices:
    """M, C and K at q, v, a (nv,), with the effects as they are at the scene's start; friction and stops are left out.

    Raises InputError for effects without derivatives, MissingLibrary without llvmlite.
    """
    model, effects, start = build(scene.model), differentiable(scene), scene.start.time
    engine = choose_engine(model, Binding(model, effects, start=start).loads, "auto", "angles")
    by_rod, nv = records_by_rod(engine, effects), len(q)
    parameters = list_parameters(model, by_rod)
    _residual(engine, effects, start, parameters, np)
    write = partial(_record, engine, effects, start, by_rod)
    block = look_up(("residual", parameters.structure), write, parameters).function.block(Values.of(parameters))
    point, derivatives = np.concatenate([q, v, a]), np.empty((PARTS * nv, nv))
    for begin in range(0, PARTS * nv, TOGETHER):
        ways = np.eye(min(TOGETHER, PARTS * nv - begin), PARTS * nv, begin)
        states = np.concatenate([np.broadcast_to(point, ways.shape), ways], 1)
        derivatives[begin : begin + len(ways)] = block.evaluated(np.zeros(len(ways)), states)[0][:, nv : 2 * nv]
    of_q, of_v, of_a = derivatives.reshape(PARTS, nv, nv).transpose(0, 2, 1)
    return Matrices(of_a, of_v, of_q)


def _record(engine: Engine, effects: Sequence[Effect], start: float, by_rod: bool) -> Recording:
    """The residual with its derivative along a change of q, v and a; by rod, of one rod."""
    tape, numbers, xp = begin_tape(engine.model, by_rod)
    residual = _residual(engine, effects, start, numbers, xp)
    state = tape.state_of_rod(PARTS, JOINTS) if by_rod else tape.state(PARTS * len(engine.model.joints))
    results = list(residual(tape.time(), *state.reshape(PARTS, -1)))
    if by_rod:
        return add_tangents(Recording(tape, [], parts=PARTS, width=JOINTS, of_rod=results), [STATE])
    return add_tangents(Recording(tape, results, width=len(state)), [STATE])


def _residual(engine: Engine, effects: Sequence[Effect], start: float, numbers: Parameters, xp: Any) -> Residual:
    """The torques (nv,) that a motion needs beyond those of the effects, as a function of t, q, v, a (nv,)."""
    model = engine.model
    numbers.constant("residual")
    numbers.constant(() if numbers.by_rod else (model.joints, tuple(body.link for body in model.bodies)))
    loads = Binding(model, effects, xp, start, numbers).loads
    tree = tree_with_numbers(model, numbers)
    external = None if loads.wrench is None else external_wrenches(model, loads, numbers, tree, xp)

    def residual(t: Any, q: Array, v: Array, a: Array) -> Array:
        wrenches = recursion.wrenches(tree, q, v, a, loads.field(t), external and external(t, q, v), xp)
        turns = np.array([kind == "revolute" for kind in tree.kinds])
        along = np.where(turns[:, None], wrenches[:, 3:], wrenches[:, :3])
        needed = (along * tree.axes).sum(-1)
        return needed if loads.torque is None else needed - loads.torque(t, q, v)

    return residual
