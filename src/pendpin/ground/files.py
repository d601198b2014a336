"""Reading files no further than is sane, and writing them whole or not at all."""

import csv
import os
import re
import shutil
import sys
import tempfile
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib import resources
from io import BytesIO, TextIOWrapper
from math import prod
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pendpin.errors import InputError, amount, choices, inside, shown

MAX_HEADER_BYTES = 10_000
MAX_ARRAYS_BYTES = 4_000_000_000  # what the arrays of one file may hold in all
MAX_TEXT_BYTES = 400_000_000  # of that, as text; a scene of 100,000 rods takes a tenth
MAX_ARRAYS = 1_000


def path_of(value: Any) -> Path:
    """The path that an argument names. Raises InputError for what is neither text nor a path."""
    if not isinstance(value, str | os.PathLike):
        raise InputError(f"{shown(value)} is not the path of a file")
    if value == "":  # Path makes it the folder "."
        raise InputError("the name of the file is empty")
    try:
        os.fsencode(value)
    except UnicodeEncodeError:
        raise InputError(f"{shown(value)} is not the path of a file: no name has such letters") from None
    return Path(value)


def read_whole(path: Path, most: int, what: str) -> bytes:
    """The bytes of a file. Raises InputError, without the path, where it cannot be read or has more than `most`."""
    with _reading(), _opened(path) as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise InputError(f"larger than the {most / 1e6:g} MB that {what} may have")
    return data


def text_of(data: bytes, kind: str) -> str:
    """The text of a file of a kind, such as CSV, without the mark that some editors write first. Raises InputError."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"not a {kind} file: byte {error.start} is not UTF-8 text") from None


def fill_template(package: str, path: str, **parts: str) -> str:
    """The text of a file of a package with parts in place of {{name}}, all at once: a part may contain such marks."""
    text = resources.files(package).joinpath(path).read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], text)


def csv_table(data: bytes) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The names in the first line of a CSV file, and the cells of each row below with its line. Raises InputError."""
    table = csv.reader(text_of(data, "CSV").splitlines(), strict=True)
    try:
        rows = [(table.line_num, row) for row in table if any(row)]
    except csv.Error as error:
        raise InputError(f"not a CSV file: {error}") from None
    if not rows:
        raise InputError("an empty file: a CSV starts with a line of column names")
    names = [name.strip() for name in rows[0][1]]
    for mark, name in ((";", "semicolons"), ("\t", "tabs")):
        if len(names) == 1 and mark in names[0]:
            raise InputError(f"columns are separated by {name}; separate them by commas, with decimal points")
    with suppress(ValueError):
        list(map(float, names))
        raise InputError("line 1 holds numbers; a CSV starts with a line of column names")
    if twice := [name for name in names if names.count(name) > 1]:
        raise InputError(f"column {shown(twice[0])} is there twice")
    for line, row in rows[1:]:
        if len(row) != len(names):
            cells, columns = amount(len(row), "cell"), amount(len(names), "column")
            raise InputError(f"line {line} has {cells}, where the first line names {columns}")
    return names, rows[1:]


def number_in(where: str, text: str) -> float:
    """The number that a cell, or a text of the command line, holds. Raises InputError."""
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{where}: {shown(text.strip())} is not a number") from None


def write_csv(path: Path, names: Iterable[str], rows: Iterable[Iterable[object]]) -> Path:
    """Write a table with the names of its columns in the first line, whole or not at all; every digit is kept."""

    def write(file: IO[bytes]) -> None:
        text = TextIOWrapper(file, "utf-8", newline="")
        table = csv.writer(text, lineterminator="\n")
        table.writerow(names)
        table.writerows(rows)
        text.detach()  # flushes, and leaves the file open

    return write_whole(path, write)


