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
INERTIAS = {"I1", "I2", "I3", "J1", "J2", "J3"}
# equations: what the symbols of a text tell of its rod; another that is of any shape too needs less
SYMBOLS_COUNT, ITSELF = 1.5, 0.25

OTHER_WORDS = {"theta-counterclockwise": "theta-ccw", "theta-reversed": "theta-ccw", "phi-cw": "phi-reversed"}
OTHER_WORDS |= {"phi-clockwise": "phi-reversed", "mirrored": "z-mirrored", "b3-joint": "b3-up"}
_FLAGS = product((1, -1), (1, -1), (False, True), ("down", "up", "mirrored"), (1, -1), (False, True))
EVERY = sorted((Convention(*flag) for flag in _FLAGS), key=lambda c: len(c.differences) + 0.1 * (c.z == "mirrored"))
SINGLE = tuple(convention for convention in EVERY if len(convention.differences) == 1)


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
    usual, spec = Convention(), SPECS[rod]
    verdicts = [(one, _holds(one, System(spec))) for one in equations]
    right, wrong = ([one for one, holds in verdicts if holds is which] for which in (True, False))
    held = dict[Convention, int]()
    for convention in EVERY if wrong else ():
        system = System(spec, convention)
        if (swaps or not convention.swapped) and any(_holds(one, system) for one in wrong[:MOST_SAMPLED]):
            healed = sum(_holds(one, system) is True for one in wrong)
            if healed > 1 or healed == len(wrong):
                held[convention] = healed + sum(_holds(one, system) is True for one in right)
    best, read = max(held, key=lambda convention: held[convention], default=usual), len(right) + len(wrong)
    if held and held[best] >= max(len(right) + 2, 0.6 * read):
        return best, []
    if held and held[best] == read:
        return usual, [f"All equations hold if {best.words}; if that is meant, give it as the convention."]
    return usual, []


def likely_rod(equations: list[Printed]) -> str:
    """The kind of rod that a text is about: its symbols tell, unless at least two equations more hold for another one.

    h, or inertias without a length, call for any rod, r for a uniform one; else it is thin.
    """
    names, uniform = set[str](), False
    for one in (one for one in equations if one.ways):
        names |= next(one.readings()).names
        lone = {side.value for side in one.sides if side.kind == "symbol"}
        inside = set().union(*map(symbols, one.sides))
        # the length gives h or an inertia
        uniform |= "l" in inside and "h" not in inside - lone and bool(lone & {"h", "inertia", *INERTIAS})
    if uniform or not ("h" in names or (names & INERTIAS and "l" not in names)):
        guess = "uniform" if names & {"r", "I3", "J3"} else "thin"
    else:  # two transverse inertias are told apart, or the tensor is printed
        written = [p.written for one in equations for p in parts(one.sides) if p.written and p.written.letter in "IJ"]
        indices = {one.index[:1] for one in written}
        apart = any(one.styled for one in written) or (indices & {"1", "x"} and indices & {"2", "y"})
        guess = "general" if apart else "symmetric"

    def score(rod: str) -> float:
        alike = rod == guess or {rod, guess} == {"symmetric", "general"}
        held = sum(_holds(one, System(SPECS[rod])) is True for one in equations)
        return held + SYMBOLS_COUNT * alike + ITSELF * (rod == guess)

    return max(RODS, key=score)
