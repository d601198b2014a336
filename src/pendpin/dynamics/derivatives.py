"""Exact derivatives of a scene's motion, in machine code: of accelerations by positions, rates and numbers of the scene.

The equations are those of the run on angles, recorded on a tape and differentiated there operation by operation
(engines/machine/tangents.py): no finite differences, no second formula. Friction and stops are left out: they act at events.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pendpin.dynamics.as_written import expand_as_written
from pendpin.dynamics.binding import Binding
from pendpin.dynamics.binding.contacts import bind_contacts
from pendpin.dynamics.compiling import differentiate_equations
from pendpin.dynamics.contacts import Contacts
from pendpin.dynamics.dynamics import choose_engine
from pendpin.dynamics.symbols import records_by_rod
from pendpin.dynamics.varied import vary
from pendpin.effects import ContactEffect, Effect, Idle
from pendpin.engines import AngleEngine
from pendpin.engines.machine.code import Block
from pendpin.equations.chain.angles import POLE
from pendpin.errors import InputError
from pendpin.ground.arrays import Array
from pendpin.model.build import Model, build
from pendpin.scene import Scene


class Jacobian(NamedTuple):
    """Accelerations q'' at a state, and their derivatives."""

    acceleration: Array  # (nv,)
    of_q: Array  # (nv, nv), 1/s²
    of_v: Array  # (nv, nv), 1/s


class Variational:
    """y' = f(t, y) of the state y = (q, v), with the derivatives of f in some directions, as machine code.

    A direction is that of one number of the scene, by its key path: the state of its equations is (y, w_1, ..., w_K),
    w_k = dy/d(number k), and w_k' = df/dy w_k + df/d(number k). Without keys there is one direction, that of a change w of
    the state itself. Times are since the scene's start, in s. Use one in each thread.

    Friction and stops are left out: they act at events. `contacts` keeps friction, between two events: `self.contacts` then
    says what is held. The places `still` of the state (2 nv,) are 0.

    Raises InputError for effects without derivatives, for keys that are not numbers of the scene, and MissingLibrary
    without llvmlite.
    """

    def __init__(
        self, scene: Scene, keys: Sequence[str] = (), contacts: bool = False, still: tuple[int, ...] = ()
    ) -> None:
        self.model = build(scene.model)
        self.keys, self.scene = tuple(keys), scene
        effects, start = differentiable(scene, contacts), scene.start.time
        engine = choose_engine(self.model, Binding(self.model, effects, start=start).loads, "auto", "angles")
        touching = any(isinstance(effect, ContactEffect) for effect in effects)
        by_rod = not still and not touching and records_by_rod(engine, effects)
        self.variation = vary(scene.model_copy(update={"effects": effects}), engine, keys, by_rod)
        self.block: Block = differentiate_equations(
            self.variation, start, by_rod, still
        )  # its state is (y, w_1, ..., w_K)
        self.contacts: Contacts | None = None
        if touching and isinstance(engine, AngleEngine):
            bound = bind_contacts(self.model, self.variation.effects, engine)
            moving = np.isin(np.arange(len(bound.static)), still, invert=True)
            self.contacts = replace(bound, static=bound.static * moving, block=self.block)
        self.starts: Array = self.variation.start  # (K, 2 nv), of the start's (q, v) by the numbers
        self.nv = len(self.model.joints)

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
    """The effects of a scene, with `Idle` in place of friction and stops unless `contacts` are kept.

    Raises InputError for one that does not run on symbols.
    """
    acts = expand_as_written(build(scene.model), scene.effects)
    for i, effect in enumerate(acts):
        if not effect.symbolic:
            raise InputError(f"effects[{i}]: {effect.kind} has no derivative: its law takes plain floats only")
    return tuple(Idle(kind=e.kind) if isinstance(e, ContactEffect) and not contacts else e for e in acts)
