"""Joints that stick, slide and hit stops: holding torques, start of sliding, and impacts.

Every joint has a friction torque against sliding, a largest holding torque, limits and a restitution. A joint at rest is
held (rate exactly 0) as long as friction and stop can give the torque that this needs; the torques of all held joints are
computed together, from the columns of the inverse mass matrix. An impact follows Newton's law: the joints that hit a stop
reverse their rates, times the restitution, by impulses that may push and not pull.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.acting import chosen_joints, in_order
from pendpin.dynamics.parameters import Numbers
from pendpin.effects import ContactEffect, DryFriction, Effect
from pendpin.engines import AngleEngine
from pendpin.engines.machine.llvm import Block
from pendpin.errors import InputError, RunError, shown
from pendpin.ground.arrays import Array, Indices, Mask
from pendpin.model.build import Model
from pendpin.model.kinematics import scale

SHRINKS = 50.0  # a joint: exponent of the decay of the rates in a series of impacts, before its limit is taken
MOST_IMPACTS = 20_000  # at one time
PATIENCE = 10  # changes of several stops that do not help, before one at a time is changed, which always ends
ROUNDING = 1e-12  # of the torques: what a held joint may exceed its limits by
_OTHERS = 1e-2  # of the largest torque, for the joints on which smaller ones act
_LOOKS = 9  # times at which the loads are evaluated for the scales


class Scales(NamedTuple):
    """The scales of a run, with which small values are compared."""

    position: Array  # (nv,) 1 rad, or the length of the model for slides
    rate: Array  # (nv,) rad/s, m/s
    torque: Array  # (nv,) N m, N


class Mode(NamedTuple):
    """Which joints are held, and which way the others slide, from one event to the next."""

    held: Mask  # (nv,)
    sign: Array  # (nv,) -1 or 1, the way that a sliding joint slides; 0 where there is no friction
    torque: Array  # (nv,) N m, the size of the torques that act: what holding torques are rounded by

    @property
    def holds(self) -> bool:
        """Whether any joint is held."""
        return bool(np.count_nonzero(self.held))


@dataclass(frozen=True, eq=False)
class Contacts:
    """The dry friction and the stops of a scene, joint by joint, (nv,) each; effects on one joint add up."""

    engine: AngleEngine
    length: Array  # (nv,) 1 for joints that turn, m for slides: what a position is large or small against
    static: Array  # N m, what friction can hold
    lower: Array  # rad
    upper: Array  # rad
    restitution: Array  # (2, nv), at the lower and at the upper limit
    rubbing: tuple[tuple[Array, DryFriction], ...]  # what rubs, and 1 for each joint that it is on
    stopping: Array  # (2, nv) of text, the kind of effect that sets each limit
    block: Block | None = None  # of the equations with these contacts in machine code, if they are used

    def friction(self, v: Array, mode: Mode) -> Array:
        """The torques of sliding friction (..., nv) at rates v (..., nv)."""
        return sum((torque for _, torque in self.friction_by_kind(v, mode.sign)), np.zeros_like(v))

    def friction_by_kind(self, v: Array, sign: Array, xp: Any = np) -> list[tuple[str, Array]]:
        """The torques (..., nv) of each effect that rubs, with its kind, where joints slide in the ways `sign` (nv,)."""
        return [(effect.kind, 0.0 - share * effect.sliding(v, xp) * sign) for share, effect in self.rubbing]

    @cached_property
    def stops(self) -> bool:
        """Whether there are any."""
        return bool(np.isfinite([self.lower, self.upper]).any())

    @property
    def holding(self) -> Mask:
        """Which joints (nv,) friction or a stop can hold."""
        return (self.static > 0) | np.isfinite(self.lower) | np.isfinite(self.upper)

    def with_numbers(self, numbers: Numbers) -> "Contacts":
        """The contacts with the numbers of sliding friction mapped by `numbers`."""
        rubbing = ((numbers.per_rod(share), numbers.effect(effect)) for share, effect in self.rubbing)
        return replace(self, rubbing=tuple(rubbing))

    def accelerate(self, t: float, q: Array, v: Array, mode: Mode) -> tuple[Array, Array]:
        """Accelerations (nv,) and the torques (nv,) that hold the held joints."""
        if self.block:
            y = np.zeros((1, self.block.size))
            y[0, : 2 * len(q)] = np.concatenate([q, v])
            rates, holding = self._evaluated(np.array([t]), y, mode)
            return rates[0, len(q) : 2 * len(q)], holding[0]
        a = self.engine.accelerate(t, q, v, self.friction(v, mode))
        holding = np.zeros_like(a)
        if mode.holds:
            held = np.flatnonzero(mode.held)
            columns = self.engine.compliance(q, held)
            holding[held] = -np.linalg.solve(columns[held], a[held])
            a = a + columns @ holding[held]
            a[held] = 0.0
        return a, holding

    def hold(self, t: Array, y: Array, mode: Mode) -> Array:
        """The torques (n, nv) that hold the held joints, at times (n,) and states y (n, size), which begin with q, v."""
        nv = len(mode.held)
        if not mode.holds:
            return np.zeros((len(y), nv))
        if self.block:
            return self._evaluated(t, y, mode)[1]
        states = zip(t, y[:, :nv], y[:, nv : 2 * nv], strict=True)
        return np.array([self.accelerate(*state, mode)[1] for state in states]).reshape(-1, nv)

    def _evaluated(self, t: Array, y: Array, mode: Mode) -> tuple[Array, Array]:
        """y' (n, size) and holding torques (n, nv) in machine code."""
        assert self.block
        self.enter(mode)
        rates, holding = self.block.evaluated(t, y)
        return rates, holding[:, : len(mode.held)]  # their derivatives may follow (derivatives.py)

    def enter(self, mode: Mode) -> None:
        """Pass a mode to the equations in machine code."""
        assert self.block
        self.block.inputs[: len(mode.held)], self.block.inputs[len(mode.held) :] = mode.held, mode.sign

    def holding_range(self, q: Array) -> tuple[Array, Array]:
        """The least and the largest torque (nv,) that friction and stops can hold with, at positions q."""
        return np.where(q >= self.upper, -np.inf, -self.static), np.where(q <= self.lower, np.inf, self.static)

    def at_stops(self, q: Array) -> tuple[Indices, Array]:
        """The joints (k,) that are at their stops, and the ways (k,) in which these push, -1 or 1; at positions q (nv,)."""
        joints = ((q >= self.upper) | (q <= self.lower)).nonzero()[0]
        return joints, np.where(q[joints] >= self.upper[joints], -1.0, 1.0)

    def strike(self, q: Array, v: Array, t: float) -> Array:
        """The rates (nv,) after the impacts of all joints that move into their stops. RunError if these never end."""
        # Joints that kick each other may bounce without end, less and less. In the limit all that strike without end are at
        # rest relative to their stops. All impulses are theirs, so that one impact without restitution has the same result,
        # however many impacts came before it.
        joints, side = self.at_stops(q)
        if not (side * v[joints] < 0).any():
            return v
        columns, back = self.engine.compliance(q, joints), self.restitution[(side < 0).astype(int), joints]
        fastest = (self.length * np.abs(v)).max()
        # An impact shrinks the space of the rates by the factor `back`. A series ends because the rates turn in this space,
        # and those that turn shrink together: of 2 joints by sqrt(back) an impact. A later end leaves less than rounding.
        loss = 1.0 - float(back.max())
        most = MOST_IMPACTS if loss == 0 else int(min(MOST_IMPACTS, SHRINKS * (len(back) + 1) / loss))
        for _ in range(most):
            away = side * v[joints]
            if not (away < 0).any():
                return v
            if (self.length[joints] * away).min() >= -ROUNDING * fastest:
                break
            touching = away <= 0
            v = _strike_once(v, columns[:, touching], joints[touching], side[touching], back[touching])
        else:
            if (back == 1).all():
                raise RunError(f"{t:g} s after the start, simultaneous impacts on several stops do not end")
        return _strike_once(v, columns, joints, side, np.zeros(len(joints)))

    def rest(self, q: Array, v: Array, joints: Indices) -> Array:
        """The rates (nv,) after impulses on k joints (k,) that end their rates; the others follow by the mass matrix."""
        columns = self.engine.compliance(q, joints)
        after = v - columns @ np.linalg.solve(columns[joints], v[joints])
        after[joints] = 0.0
        return after

    def work_of_impacts(self, q: Array, before: Array, after: Array) -> dict[str, float]:
        """The work in J of the impulses by kind of effect, from the rates (nv,) before and after an impact."""
        joints, _ = self.at_stops(q)
        impulse = np.linalg.solve(self.engine.compliance(q, joints)[joints], (after - before)[joints])
        work = impulse * (before + after)[joints] / 2
        kinds = self.stopping[(q >= self.upper).astype(int), range(len(q))]
        return {kind: float(work[kinds[joints] == kind].sum()) for kind in dict.fromkeys(kinds[joints])}

    def choose(self, t: float, q: Array, v: Array, scales: Scales, loose: Array | float = 0.0) -> Mode:
        """Which joints at rest are held, and how the others start to slide; q, v (nv,). RunError if a search never ends."""
        # It starts with all joints held except those that have just come `loose` (nv,: their direction), and changes the
        # first joint that does not fit, one at a time: Murty's least-index rule, which ends for positive definite matrices
        # of held joints. If rounding errors prevent this, larger ones are allowed.
        resting = (v == 0) & ((self.static > 0) | (q >= self.upper) | (q <= self.lower))
        sign = np.where(self.static > 0, np.sign(v), 0.0)
        if not resting.any():
            return Mode(resting, sign, scales.torque)
        sign = np.where(resting, loose, sign)
        for rounding in (ROUNDING, 1e3 * ROUNDING, 1e6 * ROUNDING):
            held, sign = resting & (sign == 0), sign.copy()
            for _ in range(50 + 10 * len(q) ** 2):
                a, holding = self.accelerate(t, q, v, Mode(held, sign, scales.torque))
                # rounding is relative to the torques that act: those of other joints act on a joint too, compared per length
                size = scales.torque + np.abs(holding)
                size = size + _OTHERS * (size * self.length).max(initial=0.0) / self.length
                mode, (least, most), off = Mode(held, sign, size), self.holding_range(q), rounding * size
                unfit = held & ((holding > most + off) | (holding < least - off))
                # joints at rest that would start against their acceleration
                if (backwards := resting & ~held & (a * sign < 0)).any():
                    columns = np.abs(self.engine.compliance(q, np.flatnonzero(resting)))
                    unfit |= backwards & (a * sign < -rounding * (columns @ size[resting]))
                if not unfit.any():
                    return mode
                joint = int(np.argmax(unfit))
                held[joint] = not held[joint]
                sign[joint] = 0.0 if held[joint] else (-1.0 if holding[joint] > 0 else 1.0)
                if not held.any() and resting.sum() == 1:  # alone, it starts the way that it is pushed
                    return Mode(held, sign, mode.torque)
        raise RunError(f"{t:g} s after the start, the search for the joints that stick does not end")

    def scales(self, times: Array, q: Array, v: Array, varies: bool = True) -> Scales:
        """The scales of a run from q, v (nv,), from evaluations at some of its times (n,) if what acts `varies`."""
        nv, size = len(q), self.length
        columns = self.engine.compliance(q, np.arange(nv))
        # four directions of order one: every theta of a chain may be turned, and every phi; mirror images have the same four
        turned = np.array([[1, 1], [-1, 1], [1, -1], [-1, -1]])[:, np.arange(nv) % 2] * np.sin(1.0 + np.arange(nv))
        away, rest = turned * size, np.zeros(nv)
        looks = times[np.unique(np.linspace(0, len(times) - 1, _LOOKS if varies else 1).astype(int))]
        pushes = np.array([self.engine.accelerate(t, x, rest, rest) for t in looks for x in (q, *(q + away))])
        push = np.nan_to_num(np.abs(pushes)).max(0)
        square = max((push / size).max(), (np.abs(columns) @ self.static / size).max())
        span = float(times[-1] - times[0])
        rate = max(math.sqrt(square), float((np.abs(v) / size).max()), 1.0 / span if span else 0.0)
        return Scales(size, rate * size, self.static + (push + rate**2 * size) / np.diag(columns))


