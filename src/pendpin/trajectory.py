"""The result of a run: arrays over time, statistics, and the file that holds them."""

import json
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from pendpin.arrays import Array
from pendpin.errors import InputError, explain
from pendpin.files import ArrayFile, open_arrays, write_whole
from pendpin.records import LARGEST

FORMAT = 1


class Reactions(NamedTuple):
    """Joint reactions on each rod of a universal joint, (n, rods): R1, R2, R3 in N, M3, Mc in N m (DESIGN in docs)."""

    R1: Array
    R2: Array
    R3: Array
    M3: Array
    Mc: Array


class Energy(NamedTuple):
    """Kinetic and potential energy, (n,) in J; the potential is that of the conservative effects."""

    kinetic: Array
    potential: Array

    @property
    def total(self) -> Array:
        """Their sum, (n,) in J."""
        return self.kinetic + self.potential

    @property
    def drift(self) -> float:
        """Largest departure of the total from its start, over the largest kinetic energy or range of potential."""
        moved = max(self.kinetic.max(), np.ptp(self.potential), np.finfo(float).tiny)
        return float(np.abs(self.total - self.total[0]).max() / moved)


@dataclass(frozen=True)
class Stats:
    """What a run took."""

    method: str
    tolerance: float | None  # of a method without a fixed step
    step: float | None  # s, of a method with one
    steps: int
    evaluations: int
    events: int  # impacts, and joints that stuck or came loose
    seconds: float  # of integration with its sampling
    compile_seconds: float
    engine: str
    library: str
    version: str
    conservative: bool = False  # whether every effect has a potential, so that the energy should not change
    stopped: str | None = None  # why the run ended before its time
    accuracy: float | None = None  # the largest tip error over the chain's length that was asked for
    error: float | None = None  # the one that is estimated
    all_seconds: float | None = None  # of every run that led to this one

    @property
    def setting(self) -> str:
        """The tolerance or step, in words."""
        return f"step {self.step:g} s" if self.tolerance is None else f"tolerance {self.tolerance:g}"


