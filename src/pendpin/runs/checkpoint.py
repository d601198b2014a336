"""The state of a run: its samples so far, and where its integration continues; and the file from which it continues."""

import json
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pendpin.dynamics.contacts import Mode
from pendpin.errors import Halted, InputError, Interrupted, shown
from pendpin.ground.arguments import seconds
from pendpin.ground.arrays import Array
from pendpin.ground.files import open_arrays, refuse_targets, write_whole
from pendpin.ground.libraries import VERSION, installed
from pendpin.integrators import Memory
from pendpin.scene import Scene
from pendpin.trajectory.parts import Event, event_arrays, read_array, read_events

FORMAT = 4  # of the file: another one is refused, as its arrays would be misread
EVERY = 5.0  # s of wall time between two saves, unless another is given
REMEDY = "delete it or name another file"
WHAT = f"a checkpoint that pendpin saved ({REMEDY})"


class SmoothState(NamedTuple):
    """Where a motion without events continues. Shapes do not change during a run."""

    t: float  # s since the start
    q: Array  # (nv,) the angles from which turns are counted
    y: Array  # (size,) the engine's state
    work: Array  # (accounts,) J
    most: int  # output times of the next segment
    first_step: float  # s, a proposal; 0 without one
    density: float  # states per s, from which angles are read in the next segment; 0 where the state holds angles
    memory: Memory  # of the integrator
    held: tuple[Array, ...]  # the records of the sampled torques, which all states share


class EventState(NamedTuple):
    """Where a motion with events continues."""

    t: float  # s since the start
    y: Array  # (size,) positions, rates, work of the accounts
    mode: Mode
    at_once: int  # events at this instant, so far
    held: tuple[Array, ...]  # as in SmoothState


@dataclass(frozen=True, eq=False)
class RunState:
    """The motion at the first n output times, and the state with which its integration continues."""

    room: Array  # (output times, columns): q, v, work of accounts, torques of contacts; all states of a run share it
    n: int  # its first n rows do not change any more
    last: SmoothState | EventState
    steps: int = 0
    evaluations: int = 0
    events: int = 0
    seconds: float = 0.0
    log: list[Event] = field(default_factory=list)  # what happened at the events, shared as `room` is
    logged: int = 0  # how many of these belong to the state

    @classmethod
    def at_start(cls, first: Array, count: int, last: SmoothState | EventState) -> "RunState":
        """A state with the first of `count` samples, first (columns,)."""
        room = np.empty((count, len(first)))
        room[0] = first
        return cls(room, 1, last)

    def grown(
        self, samples: Array, last: SmoothState | EventState, steps: int, evaluations: int, happened: Any = None
    ) -> "RunState":
        """The state with more samples (k, columns), the counts increased, and the Events that happened, if any did."""
        n = self.n + len(samples)
        self.room[self.n : n] = samples
        self.log[self.logged :] = happened or ()
        counts = (self.steps + steps, self.evaluations + evaluations, self.events + (happened is not None))
        return RunState(self.room, n, last, *counts, self.seconds, self.log, len(self.log))


# Of a motion without events: each number of its state is shifted by this part of its largest so far, away from 0, so that
# shifts add up, every so many samples. A part of 0 only cuts the run.
Shifts = tuple[float, int]


# --- its file -------------------------------------------------------------------------------------------------------


