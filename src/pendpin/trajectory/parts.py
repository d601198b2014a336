"""The parts of a run's record: counts, energies, events, reactions, and how they are read from a file."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from pendpin.errors import amount
from pendpin.ground.arrays import TINY, Array
from pendpin.ground.files import ArrayFile
from pendpin.ground.records import LARGEST, fault_text

ROUNDING = 1e-9  # of a potential energy or work: a motion that exchanges less is lost in their rounding


def exchanged(kinetic: Array, *others: Array) -> Array:
    """The energy exchanged up to each sample, (n,) in J: the largest kinetic, or range of a potential or work if larger."""
    so_far, least = np.maximum.accumulate, np.full_like(kinetic, TINY)
    ranges = [np.maximum(so_far(x) + so_far(-x), ROUNDING * so_far(np.abs(x))) for x in others]
    return np.maximum.reduce([least, so_far(kinetic), *ranges])


def share(error: Array, kinetic: Array, *others: Array) -> float:
    """The largest of energy errors (n,) over the energy exchanged at the end, as of `exchanged`; 0 without samples."""
    return float(error.max() / exchanged(kinetic, *others)[-1]) if len(error) else 0.0


def _ranges_in_words(self: Any) -> str:
    """The least and the largest of each reaction of a run, N and N m."""
    parts = (f"{name} {x.min(initial=0):.6g} to {x.max(initial=0):.6g}" for name, x in self._asdict().items())
    return f"Reactions {self.R1.shape}: {', '.join(parts)}"


class Reactions(NamedTuple):
    """Joint reactions on each rod of a universal joint, (n, rods): R1, R2, R3 in N, M3, Mc in N m (docs/python.md)."""

    R1: Array
    R2: Array
    R3: Array
    M3: Array
    Mc: Array
    __repr__ = _ranges_in_words


class HingeReactions(NamedTuple):
    """The same where some rods are on hinges: M1, M2, M3 in N m are the moment that a joint carries, along b1, b2, b3.

    A hinge about x carries M2 and M3, one about y M1 and M3, a universal joint Mc along a3; the others are 0.
    """

    R1: Array
    R2: Array
    R3: Array
    M1: Array
    M2: Array
    M3: Array
    Mc: Array
    __repr__ = _ranges_in_words


AnyReactions = Reactions | HingeReactions


class Derived(NamedTuple):
    """What follows from the states at the samples."""

    a: Array  # (n, nv)
    wrench: Array  # (n, joints, 6)
    kinetic: Array  # (n,)
    potential: Array  # (n,)
    tips: Array  # (n, rods, 3), world frame W
    rod_reactions: AnyReactions | Callable[[], AnyReactions | None] | None  # None without universal joints; may be late

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, Array]) -> "Derived":
        """From the arrays of a file or of `RunRecord.arrays`, by their names."""
        kind = HingeReactions if "M1" in arrays else Reactions
        rods = kind(**{name: arrays[name] for name in kind._fields}) if "R1" in arrays else None
        return cls(**{name: arrays[name] for name in cls._fields[:-1]}, rod_reactions=rods)


class Energy(NamedTuple):
    """Kinetic and potential energy, (n,) in J; the potential is that of the conservative effects."""

    kinetic: Array
    potential: Array

    def __repr__(self) -> str:
        return f"Energy of {amount(len(self.kinetic), 'sample')}: drift {self.drift:.1e} of the energy exchanged"

    @property
    def total(self) -> Array:
        """Their sum, (n,) in J."""
        return self.kinetic + self.potential

    @property
    def exchanged(self) -> Array:
        """The energy exchanged up to each sample, (n,) in J."""
        return exchanged(self.kinetic, self.potential)

    @property
    def drift(self) -> float:
        """Largest departure of the total from its start, divided by the energy exchanged."""
        return share(np.abs(self.total - self.total[:1]), self.kinetic, self.potential)


KINDS = ("stick", "reverse", "slip", "stop", "release")


class Event(NamedTuple):
    """What happened to a joint, under dry friction or at a stop.

    A sliding joint came to rest (stick) or turned back (reverse), a held one started to slide (slip), one reached a
    limit (stop) or left the limit on which it rested (release).
    """

    t: float  # s, as a run's t
    joint: str
    kind: str  # one of KINDS


@dataclass(frozen=True, kw_only=True)
class Counts:
    """What one run took, or many together: method, setting, counts and times."""

    method: str
    tolerance: float | None  # of a method without a fixed step
    step: float | None  # s, of a method with one; the last may be shorter
    steps: int
    evaluations: int
    seconds: float  # of integration with its sampling
    compile_seconds: float
    library: str
    version: str

    @property
    def setting(self) -> str:
        """The tolerance or step, in words."""
        return f"step {self.step:g} s" if self.tolerance is None else f"tolerance {self.tolerance:g}"


@dataclass(frozen=True, kw_only=True)
class Stats(Counts):
    """Method, setting, counts, times and estimated error of a run."""

    events: int  # impacts, and joints that stuck or came loose
    engine: str
    conservative: bool = False  # whether every effect has a potential, so that the energy should not change
    stopped: str | None = None  # why the run ended early
    accuracy: float | None = None  # the target: largest tip error divided by the chain's length
    error: float | None = None  # the estimated error
    all_seconds: float | None = None  # of every run that led to this one
    notes: tuple[str, ...] = ()  # remarks on the run


# --- the file of a run ----------------------------------------------------------------------------------------------

FORMAT = 1  # of the file of a run: another one is refused
AS_WRITTEN = ("as_written", "viscous", "dry_friction", "stop")  # an effect, and those that it stands for
STATES = ("t", "q", "v")  # the arrays of a record that are integrated; the others follow from them


def pack_run(run: Any) -> dict[str, Any]:
    """The arrays of the file of a RunRecord, by their names."""
    held = {f"held_{i}": outputs for i, outputs in enumerate(run.held)}
    meta = json.dumps({"format": FORMAT, "scene": run.scene, **asdict(run.stats)})
    return run.arrays | held | event_arrays(run.events) | {"joints": np.array(run.joints), "meta": np.array(meta)}


def read_fields(file: ArrayFile) -> dict[str, Any]:
    """The fields of a RunRecord from a file. Raises ValueError where they do not fit together."""
    meta = json.loads(str(read_array(file, "meta", (), text=True)))
    if not isinstance(meta, dict) or meta.get("format") != FORMAT:
        raise ValueError("its format is of another version of pendpin")
    scene = meta.get("scene")
    if not isinstance(scene, dict) or not isinstance(listed := scene.get("effects") or [], list):
        raise ValueError("meta holds no scene")
    if not all(isinstance(table, dict) for table in (scene.get("model") or {}, *listed)):
        raise ValueError("meta holds no scene")
    try:
        stats = TypeAdapter(Stats).validate_python(meta)  # which leaves out what is not of Stats
    except ValidationError as error:
        raise ValueError(f"meta: {fault_text(error.errors(include_url=False), Stats)}") from None
    joints = tuple(str(name) for name in read_array(file, "joints", ("joints",), text=True))
    n, nv, rods = _length(file, "t", 0), len(joints), _length(file, "tips", 1)
    shapes = {"t": (n,), "q": (n, nv), "v": (n, nv), "a": (n, nv), "wrench": (n, nv, 6)}
    shapes |= {"kinetic": (n,), "potential": (n,), "tips": (n, rods, 3)}
    arrays = {name: read_array(file, name, shape) for name, shape in shapes.items()}
    if np.any(np.diff(arrays["t"]) <= 0):
        raise ValueError("array 't' does not rise")
    if "R1" in file.headers:
        names = HingeReactions._fields if "M1" in file.headers else Reactions._fields
        arrays |= {name: read_array(file, name, (n, _length(file, "R1", 1))) for name in names}
    kinds = [name.removeprefix("work_") for name in file.headers if name.startswith("work_")]
    work = {kind: read_array(file, f"work_{kind}", (n,)) for kind in kinds}
    effects = {str(effect.get("kind")) for effect in listed}
    others = {*AS_WRITTEN} if AS_WRITTEN[0] in effects else set()  # it stands for others, as many as its file writes
    if work and not effects - others <= set(work) <= effects | others:
        raise ValueError("its works are not those of its scene's effects")
    names = sorted(name for name in file.headers if name.startswith("held_"))
    if names != sorted(f"held_{i}" for i in range(len(names))):
        raise ValueError("the arrays of held torques do not fit together")
    held = []  # the outputs (instants, k) of each sampled torque
    for i in range(len(names)):
        instants, driven = (_length(file, f"held_{i}", axis) for axis in (0, 1))
        if driven > nv:
            raise ValueError(f"held torques of more than {nv} joints")
        held.append(read_array(file, f"held_{i}", (instants, driven)))
    states = {name: arrays[name] for name in STATES} | {"derived": Derived.of_arrays(arrays)}
    happened = {"events": read_events(file, joints), "held": tuple(held), "work": work}
    return states | happened | {"joints": joints, "stats": stats, "scene": scene}


def event_arrays(events: Sequence[Event]) -> dict[str, NDArray[Any]]:
    """The arrays by which a file holds events; empty without events."""
    parts = zip(Event._fields, zip(*events, strict=True), strict=False)
    return {f"event_{name}": np.array(part) for name, part in parts}


def read_events(file: ArrayFile, joints: Sequence[str] | None = None) -> tuple[Event, ...]:
    """The events in a file, of these joints if they are given. Raises ValueError for impossible ones."""
    if not any(name.startswith("event_") for name in file.headers):
        return ()
    t = read_array(file, "event_t", (_length(file, "event_t", 0),))
    names, kinds = (read_array(file, name, ("events",), text=True) for name in ("event_joint", "event_kind"))
    are_known = set(names) <= set(joints or names) and set(kinds) <= set(KINDS)
    if not len(t) == len(names) == len(kinds) or not are_known or np.any(np.diff(t) < 0):
        raise ValueError("the arrays of events do not fit together")
    return tuple(map(Event, t.tolist(), names.tolist(), kinds.tolist()))


def _length(file: ArrayFile, name: str, axis: int) -> int:
    """The length of an array of a file along an axis, from its header."""
    shape = file.header(name).shape
    if len(shape) <= axis or not shape[axis]:
        raise ValueError(f"array {name!r} has the shape {shape}")
    return shape[axis]


def read_array(file: ArrayFile, name: str, shape: tuple[Any, ...], text: bool = False) -> NDArray[Any]:
    """An array of finite numbers, or of texts, of this shape; another shape is refused before the data are read."""
    dtype, stored = file.header(name)
    if text and dtype.kind == "U" and len(stored) == len(shape) and all(stored):
        return file.read(name)
    if text or dtype != np.float64 or stored != shape:
        right = "text" if text else f"float64 {shape}"
        raise ValueError(f"array {name!r} is {dtype} {stored}, not {right}")
    array = file.read(name)
    if not (np.abs(array) <= LARGEST).all():
        raise ValueError(f"array {name!r} holds NaN or a number beyond {LARGEST:g}")
    return array