@dataclass(frozen=True)
class Trajectory:
    """A motion sampled at t, with everything that was computed along it.

    q, v, a hold one value per joint, in model order, rad and s (m for prismatic joints); angles are not wrapped.
    wrench is the force (N), then the moment (N m), that each joint's parent exerts on its child, at the joint's origin,
    in the child joint's frame.
    """

    joints: tuple[str, ...]
    t: Array  # (n,)
    q: Array  # (n, nv)
    v: Array  # (n, nv)
    a: Array  # (n, nv)
    wrench: Array  # (n, joints, 6)
    kinetic: Array  # (n,)
    potential: Array  # (n,)
    tip: Array  # (n, rods, 3), world frame W
    rods: Reactions | None  # None for a model without universal joints
    stats: Stats
    work: dict[str, Array] = field(default_factory=dict)  # J (n,), of each kind of effect, with energy_balance
    scene: dict[str, Any] = field(default_factory=dict)  # as in a scene file

    def reactions(self) -> Reactions:
        """R1, R2, R3, M3, Mc of every rod on a universal joint. Raises InputError where the model has none."""
        if self.rods is None:
            raise InputError("this model has no universal joint, so no R1, R2, R3, M3; see .wrench for every joint")
        return self.rods

    def energy(self) -> Energy:
        """Kinetic and potential energy over time."""
        return Energy(self.kinetic, self.potential)

    @property
    def imbalance(self) -> float:
        """The largest change of kinetic energy that no work accounts for, over the energy moved."""
        if not self.work:
            return 0.0
        total = sum(self.work.values(), np.zeros(len(self.t)))
        moved = max(self.kinetic.max(), *(np.ptp(work) for work in self.work.values()), np.finfo(float).tiny)
        return float(np.abs(self.kinetic - self.kinetic[0] - total).max() / moved)

    def tips(self) -> Array:
        """The far end of each rod, (n, rods, 3) in m, world frame W."""
        return self.tip

    @property
    def sound(self) -> int:
        """How many samples there are before the first with a number that is not finite or beyond LARGEST."""
        n = len(self.t)
        arrays = [getattr(self, name).reshape(n, -1) for name in _ARRAYS] + list(self.rods or ())
        good = np.all([(np.abs(array) <= LARGEST).all(1) for array in arrays], 0)
        return n if good.all() else int(np.argmin(good))

    def save(self, path: str | Path) -> Path:
        """Write everything to an .npz file, whole or not at all. Raises InputError where that cannot be."""
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS} | {"joints": np.array(self.joints)}
        if self.rods is not None:
            arrays |= self.rods._asdict()
        arrays |= {f"work_{kind}": work for kind, work in self.work.items()}
        meta = {"format": FORMAT, "scene": self.scene, **asdict(self.stats)}
        arrays["meta"] = np.array(json.dumps(meta))
        return write_whole(Path(path), lambda file: np.savez_compressed(file, **arrays))

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a saved run. Raises InputError for anything that is not one; nothing in the file is executed."""
        with open_arrays(Path(path), "a run that pendpin saved") as file:
            return cls(**_checked(file))


_ARRAYS = ("t", "q", "v", "a", "wrench", "kinetic", "potential", "tip")


def _checked(file: ArrayFile) -> dict[str, Any]:
    """The fields of a Trajectory from a file's arrays; ValueError where they do not fit together."""
    scene, stats = _read_meta(file)
    joints = tuple(str(name) for name in read_array(file, "joints", ("joints",), text=True))
    n, nv, rods = _length(file, "t", 0), len(joints), _length(file, "tip", 1)
    shapes = {"t": (n,), "q": (n, nv), "v": (n, nv), "a": (n, nv), "wrench": (n, nv, 6)}
    shapes |= {"kinetic": (n,), "potential": (n,), "tip": (n, rods, 3)}
    found: dict[str, Any] = {name: read_array(file, name, shape) for name, shape in shapes.items()}
    if np.any(np.diff(found["t"]) <= 0):
        raise ValueError("array 't' does not rise")
    universal = (n, _length(file, "R1", 1)) if "R1" in file.headers else None
    reactions = Reactions(*(read_array(file, name, universal) for name in Reactions._fields)) if universal else None
    kinds = [name.removeprefix("work_") for name in file.headers if name.startswith("work_")]
    work = {kind: read_array(file, f"work_{kind}", (n,)) for kind in kinds}
    return found | {"joints": joints, "rods": reactions, "work": work, "stats": stats, "scene": scene}


def _length(file: ArrayFile, name: str, axis: int) -> int:
    shape = file.header(name).shape
    if len(shape) <= axis or not shape[axis]:
        raise ValueError(f"array {name!r} has the shape {shape}")
    return shape[axis]


def read_array(file: ArrayFile, name: str, shape: tuple[Any, ...], text: bool = False) -> NDArray[Any]:
    """An array of finite numbers of this shape, or a list of texts; refused by its header before it is read."""
    dtype, found = file.header(name)
    if text and dtype.kind == "U" and len(found) == len(shape) and all(found):
        return file.read(name)
    if text or dtype != np.float64 or found != shape:
        wanted = "text" if text else f"float64 {shape}"
        raise ValueError(f"array {name!r} is {dtype} {found}, not {wanted}")
    array = file.read(name)
    if not (np.abs(array) <= LARGEST).all():
        raise ValueError(f"array {name!r} holds NaN or a number beyond {LARGEST:g}")
    return array


def _read_meta(file: ArrayFile) -> tuple[dict[str, Any], Stats]:
    meta = json.loads(str(read_array(file, "meta", (), text=True)))
    if not isinstance(meta, dict) or meta.get("format") != FORMAT:
        raise ValueError("its format is of another version of pendpin")
    scene = meta.get("scene")
    if not isinstance(scene, dict):
        raise ValueError("meta holds no scene")
    try:
        known = {f.name: meta[f.name] for f in fields(Stats) if f.name in meta}
        return scene, TypeAdapter(Stats).validate_python(known)
    except ValidationError as error:
        raise ValueError(f"meta: {explain(error.errors(include_url=False), 'meta')}") from None
