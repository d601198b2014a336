"""The verdict on an equation at random states; in which motions it fails; laws of any system; what definitions come to."""

import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from pendpin.doctor.checking.evaluation import Equation, evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, holds, relative_error, stack_residuals
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.names import ENERGY, LENGTH
from pendpin.doctor.reading.tree import Node, Unread, parts, walk
from pendpin.doctor.systems.base import (
    LOADS,
    STATES,
    Formula,
    Quantities,
    System,
    Values,
    free_states,
    random_states,
)
from pendpin.equations.base import exact
from pendpin.ground.libraries import optional

EXACT = 1e-25  # what is left in 50 digits: three derivatives within each other leave 1e-32
SAME = 1e-8  # relative: of second derivatives eight digits are left
PAIRS = 4  # states in 50 digits from either half of the random states
SHORT, LONG = 3, 9  # parts of an expression that is named like a quantity; of one that is none by chance
MOST_MEANT = 4  # readings of a definition
ACCELERATION = re.compile(r"acc|dd|dot|alpha")


def check(equation: Equation, system: System) -> tuple[bool, bool, float]:
    """Whether an equation holds on every true motion, whether to 25 digits rather than those of floats, and its error.

    It is compared at random states, in floats and then in 50 digits. The error is relative to its terms. Raises Unread.
    """
    states = random_states(system)
    error = relative_error(equation, states)
    if error > TOLERANCE:
        with suppress(Unread):  # rates of points have no rates off the true motion
            if changes_no_motion(equation, system):
                return True, system.spec.analytic, 0.0
    if error > TOLERANCE or not system.spec.analytic:
        return error <= TOLERANCE, error > TOLERANCE, error
    try:
        return bool(np.abs(stack_residuals(equation, in_fifty_digits(states))).max() < EXACT), True, error
    except ZeroDivisionError:
        raise Unread("it divides by 0") from None


def changes_no_motion(equation: Equation, system: System) -> bool:
    """Whether it gives a Lagrangian that is not T - V but has its motions: times a factor, or with a total derivative."""
    lone = [side for side in equation.sides if side.kind == "symbol" and equation.meaning(side.value) == "L"]
    others = [side for side in equation.sides if side not in lone]
    if len(lone) != 1 or len(others) != 1 or equation.names & set(system.spec.unknowns):
        return False
    exact = in_fifty_digits if system.spec.analytic else lambda q: q
    states, free = exact(random_states(system)), exact(free_states(system))
    law, off = (lagrange_residuals(side, equation, free) for side in (lone[0], others[0]))
    left = lagrange_residuals(others[0], equation, states)
    return bool((law * off).sum() > 0 and np.abs(left).max() <= SAME * np.abs(off).max())


def lagrange_residuals(side: Node, equation: Equation, quantities: Quantities) -> Values:
    """Euler and Lagrange's left sides of an expression, (coordinates, n)."""
    context, place = equation.context(quantities), (side.outer[0], side.outer[0])
    by = lambda node, name: Node("derivative", side.span, name, (node,))  # noqa: E731
    lefts = (
        Node("sum", side.span, (1, -1), (by(by(side, f"d{q}"), "t"), by(side, q)), (place, place))
        for q in quantities.spec.coordinates
    )
    return np.stack([evaluate(left, context) for left in lefts])


def when(equation: Equation, system: System) -> str:
    """In which motions a wrong equation fails, in words."""
    rates, full = system.spec.rates, random_states(system)

    def fails_without(still: list[str]) -> bool:
        try:
            return relative_error(equation, random_states(system, tuple((n, 0.0) for n in still)), full) > TOLERANCE
        except Unread:  # it has no value there, as one that is divided by a rate at rest
            return False

    if fails_without([*rates]):
        return "already at rest"
    turns = {
        name: "turns" if system.spec.dimensions[name] == (0, 0, 0) else "moves" for name in system.spec.coordinates
    }
    alone = [name for name in turns if fails_without([rate for rate in rates if rate != f"d{name}"])]
    wrong = " and ".join(f"as soon as {name} {turns[name]}" for name in alone)
    return wrong or f"only when {' and '.join(turns)} both turn"


def is_general(equation: Equation, system: System) -> bool:
    """Whether an equation is Euler and Lagrange's or Hamilton's for any coordinate q_i, or with a force Q of its own.

    It has to hold for every coordinate, or the one that it names, without loads and without the force.
    """
    spec, nodes = system.spec, [*parts(equation.sides)]
    by = {str(node.value).lstrip("?") for node in nodes if node.kind == "derivative" and node.value != "t"}
    named = [name for name in spec.coordinates if {name, f"d{name}"} & by]
    if not by or equation.names & {*spec.parameters, "q_i"}:  # of a rod q_i is known, and the equation is checked
        return False
    unloaded = random_states(system, tuple((name, 0.0) for name in LOADS if name in spec.parameters))
    letters = {name.lstrip("?").lstrip("d") for name in (*by, *equation.names)}
    letters = {name for name in letters if name in by or f"d{name}" in by or name[:1] == "p"} - {*spec.state, "pi"}
    for coordinate in named or spec.coordinates:
        meant = {one: spec.momentum(coordinate) if one[:1] == "p" else coordinate for one in letters}
        meanings = {f"{mark}{dot}{one}": dot + meant[one] for one in letters for dot in ("", "d") for mark in ("?", "")}
        sides = tuple(side for side in equation.sides if side.value in meanings or not str(side.value).startswith("?"))
        one_coordinate = named and len(sides) == len(equation.sides)  # checked as any other equation
        if one_coordinate or not sides:
            return False
        if not holds(replace(equation, sides=sides, meanings=equation.meanings | meanings), unloaded):
            return False
    return True