def _strike_once(v: Array, columns: Array, joints: Indices, side: Array, back: Array) -> Array:
    """The rates (nv,) after one simultaneous impact, from v (nv,): the stops push k joints to their sides (k,)."""
    # By impulses p >= 0, with the columns (nv, k) of the compliance. A joint that is pushed leaves with its rate before
    # times `back` (k,), the restitution; one that is not pushed, because the others carry it away, leaves faster.
    away = side * v[joints]
    bounce = back * np.maximum(-away, 0.0)
    impulse = _find_pushes(side[:, None] * columns[joints] * side, bounce - away)
    after = v + columns @ (side * impulse)
    after[joints] = side * np.where(impulse > 0, bounce, np.maximum(side * after[joints], bounce)) + 0.0
    return after


def _find_pushes(A: Array, b: Array) -> Array:
    """The p >= 0 (k,) with A p >= b for which only those rows are equal whose p is above 0; A (k, k) positive definite."""
    # Block principal pivoting: all that do not fit change, or one of them where that does not help (L. Portugal, J. Júdice,
    # L. Vicente, Math. Comp. 63 (1994), 625).
    unit = math.ldexp(1.0, math.frexp(np.diag(A).max())[1])  # a power of 2, so that the unit of mass changes no bit
    A = A / unit
    size = np.sqrt(np.diag(A))
    A, b = A / np.outer(size, size), b / size
    pushing, fewest, patience = np.ones(len(b), bool), len(b) + 1, PATIENCE
    for _ in range(50 + 10 * len(b) ** 2):
        p = np.zeros(len(b))
        if pushing.any():
            p[pushing] = np.linalg.solve(A[pushing][:, pushing], b[pushing])
        unfit = np.where(pushing, p < -ROUNDING * np.abs(p).max(), A @ p < b - ROUNDING * np.abs(b).max())
        count = int(unfit.sum())
        if not count:
            return np.maximum(p, 0.0) / (unit * size)
        fewest, patience = (count, PATIENCE) if count < fewest else (fewest, patience - 1)
        pushing ^= unfit if patience >= 0 else np.arange(len(b)) == np.flatnonzero(unfit)[-1]
    raise RunError("the search for the stops that push does not end")


