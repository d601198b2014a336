"""The results of a sweep, in memory or in a Zarr store that is written block by block, each whole or not at all.

A store holds a variable for each measure over the dimensions of the plan, `why`, the coordinates, and `done`: for each block
0, or a checksum of its values, which is written behind them. A block whose values have another checksum is run again.
"""

import json
import os
import shutil
import warnings
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, shown
from pendpin.ground.arrays import Array
from pendpin.ground.files import read_whole, write_csv
from pendpin.sweeps.plan import CASE, Plan, short_names
from pendpin.sweeps.task import Block, Task, versions

FORMAT = 3
MAX_JSON = 100_000_000  # bytes, of a store's own description
NOT_RUN = "not run"  # why a case of a block that is not done has no measures
REMEDY = "delete it or name another store"


class Blocks:
    """How the cases are cut: block i is the cases from i * size on, whole rows of the trailing dimensions."""

    def __init__(self, shape: tuple[int, ...], size: int) -> None:
        self.shape, self.count = shape, int(np.prod(shape))
        trailing = np.cumprod([1, *shape[::-1]])[::-1]  # cases behind one place of each dimension, and of all
        axis = int(np.argmax(trailing[1:] <= max(size, 1)))  # the first whose single places are small enough
        along = max(1, min(shape[axis], size // int(trailing[axis + 1])))
        self.chunks = (1,) * axis + (along,) + shape[axis + 1 :]
        self.grid = tuple(-(-n // c) for n, c in zip(shape, self.chunks, strict=True))
        self.blocks = int(np.prod(self.grid))

    @classmethod
    def of(cls, shape: tuple[int, ...], chunks: tuple[int, ...]) -> "Blocks":
        """The cut with these chunks."""
        return cls(shape, int(np.prod(chunks)))

    def region(self, block: int) -> tuple[slice, ...]:
        """Where a block is, as slices of the dimensions."""
        places = np.unravel_index(block, self.grid)
        return tuple(
            slice(int(i) * c, min((int(i) + 1) * c, n)) for i, c, n in zip(places, self.chunks, self.shape, strict=True)
        )

    def span(self, block: int) -> tuple[int, int]:
        """The first case of a block, and the one behind its last, in C order."""
        region = self.region(block)
        first = int(np.ravel_multi_index([s.start for s in region], self.shape))
        return first, first + int(np.prod([s.stop - s.start for s in region]))


class Store:
    """Results in a Zarr store, in memory where there is no path; made anew, or resumed where it is there.

    Raises InputError where that cannot be.
    """

    def __init__(self, task: Task, path: Path | None, size: int) -> None:
        self.task, self.path = task, path
        with _one_line(path):
            import zarr
            from zarr.storage import MemoryStore

            blocks, resumed = Blocks(task.plan.shape, size), path is not None and path.exists()
            self._store: Any = MemoryStore() if path is None else str(path)
            if path is None:
                _fill(self._store, task, blocks)
            elif not resumed:
                _create(task, blocks, path)
            else:
                _refuse_unread(path)
            self._group: Any = zarr.open_group(self._store, mode="r+", zarr_format=3)
            _refuse_foreign(self._group.attrs)
            for name, value in _identity(task).items():
                if (there := self._group.attrs.get(name)) != value:
                    raise InputError(f"it holds another sweep: {_change(name, there, value)}; {REMEDY}")
            if resumed:
                self.dataset()  # sound, before the work begins
            self.blocks = Blocks.of(task.plan.shape, tuple(self._group["why"].chunks))

    def left(self) -> list[int]:
        """The blocks that are not done."""
        with _one_line(self.path):
            return _left({name: self._group[name][...] for name in _stored(self._group.attrs)}, self.blocks)

    def put(self, block: int, results: Block) -> None:
        """Write the results of a block, then that it is done."""
        region = self.blocks.region(block)
        shape = tuple(s.stop - s.start for s in region)
        with _one_line(self.path):
            group = self._group
            for m, column in zip(self.task.chosen, results.values.T, strict=True):
                group[m.name][region] = column.reshape(shape)
            if any(results.why):
                group["why"][region] = results.why.reshape(shape)
            group["done"][block] = _checksum(results.values.T, results.why)

    def dataset(self) -> Any:
        """The xarray.Dataset of the store, read when it is asked for."""
        with _one_line(self.path, "read"):
            return _dataset(self._store)


def load(path: Path) -> Any:
    """The xarray.Dataset of a store, finished or not. Raises InputError for anything else."""
    with _one_line(path, "read"):
        if not path.is_dir():
            raise InputError("there is no store of a sweep")
        _refuse_unread(path)
        return _dataset(str(path))


def _dataset(store: Any) -> Any:
    """What is done of a store; the rest is NaN, with the reason "not run"."""
    with _quiet():
        import xarray

        dataset = xarray.open_zarr(store, consolidated=False, chunks=None, zarr_format=3)
        _refuse_foreign(dataset.attrs)
        dataset, keys = dataset.load(), tuple(dataset.attrs["keys"])
        varied = short_names(keys)
        plan = Plan(
            keys, {key: dataset[name].values for key, name in zip(keys, varied, strict=True)}, CASE not in dataset.dims
        )
        if plan.identity != dataset.attrs["cases"]:
            raise InputError(f"the numbers that are varied are damaged; {REMEDY}")
        blocks, dims = Blocks.of(plan.shape, dataset["why"].encoding["chunks"]), dataset["why"].dims
        arrays = {name: dataset[name].values for name in _stored(dataset.attrs)}
        arrays["why"] = arrays["why"].astype(object)
        for block in _left(arrays, blocks):
            for name in dataset.attrs["measures"]:
                arrays[name][blocks.region(block)] = np.nan
            arrays["why"][blocks.region(block)] = NOT_RUN
        del arrays["done"]
        variables = {name: (dims, array, dataset[name].attrs) for name, array in arrays.items()}
        coordinates = {name: dataset[name].variable for name in dict.fromkeys([*dims, *varied])}
        return xarray.Dataset(variables, coordinates, dataset.attrs)


def write_table(dataset: Any, path: Path) -> Path:
    """Write every case as a row of a CSV file, whole or not at all: its numbers, its measures, why it has none."""
    keys = [str(key) for key in dataset.attrs["keys"]]
    names = [str(name) for name in dataset.data_vars]
    varied = [dataset[name] for name in short_names(keys)]
    grids = [values.broadcast_like(dataset["why"]).transpose(*dataset["why"].dims).values for values in varied]
    columns = [*grids, *(dataset[name].values for name in names)]
    return write_csv(path, [*keys, *names], zip(*(column.ravel().tolist() for column in columns), strict=True))


def _stored(attributes: Any) -> list[str]:
    """The arrays of a store that hold results."""
    return [*attributes["measures"], "why", "done"]


def _left(arrays: Mapping[str, Array], blocks: Blocks) -> list[int]:
    """The blocks that are not done, or have not the checksum of their values, from arrays (dims), and done (blocks,)."""
    *measures, why, done = arrays.values()

    def sound(block: int) -> bool:
        region = blocks.region(block)
        return _checksum([values[region].ravel() for values in measures], why[region].ravel()) == done[block]

    return [block for block in range(blocks.blocks) if not done[block] or not sound(block)]


def _checksum(measures: Iterable[Array], why: Array) -> int:
    """A number above 0 of the values of a block's measures (cases,) and its reasons (cases,)."""
    checksum = zlib.crc32("\n".join(why.tolist()).encode())
    for values in measures:
        checksum = zlib.crc32(
            np.where(np.isnan(values), np.nan, values).tobytes(), checksum
        )  # one NaN, whatever its bits
    return checksum + 1


def _refuse_unread(path: Path) -> None:
    """Raises InputError for a folder that is not a store of a sweep in Zarr 3, by its JSON alone.

    No array is opened for that: a filter of the formats before, as numcodecs' Pickle, runs code when it reads.
    """
    try:
        attributes = json.loads(read_whole(path / "zarr.json", MAX_JSON, "a store's description"))["attributes"]
    except (InputError, ValueError, LookupError, TypeError):
        raise InputError(f"it is not a store of a sweep; {REMEDY}") from None
    _refuse_foreign(attributes)


def _refuse_foreign(attributes: Any) -> None:
    """Raises InputError for the attributes of a group that is not a store of a sweep."""
    layout = attributes.get("pendpin_sweep")
    if layout is None:
        raise InputError(f"it is not a store of a sweep; {REMEDY}")
    if layout != FORMAT:
        also = "xarray.open_zarr still reads its numbers; name another store"
        raise InputError(f"it is a store of another version of pendpin, in format {layout} instead of {FORMAT}; {also}")


def _identity(task: Task) -> dict[str, Any]:
    """What has to be the same for a sweep to be gone on with."""
    return {
        "scene": json.dumps(task.scene.recorded(), sort_keys=True),
        "keys": list(task.plan.keys),
        "cases": task.plan.identity,
        "measures": [m.name for m in task.chosen],
        "versions": json.dumps(versions(), sort_keys=True),
    }


def _change(name: str, there: Any, here: Any) -> str:
    """How the identity of a store and that of this sweep differ, in words."""
    if name == "cases":
        return "its cases have other numbers"
    if name in ("scene", "versions"):
        there, here = ({} if text is None else _leaves(json.loads(text)) for text in (there, here))
        name = next(key for key in {**here, **there} if there.get(key) != here.get(key))
        there, here = there.get(name), here.get(name)
    return f"{name}: {shown(there, 40)} there and {shown(here, 40)} here"


def _leaves(value: Any, path: str = "") -> dict[str, Any]:
    """The numbers and texts of nested tables and lists, by key path."""
    if isinstance(value, dict):
        parts = [(f"{path}.{name}" if path else name, part) for name, part in value.items()]
    elif isinstance(value, list):
        parts = [(f"{path}[{i}]", part) for i, part in enumerate(value)]
    else:
        return {path: value}
    return {key: leaf for place, part in parts for key, leaf in _leaves(part, place).items()}


def _create(task: Task, blocks: Blocks, path: Path) -> None:
    """Make an empty store beside its place, then put it there."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    shutil.rmtree(draft, ignore_errors=True)
    try:
        _fill(str(draft), task, blocks)
        try:
            draft.rename(path)
        except OSError:
            if not path.exists():  # else another command was faster
                raise
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _fill(store: Any, task: Task, blocks: Blocks) -> None:
    """Write what is known of a sweep before it runs: the coordinates, and arrays without results."""
    import zarr

    plan, dims = task.plan, list(task.plan.dims)
    with _quiet():
        group = zarr.open_group(store, mode="w")
        group.attrs.update({**_identity(task), "pendpin_sweep": FORMAT})
        for m in task.chosen:
            _array(group, m.name, blocks.shape, blocks.chunks, "f8", np.nan, dims)
        _array(group, "why", blocks.shape, blocks.chunks, str, "", dims)
        _array(group, "done", (blocks.blocks,), (1,), "i8", 0, ["block"])
        coordinates = {} if plan.grid else {CASE: (CASE, np.arange(plan.count), {})}
        for name, key in zip(short_names(plan.keys), plan.keys, strict=True):
            coordinates[name] = (name if plan.grid else CASE, plan.values[key], {"key": key})
        for name, (dimension, values, attributes) in coordinates.items():
            array = _array(group, name, values.shape, values.shape, values.dtype.str, 0, [dimension])
            array[:] = values
            array.attrs.update(attributes)
        for name, unit in task.units.items():
            group[name].attrs["units"] = unit
        zarr.consolidate_metadata(store)  # which readers look for, and warn where it is not


def _array(
    group: Any, name: str, shape: tuple[int, ...], chunks: tuple[int, ...], dtype: Any, fill: Any, names: list[str]
) -> Any:
    return group.create_array(name, shape=shape, chunks=chunks, dtype=dtype, fill_value=fill, dimension_names=names)


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


@contextmanager
def _quiet() -> Iterator[None]:
    """Zarr warns of text, which other readers of the format may lack."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
