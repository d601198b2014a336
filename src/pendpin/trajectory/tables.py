"""A run as a table: in pandas, or as comma-separated values."""

from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.files import refuse_other_format, write_csv
from pendpin.libraries import optional
from pendpin.trajectory.columns import AXES, UNITS, WRENCH, unit_of

ROWS_AT_ONCE = 4096
TABLES = (".csv", ".txt")


def to_pandas(run: Any) -> Any:
    """A DataFrame, the time its index, a column for each quantity. Raises MissingLibrary without pandas."""
    pandas = optional("pandas", "to_pandas", "pandas")
    table = {name: run[name] for name in run.names if name != "t"}
    frame = pandas.DataFrame(table, index=pandas.Index(run.t, name="t"))
    frame.attrs["units"] = {name: unit_of(run, name) for name in run.names}
    return frame


def to_xarray(run: Any) -> Any:
    """A Dataset over time t, joint, rod, axis and component, with units. Raises MissingLibrary."""
    xarray = optional("xarray", "to_xarray", "xarray")
    units = {name: f"{UNITS[name]}, of slides {UNITS[name].replace('rad', 'm')}" for name in "qva"}
    per_joint = {name: (("t", "joint"), getattr(run, name), {"units": unit}) for name, unit in units.items()}
    fixed = {
        "wrench": (("t", "joint", "component"), run.wrench, {"units": "N, of moments N m"}),
        "tips": (("t", "rod", "axis"), run.tips, {"units": "m"}),
        "kinetic": (("t",), run.kinetic, {"units": "J"}),
        "potential": (("t",), run.potential, {"units": "J"}),
    }
    reactions = {} if run.rod_reactions is None else run.rod_reactions._asdict()
    fixed |= {name: (("t", "rod"), values, {"units": UNITS[name]}) for name, values in reactions.items()}
    fixed |= {f"work_{kind}": (("t",), work, {"units": "J"}) for kind, work in run.work.items()}
    coordinates = {
        "t": ("t", run.t, {"units": "s"}),
        "joint": list(run.joints),
        "rod": np.arange(1, run.tips.shape[1] + 1),
        "axis": list(AXES),
        "component": list(WRENCH),
    }
    return xarray.Dataset(per_joint | fixed, coordinates, {"title": run.title, "method": run.stats.method})


def to_csv(run: Any, path: str | Path) -> Path:
    """Write a run's quantities with their names in the first line, whole or not at all; every digit is kept."""
    refuse_other_format(Path(path), *TABLES)
    rows = np.array([run[name] for name in run.names]).T
    pieces = (rows[first : first + ROWS_AT_ONCE].tolist() for first in range(0, len(rows), ROWS_AT_ONCE))
    return write_csv(Path(path), run.names, chain.from_iterable(pieces))
