"""Arithmetic recorded while it is computed, to be compiled to machine code.

A tape is a list of operations, each distinct one once. They start from the time, the state, the parameters of a run (the
numbers of its scene), tables over time, and inputs that change between the segments of a run. What depends on parameters
alone is `fixed`: it is computed once for a set of parameters, not at every evaluation. Numbers that are 0 or 1 by structure
are plain floats and are simplified away.

A tape of a chain of any length holds the operations of one rod (`by_rod`): they start from that rod's state, parameters
and inputs, and from what passes along the chain carry from rod to rod (passes.py).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache, partial, reduce
from operator import mul
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from pendpin.equations.base import FUNCTIONS
from pendpin.ground.arrays import Array

_MOST_FACTORS = 8  # up to which a whole power is written out
_COMMUTING = ("add", "mul", "min", "max")
_WITH_CONSTANTS = {"row", "entry", "lane"}  # behind their one operand
# Operations without operands: the time, a number of the state, or of a part of a rod's; a parameter; a number that changes
# between the segments of a run, or one of a rod, in the first or second half of those; a constant; what a pass, by its
# number, carries from rod to rod, and what it carries at its end.
LEAVES = ("time", "state", "parameter", "input", "number", "carried", "last")
_NONE = np.empty((0, 1))
_ON_FLOATS: dict[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "pow": np.power,
    "min": np.minimum,
    "max": np.maximum,
    "less": lambda x, y: np.where(np.less(x, y), 1.0, 0.0),
    "neg": np.negative,
    **{name: getattr(np, name) for name in FUNCTIONS},
}


@dataclass(eq=False, repr=False)
class Tape:
    """The operations, each a name and the places of its operands (or what it stands for), in an order of computing."""

    operations: list[tuple[Any, ...]] = field(default_factory=list)
    operands: list[tuple[int, ...]] = field(default_factory=list)  # the places of what each is computed from
    fixed: list[bool] = field(default_factory=list)  # whether an operation depends on parameters alone
    by_rod: list[bool] = field(default_factory=list)  # whether it has a value for each rod
    lanes: list[int] = field(default_factory=list)  # how many numbers it is at once; 0 for a single one
    passes: list["Pass"] = field(default_factory=list)
    _places: dict[tuple[Any, ...], int] = field(default_factory=dict)

    def term(self, *operation: Any, fixed: bool = False, by_rod: bool = False, lanes: int = 0) -> "Term":
        """An operation, by its name and what it is computed from or stands for (LEAVES)."""
        place = self._places.get(operation)
        if place is not None:
            return Term(self, place)
        operands = () if operation[0] in LEAVES else operation[1 : 2 if operation[0] in _WITH_CONSTANTS else None]
        return self._new(operation, operands, fixed, by_rod, lanes)

    def state(self, width: int, parts: int = 0) -> Array:
        """The state y (width,); with `parts` that of one rod, (parts width,), in a state with so many parts for each rod."""
        cells = [(part, i) for part in range(parts) for i in range(width)] if parts else [(i,) for i in range(width)]
        return np.array([self.term("state", *cell, by_rod=parts > 0) for cell in cells], dtype=object)

    def parameter(self, place: int, by_rod: bool = False) -> "Term":
        """One of the run's parameters, or of those that each rod has its own value of."""
        return self.term("parameter", place, by_rod, fixed=True, by_rod=by_rod)

    def pack(self, values: Sequence[Any]) -> Any:
        """Several terms or numbers side by side, as one term on which operations act lane by lane; 0 if all are 0."""
        if len(values) == 1 or not any(isinstance(x, Term) or x for x in values):
            return values[0]
        operands = [self.placed(x) for x in values]
        fixed, by_rod = all(self.fixed[x] for x in operands), any(self.by_rod[x] for x in operands)
        return self.term("pack", *operands, fixed=fixed, by_rod=by_rod, lanes=len(operands))

    def lane(self, x: Any, i: int) -> Any:
        """One of the terms side by side; a single term or number is all of them."""
        if not isinstance(x, Term) or not self.lanes[x.place]:
            return x
        return self.term("lane", x.place, i, fixed=self.fixed[x.place], by_rod=self.by_rod[x.place])

    def row(self, table: int, width: int, t: Any) -> Array:
        """The row (width,) of a table that holds at the time t."""
        row = self.term("row", self.placed(t), table, width).place
        return np.array([self.term("entry", row, i) for i in range(width)], dtype=object)

    def record(self, name: str, x: Any, y: Any = None) -> "Term":
        """An operation on one or two terms and numbers."""
        first = x.place if type(x) is Term else self.placed(x)
        last, operation = first, (name, first)
        if y is not None:
            last = y.place if type(y) is Term else self.placed(y)
            operation = (name, last, first) if last < first and name in _COMMUTING else (name, first, last)
        place = self._places.get(operation)
        if place is not None:
            return Term(self, place)
        fixed, by_rod = self.fixed[first] and self.fixed[last], self.by_rod[first] or self.by_rod[last]
        lanes = max(self.lanes[first], self.lanes[last])
        return self._new(operation, operation[1:], fixed, by_rod, lanes)

    def fixed_operands(self, results: Sequence[int]) -> list[int]:
        """The fixed operations, but for plain numbers, that others or the results themselves take directly."""
        used = {x for place in self.needed(results) if not self.fixed[place] for x in self.sources(place)}
        return sorted(x for x in used.union(results) if self.fixed[x] and self.operations[x][0] != "number")

    def needed(self, results: Sequence[int]) -> list[int]:
        """The operations that some results take, in order: operands come before what is computed from them."""
        is_needed, left = [False] * len(self.operations), list(results)
        while left:
            place = left.pop()
            if not is_needed[place]:
                is_needed[place] = True
                left.extend(self.sources(place))
        return [place for place, is_wanted in enumerate(is_needed) if is_wanted]

    def sources(self, place: int) -> Sequence[int]:
        """The places of all that an operation is computed from, on this rod and on others."""
        operation = self.operations[place]
        if operation[0] in {"carried", "last"}:
            return self.passes[operation[1]].cells[operation[2]]
        return self.operands[place]

    def values(self, needed: Sequence[int], parameters: Sequence[float], of_rods: Array = _NONE) -> dict[int, Any]:
        """What fixed operations come to: numbers, or arrays (n,) of those with parameters of n rods, of_rods (k, n).

        They are given with all that they need, in order.
        """
        # Those of several lanes are arrays (lanes, 1) or (lanes, n).
        results: dict[int, Any] = {}
        for place in needed:
            name, *operands = self.operations[place]
            if name == "parameter":
                results[place] = (of_rods if operands[1] else parameters)[operands[0]]
            elif name == "number":
                results[place] = operands[0]
            elif name == "pack":
                results[place] = np.array(np.broadcast_arrays(*(np.atleast_1d(results[x]) for x in operands)))
            elif name == "lane":
                row = results[operands[0]][operands[1]]
                results[place] = row if self.by_rod[place] else float(row[0])
            else:
                result = _ON_FLOATS[name](*(results[x] for x in operands))
                results[place] = result if self.by_rod[place] or self.lanes[place] else float(result)
        return results

    def placed(self, x: Any) -> int:
        """The place of a term or number."""
        return x.place if isinstance(x, Term) else self.term("number", float(x), fixed=True).place

    def _new(self, operation: tuple, operands: tuple[int, ...], fixed: bool, by_rod: bool, lanes: int) -> "Term":
        place = self._places[operation] = len(self.operations)
        self.operations.append(operation)
        self.operands.append(operands)
        self.fixed.append(fixed)
        self.by_rod.append(by_rod)
        self.lanes.append(lanes)
        return Term(self, place)


