"""A run as a table: in pandas, or as comma-separated values."""

from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.ground.files import path_of, refuse_other_format, write_csv
from pendpin.ground.libraries import optional
from pendpin.trajectory.columns import AXES, UNITS, WRENCH, is_chain, unit_of

ROWS_AT_ONCE = 4096  # turned into text: bounds the memory that a long run takes
TABLES = (".csv", ".txt")


def to_pandas(run: Any, names: Sequence[str] = ()) -> Any:
    """A DataFrame, the time its index, a column for each quantity. Raises MissingLibrary without pandas."""
    pandas = optional("pandas", "to_pandas", "pandas")
    _, *names = _t_first(run, names)
    frame = pandas.DataFrame({name: run[name] for name in names}, index=pandas.Index(run.t, name="t"))
    frame.attrs["units"] = {name: unit_of(run, name) for name in ("t", *names)}
    return frame


def _t_first(run: Any, names: Sequence[str]) -> tuple[str, ...]:
    """The time, then the names; all of the run's if there are none."""
    return ("t", *(name for name in names or run.names if name != "t"))


def to_xarray(run: Any) -> Any:
    """A Dataset over time t, joint, rod or link, axis and component, with units. Raises MissingLibrary."""
    xarray = optional("xarray", "to_xarray", "xarray")
    units = {name: f"{UNITS[name]}, of slides {UNITS[name].replace('rad', 'm')}" for name in "qva"}
    per_joint = {name: (("t", "joint"), getattr(run, name), {"units": unit}) for name, unit in units.items()}
    rods, count = 0 if run.rod_reactions is None else run.rod_reactions.R1.shape[1], run.tips.shape[1]
    bodies = {"rod": range(1, rods + 1)} if rods else {}
    bodies |= {} if rods == count else {"link": run.links or range(1, count + 1)}
    fixed = {
        "wrench": (("t", "joint", "component"), run.wrench, {"units": "N, of moments N m"}),
        "tips": (("t", list(bodies)[-1], "axis"), run.tips, {"units": "m"}),
        "kinetic": (("t",), run.kinetic, {"units": "J"}),
        "potential": (("t",), run.potential, {"units": "J"}),
    }
    reactions = {} if run.rod_reactions is None else run.rod_reactions._asdict()
    fixed |= {name: (("t", "rod"), values, {"units": UNITS[name]}) for name, values in reactions.items()}
    if is_chain(run):
        fixed |= {"tension": (("t", "rod"), reactions["R3"], {"units": "N"})}
        fixed |= {f"omega{k + 1}": (("t", "rod"), run.omega[..., k], {"units": UNITS["omega"]}) for k in range(3)}
        fixed["swing"] = (("t",), run["swing"], {"units": UNITS["swing"]})
        fixed["angular_momentum"] = (("t", "axis"), run.angular_momentum, {"units": UNITS["angular_momentum"]})
    fixed |= {f"work_{kind}": (("t",), work, {"units": "J"}) for kind, work in run.work.items()}
    coordinates = {
        "t": ("t", run.t, {"units": "s"}),
        "joint": list(run.joints),
        **{name: list(labels) for name, labels in bodies.items()},
        "axis": list(AXES),
        "component": list(WRENCH),
    }
    dataset = xarray.Dataset(per_joint | fixed, coordinates, {"title": run.title, "method": run.stats.method})
    return dataset.copy(deep=True)  # the arrays of the run are read-only


def to_csv(run: Any, path: str | Path, names: Sequence[str] = ()) -> Path:
    """Write a run's quantities with their names in the first line, whole or not at all; every digit is kept."""
    path = path_of(path)
    refuse_other_format(path, *TABLES)
    names = _t_first(run, names)
    rows = np.array([run[name] for name in names]).T
    pieces = (rows[first : first + ROWS_AT_ONCE].tolist() for first in range(0, len(rows), ROWS_AT_ONCE))
    return write_csv(path, names, chain.from_iterable(pieces))
