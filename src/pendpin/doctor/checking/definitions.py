"""What the definitions of a text come to: the quantity of the system that one is, and those that equations use."""

import re
from contextlib import suppress
from functools import cache

import numpy as np

from pendpin.doctor.checking.evaluation import ENERGIES, Equation, evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, Disagreement, dimension
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Unread, walk
from pendpin.doctor.systems.base import System, Values, random_states

SHORT, LONG = 3, 9  # parts of an expression that is named like a quantity; of one that is none by chance
MOST_MEANT = 4  # readings of a definition
ACCELERATION = re.compile(r"acc|dd|dot|alpha")


def quantity_of(one: Printed, system: System) -> tuple[str, Equation] | None:
    """The quantity that a definition comes to, such as acc1 = (M22*R1 - M12*R2)/det, and how it is read; None for none.

    A short one comes to it by chance, unless it is named like it: xs = L*sin(theta), with X1 or pos_x for x1 and x. Of two
    bodies the indices agree. Energies have a constant.
    """
    if len(one.sides) != 2 or one.statement.name or one.sides[0].kind != "symbol" or not one.sides[0].written:
        return None
    word, size = one.sides[0].value.lstrip("?"), sum(1 for _ in walk(one.sides[1]))
    if size < SHORT or one.lacking - {one.defines}:
        return None
    dimensions = system.spec.dimensions  # a Lagrangian that comes to the energy is wrong, as is a place to another
    usual = {dimensions.get(name) for name in system.spec.words(one.sides[0].written)} & {(1, 2, -2), (0, 1, 0)}
    rows, first, apart = _quantities_of(system)
    for equation in (each for each in one.meant[:MOST_MEANT] if _is_own(each, one, system)):
        try:
            with np.errstate(all="ignore"):
                value = evaluate(one.sides[1], equation.context(random_states(system)))
        except (Unread, KeyError):
            continue
        # most are another quantity at the first state already
        near = np.flatnonzero(~(np.abs(value.flat[0] - first) > apart)) if np.isfinite(value).all() else ()
        names = list[str]()
        for name, row in (rows[i] for i in near):
            if row.shape == value.shape and dimensions.get(name, ()) not in usual:
                off = value - row
                off = np.diff(np.split(off, 2), axis=0) if name in ENERGIES else off  # the halves share the parameters
                names += [name] * bool(np.abs(off).max() <= TOLERANCE * np.abs(row).max())
        called = size >= LONG or ACCELERATION.search(word)
        fits = [name for name in names if (called and _agrees(word, name)) or _is_named_like(word, name)]
        if fits := sorted(fits, key=lambda name: (not _is_named_like(word, name), len(name), name)):
            return fits[0], equation
    return None


def _is_own(equation: Equation, one: Printed, system: System) -> bool:
    """Whether the name on the left is the text's own: nobody's, or of another dimension than what it usually means."""
    left, right = one.sides
    usual = system.spec.dimensions.get(equation.meaning(left.value))
    mine = left.value == one.defines
    if mine or not usual or left.value in system.spec.state or (left.written and left.written.dots):
        return mine
    with suppress(Disagreement):
        found = dimension(right, equation.definitions, system.spec)
        return found is not None and tuple(found) != tuple(usual)
    return False


@cache
def _quantities_of(system: System) -> tuple[list[tuple[str, Values]], Values, Values]:
    """The quantities of a system at random states of the true motion; their first values; how far others may be off these.

    Any value may be that of an energy, which has a constant.
    """
    spec, states = system.spec, random_states(system)
    names = [name for name in spec.formulas if not name.endswith("_")]
    moving = [name for name in names if re.match(r"r|[xyz][pG]?\d?$", name)]
    names += [*spec.unknowns, *spec.rates, *(f"d{name}" for name in names if re.fullmatch(r"p(?:\d|x|theta)?", name))]
    names += ["ddq"] * ("q" in spec.formulas) + [d + name for name in moving for d in ("d", "dd")]
    rows = [(name, states[name]) for name in dict.fromkeys(names) if 0 < np.abs(states[name]).max() < np.inf]
    apart = [np.inf if name in ENERGIES else TOLERANCE * np.abs(row).max() for name, row in rows]
    return rows, np.array([row.flat[0] for _, row in rows]), np.array(apart)


def _agrees(word: str, name: str) -> bool:
    """Whether the indices of a name and of a quantity do not contradict each other."""
    mine, others = (re.findall(r"(?<![\[\d])(\d{1,2})", text)[:1] for text in (word, name))
    return not mine or not others or len(mine[0]) != len(others[0]) or mine == others


def _is_named_like(word: str, name: str) -> bool:
    """Whether a name begins like a quantity: xs, X1 or pos_x for x1 or x."""
    if (match := re.fullmatch(r"(d{0,2})([A-Za-z])[pG]?(\d*)", name)) is None:
        return False
    rate, letter, _ = match.groups()
    if rate:  # v_1x, a_x
        return bool(re.match(rf"{'va'[len(rate) - 1]}.*{letter}", word)) and _agrees(word[1:], name)
    begins = word[:1].lower() == letter.lower() or re.search(rf"(?:_|[Pp]os|tip|bob|end){letter}(?![a-z])", word)
    return bool(begins) and _agrees(word, name)


def in_use(equations: list[Printed], systems: list[System]) -> set[str]:
    """The symbols without dots and components that some equations use; those of a definition if what it defines is used.

    What comes to a quantity of the system is used as an equation is.
    """
    laws = [bool(one.ways) and bool(quantity_of(one, system)) for one, system in zip(equations, systems, strict=True)]
    used, before = set[str](), -1
    while len(used) > before:
        before = len(used)
        for one, law in zip(equations, laws, strict=True):
            if one.ways and (law or not one.defines or len(one.sides) > 2 or bare(one.defines) in used):
                letters = {bare(name) for name in one.names - {one.defines}}
                used |= letters | {letter.rpartition("_")[0] for letter in letters}
    return used


def bare(name: str) -> str:
    """A symbol without its dots."""
    return name.lstrip("?").lstrip("d") or "d"
