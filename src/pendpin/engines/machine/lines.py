"""Operations of a tape in LLVM's intermediate language, and the sines and cosines of many angles."""

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


# --- sines and cosines of many angles on vectors of the processor -----------------------------------------------------
#
# With the library's sin and cos in their place an evaluation takes 1.36 to 1.39 times as long (4 to 100 rods). The nearest
# quarter turn k is taken from an angle: r + c = x - k pi/2, with pi/2 in three parts and c what rounding leaves (W. J. Cody,
# W. Waite, Software Manual for the Elementary Functions, 1980). Polynomials of r², from Chebyshev's nodes, are
# within 2e-17 of sine and cosine up to pi/4; results within one unit in the last place (tests/test_machine_functions.py).
# Angles beyond FAR, and NaN, go to the library, four at a time.

FAR = 1e5  # rad: up to there the whole number k of quarter turns is exact, and what the parts of pi/2 leave is nothing
TRIGONOMETRY = "pendpin_trigonometry"  # its name among the functions of a process, which compiles it once
_SINE = (  # of r² in (sin r / r - 1) / r²
    *(-1 / 6, 0.008333333333330948, -1.9841269836756774e-4),
    *(2.7557316101617874e-6, -2.505113165023518e-8, 1.5918115263265974e-10),
)
_COSINE = (  # of r² in (cos r - 1 + r²/2) / r⁴
    *(1 / 24, -0.0013888888888887398, 2.480158729876456e-5),
    *(-2.7557317271145144e-7, 2.087614614655861e-9, -1.1382623647474604e-11),
)
_HALF_PI, _REST, _LAST = 1.5707963267948966, 6.123233995736766e-17, -1.4973849048591698e-33
_TO_QUARTERS = 0.6366197723675814  # 2/pi
_ROUNDS = 1.5 * 2.0**52  # added and taken away it leaves a whole number, which is in the last bits of the sum
_WHOLE = f"<{WIDE} x i64>"


def _constant(x: float) -> str:
    return constant([x] * WIDE)


def _whole(x: int) -> str:
    return "<" + ", ".join([f"i64 {x}"] * WIDE) + ">"


class _Lines:
    """Lines of code, each with a new name for its result."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def __call__(self, text: str) -> str:
        name = f"%w{len(self.lines)}"
        self.lines.append(f"  {name} = {text}")
        return name

    def fused(self, x: str, y: str, z: str) -> str:
        """x y + z with one rounding."""
        return self(f"call {VECTOR} @llvm.fma.v{WIDE}f64({VECTOR} {x}, {VECTOR} {y}, {VECTOR} {z})")

    def on(self, operation: str, x: str, y: str) -> str:
        """An operation on two vectors of numbers."""
        return self(f"{operation} {VECTOR} {x}, {y}")

    def polynomial(self, coefficients: tuple[float, ...], z: str) -> str:
        """By Horner's rule."""
        *others, highest = coefficients
        value = _constant(highest)
        for coefficient in reversed(others):
            value = self.fused(value, z, _constant(coefficient))
        return value


def _sine_and_cosine(line: _Lines, x: str) -> tuple[str, str]:
    shifted = line.fused(x, _constant(_TO_QUARTERS), _constant(_ROUNDS))
    back = line.on("fsub", _constant(_ROUNDS), shifted)  # -k
    first = line.fused(back, _constant(_HALF_PI), x)  # exact
    rest = line.on("fmul", back, _constant(_REST))
    r = line.on("fadd", first, rest)
    of_rest = line.on("fsub", r, first)  # what the sum loses by rounding, exactly (Knuth), and what the product loses
    of_first = line.on("fsub", r, of_rest)
    lost = line.on("fadd", line.on("fsub", first, of_first), line.on("fsub", rest, of_rest))
    c = line.on("fadd", lost, line.fused(back, _constant(_REST), line(f"fneg {VECTOR} {rest}")))
    c = line.fused(back, _constant(_LAST), c)
    z = line.on("fmul", r, r)
    cubed = line.on("fmul", z, r)
    half = line.on("fmul", z, _constant(0.5))
    cosine_left = line.on("fsub", _constant(1.0), half)
    # sin(r + c) = r + (r³ S(z) + c cos r), cos(r + c) = 1 - z/2 + (what that rounds + z² C(z) - r c)
    small = line.fused(cubed, line.polynomial(_SINE, z), line.on("fmul", c, cosine_left))
    sine = line.on("fadd", r, small)
    rounding = line.on("fsub", line.on("fsub", _constant(1.0), cosine_left), half)
    turned = line.on("fsub", rounding, line.on("fmul", r, c))
    squared = line.on("fmul", z, z)
    cosine = line.on("fadd", cosine_left, line.fused(squared, line.polynomial(_COSINE, z), turned))
    return _turn_by_quarters(line, shifted, sine, cosine)


