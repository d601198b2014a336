"""Frozen, validated data: the base of scenes and effects, the number types they use, and what their errors say."""

import inspect
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self, get_args

import numpy as np
from pydantic import AfterValidator, AllowInfNan, BaseModel, ConfigDict, Field, Strict, ValidationError

from pendpin.errors import InputError, brief, choices, nearest_or_all, not_one_of, shown, written

MOST_ITEMS = 6  # of a list in one
MOST_PATHS = 3  # of further faults
MOST_SHOWN = 60  # letters of a name in a message
LARGEST = 1e150  # of any number in a scene or a run: its square stays within doubles
LARGEST_SIZE = 1e100  # of a length, mass or inertia, and 1 over the least inertia: their products stay within doubles
# an int or float; never text or a bool
Number = Annotated[float, Strict(), AllowInfNan(False), Field(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
Vector = tuple[Number, Number, Number]
_KEYED = re.compile(r"([a-z_]+)(\[\d+\])?(\.[a-z_]+)*: ")
_DEGREES = re.compile(r"\d *(deg|°)")


def _absolute(path: Path) -> Path:
    try:
        return path.absolute()
    except OSError:  # the working folder is gone
        return path


def _with_length(direction: Vector) -> Vector:
    if not any(direction):
        raise ValueError("a direction needs a length: [0, 0, -1] points down")
    return direction


Direction = Annotated[Vector, AfterValidator(_with_length)]  # in W, of any length but 0
FilePath = Annotated[Path, AfterValidator(_absolute)]  # stays the same file when the working folder changes


class FrozenDict(dict[str, Any]):
    """The dict of a frozen record: it cannot be changed, which would skip the checks, and it has a hash."""

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise InputError("a scene cannot be changed; scene.replace({key path: value}) gives another")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse  # type: ignore

    def __hash__(self) -> int:  # type: ignore[override]  # a dict has none, as it can be changed
        return hash(frozenset(self.items()))

    def __reduce__(self) -> tuple[type, tuple[dict[str, Any]]]:
        """To be copied and pickled whole: item by item is refused."""
        return FrozenDict, (dict(self),)


class RecordType(type(BaseModel)):
    """Calling the class raises InputError; inside another record pydantic keeps its own error, for the full path.

    It is a metaclass for two reasons. A class with an __init__ of its own is built by that __init__ inside other records
    too: the error of an inner record would be raised there, without its place in the outer one. And help() of a class asks
    the metaclass's __dir__: help(Rod) has 43 lines with this one, 503 with pydantic's.
    """

    def __new__(mcs, name: str, bases: tuple[type, ...], body: dict[str, Any], **options: Any) -> Any:
        """The class. Raises InputError where a value stands in place of a property of its base, as smooth = False."""
        for key, value in body.items():
            inherited = any(isinstance(getattr(base, key, None), property) for base in bases)
            if inherited and not isinstance(value, property):
                raise InputError(f"{name}.{key}: write {key} as a property that returns {shown(value)}")
        return super().__new__(mcs, name, bases, body, **options)

    def __call__(cls, *args: Any, **data: Any) -> Any:
        try:
            return super().__call__(**plain(cls.from_one(*args) | data if args else data))
        except ValidationError as error:
            raise InputError(fault_text(error.errors(include_url=False), cls)) from None

    def from_one(cls, *values: Any) -> dict[str, Any]:
        """The fields that unnamed values stand for; a class that takes one says so."""
        record: Any = cls
        fields = {name: field for name, field in record.model_fields.items() if name != "kind"}
        names = sorted(fields, key=lambda name: not fields[name].is_required())
        raise InputError(f"{cls.__name__}: every value needs its name: {cls.__name__}({names[0]}=..., ...)")

    def __dir__(cls) -> list[str]:
        """What the class adds to pydantic's own: for help() and completion."""
        return sorted(_added(cls))


class Record(BaseModel, metaclass=RecordType):
    """Frozen data that refuses unknown keys; a bad value raises InputError with its key path."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    # Python's way to say "not iterable": pydantic's gives pairs of names and values, and a rod would pass for a list of rods
    __iter__ = None  # type: ignore
    _about: ClassVar[str] = ""  # the docstring without its list of fields

    def __setattr__(self, name: str, value: Any) -> None:
        """A record is what it was made: `replace` of a scene gives another. What a subclass keeps for itself it may set."""
        if name.startswith("_"):
            return super().__setattr__(name, value)
        own = type(self).__name__
        raise InputError(f"{own}.{name}: a {own} cannot be changed; scene.replace({name}=...) gives another scene")

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """As pydantic's; what was computed from the old fields and kept is left behind, unless the update holds it."""
        copy = super().model_copy(update=update, deep=deep)
        if update:
            known = type(self).model_fields
            for name in [name for name in vars(copy) if name not in known and name not in update]:
                del vars(copy)[name]
        return copy

    def copy(self, *, update: Mapping[str, Any] | None = None) -> Self:  # type: ignore[override]
        """A record with some fields changed, and checked: pydantic's own would skip the checks."""
        if not isinstance(update, Mapping | None):
            raise InputError(f"update: {shown(update)} is not a mapping of fields to values")
        return type(self)(**self.given() | dict(update or {}))

    def given(self) -> dict[str, Any]:
        """The fields that were given, by name, and the record's kind: a record of these is equal."""
        names = type(self).model_fields
        return {name: getattr(self, name) for name in names if name in self.model_fields_set or name == "kind"}

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={_short(value)}" for name, value in self.given().items() if name != "kind")
        return brief(f"{type(self).__name__}({fields})")

    __str__ = __repr__

    def __dir__(self) -> list[str]:
        """What the class adds to pydantic's own, and the fields."""
        return sorted({*_added(type(self)), *type(self).model_fields})

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Let help() show the fields with their units, and a signature of names and defaults."""
        parameters = []
        for name, field in cls.model_fields.items():
            default = inspect.Parameter.empty if field.is_required() else field.get_default(call_default_factory=True)
            parameters.append(inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default))
        cls.__signature__ = inspect.Signature(parameters)
        cls._about = inspect.cleandoc(cls.__dict__.get("__doc__") or "")
        lines = [f"{name}: {field.description}" for name, field in cls.model_fields.items()]
        cls.__doc__ = "\n".join([cls._about, "", "Fields:", *(f"    {line}" for line in lines)])

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: Any) -> Any:
        """The schema's description is the docstring alone: each field has its own."""
        schema = handler(core_schema)
        handler.resolve_ref_schema(schema)["description"] = cls._about
        return schema


def _short(value: Any) -> str:
    """A value in a representation: of a long list its ends."""
    if isinstance(value, tuple | list) and len(value) > MOST_ITEMS:
        first, last = _short(value[0]), _short(value[-1])
        return f"({first}, ... {len(value) - 2} more ..., {last})"
    if isinstance(value, dict) and len(value) > MOST_ITEMS:
        name = next(iter(value))
        return f"{{{name!r}: {_short(value[name])}, ... {len(value) - 1} more}}"
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_short, value))}]"
    return repr(value)


