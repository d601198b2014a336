"""The effects of a scene that act, in a fixed order; the joints and links that they name; the law of each."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from pydantic import PrivateAttr

from pendpin import effects as fx
from pendpin.dynamics.parameters import GIVEN, Numbers
from pendpin.effects.base import returned
from pendpin.effects.pace import Pace
from pendpin.errors import InputError, shown
from pendpin.ground.arrays import EPS, Array, Indices
from pendpin.model.bodies import WrittenJoint
from pendpin.model.build import Model

MOST = 5_000_000  # instants of a run: 40 MB for each joint
NEAR = 2 * EPS  # of a time: closer to an instant it is at it. Steps end twice as far from corners (runs/integration.py)


class HeldTorque(fx.Torque):
    """A Torque with `every` in the dynamics of one run. Before the run it is the function itself.

    During the run it is what was sampled last; afterwards, for accelerations and work at the samples, the recorded output.
    """

    _effect: fx.Torque = PrivateAttr()
    _interval: float = PrivateAttr()  # s
    _joints: Indices = PrivateAttr()
    _start: float = PrivateAttr()  # s
    _given: int = PrivateAttr(0)  # outputs that an earlier run has recorded: they are not computed again
    _values: Array | None = PrivateAttr(None)  # (m, k) N m, at the instants; 0 where they are not known yet
    _current: Array | None = PrivateAttr(None)  # (k,) N m, during an integration

    @classmethod
    def of(cls, effect: fx.Torque, joints: Indices, start: float) -> "HeldTorque":
        """The effect on the joints (k,), by their indices in the model, for runs from `start` in s."""
        held = cls.model_construct(**effect.given())
        assert effect.every is not None
        held._effect, held._joints, held._interval, held._start = effect, joints, effect.every, start
        return held

    def since(self, start: float) -> tuple[fx.Effect, float]:
        """Its instants are counted from the start of a run."""
        return self, 0.0

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """A corner at every instant; between them nothing changes. Raises InputError for too many instants."""
        if end / self._interval > MOST:
            raise InputError(f"torque: every = {self._interval:g} s makes over {MOST:,} instants in {end:g} s")
        corners = self._interval * np.arange(1, self._place(end) + 1)
        corners = corners[corners < end * (1 - NEAR)]
        return Pace(corners, np.full(len(corners) + 1, np.inf))

    def torques(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """What is held at the moment, or was at time t, (k,) N m; before a run what the function returns."""
        if self._current is not None:
            return self._current.copy()
        if self._values is None:
            return self._effect.torques(self._start + t, q, v)
        return self._values[self._place(t)].copy()

    def begin(self, start: float, end: float, recorded: Array | None = None) -> None:
        """Make room for a run from `start` to `end` s since then, with outputs (m, k). InputError for other joints'."""
        self._start, room = start, np.zeros((self._place(end) + 1, len(self._joints)))
        given = room[:0] if recorded is None else recorded[: len(room)]
        if given.shape[1:] != room.shape[1:]:
            raise InputError(f"the run's outputs of a torque are of {given.shape[1:]} joints, not {room.shape[1:]}")
        room[: len(given)] = given
        self._given, self._values, self._current = len(given), room, None

    def is_instant(self, t: float) -> bool:
        """Whether t, in s since the start, is an instant but for its rounding."""
        return abs(t - self._interval * self._place(t)) <= NEAR * (abs(self._start) + abs(t))

    def sample(self, t: float, q: Array, v: Array) -> None:
        """Hold what the function returns at the instant t, in s since the start, from q, v (nv,); or what was given."""
        place = self._place(t)
        if place >= self._given:
            instant = self._start + self._interval * place
            self.record[place] = self._effect.torques(instant, q[self._joints], v[self._joints])
        self._current = self.record[place]

    def recall(self, t: float, values: Array) -> None:
        """Go on from t, in s since the start, with the outputs (m, k) up to there."""
        if values is not self.record:  # which a long run would copy at every segment
            self.record[:] = values
        self._current = self.record[self._place(t)]

    def finish(self) -> None:
        """The integration is over: from now on the record answers by time."""
        self._current = None

    @property
    def record(self) -> Array:
        """The outputs (m, k) in N m at all instants of the run; the array itself, in which a run writes."""
        assert self._values is not None
        return self._values

    def until(self, t: float) -> Array:
        """The outputs (m, k) in N m up to t in s since the start, and those that were given."""
        return self.record[: max(self._given, self._place(t) + 1)].copy()

    @property
    def recorded(self) -> bool:
        """Whether a run has begun."""
        return self._values is not None

    def _place(self, t: float) -> int:
        """Which instant is the last one at t in s since the start."""
        place = int(t / self._interval)
        return place + 1 if self._interval * (place + 1) - t <= NEAR * (abs(self._start) + abs(t)) else place


