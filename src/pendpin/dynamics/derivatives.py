"""Exact derivatives of a scene's motion, in machine code: of accelerations by positions, rates and numbers of the scene.

The equations are those of the run on angles, recorded on a tape and differentiated there operation by operation
(engines/machine/tangents.py): no finite differences, no second formula. Friction and stops are left out.

A length enters several parameters: masses, levers, inertias. They are plain arithmetic of the numbers of the scene, so a
number gets a small imaginary part h i, and that of each parameter over h is its rate, exact to rounding (the complex step:
W. Squire, G. Trapp, SIAM Review 40 (1998), 110). Numbers that are 0 have a rate too: they become parameters.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple, cast

import numpy as np

from pendpin.dynamics.acting import acting, expand_as_written
from pendpin.dynamics.binding import Binding
from pendpin.dynamics.compiling import EquationsOfMotion, look_up, records_by_rod
from pendpin.dynamics.contacts import Contacts, bind_contacts
from pendpin.dynamics.dynamics import choose_engine
from pendpin.effects import ContactEffect, Effect, Idle
from pendpin.engines import AngleEngine, Engine, Revolute, Values
from pendpin.engines.machine import llvm
from pendpin.engines.machine.llvm import Block
from pendpin.engines.machine.tangents import STATE, Direction, add_tangents
from pendpin.equations.chain.thin import POLE
from pendpin.errors import InputError, KeyPath, written
from pendpin.ground.arguments import number_at, parsed
from pendpin.ground.arrays import Array
from pendpin.ground.records import Record
from pendpin.model.build import Model, build, rod_bodies, rod_tree_of
from pendpin.scene import Chain, Scene

REST = 1e-9  # of the accelerations that a turn by 1 rad causes: what is less is rounding
_STEP = 2.0**-133  # its square is nothing beside 1, and products of two of them are still numbers
_LEAST = 1e-300  # N m


class Jacobian(NamedTuple):
    """Accelerations q'' at a state, and their derivatives."""

    acceleration: Array  # (nv,)
    of_q: Array  # (nv, nv), 1/s²
    of_v: Array  # (nv, nv), 1/s

    @property
    def balanced(self) -> bool:
        """Whether nothing accelerates there."""
        return bool(np.abs(self.acceleration).max(initial=0.0) <= REST * max(1.0, np.abs(self.of_q).max(initial=0.0)))


class Variational:
    """y' = f(t, y) of the state y = (q, v), with the derivatives of f in some directions, as machine code.

    A direction is that of one number of the scene, by its key path: the state of its equations is (y, w_1, ..., w_K),
    w_k = dy/d(number k), and w_k' = df/dy w_k + df/d(number k). Without keys there is one direction, that of a change w of
    the state itself. Times are since the scene's start, in s. Use one in each thread.

    Friction and stops are left out: they act at events. `contacts` keeps friction, between two events: `self.contacts` then
    says what is held. Friction holds no joint whose place is among those that stay 0, `still`.

    Raises InputError for effects without derivatives, for keys that are not numbers of the scene, and MissingLibrary
    without llvmlite.
    """

    def __init__(
        self, scene: Scene, keys: Sequence[str] = (), contacts: bool = False, still: tuple[int, ...] = ()
    ) -> None:
        self.model = build(scene.model)
        self.keys, self.scene = tuple(keys), scene
        effects, start = differentiable(scene, contacts), scene.start.time
        engine = choose_engine(self.model, Binding(self.model, effects, start).loads, "auto", "angles")
        touching = any(isinstance(effect, ContactEffect) for effect in effects)
        by_rod = not still and not touching and records_by_rod(self.model, effects)
        self._vary(scene.model_copy(update={"effects": effects}), engine, by_rod)
        equations, parameters, masks = self.of_motion, self._parameters, self._masks
        llvm.require("what takes derivatives")
        directions = self.directions or (STATE,)
        places = tuple((*one.shared.items(), None, *one.of_rods.items(), one.time) for one in directions)
        key = ("derivatives", parameters.structure, len(parameters.shared), places)
        function = look_up(key, lambda: add_tangents(equations.record(masks), directions), parameters)
        self.block: Block = function.block(self._values)  # its state is (y, w_1, ..., w_K)
        self.contacts: Contacts | None = None
        bound = equations.contacts  # none where all friction is 0 and stays so
        if bound is not None and isinstance(engine, AngleEngine):
            moving = np.isin(np.arange(len(bound.static)), still, invert=True)
            self.contacts = replace(bound, engine=engine, static=bound.static * moving, block=self.block)
        self.nv = len(self.model.joints)

    def _vary(self, scene: Scene, engine: Engine, by_rod: bool) -> None:
        """List the scene's parameters and its start, and how fast each changes with each of the K numbers.

        The state of `engine` is (q, v).
        """
        model, nv = engine.model, len(engine.model.joints)
        places = [parsed(key) for key in self.keys]
        for key, path in zip(self.keys, places, strict=True):
            if path[0] in ("model", "effects"):
                number_at(self.scene, key)  # a key that is none is refused
        changes = [_changed(scene, model, path) for path in places if path[0] != "start"]  # which is in no parameter
        given = [scene.effects, *(effects for _, effects in changes)]
        lists = [acting(model, effects) for effects in given]
        active = [not all(isinstance(effect, Idle) for effect in column) for column in zip(*lists, strict=True)]
        cases = list[EquationsOfMotion]()  # of the scene as it is, then with an imaginary part in each of its numbers
        for other, effects in zip([None, *(changed for changed, _ in changes)], given, strict=True):
            acts = tuple(e if a else Idle(kind=e.kind) for e, a in zip(effects, active, strict=True))
            own, contacts = engine if other is None else Revolute(other, engine.loads), None
            if cases and effects is given[0]:
                contacts = cases[0].contacts
            elif any(isinstance(effect, ContactEffect) for effect in acts):
                assert isinstance(own, AngleEngine)
                contacts = bind_contacts(model, acts, own)
            cases.append(EquationsOfMotion(own, acts, scene.start.time, contacts=contacts, by_rod=by_rod))
        bound = [case.contacts for case in cases]
        if (mine := bound[0]) is not None:
            # A friction of 0 that may grow changes its way at events too: it is one of next to nothing.
            grows = np.any([np.imag(one.static) > 0 for one in bound if one is not None], 0)
            mine = replace(mine, static=np.where(grows, np.maximum(mine.static, _LEAST), mine.static))
            cases = [case._replace(contacts=mine) if case.contacts is bound[0] else case for case in cases]
        first = [case.parameters() for case in cases]
        base, *others = first
        masks = [np.logical_or.reduce(column) for column in zip(*(one.masks for one in first), strict=True)]
        if any(one.structure != base.structure for one in others):
            base, *others = (case.parameters(masks) for case in cases)
        shared, rods = list(base.shared), list(base.of_rods)

        def appended(values: list[Any], rates: Array) -> dict[int, int]:
            """Where the rates that are not 0 are among the values, behind which they are put."""
            places = np.flatnonzero(rates if rates.ndim == 1 else rates.any(1))
            out = {place: len(values) + i for i, place in enumerate(places.tolist())}
            values += rates[places].tolist() if rates.ndim == 1 else list(rates[places])
            return out

        directions, static = [], []
        changed = iter(zip(others, (case.contacts for case in cases[1:]), strict=True))
        for key in places:
            one, contacts = (base, cases[0].contacts) if key[0] == "start" else next(changed)
            rates, of_rods = np.imag(one.shared) / _STEP, np.imag(one.values.of_rods) / _STEP
            time = 1.0 if key == ("start", "time") else 0.0
            directions.append(Direction(appended(shared, rates), appended(rods, of_rods), time))
            static.append(np.imag(contacts.static) / _STEP if contacts else np.zeros(nv))
        self.of_motion = cases[0]  # with effects that act, or would with other numbers
        self._parameters, self._masks = base, masks  # with a place for each number that is not 0 or changes
        columns = np.array(rods, float).reshape(len(rods), base.rods)
        self._values = Values(shared, columns, base.tables)  # of the parameters, those of the rates behind them
        self.directions: tuple[Direction, ...] = tuple(directions)  # (K,)
        starts = np.array([_start_rate(scene, model, path) for path in places])
        self.starts: Array = starts.reshape(len(places), 2 * nv)  # (K, 2 nv), of the start's (q, v) by the numbers
        self.static: Array = np.array(static).reshape(len(places), nv)  # (K, nv) N m, of what can hold each joint

    def rates(self, t: Array, y: Array, w: Array) -> tuple[Array, Array]:
        """y' (n, 2 nv) and w' (n, K, 2 nv) at times (n,), states y (n, 2 nv) and w (n, K, 2 nv)."""
        n, size = y.shape
        rows, _ = self.block.evaluated(t, np.concatenate([y, w.reshape(n, -1)], 1))
        return rows[:, :size], rows[:, size:].reshape(w.shape)

    def jacobian(self, t: float, q: Array, v: Array) -> Jacobian:
        """The accelerations at a state (nv,) each and their derivatives; for one without keys."""
        nv, directions = self.nv, np.eye(2 * self.nv)[:, None]
        y = np.tile(np.concatenate([q, v]), (2 * nv, 1))
        rates, changes = self.rates(np.full(2 * nv, t), y, directions)
        return Jacobian(rates[0, nv:], changes[:nv, 0, nv:].T, changes[nv:, 0, nv:].T)


def refuse_poles(model: Model, q: Array) -> None:
    """Raise InputError for positions q (nv,) with a thin rod at phi = ±90 degrees, where its angles are singular."""
    if rod := model.thin_at_pole(q, POLE):
        raise InputError(f"{rod} is thin and at phi = ±90 degrees, where its angles are singular: give it a radius")


def differentiable(scene: Scene, contacts: bool = False) -> tuple[Effect, ...]:
    """A scene's effects, `Idle` for friction and stops unless `contacts` are kept. InputError for one without symbols."""
    acts = expand_as_written(build(scene.model), scene.effects)
    for i, effect in enumerate(acts):
        if not effect.symbolic:
            raise InputError(f"effects[{i}]: {effect.kind} has no derivative: its law takes plain floats only")
    return tuple(Idle(kind=e.kind) if isinstance(e, ContactEffect) and not contacts else e for e in acts)


