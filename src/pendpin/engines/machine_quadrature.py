"""Weighted sums of sqrt(A + B x + C x²), or of 1 over it, over constant points x, as machine code on vectors."""

from collections.abc import Iterator, Sequence

import numpy as np

from pendpin.arrays import Array

_WIDE = 4  # numbers in a vector of the processor
_VECTOR = f"<{_WIDE} x double>"
DECLARED = f"declare {_VECTOR} @llvm.sqrt.v{_WIDE}f64({_VECTOR})"


def quadrature_code(name: str, points: Sequence[float], weights: Sequence[Sequence[float]], inverse: bool) -> str:
    """The function void name(A, B, C, out): sums over the points (p,) with weights (k, p), out (k,).

    `inverse`: of the weights over the roots, 0 where a root is 0.
    """
    missing = -len(points) % _WIDE
    x, W = np.pad(points, (0, missing)), np.pad(weights, ((0, 0), (0, missing)))
    return "\n".join(_written(name, x.reshape(-1, _WIDE), W.reshape(len(W), -1, _WIDE), inverse))


def _written(name: str, points: Array, weights: Array, inverse: bool) -> Iterator[str]:
    """Points (groups, wide), weights (k, groups, wide)."""
    yield f"\ndefine internal void @{name}(double %A, double %B, double %C, ptr %out) noinline {{"
    for x in "ABC":
        yield f"  %{x}1 = insertelement {_VECTOR} undef, double %{x}, i64 0"
        yield f"  %{x}s = shufflevector {_VECTOR} %{x}1, {_VECTOR} undef, <{_WIDE} x i32> zeroinitializer"
    for i, x in enumerate(points):
        yield f"  %c{i} = fmul {_VECTOR} %Cs, {_constant(x)}"
        yield f"  %b{i} = fadd {_VECTOR} %Bs, %c{i}"
        yield f"  %x{i} = fmul {_VECTOR} %b{i}, {_constant(x)}"
        yield f"  %a{i} = fadd {_VECTOR} %As, %x{i}"
        yield f"  %{'positive' if inverse else 'root'}{i} = call {_VECTOR} @llvm.sqrt.v{_WIDE}f64({_VECTOR} %a{i})"
        if inverse:
            yield f"  %over{i} = fdiv {_VECTOR} {_constant(np.ones(_WIDE))}, %positive{i}"
            yield f"  %some{i} = fcmp ogt {_VECTOR} %positive{i}, zeroinitializer"
            yield f"  %root{i} = select <{_WIDE} x i1> %some{i}, {_VECTOR} %over{i}, {_VECTOR} zeroinitializer"
    for k, of_groups in enumerate(weights):
        yield from _sum(k, of_groups)
    yield "  ret void\n}"


def _sum(k: int, weights: Array) -> Iterator[str]:
    """The sum with weights (groups, wide), stored as number k."""
    for i, w in enumerate(weights):
        yield f"  %p{k}_{i} = fmul {_VECTOR} %root{i}, {_constant(w)}"
        before = f"%s{k}_{i - 1}" if i > 1 else f"%p{k}_0"
        if i:
            yield f"  %s{k}_{i} = fadd {_VECTOR} {before}, %p{k}_{i}"
    last = f"%s{k}_{len(weights) - 1}" if len(weights) > 1 else f"%p{k}_0"
    for i in range(_WIDE):
        yield f"  %e{k}_{i} = extractelement {_VECTOR} {last}, i64 {i}"
    yield f"  %f{k} = fadd double %e{k}_0, %e{k}_1"
    yield f"  %g{k} = fadd double %e{k}_2, %e{k}_3"
    yield f"  %h{k} = fadd double %f{k}, %g{k}"
    yield f"  %at{k} = getelementptr double, ptr %out, i64 {k}"
    yield f"  store double %h{k}, ptr %at{k}"


def _constant(x: Array) -> str:
    """A vector (wide,) of numbers."""
    return "<" + ", ".join(f"double 0x{int(bits):016X}" for bits in x.astype(np.float64).view(np.uint64)) + ">"
