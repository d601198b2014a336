"""The text of a function in LLVM's intermediate language: what is computed once, loops over the rods, what follows them.

It has the signature of CyRK's right-hand sides, so that it is called from compiled integrators and from Python:
    void rate(double *dy, double t, double *y, void **block, double *more)
`more` takes the further results of a recording; it is null where they are not wanted. The block holds what changes from run
to run (llvm.py). Equations of a chain are loops over its rods: the same code is for any number of rods.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from pendpin.engines.machine import routines
from pendpin.engines.machine.passes import Schedule
from pendpin.engines.machine.tape import Recording

EVERY = 4096  # calls between two of the progress callback; a power of 2
# "contract" lets LLVM round a product and the sum that it enters once instead of twice; a quotient enters no such sum. More
# freedom, as of "fast", would let it change the order of sums too.
_BINARY = {"add": "fadd contract", "sub": "fsub contract", "mul": "fmul contract", "div": "fdiv"}
_COMPARED = {"min": "olt", "max": "ogt"}
_INTRINSIC = ("sqrt", "exp", "log", "sin", "cos", "pow")
_ROW = """
define internal i64 @row(ptr %times, i64 %rows, double %t) noinline {
entry:
  br label %look
look:                                             ; the last of the rows that begins at or before t
  %low = phi i64 [ 0, %entry ], [ %low2, %next ]
  %high = phi i64 [ %rows, %entry ], [ %high2, %next ]
  %gap = sub i64 %high, %low
  %more = icmp sgt i64 %gap, 1
  br i1 %more, label %next, label %done
next:
  %sum = add i64 %low, %high
  %middle = lshr i64 %sum, 1
  %at = getelementptr double, ptr %times, i64 %middle
  %begin = load double, ptr %at
  %later = fcmp ogt double %begin, %t
  %low2 = select i1 %later, i64 %low, i64 %middle
  %high2 = select i1 %later, i64 %middle, i64 %high
  br label %look
done:
  ret i64 %low
}
"""
_REPORTING = f"""
  %block = load ptr, ptr %blocks
  %before = load i64, ptr %block
  %count = add i64 %before, 1
  store i64 %count, ptr %block
  %rods_at = getelementptr i64, ptr %block, i64 {routines.RODS}
  %rods = load i64, ptr %rods_at
  %scratch_at = getelementptr ptr, ptr %block, i64 {routines.SCRATCH}
  %scratch = load ptr, ptr %scratch_at
  %numbers_at = getelementptr ptr, ptr %block, i64 {routines.NUMBERS}
  %numbers = load ptr, ptr %numbers_at
  %part_of_count = and i64 %count, {EVERY - 1}
  %due = icmp eq i64 %part_of_count, 0
  br i1 %due, label %report, label %go
report:                                           ; count the call; every EVERY-th time call the progress callback
  %place = getelementptr ptr, ptr %block, i64 {routines.CALLBACK}
  %callback = load ptr, ptr %place
  %none = icmp eq ptr %callback, null
  br i1 %none, label %go, label %ask
ask:
  %answer = call i32 %callback(double %t)
  %on = icmp eq i32 %answer, 0
  br i1 %on, label %go, label %stop
stop:                                             ; not counted: the next call asks again, and stops too
  store i64 %before, ptr %block
  %state_at = getelementptr i64, ptr %block, i64 {routines.STATE}
  %state = load i64, ptr %state_at
  %bytes = mul i64 %state, 8
  call void @llvm.memset.p0.i64(ptr %dy, i8 -1, i64 %bytes, i1 false)
  ret void
