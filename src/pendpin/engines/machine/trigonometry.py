"""Sines and cosines of many angles as machine code on vectors: a third of the time of one rod, if a library computes them.

The nearest quarter turn k is taken from an angle: r + c = x - k pi/2, with pi/2 in three parts and c what rounding leaves
(W. J. Cody, W. Waite, Software Manual for the Elementary Functions, 1980). Polynomials of r² are within 2e-17 of sine and
cosine up to pi/4, by interpolation at Chebyshev's nodes; results are within one unit in the last place
(tests/test_machine_functions.py). Angles beyond FAR, and NaN, go to the library, four at a time.
"""

from pendpin.engines.machine.lines import VECTOR, WIDE, constant

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

    def lost_in_sum(self, x: str, y: str, total: str) -> str:
        """What a sum loses by rounding, exactly (Knuth)."""
        of_y = self.on("fsub", total, x)
        of_x = self.on("fsub", total, of_y)
        return self.on("fadd", self.on("fsub", x, of_x), self.on("fsub", y, of_y))

    def lost_in_product(self, x: str, y: str, product: str) -> str:
        """What a product loses by rounding, exactly."""
        return self.fused(x, y, self(f"fneg {VECTOR} {product}"))

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
    c = line.on("fadd", line.lost_in_sum(first, rest, r), line.lost_in_product(back, _constant(_REST), rest))
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