def _start_rate(scene: Scene, model: Model, path: KeyPath) -> Array:
    """The change (2 nv,) of q and v at the start with the number at a path."""
    nv, out = len(model.joints), np.zeros(2 * len(model.joints))
    if path[0] != "start" or path == ("start", "time"):
        return out
    fields = ("positions", "velocities")
    if len(path) != 3 or path[1] not in fields:
        raise InputError(f"{written(path)}: this number has no derivative; positions and velocities of joints have one")
    joint = path[2] if isinstance(path[2], int) else model.index(path[2], "start")
    if joint >= nv:
        raise InputError(f"{written(path)}: the model has {nv} joints")
    degrees = scene.start.unit == "degrees" and not model.slides[joint]
    out[fields.index(str(path[1])) * nv + joint] = np.pi / 180 if degrees else 1.0
    return out


def _changed(scene: Scene, model: Model, path: KeyPath) -> tuple[Model | None, tuple[Effect, ...]]:
    """The model, None where it does not change, and the effects with an imaginary part in the number at a path."""
    given, effects = scene.model, scene.effects
    if path[0] == "effects":
        return None, _step_numbers(effects, path, 1)
    if path[:2] == ("model", "rods") and isinstance(given, Chain):
        rods = _step_numbers(given.rods, path, 2)
        chain = Chain.model_construct(kind="chain", rods=rods, copies=given.copies)
        all_rods, pairs = chain.all_rods, zip(model.rods, chain.all_rods, strict=True)
        rods = tuple(replace(old, inertia=new.properties) for old, new in pairs)
        bodies = rod_bodies(all_rods, rods)
        return replace(model, chain=None, rods=rods, bodies=bodies, rod_tree=rod_tree_of(chain)), effects
    raise InputError(f"{written(path)}: this number has no derivative; numbers of rods, effects and the start have one")


