"""The result of a run: arrays over time, statistics, and the file that holds them."""

import json
import zipfile
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pendpin.errors import InputError
from pendpin.files import write_whole

Array = NDArray[np.float64]

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
    tolerance: float
    steps: int
    evaluations: int
    seconds: float  # of integration with its sampling
    compile_seconds: float
    library: str
    version: str
    stopped: str | None = None  # why the run ended before its time


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
    scene: dict[str, Any] = field(default_factory=dict)  # as in a scene file

    def reactions(self) -> Reactions:
        """R1, R2, R3, M3, Mc of every rod on a universal joint. Raises InputError where the model has none."""
        if self.rods is None:
            raise InputError("this model has no universal joint, so no R1, R2, R3, M3; see .wrench for every joint")
        return self.rods

    def energy(self) -> Energy:
        """Kinetic and potential energy over time."""
        return Energy(self.kinetic, self.potential)

    def tips(self) -> Array:
        """The far end of each rod, (n, rods, 3) in m, world frame W."""
        return self.tip

    def save(self, path: str | Path) -> Path:
        """Write everything to an .npz file, whole or not at all. Raises InputError where that cannot be."""
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS} | {"joints": np.array(self.joints)}
        if self.rods is not None:
            arrays |= self.rods._asdict()
        meta = {"format": FORMAT, "scene": self.scene, **asdict(self.stats)}
        arrays["meta"] = np.array(json.dumps(meta))
        return write_whole(Path(path), lambda file: np.savez_compressed(file, **arrays))

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a saved run. Raises InputError for anything that is not one; nothing in the file is executed."""
        path = Path(path)
        try:
            with np.load(path, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
            return cls(**_checked(arrays))
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
        except (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, MemoryError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise InputError(f"{path}: not a run that pendpin saved: {reason}") from None


_ARRAYS = ("t", "q", "v", "a", "wrench", "kinetic", "potential", "tip")


def _checked(arrays: dict[str, Any]) -> dict[str, Any]:
    """The fields of a Trajectory from a file's arrays; ValueError, KeyError or TypeError where they do not fit."""
    meta = json.loads(str(arrays["meta"][()]))
    if meta.pop("format") != FORMAT:
        raise ValueError("its format is of another version of pendpin")
    joints = tuple(str(name) for name in arrays["joints"])
    n, nv = len(arrays["t"]), len(joints)
    shapes = {"t": (n,), "q": (n, nv), "v": (n, nv), "a": (n, nv), "wrench": (n, nv, 6)}
    shapes |= {"kinetic": (n,), "potential": (n,), "tip": (n, arrays["tip"].shape[1], 3)}
    for name, shape in shapes.items():
        if arrays[name].shape != shape or arrays[name].dtype != np.float64 or not n:
            raise ValueError(f"array {name!r} is {arrays[name].dtype} {arrays[name].shape}, not float64 {shape}")
        if not np.isfinite(arrays[name]).all():
            raise ValueError(f"array {name!r} holds NaN or inf")
    rods = Reactions(*(arrays[name] for name in Reactions._fields)) if "R1" in arrays else None
    scene = meta.pop("scene")
    stats = Stats(**{f.name: meta[f.name] for f in fields(Stats)})
    return {name: arrays[name] for name in _ARRAYS} | {"joints": joints, "rods": rods, "stats": stats, "scene": scene}
