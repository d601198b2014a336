"""The rates at which the parameters of a scene's equations change with numbers of the scene, named by key paths.

A length enters several parameters: masses, levers, inertias. They are plain arithmetic of the numbers of the scene, so a
number gets a small imaginary part h i, and that of each parameter over h is its rate, exact to rounding (the complex step:
W. Squire, G. Trapp, SIAM Review 40 (1998), 110). Numbers that are 0 have a rate too: they become parameters.
"""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.binding.acting import acting
from pendpin.dynamics.binding.contacts import bind_contacts
from pendpin.dynamics.parameters import Parameters
from pendpin.dynamics.symbols import MOTION, Asked, parameters_of
from pendpin.effects import ContactEffect, Effect, Idle
from pendpin.engines import AngleEngine, Engine, LongChain
from pendpin.engines.machine.tangents import Direction
from pendpin.errors import InputError, KeyPath, is_number, shown, written
from pendpin.ground.arrays import Array, Mask
from pendpin.ground.keypaths import parsed
from pendpin.ground.records import Record
from pendpin.model.build import Model, chain_bodies
from pendpin.scene import Chain, Scene

_STEP = 2.0**-133  # its square is nothing beside 1, and products of two of them are still numbers


class Variation(NamedTuple):
    """A scene's parameters with their rates of change by K numbers, and the start's."""

    engine: Engine  # on angles
    effects: tuple[Effect, ...]  # that act, or would with other numbers
    asked: Asked  # the contacts of these, if there are any
    parameters: Parameters  # with a place for each number that is not 0 or changes
    masks: Sequence[Mask]
    shared: list[float]  # values of parameters, those of the rates behind them
    of_rods: Array  # (k, n), the same of the parameters of rods
    directions: tuple[Direction, ...]  # (K,)
    start: Array  # (K, 2 nv), of q and v at the start
    static: Array  # (K, nv) N m, of what can hold each joint


def vary(scene: Scene, engine: Engine, keys: Sequence[str], by_rod: bool) -> Variation:
    """The variation of a scene by its numbers at some key paths: of rods, of effects, of the start.

    The engine is one on angles. Raises InputError for a key that is not a number, or one by which there is no derivative.
    """
    model = engine.model
    places = [parsed(key) for key in keys]
    changes = [_changed(scene, path) for path in places if path[0] != "start"]  # the start is in no parameter
    lists = [acting(model, effects) for effects in (scene.effects, *(changed for _, changed in changes))]
    active = [not all(isinstance(effect, Idle) for effect in column) for column in zip(*lists, strict=True)]
    pairs: list[tuple[Engine, tuple[Effect, ...]]] = []
    for chain, effects in [(None, scene.effects), *changes]:
        chosen = (e if acts else Idle(kind=e.kind) for e, acts in zip(effects, active, strict=True))
        pairs.append((_engine_of(model, engine, chain), tuple(chosen)))
    asked = [_contacts_of(model, *pair) for pair in pairs]
    cases = [(*pair, scene.start.time, one, by_rod) for pair, one in zip(pairs, asked, strict=True)]
    first = [parameters_of(*case) for case in cases]
    masks = [np.logical_or.reduce(column) for column in zip(*(one.masks for one in first), strict=True)]
    same = all(np.array_equal(mask, own) for one in first for mask, own in zip(masks, one.masks, strict=True))
    base, *others = first if same else [parameters_of(*case, masks) for case in cases]
    shared, rods, changed = list(base.values), list(base.values_of_rods), iter(zip(others, asked[1:], strict=True))
    directions, static = [], []
    for key in places:
        one, its = (base, asked[0]) if key[0] == "start" else next(changed)
        rates, of_rods = np.imag(one.values) / _STEP, np.imag(one.values_of_rods) / _STEP
        time = 1.0 if key == ("start", "time") else 0.0
        directions.append(Direction(_appended(shared, rates), _appended(rods, of_rods), time))
        static.append(np.imag(its.contacts.static) / _STEP if its.contacts else np.zeros(len(model.joints)))
    starts = np.array([_start_rate(scene, model, path) for path in places]).reshape(len(keys), 2 * len(model.joints))
    columns = np.array(rods, float).reshape(len(rods), base.values_of_rods.shape[1])
    holding = np.array(static).reshape(len(keys), len(model.joints))
    return Variation(*pairs[0], asked[0], base, masks, shared, columns, tuple(directions), starts, holding)


