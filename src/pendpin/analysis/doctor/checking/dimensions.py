"""The dimensions of expressions: powers of kg, m and s, and which terms do not agree."""

from fractions import Fraction

from pendpin.analysis.doctor.reading.names import DIMENSION_OF
from pendpin.analysis.doctor.reading.tree import Node

Dimension = tuple[Fraction, Fraction, Fraction]
NONE: Dimension = (Fraction(0), Fraction(0), Fraction(0))


class Disagreement(Exception):
    """Terms of different dimensions are added or set equal; the message names them."""


def dimension(node: Node, definitions: dict[str, Node], depth: int = 0) -> Dimension | None:
    """Powers of kg, m and s; None for what fits anything (0, or a name that is not known). Raises Disagreement."""
    parts = [dimension(child, definitions, depth) for child in node.children]
    match node.kind:
        case "number":
            return NONE if node.value else None
        case "symbol":
            name = str(node.value)
            if name in definitions and depth < 20:
                return dimension(definitions[name], definitions, depth + 1)
            found = DIMENSION_OF.get(name)
            return None if found is None else (Fraction(found[0]), Fraction(found[1]), Fraction(found[2]))
        case "sum" | "matrix":
            return common(parts)
        case "product":
            if None in parts:
                return None
            signs = [-1 if operator == "/" else 1 for operator in node.value]  # type: ignore[attr-defined]
            return tuple(sum((s * p[i] for s, p in zip(signs, parts, strict=True)), Fraction(0)) for i in range(3))  # type: ignore[index, return-value]
        case "power":
            return None if parts[0] is None else tuple(Fraction(str(node.value)) * p for p in parts[0])  # type: ignore[return-value]
        case "function" if node.value != "sqrt":
            common([parts[0], NONE])
            return NONE
        case "function":
            return None if parts[0] is None else tuple(p / 2 for p in parts[0])  # type: ignore[return-value]
        case _:
            return None


def common(parts: list[Dimension | None]) -> Dimension | None:
    """The dimension that all have. Raises Disagreement."""
    known = [part for part in parts if part is not None]
    for part in known:
        if part != known[0]:
            raise Disagreement(f"{unit(known[0])} and {unit(part)}")
    return known[0] if known else None


def unit(dimension: Dimension) -> str:
    """A dimension as a unit."""
    names = {(1, 2, -2): "N m", (1, 1, -2): "N", (1, 2, 0): "kg m²", (0, 0, 0): "a pure number"}
    plain = (int(dimension[0]), int(dimension[1]), int(dimension[2]))
    if plain in names and plain == dimension:
        return names[plain]
    parts = (f"{symbol}{_raised(power)}" for symbol, power in zip(("kg", "m", "s"), dimension, strict=True) if power)
    return " ".join(parts)


def _raised(power: Fraction) -> str:
    digits = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
    return "" if power == 1 else str(power).translate(digits) if power.denominator == 1 else f"^({power})"
