"""The smallest changes of a printed equation that make it hold, the simplest first, each verified on the changed text."""

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, pairwise
from typing import Any

import numpy as np

from pendpin.doctor.checking.check import check
from pendpin.doctor.checking.evaluation import Instead, Known
from pendpin.doctor.checking.residuals import (
    TOLERANCE,
    Equation,
    changed,
    relative_error,
    stack_residuals,
)
from pendpin.doctor.mending.additions import by_need, equal_products, possible
from pendpin.doctor.mending.edits import Edit, Editor, apply, overlap
from pendpin.doctor.mending.laws import standing
from pendpin.doctor.mending.mismatches import changes_of_kind
from pendpin.doctor.mending.monomials import Printer
from pendpin.doctor.mending.moves import moves
from pendpin.doctor.mending.needs import needs
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.grammar import parse
from pendpin.doctor.reading.tree import Node, Span, Unread, key, parts, symbols, walk
from pendpin.doctor.systems.base import Quantities, System, Values, random_states

MOST_NODES = 400  # of an equation that is searched
MOST_WORK = 400_000  # moves times parts of an equation that are tried
MOST_TOGETHER = 120  # moves of which every pair is tried
MOST_PAIRED = 700  # single moves that are tried in pairs
MOST_HIDDEN = 100  # moves under a derivative, whose texts are read again
MOST_MENDS = 4  # of an equation
MOST_VERIFIED = 400  # candidates whose text is read again
FARTHER = 0.75  # what a second mend may cost more than the first
FARTHEST = 3.2  # the cost beyond which a mend is too unlikely

Trial = Callable[[Instead], Values | None]  # the residual with other values for some parts


@dataclass(frozen=True, eq=False)
class Mend:
    """A verified change: the text with it, the changed spans of that text, words, and the equation that results."""

    text: str
    words: str
    old: str
    new: str
    cost: float
    proved: bool
    equation: Equation
    splices: tuple[tuple[int, int, str], ...]
    alone: bool = True  # its text holds no other equation
    changes: int = 1

    @property
    def span(self) -> tuple[int, int]:
        """Where the mended equation stands in its text."""
        sides = self.equation.sides
        return (0, len(self.text)) if self.alone else (sides[0].outer[0], sides[-1].outer[1])

    @property
    def changed(self) -> tuple[Span, ...]:
        """The characters of the text that are new; none between the ends of a span where something is gone."""
        spans, shift = [], 0
        for start, end, new in sorted(self.splices):
            spans.append((start + shift, start + shift + len(new)))
            shift += len(new) - (end - start)
        return tuple(spans)

    @property
    def latex(self) -> str:
        """The mended equation as it would be printed."""
        return self.text[slice(*self.span)].strip()


@dataclass(frozen=True, eq=False)
class Patient:
    """A wrong equation: one reading of what is printed, and who prints as its text does."""

    printed: Printed
    equation: Equation
    system: System
    printer: Printer

    @property
    def editor(self) -> Editor:
        """Who writes the changes of its text."""
        return Editor(self.printed.text, self.printer)

    def read(self, text: str) -> Equation:
        """The equation of a changed text, its names meaning the same. Raises Unread."""
        equations = parse(text, self.printed.words, tight=self.equation.tight)
        if len(equations) <= self.printed.index:
            raise Unread("the equation is gone")
        return replace(self.equation, sides=tuple(equations[self.printed.index]))


