"""Libraries that need not be installed: imported where they are used, and named where they are missing."""

from importlib import import_module
from typing import Any

from pendpin.errors import MissingLibrary


def optional(library: str, what: str, package: str) -> Any:
    """A library that need not be installed. Raises MissingLibrary, which says what needs it and what to install."""
    try:
        return import_module(library)
    except ImportError:
        raise MissingLibrary(f"{what} needs {library.partition('.')[0]}: pip install {package}") from None
