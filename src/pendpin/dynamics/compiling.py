"""A scene's equations of motion on a tape, in the state of its engine, and as machine code.

The numbers of the scene are parameters: there is one compilation for each structure, kept for the life of the process. A
structure is what remains of a scene when its numbers are taken out: joints, kinds of effects, which numbers are 0.
"""

import time
from collections.abc import Callable, Hashable, Sequence
from functools import cache, partial
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.acting import plain_arithmetic
from pendpin.dynamics.binding import Accounts, Binding, Powered, State
from pendpin.dynamics.contacts import Contacts
from pendpin.dynamics.parameters import Parameters
from pendpin.effects import ContactEffect, Effect, Motion, Torque
from pendpin.engines import AngleEngine, Compiled, Directions, Engine, Function, GivenTorque, Loads, Moving
from pendpin.engines.machine import llvm
from pendpin.engines.machine.llvm import Block
from pendpin.engines.machine.tape import Recording, Tape, Term
from pendpin.engines.pinocchio import turn_into_joint_frames
from pendpin.equations import newton_euler, recursion, trees
from pendpin.equations.base import RodInertia
from pendpin.equations.trees import Tree, outward, total
from pendpin.errors import InputError
from pendpin.ground.arrays import Array, Mask, cross
from pendpin.ground.libraries import Recent, ThreadCache
from pendpin.model.build import SIGNS, Model

Right = Callable[[Any, Array], tuple[list[Any], list[Any]]]  # t, y (size,) -> y' and what else is computed, all terms
PARTS = 2  # of a chain's state: angles and rates, or directions and angular velocities
WRITTEN_OUT = 3  # rods, up to which code without a loop takes less time: the first and the last rod lack a neighbour
MOST_WRITTEN_OUT = 200  # joints, of equations that are not a loop over rods
MOST_KNOWN = 128  # structures that are kept; the one that was not asked for longest goes
MOST_SHORTENED = 10  # joints, up to which equations are written out so that what stays 0 is left out of them
_known = Recent[Function](MOST_KNOWN)
_still = ThreadCache[tuple[int, ...]](MOST_KNOWN)  # by structure and zeros at the start
_lock = Lock()


