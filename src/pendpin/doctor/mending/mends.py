"""The smallest changes of a printed equation that make it hold, the simplest first, each verified on the changed text."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import combinations, pairwise

import numpy as np

from pendpin.doctor.checking.check import check
from pendpin.doctor.checking.evaluation import evaluate
from pendpin.doctor.checking.residuals import Equation, holds, of_equation, stack_residuals
from pendpin.doctor.mending.changes import Change, Patient
from pendpin.doctor.mending.numbers import CLOSE, Numbers, Part, swapped
from pendpin.doctor.mending.writing import Writer, overlap, spliced
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Node, Unread, key, parts
from pendpin.doctor.systems.base import Quantities, System, Values, free_states, random_states

MOST_NODES = 400  # of an equation that is searched
MOST_WORK = 400_000  # changes times parts of an equation that are tried
MOST_TOGETHER = 30  # changes of which any two in the same term are tried
MOST_PAIRED = 700  # changes that are tried in pairs
MOST_OF_AN_ANGLE = 8  # parts of a definition of what equations are not straight in
MOST_TEXTS = 400  # candidates whose text is read again
MOST_MENDS = 4  # of an equation
FARTHER = 0.75  # what a second mend may cost more than the first
FARTHEST = 3.2  # the cost beyond which a mend is too unlikely
OTHERS = -0.3  # what a mend of a definition costs less for each other equation that it heals


@dataclass(frozen=True, eq=False, kw_only=True)
class Mend(Change):
    """A verified change: the text with it, and the equation that results."""

    text: str
    equation: Equation
    alone: bool  # its text holds no other equation

    @property
    def span(self) -> tuple[int, int]:
        """Where the mended equation stands in its text."""
        sides = self.equation.sides
        return (0, len(self.text)) if self.alone else (sides[0].outer[0], sides[-1].outer[1])

    @property
    def pieces(self) -> list[tuple[str, bool]]:
        """The mended equation in parts, each with whether it is new."""
        place, end_of_it = self.span
        parts, shift = list[tuple[str, bool]](), 0
        for start, end, new in sorted(self.splices):
            parts += [(self.text[place : start + shift], False), (new, True)]
            place = start + shift + len(new)
            shift += len(new) - (end - start)
        parts.append((self.text[place:end_of_it].rstrip().removesuffix("\\\\"), False))
        return [(" ".join(part.split("\n")), new) for part, new in parts if part]

    @property
    def latex(self) -> str:
        """The mended equation as it would be printed."""
        return self.text[slice(*self.span)].strip().removesuffix("\\\\").strip()


def mends(patient: Patient, pairs: bool) -> list[Mend]:
    """Verified mends, the simplest first; none where only unlikely ones would do. `pairs` also tries two changes."""
    every, numbers = patient.parts, patient.numbers
    if numbers is None or len(every) > MOST_NODES:
        return []
    listed = sorted(patient.listed(), key=lambda change: change.order)[: MOST_WORK // len(every)]
    sized: list[Change] = []
    for part in every:
        if (needed := numbers.needed(part)) is not None:
            sized += patient.by_need(part, numbers.known[id(part.node)], needed)
    effects = [(change, rows) for change in listed if (rows := numbers.residual(change.swaps)) is not None]
    chosen = _verified(patient, [*sized, *(change for change, rows in effects if numbers.vanishes(rows))])
    if chosen or not pairs:
        return chosen
    likely = listed[:MOST_TOGETHER] if len(every) < MOST_NODES // 8 else []
    return _verified(patient, _pairs(effects, numbers)) or _verified(patient, _pairs_of_terms(likely, every, numbers))


def mends_of_definition(
    wrong: Equation, source: Printed, every: list[Equation], system: System, writer: Writer
) -> list[Mend]:
    """Mends of the definition `source` that heal an equation, and every other one that uses it.

    The symbol is taken as a quantity of the system: what the wrong equation, if it is straight in it, needs it to be. Where
    it is not, as in an angle, that is what a change of a short definition makes of it.
    """
    name = source.defines
    known = {other: node for other, node in wrong.definitions.items() if other != name}

    def needed(q: Quantities, power: int) -> Values:
        numbers = ({name: Node("number", (0, 0), Fraction(k))} for k in (1, 2))
        tried = (replace(wrong, definitions=wrong.definitions | number) for number in numbers)
        one, two = (stack_residuals(equation, q, plain=True)[0] for equation in tried)
        root = q.number(1) - one * (2.0**power - 1) / (two - one)
        return root if power == 1 else q.number(1) / root

    formulas = ({**system.spec.formulas, name: partial(needed, power=power)} for power in (1, -1))
    healing = (replace(system, spec=replace(system.spec, formulas=one)) for one in formulas)  # as a factor or a divisor
    needed_by = next((s for s in healing if holds(replace(wrong, definitions=known), random_states(s))), None)
    definition = Equation(source.sides, wrong.frame, wrong.meanings, known, source.ways[0][1])

    def heals(meaning: Node) -> bool:
        mended = (replace(one, definitions=one.definitions | {name: meaning}) for one in every)
        return all(holds(one, random_states(system)) for one in mended)

    if not (straight := needed_by is not None):
        own = next(side for side in source.sides if side.value != name)
        short = sum(1 for _ in parts((own,))) <= MOST_OF_AN_ANGLE
        changes = sorted(Patient(source, definition, system, writer).listed() if short else (), key=lambda c: c.order)
        meaning = next((new for one in changes if heals(new := swapped(own, one.swaps))), None)
        if meaning is None:
            return []
        as_changed = {name: lambda q: evaluate(meaning, replace(definition, sides=(meaning,)).context(q))}
        needed_by = replace(system, spec=replace(system.spec, formulas={**system.spec.formulas, **as_changed}))
    words = f" in the definition of {name.lstrip('?')}, {source.statement.place}"
    less = OTHERS * (len({id(one) for one in every}) - 1) * straight
    found = []
    patient = Patient(source, definition, needed_by, writer)
    patient.parts = [part for part in patient.parts if part.node.value != name]
    for mend in mends(patient, False):
        if heals(next(side for side in mend.equation.sides if side.value != name)):
            found.append(replace(mend, words=mend.words + words, cost=mend.cost + less))
    return found


def _pairs(effects: list[tuple[Change, Values]], numbers: Numbers) -> Iterator[Change]:
    """Two changes whose effects add up to what is missing: where they do at one state, compared on all."""
    rows, size, shape = numbers.rows.ravel(), CLOSE * numbers.size, numbers.rows.shape
    usable = [(change, after) for change, after in effects if after.shape == shape and np.isfinite(after).all()]
    usable = usable[:MOST_PAIRED]
    steps = np.array([after.ravel() - rows for _, after in usable]).reshape(len(usable), -1)
    first = int(np.argmax(np.abs(rows)))
    for i, (a, after) in enumerate(usable):
        left = after.ravel()
        for j in i + 1 + np.flatnonzero(np.abs(left[first] + steps[i + 1 :, first]) <= size):
            b = usable[j][0]
            if np.abs(left + steps[j]).max() <= size and not overlap(a.splices, b.splices):
                yield a & b


def _pairs_of_terms(likely: list[Change], every: list[Part], numbers: Numbers) -> Iterator[Change]:
    """Two changes in the same term or side, whose effects do not add up, each pair tried on numbers."""
    terms: dict[int, int] = {}  # the term, or side, that each part stands in, by id
    for part in every:
        side, *below = (*part.parents, part.node)
        terms[id(part.node)] = id(below[0] if side.kind == "sum" and below else side)
    placed = [(change, {terms[place] for place in change.swaps}) for change in likely]
    for (a, here), (b, there) in combinations(placed, 2):
        if here & there and not overlap(a.splices, b.splices):
            pair = a & b
            if numbers.vanishes(numbers.residual(pair.swaps)):
                yield pair


def _verified(patient: Patient, changes: Iterable[Change]) -> list[Mend]:
    """The simplest changes whose text, read again, holds; of those that come to the same the simplest."""
    chosen, shapes, printed = list[Mend](), list[Values](), patient.printed
    likely = sorted((change for change in changes if change.cost <= FARTHEST), key=lambda change: change.order)
    for change in likely[:MOST_TEXTS]:
        if len(chosen) == MOST_MENDS or (chosen and change.cost > chosen[0].cost + FARTHER):
            break
        text = spliced(printed.text, change.splices)
        with suppress(Unread, IndexError):
            sides = printed.read_again(text, patient.equation.tight)[printed.index]
            equation = replace(patient.equation, sides=sides)
            if not holds(equation, random_states(patient.system)) or _is_empty(equation, patient):
                continue
            shape = standing(equation, patient.system)
            again = any(other.shape == shape.shape and np.abs(other - shape).max() < CLOSE for other in shapes)
            if not again and check(equation, patient.system)[0]:
                shapes.append(shape)
                chosen.append(Mend(**vars(change), text=text, equation=equation, alone=printed.alone))
    return chosen


def _is_empty(equation: Equation, patient: Patient) -> bool:
    """Whether an equation that holds says little.

    That is one of constants alone unlike the wrong one, of what is given freely and cancels, with two sides alike, with
    one side within another, whose sides are 0, or of units that no longer agree.
    """
    context = equation.context(random_states(patient.system))
    if not any(np.any(evaluate(side, context)) for side in equation.sides):
        return True
    spec, names = patient.spec, equation.names
    if of_equation(equation, spec)[1] and not of_equation(patient.equation, spec)[1]:
        return True
    fewer = names <= spec.still and not patient.equation.names <= spec.still
    derived = any(part.kind == "derivative" for part in parts(equation.sides))
    own = names - equation.definitions.keys()
    cancels = not derived and own <= {*spec.state, *spec.parameters, *spec.unknowns}  # which are given freely
    cancels = cancels and bool((names | patient.equation.names) & {*spec.parameters})
    cancels = cancels and holds(equation, free_states(patient.system))
    lone = {side.value: side for side in equation.sides if side.kind == "symbol"}
    again = any(lone.keys() & side.names for side in equation.sides if side not in lone.values())
    return bool(fewer or cancels or again) or any(key(left) == key(right) for left, right in pairwise(equation.sides))


def standing(equation: Equation, system: System) -> Values:
    """An equation's residual off the true motion up to a factor: what is multiplied by 4 says the same."""
    flat = stack_residuals(equation, free_states(system), plain=True).ravel()
    largest = flat[np.argmax(np.abs(flat))]
    return flat / largest if abs(largest) > 1e-12 else flat


def styles_of(printed: Printed, sides: tuple[Node, ...]) -> dict[str, str]:
    """How a text prints each quantity, where it is seen first."""
    names = [part for part in parts(sides) if part.kind == "symbol" and part.span[1] > part.span[0]]
    return {part.value: printed.text[slice(*part.span)].strip() for part in reversed(names)}
