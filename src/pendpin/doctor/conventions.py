"""The convention and the kind of rod that a text is about: given in words, or what explains most of its equations."""

from collections.abc import Collection
from itertools import product
from typing import Any

import numpy as np

from pendpin.doctor.printed import Printed, holding
from pendpin.doctor.reading.names import CONSTANTS
from pendpin.doctor.reading.tree import names_in, parts
from pendpin.doctor.systems.base import DIFFERENCES, Convention, System
from pendpin.doctor.systems.rod import SPECS
from pendpin.errors import InputError, not_one_of

MOST_SEARCHED = 300  # parts of an equation whose convention is searched
INERTIAS = {"I1", "I2", "I3", "J1", "J2", "J3"}
# equations: what the symbols of a text tell of its rod, and how much less of the next; what the usual convention counts
SURE, NEARLY = 1.5, 0.25

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


def likeliest_rod(equations: list[Printed], kinds: tuple[str, ...], conventions: Collection[Convention]) -> System:
    """The kind of rod and the convention, the usual one first, under which most equations hold.

    Another kind than the symbols tell has to explain two equations more, and so has a convention that is not the usual one.
    """
    telling, guess = list[Printed](), _kinds_of_symbols(equations)
    for one in (one for one in equations if one.ways and not (one.defines or one.lacking)):
        inside = [*parts(one.sides)]
        plain = not any(part.kind == "derivative" or part.value in CONSTANTS for part in inside)
        telling += [one] if plain and len(inside) <= MOST_SEARCHED else []
    prior = [SURE - NEARLY * guess.index(kind) if kind in guess else 0.0 for kind in kinds]
    kind = kinds[int(np.argmax(prior + _count(telling, tuple(System(SPECS[kind]) for kind in kinds))))]
    systems = tuple(System(SPECS[kind], convention) for convention in conventions)
    unusual = [SURE * bool(i) for i in range(len(systems))]
    return systems[int(np.argmax(_count(telling, systems) - unusual))]


def _count(equations: list[Printed], systems: tuple[System, ...]) -> np.ndarray:
    """How many equations hold for each of some systems."""
    return np.array([sum(holding(one, system) is not None for one in equations) for system in systems])


def _kinds_of_symbols(equations: list[Printed]) -> tuple[str, ...]:
    """The kinds of rod that the symbols of a text tell, the likeliest first.

    h, or inertias without a length, call for any rod, r for a uniform one; else it is thin.
    """
    names, uniform = set[str](), False
    for one in (one for one in equations if one.ways):
        names |= next(one.readings()).names
        lone = {side.value for side in one.sides if side.kind == "symbol"}
        inside = names_in(one.sides, {})
        # the length gives h or an inertia
        uniform |= "l" in inside and "h" not in inside - lone and bool(lone & {"h", "inertia", *INERTIAS})
    if uniform or not ("h" in names or (names & INERTIAS and "l" not in names)):
        return ("uniform",) if names & {"r", "I3", "J3"} else ("thin",)
    # two transverse inertias are told apart, or the tensor is printed
    written = [p.written for one in equations for p in parts(one.sides) if p.written and p.written.letter in "IJ"]
    indices = {one.index[:1] for one in written}
    apart = any(one.styled for one in written) or (indices & {"1", "x"} and indices & {"2", "y"})
    return ("general", "symmetric") if apart else ("symmetric", "general")