def _added(cls: type) -> set[str]:
    inherited = {name for base in cls.__mro__ if issubclass(base, Record) and base is not Record for name in vars(base)}
    return {name for name in inherited if not name.startswith("_") and name != "model_config"} | {"__doc__"}


def plain(value: Any, depth: int = 8) -> Any:
    """A value with NumPy's numbers and arrays in it, down to this depth, as Python's."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, dict) and depth:
        return {key: plain(inner, depth - 1) for key, inner in value.items()}
    return [plain(inner, depth - 1) for inner in value] if type(value) in {list, tuple} and depth else value


def fault_text(faults: list[Any], record: type) -> str:
    """The first of pydantic's faults with data of a class, as `key path: what is wrong`, or its name without a path."""
    fault = min(faults, key=lambda f: f["type"] in {"missing", "too_short"})  # often the echo of another fault
    unknown = [f for f in faults if f["type"] == "extra_forbidden"]
    unknown.sort(key=lambda f: [str(part) for part in f["loc"]])  # whatever order they were given in
    faults = [f for f in faults if f["type"] != "extra_forbidden"] + unknown
    if fault["type"] == "extra_forbidden":
        fault = next(f for f in unknown if f["loc"][:-1] == fault["loc"][:-1])
    path, reason = _path(fault) or record.__name__, _reason(fault, record)
    others = [f for f in faults if f["type"] != "too_short" and _path(f) not in ("", path)]
    others = list(dict.fromkeys(_path(f) + " is missing" * (f["type"] == "missing") for f in others))
    count = "another fault" if len(others) == 1 else f"{len(others)} other faults"
    more = f"; {count}: {choices(others, MOST_PATHS)}" if others else ""
    keyed = _KEYED.match(reason)
    if keyed and any(keyed[1] in kind.model_fields for kind in _records_at(record, fault["loc"])):
        # a check of a whole record names the place in it
        return f"{f'{path}.' if fault['loc'] else ''}{reason}{more}"
    return f"{path}: {reason}{more}"


