"""Masses, lengths and inertias with letters that nobody explains: the meanings under which most equations hold."""

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice, permutations

from pendpin.doctor.checking.dimensions import of_equation
from pendpin.doctor.checking.residuals import TOLERANCE, Equation, relative_error
from pendpin.doctor.letters import weight
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Node, Unread
from pendpin.doctor.systems.base import Spec, System, random_states

Meanings = dict[str, str]  # symbols without a meaning of their own, and what they stand for

MEASURED = {(1, 0, 0), (0, 1, 0), (1, 2, 0)}  # the powers of kg, m, s of what a letter may stand for
MOST_EQUATIONS, MOST_LETTERS = 12, 4  # that are tried; letters of one equation
MOST_TRIED, MOST_KEPT = 400, 6  # meanings of the letters of one equation, and those that are followed up
SHORT = {"?s", "?c"}
LEAST = 2  # equations that hold with the meanings


def proposed(equations: list[Printed], system: System) -> tuple[float, Meanings]:
    """How much holds with the best meanings of the letters, and these; none if too little does."""
    explained = {one.defines for one in equations}
    wanted = [(one, _letters(one, explained)) for one in equations if len(one.names) > 1 and not one.defines]
    wanted = [(one, letters) for one, letters in wanted if len(letters) <= MOST_LETTERS][:MOST_EQUATIONS]
    used = set().union(*(next(one.readings()).names for one, _ in wanted))
    names = [name for name in dict.fromkeys((*system.spec.parameters, "J1", "J")) if _may_be_meant(name, system.spec)]
    free = [name for name in names if name not in used]
    kept: list[tuple[float, int, Meanings]] = [(0.0, 0, {})]  # what holds counts, how many hold, with which meanings
    for one, letters in sorted(wanted, key=lambda pair: len(pair[1])):
        more = []
        for score, count, known in kept:
            for equation, meanings in _meanings(one, letters, known, free, system):
                more.append((score + weight(equation, system.spec), count + bool(letters), meanings))
        kept = sorted([*more, *kept], key=lambda entry: -entry[0])[:MOST_KEPT]
    score, count, meanings = kept[0]
    return (score, meanings) if count >= LEAST else (0.0, {})


def option(name: str) -> str:
    """A symbol or quantity as it is written in --symbols: J1 is J_1."""
    return re.sub(r"(?<=[a-zA-Z])(\d+)$", r"_\1", name.lstrip("?"))


def _letters(one: Printed, explained: set[str]) -> list[str]:
    """The symbols of an equation that nothing explains; s and c need not be a sine and cosine."""
    known = explained | (one.definitions.keys() - SHORT)
    return sorted({name for name in one.names if name.startswith("?")} - known)


def _may_be_meant(name: str, spec: Spec) -> bool:
    known = name in spec.parameters or name in spec.formulas
    return known and spec.dimensions.get(name) in MEASURED


def _meanings(
    one: Printed, letters: list[str], known: Meanings, free: list[str], system: System
) -> Iterator[tuple[Equation, Meanings]]:
    """The meanings of an equation's letters with which it holds, those that are `known` among them."""
    left = [letter for letter in letters if letter not in known]
    choices = permutations([name for name in free if name not in known.values()], len(left))
    for choice in islice(choices, MOST_TRIED):
        meanings = known | dict(zip(left, choice, strict=True))
        nodes = {letter: Node("symbol", (0, 0), meanings[letter]) for letter in letters}
        for equation in one.readings():
            meant = replace(equation, definitions=equation.definitions | nodes)
            if _holds(meant, system):
                yield meant, meanings
                break


def _holds(equation: Equation, system: System) -> bool:
    try:
        return not of_equation(equation, system.spec)[1] and relative_error(equation, random_states(system)) < TOLERANCE
    except Unread:
        return False
