"""Files of saved runs, good and damaged."""

import json
import struct
import warnings
import zipfile
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from pendpin.trajectory import Stats

N, NV = 4, 2
SAMPLES = {"tuple": (), "bool": True, "float": 1.0, "int": 1, "str": "x"}
STATS = {
    name: next(sample for word, sample in SAMPLES.items() if word in str(kind))
    for name, kind in get_type_hints(Stats).items()
}
META = {"format": 1, "scene": {}, **STATS}


def good_run() -> dict[str, Any]:
    """The arrays of a saved run of one rod."""
    arrays: dict[str, Any] = {name: np.zeros((N, NV)) for name in "qva"}
    arrays |= {name: np.ones((N, 1)) for name in ("R1", "R2", "R3", "M3", "Mc")}
    arrays |= {"t": np.linspace(0, 1, N), "kinetic": np.ones(N), "potential": np.ones(N)}
    return arrays | {
        "joints": np.array(["theta", "phi"]),
        "wrench": np.zeros((N, NV, 6)),
        "tips": np.zeros((N, 1, 3)),
        "meta": np.array(json.dumps(META)),
    }


def run_file(**changed: Any) -> bytes:
    """A saved run with some arrays replaced, or left out where None."""
    arrays = {name: array for name, array in (good_run() | changed).items() if array is not None}
    file = BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def zipped(**members: bytes) -> bytes:
    """A zip with members of any bytes."""
    file = BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(f"{name}.npy", data)
    return file.getvalue()


def header(text: str, version: int = 1, length: int | None = None) -> bytes:
    """The start of an .npy file with a header of this text, which may claim another length."""
    size = len(text) if length is None else length
    return b"\x93NUMPY" + bytes([version, 0]) + struct.pack("<H" if version == 1 else "<I", size) + text.encode()


def claiming(shape: str, dtype: str = "'<f8'") -> bytes:
    """An array that claims a shape and holds nothing."""
    return header(f"{{'descr': {dtype}, 'fortran_order': False, 'shape': {shape}}}\n")


def meta(**changed: Any) -> np.ndarray:
    """The text of a run's meta array with some entries replaced."""
    return np.array(json.dumps(META | changed))


class Trap:
    """Unpickling it writes a file."""

    def __reduce__(self) -> Any:
        return Path.touch, (Path("trapped"),)


def at(array: np.ndarray, value: float) -> np.ndarray:
    copy = array.copy()
    copy.flat[1] = value
    return copy


def damaged(data: bytes, at: int) -> bytes:
    return data[:at] + bytes(byte ^ 255 for byte in data[at : at + 40]) + data[at + 40 :]


def flagged(data: bytes, at: int, value: int) -> bytes:
    """A zip with one byte of every entry of its directory changed."""
    return b"PK\x01\x02".join(
        [data.split(b"PK\x01\x02")[0]]
        + [part[: at - 4] + bytes([value]) + part[at - 3 :] for part in data.split(b"PK\x01\x02")[1:]]
    )


def with_member(data: bytes, name: str, member: bytes) -> bytes:
    """A zip with one more member, whose name may be there already."""
    file = BytesIO(data)
    with zipfile.ZipFile(file, "a") as archive, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a name that is there twice
        archive.writestr(f"{name}.npy", member)
    return file.getvalue()


def linked(name: str) -> Callable[[Path], object]:
    return lambda path: path.symlink_to(name)


def letters(*codes: int) -> np.ndarray:
    """A text of these codes, whether Unicode has them or not."""
    return np.array(codes, np.uint32).view(f"<U{len(codes)}").reshape(())
