"""The version of pendpin, and of the libraries that compute with it."""

from functools import cache

VERSION = "0.1.0"


def installed(*libraries: str) -> dict[str, str | None]:
    """The versions of libraries by the names of their packages; None for one that is not installed."""
    return {name: _version(name) for name in libraries}


@cache
def version(library: str) -> str:
    """The version of an installed library by the name of its package; reading it takes a millisecond, once."""
    from importlib import metadata

    return metadata.version(library)


def _version(library: str) -> str | None:
    try:
        return version(library)
    except ImportError:  # PackageNotFoundError is one
        return None
