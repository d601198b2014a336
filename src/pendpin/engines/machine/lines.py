"""Single operations of a tape in LLVM's intermediate language."""

import struct
from collections.abc import Iterable, Iterator, Sequence

WIDE = 4  # numbers in a vector of the processor
VECTOR = f"<{WIDE} x double>"
DECLARED = """
declare double @llvm.sqrt.f64(double)
declare double @llvm.exp.f64(double)
declare double @llvm.log.f64(double)
declare double @llvm.sin.f64(double)
declare double @llvm.cos.f64(double)
declare double @llvm.pow.f64(double, double)
declare double @tan(double)
declare double @tanh(double)
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)
declare ptr @llvm.launder.invariant.group.p0(ptr)
"""
ROW = """
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
# "contract" lets LLVM round a product and the sum that it enters once instead of twice; a quotient enters no such sum. More
# freedom, as of "fast", would let it change the order of sums too.
_BINARY = {"add": "fadd contract", "sub": "fsub contract", "mul": "fmul contract", "div": "fdiv"}
_COMPARED = {"min": "olt", "max": "ogt"}
_INTRINSIC = ("sqrt", "exp", "log", "sin", "cos", "pow")


def number(x: float) -> str:
    """A constant, to the bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}"


def constant(numbers: Iterable[float]) -> str:
    """Constants side by side."""
    return "<" + ", ".join(f"double {number(x)}" for x in numbers) + ">"


def kind_of(lanes: int) -> str:
    """The type of a number, or of several side by side."""
    return f"<{lanes} x double>" if lanes else "double"


def load(name: str, array: str, cell: str, kind: str = "double") -> Iterator[str]:
    """A number of an array, or several, by its cell."""
    yield f"  %at_{name} = getelementptr double, ptr %{array}, i64 {cell}"
    yield f"  %{name} = load {kind}, ptr %at_{name}, align 8"


def store(value: str, name: str, array: str, cell: str, kind: str = "double") -> Iterator[str]:
    """Write a number, or several, to a cell of an array; `name` is that of its address."""
    yield f"  %{name} = getelementptr double, ptr %{array}, i64 {cell}"
    yield f"  store {kind} {value}, ptr %{name}, align 8"


def lanes_of(result: str, numbers: Sequence[str]) -> Iterator[str]:
    """Several numbers side by side."""
    kind = kind_of(len(numbers))
    before = "<" + ", ".join(f"double {x if x.startswith('0x') else '0.0'}" for x in numbers) + ">"
    inserted = [(i, x) for i, x in enumerate(numbers) if not x.startswith("0x")]
    for i, x in inserted:
        after = result if i == inserted[-1][0] else f"to{i}_{result}"
        yield f"  %{after} = insertelement {kind} {before}, double {x}, i32 {i}"
        before = f"%{after}"


def repeated(result: str, number: str, lanes: int) -> Iterator[str]:
    """One number in all lanes."""
    kind = kind_of(lanes)
    yield f"  %one_{result} = insertelement {kind} poison, double {number}, i32 0"
    yield f"  %{result} = shufflevector {kind} %one_{result}, {kind} poison, <{lanes} x i32> zeroinitializer"


def arithmetic(result: str, name: str, operands: Sequence[str], lanes: int = 0) -> Iterator[str]:
    """An operation on numbers. A product in a sum may go without its own rounding, as a fused operation."""
    both = ", ".join(operands)
    if name in _BINARY:
        yield f"  %{result} = {_BINARY[name]} {kind_of(lanes)} {both}"
    elif name == "neg":
        yield f"  %{result} = fneg {kind_of(lanes)} {both}"
    elif name == "less":
        yield f"  %c_{result} = fcmp olt double {both}"
        yield f"  %{result} = uitofp i1 %c_{result} to double"
    elif name in _COMPARED:
        yield f"  %c_{result} = fcmp {_COMPARED[name]} double {both}"
        yield f"  %{result} = select i1 %c_{result}, double {operands[0]}, double {operands[1]}"
    else:
        function = f"llvm.{name}.f64" if name in _INTRINSIC else name
        yield f"  %{result} = call double @{function}({', '.join('double ' + x for x in operands)})"


def table_row(place: int, t: str, cell: int, width: int) -> Iterator[str]:
    """The address %row of the row of a table that holds at a time; `cell` of the block is the first of the table's."""
    yield from load(f"times{place}", "block", str(cell), "ptr")
    yield from load(f"rows{place}", "block", str(cell + 1), "ptr")
    yield from load(f"many{place}", "block", str(cell + 2), "i64")
    yield f"  %which{place} = call i64 @row(ptr %times{place}, i64 %many{place}, double {t})"
    yield f"  %first{place} = mul i64 %which{place}, {width}"
    yield f"  %row{place} = getelementptr double, ptr %rows{place}, i64 %first{place}"
