"""Libraries that need not be installed: imported where they are used, and named where they are missing."""

import ctypes
from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from pendpin.errors import MissingLibrary


def optional(library: str, what: str, package: str) -> Any:
    """A library that need not be installed. Raises MissingLibrary, which says what needs it and what to install."""
    try:
        return import_module(library)
    except ImportError:
        raise MissingLibrary(f"{what} needs {library.partition('.')[0]}: pip install {package}") from None


def c_functions(package: str, file: str, names: Mapping[str, tuple[str, Any, tuple[Any, ...]]]) -> Any:
    """Functions in a file of an installed package, by names of ours, without importing the package.

    `names` has the name in the file, the type of the result and those of the arguments. Raises OSError, ValueError or
    AttributeError where there is no such file or function.
    """
    spec = find_spec(package)
    assert spec is not None
    assert spec.origin is not None
    (path,) = Path(spec.origin).parent.glob(file)
    library, functions = ctypes.CDLL(str(path)), {}
    for name, (symbol, result, arguments) in names.items():
        functions[name] = library[symbol]
        functions[name].restype, functions[name].argtypes = result, arguments
    return SimpleNamespace(**functions)
