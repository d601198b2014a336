"""The dimensions of expressions: powers of kg, m and s, and which terms do not agree."""

from collections.abc import Mapping
from fractions import Fraction

from pendpin.doctor.checking.residuals import Equation
from pendpin.doctor.reading.tree import Node
from pendpin.doctor.systems.base import Spec

Dimension = tuple[float, ...]  # powers of kg, m, s: multiples of 1/2 or 1/4, which floats hold exactly
NONE: Dimension = (0, 0, 0)

WHOLE = {"sqrt": 0.5, "norm": 1, "transpose": 1}  # functions of quantities with a unit


class Disagreement(Exception):
    """Terms of different dimensions are added or set equal; the message names them."""


def dimension(node: Node, definitions: Mapping[str, Node], spec: Spec, depth: int = 0) -> Dimension | None:
    """Powers of kg, m and s; None for what fits anything (0, or a name that is not known). Raises Disagreement."""
    parts = [dimension(child, definitions, spec, depth) for child in node.children]
    match node.kind:
        case "number":
            return NONE if node.value else None
        case "symbol":
            if node.value in definitions and depth < 20:
                return dimension(definitions[node.value], definitions, spec, depth + 1)
            return spec.dimensions.get(node.value)
        case "sum" | "matrix":
            return common(parts)
        case "product":
            total = NONE
            for operator, part in zip(node.value, parts, strict=True):
                if part is None:
                    return None
                total = tuple(a - b if operator == "/" else a + b for a, b in zip(total, part, strict=True))
            return total
        case "power":
            return _times(parts[0], float(node.value))
        case "function" if node.value in WHOLE:
            return _times(parts[0], WHOLE[node.value])
        case "function":
            common([parts[0], NONE])
            return NONE
        case _:
            return None


def _times(of: Dimension | None, factor: float) -> Dimension | None:
    return None if of is None else tuple(factor * power for power in of)


def common(parts: list[Dimension | None]) -> Dimension | None:
    """The dimension that all have. Raises Disagreement."""
    definite = [part for part in parts if part is not None]
    for part in definite:
        if part != definite[0]:
            raise Disagreement(f"{unit(definite[0])} and {unit(part)}")
    return definite[0] if definite else None


def unit(dimension: Dimension) -> str:
    """A dimension as a unit."""
    names: dict[Dimension, str] = {(1, 2, -2): "N m", (1, 1, -2): "N", (0, 0, 0): "a pure number"}
    if (plain := tuple(dimension)) in names:
        return names[plain]
    digits, written = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"), []
    for symbol, power in zip(("kg", "m", "s"), map(Fraction, dimension), strict=True):
        raised = str(power).translate(digits) if power.denominator == 1 else f"^({power})"
        written += [symbol + ("" if power == 1 else raised)] if power else []
    return " ".join(written)


def of_equation(equation: Equation, spec: Spec) -> tuple[Dimension | None, str]:
    """The dimension that all sides have, and in words which do not agree, empty where all do."""
    chosen = {name: Node("symbol", (0, 0), other) for name, other in equation.meanings.items() if name != other}
    try:
        return common([dimension(side, equation.definitions | chosen, spec) for side in equation.sides]), ""
    except Disagreement as disagreement:
        return None, str(disagreement)
