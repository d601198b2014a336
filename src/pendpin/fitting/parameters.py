"""The free numbers of a scene, named by their key paths, and the coordinates in which the search moves them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, get_args

import annotated_types
import numpy as np

from pendpin.effects import DryFriction
from pendpin.errors import InputError, amount, is_number, not_one_of, shown
from pendpin.fitting.uncertainty import Certainty
from pendpin.ground.arguments import parsed
from pendpin.ground.arrays import Array, ArrayLike
from pendpin.ground.records import Record
from pendpin.scene import Chain, Rod, Scene

_MOMENTS = np.ones((3, 3)) - np.eye(3)  # I = _MOMENTS S with S the second moments of mass along b1, b2, b3
_LEAST = 1e-6  # of the guess of a positive number
_NEGLIGIBLE = 1e-9  # of the largest second moment: the rod is thin


@dataclass(frozen=True, eq=False)
class Free:
    """Free numbers, transform x(z), of search coordinates z (nz,) within bounds; x is exp(z) where it is positive, else z.

    A rod's three inertias move through its second moments of mass, none of them negative, so that a real body has
    them; a static friction moves through its excess over the kinetic one.
    """

    keys: tuple[str, ...]  # K key paths of single numbers
    guess: Array  # (K,)
    transform: Array  # (K, nz)
    positive: Array  # (nz,) whether a coordinate is the logarithm
    start: Array  # (nz,)
    lower: Array  # (nz,)
    upper: Array  # (nz,)

    def values(self, z: Array) -> Array:
        """The numbers (K,) at search coordinates (nz,)."""
        # not the guess and a difference: by rounding static might fall below kinetic friction
        return self.transform @ np.where(self.positive, np.exp(np.where(self.positive, z, 0.0)), z)

    @property
    def is_stribeck_speed(self) -> Array:
        """Whether a coordinate (nz,) is a Stribeck speed, which only whole swings tell from friction at rest."""
        return np.asarray(self.transform[[key.endswith(".stribeck") for key in self.keys]].any(0))

    def dissipation(self, scene: Scene) -> Array:
        """Whether a coordinate (nz,) is that of a friction or a drag."""
        places = {i for i, effect in enumerate(scene.effects) if effect.resistances}
        rows = [home == "effects" and place in places for home, place, _, _ in map(_parse, self.keys)]
        return np.asarray(self.transform[rows].any(0))

    def gradients(self, z: Array) -> Array:
        """The derivatives (K, nz) of the numbers by the search coordinates."""
        with np.errstate(over="ignore"):  # of a model that is far off
            return self.transform * np.where(self.positive, np.exp(z), 1.0)


def free_parameters(scene: Scene, free: str | Sequence[str]) -> Free:
    """The free numbers that key paths, "physics" and "friction" name. Raises InputError for a key that a fit cannot free."""
    texts = [free] if isinstance(free, str) else free
    if not isinstance(texts, Sequence) or not all(isinstance(text, str) for text in texts):
        raise InputError(f"free: {shown(free)} is neither a key path nor a list of them")
    keys = _expand(scene, texts)
    guess = []
    for key in keys:
        if not is_number(value := _value(scene, key)):
            raise InputError(f"free: {key}: {shown(value)} is not a number")
        guess.append(float(value))
    guess = np.array(guess)
    columns, positive, start, lower, upper = [], [], [], [], []
    for rows, matrix, first, low, high in _groups(scene, keys, guess):
        guess[rows] = matrix @ np.asarray(first)  # of a body that cannot be, one that can
        for column, z, least, most in zip(matrix.T, first, low, high, strict=True):
            full = np.zeros(len(keys))
            full[rows] = column
            columns.append(full)
            positive.append(0 < least <= _LEAST * z and most == np.inf)  # not a static friction, which has a floor
            start.append(np.log(z) if positive[-1] else z)
            lower.append(-np.inf if positive[-1] else least)
            upper.append(most)
    transform = np.array(columns).T.reshape(len(keys), len(columns))
    return Free(tuple(keys), guess, transform, *map(np.array, (positive, start, lower, upper)))


def substitute(scene: Scene, keys: Sequence[str], values: ArrayLike, checked: bool = True) -> Scene:
    """The scene with other numbers (K,) at K key paths; if not `checked` even such as it refuses. Raises InputError."""

    def change(record: Record, changes: dict[str, Any]) -> Any:
        if checked:
            return type(record)(**(record.given() | changes))
        fields = {name: getattr(record, name) for name in type(record).model_fields}
        return type(record).model_construct(**(fields | changes))

    rods, effects = list(scene.model.rods) if isinstance(scene.model, Chain) else [], list(scene.effects)
    changes: dict[tuple[str, int], dict[str, Any]] = {}
    for key, value in zip(keys, np.asarray(values).tolist(), strict=True):
        home, place, name, part = _parse(key)
        fields = changes.setdefault((home, place), {})
        if part is None:
            fields[name] = value
        else:
            record = rods[place] if home == "model.rods" else effects[place]
            fields.setdefault(name, list(_field(record, name)))[part] = value
    for (home, place), fields in changes.items():
        records = rods if home == "model.rods" else effects
        fields = {name: tuple(value) if isinstance(value, list) else value for name, value in fields.items()}
        records[place] = change(records[place], fields)
    model = change(scene.model, {"rods": tuple(rods)}) if rods else scene.model
    return change(scene, {"model": model, "effects": tuple(effects)})


# --- what free swings tell where they do not tell the numbers themselves: ratios to the first moment of the last rod ---


class Combination(NamedTuple):
    """A determined function of free numbers that are not determined themselves."""

    name: str
    value: float
    error: float | None  # standard error; None where the fit gives none
    unit: str

    def __str__(self) -> str:
        error = "" if self.error is None else f" +- {self.error:.2g}"
        return f"{self.name} = {self.value:.6g}{error} {self.unit}".rstrip()


def combinations(scene: Scene, free: Free, z: Array, certainty: Certainty, unsure: set[str]) -> tuple[Combination, ...]:
    """The ratios of a chain that the data determine, of those with an undetermined number; z (nz,)."""
    if not isinstance(scene.model, Chain) or not scene.model.tip_to_tip or not unsure:
        return ()
    last, names = scene.model.count - 1, list[tuple[str, str]]()
    for i in range(last + 1):
        of = f"rod {i + 1}" + " with all below" * (i < last)
        names.append((f"inertia of {of} about its joint / first moment of {of}", "m"))
        if i < last:
            names.append((f"first moment of {of} / first moment of rod {last + 1}", ""))
    torques = [row for row, key in enumerate(free.keys) if key.startswith("effects") and key in unsure]
    names += [(f"{free.keys[row]} / first moment of rod {last + 1}", "") for row in torques]

    def ratios(values: Array) -> Array:  # those of the names at the free numbers (K,)
        chain: Any = substitute(scene, free.keys, values, checked=False).model
        below, inertia, first = 0.0, [], []
        for rod in reversed(chain.all_rods):  # about its joint, kg m², and first, kg m, with what hangs on it
            m, h, I1, _, _ = rod.properties
            inertia.insert(0, I1 + m * h * h + below * rod.length**2)
            first.insert(0, m * h + below * rod.length)
            below += m
        pairs = ([J / k, k / first[last]] for J, k in zip(inertia, first, strict=True))
        return np.array([x for pair in pairs for x in pair][:-1] + [values[row] / first[last] for row in torques])

    values, determined = free.values(z), list[Combination]()
    steps = np.diag(1e-6 * np.where(values != 0, np.abs(values), 1.0))  # of central differences
    slopes = np.array([(ratios(values + d) - ratios(values - d)) / (2 * d.sum()) for d in steps]).T
    gradients = np.pad(slopes @ free.gradients(z), ((0, 0), (0, len(certainty.scale) - len(z))))
    for (name, unit), value, gradient in zip(names, ratios(values), gradients, strict=True):
        if certainty.determined(gradient):
            error = certainty.error(gradient) if certainty.enough else None
            determined.append(Combination(name, float(value), error, unit))
    return tuple(determined)


def _parse(key: str) -> tuple[str, int, str, int | None]:
    """The home of a free number, rods or effects, the place there, the field, and the place in that, if it is a list."""
    match parsed(key):
        case ("model", "rods", int(place), str(name)):
            return "model.rods", place, name, None
        case ("model", "rods", int(place), str(name), int(part)):
            return "model.rods", place, name, part
        case ("effects", int(place), str(name)):
            return "effects", place, name, None
        case ("effects", int(place), str(name), int(part)):
            return "effects", place, name, part
    such = 'such as model.rods[0].com or effects[1].coefficient, nor "physics" or "friction"'
    raise InputError(f"free: {shown(key)} is not a number of a rod or an effect, {such}")


def _expand(scene: Scene, texts: Sequence[str]) -> list[str]:
    """Key paths of single numbers, each once, in the order given."""
    keys, model = list[str](), scene.model
    torques = [f"effects[{i}].{name}" for i, effect in enumerate(scene.effects) for name in effect.resistances]
    bodies: list[str] = []
    if isinstance(model, Chain):  # a rod's motion shows its length where another hangs there
        bodies = [f"model.rods[{i}].{name}" for i in range(len(model.rods)) for name in ("com", "inertia")]
        bodies += [f"model.rods[{i}].length" for i in model.bearing]
    short_forms = {"physics": bodies + torques, "friction": torques}
    for key in (key.strip() for text in texts for key in text.split(",")):
        if not (names := short_forms.get(key, [key])):
            raise InputError(f'free: "{key}": the scene has no rods, friction or drag that could be free')
        for name in names:
            value, part = _value(scene, name), _parse(name)[3]
            entries = len(value) if part is None and isinstance(value, tuple) else 0
            keys += [k for k in ([f"{name}[{i}]" for i in range(entries)] or [name]) if k not in keys]
    if not keys:
        raise InputError("free: nothing is free: name key paths such as model.rods[0].com")
    return keys


def _field(record: Any, name: str) -> Any:
    """The value of a field; of a rod's absent centre of mass and inertia those of a uniform rod."""
    value = getattr(record, name)
    if value is None and isinstance(record, Rod):
        bare = Rod(length=record.length, mass=record.mass or 1.0, radius=record.radius).properties
        return bare.h if name == "com" else tuple(x * (record.mass > 0) for x in (bare.I1, bare.I2, bare.I3))
    return value


