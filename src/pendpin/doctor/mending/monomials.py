"""Values at random states read back as a small fraction times a product of powers."""

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from typing import NamedTuple

import numpy as np

from pendpin.doctor.systems.base import Quantities, Values

MOST = 60  # of the numerator and denominator of a fraction that counts as small
CLOSE = 1e-8
MOST_POWER = 4


class Monomial(NamedTuple):
    """A fraction times powers of atoms: names of quantities, "sin phi" and the like, and differences "I1 - I3"."""

    factor: Fraction
    powers: tuple[tuple[str, int], ...] = ()

    @property
    def size(self) -> int:
        """How much there is to write."""
        return sum(abs(power) for _, power in self.powers)


def atom(name: str, quantities: Quantities) -> Values:
    """The values of an atom; the angle of a sine may be a sum or difference of two."""
    for sign, mark in ((-1, "-"), (1, "+")):
        head, found, second = name.partition(mark)
        function, _, first = head.strip().rpartition(" ")
        if found and not function:
            return quantities[first] + sign * quantities[second.strip()]
        if found:
            return getattr(quantities.xp, function)(quantities[first] + sign * quantities[second])
    function, _, angle = name.rpartition(" ")
    return getattr(quantities.xp, function)(quantities[angle]) if function else quantities[angle]


def fraction_of(values: Values) -> Fraction | None:
    """The small fraction that all values are within rounding of, or None."""
    first = float(values[0])
    if not np.isfinite(values).all() or np.ptp(values) > CLOSE * max(abs(first), 1e-12) or not abs(first) < MOST:
        return None
    found = Fraction(float(np.mean(values))).limit_denominator(MOST)
    small = 0 < abs(found.numerator) <= MOST
    return found if small and abs(float(found) - first) < CLOSE * abs(first) else None


class Reader:
    """Reads values at the states of some quantities back as monomials."""

    def __init__(self, quantities: Quantities) -> None:
        spec = quantities.spec
        self.quantities = quantities
        plain = (name for name in spec.parameters if name != "r" or "h" not in spec.parameters)
        self.names = tuple(name for name in (*plain, *spec.moving) if name not in spec.values)
        self.atoms = np.array([atom(name, quantities) for name in self.names])
        logs = np.log(np.abs(self.atoms)).T
        self._inverse = np.linalg.pinv(np.column_stack([logs, np.ones(len(logs))]))
        extra = {name: atom(name, quantities) for name in spec.extra if name not in self.names}
        self.extra = {name: values for name, values in extra.items() if np.abs(values).min() > 0}

    def plain(self, values: Values) -> Monomial | None:
        """A monomial in parameters, rates, sines and cosines: a straight line through the logarithms gives the powers."""
        with np.errstate(all="ignore"):
            powers = self._inverse @ np.log(np.abs(values))
        whole = np.round(powers[:-1])
        close = np.isfinite(powers).all() and np.abs(powers[:-1] - whole).max(initial=0) < 1e-5
        if not close or np.abs(whole).max(initial=0) > MOST_POWER:
            return None
        factor = fraction_of(values / np.prod(self.atoms ** whole[:, None], axis=0))
        powers = tuple((name, int(power)) for name, power in zip(self.names, whole, strict=True) if power)
        return Monomial(factor, powers) if factor else None

    def read(self, values: Values, extras: dict[str, tuple[int, ...]]) -> Iterator[Monomial]:
        """Every monomial that fits: in plain atoms, or with one more quantity to one of the powers that it may have."""
        if not np.isfinite(values).all() or np.abs(values).min() == 0:
            return
        if found := self.plain(values):
            yield found
        for name in extras.keys() & self.extra.keys():
            for power in extras[name]:
                if found := self.plain(values / self.extra[name] ** power):
                    yield Monomial(found.factor, (*found.powers, (name, power)))


@cache
def reader_of(quantities: Quantities) -> Reader:
    """The reader for some quantities."""
    return Reader(quantities)


_USUAL = {0.0: (1,), 0.02: (2,), 0.03: (3, 4, 6, 12), 0.08: (8, 24), 0.12: (5, 9, 10), 0.14: (7,)}
_ODD = {number: cost for cost, numbers in _USUAL.items() for number in numbers}


def oddness(factor: Fraction) -> float:
    """How odd a fraction is: 0 for 1, small for halves, thirds and twelfths, larger for others."""
    return sum(_ODD.get(abs(part), 0.2) for part in (factor.numerator, factor.denominator))
