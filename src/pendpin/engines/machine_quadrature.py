"""Weighted sums of sqrt(A + B x + C x²), or of 1 over it, over constant points x, as machine code on vectors."""

from collections.abc import Iterator, Sequence

import numpy as np

from pendpin.engines.machine_lines import VECTOR, WIDE, constant
from pendpin.ground.arrays import Array

DECLARED = f"declare {VECTOR} @llvm.sqrt.v{WIDE}f64({VECTOR})"


def quadrature_code(name: str, points: Sequence[float], weights: Sequence[Sequence[float]], inverse: bool) -> str:
    """The function void name(A, B, C, out): sums over the points (p,) with weights (k, p), out (k,).

    `inverse`: of the weights over the roots, 0 where a root is 0.
    """
    missing = -len(points) % WIDE
    x, W = np.pad(points, (0, missing)), np.pad(weights, ((0, 0), (0, missing)))
    return "\n".join(_lines(name, x.reshape(-1, WIDE), W.reshape(len(W), -1, WIDE), inverse))


def _lines(name: str, points: Array, weights: Array, inverse: bool) -> Iterator[str]:
    """Points (groups, wide), weights (k, groups, wide)."""
    yield f"\ndefine internal void @{name}(double %A, double %B, double %C, ptr %out) noinline {{"
    for x in "ABC":
        yield f"  %{x}1 = insertelement {VECTOR} undef, double %{x}, i64 0"
        yield f"  %{x}s = shufflevector {VECTOR} %{x}1, {VECTOR} undef, <{WIDE} x i32> zeroinitializer"
    for i, x in enumerate(points):
        yield f"  %c{i} = fmul {VECTOR} %Cs, {constant(x)}"
        yield f"  %b{i} = fadd {VECTOR} %Bs, %c{i}"
        yield f"  %x{i} = fmul {VECTOR} %b{i}, {constant(x)}"
        yield f"  %a{i} = fadd {VECTOR} %As, %x{i}"
        yield f"  %{'positive' if inverse else 'root'}{i} = call {VECTOR} @llvm.sqrt.v{WIDE}f64({VECTOR} %a{i})"
        if inverse:
            yield f"  %over{i} = fdiv {VECTOR} {constant(np.ones(WIDE))}, %positive{i}"
            yield f"  %some{i} = fcmp ogt {VECTOR} %positive{i}, zeroinitializer"
            yield f"  %root{i} = select <{WIDE} x i1> %some{i}, {VECTOR} %over{i}, {VECTOR} zeroinitializer"
    for k, of_groups in enumerate(weights):
        yield from _sum(k, of_groups)
    yield "  ret void\n}"


def _sum(k: int, weights: Array) -> Iterator[str]:
    """The sum with weights (groups, wide), stored as number k."""
    for i, w in enumerate(weights):
        yield f"  %p{k}_{i} = fmul {VECTOR} %root{i}, {constant(w)}"
        before = f"%s{k}_{i - 1}" if i > 1 else f"%p{k}_0"
        if i:
            yield f"  %s{k}_{i} = fadd {VECTOR} {before}, %p{k}_{i}"
    last = f"%s{k}_{len(weights) - 1}" if len(weights) > 1 else f"%p{k}_0"
    for i in range(WIDE):
        yield f"  %e{k}_{i} = extractelement {VECTOR} {last}, i64 {i}"
    yield f"  %f{k} = fadd double %e{k}_0, %e{k}_1"
    yield f"  %g{k} = fadd double %e{k}_2, %e{k}_3"
    yield f"  %h{k} = fadd double %f{k}, %g{k}"
    yield f"  %at{k} = getelementptr double, ptr %out, i64 {k}"
    yield f"  store double %h{k}, ptr %at{k}"