class Checkpoint:
    """The file of one run, written whole or not at all, every so many s of wall time. InputError where it cannot be."""

    def __init__(self, path: Path, every: float = EVERY) -> None:
        self.path, self._every, self._saved = path, seconds("every", every), -np.inf
        refuse_targets([path], [])
        self.run = dict[str, Any]()  # what must be the same to continue it (`identity`)

    def resume(self, first: RunState) -> RunState:
        """The state in the file, in the shapes of `first`, or `first` where there is none. InputError; it runs no code."""
        if not os.path.exists(self.path):
            return first
        with open_arrays(self.path, WHAT) as file:
            meta = json.loads(str(read_array(file, "meta", (), text=True)))
            if not isinstance(meta, dict) or meta.get("checkpoint") != FORMAT:
                raise ValueError("it is something else, or of another version of pendpin")
            if (difference := _difference(meta.get("run"), self.run)) is None:
                most, columns = first.room.shape
                n = (*file.header("samples").shape, 0)[0]
                if not 1 <= n <= most:
                    raise ValueError(f"{n} samples, where 1 to {most} are wanted")
                first.room[:n] = read_array(file, "samples", (n, columns))
                last = _restored(first.last, lambda name, shape: read_array(file, name, shape))
                counts = read_array(file, "counts", (4,))
                if (counts < 0).any() or (counts[:3] % 1).any():
                    raise ValueError("array 'counts' holds no counts")
                log, (steps, evaluations, events, seconds) = list(read_events(file)), counts.tolist()
                return RunState(first.room, n, last, int(steps), int(evaluations), int(events), seconds, log, len(log))
        raise InputError(f"{self.path}: the checkpoint of another run: {difference}; {REMEDY}")

    @property
    def due(self) -> bool:
        """Whether the interval between two saves has passed, or nothing is saved yet."""
        return time.perf_counter() - self._saved >= self._every

    def save(self, state: RunState) -> None:
        """Write the file. Raises Halted if that fails."""
        counts = np.array([state.steps, state.evaluations, state.events, state.seconds])
        meta = np.array(json.dumps({"checkpoint": FORMAT, "run": self.run}))
        arrays: dict[str, Any] = {"samples": state.room[: state.n], "counts": counts, "meta": meta}
        arrays |= _arrays_of(state.last) | event_arrays(state.log[: state.logged])
        try:
            write_whole(self.path, lambda file: np.savez(file, **arrays))
        except InputError as error:
            raise Halted(str(error)) from None
        self._saved = time.perf_counter()


@contextmanager
def resumable(path: Path | None) -> Iterator[None]:
    """If the user stops the block and the run has a file, raise Interrupted with the name of the file."""
    try:
        yield
    except KeyboardInterrupt:
        if path is None or not os.path.exists(path):
            raise
        raise Interrupted(f"stopped by the user{how_to_resume(path)}") from None


def how_to_resume(path: Path) -> str:
    """What is said of a halted run."""
    return f"; {path} holds the run so far; the same command resumes it" if os.path.exists(path) else ""


def identity(scene: Scene, energy_balance: bool, engine: str) -> dict[str, Any]:
    """What must be the same to continue a run: scene, contents of its files, energy balance, engine, versions."""
    record = scene.recorded()
    for table in (record["model"], *record["effects"]):
        for key in table.keys() & {"path", "csv"}:
            if os.path.isfile(str(table[key])):
                table[key] = "sha256 " + sha256(Path(table[key]).read_bytes()).hexdigest()[:32]
    whole = {"scene": record, "energy_balance": energy_balance, "engine": engine, "versions": versions()}
    return json.loads(json.dumps(whole))


def versions() -> dict[str, str | None]:
    """The versions on which the bits of a result depend."""
    return {"pendpin": VERSION} | installed("pin", "numpy", "scipy", "CyRK", "heyoka")


def _arrays_of(record: Any, name: str = "last") -> dict[str, Any]:
    """The arrays of a record of arrays, numbers and such records, by the names of its fields."""
    if not isinstance(record, tuple):
        return {name: np.asarray(record, float)}
    names, arrays = getattr(record, "_fields", range(len(record))), dict[str, Any]()
    for part, value in zip(names, record, strict=True):
        arrays |= _arrays_of(value, f"{name}.{part}")
    return arrays


def _restored(like: Any, read: Callable[[str, tuple[int, ...]], Any], name: str = "last") -> Any:
    """A record of the shapes and types of another one, from the arrays that `read` returns."""
    if not isinstance(like, tuple):
        array = read(name, np.shape(like))
        return array.astype(like.dtype) if isinstance(like, np.ndarray) else type(like)(array)
    names = getattr(like, "_fields", range(len(like)))
    parts = [_restored(value, read, f"{name}.{part}") for part, value in zip(names, like, strict=True)]
    return type(like)(*parts) if hasattr(like, "_fields") else tuple(parts)


def _difference(saved: Any, now: Any, place: str = "run") -> str | None:
    """The first place where two records differ, in words; None where they are the same."""
    if isinstance(saved, dict) and isinstance(now, dict):
        inner = [(saved.get(key), now.get(key), f"{place}.{key}") for key in now | saved]
    elif isinstance(saved, list) and isinstance(now, list) and len(saved) == len(now):
        inner = [(*pair, f"{place}[{i}]") for i, pair in enumerate(zip(saved, now, strict=True))]
    else:
        return None if saved == now else f"{place.removeprefix('run.')} is {shown(saved)} in it, {shown(now)} here"
    return next(filter(None, (_difference(*pair) for pair in inner)), None)
