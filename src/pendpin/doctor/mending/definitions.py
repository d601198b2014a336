"""Mends of a definition: what a wrong equation needs a symbol to be is what its definition has to give."""

from dataclasses import replace

import numpy as np

from pendpin.doctor.checking.residuals import TOLERANCE, Equation, relative_error, residuals
from pendpin.doctor.mending.mends import Mend, Patient, mends
from pendpin.doctor.mending.monomials import Printer
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Unread, parts
from pendpin.doctor.systems.base import Quantities, System, Values, random_states

OTHERS = -0.3  # what a mend costs less for each other equation that it heals


def mends_of_definition(
    wrong: Equation, source: Printed, every: list[Equation], system: System, printer: Printer
) -> list[Mend]:
    """Mends of the definition `source` that heal an equation, and every other one that uses it."""
    name = source.defines
    known = {other: node for other, node in wrong.definitions.items() if other != name}
    if (needing := _needing(wrong, name, system)) is None:
        return []
    definition = Equation(source.sides, wrong.frame, wrong.meanings, known, source.ways[0][1])
    patient = Patient(source, definition, needing, printer)
    healed = [mend for mend in mends(patient, False) if all(_heals(mend, name, one, system) for one in every)]
    words = f" in the definition of {name.lstrip('?')}, {source.statement.place}"
    return [
        replace(mend, words=mend.words + words, cost=mend.cost + OTHERS * (len({id(one) for one in every}) - 1))
        for mend in healed
    ]


def _needing(equation: Equation, name: str, system: System) -> System | None:
    """The system with a symbol as what an equation needs it to be; None where the equation is not straight in it."""
    nodes = [part for part in parts(equation.sides) if part.kind == "symbol" and part.value == name]

    def residual(q: Quantities, size: int) -> Values:
        values = {id(node): q.number(size) for node in nodes}
        return np.concatenate([rows for rows, _ in residuals(equation, q, None, values)])

    def value(q: Quantities) -> Values:
        one, two = (residual(q, size)[0] for size in (1, 2))
        return q.number(1) - one / (two - one)

    try:
        one, two, three = (residual(random_states(system), size) for size in (1, 2, 3))
    except Unread:
        return None
    straight = len(one) == 1 and np.abs(three - 2 * two + one).max() <= TOLERANCE * np.abs(three).max()
    if not straight or not np.abs(two - one).min() > 0:
        return None
    return replace(system, spec=replace(system.spec, formulas={**system.spec.formulas, name: value}))


def _heals(mend: Mend, name: str, equation: Equation, system: System) -> bool:
    """Whether an equation holds with a mended definition."""
    meaning = next(side for side in mend.equation.sides if side.value != name)
    try:
        return (
            relative_error(replace(equation, definitions=equation.definitions | {name: meaning}), random_states(system))
            < TOLERANCE
        )
    except Unread:
        return False