class Cell(NamedTuple):
    """A number that a pass carries: its places on the tape."""

    first: int  # at the rod where the pass begins
    next: int  # on the way from a rod to the next


class Pass(NamedTuple):
    """A pass over all rods, from the support to the tip or back."""

    inward: bool
    cells: list[Cell]


class Recording(NamedTuple):
    """Equations on a tape: y' of a state y, and what else is computed with it.

    With `parts`, of a chain of any length: a state has so many parts, each with a row of numbers for every rod, and then
    the others. `of_rod` and `more_of_rod` are the results of one rod.
    """

    tape: Tape
    results: list[Any]  # terms or numbers
    more: Sequence[Any] = ()  # further results
    inputs: int = 0  # how many inputs there are, of a rod if there are parts
    directions: int = 0  # how many unit vectors in space the state begins with, of a rod if there are parts
    parts: int = 0
    width: int = 0  # how many numbers a state has; with parts, each part for a rod
    of_rod: Sequence[Any] = ()
    more_of_rod: Sequence[Any] = ()

    def state_size(self, rods: int = 1) -> int:
        """How many numbers a state has, of a chain of `rods` rods."""
        return rods * self.parts * self.width + len(self.results) if self.parts else self.width

    @property
    def places(self) -> list[int]:
        """The places of the results that are of no rod."""
        return [self.tape.placed(x) for x in self.results]


