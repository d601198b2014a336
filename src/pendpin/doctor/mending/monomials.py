"""Values at random states read back as a small fraction times a product of powers, and such products printed."""

import re
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from typing import NamedTuple

import numpy as np

from pendpin.doctor.systems.base import Quantities, Spec, Values

MOST = 60  # of the numerator and denominator of a fraction that counts as small
CLOSE = 1e-8


class Monomial(NamedTuple):
    """A fraction times powers of atoms: names of quantities, and "sin phi" and the like."""

    factor: Fraction
    powers: tuple[tuple[str, int], ...]

    @property
    def size(self) -> int:
        """How much there is to write."""
        return sum(abs(power) for _, power in self.powers)


def atom(name: str, quantities: Quantities) -> Values:
    """The values of an atom."""
    if " - " in name:
        first, _, second = name.partition(" - ")
        return quantities[first] - quantities[second]
    if terms := quantities.spec.sums.get(name):
        return sum((_term(term, quantities) for term in terms), start=np.zeros(1))
    function, _, angle = name.rpartition(" ")
    return quantities[angle] if not function else getattr(quantities.xp, function)(_angle(angle, quantities))


def _angle(name: str, quantities: Quantities) -> Values:
    """An angle, or the sum or difference of two."""
    for sign, mark in ((1, "+"), (-1, "-")):
        first, found, second = name.partition(mark)
        if found:
            return quantities[first] + sign * quantities[second]
    return quantities[name]


def _term(names: tuple[str, ...], quantities: Quantities) -> Values:
    """A product of atoms; -2 is a number."""
    minus_two = np.full(quantities.shape, -2.0)
    return np.prod([minus_two if name == "-2" else atom(name, quantities) for name in names], axis=0)


def fraction_of(values: Values) -> Fraction | None:
    """The small fraction that all values are equal to, or None."""
    first = float(values[0])
    if not np.isfinite(values).all() or np.ptp(values) > CLOSE * max(abs(first), 1e-12):
        return None
    return small_fraction(float(np.mean(values)))


def small_fraction(value: float) -> Fraction | None:
    """A small fraction within rounding of a number, or None."""
    if abs(value) < CLOSE:
        return Fraction(0)
    if not abs(value) < MOST:
        return None
    found = Fraction(value).limit_denominator(MOST)
    small = 0 < abs(found.numerator) <= MOST
    return found if small and abs(float(found) - value) < CLOSE * abs(value) else None


class Reader:
    """Reads values at the states of some quantities back as monomials."""

    def __init__(self, quantities: Quantities) -> None:
        self.quantities = quantities
        spec = quantities.spec
        plain = tuple(name for name in spec.parameters if name != "r" or "h" not in spec.parameters)
        self.names = tuple(name for name in (*plain, *spec.moving) if name not in spec.values)
        self.atoms = np.array([atom(name, quantities) for name in self.names])
        logs = np.log(np.abs(self.atoms)).T
        self._inverse = np.linalg.pinv(np.column_stack([logs, np.ones(len(logs))]))
        extra = {name: atom(name, quantities) for name in (*spec.extra, *spec.sums) if name not in self.names}
        self.extra = {name: values for name, values in extra.items() if np.abs(values).min() > 0}

    def plain(self, values: Values) -> Monomial | None:
        """A monomial in parameters, rates, sines and cosines."""
        with np.errstate(all="ignore"):
            powers = self._inverse @ np.log(np.abs(values))
        whole = np.round(powers[:-1])
        if not np.isfinite(powers).all() or np.abs(powers[:-1] - whole).max() > 1e-5 or np.abs(whole).max() > 4:
            return None
        product = np.prod(self.atoms ** whole[:, None], axis=0)
        factor = fraction_of(values / product)
        if not factor:
            return None
        return Monomial(factor, tuple((n, int(p)) for n, p in zip(self.names, whole, strict=True) if p))

    def all(self, values: Values) -> Iterator[Monomial]:
        """Every monomial that fits: in plain atoms, or with one more quantity, its square or inverse."""
        if not np.isfinite(values).all() or np.abs(values).min() == 0:
            return
        if found := self.plain(values):
            yield found
        for name, extra in self.extra.items():
            for power in (1, 2, -1):
                if found := self.plain(values / extra**power):
                    yield Monomial(found.factor, (*found.powers, (name, power)))