def _turn_by_quarters(line: _Lines, shifted: str, sine: str, cosine: str) -> tuple[str, str]:
    """Sine and cosine of the angle from those of what it is beyond its quarter turn."""
    k = line(f"bitcast {VECTOR} {shifted} to {_WHOLE}")
    odd = line(f"and {_WHOLE} {k}, {_whole(1)}")
    exchanged = line(f"icmp ne {_WHOLE} {odd}, {_whole(0)}")
    results = []
    for quarters, one, other in ((k, sine, cosine), (line(f"add {_WHOLE} {k}, {_whole(1)}"), cosine, sine)):
        chosen = line(f"select <{WIDE} x i1> {exchanged}, {VECTOR} {other}, {VECTOR} {one}")
        second = line(f"and {_WHOLE} {quarters}, {_whole(2)}")
        sign = line(f"shl {_WHOLE} {second}, {_whole(62)}")
        as_bits = line(f"bitcast {VECTOR} {chosen} to {_WHOLE}")
        signed = line(f"xor {_WHOLE} {as_bits}, {sign}")
        results.append(line(f"bitcast {_WHOLE} {signed} to {VECTOR}"))
    return results[0], results[1]


def trigonometry_code() -> str:
    """void pendpin_trigonometry(double *x, int64 n, double *sines, double *cosines), n up to the next multiple of WIDE."""
    line = _Lines()
    size = line(f"call {VECTOR} @llvm.fabs.v{WIDE}f64({VECTOR} %x)")
    near = line(f"fcmp ole {VECTOR} {size}, {_constant(FAR)}")
    bits = line(f"bitcast <{WIDE} x i1> {near} to i{WIDE}")
    all_near = line(f"icmp eq i{WIDE} {bits}, -1")
    looking = list(line.lines)
    sine, cosine = _sine_and_cosine(line, "%x")
    computing, calls = line.lines[len(looking) :], _Lines()
    far = {"sin": "undef", "cos": "undef"}
    for i in range(WIDE):
        calls.lines.append(f"  %x{i} = extractelement {VECTOR} %x, i64 {i}")
        for name, before in far.items():
            calls.lines.append(f"  %{name}{i} = call double @llvm.{name}.f64(double %x{i})")
            calls.lines.append(f"  %far_{name}{i} = insertelement {VECTOR} {before}, double %{name}{i}, i64 {i}")
            far[name] = f"%far_{name}{i}"
    text = {"looking": looking, "computing": computing, "calls": calls.lines}
    return _FUNCTION.format(
        name=TRIGONOMETRY, V=VECTOR, wide=WIDE,
        all_near=all_near, sine=sine, cosine=cosine, far_sine=far["sin"], far_cosine=far["cos"],
        **{name: "\n".join(lines) for name, lines in text.items()},
    )  # fmt: skip


_FUNCTION = """
declare {V} @llvm.fma.v{wide}f64({V}, {V}, {V})
declare {V} @llvm.fabs.v{wide}f64({V})

define void @{name}(ptr %angles, i64 %n, ptr %sines, ptr %cosines) {{
entry:
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %after, %done ]
  %from = getelementptr double, ptr %angles, i64 %i
  %x = load {V}, ptr %from, align 8
{looking}
  br i1 {all_near}, label %near, label %far
near:
{computing}
  br label %done
far:
{calls}
  br label %done
done:
  %sine = phi {V} [ {sine}, %near ], [ {far_sine}, %far ]
  %cosine = phi {V} [ {cosine}, %near ], [ {far_cosine}, %far ]
  %to_sines = getelementptr double, ptr %sines, i64 %i
  %to_cosines = getelementptr double, ptr %cosines, i64 %i
  store {V} %sine, ptr %to_sines, align 8
  store {V} %cosine, ptr %to_cosines, align 8
  %after = add i64 %i, {wide}
  %again = icmp slt i64 %after, %n
  br i1 %again, label %next, label %end
end:
  ret void
}}
"""