def _path(fault: Any) -> str:
    """Names of union branches, which start with ~, are not part of a key path, nor is pydantic's mark of a key."""
    path = [part for part in fault["loc"] if isinstance(part, int) or not (part.startswith("~") or part == "[key]")]
    if fault["type"] == "union_tag_invalid" and fault["ctx"]["tag"] != "~no table":
        path.append("kind")
    return written(tuple(part if isinstance(part, int) else part[:MOST_SHOWN] for part in path))


def _reason(fault: Any, record: type) -> str:
    context, value = fault.get("ctx", {}), shown(fault.get("input"))
    match fault["type"]:
        case "union_tag_invalid" if context["tag"] == "~no table":
            return f"{value} is not a table with a `kind`"
        case "union_tag_invalid" if context["tag"] == "~":
            allowed = _allowed(context)
            return f'missing; it is one of: {allowed}; for example kind = "{allowed.split(", ")[0]}"'
        case "union_tag_invalid":
            return not_one_of(context["tag"].removeprefix("~"), _allowed(context).split(", "))
        case "literal_error":
            return not_one_of(fault["input"], context["expected"].replace("'", "").replace(" or ", ", ").split(", "))
        case "extra_forbidden":
            *place, name = fault["loc"]
            fields = [field for other in _records_at(record, place) for field in other.model_fields]
            return f"unknown key{nearest_or_all(name, tuple(fields))}"
        case "float_type" if isinstance(fault["input"], str) and _DEGREES.search(fault["input"]):
            return f'{value} is not a number; for numbers in degrees write unit = "degrees" in [start]'
        case "tuple_type":
            *place, name = fault["loc"] or ("",)
            kinds = [r.model_fields[name].annotation for r in _records_at(record, place) if name in r.model_fields]
            if any(kind in (Vector, Vector | None, Direction | None) for kind in kinds):
                return f"{value} is not a list of 3 numbers"
            if isinstance(fault["input"], dict):
                return f"{value} is a table, not a list; a list of tables begins with [[{_path(fault)}]]"
            return f"{value} is not a list"
        case "value_error":
            return str(context["error"])
        case "float_type" if type(fault["input"]) is int:
            return f"{value} is beyond double precision"
        case kind if kind in _REASONS:
            return _REASONS[kind].format(value=value, **context)
        case _:
            return f"{value}: {fault['msg'].removeprefix('Input ').replace(' after validation', '')}"


def _records_at(record: type, loc: Sequence[str | int]) -> list[type[BaseModel]]:
    """The classes that a record at a place in a class of records may have."""

    def within(annotation: Any) -> list[type[BaseModel]]:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            return [annotation]
        return [inner for part in get_args(annotation) for inner in within(part)]

    records = [record] if issubclass(record, BaseModel) else []
    for part in loc:
        if isinstance(part, str) and part.startswith("~"):
            records = [r for r in records if "kind" in r.model_fields and r.model_fields["kind"].default == part[1:]]
        elif isinstance(part, str):
            annotations = [r.model_fields[part].annotation for r in records if part in r.model_fields]
            records = [inner for annotation in annotations for inner in within(annotation)]
    return records


def _allowed(context: Any) -> str:
    tags = context["expected_tags"].replace("'", "").split(", ")
    return choices(tag.removeprefix("~") for tag in tags if tag != "~instance")


_REASONS = {
    "missing": "missing",
    "finite_number": "{value} is not a finite number",
    **dict.fromkeys(("float_type", "float_parsing"), "{value} is not a number"),
    **dict.fromkeys(("bool_type", "bool_parsing"), "{value} is not true or false"),
    **dict.fromkeys(("int_parsing", "int_type", "int_from_float"), "{value} is not a whole number"),
    **dict.fromkeys(("dict_type", "model_type"), "{value} is not a table"),
    "string_type": "{value} is not text",
    "path_type": "{value} is not a path",
    "greater_than": "{value} is not above {gt:.15g}",
    "greater_than_equal": "{value} is below {ge:.15g}",
    "less_than": "{value} is not below {lt:.15g}",
    "less_than_equal": "{value} is above {le:.15g}",
    "too_long": "{actual_length} values, where {max_length} are wanted",
    "too_short": "{actual_length} values, where at least {min_length} are wanted",
}
