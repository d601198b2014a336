"""The version of pendpin, and of the libraries that compute with it."""

from importlib.metadata import PackageNotFoundError, version

VERSION = "0.1.0"


def installed(*libraries: str) -> dict[str, str | None]:
    """The versions of libraries by the names of their packages; None for one that is not installed."""
    return {name: _version(name) for name in libraries}


def _version(library: str) -> str | None:
    try:
        return version(library)
    except PackageNotFoundError:
        return None
