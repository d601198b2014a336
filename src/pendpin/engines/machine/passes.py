"""Passes along a chain of any length, recorded once for a rod: what the equations carry from rod to rod becomes a loop.

The equations see a chain of one rod (pendpin.equations.trees): it hangs on what a pass carries outward, and what a pass
carries inward hangs on it. Most of what is carried has structure: entries that stay 0, or entries that are equal, as those
of a symmetric matrix. A body is recorded until this structure no longer changes: first as if a rod passed on what it
receives, then with each entry on its own that turned out to differ.
"""

from collections import defaultdict
from collections.abc import Callable, Hashable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from pendpin.engines.machine.tape import LEAVES, Cell, Pass, Tape, Term, recorded
from pendpin.equations.trees import Step, add, inward_steps, outward_steps
from pendpin.ground.arrays import Array

Body = Callable[[Any], Any]  # what arrives at a rod -> what it passes on


def recorded_by_rod(tape: Tape) -> Any:
    """The functions as `recorded`, with passes over all rods; they see the links (n,) of one rod, by their parents."""

    def outward(step: Step, base: Any, parents: Sequence[int]) -> list[Any]:
        """The results of a step outward; `base` is what the first rod of the chain receives."""
        done: list[tuple[Any, Any]] = []

        def body(arriving: Any) -> Any:
            done[:] = outward_steps(step, arriving, parents)
            return done[-1][0]

        _record(tape, False, body, base, body(base))
        return [result for _, result in done]

    def inward(step: Step, own: Sequence[Any], parents: Sequence[int]) -> list[Any]:
        """The results of a step inward; nothing hangs on the last rod of the chain."""
        done: list[tuple[Any, Any]] = []

        def body(arriving: Any) -> Any:
            done[:] = inward_steps(step, [*own[:-1], add(own[-1], arriving)], parents)
            return done[0][0]

        passed = inward_steps(step, own, parents)[0][0]
        _record(tape, True, body, _rebuilt(passed, [0.0] * len(_entries(passed))), passed)
        return [result for _, result in done]

    def total(x: Array) -> Any:
        """The sum of the numbers (k,) of all rods."""
        own = np.sum(x)
        return _record(tape, False, lambda before: before + own, np.zeros(1), np.array([own]))[0]

    return SimpleNamespace(**vars(recorded()), outward=outward, inward=inward, total=total)


def _record(tape: Tape, is_inward: bool, body: Body, first: Any, second: Any) -> Any:
    """Record a pass that begins with `first` and passes on `second`; returns what it carries at its end."""
    number, start, passed = len(tape.passes), _entries(first), _entries(second)
    tape.passes.append(Pass(is_inward, []))
    histories, classes = [(_label(x),) for x in start], None  # of each entry what it was from rod to rod
    while True:
        histories = [(*history, _label(x)) for history, x in zip(histories, passed, strict=True)]
        before, classes = classes, list[int | None]()  # the cell of each entry: one for those that are always equal
        numbers: dict[Hashable, int] = {}
        for history in histories:
            label = history[0]
            changes = len(set(history)) > 1 or (isinstance(label, tuple) and tape.by_rod[label[1]])
            classes.append(numbers.setdefault(history, len(numbers)) if changes else None)
        if classes == before:
            break
        arriving = list(start)
        for i, cell in enumerate(classes):
            if cell is not None:
                arriving[i] = tape.term("carried", number, cell, by_rod=True)
        passed = _entries(body(_rebuilt(first, arriving)))
    cells = {cell: Cell(*map(tape.placed, pair)) for cell, *pair in zip(classes, start, passed, strict=True)}
    tape.passes[number] = Pass(is_inward, [cells[cell] for cell in range(len(numbers))])
    ends = zip(classes, start, strict=True)
    return _rebuilt(first, [x if cell is None else tape.term("last", number, cell) for cell, x in ends])


def _label(x: Any) -> Hashable:
    """What two entries have in common that are the same: a number, or a place on the tape."""
    return ("at", x.place) if isinstance(x, Term) else float(x)


def _entries(x: Any) -> list[Any]:
    """The entries of an array, or of all arrays of a tuple."""
    return [entry for part in (x if isinstance(x, tuple) else (x,)) for entry in np.asarray(part, dtype=object).flat]


