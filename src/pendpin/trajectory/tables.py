"""A run as a table: in pandas, or as comma-separated values."""

from io import TextIOWrapper
from pathlib import Path
from typing import IO, Any

import numpy as np

from pendpin.files import refuse_other_format, write_whole
from pendpin.libraries import optional

ROWS_AT_ONCE = 4096
TABLES = (".csv", ".txt")


def to_pandas(run: Any) -> Any:
    """A DataFrame, the time its index, a column for each quantity. Raises MissingLibrary without pandas."""
    pandas = optional("pandas", "to_pandas", "pandas")
    table = {name: run[name] for name in run.names if name != "t"}
    return pandas.DataFrame(table, index=pandas.Index(run.t, name="t"))


def to_csv(run: Any, path: str | Path) -> Path:
    """Write a run's quantities with their names in the first line, whole or not at all; every digit is kept."""
    refuse_other_format(Path(path), *TABLES)
    rows = np.array([run[name] for name in run.names]).T

    def write(file: IO[bytes]) -> None:
        text = TextIOWrapper(file, "utf-8", newline="\n")
        text.write(",".join(map(_cell, run.names)) + "\n")
        for first in range(0, len(rows), ROWS_AT_ONCE):
            text.writelines(",".join(map(repr, row)) + "\n" for row in rows[first : first + ROWS_AT_ONCE].tolist())
        text.detach()  # flushes, and leaves the file open

    return write_whole(Path(path), write)


def _cell(name: str) -> str:
    """A name as a cell: in quotes where it holds what would end one."""
    return '"' + name.replace('"', '""') + '"' if any(c in name for c in ',"\r\n') else name
