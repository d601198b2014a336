"""The equations of a scene as machine code, kept for the life of the process: one compilation for each structure.

A structure is what remains of a scene when its numbers are taken out: joints, kinds of effects, which numbers are 0.
"""

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from functools import partial
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.acting import plain_arithmetic
from pendpin.dynamics.binding import Binding, bodies_of
from pendpin.dynamics.parameters import Parameters, RodParameters, begin_tape, list_parameters
from pendpin.dynamics.symbols import (
    MOTION,
    Asked,
    bodies_joints,
    external_wrenches,
    motion_in_links,
    parameters_of,
    record,
    records_by_rod,
    staying_zero,
    tree_with_numbers,
)
from pendpin.effects import Bodies, Effect
from pendpin.engines import Compiled, Engine, Function, Loads, Moving, Values
from pendpin.engines.machine import llvm
from pendpin.engines.machine.code import Block
from pendpin.engines.machine.tape import Recording
from pendpin.engines.spherical import Thin
from pendpin.equations import recursion, thin_recursion
from pendpin.equations.trees import Joint, Tree, joints_at, outward, prepared, total
from pendpin.errors import InputError
from pendpin.ground.arrays import Array, applied, cross, dot, transposed
from pendpin.model.build import Model

PARTS = 3  # of what is given: positions, rates, further torques
MOST_SAMPLED = 20  # joints of a tree that is not a loop over rods, up to which its samples are compiled
_DOWN = np.array([0.0, 0.0, -1.0])  # along a rod, in its link frame


class RodSamples(NamedTuple):
    """Rods at n samples."""

    acceleration: Array  # (n, nv) rad/s²
    wrench: Array  # (n, joints, 6) N, N m, by each joint's parent, in the joint's frame
    poses: Array  # (n, rods, 4, 4) of the rods' links, in W
    kinetic: Array  # (n,) J


# of t, q, v and further torques (w,) of a rod, or of all, as terms: their numbers, and the kinetic energy of all rods
Sampled = Callable[[Any, Array, Array, Array], tuple[Array, Any]]
# of the same and the external wrenches (w, 6): accelerations (w,) and wrenches (w, 6)
Equations = Callable[[Any, Array, Array, Array, Array | None], tuple[Array, Array]]


def record_samples(engine: Engine, effects: Sequence[Effect], start: float) -> Recording:
    """What is computed at a sample, recorded for one rod where they are alike; that of a single rod is written out."""
    tape, numbers, xp = begin_tape(engine.model, _by_rod(engine.model))
    width = numbers.width if isinstance(numbers, RodParameters) else len(engine.model.joints)
    state = tape.state_of_rod(PARTS, width) if numbers.by_rod else tape.state(PARTS * width)
    rows, kinetic = _sampled(engine, effects, start, numbers, xp)(tape.time(), *state.reshape(PARTS, width))
    if numbers.by_rod:
        return Recording(tape, [], [kinetic], parts=PARTS, width=width, more_of_rod=list(rows))
    return Recording(tape, [], [*rows, kinetic], width=PARTS * width)


def parameters_of_samples(engine: Engine, effects: Sequence[Effect], start: float) -> Parameters:
    """The parameters of `record_samples`, and its structure."""
    numbers = list_parameters(engine.model, _by_rod(engine.model))
    numbers.constant("samples")
    _sampled(engine, effects, start, numbers, np)
    return numbers


class Sampler:
    """Samples of rods in machine code, with one set of parameters."""

    def __init__(self, model: Model, block: Block) -> None:
        self._parts = len(model.rods) if _by_rod(model) else 1
        self._joints, self._block = len(model.joints) // self._parts, block

    def __call__(self, t: Array, q: Array, v: Array, torque: Array | None = None) -> RodSamples | None:
        """The samples at t (n,), q, v (n, nv) with further torques (n, nv); None where a number is not finite."""
        n, joints = len(t), self._joints
        _, more = self._block.evaluated(t, np.concatenate([q, v, np.zeros_like(q) if torque is None else torque], 1))
        if not np.isfinite(more).all():
            return None
        a, wrench, placed = np.split(more[:, :-1].reshape(n, self._parts, -1), [joints, 7 * joints], -1)
        placed = placed.reshape(n, -1, 3, 4)
        poses = np.zeros((*placed.shape[:2], 4, 4))
        poses[..., :3, :], poses[..., 3, 3] = placed, 1.0
        return RodSamples(a.reshape(n, -1), wrench.reshape(n, -1, 6), poses, more[:, -1].copy())


def _by_rod(model: Model) -> bool:
    """Whether samples are recorded for one rod."""
    return model.alike and len(model.rods) > 1