class EquationsOfMotion(NamedTuple):
    """What is written: y' of an engine's state with all effects, and what is computed beside it; t in s since `start`."""

    engine: Engine
    effects: Sequence[Effect]
    start: float
    accounts: Accounts | None = None  # whose work is integrated with the motion
    contacts: Contacts | None = None  # the inputs are then the held joints (nv,) and the ways (nv,) that joints slide
    given: bool = False  # whether torques (nv,) in N m are given with every call: the inputs are then these
    by_rod: bool = False  # for one rod of a chain, the same for any number of rods

    def parameters(self, masks: Sequence[Mask] | None = None) -> Parameters:
        """The parameters of these equations, and their structure, without the equations."""
        parameters = Parameters(self.engine.model, self.by_rod, masks)
        self.right_hand_side(parameters)
        return parameters

    def record(self, masks: Sequence[Mask] | None = None, still: tuple[int, ...] = ()) -> Recording:
        """The equations on a tape, and the torques that hold joints; `masks` are those of the parameters.

        Numbers of the state at the places `still` are 0 and left out. Raises InputError for an effect that does not run on
        symbols.
        """
        engine, tape = self.engine, Tape()
        numbers = Parameters(engine.model, self.by_rod, masks, tape)
        right = self.right_hand_side(numbers)
        rods = engine.chain.n if isinstance(engine, Directions) else 0
        inputs = numbers.width * (2 if self.contacts else self.given)
        if self.by_rod:
            y = tape.state(3 if rods else numbers.width, PARTS)
            results, more = right(tape.term("time"), y)
            of_rod, others = results[: len(y)], results[len(y) :]
            return Recording(tape, others, [], inputs, int(rods > 0), PARTS, len(y) // PARTS, of_rod, more)
        size = engine.size + (len(self.accounts.kinds) if self.accounts else 0)
        y, moving = np.zeros(size, dtype=object), np.setdiff1d(np.arange(size), still)
        y[moving] = tape.state(len(moving))
        results, more = right(tape.term("time"), y)
        if still:
            results, rods = [results[i] for i in moving], 0  # what is normalised is whole directions
        return Recording(tape, results, more, inputs, rods, width=len(moving))

    def function(self) -> tuple[Function, Parameters]:
        """The equations, those of an earlier scene if its structure is the same, and the values of their parameters."""
        engine, still = self.engine, ()
        if isinstance(engine, Moving):
            engine, still = engine.base, engine.still
        whole = self._replace(engine=engine)
        parameters = whole.parameters()
        return look_up((parameters.structure, still), partial(whole.record, still=still), parameters), parameters

    def right_hand_side(self, numbers: Parameters) -> Right:
        """y' for the engine's state: angles and rates, or directions and angular velocities of thin rods; then the work."""
        # A single rod in fields alone goes by the closed form (measured at 12 digits: 15 % less time than the recursion).
        engine, model, xp = self.engine, self.engine.model, numbers.xp
        names = () if numbers.by_rod else (model.joints, tuple(body.link for body in model.bodies))
        numbers.constant((isinstance(engine, Directions), numbers.by_rod, *names, self.accounts))
        binding = Binding(model, self.effects, self.start, numbers)
        loads, powered = binding.loads, self.accounts and binding.powers(self.accounts)
        if isinstance(engine, Directions):
            return _record_directions(engine, loads, powered, numbers)
        assert isinstance(engine, AngleEngine)
        rod = model.rods[0] if len(model.joints) == 2 and len(model.rods) == 1 else None
        more = loads.torque, loads.wrench, self.accounts, self.contacts, self.given
        if rod is None or rod.inertia is None or any(more):
            return self._tree(binding, powered, numbers)
        turn = np.array([rod.sign, 1.0])
        for part in (turn, rod.base):
            numbers.constant(part)
        inertia = RodInertia(*map(numbers, rod.inertia))

        def right(t: Any, y: Array) -> tuple[list[Any], list[Any]]:
            q, v = np.split(y, 2)
            solution = newton_euler.solve(inertia, turn * q, turn * v, rod.base.T @ loads.field(t), xp)
            return [*v, *(turn * np.array([solution.theta_dd, solution.phi_dd]))], []

        return right

    def _tree(self, binding: Binding, powered: Powered | None, numbers: Parameters) -> Right:
        """The rates of any tree, by the articulated-body recursion, and the torques (nv,) that hold held joints."""
        accounts, contacts, loads, xp = self.accounts, self.contacts, binding.loads, numbers.xp
        bound = BoundTree(binding)
        tree, nv = bound.tree, numbers.width
        held, ways = [None] * nv, np.zeros(nv)  # which joints are held, and the ways in which others slide
        numbers.constant(self.given)
        given = [numbers.inputs(0)] if self.given else []
        if contacts is not None:
            holding, contacts = np.any(contacts.holding.reshape(-1, nv), 0), contacts.with_numbers(numbers)
            flags, ways = numbers.inputs(0), numbers.inputs(1)
            numbers.constant(("contacts", holding.tobytes()))
            held = [flag if can else None for flag, can in zip(flags, holding, strict=True)]

        def right(t: Any, y: Array) -> tuple[list[Any], list[Any]]:
            q, v = y[:nv], y[nv : 2 * nv]
            rubs = [] if contacts is None else contacts.friction_by_kind(v, np.array(ways), xp)
            taus = [*([loads.torque(t, q, v)] if loads.torque else []), *map(np.array, given)]
            taus += [torque for _, torque in rubs]
            tau = sum(taus[1:], taus[0]) if taus else None
            wrenches = bound.external(t, q, v)
            a, holding = recursion.accelerate_or_hold(tree, q, v, loads.field(t), held, tau, wrenches, xp)
            work = powered(State(t, q, v, cache(lambda: bound.motion(q, v)))) if powered else []
            if accounts:
                for kind, torque in rubs:
                    work[accounts.kinds.index(kind)] += total(torque * v, xp)
            return [*v, *a, *work], list(holding) if contacts else []

        return right


def records_by_rod(model: Model, effects: Sequence[Effect]) -> bool:
    """Whether the equations are recorded for one rod: several in a row, and effects whose laws are pendpin's own."""
    # Those see each rod for itself; what a user's law reads is not known.
    return model.alike and len(model.rods) > WRITTEN_OUT and plain_arithmetic(effects)


def staying_zero(equations: EquationsOfMotion, zero: Sequence[int]) -> tuple[int, ...]:
    """Which of the places `zero` of a state stay 0 whatever the numbers of the scene: phi in a planar motion."""
    # Their rates are 0 by structure while they are 0 themselves.
    model, still = equations.engine.model, tuple(zero)
    while still:
        tape = Tape()
        y = tape.state(equations.engine.size)
        y[list(still)] = 0.0
        try:
            rates, _ = equations.right_hand_side(Parameters(model, tape=tape))(tape.term("time"), y)
        except ArithmeticError:  # an effect that divides by one of them
            return ()
        left = tuple(i for i in still if not isinstance(rates[i], Term) and rates[i] == 0)
        if left == still:
            break
        still = left
    return still


class BoundTree:
    """The tree of a model with what its effects exert on it, on one kind of number; by rod, the tree of one."""

    def __init__(self, binding: Binding) -> None:
        model, numbers = binding.model, binding.numbers
        self.loads, self.xp, tree = binding.loads, numbers.xp, model.tree
        self._in_links = plain_arithmetic(binding.effects)  # our own laws take motions in the frames of the links too
        kept = slice(len(tree.parents) // len(model.rods) if numbers.by_rod else None)
        constants = tree.parents[kept], tree.kinds[kept], tree.axes[kept], tree.rotations[kept]
        for part in constants:  # the directions of the axes too
            numbers.constant(part)
        changing = tree.translations, tree.masses, tree.coms, tree.inertias
        self.tree = Tree(*constants, *map(numbers.per_rod, changing))
        joints = np.array([body.joint for body in model.bodies])
        self.joints = joints[joints < len(self.tree.parents)]  # that move the bodies
        self._com = None if self.loads.wrench is None else numbers.per_rod(model.body_arrays.com)

    def motion(self, q: Array, v: Array) -> Motion:
        """The motion of the bodies: in their link frames, which takes fewer operations, unless a user's effects need W."""
        if self.loads.wrench is not None and not self._in_links:
            return Motion(*trees.motions(self.tree, q, v, self.xp)).of(self.joints)
        origin, velocity, spin, into_links = trees.motions_in_links(self.tree, q, v, self.xp)
        unturned = np.broadcast_to(np.eye(3), (len(origin), 3, 3))
        return Motion(origin, unturned, velocity, spin, into_links=into_links).of(self.joints)

    def external(self, t: Any, q: Array, v: Array) -> Array | None:
        """Wrenches on the links, (n, 6), at the joints' origins and in their frames; None without any."""
        if self.loads.wrench is None or self._com is None:
            return None
        motion, out = self.motion(q, v), np.zeros((len(self.tree.parents), 6), dtype=object)
        out[self.joints] = turn_into_joint_frames(self._com, motion, *self.loads.wrench(t, motion))
        return out


def thin_rods(model: Model, numbers: Parameters) -> recursion.ThinRods:
    """A chain of thin rods with its numbers as parameters."""
    assert model.chain is not None
    return recursion.ThinRods(*(numbers.per_rod(getattr(model.chain, name)) for name in recursion.ThinRods._fields))


def _record_directions(engine: Directions, loads: Loads, powered: Powered | None, numbers: Parameters) -> Right:
    """d' = omega x d and omega' = d x d'', in I: regular everywhere."""
    chain, xp = thin_rods(engine.model, numbers), numbers.xp
    size, length = 6 * len(chain.m), chain.l[:, None]

    def sums(x: Array) -> Array:
        """The sum (n, 3) of the rows of x before each."""
        return np.stack(outward(lambda i, before: (before + x[i], before), np.zeros(3), range(-1, len(x) - 1), xp))

    def right(t: Any, y: Array) -> tuple[list[Any], list[Any]]:
        d, omega = (part.reshape(-1, 3) for part in np.split(y[:size], 2))
        rate, force, moment = cross(omega, d), None, None
        origin, velocity = sums(length * d), sums(length * rate)
        axes = np.zeros((len(d), 3, 3), dtype=object)
        axes[..., 2] = -d * SIGNS  # the others are 0: nothing asks for them
        motion = Motion(origin * SIGNS, axes, velocity * SIGNS, omega * SIGNS)
        if loads.wrench is not None:
            force, moment = (part * SIGNS for part in loads.wrench(t, motion))
        turning, _ = recursion.thin_turning(chain, d, rate, loads.field(t) * SIGNS, force, moment, xp)
        work = powered(State(t, d, omega, lambda: motion)) if powered else []
        return [*rate.reshape(-1), *turning.reshape(-1), *work], []

    return right


# --- as machine code ---------------------------------------------------------------------------------------------------


def compilable(model: Model, effects: Sequence[Effect]) -> bool:
    """Whether `auto` compiles a scene: llvmlite is there, and all effects run on symbols, pendpin's own; or a Torque."""
    few = model.alike or len(model.joints) <= MOST_WRITTEN_OUT
    others = [effect for effect in effects if not isinstance(effect, Torque)]
    touching = any(isinstance(effect, ContactEffect) for effect in others)
    return few and plain_arithmetic(others) and not (touching and len(others) < len(effects)) and llvm.installed()


def split_functions(
    model: Model, effects: Sequence[Effect], start: float
) -> tuple[tuple[Effect, ...], GivenTorque | None]:
    """The effects but each Torque, and the sum of these at times since `start` in s: called beside the machine code."""
    others = tuple(effect for effect in effects if not isinstance(effect, Torque))
    return others, Binding(model, [effect for effect in effects if isinstance(effect, Torque)], start).loads.torque


def compile_engine(equations: EquationsOfMotion) -> Compiled:
    """The engine of equations compiled. Raises InputError for no symbols, MissingLibrary for no llvmlite."""
    llvm.require('solver.engine: "compiled"')
    for i, effect in enumerate(equations.effects):
        if not (effect.symbolic or isinstance(effect, Torque)):
            why = f"{effect.kind} does not run on symbols, as compiled equations must"
            raise InputError(f'effects[{i}]: {why}; use solver.engine = "auto"')
    begin, engine = time.thread_time(), equations.engine
    effects, given = split_functions(engine.model, equations.effects, equations.start)
    if given is not None and equations.contacts is not None:
        raise InputError('solver.engine: "compiled" takes no Torque beside stops and dry friction; leave it out')
    by_rod = not isinstance(engine, Moving) and records_by_rod(engine.model, effects)
    if not by_rod and len(engine.model.joints) > MOST_WRITTEN_OUT:
        others = "longer chains with built-in effects, on joints of one kind"
        raise InputError(f'solver.engine: "compiled" takes up to {MOST_WRITTEN_OUT} joints, and {others}')
    equations = equations._replace(effects=effects, given=given is not None, by_rod=by_rod)
    function, parameters = equations.function()
    return Compiled(engine, function, parameters.values, time.thread_time() - begin, given)


def drop_zeros(equations: EquationsOfMotion, q: Array, v: Array) -> Engine:
    """The engine for motions from q, v (nv,). Where some numbers of the state stay 0, it leaves them out."""
    engine = equations.engine
    y = engine.pack(q, v)
    zero = tuple(np.flatnonzero(y == 0).tolist())
    if not zero or len(q) > MOST_SHORTENED or not plain_arithmetic(equations.effects):
        return engine
    key = equations.parameters().structure, zero
    still = _still.look_up(key, lambda: staying_zero(equations, zero))
    return Moving(engine, still) if 0 < len(still) < len(y) else engine  # where nothing moves, the whole state is kept


def record_twice(
    name: str,
    model: Model,
    by_rod: bool,
    write: Callable[[Parameters], Callable[..., Any]],
    recording: Callable[[Tape, Parameters, Any], Recording],
    parts: int,
) -> tuple[Block, Parameters]:
    """Machine code for what the function that `write` returns computes at t and `parts` parts of a state; its parameters.

    It is written once to list the parameters, and once more on a tape unless a scene of this structure came before.
    """
    parameters = Parameters(model, by_rod)
    write(parameters)

    def record() -> Recording:
        numbers = Parameters(model, by_rod, tape=(tape := Tape()))
        return recording(tape, numbers, write(numbers)(tape.term("time"), *numbers.state(parts)))

    return look_up((name, parameters.structure), record, parameters).block(parameters.values), parameters


def look_up(key: Hashable, record: Callable[[], Recording], parameters: Parameters) -> Function:
    """The equations of a structure, new ones if they are not known."""
    with _lock:
        return _known.look_up(key, lambda: Function(record, len(parameters.tables)))