def _step_numbers(records: Sequence[Record], path: KeyPath, depth: int) -> tuple[Any, ...]:
    """The records with an imaginary part in the number at a path, whose place at `depth` is that of one of them."""
    place, rest = cast(int, path[depth]), path[depth + 1 :]
    record, name = records[place], str(rest[0])
    if isinstance(record, Idle):
        raise InputError(f"{written(path)}: {record.kind} acts through events; its numbers have no derivatives")
    fields = {name: getattr(record, name) for name in type(record).model_fields}
    if name not in fields or isinstance(fields[name], int):  # a whole number, as the copies of a rod
        raise InputError(f"{written(path)}: this number has no derivative; lengths, masses and coefficients have one")

    own = type(record)
    if isinstance(record, Effect) and not own.__module__.startswith("pendpin.") and name not in record.parameters:
        # it stands in the equations as a constant
        remedy = f'name it in the class, {own.__name__}: parameters = ("{name}",)'
        raise InputError(f"{written(path)}: this number has no derivative; {remedy}")

    def stepped(value: Any, rest: KeyPath) -> Any:
        """A number with an imaginary part, or a list of numbers with one in that at its place `rest`."""
        if not rest:
            return complex(value, _STEP)
        i = cast(int, rest[0])
        return (*value[:i], stepped(value[i], rest[1:]), *value[i + 1 :])

    construct = cast(Any, type(record).model_construct)  # which takes complex numbers, as records do not
    changed = construct(**(fields | {name: stepped(fields[name], rest[1:])}))
    return (*records[:place], changed, *records[place + 1 :])
