"""The convention and the kind of rod that a text is about: given in words, or what explains most of its equations."""

from itertools import product
from typing import Any

from pendpin.doctor.checking.residuals import TOLERANCE
from pendpin.doctor.printed import Printed, candidates
from pendpin.doctor.reading.names import CONSTANTS
from pendpin.doctor.reading.tree import Unread, parts, symbols
from pendpin.doctor.systems.base import DIFFERENCES, Convention, System
from pendpin.doctor.systems.rod import RODS, SPECS
from pendpin.errors import InputError, not_one_of

MOST_SAMPLED = 6  # equations that fail, of which a convention that is searched on explains one
MOST_SEARCHED = 300  # parts of an equation whose convention is searched

OTHER_WORDS = {"theta-counterclockwise": "theta-ccw", "theta-reversed": "theta-ccw", "phi-cw": "phi-reversed"}
OTHER_WORDS |= {"phi-clockwise": "phi-reversed", "mirrored": "z-mirrored", "b3-joint": "b3-up"}


def conventions_of(text: str) -> Convention:
    """A convention in words: theta-ccw, phi-reversed, z-up, swapped, b3-up, with commas; or standard. Raises InputError."""
    changes: dict[str, Any] = {}
    for part in filter(None, (p.strip().lower().replace("=", "-").replace(" ", "-") for p in text.split(","))):
        name = part.replace("counter-clockwise", "counterclockwise")
        name = OTHER_WORDS.get(name, name)
        if name not in ("standard", *DIFFERENCES):
            raise InputError(f"convention: {not_one_of(part, ('standard', *DIFFERENCES))}")
        if name != "standard":
            field, value, _ = DIFFERENCES[name]
            changes[field] = value
    return Convention(**changes)


def _all_conventions() -> list[Convention]:
    flags = product((1, -1), (1, -1), (False, True), ("down", "up", "mirrored"), (1, -1), (False, True))
    every = [Convention(*flag) for flag in flags]
    return sorted(every, key=lambda c: len(c.differences) + 0.1 * (c.z == "mirrored"))


def _holds(one: Printed, system: System) -> bool | None:
    """Whether an equation holds at random states; None for one that cannot be read or tells little of the convention."""
    inside = list(parts(one.sides))
    silent = any(part.kind == "derivative" or part.value in CONSTANTS for part in inside)
    if one.defines or len(inside) > MOST_SEARCHED or silent:
        return None
    try:
        return candidates(one, system)[0][1] < TOLERANCE
    except Unread:
        return None


def find_convention(equations: list[Printed], rod: str, swaps: bool = True) -> tuple[Convention, list[str]]:
    """The convention that a text was written in, and remarks.

    It is the usual one, unless another explains two equations more: what explains all but no two more is a remark.
    `swaps` says whether the names of the angles may be swapped.
    """
    usual = Convention()
    verdicts = [(one, _holds(one, System(SPECS[rod]))) for one in equations]
    right = [one for one, holds in verdicts if holds]
    wrong = [one for one, holds in verdicts if holds is False]
    if not wrong:
        return usual, []
    every = (c for c in _all_conventions() if swaps or not c.swapped)
    likely = [c for c in every if any(_holds(one, System(SPECS[rod], c)) for one in wrong[:MOST_SAMPLED])]
    healed = {c: sum(_holds(one, System(SPECS[rod], c)) is True for one in wrong) for c in likely}
    some = {c: n for c, n in healed.items() if n > 1 or n == len(wrong)}
    held = {c: n + sum(_holds(one, System(SPECS[rod], c)) is True for one in right) for c, n in some.items()}
    best = max(held, key=lambda convention: held[convention], default=usual)
    read = len(right) + len(wrong)
    if held.get(best, 0) >= max(len(right) + 2, 0.6 * read):
        return best, []
    if held.get(best, 0) == read:
        return usual, [f"All equations hold if {best.words}; if that is meant, give it as the convention."]
    return usual, []


INERTIAS = {"I1", "I2", "I3", "J1", "J2", "J3"}
ANY = {"symmetric", "general"}  # rods of any shape
SYMBOLS_COUNT = (
    1.5  # equations: what the symbols of a text tell of its rod; another that is of any shape too needs less
)
ITSELF = 0.25


def likely_rod(equations: list[Printed]) -> str:
    """The kind of rod that a text is about: its symbols tell, unless at least two equations more hold for another one."""
    guess = _rod_of_symbols(equations)

    def score(rod: str) -> float:
        alike = rod == guess or {rod, guess} == ANY
        held = sum(_holds(one, System(SPECS[rod])) is True for one in equations)
        return held + SYMBOLS_COUNT * alike + ITSELF * (rod == guess)

    return max(RODS, key=score)


def _rod_of_symbols(equations: list[Printed]) -> str:
    """h, or inertias without a length, call for any rod, r for a uniform one; else it is thin."""
    readings = [equation for one in equations for equation in list(one.readings())[:1]]
    names = set().union(*(equation.names for equation in readings))
    if _says_uniform(equations) or not ("h" in names or (names & INERTIAS and "l" not in names)):
        return "uniform" if names & {"r", "I3", "J3"} else "thin"
    return "general" if _tells_apart(equations) else "symmetric"


def _tells_apart(equations: list[Printed]) -> bool:
    """Whether a text tells two transverse inertias apart: it has both indices, or the tensor."""
    names = (part.written for one in equations for part in parts(one.sides) if part.written)
    inertias = [written for written in names if written.letter in "IJ"]
    indices = {written.index[:1] for written in inertias}
    return any(written.styled for written in inertias) or bool(indices & {"1", "x"} and indices & {"2", "y"})


def _says_uniform(equations: list[Printed]) -> bool:
    """Whether an equation gives h or an inertia by the length."""
    for sides in (one.sides for one in equations if one.ways):
        lone, names = {side.value for side in sides if side.kind == "symbol"}, set().union(*map(symbols, sides))
        if "l" in names and "h" not in names - lone and lone & {"h", "inertia", *INERTIAS}:
            return True
    return False


def single_conventions() -> list[Convention]:
    """The conventions that differ from the usual one in one way."""
    return [convention for convention in _all_conventions() if len(convention.differences) == 1]