go:"""


class _Row(NamedTuple):
    """The numbers of a rod in an array, or in a part of it."""

    array: str
    part: int
    width: int


class Text:
    """The text of a recording's function."""

    def __init__(self, recording: Recording, tables: int) -> None:
        tape = self.tape = recording.tape
        parts = recording.results, recording.more, recording.of_rod, recording.more_of_rod
        self.others, self.more, self.of_rod, self.more_of_rod = ([tape.placed(x) for x in part] for part in parts)
        everything = self.others + self.more + self.of_rod + self.more_of_rod
        self.schedule = Schedule(tape, everything)
        fixed = tape.fixed_operands(everything)
        self.needed_for_fixed = tape.needed(fixed)
        self.fixed = self._cells_of(x for x in fixed if not tape.by_rod[x])
        self.fixed_of_rod = self._cells_of(x for x in fixed if tape.by_rod[x])
        self._stored = self._cells_of(self.schedule.stored)
        self._inputs_at = routines.HEADER + routines.TABLE * tables + self._count(self.fixed)
        self._width = recording.width
        self._has_trigonometry = any(map(self.schedule.is_trigonometric, self.schedule.needed))
        stored = self._count(self._stored) + len(self.more_of_rod)
        self.scratch_of_rod = 2 * self._width * self._has_trigonometry + stored  # numbers in the scratch memory

    def _cells_of(self, places: Iterable[int]) -> dict[int, int]:
        """The cell in memory of each of some operations, one after the other: several numbers have several cells."""
        cells, end = {}, 0
        for place in places:
            cells[place] = end
            end += self.tape.lanes[place] or 1
        return cells

    def _count(self, places: Iterable[int]) -> int:
        return sum(self.tape.lanes[place] or 1 for place in places)

    def lines(self) -> Iterator[str]:
        """The lines of the text, without their ends."""
        tape, schedule = self.tape, self.schedule
        yield routines.DECLARED
        yield "define void @rate(ptr noalias %dy, double %t, ptr noalias %y, ptr %blocks, ptr noalias %more) {"
        yield _REPORTING
        begin = self._inputs_at - self._count(self.fixed)
        for place, cell in self.fixed.items():
            yield from _load(f"v{place}", "block", str(begin + cell), self._kind(place))
        once = [place for place in schedule.needed if not (tape.by_rod[place] or tape.fixed[place])]
        for place in once:
            if place not in schedule.late:
                yield from self._operation(place)
        if schedule.loops:
            yield from self._loops()
        for place in once:
            if place in schedule.late:
                yield from self._operation(place)
        # the results that are of no rod, behind those of the rods
        yield f"  %of_rods = mul i64 %rods, {len(self.of_rod)}"
        yield "  %others = getelementptr double, ptr %dy, i64 %of_rods"
        for i, place in enumerate(self.others):
            yield from _store(self._name(place), f"other{i}", "others", str(i))
        if self.more:
            yield f"  %more_of_rods = mul i64 %rods, {len(self.more_of_rod)}"
            yield "  %behind = getelementptr double, ptr %more, i64 %more_of_rods"
            yield "  %wanted = icmp ne ptr %more, null"
            yield "  br i1 %wanted, label %further, label %end\nfurther:"
            for i, place in enumerate(self.more):
                yield from _store(self._name(place), f"more{i}", "behind", str(i))
            yield "  br label %end\nend:"
        yield "  ret void\n}"
        if any(tape.operations[place][0] == "row" for place in schedule.needed):
            yield _ROW
        if self._has_trigonometry:
            yield f"declare void @{routines.TRIGONOMETRY}(ptr, i64, ptr, ptr)"

    def _loops(self) -> Iterator[str]:
        """The loops over the rods; further results go to the scratch memory where they are not wanted."""
        yield f"  %part = mul i64 %rods, {self._width}"
        yield "  %last = sub i64 %rods, 1"
        yield f"  %inputs = getelementptr double, ptr %block, i64 {self._inputs_at}"
        yield f"  %in_part = add i64 %part, {routines.WIDE}"
        yield "  %cosines = getelementptr double, ptr %scratch, i64 %in_part"
        yield f"  %angles = mul i64 %in_part, {2 * self._has_trigonometry}"
        yield "  %stored = getelementptr double, ptr %scratch, i64 %angles"
        if self._has_trigonometry:
            yield f"  call void @{routines.TRIGONOMETRY}(ptr %y, i64 %part, ptr %scratch, ptr %cosines)"
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
        """A loop over the rods, outward or inward, and the label of the code behind it."""
        # It carries the address of the rod's row in each array. LLVM does not see that they advance evenly: it would take a
        # quarter of its time to look for fewer addresses (loop strength reduction), and the code is not faster for it.
        schedule, is_inward = self.schedule, loop % 2 == 0
        begin, end, step = ("%last", "0", -1) if is_inward else ("0", "%last", 1)
        reads = {place: self._read_at(place) for place in schedule.read(loop)}
        writes = list(self._written(loop))
        rows = dict.fromkeys([row for row, _ in reads.values()] + [row for _, row, _ in writes])
        names = {row: f"{row.array}{row.part}_{loop}" for row in rows}
        yield f"enter{loop}:"
        for row, at in names.items():
            yield f"  %part_{at} = mul i64 %part, {row.part}"
            yield f"  %rods_{at} = mul i64 {begin}, {row.width}"
            yield f"  %cells_{at} = add i64 %part_{at}, %rods_{at}"
            yield f"  %first_{at} = getelementptr double, ptr %{row.array}, i64 %cells_{at}"
        yield f"  br label %loop{loop}\nloop{loop}:"
        yield f"  %i{loop} = phi i64 [ {begin}, %enter{loop} ], [ %next{loop}, %loop{loop} ]"
        for at in names.values():
            yield f"  %row_{at} = phi ptr [ %first_{at}, %enter{loop} ], [ %next_{at}, %loop{loop} ]"
        for place, cell in schedule.carried(loop):
            first, following = self._lanes(cell.first, 0, place), self._lanes(cell.next, loop, place)
            yield f"  %v{place} = phi {self._kind(place)} [ {first}, %enter{loop} ], [ {following}, %loop{loop} ]"
        for at in names.values():  # an address that LLVM cannot follow, which keeps loop strength reduction from it
            yield f"  %{at} = call ptr @llvm.launder.invariant.group.p0(ptr %row_{at})"
        for place, (row, cell) in reads.items():
            yield from _load(f"v{place}_{loop}", names[row], str(cell), self._kind(place))
        for place in schedule.needed:
            if schedule.loop.get(place) == loop:
                yield from self._operation(place, loop)
        for i, (place, row, cell) in enumerate(writes):
            yield from _store(self._name(place, loop), f"written{loop}_{i}", names[row], str(cell), self._kind(place))
        for row, at in names.items():
            yield f"  %next_{at} = getelementptr double, ptr %{at}, i64 {step * row.width}"
        yield f"  %next{loop} = add i64 %i{loop}, {step}"
        yield f"  %done{loop} = icmp eq i64 %i{loop}, {end}"
        yield f"  br i1 %done{loop}, label %{behind}, label %loop{loop}"

    def _read_at(self, place: int) -> tuple[_Row, int]:
        """The row and the cell of what an earlier loop left, a number of the rod, its state or an input."""
        kind, *rest = self.tape.operations[place]
        if place in self._stored:
            return _Row("stored", 0, self._count(self._stored)), self._stored[place]
        if place in self.fixed_of_rod:
            return _Row("numbers", 0, self._count(self.fixed_of_rod)), self.fixed_of_rod[place]
        part, cell = self.tape.operations[rest[0]][1:] if kind in {"sin", "cos"} else rest
        array = {"state": "y", "input": "inputs", "sin": "scratch", "cos": "cosines"}[kind]
        return _Row(array, part, self._width), cell

    def _written(self, loop: int) -> Iterator[tuple[int, _Row, int]]:
        """The results of the rod that are known in a loop, and what later loops read, with their rows and cells."""
        schedule = self.schedule
        for i, place in enumerate(self.of_rod):
            if schedule.loop_of(place) == loop:
                part, cell = divmod(i, self._width)
                yield place, _Row("dy", part, self._width), cell
        for i, place in enumerate(self.more_of_rod):
            if schedule.loop_of(place) == loop:
                yield place, _Row("further_of_rods", 0, len(self.more_of_rod)), i
        for place, cell in self._stored.items():
            if schedule.loop[place] == loop:
                yield place, _Row("stored", 0, self._count(self._stored)), cell

    def _operation(self, place: int, loop: int = 0) -> Iterator[str]:
        name, *operands = self.tape.operations[place]
        result, lanes = f"%v{place}", self.tape.lanes[place]
        if name in {"carried", "last"}:
            return
        if name == "time":
            yield f"  {result} = fsub double %t, 0.0"
        elif name == "state":
            yield from _load(f"v{place}", "y", str(operands[0]))
        elif name == "input":
            yield from _load(f"v{place}", "block", str(self._inputs_at + operands[0]))
        elif name == "row":
            t, table, width = operands
            for i, (part, kind) in enumerate((("times", "ptr"), ("rows", "ptr"), ("many", "i64"))):
                yield from _load(f"{part}{place}", "block", str(routines.HEADER + routines.TABLE * table + i), kind)
            row = f"call i64 @row(ptr %times{place}, i64 %many{place}, double {self._name(t, loop)})"
            yield f"  %which{place} = {row}"
            yield f"  %first{place} = mul i64 %which{place}, {width}"
            yield f"  %row{place} = getelementptr double, ptr %rows{place}, i64 %first{place}"
        elif name == "entry":
            yield from _load(f"v{place}", f"row{operands[0]}", str(operands[1]))
        elif name == "pack":
            numbers = [self._name(x, loop) for x in operands]
            before = "<" + ", ".join(f"double {x if x.startswith('0x') else '0.0'}" for x in numbers) + ">"
            inserted = [(i, x) for i, x in enumerate(numbers) if not x.startswith("0x")]
            for i, x in inserted:
                after = result if i == inserted[-1][0] else f"%to{i}_v{place}"
                yield f"  {after} = insertelement {self._kind(place)} {before}, double {x}, i32 {i}"
                before = after
        elif name == "lane":
            several, i = operands
            yield f"  {result} = extractelement {self._kind(several)} {self._name(several, loop)}, i32 {i}"
        else:
            for i, x in enumerate(operands):  # one number in all lanes
                if lanes and not self.tape.lanes[x] and self.tape.operations[x][0] != "number":
                    kind, one = self._kind(place), f"%one_all{i}_{place}"
                    yield f"  {one} = insertelement {kind} poison, double {self._name(x, loop)}, i32 0"
                    yield f"  %all{i}_{place} = shufflevector {kind} {one}, {kind} poison, <{lanes} x i32> zeroinitializer"
            yield from self._arithmetic(place, name, [self._lanes(x, loop, place, i) for i, x in enumerate(operands)])

    def _arithmetic(self, place: int, name: str, operands: list[str]) -> Iterator[str]:
        """An operation on numbers. A product in a sum may go without its own rounding, as a fused operation."""
        result, kind, both = f"%v{place}", self._kind(place), ", ".join(operands)
        if name in _BINARY:
            yield f"  {result} = {_BINARY[name]} {kind} {both}"
        elif name == "neg":
            yield f"  {result} = fneg {kind} {both}"
        elif name == "less":
            yield f"  %c_v{place} = fcmp olt double {both}"
            yield f"  {result} = uitofp i1 %c_v{place} to double"
        elif name in _COMPARED:
            yield f"  %c_v{place} = fcmp {_COMPARED[name]} double {both}"
            yield f"  {result} = select i1 %c_v{place}, double {operands[0]}, double {operands[1]}"
        else:
            function = f"llvm.{name}.f64" if name in _INTRINSIC else name
            yield f"  {result} = call double @{function}({', '.join('double ' + x for x in operands)})"

    def _kind(self, place: int) -> str:
        """The type of a number, or of several side by side."""
        lanes = self.tape.lanes[place]
        return f"<{lanes} x double>" if lanes else "double"

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
            return routines.number(rest[0])
        if name == "last":
            cell = self.tape.passes[rest[0]].cells[rest[1]].next
            return self._name(cell, self.schedule.loop.get(cell, 0))
        if self.tape.by_rod[place] and self.schedule.loop.get(place) != loop:
            return f"%v{place}_{loop}"
        return f"%v{place}"


def _load(name: str, array: str, cell: str, kind: str = "double") -> Iterator[str]:
    """A number of an array, or several, by its cell."""
    yield f"  %at_{name} = getelementptr double, ptr %{array}, i64 {cell}"
    yield f"  %{name} = load {kind}, ptr %at_{name}, align 8"


def _store(value: str, name: str, array: str, cell: str, kind: str = "double") -> Iterator[str]:
    """Write a number, or several, to a cell of an array; `name` is that of its address."""
    yield f"  %{name} = getelementptr double, ptr %{array}, i64 {cell}"
    yield f"  store {kind} {value}, ptr %{name}, align 8"
