"""The version of pendpin, and of the libraries that compute with it."""

from contextlib import suppress
from functools import cache

VERSION = "0.1.0"


def installed(*libraries: str) -> dict[str, str | None]:
    """The versions of libraries by the names of their packages; None for one that is not installed."""
    versions: dict[str, str | None] = dict.fromkeys(libraries)
    for name in libraries:
        with suppress(ImportError):  # PackageNotFoundError is one
            versions[name] = version(name)
    return versions


@cache
def version(library: str) -> str:
    """The version of an installed library by the name of its package; reading it takes a millisecond, once."""
    from importlib import metadata

    return metadata.version(library)