@cache
def in_fifty_digits(states: Quantities) -> Quantities:
    """Some of the states in mpmath's numbers of 50 digits, as many of the second half as of the first."""
    numbers = exact(50)
    pi = numbers.asarray("3.14159265358979323846264338327950288419716939937510582097")
    chosen = [place + start for start in (0, STATES // 2) for place in range(PAIRS)]
    base = {name: numbers.asarray(values[chosen]) for name, values in states.base.items()}
    return Quantities(base, states.system, SimpleNamespace(**vars(numbers), pi=pi), states.true)


@cache
def in_symbols(system: System) -> Quantities:
    """Every quantity as sympy's expression in the state, the parameters and the unknowns."""
    sympy: Any = optional("sympy", "the equation doctor", "sympy")

    def on_each(function: Callable[[Any], Any]) -> Callable[[Any], Values]:
        one_by_one = np.frompyfunc(function, 1, 1)
        return lambda x: np.asarray(one_by_one(np.asarray(x, dtype=object)), dtype=object)

    def derivative(q: Quantities, function: Formula, variable: str) -> Values:
        value, rates = function(q), {sympy.Symbol(name): rate[0] for name, rate in q.direction(variable).items()}
        if variable == "t" and any(str(one) in q.spec.unknowns for x in value.flat for one in x.free_symbols):
            raise Unread("the rate of an acceleration or reaction is not known")
        return on_each(lambda x: sum(x.diff(symbol) * rate for symbol, rate in rates.items()))(value)

    functions = {name: on_each(getattr(sympy, name)) for name in ("sin", "cos", "sqrt", "exp")}
    numbers = SimpleNamespace(asarray=on_each(sympy.sympify), pi=sympy.pi, derivative=derivative, **functions)
    names = (*system.spec.state, *system.spec.parameters, *system.spec.unknowns)
    return Quantities({name: np.array([sympy.Symbol(name)], dtype=object) for name in names}, system, numbers)


def quantity_of(one: Printed, system: System) -> tuple[str, Equation] | None:
    """The quantity that a definition comes to, such as acc1 = (M22*R1 - M12*R2)/det, and how it is read; None for none.

    A short one comes to it by chance, unless it is named like it: xs = L*sin(theta), with X1 or pos_x for x1 and x. Of two
    bodies the indices agree.
    """
    left, *others = one.sides or (None,)
    if len(others) != 1 or one.statement.name or not left or not left.written or left.value != one.defines:
        return None
    word, size = left.value.lstrip("?"), sum(1 for _ in walk(others[0]))
    if size < SHORT or one.lacking - {one.defines}:
        return None
    dimensions, states = system.spec.dimensions, random_states(system)
    # a Lagrangian that comes to the energy is wrong, as is a place to another
    usual = {dimensions.get(name) for name in system.spec.words(left.written)} & {ENERGY, LENGTH}
    called = size >= LONG or ACCELERATION.search(word)
    pairs = (pair for pair in _quantities_of(system, word) if dimensions.get(pair[0], ()) not in usual)
    names = [name for name, alike in pairs if called or alike]
    for equation in one.meant[:MOST_MEANT] if names else ():
        with suppress(Unread, KeyError), np.errstate(all="ignore"):
            value = evaluate(others[0], equation.context(states))
            for name in names:
                row = states[name]
                near = value.shape == row.shape and abs(value.flat[0] - row.flat[0]) <= SAME * abs(row.flat[0])
                if near and np.abs(value - row).max() <= TOLERANCE * np.abs(row).max():
                    return name, equation
    return None


@cache
def _quantities_of(system: System, word: str) -> list[tuple[str, bool]]:
    """The quantities of a system, and their rates, that a name may come to, and whether it is like theirs; these first.

    None that is 0.
    """
    spec, states = system.spec, random_states(system)
    names = [name for name in spec.formulas if not name.endswith("_")]
    moving = [name for name in names if re.match(r"r|[xyz][pG]?\d?$", name)]
    names += [*spec.unknowns, *spec.rates, *(f"d{name}" for name in names if re.fullmatch(r"p(?:\d|x|theta)?", name))]
    names += ["ddq"] * ("q" in spec.formulas) + [d + name for name in moving for d in ("d", "dd")]
    every = (name for name in dict.fromkeys(names) if _agrees(word, name) and 0 < np.abs(states[name]).max() < np.inf)
    return sorted(((n, _is_named_like(word, n)) for n in every), key=lambda pair: (not pair[1], len(pair[0]), pair[0]))


def _agrees(word: str, name: str) -> bool:
    """Whether the indices of a name and of a quantity, and the points G and T, do not contradict each other."""
    points = {"G", "T"} & {*word.partition("_")[2]}
    if points and name[-1] in {"G", "T"} - points:
        return False
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