def recall_outputs(held: Sequence[HeldTorque], run: Any, end: float, start: float) -> None:
    """Give sampled torques the outputs of a run, for a motion to `end` in s since `start`. InputError if it had others."""
    if len(held) != len(run.held):
        raise InputError(f"this run has outputs of {len(run.held)} sampled torques, and its scene has {len(held)}")
    for one, outputs in zip(held, run.held, strict=True):
        one.begin(start, end, outputs)


def acting(model: Model, effects: Sequence[fx.Effect], start: float = 0.0) -> tuple[fx.Effect, ...]:
    """The effects of a scene, with `Idle` in place of each of strength 0: these change no bit of a run.

    In place of an as_written there is what it stands for, in place of a sampled Torque one that can hold, from `start` in s
    on. Raises InputError for a joint or link that the model lacks, whatever the strength.
    """
    acts = list(expand_as_written(model, effects))
    for i, effect in enumerate(acts):
        where = f"effects[{i}]"
        if isinstance(effect, fx.Drag) and any(body.payload_radius for body in model.bodies):
            acts[i] = effect = effect.model_copy(update={"payload_coefficient": effect.payload_coefficient})
        if isinstance(effect, fx.Torque) and effect.every is not None:
            acts[i] = HeldTorque.of(effect, chosen_joints(model, effect.on, where), start)
        elif effect.idle:
            if isinstance(effect, fx.JointEffect | fx.ContactEffect):
                chosen_joints(model, effect.on, where)
            elif isinstance(effect, fx.BodyEffect):
                chosen_bodies(model, effect.on, where)
            acts[i] = fx.Idle(kind=effect.kind)
        if isinstance(effect, fx.Anchor) and effect.at is not None:
            length = float(np.linalg.norm(model.bodies[chosen_bodies(model, effect.on, where)[0]].tip))
            if not 0 <= np.real(effect.at) <= length * (1 + 10 * EPS):
                raise InputError(f"{where}.at: {effect.at:g} m is beyond the ends of {effect.link}, 0 to {length:g} m")
    return tuple(acts)


def in_order(effects: Sequence[fx.Effect]) -> list[tuple[fx.Effect, str]]:
    """The effects that act, with their key paths, in an order that does not depend on that of the list.

    It is that of the names of their classes, then of the numbers in their fields, as text. Every sum over effects uses this
    order, so that the order of a scene's list changes no bit: without it the 24 orders of gravity, viscous, spring and motor
    on two rods gave four motions, 1.3e-8 rad apart after 30 s at tolerance 1e-10.
    """
    acts = [(effect, f"effects[{i}]") for i, effect in enumerate(effects) if not isinstance(effect, fx.Idle)]

    def text(value: Any) -> str:
        if isinstance(value, tuple):
            return f"({', '.join(map(text, value))})"
        # a number that derivatives.py makes complex has the place of the real one
        return repr(value.real) if isinstance(value, complex) else repr(value)

    names = [type(effect).__name__ for effect, _ in acts]
    apart = len(set(names)) == len(names)  # the numbers decide nothing

    def place(pair: tuple[fx.Effect, str]) -> list[str]:
        kind = type(pair[0])
        return [kind.__name__, *(() if apart else (text(getattr(pair[0], name)) for name in kind.model_fields))]

    return sorted(acts, key=place)


def chosen_joints(model: Model, names: Sequence[str] | None, where: str) -> Indices:
    """The indices (k,) of joints in model order, of all if None. Raises InputError for one unknown or given twice."""
    if names is None:
        return np.arange(len(model.joints))
    chosen = [model.index(name, where) for name in names]
    if len(set(chosen)) < len(chosen):
        raise InputError(f"{where}: a joint is named twice: {', '.join(map(shown, names))}")
    return np.array(chosen, dtype=np.intp)


