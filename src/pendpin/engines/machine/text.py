"""The text of a function in LLVM's intermediate language: what is computed once, loops over the rods, what follows them."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from pendpin.engines.machine.lines import (
    DECLARED,
    ROW,
    TRIGONOMETRY,
    WIDE,
    arithmetic,
    kind_of,
    lanes_of,
    load,
    number,
    repeated,
    store,
    table_row,
)
from pendpin.engines.machine.tape import LEAVES, Cell, Recording, Tape

EVERY = 4096  # calls between two of the progress callback; a power of 2
# The first cells of a block: the count of calls, the progress callback, how many rods there are, where loops leave numbers
# for later ones, where the numbers of the rods are, how long states and further results are, how many unit vectors there are
CALLS, CALLBACK, RODS, SCRATCH, NUMBERS, STATE, MORE, UNITS = range(8)
HEADER = 8  # how many these are
TABLE = 3  # cells of a table: addresses of its times and its rows, and how many there are


class Places(NamedTuple):
    """Where results are on the tape."""

    others: list[int]  # of no rod
    more: list[int]
    of_rod: list[int]
    more_of_rod: list[int]

    @staticmethod
    def of(recording: Recording) -> "Places":
        """Those of a recording."""
        parts = recording.results, recording.more, recording.of_rod, recording.more_of_rod
        return Places(*([recording.tape.placed(x) for x in part] for part in parts))

    @property
    def all(self) -> list[int]:
        """All of them."""
        return [place for part in self for place in part]


class _Row(NamedTuple):
    """The numbers of a rod in an array, or in a part of it."""

    array: str
    part: int
    width: int

    def at(self, loop: int) -> str:
        """The name of its address in a loop."""
        return f"{self.array}{self.part}_{loop}"

    def first(self, loop: int, rod: str) -> Iterator[str]:
        """The address %first of the row of the rod where a loop begins."""
        at = self.at(loop)
        yield f"  %part_{at} = mul i64 %part, {self.part}"
        yield f"  %rods_{at} = mul i64 {rod}, {self.width}"
        yield f"  %cells_{at} = add i64 %part_{at}, %rods_{at}"
        yield f"  %first_{at} = getelementptr double, ptr %{self.array}, i64 %cells_{at}"


class Text:
    """The text of a recording's function."""

    def __init__(self, recording: Recording, tables: int, places: Places) -> None:
        self.tape, self.places, self.schedule = recording.tape, places, Schedule(recording.tape, places.all)
        fixed = self.tape.fixed_operands(places.all)
        self.fixed = self._cells_of(x for x in fixed if not self.tape.by_rod[x])
        self.fixed_of_rod = self._cells_of(x for x in fixed if self.tape.by_rod[x])
        self._stored = self._cells_of(self.schedule.stored)
        self.inputs_at = HEADER + TABLE * tables + self._count(self.fixed)
        self._width = recording.width
        self._has_trigonometry = any(map(self.schedule.is_trigonometric, self.schedule.needed))
        stored = self._count(self._stored) + len(places.more_of_rod)
        self.scratch_of_rod = 2 * self._width * self._has_trigonometry + stored  # numbers in the scratch memory

    def __str__(self) -> str:
        return "\n".join(self._lines())

    def _cells_of(self, places: Iterable[int]) -> dict[int, int]:
        """The cell in memory of each of some operations, one after the other: several numbers have several cells."""
        cells, end = {}, 0
        for place in places:
            cells[place] = end
            end += self.tape.lanes[place] or 1
        return cells

    def _count(self, places: Iterable[int]) -> int:
        return sum(self.tape.lanes[place] or 1 for place in places)

    def _kind(self, place: int) -> str:
        return kind_of(self.tape.lanes[place])

    def _lines(self) -> Iterator[str]:
        tape, schedule = self.tape, self.schedule
        yield DECLARED
        yield "define void @rate(ptr noalias %dy, double %t, ptr noalias %y, ptr %blocks, ptr noalias %more) {"
        yield _REPORTING
        begin = self.inputs_at - self._count(self.fixed)
        for place, cell in self.fixed.items():
            yield from load(f"v{place}", "block", str(begin + cell), self._kind(place))
        once = [place for place in schedule.needed if not (tape.by_rod[place] or tape.fixed[place])]
        yield from self._computed(place for place in once if place not in schedule.late)
        if schedule.loops:
            yield from self._loops()
        yield from self._computed(place for place in once if place in schedule.late)
        yield from self._results()
        yield "  ret void\n}"
        if any(tape.operations[place][0] == "row" for place in schedule.needed):
            yield ROW
        if self._has_trigonometry:
            yield f"declare void @{TRIGONOMETRY}(ptr, i64, ptr, ptr)"

    def _results(self) -> Iterator[str]:
        """Store the results that are of no rod, behind those of the rods."""
        yield f"  %of_rods = mul i64 %rods, {len(self.places.of_rod)}"
        yield "  %others = getelementptr double, ptr %dy, i64 %of_rods"
        for i, place in enumerate(self.places.others):
            yield from store(self._name(place), f"other{i}", "others", str(i))
        if self.places.more:
            yield f"  %more_of_rods = mul i64 %rods, {len(self.places.more_of_rod)}"
            yield "  %behind = getelementptr double, ptr %more, i64 %more_of_rods"
            yield "  %wanted = icmp ne ptr %more, null"
            yield "  br i1 %wanted, label %further, label %end\nfurther:"
            for i, place in enumerate(self.places.more):
                yield from store(self._name(place), f"more{i}", "behind", str(i))
            yield "  br label %end\nend:"

    # --- loops --------------------------------------------------------------------------------------------------------

    def _loops(self) -> Iterator[str]:
        """The loops over the rods; further results go to the scratch memory where they are not wanted."""
        yield f"  %part = mul i64 %rods, {self._width}"
        yield "  %last = sub i64 %rods, 1"
        yield f"  %inputs = getelementptr double, ptr %block, i64 {self.inputs_at}"
        yield f"  %in_part = add i64 %part, {WIDE}"
        yield "  %cosines = getelementptr double, ptr %scratch, i64 %in_part"
        yield f"  %angles = mul i64 %in_part, {2 * self._has_trigonometry}"
        yield "  %stored = getelementptr double, ptr %scratch, i64 %angles"
        if self._has_trigonometry:
            yield f"  call void @{TRIGONOMETRY}(ptr %y, i64 %part, ptr %scratch, ptr %cosines)"
        yield f"  %stored_of_rods = mul i64 %rods, {self._count(self._stored)}"
        yield "  %aside = getelementptr double, ptr %stored, i64 %stored_of_rods"
        yield "  %unwanted = icmp eq ptr %more, null"
        yield "  %further_of_rods = select i1 %unwanted, ptr %aside, ptr %more"
        labels = [*(f"enter{loop}" for loop in self.schedule.loops), "after"]
        yield f"  br label %{labels[0]}"
        for loop, behind in zip(self.schedule.loops, labels[1:], strict=True):
            yield from self._loop(loop, behind)
        yield "after:"

    def _loop(self, loop: int, behind: str) -> Iterator[str]:
        """A loop over the rods, outward or inward, and the label of the code behind it.

        It carries the address of the rod's row in each array. LLVM does not see that they advance evenly: it would take a
        quarter of its time to look for fewer addresses (loop strength reduction), and the code is not faster for it.
        """
        schedule, is_inward = self.schedule, loop % 2 == 0
        begin, end, step = ("%last", "0", -1) if is_inward else ("0", "%last", 1)
        reads = {place: self._read_at(place) for place in schedule.read(loop)}
        writes = list(self._written(loop))
        rows = dict.fromkeys([row for row, _ in reads.values()] + [row for _, row, _ in writes])
        yield f"enter{loop}:"
        for row in rows:
            yield from row.first(loop, begin)
        yield f"  br label %loop{loop}\nloop{loop}:"
        yield f"  %i{loop} = phi i64 [ {begin}, %enter{loop} ], [ %next{loop}, %loop{loop} ]"
        for row in rows:
            at = row.at(loop)
            yield f"  %row_{at} = phi ptr [ %first_{at}, %enter{loop} ], [ %next_{at}, %loop{loop} ]"
        for place, cell in schedule.carried(loop):
            first, following = self._lanes(cell.first, 0, place), self._lanes(cell.next, loop, place)
            yield f"  %v{place} = phi {self._kind(place)} [ {first}, %enter{loop} ], [ {following}, %loop{loop} ]"
        for row in rows:  # an address that LLVM cannot follow, which is what keeps loop strength reduction from it
            yield f"  %{row.at(loop)} = call ptr @llvm.launder.invariant.group.p0(ptr %row_{row.at(loop)})"
        for place, (row, cell) in reads.items():
            yield from load(f"v{place}_{loop}", row.at(loop), str(cell), self._kind(place))
        yield from self._computed((place for place in schedule.needed if schedule.loop.get(place) == loop), loop)
        for i, (place, row, cell) in enumerate(writes):
            yield from store(self._name(place, loop), f"written{loop}_{i}", row.at(loop), str(cell), self._kind(place))
        for row in rows:
            yield f"  %next_{row.at(loop)} = getelementptr double, ptr %row_{row.at(loop)}, i64 {step * row.width}"
        yield f"  %next{loop} = add i64 %i{loop}, {step}"
        yield f"  %done{loop} = icmp eq i64 %i{loop}, {end}"
        yield f"  br i1 %done{loop}, label %{behind}, label %loop{loop}"

    def _read_at(self, place: int) -> tuple["_Row", int]:
        """The row and the cell of what an earlier loop left, a number of the rod, its state or an input."""
        kind, *rest = self.tape.operations[place]
        if place in self._stored:
            return _Row("stored", 0, self._count(self._stored)), self._stored[place]
        if place in self.fixed_of_rod:
            return _Row("numbers", 0, self._count(self.fixed_of_rod)), self.fixed_of_rod[place]
        part, cell = self.tape.operations[rest[0]][1:] if kind in {"sin", "cos"} else rest
        array = {"state": "y", "input": "inputs", "sin": "scratch", "cos": "cosines"}[kind]
        return _Row(array, part, self._width), cell

    def _written(self, loop: int) -> Iterator[tuple[int, "_Row", int]]:
        """The results of the rod that are known in a loop, and what later loops read, with their rows and cells."""
        schedule, places = self.schedule, self.places
        for i, place in enumerate(places.of_rod):
            if schedule.loop_of(place) == loop:
                part, cell = divmod(i, self._width)
                yield place, _Row("dy", part, self._width), cell
        for i, place in enumerate(places.more_of_rod):
            if schedule.loop_of(place) == loop:
                yield place, _Row("further_of_rods", 0, len(places.more_of_rod)), i
        for place, cell in self._stored.items():
            if schedule.loop[place] == loop:
                yield place, _Row("stored", 0, self._count(self._stored)), cell

    # --- operations ---------------------------------------------------------------------------------------------------

    def _computed(self, places: Iterable[int], loop: int = 0) -> Iterator[str]:
        for place in places:
            yield from self._operation(place, loop)

    def _operation(self, place: int, loop: int) -> Iterator[str]:
        name, *operands = self.tape.operations[place]
        if name in {"carried", "last"}:
            return
        if name == "time":
            yield f"  %v{place} = fsub double %t, 0.0"
        elif name == "state":
            yield from load(f"v{place}", "y", str(operands[0]))
        elif name == "input":
            yield from load(f"v{place}", "block", str(self.inputs_at + operands[0]))
        elif name == "row":
            yield from table_row(place, self._name(operands[0], loop), HEADER + TABLE * operands[1], operands[2])
        elif name == "entry":
            yield from load(f"v{place}", f"row{operands[0]}", str(operands[1]))
        elif name == "pack":
            yield from lanes_of(f"v{place}", [self._name(x, loop) for x in operands])
        elif name == "lane":
            lanes, i = operands
            yield f"  %v{place} = extractelement {self._kind(lanes)} {self._name(lanes, loop)}, i32 {i}"
        elif lanes := self.tape.lanes[place]:
            for i, x in enumerate(operands):
                if not self.tape.lanes[x] and self.tape.operations[x][0] != "number":
                    yield from repeated(f"all{i}_{place}", self._name(x, loop), lanes)
            yield from arithmetic(
                f"v{place}", name, [self._lanes(x, loop, place, i) for i, x in enumerate(operands)], lanes
            )
        else:
            yield from arithmetic(f"v{place}", name, [self._name(x, loop) for x in operands])

    def _lanes(self, x: int, loop: int, result: int, i: int = 0) -> str:
        """An operand i of an operation, in as many lanes as its result has."""
        name = self._name(x, loop)
        if (lanes := self.tape.lanes[result]) == self.tape.lanes[x]:
            return name
        if self.tape.operations[x][0] != "number":
            return f"%all{i}_{result}"
        return "<" + ", ".join([f"double {name}"] * lanes) + ">"

    def _name(self, place: int, loop: int = 0) -> str:
        """An operand in a loop, or outside of loops."""
        name, *rest = self.tape.operations[place]
        if name == "number":
            return number(rest[0])
        if name == "last":
            cell = self.tape.passes[rest[0]].cells[rest[1]].next
            return self._name(cell, self.schedule.loop.get(cell, 0))
        if self.tape.by_rod[place] and self.schedule.loop.get(place) != loop:
            return f"%v{place}_{loop}"
        return f"%v{place}"