def _rebuilt(like: Any, entries: Sequence[Any]) -> Any:
    """Entries in the arrays of `like`."""
    if not isinstance(like, tuple):
        out = np.empty(np.shape(like), dtype=object)
        out.ravel()[:] = entries
        return out
    ends = np.cumsum([np.size(part) for part in like])
    parts = [_rebuilt(part, entries[end - np.size(part) : end]) for part, end in zip(like, ends, strict=True)]
    return like._make(parts) if hasattr(like, "_make") else tuple(parts)  # type: ignore[attr-defined]


# --- in which loop along a chain each operation is computed, and what one loop leaves for the next -------------------


class Schedule:
    """The loop of each operation that some results need.

    Loops have the numbers 1, 2, 3, ...: odd ones go outward, even ones inward. Passes of one direction share a loop as long
    as what they carry can be computed in it. A pass that needs what a later loop knows moves to the next loop of its
    direction, and with it what needs that pass, until nothing moves. An operation is computed in the first loop that uses
    it, unless it needs what a pass carries.
    """

    def __init__(self, tape: Tape, results: Sequence[int]) -> None:
        self.tape, self.needed, self._results = tape, tape.needed(results), results
        self._carried: list[tuple[int, Cell]] = []  # what passes carry: the place of the operation, and the cell
        passed_on: list[tuple[int, int]] = []  # the number of a pass, and the place of what a rod passes on in it
        for place in self.needed:
            if tape.operations[place][0] == "carried":
                _, number, cell = tape.operations[place]
                self._carried.append((place, tape.passes[number].cells[cell]))
                passed_on.append((number, self._carried[-1][1].next))
        pass_loops, before = [2 if one.inward else 1 for one in tape.passes], None
        earliest: dict[int, int] = {}  # the first loop in which each operation of a rod can be computed; 0 for any
        while pass_loops != before:
            before, earliest = list(pass_loops), {}
            for place in self.needed:
                name, *rest = tape.operations[place]
                if name == "carried":
                    earliest[place] = pass_loops[rest[0]]
                elif tape.by_rod[place]:
                    earliest[place] = max([earliest.get(x, 0) for x in tape.operands[place]], default=0)
            for which, place in passed_on:
                if (due := earliest.get(place, 0)) > pass_loops[which]:
                    pass_loops[which] = due + (due - pass_loops[which]) % 2

        uses: dict[int, list[int]] = defaultdict(list)  # the loops that use an operation
        for which, place in passed_on:
            uses[place].append(pass_loops[which])
        self.loop: dict[int, int] = {}  # of each operation of a rod but leaves, which are read anew in each loop
        for place in reversed(self.needed):
            is_leaf = tape.fixed[place] or tape.operations[place][0] in LEAVES or self.is_trigonometric(place)
            if place in earliest and (earliest[place] or not is_leaf):
                self.loop[place] = earliest[place] or min(uses[place], default=1)
                for x in tape.operands[place]:
                    uses[x].append(self.loop[place])
        self.loops = sorted(set(self.loop.values()))
        self.late = set[int]()  # the operations of no rod that are computed after the loops
        for place in self.needed:
            if tape.operations[place][0] == "last" or not self.late.isdisjoint(tape.operands[place]):
                self.late.add(place)
        used = [(x, loop) for place, loop in self.loop.items() for x in tape.operands[place]]
        used += [(place, pass_loops[which]) for which, place in passed_on]
        self.stored = sorted({x for x, loop in used if loop > self.loop.get(x, loop)})  # what later loops read

    def carried(self, loop: int) -> list[tuple[int, Cell]]:
        """What the passes of a loop carry: the place of the operation, and the cell."""
        return [(place, cell) for place, cell in self._carried if self.loop[place] == loop]

    def read(self, loop: int) -> list[int]:
        """The operations of the rod that a loop reads, as it does not compute them."""
        used = {x for place, at in self.loop.items() if at == loop for x in self.tape.operands[place]}
        used.update(cell.next for _, cell in self.carried(loop))
        used.update(place for place in self._results if self.loop_of(place) == loop)
        return sorted(x for x in used if self.tape.by_rod[x] and self.loop.get(x) != loop)

    def loop_of(self, place: int) -> int:
        """The loop in which a result is known: the first one for what all loops can read."""
        return self.loop.get(place, self.loops[0])

    def is_trigonometric(self, place: int) -> bool:
        """Whether it is the sine or cosine of an angle of the state: those of all rods are computed before the loops."""
        (name, *operands), tape = self.tape.operations[place], self.tape
        return name in {"sin", "cos"} and tape.operations[operands[0]][:2] == ("state", 0) and tape.by_rod[place]
