"""The convention and the kind of rod that a text is about: given in words, or what explains most of its equations."""

from itertools import compress, product
from typing import Any

import numpy as np

from pendpin.doctor.printed import Printed, readings_that_hold
from pendpin.doctor.reading.names import CONSTANTS
from pendpin.doctor.reading.tree import parts, symbols
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


def _telling(equations: list[Printed]) -> list[Printed]:
    """The equations that tell a convention: those that can be read, are no definitions, and are not too long."""
    found = list[Printed]()
    for one in (one for one in equations if one.ways and not one.defines and not one.lacking):
        inside = list(parts(one.sides))
        if len(inside) <= MOST_SEARCHED and not any(p.kind == "derivative" or p.value in CONSTANTS for p in inside):
            found.append(one)
    return found


def _count(equations: list[Printed], systems: tuple[System, ...]) -> np.ndarray:
    """How many equations hold for each of some systems."""
    held = [[reading is not None for reading in readings_that_hold(one, systems)] for one in equations]
    return np.array(held, dtype=bool).reshape(-1, len(systems)).sum(0)


def find_convention(equations: list[Printed], rod: str, swaps: bool = True) -> tuple[Convention, list[str]]:
    """The convention that a text was written in, and remarks.

    It is the usual one, unless another explains two equations more: what explains all but no two more is a remark.
    `swaps` says whether the names of the angles may be swapped.
    """
    usual, told = (System(SPECS[rod]),), _telling(equations)
    wrong = [one for one in told if not _count([one], usual)[0]]
    right = [one for one in told if one not in wrong]
    systems = tuple(System(SPECS[rod], one) for one in EVERY if swaps or not one.swapped)
    for some, least in ((wrong[:MOST_SAMPLED], 1), (wrong, min(2, len(wrong)))):
        healed = _count(some, systems)
        systems, healed = tuple(compress(systems, healed >= least)), healed[healed >= least]
        if not (wrong and systems):
            return Convention(), []
    held = healed + _count(right, systems)
    best = int(np.argmax(held))
    if held[best] >= max(len(right) + 2, 0.6 * len(told)):
        return systems[best].convention, []
    if held[best] == len(told):
        words = systems[best].convention.words
        return Convention(), [f"All equations hold if {words}; if that is meant, give it as the convention."]
    return Convention(), []


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

    told = _telling(equations)

    def score(rod: str) -> float:
        alike = rod == guess or {rod, guess} == {"symmetric", "general"}
        held = _count(told, (System(SPECS[rod]),))[0]
        return held + SYMBOLS_COUNT * alike + ITSELF * (rod == guess)

    return max(RODS, key=score)