_REPORTING = f"""
  %block = load ptr, ptr %blocks
  %before = load i64, ptr %block
  %count = add i64 %before, 1
  store i64 %count, ptr %block
  %rods_at = getelementptr i64, ptr %block, i64 {RODS}
  %rods = load i64, ptr %rods_at
  %scratch_at = getelementptr ptr, ptr %block, i64 {SCRATCH}
  %scratch = load ptr, ptr %scratch_at
  %numbers_at = getelementptr ptr, ptr %block, i64 {NUMBERS}
  %numbers = load ptr, ptr %numbers_at
  %part_of_count = and i64 %count, {EVERY - 1}
  %due = icmp eq i64 %part_of_count, 0
  br i1 %due, label %report, label %go
report:                                           ; count the call; every EVERY-th time call the progress callback
  %place = getelementptr ptr, ptr %block, i64 {CALLBACK}
  %callback = load ptr, ptr %place
  %none = icmp eq ptr %callback, null
  br i1 %none, label %go, label %ask
ask:
  %answer = call i32 %callback(double %t)
  %on = icmp eq i32 %answer, 0
  br i1 %on, label %go, label %stop
stop:                                             ; not counted: the next call asks again, and stops too
  store i64 %before, ptr %block
  %state_at = getelementptr i64, ptr %block, i64 {STATE}
  %state = load i64, ptr %state_at
  %bytes = mul i64 %state, 8
  call void @llvm.memset.p0.i64(ptr %dy, i8 -1, i64 %bytes, i1 false)
  ret void
go:"""


