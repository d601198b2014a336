"""Which cases a sweep has: a grid, pairs, random samples or the rows of a CSV file, over numbers named by key paths."""

import json
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, inside, not_one_of, say_note, shown
from pendpin.ground.arguments import numbers, parsed, whole_number
from pendpin.ground.arrays import Array, ArrayLike, Indices
from pendpin.ground.files import csv_table, number_in, path_of, read_whole
from pendpin.ground.report import Report, Table

CASE = "case"  # the dimension of cases that are not a grid
RESERVED = ("why", "done", "block", CASE)  # variables and dimensions of a result
MOST_CASES = 100_000_000
MAX_CSV_BYTES = 100_000_000
METHODS = ("random", "latin", "sobol")  # of sampling
UNEVEN = "{} points of a Sobol' sequence are not evenly spread: take a power of 2"
_NORMAL = re.compile(r"normal\(([^,]+),([^,]+)\)")

Spread = tuple[str, float, float]  # "uniform", low, high; or "normal", mean, standard deviation


@dataclass(frozen=True, eq=False)
class Plan:
    """The cases of a sweep: a grid has a dimension for each key path, by its short name, with `values[key]` along it.

    Anything else has the one dimension "case", and `values[key]` holds a number for each case.
    """

    keys: tuple[str, ...]
    values: Mapping[str, Array]
    grid: bool

    def __post_init__(self) -> None:
        if not self.keys:
            raise InputError("vary: nothing is varied; name a number of the scene, such as model.rods[0].length")
        if self.count > MOST_CASES:
            raise InputError(f"vary: {self.count} cases are more than {MOST_CASES}")

    @property
    def dims(self) -> dict[str, int]:
        """The dimensions and their sizes."""
        return dict(zip(short_names(self.keys) if self.grid else [CASE], self.shape, strict=True))

    @property
    def shape(self) -> tuple[int, ...]:
        """The sizes of the dimensions."""
        return tuple(len(self.values[key]) for key in self.keys[: None if self.grid else 1])

    @property
    def count(self) -> int:
        """How many cases there are."""
        return int(np.prod(self.shape))

    def rows(self, places: Indices) -> Array:
        """The numbers (cases, keys) of some cases, by their places in C order."""
        indices = np.unravel_index(places, self.shape) if self.grid else [places] * len(self.keys)
        return np.stack([self.values[key][index] for key, index in zip(self.keys, indices, strict=True)], -1)

    @property
    def identity(self) -> str:
        """A digest of all cases, which differs for any other sweep."""
        digest = sha256(json.dumps([self.keys, self.grid]).encode())
        for key in self.keys:
            digest.update(np.ascontiguousarray(self.values[key]).tobytes())
        return digest.hexdigest()[:32]


def short_names(keys: Sequence[str]) -> list[str]:
    """A name for each key path, as `.sel(length=...)` takes it: as few of its last parts as tell it apart. InputError."""
    parts = [[re.sub(r"\W", "_", str(part)) for part in parsed(key)] for key in keys]
    names: list[str] = []
    for i, own in enumerate(parts):
        tails = ["_".join(own[-count:]) for count in range(1, len(own) + 1)]
        rest = parts[:i] + parts[i + 1 :]
        others = {"_".join(other[-count:]) for other in rest for count in range(1, len(other) + 1)}
        free = (name for name in tails if name.isidentifier() and name not in {*others, *RESERVED, *names})
        names.append(next(free, f"varied_{i + 1}"))
    return names


def grid(values: Mapping[str, ArrayLike]) -> Plan:
    """Every combination of the values (k,) of each key. Raises InputError for values that are not finite."""
    columns = _columns(values)
    return Plan(tuple(columns), columns, True)


def pairs(values: Mapping[str, ArrayLike]) -> Plan:
    """The first values of all keys, then the second ones, ... Raises InputError where keys differ in length."""
    columns = _columns(values)
    lengths = {key: len(column) for key, column in columns.items()}
    if len(set(lengths.values())) > 1:
        words = ", ".join(f"{key} has {length}" for key, length in lengths.items())
        raise InputError(f"vary: pairs need as many values for each key: {words}")
    return Plan(tuple(columns), columns, False)


