"""In which pass along a chain each operation of a tape is computed, and what one pass leaves for the next.

Passes with one direction run as one loop over the rods, as long as none needs what a later loop computes. Loops alternate:
the odd ones run outward, the even ones inward. What depends on no rod is computed before the loops, or after them if it
needs what a pass carried to its end.
"""

from collections import defaultdict
from collections.abc import Sequence

from pendpin.engines.tape import LEAVES, Cell, Tape


class Schedule:
    """The loop of each operation that some results need."""

    def __init__(self, tape: Tape, results: Sequence[int]) -> None:
        self.tape, self.needed = tape, tape.needed(results)
        self._of_rod = results
        self._carried = [place for place in self.needed if tape.operations[place][0] == "carried"]
        self._passed_on = [(tape.operations[place][1], self._cell(place).next) for place in self._carried]
        self._loops_of_passes = self._fused()
        self.loop = self._assign_loops(self._earliest(self._loops_of_passes))  # place -> its loop
        self.loops = sorted(set(self.loop.values()))
        self.late = set[int]()  # the operations of no rod that are computed after the loops
        for place in self.needed:
            if tape.operations[place][0] == "last" or not self.late.isdisjoint(tape.operands[place]):
                self.late.add(place)
        self.stored = self._stored()  # what a rod's operations leave for later loops

    def carried(self, loop: int) -> list[tuple[int, Cell]]:
        """What the passes of a loop carry: the place of the operation, and the cell."""
        return [(place, self._cell(place)) for place in self._carried if self.loop[place] == loop]

    def read(self, loop: int) -> list[int]:
        """The operations of the rod that a loop reads, as it does not compute them."""
        used = {x for place, at in self.loop.items() if at == loop for x in self.tape.operands[place]}
        used.update(cell.next for _, cell in self.carried(loop))
        used.update(place for place in self._of_rod if self.loop_of(place) == loop)
        return sorted(x for x in used if self.tape.by_rod[x] and self.loop.get(x) != loop)

    def loop_of(self, place: int) -> int:
        """The loop in which a result is known: the first one for what all loops can read."""
        return self.loop.get(place, self.loops[0])

    def _cell(self, place: int) -> Cell:
        """The cell of what a pass carries."""
        _, number, cell = self.tape.operations[place]
        return self.tape.passes[number].cells[cell]

    def is_trigonometric(self, place: int) -> bool:
        """Whether it is the sine or cosine of an angle of the state: those of all rods are computed before the loops."""
        name, *operands = self.tape.operations[place]
        return (
            name in {"sin", "cos"} and self.tape.operations[operands[0]][:2] == ("state", 0) and self.tape.by_rod[place]
        )

    def _fused(self) -> list[int]:
        """The loop of each pass: the first in its direction in which all that it carries can be computed."""
        loops = [2 if one.inward else 1 for one in self.tape.passes]
        while True:
            earliest, before = self._earliest(loops), list(loops)
            for number, place in self._passed_on:
                if (due := earliest.get(place, 0)) > loops[number]:
                    loops[number] = due + (due - loops[number]) % 2
            if loops == before:
                return loops

    def _earliest(self, loops: Sequence[int]) -> dict[int, int]:
        """The first loop in which each operation of a rod can be computed; 0 for any."""
        earliest: dict[int, int] = {}
        for place in self.needed:
            if not self.tape.by_rod[place]:
                continue
            operation = self.tape.operations[place]
            if operation[0] == "carried":
                earliest[place] = loops[operation[1]]
            else:
                earliest[place] = max([earliest.get(x, 0) for x in self.tape.operands[place]], default=0)
        return earliest

    def _assign_loops(self, earliest: dict[int, int]) -> dict[int, int]:
        """The loop of each operation of a rod but leaves: the first that uses it, unless it needs what a pass carries."""
        loop: dict[int, int] = {}
        uses: dict[int, list[int]] = defaultdict(list)  # the loops that use an operation
        for number, place in self._passed_on:
            uses[place].append(self._loops_of_passes[number])
        for place in reversed(self.needed):
            is_leaf = self.tape.fixed[place] or self.tape.operations[place][0] in LEAVES or self.is_trigonometric(place)
            if place not in earliest or (is_leaf and not earliest[place]):  # a leaf is read anew in each loop
                continue
            loop[place] = earliest[place] or min(uses[place], default=1)
            for x in self.tape.operands[place]:
                uses[x].append(loop[place])
        for place in loop:  # all results of an operation that has several are taken where it is computed
            name, *operands = self.tape.operations[place]
            if name == "entry":
                loop[place] = loop[int(operands[0])]
        return loop

    def _stored(self) -> list[int]:
        """The operations that later loops use."""
        last = dict(self.loop)
        for place, loop in self.loop.items():
            for x in self.tape.operands[place]:
                if x in last:
                    last[x] = max(last[x], loop)
        for number, place in self._passed_on:
            if place in last:
                last[place] = max(last[place], self._loops_of_passes[number])
        return [place for place in sorted(last) if last[place] > self.loop[place]]