def _value(scene: Scene, key: str) -> Any:
    """What stands at a key path of a rod or an effect. Raises InputError."""
    home, place, name, part = _parse(key)
    if home == "model.rods" and not isinstance(scene.model, Chain):
        raise InputError(f'free: {key}: only the rods of a model of kind "chain" can be free, not links of a URDF')
    records: Any = scene.effects if home == "effects" else getattr(scene.model, "rods", ())
    if place >= len(records):
        has = amount(len(records), home.removeprefix("model.").removesuffix("s"))
        raise InputError(f"free: {key}: the scene has {has}, counted from 0")
    record = records[place]
    fields = [field for field, info in type(record).model_fields.items() if _holds_floats(info.annotation)]
    if name not in fields:
        raise InputError(f"free: {key}: {not_one_of(name, fields)}")
    value = _field(record, name)
    if value is None:
        raise InputError(f"free: {key}: the scene gives no value to start from: set it to a guess")
    if part is not None:
        if not isinstance(value, tuple) or part >= len(value):
            raise InputError(f"free: {key}: there is no entry [{part}] in {shown(value)}")
        return value[part]
    return value


def _holds_floats(annotation: Any) -> bool:
    """Whether the type of a field allows floats, alone or in a tuple: not names, choices and counts."""
    return annotation is float or any(map(_holds_floats, get_args(annotation)))


