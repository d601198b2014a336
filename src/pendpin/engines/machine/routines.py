"""What machine code calls and is called by, in LLVM's intermediate language: sines and cosines, and loops over calls.

These routines belong to no scene: a process compiles them once (llvm.py).
"""

import struct
from dataclasses import dataclass, field

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
# The first cells of a block, the further arguments of a function (llvm.py): the count of calls, the progress callback, how
# many rods there are, where loops leave numbers for later ones, where the numbers of the rods are, how long states and
# further results are, how many unit vectors there are
CALLS, CALLBACK, RODS, SCRATCH, NUMBERS, STATE, MORE, UNITS = range(8)
HEADER = 8  # how many these are
TABLE = 3  # cells of a table: addresses of its times and its rows, and how many there are


def number(x: float) -> str:
    """A constant, to the bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}"


def _loop(signature: str, count: str, body: str, before: str = "") -> str:
    """A function whose body runs for %i from 0 to a count."""
    return f"""
define {signature} {{
entry:{before}
  %some = icmp sgt i64 {count}, 0
  br i1 %some, label %next, label %done
next:
  %i = phi i64 [ 0, %entry ], [ %after, %next ]{body}
  %after = add i64 %i, 1
  %again = icmp slt i64 %after, {count}
  br i1 %again, label %next, label %done
done:
  ret void
}}
"""


def _sizes(*cells: tuple[str, int]) -> str:
    """Whole numbers of a block, by their names."""
    return "\n  %cells = load ptr, ptr %block" + "".join(
        f"\n  %{name}_at = getelementptr i64, ptr %cells, i64 {cell}\n  %{name} = load i64, ptr %{name}_at"
        for name, cell in cells
    )


_EVALUATION = """
  %row = mul i64 %i, %size
  %row_more = mul i64 %i, %size_more
  %at = getelementptr double, ptr %t, i64 %i
  %time = load double, ptr %at
  %state = getelementptr double, ptr %y, i64 %row
  %rates = getelementptr double, ptr %dy, i64 %row
  %further = getelementptr double, ptr %more, i64 %row_more
  call void %rate(ptr %rates, double %time, ptr %state, ptr %block, ptr %further)"""
# the function at n times t (n,) and states y (n, size): dy (n, size), more (n, further results)
MANY = _loop(
    "void @many(ptr %rate, i64 %n, ptr %t, ptr %y, ptr %block, ptr %dy, ptr %more)",
    "%n",
    _EVALUATION,
    _sizes(("size", STATE), ("size_more", MORE)),
)

# --- steps of rk4: called from Python, step by step, one rod took 13 times as long, 30 rods twice, 300 rods 1.2 times ---

OFF = 1e-14  # of the square of a unit vector: below, it is left as it is, and the divisions' rounding does not add up

_ALONG_BODY = """
  %from = getelementptr double, ptr %y, i64 %i
  %rate = getelementptr double, ptr %k, i64 %i
  %to = getelementptr double, ptr %out, i64 %i
  %value = load double, ptr %from
  %slope = load double, ptr %rate
  %change = fmul double %h, %slope
  %sum = fadd double %value, %change
  store double %sum, ptr %to"""
# out = y + h k
_ALONG = _loop("internal void @along(i64 %size, ptr %out, ptr %y, double %h, ptr %k)", "%size", _ALONG_BODY)
_UNIT_BODY = f"""
  %from = mul i64 %i, 3
  %px = getelementptr double, ptr %y, i64 %from
  %py = getelementptr double, ptr %px, i64 1
  %pz = getelementptr double, ptr %px, i64 2
  %x = load double, ptr %px
  %y1 = load double, ptr %py
  %z = load double, ptr %pz
  %xx = fmul double %x, %x
  %yy = fmul double %y1, %y1
  %zz = fmul double %z, %z
  %xy = fadd double %xx, %yy
  %xyz = fadd double %xy, %zz
  %off = fsub double %xyz, 1.0
  %above = fcmp ogt double %off, {number(OFF)}
  %below = fcmp olt double %off, {number(-OFF)}
  %far = or i1 %above, %below
  %root = call double @llvm.sqrt.f64(double %xyz)
  %length = select i1 %far, double %root, double 1.0
  %ux = fdiv double %x, %length
  %uy = fdiv double %y1, %length
  %uz = fdiv double %z, %length
  store double %ux, ptr %px
  store double %uy, ptr %py
  store double %uz, ptr %pz"""
# each of the first vectors of 3 of a state is made a unit vector
_UNIT = _loop("internal void @unit(i64 %units, ptr %y)", "%units", _UNIT_BODY)
_STEP = """
  %many = sitofp i64 %i to double
  %gone = fmul double %many, %h
  %begin = fadd double %t, %gone
  %middle = fadd double %begin, %half
  %end = fadd double %begin, %h
  call void %rate(ptr %k1, double %begin, ptr %y, ptr %block, ptr null)
  call void @along(i64 %size, ptr %inner, ptr %y, double %half, ptr %k1)
  call void %rate(ptr %k2, double %middle, ptr %inner, ptr %block, ptr null)
  call void @along(i64 %size, ptr %inner, ptr %y, double %half, ptr %k2)
  call void %rate(ptr %k3, double %middle, ptr %inner, ptr %block, ptr null)
  call void @along(i64 %size, ptr %inner, ptr %y, double %h, ptr %k3)
  call void %rate(ptr %k4, double %end, ptr %inner, ptr %block, ptr null)
  call void @along(i64 %size, ptr %k2, ptr %k2, double 1.0, ptr %k3)
  call void @along(i64 %size, ptr %k1, ptr %k1, double 2.0, ptr %k2)
  call void @along(i64 %size, ptr %k1, ptr %k1, double 1.0, ptr %k4)
  call void @along(i64 %size, ptr %y, ptr %y, double %sixth, ptr %k1)
  call void @unit(i64 %units, ptr %y)"""
# y moves on from t by `count` steps of h; k1 has room for 5 states
_STEPS = _loop(
    "void @steps(ptr %rate, ptr %y, double %t, double %h, i64 %count, ptr %block, ptr %k1)",
    "%count",
    _STEP,
    _sizes(("size", STATE), ("units", UNITS))
    + """
  %k2 = getelementptr double, ptr %k1, i64 %size
  %k3 = getelementptr double, ptr %k2, i64 %size
  %k4 = getelementptr double, ptr %k3, i64 %size
  %inner = getelementptr double, ptr %k4, i64 %size
  %half = fmul double %h, 0.5
  %sixth = fdiv double %h, 6.0""",
)
STEPS = DECLARED + _ALONG + _UNIT + _STEPS

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


def _all(x: float | int) -> str:
    """A number in each lane of a vector, whole or not."""
    one = f"i64 {x}" if isinstance(x, int) else f"double {number(x)}"
    return "<" + ", ".join([one] * WIDE) + ">"


@dataclass(eq=False)
class _Lines:
    """Lines of code, each with a new name for its result."""

    lines: list[str] = field(default_factory=list)

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
        value = _all(coefficients[-1])
        for coefficient in reversed(coefficients[:-1]):
            value = self.fused(value, z, _all(coefficient))
        return value

    def sine_and_cosine(self, x: str) -> tuple[str, str]:
        """Of angles up to FAR."""
        fused, on = self.fused, self.on
        shifted = fused(x, _all(_TO_QUARTERS), _all(_ROUNDS))
        back = on("fsub", _all(_ROUNDS), shifted)  # -k
        first = fused(back, _all(_HALF_PI), x)  # exact
        rest = on("fmul", back, _all(_REST))
        r = on("fadd", first, rest)
        of_rest = on("fsub", r, first)  # what the sum loses by rounding, exactly (Knuth), and what the product loses
        of_first = on("fsub", r, of_rest)
        lost = on("fadd", on("fsub", first, of_first), on("fsub", rest, of_rest))
        c = on("fadd", lost, fused(back, _all(_REST), self(f"fneg {VECTOR} {rest}")))
        c = fused(back, _all(_LAST), c)
        z = on("fmul", r, r)
        cubed, half = on("fmul", z, r), on("fmul", z, _all(0.5))
        cosine_left = on("fsub", _all(1.0), half)
        # sin(r + c) = r + (r³ S(z) + c cos r), cos(r + c) = 1 - z/2 + (what that rounds + z² C(z) - r c)
        small = fused(cubed, self.polynomial(_SINE, z), on("fmul", c, cosine_left))
        sine = on("fadd", r, small)
        rounding = on("fsub", on("fsub", _all(1.0), cosine_left), half)
        turned = on("fsub", rounding, on("fmul", r, c))
        cosine = on("fadd", cosine_left, fused(on("fmul", z, z), self.polynomial(_COSINE, z), turned))
        # by an odd number of quarter turns they change places, by two their sign
        k = self(f"bitcast {VECTOR} {shifted} to {_WHOLE}")
        odd = self(f"and {_WHOLE} {k}, {_all(1)}")
        exchanged = self(f"icmp ne {_WHOLE} {odd}, {_all(0)}")
        results = []
        for quarters, one, other in ((k, sine, cosine), (self(f"add {_WHOLE} {k}, {_all(1)}"), cosine, sine)):
            chosen = self(f"select <{WIDE} x i1> {exchanged}, {VECTOR} {other}, {VECTOR} {one}")
            second = self(f"and {_WHOLE} {quarters}, {_all(2)}")
            sign = self(f"shl {_WHOLE} {second}, {_all(62)}")
            signed = self(f"xor {_WHOLE} {self(f'bitcast {VECTOR} {chosen} to {_WHOLE}')}, {sign}")
            results.append(self(f"bitcast {_WHOLE} {signed} to {VECTOR}"))
        return results[0], results[1]


def trigonometry_code() -> str:
    """void pendpin_trigonometry(double *x, int64 n, double *sines, double *cosines), n up to the next multiple of WIDE."""
    line = _Lines()
    size = line(f"call {VECTOR} @llvm.fabs.v{WIDE}f64({VECTOR} %x)")
    near = line(f"fcmp ole {VECTOR} {size}, {_all(FAR)}")
    bits = line(f"bitcast <{WIDE} x i1> {near} to i{WIDE}")
    all_near = line(f"icmp eq i{WIDE} {bits}, -1")
    count = len(line.lines)
    sine, cosine = line.sine_and_cosine("%x")
    calls, far = [], {"sin": "undef", "cos": "undef"}
    for i in range(WIDE):
        calls.append(f"  %x{i} = extractelement {VECTOR} %x, i64 {i}")
        for name, before in far.items():
            calls.append(f"  %{name}{i} = call double @llvm.{name}.f64(double %x{i})")
            calls.append(f"  %far_{name}{i} = insertelement {VECTOR} {before}, double %{name}{i}, i64 {i}")
            far[name] = f"%far_{name}{i}"
    looking, computing, calling = ("\n".join(lines) for lines in (line.lines[:count], line.lines[count:], calls))
    return f"""
declare {VECTOR} @llvm.fma.v{WIDE}f64({VECTOR}, {VECTOR}, {VECTOR})
declare {VECTOR} @llvm.fabs.v{WIDE}f64({VECTOR})

define void @{TRIGONOMETRY}(ptr %angles, i64 %n, ptr %sines, ptr %cosines) {{
entry:
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %after, %done ]
  %from = getelementptr double, ptr %angles, i64 %i
  %x = load {VECTOR}, ptr %from, align 8
{looking}
  br i1 {all_near}, label %near, label %far
near:
{computing}
  br label %done
far:
{calling}
  br label %done
done:
  %sine = phi {VECTOR} [ {sine}, %near ], [ {far["sin"]}, %far ]
  %cosine = phi {VECTOR} [ {cosine}, %near ], [ {far["cos"]}, %far ]
  %to_sines = getelementptr double, ptr %sines, i64 %i
  %to_cosines = getelementptr double, ptr %cosines, i64 %i
  store {VECTOR} %sine, ptr %to_sines, align 8
  store {VECTOR} %cosine, ptr %to_cosines, align 8
  %after = add i64 %i, {WIDE}
  %again = icmp slt i64 %after, %n
  br i1 %again, label %next, label %end
end:
  ret void
}}
"""