def _sampled(engine: Engine, effects: Sequence[Effect], start: float, numbers: Parameters, xp: Any) -> Sampled:
    model = engine.model
    numbers.constant((isinstance(engine, Thin), numbers.by_rod))
    loads = Binding(model, effects, xp, start, numbers).loads
    bodies, tree = Bodies(*map(numbers.bodies, bodies_of(model))), tree_with_numbers(model, numbers)
    external = None if loads.wrench is None else external_wrenches(model, loads, numbers, tree, xp)
    thin = isinstance(engine, Thin)
    equations = _sample_directions(model, loads, tree, numbers, xp) if thin else _sample_angles(loads, tree, xp)

    def sampled(t: Any, q: Array, v: Array, more: Array) -> tuple[Array, Any]:
        links = motion_in_links(model, loads, tree, q, v, xp)
        wrenches = external and external(t, q, v)
        a, wrench = equations(t, q, v, more, wrenches)
        frames = np.stack(_poses(tree, q, xp))[bodies_joints(model, tree)]
        moving = bodies.mass[:, None] * links.velocities(bodies.com) ** 2
        kinetic = total(moving + links.spin * applied(bodies.inertia, links.spin), xp) / 2  # J
        return np.concatenate([a, wrench.reshape(-1), frames.reshape(-1)]), kinetic

    return sampled


def _sample_angles(loads: Loads, tree: Tree, xp: Any) -> Equations:
    """Accelerations (nv,) and wrenches (nv, 6), by the articulated bodies and Newton-Euler."""

    def equations(t: Any, q: Array, v: Array, more: Array, external: Array | None) -> tuple[Array, Array]:
        tau = more if loads.torque is None else more + loads.torque(t, q, v)
        field = loads.field(t)
        a = recursion.accelerations(tree, q, v, field, tau, external, xp)
        return a, recursion.wrenches(tree, q, v, a, field, external, xp)

    return equations


def _sample_directions(model: Model, loads: Loads, tree: Tree, numbers: Parameters, xp: Any) -> Equations:
    """The same of a thin rod, whose joint carries no moment, by the recursion in directions; these are in W here."""
    assert model.chain is not None
    rods = (getattr(model.chain, name) for name in thin_recursion.ThinRods._fields)
    chain = thin_recursion.ThinRods(*map(numbers.bodies, rods))

    def equations(t: Any, q: Array, v: Array, more: Array, external: Array | None) -> tuple[Array, Array]:
        placed, signs = prepared(tree, xp)
        joints, force, moment = joints_at(placed, signs * q, xp), None, None
        turning = _turning(joints, signs * v, tree.parents, xp)
        R, spin = turning[1].R, turning[1].spin
        if external is not None:
            f, about_joint = np.split(external[1], 2)
            force, moment = applied(R, f)[None], applied(R, about_joint - cross(chain.h[0] * _DOWN, f))[None]
        state = applied(R, _DOWN)[None], applied(R, cross(spin, _DOWN))[None]
        turned, reaction = thin_recursion.turning(chain, *state, loads.field(t), force, moment, xp)
        across, reaction = (applied(transposed(R), x[0]) for x in (turned, reaction))
        across = across - dot(spin, _DOWN) * cross(_DOWN, spin)  # of the frame, which spins with its angles
        forces = np.stack([applied(joints[1].R, reaction), reaction])
        return signs * _accelerations(joints, turning, across, xp), np.concatenate([forces, np.zeros((2, 3))], -1)

    return equations


class _Turning(NamedTuple):
    """How a joint's frame turns."""

    R: Array  # (3, 3), to W
    spin: Array  # (3,) rad/s, in the frame
    coriolis: Array  # (3,) rad/s², the part of its angular acceleration that the rates add


def _turning(joints: Sequence[Joint], rates: Array, parents: Sequence[int], xp: Any) -> list[_Turning]:
    """How the two frames of a rod turn."""

    def turn(i: int, above: tuple[Array, Array]) -> tuple[tuple[Array, Array], _Turning]:
        joint, (R, spin) = joints[i], above
        R, arriving = R @ joint.R, applied(transposed(joint.R), spin)
        own = joint.axis * rates[i]
        return (R, arriving + own), _Turning(R, arriving + own, cross(arriving, own))

    return outward(turn, (np.eye(3), np.zeros(3)), parents, xp)


def _accelerations(joints: Sequence[Joint], turning: Sequence[_Turning], across: Array, xp: Any) -> Array:
    """theta'' and phi'' (2,) from the angular acceleration of the rod across its axis, (3,) in its frame.

    Along its axis the joint decides, from the support down.
    """
    of_theta = applied(transposed(joints[1].R), joints[0].axis)

    def swing(i: int, alpha: Array) -> tuple[Array, Array]:
        for joint, one in zip(joints, turning, strict=True):
            alpha = applied(transposed(joint.R), alpha) + one.coriolis
        theta, phi = (across - alpha)[0] / of_theta[0], (across - alpha)[1]
        return alpha + of_theta * theta + joints[1].axis * phi, np.array([theta, phi])

    return outward(swing, np.zeros(3), [-1], xp)[0]