def samples(spreads: Mapping[str, Spread], count: int, method: str = "latin", seed: int = 0) -> Plan:
    """`count` random cases, each key uniform or normal, by scipy.stats.qmc: Latin hypercube, Sobol' or plain random.

    Raises InputError for a count, method or spread that cannot be.
    """
    from scipy.stats import qmc

    count = whole_number("sample", count, most=MOST_CASES)
    seed = whole_number("seed", seed, least=0)
    if method not in METHODS:
        raise InputError(f"sample: {not_one_of(method, METHODS)}")
    if method == "random":
        unit = np.random.default_rng(seed).random((count, len(spreads)))
    elif method == "latin":
        unit = qmc.LatinHypercube(len(spreads), rng=seed).random(count)
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # SciPy's, of what UNEVEN says
            unit = qmc.Sobol(len(spreads), rng=seed).random(count)
        if count & (count - 1):
            say_note(UNEVEN.format(count), stacklevel=3)
    return Plan(tuple(spreads), spread_out(spreads, unit), False)


def spread_out(spreads: Mapping[str, Spread], unit: Array) -> dict[str, Array]:
    """The values (n,) of each key from numbers (n, keys) in 0 to 1, by the inverse of its distribution. InputError."""
    from scipy.stats import norm

    unit = np.clip(unit, 2.0**-53, 1 - 2.0**-53)  # so that a normal one stays finite
    columns = {}
    for (key, (kind, one, other)), u in zip(spreads.items(), unit.T, strict=True):
        if kind not in ("uniform", "normal"):
            raise InputError(f"vary: {key}: {not_one_of(kind, ('uniform', 'normal'))}")
        if not np.isfinite(other - one) or (one >= other if kind == "uniform" else other <= 0):
            right = "a lower and a higher number" if kind == "uniform" else "a mean and a standard deviation above 0"
            raise InputError(f"vary: {key}: {one:g}, {other:g}: {right} are wanted")
        columns[key] = one + u * (other - one) if kind == "uniform" else np.asarray(norm.ppf(u, one, other))
    return columns


def cases_of(path: str | Path) -> Plan:
    """The cases in a CSV file: a head line of key paths, then a row of numbers for each case. Raises InputError."""
    path = path_of(path)
    with inside(str(path)):
        keys, rows = csv_table(read_whole(path, MAX_CSV_BYTES, "a CSV of cases"))
        if not rows:
            raise InputError("it has no cases: rows of numbers are wanted behind the first line")
        cells = [[number_in(f"line {n}: {key}", x) for key, x in zip(keys, row, strict=True)] for n, row in rows]
        return pairs({key: [row[i] for row in cells] for i, key in enumerate(keys)})


# --- as on the command line -----------------------------------------------------------------------------------------


def read_axes(texts: Sequence[str]) -> dict[str, Array]:
    """Values (k,) by key from texts like KEY=FROM:TO:COUNT or KEY=1,2,5. Raises InputError."""
    axes = dict[str, Array]()
    for key, where, text in _split(texts):
        parts = text.split(":")
        if len(parts) == 1:
            axes[key] = np.array([number_in(where, part) for part in text.split(",")])
            continue
        if len(parts) != 3 or not parts[2].strip().isdecimal() or not 1 <= int(parts[2]) <= MOST_CASES:
            raise InputError(f"{where}: {shown(text)} is not FROM:TO:COUNT with a count from 1 to {MOST_CASES}")
        with np.errstate(all="ignore"):  # what is not finite is refused with its key
            axes[key] = np.linspace(number_in(where, parts[0]), number_in(where, parts[1]), int(parts[2]))
    return axes


def read_spreads(texts: Sequence[str]) -> dict[str, Spread]:
    """Spreads by key from texts like KEY=LOW:HIGH or KEY=normal(MEAN,DEVIATION). Raises InputError."""
    spreads = dict[str, Spread]()
    for key, where, text in _split(texts):
        normal = _NORMAL.fullmatch(text)
        parts = normal.groups() if normal else text.split(":")
        if len(parts) != 2:
            raise InputError(f"{where}: {shown(text)} is not LOW:HIGH or normal(MEAN,DEVIATION), as --sample takes")
        spreads[key] = ("normal" if normal else "uniform"), number_in(where, parts[0]), number_in(where, parts[1])
    return spreads