def chosen_bodies(model: Model, names: Sequence[str] | None, where: str) -> Indices:
    """The indices (k,) of links among the bodies, all if None; a single rod may be called rod_1. Raises InputError."""
    if names is None:
        return np.arange(len(model.bodies))
    links = tuple(body.link for body in model.bodies)
    pin: Any = None if model.written is None else model.pin
    for name in names:
        if pin is not None and name not in links and pin.existBodyName(name):  # fixed to another, or massless
            above = pin.frames[pin.getBodyId(name)].parentJoint - 1
            of = [shown(body.link) for body in model.bodies if body.joint == above]
            still = "has no mass" if above >= 0 else "does not move"
            raise InputError(f"{where}: link {shown(name)} {f'is fixed to {of[0]}: name that link' if of else still}")
    return np.array([model.body(name, where) for name in names], dtype=np.intp)


def plain_arithmetic(effects: Sequence[fx.Effect]) -> bool:
    """Whether the effects are pendpin's own and run on symbols: they then take many states at once too."""
    return built_in(effects) and all(effect.symbolic for effect in effects)


def built_in(effects: Sequence[fx.Effect]) -> bool:
    """Whether all laws are pendpin's own. Of a user's law we do not know whether it runs on symbols or jumps."""
    # What is held from instant to instant jumps nowhere else.
    are_ours = (type(effect).__module__.startswith("pendpin.") for effect in effects)
    return all(are_ours) and not any(isinstance(effect, fx.Torque) and effect.every is None for effect in effects)


def law(effect: fx.Effect, name: str, numbers: Numbers = GIVEN) -> Callable[..., Any]:
    """A method of an effect, by its name. That of a user's own class gets copies, and what it returns is checked."""
    method = partial(getattr(numbers.effect(effect), name), xp=numbers.xp)
    if type(effect).__module__.startswith("pendpin."):
        return method
    what, kind = f"effects: {effect.kind}: its {name}", float if numbers.xp is np else object

    def checked(t: Any, *state: Any) -> Any:
        output = method(t, *map(_copy, state))
        if name != "wrench":
            return returned(what, output, state[0].shape if state else (3,), kind)
        if not isinstance(output, tuple | list) or len(output) != 2:
            raise InputError(f"{what} returned {shown(output)}, where a force and a moment are wanted")
        return tuple(returned(what, part, state[0].com.shape, kind) for part in output)

    return checked


def _copy(part: Any) -> Any:
    """A copy of an array, or of each array in bodies or a motion: a law that works in place changes no state."""
    if isinstance(part, fx.Bodies | fx.Motion):
        return part._make(map(_copy, part))
    return part.copy() if isinstance(part, np.ndarray) else part


def expand_as_written(model: Model, effects: Sequence[fx.Effect]) -> tuple[fx.Effect, ...]:
    """The effects with those that an as_written stands for: the damping, friction and limits that its URDF writes.

    There is one for each number, or pair of limits, that some of the joints share. The first of them takes its place, the
    others come at the end: every other effect keeps its place in the list. Raises InputError where the model has no file
    that could have written any.
    """
    out, more = list(effects), list[fx.Effect]()
    for i, effect in enumerate(effects):
        if not isinstance(effect, fx.AsWritten):
            continue
        if model.written is None:
            raise InputError(f"effects[{i}]: as_written is for a URDF; this model has no <dynamics> and no <limit>")
        laws: list[tuple[bool, type[fx.Effect], Callable[[WrittenJoint], dict[str, float]]]] = [
            (effect.damping, fx.Viscous, lambda joint: {"coefficient": joint.damping}),
            (effect.friction, fx.DryFriction, lambda joint: {"kinetic": joint.friction}),
            (effect.limits, fx.Stop, lambda joint: {"lower": joint.lower, "upper": joint.upper}),
        ]
        written = list[fx.Effect]()
        for acts, kind, says in laws:
            names = dict[tuple[tuple[str, float], ...], list[str]]()  # of the joints, by their numbers
            for joint in model.written if acts else ():
                finite = [(name, x) for name, x in says(joint).items() if math.isfinite(x)]
                numbers = tuple((name, x) for name, x in finite if x or kind is fx.Stop)
                if numbers:
                    names.setdefault(numbers, []).append(joint.name)
            written += [kind(**dict(numbers), joints=some) for numbers, some in names.items()]
        out[i], *rest = written or [fx.Idle(kind=effect.kind)]
        more += rest
    return (*out, *more)