# --- in which loop along a chain each operation of a tape is computed, and what one loop leaves for the next ---------


class Schedule:
    """The loop of each operation that some results need.

    Loops have the numbers 1, 2, 3, ...: odd ones go outward, even ones inward. Passes of one direction share a loop as long
    as what they carry can be computed in it. A pass that needs what a later loop knows moves to the next loop of its
    direction, and with it what needs that pass: `_loops_of_passes` repeats this until nothing moves.
    """

    def __init__(self, tape: Tape, results: Sequence[int]) -> None:
        self.tape, self.needed, self._results = tape, tape.needed(results), results
        self._carried = [place for place in self.needed if tape.operations[place][0] == "carried"]
        self._passed_on = [(tape.operations[place][1], self._cell(place).next) for place in self._carried]
        pass_loops = self._loops_of_passes()
        self.loop = self._loops_of_operations(pass_loops)  # place -> its loop
        self.loops = sorted(set(self.loop.values()))
        self.late = set[int]()  # the operations of no rod that are computed after the loops
        for place in self.needed:
            if tape.operations[place][0] == "last" or not self.late.isdisjoint(tape.operands[place]):
                self.late.add(place)
        used = [(x, loop) for place, loop in self.loop.items() for x in tape.operands[place]]
        used += [(place, pass_loops[which]) for which, place in self._passed_on]
        self.stored = sorted({x for x, loop in used if loop > self.loop.get(x, loop)})  # what later loops read

    def carried(self, loop: int) -> list[tuple[int, Cell]]:
        """What the passes of a loop carry: the place of the operation, and the cell."""
        return [(place, self._cell(place)) for place in self._carried if self.loop[place] == loop]

    def read(self, loop: int) -> list[int]:
        """The operations of the rod that a loop reads, as it does not compute them."""
        used = {x for place, at in self.loop.items() if at == loop for x in self.tape.operands[place]}
        used.update(cell.next for _, cell in self.carried(loop))
        used.update(place for place in self._results if self.loop_of(place) == loop)
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

    def _loops_of_passes(self) -> list[int]:
        """The loop of each pass: the first in its direction in which all that it carries can be computed."""
        loops = [2 if one.inward else 1 for one in self.tape.passes]
        while True:
            earliest, before = self._earliest(loops), list(loops)
            for which, place in self._passed_on:
                if (due := earliest.get(place, 0)) > loops[which]:
                    loops[which] = due + (due - loops[which]) % 2
            if loops == before:
                return loops

    def _earliest(self, pass_loops: Sequence[int]) -> dict[int, int]:
        """The first loop in which each operation of a rod can be computed; 0 for any."""
        earliest: dict[int, int] = {}
        for place in self.needed:
            name, *rest = self.tape.operations[place]
            if name == "carried":
                earliest[place] = pass_loops[rest[0]]
            elif self.tape.by_rod[place]:
                earliest[place] = max([earliest.get(x, 0) for x in self.tape.operands[place]], default=0)
        return earliest

    def _loops_of_operations(self, pass_loops: Sequence[int]) -> dict[int, int]:
        """The loop of each operation of a rod but leaves: the first that uses it, unless it needs what a pass carries."""
        earliest, loop = self._earliest(pass_loops), dict[int, int]()
        uses: dict[int, list[int]] = defaultdict(list)  # the loops that use an operation
        for which, place in self._passed_on:
            uses[place].append(pass_loops[which])
        for place in reversed(self.needed):
            is_leaf = self.tape.fixed[place] or self.tape.operations[place][0] in LEAVES or self.is_trigonometric(place)
            if place not in earliest or (is_leaf and not earliest[place]):  # a leaf is read anew in each loop
                continue
            loop[place] = earliest[place] or min(uses[place], default=1)
            for x in self.tape.operands[place]:
                uses[x].append(loop[place])
        return loop