def bind_contacts(model: Model, effects: Sequence[Effect], engine: AngleEngine) -> Contacts:
    """The contacts of a scene, joint by joint.

    Friction adds up. Of several limits on one side of a joint the tighter holds, with its own restitution; of equal ones
    that with the smaller restitution. Raises InputError for joints that are unknown or named twice, and for stops that
    leave a joint no room.
    """
    nv = len(model.joints)
    acts = [(effect, where) for effect, where in in_order(effects) if isinstance(effect, ContactEffect)]
    kind = np.result_type(float, *(x for effect, _ in acts for x in effect.resistance()))  # complex for derivatives.py
    static, rubbing = np.zeros(nv, kind), list[tuple[Array, DryFriction]]()
    reach, restitution = np.full((2, nv), np.inf), np.zeros((2, nv))  # reach: minus the lower limit, and the upper one
    kinds, places = np.full((2, nv), "", dtype=object), np.full((2, nv), "", dtype=object)
    for effect, where in acts:
        joints = chosen_joints(model, effect.joints, f"{where}.joints")
        static[joints] += effect.resistance()[1]
        if isinstance(effect, DryFriction):
            rubbing.append((np.isin(np.arange(nv), joints).astype(float), effect))
        low, high, back = effect.limits()
        for side, limit in enumerate((-low, high)):
            tighter = (limit < reach[side]) | ((limit == reach[side]) & (back < restitution[side]))
            at = np.intersect1d(joints, np.flatnonzero(tighter))
            reach[side, at], restitution[side, at], kinds[side, at], places[side, at] = limit, back, effect.kind, where
    lower, upper = -reach[0], reach[1]
    for joint in np.flatnonzero(lower >= upper):
        below, above = places[:, joint]
        apart = f"one keeps it above {lower[joint]:g}, the other below {upper[joint]:g}"
        raise InputError(f"{below} and {above}: their stops leave joint {shown(model.joints[joint])} no room: {apart}")
    lengths = np.where(model.slides, scale(model), 1.0)
    return Contacts(engine, lengths, static, lower, upper, restitution, tuple(rubbing), kinds)


def check_start(contacts: Contacts, model: Model, q: Array) -> None:
    """Raise InputError if positions q (nv,) are beyond a stop."""
    for name, x, low, high in zip(model.joints, q, contacts.lower, contacts.upper, strict=True):
        if not low <= x <= high:
            raise InputError(f"start.positions.{name}: {x:g} is beyond its stop at {low if x < low else high:g}")