def _split(texts: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Each key, the words that name it in an error, and the text after its equals sign. Raises InputError."""
    keys = set[str]()
    for text in texts:
        key, sign, rest = (part.strip() for part in text.partition("="))
        if not (key and sign and rest):
            raise InputError(f"--vary: {shown(text)} is not KEY=FROM:TO:COUNT, such as model.rods[0].length=0.5:2:16")
        if key in keys:
            raise InputError(f"--vary: {key} is given twice")
        keys.add(key)
        yield key, f"--vary: {key}", rest


# --- what is refused ------------------------------------------------------------------------------------------------


def _columns(given: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """The finite numbers (k,) of each key. Raises InputError for anything else."""
    if not isinstance(given, Mapping):
        raise InputError(f"vary: {shown(given)} is not a mapping of key paths to numbers")
    columns = dict[str, Array]()
    for key, sequence in given.items():
        if not isinstance(key, str):
            raise InputError(f"vary: {shown(key)} is not a key path, such as model.rods[0].mass")
        values = numbers(f"vary: {key}", sequence).copy()
        if values.ndim != 1 or not len(values):
            raise InputError(f"vary: {key}: a list of one or more numbers is wanted, not shape {values.shape}")
        if not np.isfinite(values).all():
            first = int(np.argmin(np.isfinite(values)))
            raise InputError(f"vary: {key}: {values[first]}, the value at place {first}, is not a finite number")
        columns[key] = values
    return columns


# --- sobol' indices -------------------------------------------------------------------------------------------------

LEVEL = 0.95  # of the confidence intervals
CONSTANT = 1e-12  # of the largest value: what varies by less is rounding, as the swing of rods that begin at rest
RESAMPLES = 200  # bootstrap: the half-widths are then known to a twentieth


def sobol_plan(spreads: Mapping[str, Spread], count: int, seed: int = 0) -> Plan:
    """The cases of Saltelli's scheme: for each of `count` a row of A, one for each key with its B, one of B. InputError."""
    from scipy.stats import qmc

    if count < 2 or count & (count - 1):
        raise InputError(f"sobol: {count} is not a power of 2 above 1, such as {1 << max(1, int(count).bit_length())}")
    keys = len(spreads)
    if (cases := count * (keys + 2)) > MOST_CASES:
        raise InputError(f"sobol: {count} base cases make {cases} cases, more than {MOST_CASES}")
    unit = qmc.Sobol(2 * keys, rng=seed).random(count)
    rows = np.repeat(unit[:, None, :keys], keys + 2, axis=1)  # (count, keys + 2, keys), all of them A
    for i in range(keys):
        rows[:, 1 + i, i] = unit[:, keys + i]
    rows[:, -1] = unit[:, keys:]
    return pairs(spread_out(spreads, rows.reshape(cases, keys)))


def indices(spreads: Mapping[str, Spread], values: Any, seed: int = 0) -> dict[str, dict[str, float]]:
    """First-order and total indices of each key with half-widths of their 95 % intervals, from a measure (cases,).

    Saltelli et al. 2010 (Computer Physics Communications 181, 259), table 2 (b) and (f); the intervals by bootstrap over the
    base cases. Raises InputError where a case has no value, because the scheme needs every one.
    """
    from scipy import stats

    y = np.asarray(values, float)
    if not np.isfinite(y).all():
        none = int((~np.isfinite(y)).sum())
        raise InputError(f"sobol: {none} of {y.size} cases have no value; narrow what is varied")
    if np.ptp(y) <= CONSTANT * np.abs(y).max():
        return {key: {"first": 0.0, "first_conf": 0.0, "total": 0.0, "total_conf": 0.0} for key in spreads}
    columns = y.reshape(-1, len(spreads) + 2).T  # (keys + 2, base cases)
    columns = columns - columns[[0, -1]].mean()

    def estimate(base_cases: Array) -> Array:  # SciPy's sobol_indices draws its intervals without a seed
        a, b, mixed = columns[0, base_cases], columns[-1, base_cases], columns[1:-1, base_cases]
        variance = np.var([a, b]) or np.inf
        return np.array([(b * (mixed - a)).mean(1), ((a - mixed) ** 2).mean(1) / 2]) / variance

    everything = np.arange(columns.shape[1])
    first, total = estimate(everything)
    settings: dict[str, Any] = {"n_resamples": RESAMPLES, "method": "percentile", "vectorized": False}
    spread = stats.bootstrap([everything], estimate, rng=np.random.default_rng(seed), **settings).standard_error
    width = stats.norm.ppf(0.5 + LEVEL / 2) * spread
    table = zip(spreads, first, width[0], total, width[1], strict=True)
    names = ("first", "first_conf", "total", "total_conf")
    return {key: dict(zip(names, map(float, row), strict=True)) for key, *row in table}


def shares_report(spreads: Mapping[str, Spread], measures: Mapping[str, Any], seed: int) -> Report:
    """The shares of each measure (cases,) that the varied numbers cause. Raises InputError where a case has no value."""
    shares = {name: indices(spreads, values, seed) for name, values in measures.items()}
    parts: list[str | Table] = []
    for name, rows in shares.items():
        cells = [(key, *(f"{x:.3f}" for x in row.values())) for key, row in rows.items()]
        parts.append(f"Shares of the variance of {name} (95 % intervals):")
        parts.append(Table(("varied", "alone", "+-", "with all others", "+-"), cells))
    return Report(parts, {"sobol": shares})
