"""Exact directional derivatives of equations on a tape, recorded on the same tape and compiled like the rest.

Every operation gets its derivative in each of k directions by the chain rule (forward mode: A. Griewank, A. Walther,
Evaluating Derivatives, 2008, chapter 3). A direction is a change of the state, of parameters and of the time. The state is
then (y, w_1, ..., w_k), each w of the size of y, and the results are (f, f_1, ..., f_k):
    f_j = df/dy w_j + df/dp p_j + df/dt t_j
so y' = f(t, y) becomes the variational equations w_j' = f_j. Up to LANES directions are computed side by side, by
operations on several numbers at once: what they have in common, the values and slopes, is computed once. One
direction at a time took 1.5, 2.7 and 4.0 times as long for all directions of 1, 3 and 10 rods.

Where a function is continuous but not differentiable, one derivative is taken: that of sqrt at 0 is 0, so that the
quadratic drag |u| u has its derivative, 0, at rest; minimum and maximum of a number and a constant that are
equal have that of the constant. Between the rows of a table nothing changes.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pendpin.engines.machine.tape import LEAVES, Cell, Recording, Tape, Term

LANES = 8  # numbers of a register of today's processors, or of two

Places = Mapping[int, int]  # the place of a parameter -> that of its rate of change


class Direction(NamedTuple):
    """What changes in one direction beside the state; parameters by their places among those of the tape."""

    shared: Places
    of_rods: Places
    time: float = 0.0


STATE = Direction({}, {})  # the state alone


def add_tangents(recording: Recording, directions: Sequence[Direction]) -> Recording:
    """The recording with its derivatives in these directions: results f, then f_1, ..., f_k, of states y, w_1, ..., w_k.

    The further results have derivatives too. Of a chain by rods only the results of the rods have.
    """
    tape, chain = recording.tape, bool(recording.parts)
    places = [tape.placed(x) for x in (recording.of_rod if chain else [*recording.results, *recording.more])]
    count = -(-len(directions) // LANES)
    groups = [directions[i * len(directions) // count : (i + 1) * len(directions) // count] for i in range(count)]
    derivatives = _Tangents(recording, groups).of(places)
    rows = [[_term(tape, place) for place in places]]
    for group, changes in zip(groups, derivatives, strict=True):
        rows += [[tape.lane(x, i) for x in changes] for i in range(len(group))]
    if chain:
        return recording._replace(of_rod=[x for row in rows for x in row], parts=len(rows) * recording.parts)
    own = len(recording.results)
    results, more = ([x for row in rows for x in row[part]] for part in (slice(own), slice(own, None)))
    return recording._replace(results=results, more=more, width=len(rows) * recording.width)


class _Tangents:
    """The derivatives of the operations of a tape, by place, in each group of directions; one that is missing has 0."""

    def __init__(self, recording: Recording, groups: Sequence[Sequence[Direction]]) -> None:
        self.tape, self._recording, self._groups = recording.tape, recording, groups
        self._firsts = np.cumsum([0, *map(len, groups)]).tolist()  # the place of each group's first direction
        self._tangents: list[dict[int, Any]] = [{} for _ in groups]
        self._cells: dict[tuple[int, int, int], int] = {}  # group, pass and cell -> the cell of its derivative

    def of(self, results: Sequence[int]) -> list[list[Any]]:
        """The derivatives of some operations, group by group: those of its directions side by side."""
        needed = self.tape.needed(results)  # before derivatives are appended behind it
        directions = [direction for group in self._groups for direction in group]
        shared, of_rods = ({x for one in directions for x in getattr(one, kind)} for kind in ("shared", "of_rods"))
        times = any(direction.time for direction in directions)
        active, before = set[int](), -1  # what changes in some direction
        while len(active) != before:  # what passes carry may depend on what comes later on the tape
            before = len(active)
            for place in needed:
                name, *rest = self.tape.operations[place]
                if name == "parameter":
                    changes = rest[0] in (of_rods if rest[1] else shared)
                else:
                    changes = times if name == "time" else name == "state"
                if changes or not active.isdisjoint(self.tape.sources(place)):
                    active.add(place)
        for place in needed:
            if place in active:
                for j, tangents in enumerate(self._tangents):
                    tangent = self._tangent(place, j)
                    if not _is_zero(tangent):
                        tangents[place] = tangent
        for (j, number, cell), new in self._cells.items():
            cells = self.tape.passes[number].cells
            cells[new] = Cell(*(self.tape.placed(self._tangents[j].get(place, 0.0)) for place in cells[cell]))
        return [[tangents.get(place, 0.0) for place in results] for tangents in self._tangents]

    def _tangent(self, place: int, j: int) -> Any:
        """The derivative of one operation in the directions of group j, a term or 0."""
        tape, (name, *rest), group = self.tape, self.tape.operations[place], self._groups[j]
        if name in {"carried", "last"}:
            number, cell = rest
            cells = tape.passes[number].cells
            if (j, number, cell) not in self._cells:  # what it holds is known when all derivatives are
                self._cells[j, number, cell] = len(cells)
                cells.append(cells[cell])
            lanes = len(group) if len(group) > 1 else 0
            return tape.term(name, number, self._cells[j, number, cell], by_rod=name == "carried", lanes=lanes)
        if name in LEAVES:
            changes = enumerate(group, 1 + self._firsts[j])
            return tape.pack([self._differentiate_leaf(name, rest, direction, times) for times, direction in changes])
        if name in {"row", "entry"}:
            return 0.0  # between the rows of a table nothing changes
        operands = tape.operands[place]
        terms, changes = [_term(tape, x) for x in operands], [self._tangents[j].get(x, 0.0) for x in operands]
        if all(map(_is_zero, changes)):
            return 0.0
        if name == "neg":
            return -changes[0]
        if len(operands) == 2:
            return _differentiate_binary(tape, name, Term(tape, place), *terms, *changes)
        return _slope(tape, name, Term(tape, place), terms[0]) * changes[0]

    def _differentiate_leaf(self, name: str, rest: Sequence[Any], direction: Direction, times: int) -> Any:
        """Of the state, a parameter or the time; the change of the state stands that multiple of its size behind it."""
        recording = self._recording
        if name == "state" and recording.parts:
            return self.tape.term("state", times * recording.parts + rest[0], rest[1], by_rod=True)
        if name == "state":
            return self.tape.term("state", times * recording.width + rest[0])
        if name == "parameter":
            new = (direction.of_rods if rest[1] else direction.shared).get(rest[0])
            return 0.0 if new is None else self.tape.parameter(new, rest[1])
        return direction.time if name == "time" else 0.0


def _differentiate_binary(tape: Tape, name: str, result: Term, a: Any, b: Any, da: Any, db: Any) -> Any:
    if name in {"add", "sub"}:
        return da + db if name == "add" else da - db
    if name == "mul":
        return a * db + b * da
    if name == "div":
        return (da - result * db) * (1.0 / b)
    if name == "pow":
        of_base = 0.0 if _is_zero(da) else b * a ** (b - 1) * da
        log = tape.record("log", a) if isinstance(a, Term) else float(np.log(a))
        return of_base if _is_zero(db) else of_base + result * log * db
    if _is_zero(da):  # the order of two that commute is that of their places
        a, b, da, db = b, a, db, da
    first = tape.record("less", a, b) if name == "min" else tape.record("less", b, a)
    return first * da + (0.0 if _is_zero(db) else (1.0 - first) * db)


def _slope(tape: Tape, name: str, result: Term, x: Any) -> Any:
    """The derivative of a function, from its argument and its value."""
    if name == "sin":
        return tape.record("cos", x)
    if name == "cos":
        return -tape.record("sin", x)
    if name == "sqrt":  # 0 at 0
        positive = tape.record("less", 0.0, result)
        return 0.5 * positive / (result + (1.0 - positive))
    if name in {"exp", "log"}:
        return result if name == "exp" else 1.0 / x
    square = result * result
    return 1.0 + square if name == "tan" else 1.0 - square  # tanh


def _is_zero(x: Any) -> bool:
    return not isinstance(x, Term) and x == 0


def _term(tape: Tape, place: int) -> Any:
    """The operation at a place; a number as it is."""
    name, *rest = tape.operations[place]
    return rest[0] if name == "number" else Term(tape, place)
