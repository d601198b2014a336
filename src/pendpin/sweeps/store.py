"""The results of a sweep, in memory or in a Zarr store that is written block by block, each whole or not at all.

A store holds a variable for each measure over the dimensions of the plan, `why`, the coordinates, and `done`: for each block
0, or a checksum of its values, which is written behind them. A block whose values have another checksum is run again.
"""

import json
import os
import shutil
import warnings
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, shown
from pendpin.ground.arguments import leaves
from pendpin.ground.arrays import Array
from pendpin.ground.files import read_whole, write_csv
from pendpin.runs.checkpoint import versions
from pendpin.sweeps.attractors import KINDS, PART, number_attractors
from pendpin.sweeps.attractors import NAME as ATTRACTOR
from pendpin.sweeps.cases import Block, Task
from pendpin.sweeps.plan import CASE, Plan, short_names

FORMAT = 3
MAX_JSON = 100_000_000  # bytes, of a store's own description
NOT_RUN = "not run"  # why a case of a block that is not done has no measures
REMEDY = "delete it or name another store"


class Blocks:
    """How the cases are cut: block i is the cases from i * size on, whole rows of the trailing dimensions."""

    def __init__(self, shape: tuple[int, ...], size: int) -> None:
        self.shape = shape
        trailing = np.cumprod([1, *shape[::-1]])[::-1]  # cases behind one place of each dimension, and of all
        axis = int(np.argmax(trailing[1:] <= max(size, 1)))  # the first whose single places are small enough
        along = max(1, min(shape[axis], size // int(trailing[axis + 1])))
        self.chunks = (1,) * axis + (along,) + shape[axis + 1 :]
        self.grid = tuple(-(-n // c) for n, c in zip(shape, self.chunks, strict=True))
        self.blocks = int(np.prod(self.grid))

    def region(self, block: int) -> tuple[slice, ...]:
        """Where a block is, as slices of the dimensions."""
        sizes = zip(np.unravel_index(block, self.grid), self.chunks, self.shape, strict=True)
        return tuple(slice(int(i) * c, min((int(i) + 1) * c, n)) for i, c, n in sizes)

    def span(self, block: int) -> tuple[int, int]:
        """The first case of a block, and the one behind its last, in C order."""
        region = self.region(block)
        first = int(np.ravel_multi_index([s.start for s in region], self.shape))
        return first, first + int(np.prod([s.stop - s.start for s in region]))


class Store:
    """The results of a sweep, an xarray.Dataset, and their Zarr store if there is a path: new, or resumed. InputError."""

    def __init__(self, task: Task, path: Path | None, size: int) -> None:
        self.task, self.path = task, path
        self._group: Any = None  # of the store, where there is one
        with _one_line(path):
            self.data = _empty(task, Blocks(task.plan.shape, size))
            if path is not None:
                if not path.exists():
                    _create(self.data, path)
                there = _read(path)
                for name, value in self.data.attrs.items():
                    if there.attrs.get(name) != value:
                        change = _change(name, there.attrs.get(name), value)
                        raise InputError(f"it holds another sweep: {change}; {REMEDY}")
                import zarr

                self.data, self._group = there, zarr.open_group(str(path), mode="r+", zarr_format=3)
            self.blocks = _blocks_of(self.data)

    def put(self, block: int, results: Block) -> None:
        """Write the results of a block, then that it is done."""
        region = self.blocks.region(block)
        shape = tuple(s.stop - s.start for s in region)
        parts: dict[str, Array] = {
            m.name: results.values[:, columns].reshape(*shape, *(length for _, length in m.dims))
            for m, columns in zip(self.task.chosen, self.task.columns, strict=True)
        }
        with _one_line(self.path):
            for name, part in (parts | {"why": results.why.reshape(shape)}).items():
                self.data[name].values[region] = part
                if self._group is not None and (name != "why" or any(results.why)):
                    self._group[name][region] = part
            done = self.data["done"].values[block] = _checksum(parts.values(), results.why)
            if self._group is not None:
                self._group["done"][block] = done


def load(path: Path) -> Any:
    """The xarray.Dataset of a store, finished or not. Raises InputError for anything else."""
    with _one_line(path, "read"):
        if not path.is_dir():
            raise InputError("there is no store of a sweep")
        return finished(_read(path))


def _empty(task: Task, blocks: Blocks) -> Any:
    """A sweep before it runs: its coordinates, and arrays without results."""
    import xarray

    plan, dims, cut = task.plan, tuple(task.plan.dims), {"chunks": blocks.chunks}
    variables = dict[str, Any]()
    for m in task.chosen:
        names, lengths = zip(*m.dims, strict=True) if m.dims else ((), ())
        chunks = {"chunks": (*blocks.chunks, *lengths), "_FillValue": np.nan}
        variables[m.name] = ((*dims, *names), np.full((*plan.shape, *lengths), np.nan), {}, chunks)
    variables["why"] = (dims, np.full(plan.shape, "", object), {}, cut)
    variables["done"] = ("block", np.zeros(blocks.blocks, int), {}, {"chunks": (1,)})
    coordinates: dict[str, Any] = {} if plan.grid else {CASE: np.arange(plan.count)}
    for name, key in zip(short_names(plan.keys), plan.keys, strict=True):
        coordinates[name] = (name if plan.grid else CASE, plan.values[key], {"key": key})
    identity = {  # what must be the same where a sweep is resumed
        "pendpin_sweep": FORMAT,
        "scene": json.dumps(task.scene.recorded(), sort_keys=True),
        "keys": list(plan.keys),
        "cases": plan.identity,
        "measures": [m.name for m in task.chosen],
        **{f"measure {m.name}": repr(m.function) for m in task.chosen if m.dims},
        "versions": json.dumps(versions(), sort_keys=True),
    }
    data = xarray.Dataset(variables, coordinates, identity)
    for name, unit in task.units.items():
        data[name].attrs["units"] = unit
    return data


def _create(data: Any, path: Path) -> None:
    """Make a store beside its place, then put it there."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    shutil.rmtree(draft, ignore_errors=True)
    try:
        with warnings.catch_warnings():  # Zarr warns of text, which other readers of the format may lack
            warnings.simplefilter("ignore")
            data.to_zarr(str(draft), mode="w", zarr_format=3, consolidated=True)
        try:
            draft.rename(path)
        except OSError:
            if not path.exists():  # else another command was faster
                raise
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _read(path: Path) -> Any:
    """All arrays of a store. Raises InputError for a folder that is none in Zarr 3, by its JSON alone."""
    try:  # no array is opened before: a filter of the formats before Zarr 3, as numcodecs' Pickle, runs code when it reads
        attributes = json.loads(read_whole(path / "zarr.json", MAX_JSON, "a store's description"))["attributes"]
        layout = attributes["pendpin_sweep"]
    except (InputError, ValueError, LookupError, TypeError):
        raise InputError(f"it is not a store of a sweep; {REMEDY}") from None
    if layout != FORMAT:
        also = "xarray.open_zarr still reads its numbers; name another store"
        raise InputError(f"it is a store of another version of pendpin, in format {layout} instead of {FORMAT}; {also}")
    import xarray

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        data = xarray.open_zarr(str(path), consolidated=False, chunks=None, zarr_format=3).load()
    keys = tuple(data.attrs["keys"])
    varied = {key: data[name].values for key, name in zip(keys, short_names(keys), strict=True)}
    if Plan(keys, varied, CASE not in data.dims).identity != data.attrs["cases"]:
        raise InputError(f"the numbers that are varied are damaged; {REMEDY}")
    why = data["why"]
    data["why"] = (why.dims, why.values.astype(object), why.attrs, why.encoding)
    blocks_left(data)  # sound, before the work begins
    return data


def finished(data: Any) -> Any:
    """What is done of a sweep; the rest is NaN, with the reason "not run"."""
    data, blocks = data.copy(deep=True), _blocks_of(data)
    for block in blocks_left(data):
        for name in data.attrs["measures"]:
            data[name].values[blocks.region(block)] = np.nan
        data["why"].values[blocks.region(block)] = NOT_RUN
    data = data[[*data.attrs["measures"], "why"]].drop_encoding()
    if ATTRACTOR in data and PART in data[ATTRACTOR].dims:  # their numbers in place of what is stored of them
        numbers, kinds = number_attractors(data[ATTRACTOR].values)
        data[ATTRACTOR] = (data[ATTRACTOR].dims[:-1], numbers, {KINDS: kinds})
    return data


def write_table(dataset: Any, path: Path) -> Path:
    """Write every case as a row of a CSV file, whole or not at all: its numbers, its measures, why it has none."""
    keys = [str(key) for key in dataset.attrs["keys"]]
    names = [str(name) for name in dataset.data_vars]
    varied = [dataset[name] for name in short_names(keys)]
    grids = [values.broadcast_like(dataset["why"]).transpose(*dataset["why"].dims).values for values in varied]
    count, heads = dataset["why"].size, list(keys)
    columns = [grid.reshape(count, 1) for grid in grids]
    for name in names:
        columns.append(dataset[name].values.reshape(count, -1))
        places = np.ndindex(dataset[name].shape[dataset["why"].ndim :])
        heads += [f"{name}{''.join(f'[{i}]' for i in place)}" for place in places]
    rows = zip(*(column[:, i].tolist() for column in columns for i in range(column.shape[1])), strict=True)
    return write_csv(path, heads, rows)


def _blocks_of(data: Any) -> Blocks:
    return Blocks(data["why"].shape, int(np.prod(data["why"].encoding["chunks"])))


def blocks_left(data: Any) -> list[int]:
    """The blocks that are not done, or whose checksum is not that of their values."""
    blocks, done, why = _blocks_of(data), data["done"].values, data["why"].values
    measures, left = [data[name].values for name in data.attrs["measures"]], []
    for block in range(blocks.blocks):
        region = blocks.region(block)
        if not done[block] or _checksum([values[region] for values in measures], why[region]) != done[block]:
            left.append(block)
    return left


def _checksum(measures: Iterable[Array], why: Array) -> int:
    """A checksum above 0 of a block's values and reasons. Every NaN counts as the same one."""
    checksum = zlib.crc32("\n".join(why.ravel().tolist()).encode())
    for values in measures:
        checksum = zlib.crc32(np.where(np.isnan(values), np.nan, values).tobytes(), checksum)
    return checksum + 1


def _change(name: str, there: Any, here: Any) -> str:
    """How the identity of a store and that of this sweep differ, in words."""
    if name == "cases":
        return "its cases have other numbers"
    if name in ("scene", "versions"):
        there, here = ({} if text is None else leaves(json.loads(text)) for text in (there, here))
        name = next((key for key in {**here, **there} if there.get(key) != here.get(key)), name)
        there, here = there.get(name), here.get(name)
    return f"{name}: {shown(there, 40)} there and {shown(here, 40)} here"


@contextmanager
def _one_line(path: Path | None, done: str = "written") -> Iterator[None]:
    """What goes wrong with the store, a full disk or a file that is gone, is an InputError that names it."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {str(error).removeprefix(f'{path}: ')}") from None
    except Exception as error:  # Zarr and its codecs raise many kinds
        if isinstance(error, OSError) and error.strerror:
            raise InputError(f"{path}: cannot be {done}: {error.strerror}") from None
        reason = str(error).partition("\n")[0]
        raise InputError(f"{path}: it is not a sound store of a sweep ({reason}); {REMEDY}") from None
