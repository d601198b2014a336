"""The errors pendpin raises: each message is one line that says what is wrong, where, and what would be right."""

import re
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeGuard, TypeVar

MOST_CHARACTERS = 1_000  # of a message
MOST_NAMES = 16  # in a list of them
MOST_REPR = 900  # of a representation
LATE = 1e5  # s: six digits of such a time are not enough

T = TypeVar("T")
KeyPath = tuple[str | int, ...]  # names of fields or joints, and places in lists; a name first

_PLAIN = re.compile(r"[\w-]+")
_NUMBERED = re.compile(r"_\d+(?=_|$)")
MOST_COMPARED = 2_000  # names, with one that is unknown
OTHER_WORDS = {"damping": "viscous", "damper": "viscous", "friction": "dry_friction", "limit": "stop", "air": "drag"}


class PendpinError(Exception):
    """Root of every error that a user's input or scene can cause. Its message is one line of printable text."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class InputError(PendpinError):
    """A scene, URDF, run file, number or name that cannot be used."""


class RunError(PendpinError):
    """A run that could not reach its end: the message names the time and the reason, `partial` is the run up to there."""

    def __init__(self, message: str, partial: Any = None) -> None:
        super().__init__(message)
        self.partial = partial


class Halted(RunError):
    """A run that was ended from outside (by the user, for lack of time or of room on the disk) and could go on."""


class Interrupted(Halted):
    """A run that the user stopped."""


class Note(UserWarning):
    """What is allowed and probably a slip, as Python's warnings show it."""


def say_note(text: str, stacklevel: int) -> None:
    """A warning of the kind Note, at the line of a caller; in a notebook one line without a place: cells are not files."""
    if "ipykernel" in sys.modules:
        warnings.warn_explicit(Note(text), Note, "pendpin", 0)
    else:
        warnings.warn(Note(text), stacklevel=stacklevel)


class MissingLibrary(PendpinError):
    """An optional library is needed and not installed; the message holds the command that brings it."""


def attempt(compute: Callable[[], T], fails: type[PendpinError] = PendpinError) -> tuple[T | None, PendpinError | None]:
    """What is computed, or the error of a run that fails: that is an outcome too. Raises Interrupted."""
    try:
        return compute(), None
    except Interrupted:
        raise
    except fails as error:
        return None, error


def one_line(text: str) -> str:
    """Text as one line that a terminal can show: lines joined, control characters escaped, the middle of much cut."""
    joined, half = re.sub(r"\s*[\r\n]+\s*", " ", text.strip()), MOST_CHARACTERS // 2
    cut = joined if len(joined) <= MOST_CHARACTERS else f"{joined[:half]}...{joined[-half:]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in cut)


def brief(text: str, most: int = MOST_REPR) -> str:
    """A text, cut where it is longer than a representation, or than `most`."""
    return text if len(text) <= most else f"{text[: most - 3]}..."


def shown(value: Any, most: int = 60) -> str:
    """A value as one short line of printable text, for a message."""
    if isinstance(value, int) and abs(value) >= 10**most:
        return f"a number of {int(value.bit_length() * 0.30103)} digits"
    try:
        text = one_line(repr(value))
    except (RecursionError, ValueError):  # ValueError: a whole number in it has thousands of digits
        text = f"a {type(value).__name__} that is too deep or too long to show"
    return brief(text, most)


def is_number(value: Any) -> TypeGuard[float]:
    """Whether a value is a number: a bool is not one, though an int to Python, nor an int beyond double precision."""
    return isinstance(value, float) or (type(value) is int and abs(value) <= sys.float_info.max)


def shown_path(path: Path) -> str:
    """A file as messages call it: from the working folder on, where it is in there."""
    try:
        return str(path.relative_to(Path.cwd()))
    except (OSError, ValueError):  # the working folder is gone; the file is elsewhere
        return str(path)


def choices(names: Iterable[Any], most: int = sys.maxsize) -> str:
    """Names as a list in a message: of more than `most` the first, then dots."""
    texts = [str(name) for name in names]
    return ", ".join([*texts[:most], *["..."] * (len(texts) > most)])


def did_you_mean(name: Any, names: Iterable[str]) -> str:
    """`; did you mean x?` where one of the names is close to `name`, else nothing."""
    from difflib import get_close_matches

    by_lower = {valid.lower(): valid for valid, _ in zip(names, range(MOST_COMPARED), strict=False)}
    word = str(name)[:100].lower()
    close = [other for other in (OTHER_WORDS.get(word),) if other in by_lower] or get_close_matches(word, by_lower, n=1)
    return f"; did you mean {shown(by_lower[close[0]])}?" if close else ""


@contextmanager
def inside(place: str) -> Iterator[None]:
    """What raises InputError in the block raises it with its place in front, once: `place: message`."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{place}: {str(error).removeprefix(f'{place}: ')}") from None


def amount(count: int, noun: str) -> str:
    """A number of things: 1 sample, 2 samples."""
    return f"{count} {noun}{'s' * (count != 1)}"


def moment(t: float) -> str:
    """A time in s as text: to six digits, or to a microsecond where it is late."""
    return f"{t:.6g}" if abs(t) < LATE else f"{t:.6f}".rstrip("0").rstrip(".")


def not_one_of(value: Any, names: Iterable[str]) -> str:
    """What a message says of a value that none of the names is: the names, or the first of many, and the nearest."""
    valid = tuple(names)
    return f"{shown(value)} is not one of: {_first_of(valid)}{did_you_mean(value, valid)}"


def nearest_or_all(value: Any, valid: tuple[str, ...]) -> str:
    """What a message adds for an unknown name: the nearest, or the first of those that there are."""
    return did_you_mean(value, valid) or (f"; there are: {_first_of(valid)}" if valid else "")


def _first_of(names: tuple[str, ...]) -> str:
    if len(names) > MOST_NAMES:  # those that differ in a number alone become one
        series: dict[str, list[str]] = {}
        for name in names:
            series.setdefault(_NUMBERED.sub("_", str(name), count=1), []).append(name)
        names = tuple(f"{first} to {more[-1]}" if more else first for first, *more in series.values())
    return choices(names, MOST_NAMES)


def find(names: tuple[str, ...], name: str, what: str) -> int:
    """The place of a name. Raises InputError that lists the names, or the first of many."""
    if isinstance(name, str) and name in names:
        return names.index(name)
    raise InputError(f"{what} {not_one_of(name, names)}")


def written(path: KeyPath) -> str:
    """A key path as text."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            name = part if _PLAIN.fullmatch(part) else repr(part)
            text += f".{name}" if text else name
    return text
