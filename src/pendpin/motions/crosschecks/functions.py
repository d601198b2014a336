"""Functions that compute accelerations or reactions, compared with a scene: where they differ, and by what factor."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pendpin.dynamics.dynamics import bind
from pendpin.dynamics.dynamics import reactions as reactions_of
from pendpin.errors import InputError, not_one_of, one_line, shown
from pendpin.ground.arrays import Array
from pendpin.ground.report import Report, Result
from pendpin.scene import Scene
from pendpin.trajectory import Reactions
from pendpin.trajectory.columns import WRENCH

STATES = 60
LARGEST_RATE = 3.0  # rad/s
BOUND = 1e-9  # relative to the largest value
PARTS = ("at rest", "one joint turning", "all joints turning")

Answer = dict[str, Array]  # quantities by name, the last axis of each with a number a joint or rod


@dataclass(frozen=True)
class Row:
    """One quantity at one joint or rod: its error relative to its size, and when it is wrong."""

    quantity: str
    place: str
    error: float
    words: str

    @property
    def ok(self) -> bool:
        """Whether the error is within the bound."""
        return self.error <= BOUND

    def __str__(self) -> str:
        what = f"{self.quantity} of {self.place}"
        return f"holds  {what}" if self.ok else f"fails  {what}: {self.words}"


@dataclass(frozen=True, repr=False)
class Comparison(Result):
    """What was compared, a row for each quantity and joint."""

    rows: tuple[Row, ...]

    @property
    def ok(self) -> bool:
        """Whether all agree."""
        return all(row.ok for row in self.rows)

    def report(self) -> Report:
        fault = None if self.ok else "the functions differ from the scene"
        return Report([str(row) for row in self.rows], [asdict(row) | {"ok": row.ok} for row in self.rows], fault)


def compare_functions(
    scene: Scene, accelerations: Callable[..., Any] | None, reactions: Callable[..., Any] | None
) -> Comparison:
    """Compare functions of (q, v), each (nv,) in model order, with the scene at random states (diagnose). InputError."""
    if accelerations is None and reactions is None:
        raise InputError("diagnose: give accelerations, reactions or both, functions of (q, v)")
    dynamics, random = bind(scene), np.random.default_rng(0)
    shape = STATES, len(dynamics.model.joints)
    q, v = random.uniform(-1.2, 1.2, shape), random.uniform(-LARGEST_RATE, LARGEST_RATE, shape)
    alone = np.where(np.arange(shape[1]) == np.arange(STATES)[:, None] % shape[1], v, 0.0)
    rates = np.array([np.zeros_like(v), alone, v])  # of no joint, of one at a time, of all
    # the scene's own quantities at all of these states
    states = np.broadcast_to(q, rates.shape).reshape(-1, shape[1])
    exact = dynamics.engine.evaluate(np.zeros(len(states)), states, rates.reshape(-1, shape[1]))
    of_rods = reactions_of(dynamics.model, states, exact.wrench)
    truth = {"acceleration": exact.acceleration} | dict(zip(WRENCH, np.moveaxis(exact.wrench, -1, 0), strict=True))
    truth |= {} if of_rods is None else of_rods._asdict()

    rows: list[Row] = []
    for what, function in (("accelerations", accelerations), ("reactions", reactions)):
        if function is None:
            continue
        answers = [[_answer(function, what, a, b) for a, b in zip(q, part, strict=True)] for part in rates]
        shapes = [{name: array.shape for name, array in answer.items()} for part in answers for answer in part]
        if any(shape != shapes[0] for shape in shapes):
            raise InputError("the function returns other names or shapes at other states")
        if not shapes[0]:
            raise InputError("reactions: the function returns no quantity")
        for name in shapes[0]:
            ours = np.array([[answer[name] for answer in part] for part in answers])  # (parts, states, places)
            if name not in truth:
                raise InputError("reactions: the scene has no universal joints; return the wrenches (joints, 6)")
            true = truth[name].reshape(*rates.shape[:2], -1)
            if ours.shape != true.shape:
                raise InputError(f"{what}: the function returns shape {ours.shape[2:]}, not {true.shape[2:]}")
            rods = tuple(f"rod_{i + 1}" for i in range(true.shape[2]))
            places = rods if name in Reactions._fields else dynamics.model.joints
            rows += [_compare_quantity(name, places, i, ours[..., i], true) for i in range(len(places))]
    return Comparison(tuple(rows))


def _answer(function: Callable[..., Any], what: str, q: Array, v: Array) -> Answer:
    """What a given function returns at angles q and rates v (nv,), by name. Raises InputError for what it raises."""
    if not callable(function):
        raise InputError(f"{what}: {shown(function)} is not a function of (q, v)")
    try:
        value = function(q.copy(), v.copy())
    except Exception as error:
        raised = f"{type(error).__name__}: {one_line(str(error))}"
        at = f"q = {shown(q.round(3).tolist())}, v = {shown(v.round(3).tolist())}"
        raise InputError(f"{what}: the function raises {raised}, at {at}") from None
    if what == "accelerations":
        return {"acceleration": _array(value, what)}
    if isinstance(value, Mapping):
        if unknown := [name for name in value if name not in Reactions._fields]:
            raise InputError(f"{what}: {not_one_of(unknown[0], Reactions._fields)}")
        return {name: _array(entry, f"{what}: {name}") for name, entry in value.items()}
    wrenches, shape = _array(value, what), (len(q), 6)
    if wrenches.shape != shape:
        raise InputError(f"{what}: the function returns shape {wrenches.shape}, not {shape} or a mapping of names")
    return dict(zip(WRENCH, wrenches.T, strict=True))


def _array(value: Any, what: str) -> Array:
    """A returned value as real numbers. Raises InputError."""
    try:
        array = np.asarray(value)
        if value is None or np.any(np.imag(array)):
            raise TypeError
        return np.asarray(np.real(array), float)
    except (TypeError, ValueError):
        raise InputError(f"{what}: {shown(value)} is not an array of numbers") from None


def _compare_quantity(quantity: str, places: tuple[str, ...], i: int, ours: Array, right: Array) -> Row:
    """How one quantity (parts, n) at place i differs from the true ones (parts, n, places)."""
    true = right[..., i]
    if not np.isfinite(ours).all():
        count = int((~np.isfinite(ours)).any(0).sum())
        return Row(quantity, places[i], np.inf, f"not a finite number at {count} of {STATES} states")
    size = float(np.abs(true).max()) or 1.0
    errors = np.abs(ours - true).max(1) / size
    if errors.max() <= BOUND:
        return Row(quantity, places[i], float(errors.max()), "")
    first = int(np.argmax(errors > BOUND))
    words = [f"off by {errors.max():.2g} of its size, {'already' if first == 0 else 'only with'} {PARTS[first]}"]
    twins = (places[j] for j in range(len(places)) if np.abs(ours - right[..., j]).max() <= BOUND * size)
    words += [f"it is that of {twin}" for twin in twins][:1]
    rest, moving = (ours[0], true[0]), (ours[2] - ours[0], true[2] - true[0])
    for name, (one, other) in (("the part at rest", rest), ("the part that comes with the rates", moving)):
        largest = np.abs(other).max()
        factor = float(one @ other / (other @ other)) if largest > 0 else 1.0
        if abs(factor - 1) > BOUND and np.abs(one - factor * other).max() <= 1e-7 * largest:
            words.append(f"{name} is {factor:.6g} times what it should be")
    return Row(quantity, places[i], float(errors.max()), "; ".join(words))