def _groups(scene: Scene, keys: list[str], guess: Array):
    """Rows of `keys` that move together, the matrix to them, start and bounds of their coordinates; guess (K,)."""
    place = {key: row for row, key in enumerate(keys)}
    done: set[int] = set()
    for key, row in place.items():
        home, i, name, _ = _parse(key)
        rows = [place.get(f"{home}[{i}].inertia[{k}]", -1) for k in range(3)]
        if row in done:
            continue
        if home == "model.rods" and name == "inertia" and min(rows) >= 0:
            done.update(rows)
            moments = np.linalg.solve(_MOMENTS, guess[rows])  # second moments of mass, kg m²
            moments = np.where(moments > _NEGLIGIBLE * moments.max(), moments, 0.0)
            some = moments > 0
            yield rows, _MOMENTS[:, some], moments[some], np.zeros(some.sum()), np.full(some.sum(), np.inf)
        elif home == "effects" and name == "kinetic" and f"effects[{i}].static" in place:
            both = [row, place[f"effects[{i}].static"]]
            done.update(both)
            kinetic, static = guess[both]
            yield both, np.array([[1.0, 0], [1, 1]]), [kinetic, static - kinetic], [0.0, 0.0], [np.inf, np.inf]
        elif not (name == "static" and f"effects[{i}].kinetic" in place):
            yield [row], np.eye(1), [guess[row]], *([bound] for bound in _bounds(scene, key))


def _bounds(scene: Scene, key: str) -> tuple[float, float]:
    """Between what a number that moves alone may be: the limits of its field, and those of the numbers beside it."""
    home, place, name, part = _parse(key)
    model: Any = scene.model
    record = scene.effects[place] if home == "effects" else model.rods[place]
    if isinstance(record, Rod) and name == "inertia":
        others = np.delete(np.array(_field(record, name)), part or 0)
        return float(abs(others[0] - others[1])), float(others.sum())
    lower, upper = -np.inf, np.inf
    field = type(record).model_fields[name]
    queue: list[Any] = [*field.metadata, field.annotation]
    while queue:  # limits in a field's type, however deep
        limit = queue.pop()
        queue += [*getattr(limit, "__metadata__", ()), *getattr(limit, "__args__", ()), *getattr(limit, "metadata", ())]
        if isinstance(limit, annotated_types.Gt):
            lower = max(lower, _LEAST * _value(scene, key))  # a positive number stays one
        elif isinstance(limit, annotated_types.Ge) and limit.ge == 0:
            lower = max(lower, 0.0)
    if isinstance(record, DryFriction) and name == "kinetic" and record.static is not None:
        upper = record.static
    if isinstance(record, DryFriction) and name == "static":
        lower = record.kinetic
    return lower, upper
