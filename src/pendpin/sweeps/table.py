"""What a sweep found as a table: counts of its cases, and every case as a row of a CSV file."""

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.arrays import Array
from pendpin.files import write_whole
from pendpin.sweeps.plan import short_names
from pendpin.sweeps.store import NOT_RUN


def summary(dataset: Any) -> Array:
    """How many cases there are, how many were not run, how many could not be: (3,)."""
    why = dataset["why"].values
    return np.array([why.size, (why == NOT_RUN).sum(), ((why != "") & (why != NOT_RUN)).sum()])


def write_table(dataset: Any, path: Path) -> Path:
    """Write every case as a row of a CSV file, whole or not at all: its numbers, its measures, why it has none."""
    keys = [str(key) for key in dataset.attrs["keys"]]
    names = [str(name) for name in dataset.data_vars]
    varied = [dataset[name] for name in short_names(keys)]
    grids = [values.broadcast_like(dataset["why"]).transpose(*dataset["why"].dims).values for values in varied]
    rows = zip(*(grid.ravel() for grid in grids), *(dataset[name].values.ravel() for name in names), strict=True)

    def write(file: Any) -> None:
        text = io.TextIOWrapper(file, encoding="utf-8", newline="", write_through=True)
        writer = csv.writer(text)
        writer.writerow([*keys, *names])
        writer.writerows([x if isinstance(x, str) else repr(float(x)) for x in row] for row in rows)
        text.detach()

    return write_whole(path, write)