def _contacts_of(model: Model, engine: Engine, effects: Sequence[Effect]) -> Asked:
    """What the equations hold beside the motion: the contacts, if any act."""
    if not any(isinstance(effect, ContactEffect) for effect in effects):
        return MOTION
    assert isinstance(engine, AngleEngine)
    return Asked(contacts=bind_contacts(model, effects, engine))


def _appended(values: list[Any], rates: Array) -> dict[int, int]:
    """Where the rates that are not 0 are among the values, behind which they are put."""
    places = {}
    for place, rate in enumerate(rates):
        if np.any(rate):
            places[place] = len(values)
            values.append(rate if np.ndim(rate) else float(rate))
    return places


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


def _changed(scene: Scene, path: KeyPath) -> tuple[Chain | None, tuple[Effect, ...]]:
    """The chain, None where it does not change, and the effects with an imaginary part in the number at a path."""
    model, effects = scene.model, scene.effects
    if path[0] == "effects" and (changed := _step_numbers(effects, path, 1)):
        return None, changed
    if path[:2] == ("model", "rods") and isinstance(model, Chain) and (changed := _step_numbers(model.rods, path, 2)):
        return Chain.model_construct(kind="chain", rods=changed, copies=model.copies), effects
    raise InputError(f"{written(path)}: this number has no derivative; numbers of rods, effects and the start have one")


def _step_numbers(records: Sequence[Record], path: KeyPath, depth: int) -> tuple[Any, ...]:
    """The records with an imaginary part in the number at a path, whose place at `depth` is that of one of them.

    Empty if there is no such record.
    """
    place, rest = path[depth] if len(path) > depth else None, path[depth + 1 :]
    if not isinstance(place, int) or place >= len(records):
        return ()
    record, kind = records[place], type(records[place])
    if isinstance(record, Idle):
        raise InputError(f"{written(path)}: {record.kind} acts through events; its numbers have no derivatives")
    fields = {name: getattr(record, name) for name in kind.model_fields}
    if not rest or rest[0] not in fields:
        raise InputError(f"{written(path)}: not a number of the scene")
    construct: Any = kind.model_construct  # a record takes no complex number, and the arithmetic that makes parameters does
    changed = construct(**(fields | {str(rest[0]): _with_step(fields[str(rest[0])], path, rest[1:])}))
    return (*records[:place], changed, *records[place + 1 :])


def _with_step(value: Any, path: KeyPath, rest: KeyPath) -> Any:
    """A number with an imaginary part, or a list of numbers with one in that at its place `rest`."""
    if isinstance(value, tuple) and len(rest) == 1 and isinstance(i := rest[0], int) and i < len(value):
        return (*value[:i], _with_step(value[i], path, ()), *value[i + 1 :])
    if rest or not is_number(value):
        raise InputError(f"{written(path)}: {shown(value)} is not a number; a derivative needs one")
    return complex(value, _STEP)


def _engine_of(model: Model, engine: Engine, chain: Chain | None) -> Engine:
    """The engine with the model of a chain with complex numbers; of a chain always by the chain's own numbers."""
    if model.chain is None:
        return engine
    arrays = {name: getattr(model.chain, name) for name in ("m", "h", "l", "I1", "I2", "I3")}
    rods, bodies = model.rods, model.bodies
    if chain is not None:
        columns = np.array([(*rod.properties, rod.length) for rod in chain.all_rods]).T
        arrays = dict(zip(("m", "h", "I1", "I2", "I3", "l"), columns, strict=True))
        rods = tuple(replace(old, inertia=rod.properties) for old, rod in zip(rods, chain.all_rods, strict=True))
        bodies = chain_bodies(chain.all_rods, [body.link for body in bodies])
    changed: Any = replace(model, make_pin=None, rods=rods, bodies=bodies)
    object.__setattr__(changed, "chain", SimpleNamespace(n=model.chain.n, **arrays))
    return LongChain(changed, engine.loads)