def mends(patient: Patient, pairs: bool) -> list[Mend]:
    """Verified mends, the simplest first; none where only unlikely ones would do. `pairs` also tries two changes."""
    equation, quantities = patient.equation, random_states(patient.system)
    nodes = sum(1 for _ in parts(equation.sides))
    if nodes > MOST_NODES:
        return []
    known: Known = {}
    rows = stack_residuals(equation, quantities, known)
    found = list(needs(equation, quantities, known))
    editor = patient.editor
    listed = sorted(moves(found, equation.context(quantities), editor), key=_order)[: MOST_WORK // nodes]
    tried = _trial(equation, quantities, known)
    effects = [tried(edit.instead or {}) for edit in listed]
    size = float(np.abs(rows).max())
    singles = [edit for edit, after in zip(listed, effects, strict=True) if after is not None and _zero(after, size)]
    hidden = _differentiated(equation)
    singles += [edit for edit in listed if not edit.instead or edit.instead.keys() & hidden][:MOST_HIDDEN]
    singles += list(by_need(found, quantities, editor, possible(equation, patient.system.spec)))
    singles += equal_products(found, equation, quantities, editor)
    chosen = _verified(patient, singles)
    if not chosen and pairs:
        chosen = _verified(patient, _pairs(listed, effects, rows))
    if not chosen and pairs and nodes < MOST_NODES // 8:
        chosen = _verified(patient, list(_any_two(equation, tried, listed, size)))
    return chosen


def _trial(equation: Equation, quantities: Quantities, known: Known) -> Trial:
    """Who tries other values for some parts: only what those stand in is evaluated again."""
    if equation.floats or equation.names & {"q_i", "dq_i"}:  # evaluated more than once, a part with several values
        return partial(changed, equation, quantities)
    above: dict[int, set[int]] = defaultdict(set)  # a part and all that it stands in, by id
    for part in parts(equation.sides):
        for below in walk(part):
            above[id(below)].add(id(part))

    def tried(instead: Instead) -> Values | None:
        touched: set[int] = set().union(*(above[part] for part in instead))
        kept = {part: value for part, value in known.items() if part not in touched}
        return changed(equation, quantities, {**kept, **instead})

    return tried


def _differentiated(equation: Equation) -> set[int]:
    """The parts under a derivative, by id: what changes there is tried on the text."""
    derivatives = (part for part in parts(equation.sides) if part.kind == "derivative")
    return {id(below) for part in derivatives for below in walk(part.children[0])}


def _any_two(equation: Equation, tried: Trial, listed: list[Edit], size: float) -> Iterator[Edit]:
    """Two of the likeliest moves in the same term, whose effects do not add up, each pair tried on numbers."""
    tops = (term for side in equation.sides for term in (side.children if side.kind == "sum" else (side,)))
    place = {id(part): i for i, term in enumerate(tops) for part in walk(term)}
    terms = {id(edit): {place.get(part) for part in edit.instead or ()} for edit in listed}
    likely = sorted((edit for edit in listed if edit.instead), key=_order)[:MOST_TOGETHER]
    for a, b in combinations(likely, 2):
        if terms[id(a)] & terms[id(b)] and not overlap(a.splices, b.splices):
            both = _both(a, b)
            after = tried(both.instead or {})
            if after is not None and _zero(after, size):
                yield both


def mends_of_mismatch(patient: Patient) -> list[Mend]:
    """Mends of an equation that mixes numbers and vectors, so that no part has a value: tried on the text."""
    sides = patient.equation.sides
    if sum(1 for _ in parts(sides)) > MOST_NODES // 2:
        return []
    return _verified(patient, list(changes_of_kind(list(sides), patient.editor)))


def mends_of_unknown(patient: Patient, unknown: set[str]) -> list[Mend]:
    """Mends of an equation with one symbol that is not known: another one wherever it stands, tried on the text."""
    editor, spec = patient.editor, patient.system.spec
    places: dict[tuple[int, int], int] = {}  # of the symbol with its dots: how many
    for part in parts(patient.equation.sides):
        inside = [p for p in walk(part) if p.kind == "symbol"]
        if part.kind in ("symbol", "derivative") and {p.value for p in inside} == unknown and len(inside) == 1:
            places[part.span] = max(places.get(part.span, 0), sum(p.kind == "derivative" for p in walk(part)))
    edits = []
    for name in (*spec.coordinates, *spec.parameters):
        splices = tuple(editor.put(span, editor.printer.symbol("d" * dots + name)) for span, dots in places.items())
        old = editor.of(next(iter(places), (0, 0)))
        edits.append(Edit(splices, 1.0, f"{old} should be {splices[0][2]}", old, splices[0][2]) if splices else None)
    return _verified(patient, [edit for edit in edits if edit is not None])


def _zero(rows: Values, size: float) -> bool:
    return bool(np.isfinite(rows).all() and np.abs(rows).max() <= 1e-8 * size)


def _pairs(listed: list[Edit], effects: list[Values | None], rows: Values) -> list[Edit]:
    """Two moves whose effects add up to what is missing: sorted by the first state, compared on all."""
    known = ((edit, after) for edit, after in zip(listed, effects, strict=True) if after is not None)
    usable = [(edit, after) for edit, after in known if after.shape == rows.shape and np.isfinite(after).all()]
    usable = sorted(usable, key=lambda pair: pair[0].cost)[:MOST_PAIRED]
    if len(usable) < 2:
        return []
    target, size = -rows.ravel(), float(np.abs(rows).max())
    changes = np.array([(after - rows).ravel() for _, after in usable])
    first = int(np.argmax(np.abs(target)))
    order = np.argsort(changes[:, first])
    ranked = changes[order, first]
    pairs = []
    for i, change in enumerate(changes):
        wanted = target - change
        low, high = np.searchsorted(ranked, [wanted[first] - 1e-8 * size, wanted[first] + 1e-8 * size])
        for j in order[low:high]:
            one, other = usable[i][0], usable[j][0]
            close = j > i and np.abs(changes[j] - wanted).max() <= 1e-8 * size
            if close and not overlap(one.splices, other.splices):
                pairs.append(_both(one, other))
    return pairs


def _both(a: Edit, b: Edit) -> Edit:
    """Two changes as one."""
    instead: Any = dict(a.instead or {})
    for node, change in (b.instead or {}).items():
        first = instead.get(node)
        instead[node] = (lambda x, f=first, g=change: g(f(x))) if callable(first) and callable(change) else change
    words = f"{a.words}, and {b.words}"
    return Edit((*a.splices, *b.splices), a.cost + b.cost, words, f"{a.old}; {b.old}", f"{a.new}; {b.new}", instead, 2)


def _verified(patient: Patient, edits: list[Edit]) -> list[Mend]:
    """The simplest edits whose text, read again, holds; of those that come to the same the simplest."""
    held: list[tuple[float, Edit, str, Equation, Values]] = []
    truth = random_states(patient.system)
    for edit in sorted((e for e in edits if e.cost <= FARTHEST), key=_order)[:MOST_VERIFIED]:
        text = apply(patient.printed.text, edit.splices)
        try:
            equation = patient.read(text)
            if relative_error(equation, truth) < TOLERANCE and not _empty(equation, patient):
                shape, odd = standing(equation, patient.system)
                held.append((edit.cost + odd, edit, text, equation, shape))
        except Unread:
            continue
    chosen: list[Mend] = []
    shapes: list[Values] = []
    for cost, edit, text, equation, shape in sorted(held, key=lambda h: (h[0], *_order(h[1]))):
        if len(chosen) == MOST_MENDS or (chosen and cost > chosen[0].cost + FARTHER):
            break
        if any(other.shape == shape.shape and np.abs(other - shape).max() < 1e-8 for other in shapes):
            continue
        verdict = check(equation, patient.system)
        if verdict.holds:
            shapes.append(shape)
            words = (edit.words, edit.old, edit.new)
            alone = patient.printed.alone
            chosen.append(Mend(text, *words, cost, verdict.proved, equation, edit.splices, alone, edit.changes))
    return chosen


def _empty(equation: Equation, patient: Patient) -> bool:
    """Whether an equation that holds says little.

    That is one of constants alone unlike the wrong one, of what is given freely and cancels, with two sides alike, or with
    one side within another.
    """
    spec = patient.system.spec
    fewer = equation.names <= spec.still and not patient.equation.names <= spec.still
    given = equation.names <= {*spec.state, *spec.parameters} and not _differentiated(equation)
    cancels = given and equation.names & {*spec.parameters}
    lone = {side.value: side for side in equation.sides if side.kind == "symbol"}
    again = any(lone.keys() & symbols(side) for side in equation.sides if side not in lone.values())
    return bool(fewer or cancels or again) or any(key(left) == key(right) for left, right in pairwise(equation.sides))


def _order(edit: Edit) -> tuple[float, int, str]:
    return edit.cost, len(edit.words), edit.words


def styles_of(printed: Printed, sides: tuple[Node, ...]) -> dict[str, str]:
    """How a text prints each quantity, where it is seen first."""
    names = [part for part in parts(sides) if part.kind == "symbol" and part.span[1] > part.span[0]]
    return {part.value: printed.text[slice(*part.span)].strip() for part in reversed(names)}