@cache
def reader_of(quantities: Quantities) -> Reader:
    """The reader for some quantities."""
    return Reader(quantities)


class Printer:
    """Writes numbers, symbols and monomials as a text does. `styles` gives names as the text prints them."""

    def __init__(self, latex: bool, styles: dict[str, str], spec: Spec) -> None:
        self.latex, self.styles, self.spec = latex, styles, spec

    def symbol(self, name: str) -> str:
        """A quantity, a function of an angle, or the quantity's own name."""
        if " - " in name:
            first, _, second = name.partition(" - ")
            return f"({self.symbol(first)} - {self.symbol(second)})"
        if name in self.spec.sums:
            return self.sum(name)
        function, _, angle = name.rpartition(" ")
        if function:
            shown = re.sub(r"[^-+]+", lambda match: self.symbol(match[0]), angle)
            return ("\\" if self.latex else "") + f"{function}({shown})"
        return self.styles.get(name) or (self.spec.printed.get(name, name) if self.latex else name)

    def sum(self, name: str) -> str:
        """One of the sums that are found often, in brackets."""
        parts = []
        for term in self.spec.sums[name]:
            factors = [factor for factor in term if factor != "-2"]
            powers = tuple((factor, factors.count(factor)) for factor in dict.fromkeys(factors))
            text = self.monomial(Monomial(Fraction(2 if "-2" in term else 1), powers))
            parts.append((" - " if "-2" in term else " + ") + text)
        return f"({''.join(parts).removeprefix(' + ')})"

    def number(self, value: Fraction) -> str:
        """A whole number or a fraction."""
        if value.denominator == 1:
            return str(value)
        sign, above = "-" if value < 0 else "", abs(value.numerator)
        return rf"{sign}\frac{{{above}}}{{{value.denominator}}}" if self.latex else str(value)

    def power(self, text: str, power: int) -> str:
        """Something raised; a function's exponent stands before its bracket in LaTeX."""
        if power == 1:
            return text
        if not self.latex:
            return f"{text}**{power}"
        name, bracket, rest = text.partition("(")
        of_function = bracket and name[:4] in ("\\sin", "\\cos", "\\tan")
        return f"{name}^{power}{bracket}{rest}" if of_function else f"{text}^{power}"

    def product(self, factors: list[str]) -> str:
        """Factors side by side."""
        return (" " if self.latex else "*").join(factors)

    def monomial(self, monomial: Monomial, last: str = "") -> str:
        """A product without its sign; `last` is a unit vector that follows."""
        top = [self.power(self.symbol(name), power) for name, power in monomial.powers if power > 0]
        bottom = [self.power(self.symbol(name), -power) for name, power in monomial.powers if power < 0]
        factor = abs(monomial.factor)
        above = ([str(factor.numerator)] if factor.numerator != 1 or not top else []) + top
        below = ([str(factor.denominator)] if factor.denominator != 1 else []) + bottom
        text = self.product(above)
        if below and self.latex:
            text = rf"\frac{{{text}}}{{{self.product(below)}}}"
        elif below:
            text += "/" + (below[0] if len(below) == 1 else f"({self.product(below)})")
        if text == "1" and last:
            return last
        return self.product([text, last]) if last else text


def simple(factor: Fraction) -> float:
    """How odd a fraction is: 0 for 1, small for halves, thirds and twelfths, larger for others."""
    return sum(_ODD.get(abs(part), 0.2) for part in (factor.numerator, factor.denominator))


_USUAL = {0.0: (1,), 0.02: (2,), 0.03: (3, 4, 6, 12), 0.08: (8, 24), 0.12: (5, 9, 10), 0.14: (7,)}
_ODD = {number: cost for cost, numbers in _USUAL.items() for number in numbers}