def _with(name: str) -> Callable[..., Any]:
    """An operator of two terms, or as it says of a term and a number; arrays apply it to their elements themselves."""

    def operator(with_number: Callable[["Term", Any], Any]) -> Callable[["Term", Any], Any]:
        def operate(self: "Term", other: Any) -> Any:
            if type(other) is Term:
                return self.tape.record(name, self, other)
            return NotImplemented if isinstance(other, np.ndarray) else with_number(self, other)

        return operate

    return operator


@dataclass(eq=False, repr=False, slots=True)
class Term:
    """A number on a tape. It has no value: what asks for one raises TypeError."""

    tape: Tape
    place: int

    def __neg__(self) -> "Term":
        name, *operands = self.tape.operations[self.place]
        return Term(self.tape, operands[0]) if name == "neg" else self.tape.record("neg", self)

    def __pos__(self) -> "Term":
        return self

    @_with("add")
    def __add__(self, number: Any) -> Any:
        return self if number == 0 else self.tape.record("add", self, number)

    @_with("sub")
    def __sub__(self, number: Any) -> Any:
        return self if number == 0 else self.tape.record("sub", self, number)

    @_with("sub")
    def __rsub__(self, number: Any) -> Any:
        return -self if number == 0 else self.tape.record("sub", number, self)

    @_with("mul")
    def __mul__(self, number: Any) -> Any:
        if number == 0:
            return 0.0
        if abs(number) == 1:
            return self if number == 1 else -self
        return self.tape.record("mul", self, number)

    @_with("div")
    def __truediv__(self, number: Any) -> Any:
        return self if number == 1 else self.tape.record("div", self, number)

    @_with("div")
    def __rtruediv__(self, number: Any) -> Any:
        return 0.0 if number == 0 else self.tape.record("div", number, self)

    @_with("pow")
    def __pow__(self, power: Any) -> Any:
        if power != int(power) or not 0 < power <= _MOST_FACTORS:
            return self.tape.record("pow", self, power)
        return reduce(mul, [self] * int(power))

    @_with("pow")
    def __rpow__(self, base: Any) -> Any:
        return self.tape.record("pow", base, self)

    __radd__, __rmul__ = __add__, __mul__

    def __bool__(self) -> bool:
        """True for parameters and their products, which are not 0 by structure; others have no truth."""
        name, *operands = self.tape.operations[self.place]
        if name == "parameter" or (name == "mul" and all(Term(self.tape, x) for x in operands)):
            return True
        raise TypeError("a symbol has no value: an effect that is compiled may not ask for one")

    def __eq__(self, other: object) -> bool:
        raise TypeError("symbols cannot be compared")

    __hash__ = None  # type: ignore[assignment]


@cache
def recorded() -> Any:
    """The functions of the number type (as in pendpin.equations.base), over object arrays of terms and numbers."""

    def record(name: str, *operands: Any) -> Any:
        terms = [x for x in operands if isinstance(x, Term)]
        return terms[0].tape.record(name, *operands) if terms else float(_ON_FLOATS[name](*operands))

    def record_of_angle(name: str, sign: int, x: Any) -> Any:
        """Sine or cosine, of minus an angle by that of the angle itself."""
        is_minus = type(x) is Term and x.tape.operations[x.place][0] == "neg"
        return record(name, x) if not is_minus else record(name, -x) if sign > 0 else -record(name, -x)

    one = {name: partial(record, name) for name in FUNCTIONS}
    one |= {"sin": partial(record_of_angle, "sin", -1), "cos": partial(record_of_angle, "cos", 1)}
    functions = {name: np.frompyfunc(function, 1, 1) for name, function in one.items()}
    pairs = {name: np.frompyfunc(partial(record, name[:3]), 2, 1) for name in ("minimum", "maximum")}
    return SimpleNamespace(asarray=np.asarray, **functions, **pairs)