def _opened(path: Path) -> IO[bytes]:
    """A file to read from. A pipe is refused as a device is: it may never give anything, and has no end."""
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # not to wait
    if not os.path.isfile(number):
        os.close(number)
        raise InputError(f"cannot be read: it is a {_kind(path)}, not a file")
    return os.fdopen(number, "rb")


def _kind(path: Path) -> str:
    return "folder" if path.is_dir() else "pipe" if path.is_fifo() else "device"


@contextmanager
def _reading() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}") from None
    except ValueError:  # open() refuses nothing else about a path
        raise InputError("cannot be read: a null byte in the path") from None


def write_arrays(file: IO[bytes], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays as an .npz file, with the quickest compression."""
    # Of 1,000 rods, 75 MB, it takes half the time of NumPy's, and the file is a twentieth larger: digits hardly compress.
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asanyarray(array), allow_pickle=False)


def write_folder(path: Path, fill: Callable[[Path], object]) -> Path:
    """Make a new folder, filled by `fill(folder)`, whole or not at all. InputError where the name is taken, or refused."""
    if os.path.lexists(path):
        raise InputError(f"{path}: it exists already; give the name of a new folder")
    if not path.absolute().parent.is_dir():
        raise InputError(f"{path}: cannot be made: there is no folder {shown(str(path.parent))}")
    made = None
    try:
        made = Path(tempfile.mkdtemp(dir=path.absolute().parent, prefix=f".{path.name[:16]}."))
        fill(made)
        made.chmod(0o777 & ~_umask())
        os.rename(made, path)
        return path
    except (OSError, ValueError) as error:  # ValueError: a null byte in the path
        raise InputError(f"{path}: cannot be written: {getattr(error, 'strerror', None) or error}") from None
    finally:
        if made is not None:
            shutil.rmtree(made, ignore_errors=True)


def folder_of(name: str) -> Path:
    """A folder that comes with pendpin: in the installed package, or at the top of a checkout."""
    installed = Path(__file__).parents[1] / name
    return installed if installed.is_dir() else Path(__file__).parents[3] / name


def refuse_other_format(path: Path, *suffixes: str) -> None:
    """Raise InputError where a file has a suffix, and it is not one of those of what is written."""
    if path.suffix and path.suffix.lower() not in suffixes:
        ends = f"its name ends in {path.suffix}, and what is written is {choices(suffixes)}"
        raise InputError(f"{path}: {ends}; give another name")


def refuse_targets(targets: Iterable[Path], sources: Iterable[Path]) -> None:
    """Raise InputError if `write_whole` could not write each of these paths, or one is given twice, or is read too."""
    seen: set[Path] = set()
    for path in targets:
        write_whole(path, None)
        target = Path(os.path.realpath(path))
        read = target.exists() and any(os.path.exists(source) and target.samefile(source) for source in sources)
        if read or target in seen:
            raise InputError(f"{path}: this name is given twice; every file needs its own")
        seen.add(target)


def write_whole(path: Path, write: Callable[[IO[bytes]], object] | None) -> Path:
    """Write a file, by `write(open binary file)`, whole or not at all, behind symbolic links; with None see if that can be.

    It is written by way of a neighbour. Raises InputError where that is refused.
    """
    fault, temporary = f"{path}: cannot be written", None
    if "\0" in str(path):
        raise InputError(f"{fault}: a null byte in the path")
    try:
        target = Path(os.path.realpath(path))
        if target.is_symlink():
            raise InputError(f"{fault}: circular symbolic links")
        if target.exists() and not target.is_file():
            raise InputError(f"{fault}: it is a {_kind(target)}")
        if target.exists() and not os.access(target, os.W_OK, effective_ids=os.access in os.supports_effective_ids):
            raise InputError(f"{fault}: it is write-protected")
        if not target.parent.is_dir():
            raise InputError(f"{fault}: there is no folder {shown(str(path.parent))}")
        with tempfile.NamedTemporaryFile(dir=target.parent, prefix=f".{target.name[:16]}.", delete=False) as file:
            temporary = Path(file.name)
            if write is not None:
                write(file)
            file.flush()
            os.fsync(file.fileno())  # or a power cut could leave the new name with nothing in it
        temporary.chmod(target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~_umask())
        if write is not None:
            os.replace(temporary, target)
        return path
    except OSError as error:
        raise InputError(f"{fault}: {error.strerror or error}") from None
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


class Announced(NamedTuple):
    """What the header of an array says before the array is read."""

    dtype: np.dtype[Any]
    shape: tuple[int, ...]


class ArrayFile:
    """An open .npz file: the headers of its arrays, by name, and the arrays on demand. Nothing in it is executed."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        names = [name.removesuffix(".npy") for name in archive.namelist() if name.endswith(".npy")]
        if twice := [name for name, count in Counter(names).items() if count > 1]:
            raise ValueError(f"array {shown(twice[0])} is there twice")
        if len(names) > MAX_ARRAYS:
            raise ValueError(f"it holds {len(names)} arrays, more than {MAX_ARRAYS}")
        self.headers = dict[str, Announced]()
        for name in names:
            with archive.open(f"{name}.npy") as member:
                head = BytesIO(member.read(MAX_HEADER_BYTES))  # a longer header is cut off, and refused below
            try:
                with warnings.catch_warnings():  # of the literal's syntax, in newer Pythons
                    warnings.simplefilter("ignore")
                    first = np.lib.format.read_magic(head) == (1, 0)
                    read = np.lib.format.read_array_header_1_0 if first else np.lib.format.read_array_header_2_0
                    shape, _, dtype = read(head)
            except Exception:  # NumPy evaluates the header as a literal, which fails in many ways
                raise ValueError(f"array {shown(name)} has no header that NumPy writes") from None
            if dtype.hasobject or min(shape, default=0) < 0:
                raise ValueError(f"array {shown(name)} holds no plain numbers or text")
            self.headers[name] = Announced(dtype, shape)
        texts = [x for x in self.headers.values() if x.dtype.kind == "U"]
        limits = (("arrays", self.headers.values(), MAX_ARRAYS_BYTES), ("texts", texts, MAX_TEXT_BYTES))
        for what, those, most in limits:
            if (size := sum(header.dtype.itemsize * prod(header.shape) for header in those)) > most:
                raise ValueError(f"its {what} claim {size:.3g} bytes, more than {most:.3g}")

    def header(self, name: str) -> Announced:
        """The type and shape of an array; ValueError if there is none of this name."""
        if name not in self.headers:
            raise ValueError(f"array {name!r} is missing")
        return self.headers[name]

    def read(self, name: str) -> NDArray[Any]:
        """An array; ValueError if there is none of this name or its data are damaged."""
        self.header(name)
        with self._archive.open(f"{name}.npy") as member:
            array = np.lib.format.read_array(member, allow_pickle=False)
            if member.read(1):  # at the end its checksum is looked at
                raise ValueError(f"array {name!r} is longer than its header says")
        if array.dtype.kind == "U":  # Python takes letters beyond Unicode, and fails where such a text is used
            letters = np.frombuffer(array.astype(array.dtype.newbyteorder("=")).tobytes(), np.uint32)
            if letters.max(initial=0) > sys.maxunicode:
                raise ValueError(f"array {name!r} holds letters beyond Unicode")
        return array


@contextmanager
def open_arrays(path: Path, what: str) -> Iterator[ArrayFile]:
    """Open an .npz file; whatever is wrong with it, here or in the block, raises InputError: it is not `what`."""
    with inside(str(path)), _reading():
        file = _opened(path)
    try:
        with file, zipfile.ZipFile(file) as archive:
            yield ArrayFile(archive)
    except MemoryError:
        raise
    except Exception as error:  # zipfile, zlib and NumPy raise a dozen kinds for a damaged file
        raise InputError(f"{path}: not {what}: {str(error) or type(error).__name__}") from None