def _poses(tree: Tree, q: Array, xp: Any) -> list[Array]:
    """The pose (3, 4) in W of what each joint moves."""
    placed, signs = prepared(tree, xp)
    joints = joints_at(placed, signs * q, xp)

    def place(i: int, above: tuple[Array, Array]) -> tuple[tuple[Array, Array], Array]:
        R, r = above
        r, R = r + applied(R, joints[i].r), R @ joints[i].R
        return (R, r), np.concatenate([R, r[:, None]], 1)

    return outward(place, (np.eye(3), np.zeros(3)), tree.parents, xp)


# --- the equations of a scene as machine code -----------------------------------------------------------------------

MOST_WRITTEN_OUT = 200  # joints, of equations that are not a loop over rods
MOST_KNOWN = 128  # structures that are kept; the one that was not asked for longest goes
MOST_SHORTENED = 10  # joints, up to which equations are written out so that what stays 0 is left out of them
_known: OrderedDict[Hashable, Function] = OrderedDict()
_still: OrderedDict[Hashable, tuple[int, ...]] = OrderedDict()  # by structure and zeros at the start
_lock = Lock()


def compilable(model: Model, effects: Sequence[Effect]) -> bool:
    """Whether `auto` compiles a scene: llvmlite is there, and all effects are pendpin's own and run on symbols."""
    few = model.alike or len(model.joints) <= MOST_WRITTEN_OUT
    return few and plain_arithmetic(effects) and llvm.installed()


def samples_compile(model: Model, effects: Sequence[Effect]) -> bool:
    """Whether samples are computed in machine code: those of rods with pendpin's own effects."""
    few = model.alike or (model.rod_tree is not None and len(model.joints) <= MOST_SAMPLED)
    return few and compilable(model, effects)


def compile_engine(engine: Engine, effects: Sequence[Effect], start: float, asked: Asked = MOTION) -> Compiled:
    """An engine with its equations compiled, at times since `start` in s.

    Raises InputError for what has no symbols, MissingLibrary without llvmlite.
    """
    llvm.require('solver.engine: "compiled"')
    for i, effect in enumerate(effects):
        if not effect.symbolic:
            raise InputError(
                f"effects[{i}]: {effect.kind} does not run on symbols, as compiled equations must; "
                'use solver.engine = "auto"'
            )
    begin = time.thread_time()
    by_rod = not isinstance(engine, Moving) and records_by_rod(engine, effects)
    if not by_rod and len(engine.model.joints) > MOST_WRITTEN_OUT:
        raise InputError(
            f'solver.engine: "compiled" takes up to {MOST_WRITTEN_OUT} joints, and longer chains with built-in effects, on '
            "joints of one kind"
        )
    equations, parameters = equations_of(engine, effects, start, asked, by_rod)
    return Compiled(engine, equations, Values.of(parameters), time.thread_time() - begin)


def in_motion(engine: Engine, effects: Sequence[Effect], start: float, q: Array, v: Array) -> Engine:
    """The engine for motions from q, v (nv,): without the numbers of its state that stay 0, where there are such."""
    zero = tuple(np.flatnonzero(engine.pack(q, v) == 0).tolist())
    if not zero or len(q) > MOST_SHORTENED or not plain_arithmetic(effects):
        return engine
    key = parameters_of(engine, effects, start).structure, zero
    with _lock:
        still = _still.get(key)
    if still is None:
        still = staying_zero(engine, effects, start, zero)
        with _lock:
            _still[key] = still = () if len(still) == len(engine.pack(q, v)) else still  # at rest for good
            while len(_still) > MOST_KNOWN:
                _still.popitem(last=False)
    return Moving(engine, still) if still else engine


def equations_of(
    engine: Engine,
    effects: Sequence[Effect],
    start: float,
    asked: Asked = MOTION,
    by_rod: bool = False,
) -> tuple[Function, Parameters]:
    """The equations of an engine's state with effects that run on symbols, and the values of their parameters.

    `by_rod`: those of one rod of a chain, which are loops as machine code.
    """
    engine, still = (engine.base, engine.still) if isinstance(engine, Moving) else (engine, ())
    parameters = parameters_of(engine, effects, start, asked, by_rod)
    write = partial(record, engine, effects, start, still, asked, by_rod)
    return look_up((parameters.structure, still), write, parameters), parameters


def compile_sampler(engine: Engine, effects: Sequence[Effect], start: float) -> Sampler:
    """The samples of rods in machine code, at times since `start` in s."""
    # A function of its own, though the equations hold the same articulated bodies: compiling these once would save 15 to 20
    # ms of a first run, but change the last digit of the accelerations at the samples (docs/accuracy.md).
    parameters = parameters_of_samples(engine, effects, start)
    equations = look_up(parameters.structure, partial(record_samples, engine, effects, start), parameters)
    return Sampler(engine.model, equations.block(Values.of(parameters)))


def look_up(key: Hashable, record: Callable[[], Recording], parameters: Parameters) -> Function:
    """The equations of a structure, new ones if they are not known."""
    with _lock:
        equations = _known.get(key)
        if equations is None:
            equations = _known[key] = Function(record, len(parameters.tables))
        _known.move_to_end(key)
        while len(_known) > MOST_KNOWN:
            _known.popitem(last=False)
    return equations
