"""Functions that compute accelerations or reactions, compared with a scene: where they differ, and by what factor."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.dynamics import Dynamics, bind
from pendpin.dynamics.dynamics import reactions as reactions_of
from pendpin.errors import InputError, brief, not_one_of, shown
from pendpin.scene import Scene

STATES = 60
LARGEST_RATE = 3.0  # rad/s
BOUND = 1e-9  # relative to the largest value
PARTS = ("at rest", "one joint turning", "all joints turning")


@dataclass(frozen=True)
class Row:
    """One quantity at one joint or rod: its error relative to its size, and when it is wrong."""

    quantity: str
    place: str
    error: float
    words: str

    @property
    def ok(self) -> bool:
        """Whether it agrees."""
        return self.error <= BOUND


@dataclass(frozen=True, repr=False)
class Comparison:
    """What was compared, a row for each quantity and joint."""

    rows: tuple[Row, ...]

    @property
    def ok(self) -> bool:
        """Whether all agree."""
        return all(row.ok for row in self.rows)

    def __repr__(self) -> str:
        return brief(f"Comparison: {str(self).replace(chr(10), '; ')}")

    def __str__(self) -> str:
        """The report as text."""
        lines = [
            f"{'holds' if row.ok else 'fails'}  {row.quantity} of {row.place}" + ("" if row.ok else f": {row.words}")
            for row in self.rows
        ]
        return "\n".join(lines)


Function = Callable[..., Any]


def compare(scene: Scene, accelerations: Function | None, reactions: Function | None) -> Comparison:
    """Compare functions of (q, v), each (nv,) in model order, with the scene at random states.

    `accelerations` returns (nv,). `reactions` returns a mapping with any of R1, R2, R3, M3, Mc to (rods,) of a chain, or
    the wrenches (joints, 6), force then moment, as in docs/derivation.md. Raises InputError for anything else.
    """
    if accelerations is None and reactions is None:
        raise InputError("diagnose: give accelerations, reactions or both, functions of (q, v)")
    dynamics = bind(scene)
    rows: list[Row] = []
    if accelerations is not None:
        truth = {"acceleration": lambda q, v: dynamics.acceleration(scene.start.time, q, v)}
        rows += _rows(truth, {"acceleration": accelerations}, dynamics, dynamics.model.joints, "accelerations")
    if reactions is not None:
        rows += _reaction_rows(dynamics, reactions, scene)
    return Comparison(tuple(rows))


def _reaction_rows(dynamics: Dynamics, reactions: Function, scene: Scene) -> list[Row]:
    nv = len(dynamics.model.joints)
    sample = reactions(np.full(nv, 0.1), np.full(nv, 0.1))
    wrenches = lambda q, v: dynamics.wrenches(scene.start.time, q, v)  # noqa: E731
    if not isinstance(sample, Mapping):
        names = dynamics.model.joints
        parts = [f"{axis}" for axis in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
        truth = {part: (lambda q, v, i=i: np.asarray(wrenches(q, v))[..., i]) for i, part in enumerate(parts)}
        given = {part: (lambda q, v, i=i: np.asarray(reactions(q, v), float)[..., i]) for i, part in enumerate(parts)}
        return _rows(truth, given, dynamics, names, "reactions")
    allowed = ("R1", "R2", "R3", "M3", "Mc")
    if unknown := [name for name in sample if name not in allowed]:
        raise InputError(f"reactions: {not_one_of(unknown[0], allowed)}")

    def true(name: str) -> Function:
        def value(q: Array, v: Array) -> Array:
            found = reactions_of(dynamics.model, q[None], np.asarray(wrenches(q, v))[None])
            if found is None:
                raise InputError("reactions: the scene has no universal joints; return the wrenches (joints, 6)")
            return getattr(found, name)[0]

        return value

    rods = tuple(f"rod_{i + 1}" for i in range(len(dynamics.model.bodies)))
    given = {name: (lambda q, v, name=name: np.asarray(reactions(q, v)[name], float)) for name in sample}
    return _rows({name: true(name) for name in sample}, given, dynamics, rods, "reactions")


def _rows(
    truth: Mapping[str, Function], given: Mapping[str, Function], dynamics: Dynamics, places: tuple[str, ...], what: str
) -> list[Row]:
    """A row for each quantity and place."""
    q, v = _states(len(dynamics.model.joints))
    rows = []
    for name in truth:
        right = {part: np.array([truth[name](a, b) for a, b in zip(q, v[part], strict=True)]) for part in PARTS}
        ours = {
            part: np.array([_checked(given[name](a, b), right[part][0], what) for a, b in zip(q, v[part], strict=True)])
            for part in PARTS
        }
        for i, place in enumerate(places):
            rows.append(
                _row(
                    name,
                    place,
                    *({part: np.atleast_2d(values[part])[:, i] for part in PARTS} for values in (ours, right)),
                )
            )
    return rows


def _states(nv: int) -> tuple[Array, dict[str, Array]]:
    """Random angles (n, nv), and rates: none, of one joint at a time, of all."""
    random = np.random.default_rng(0)
    q, v = random.uniform(-1.2, 1.2, (STATES, nv)), random.uniform(-LARGEST_RATE, LARGEST_RATE, (STATES, nv))
    alone = np.zeros_like(v)
    alone[np.arange(STATES), np.arange(STATES) % nv] = v[np.arange(STATES), np.arange(STATES) % nv]
    return q, dict(zip(PARTS, (np.zeros_like(v), alone, v), strict=True))


def _checked(value: Any, like: Array, what: str) -> Array:
    """What a function returned as an array of the shape of `like` (nv,) or (rods,). Raises InputError."""
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        raise InputError(f"{what}: {shown(value)} is not an array of numbers") from None
    if array.shape != np.shape(like):
        raise InputError(f"{what}: the function returns shape {array.shape}, not {np.shape(like)}")
    return array


def _row(quantity: str, place: str, ours: dict[str, Array], right: dict[str, Array]) -> Row:
    """The error of one quantity, when it appears, and the factor that its parts are off by; arrays (n,) by part."""
    size = max(float(np.abs(values).max()) for values in right.values()) or 1.0
    errors = {part: float(np.abs(ours[part] - right[part]).max()) / size for part in PARTS}
    worst = max(np.inf if np.isnan(error) else error for error in errors.values())
    first = next((part for part in PARTS if not errors[part] <= BOUND), "")
    words = [f"off by {worst:.2g} of its size, {'already ' if first == 'at rest' else 'only with '}{first}"]
    parts = {
        "the part at rest": (ours["at rest"], right["at rest"]),
        "the part that comes with the rates": (ours[PARTS[2]] - ours["at rest"], right[PARTS[2]] - right["at rest"]),
    }
    for name, (a, b) in parts.items():
        factor = _factor(a, b)
        if factor is not None and abs(factor - 1) > BOUND:
            words.append(f"{name} is {factor:.6g} times what it should be")
    return Row(quantity, place, worst, "; ".join(words))


def _factor(ours: Array, right: Array) -> float | None:
    """The constant that one array (n,) is of the other, or None."""
    if not np.abs(right).max() > 0:
        return None
    factor = float(ours @ right / (right @ right))
    return factor if np.abs(ours - factor * right).max() <= 1e-7 * np.abs(right).max() else None
