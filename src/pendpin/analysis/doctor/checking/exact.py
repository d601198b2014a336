"""Exact arithmetic for proofs: fractions of polynomials in sines, cosines, rates and parameters.

Two expressions are equal if the numerator of their difference reduces to 0 by sin² = 1 - cos². sympy's polynomial rings
do the algebra; `symbolic` gives the same interface over sympy's expressions, for printing and derivatives.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from pendpin.analysis.doctor.checking.mechanics import COORDINATES, PARAMETERS, Pendulum, Quantities
from pendpin.analysis.doctor.reading.names import UNKNOWNS
from pendpin.late import optional

ANGLES = ("theta", "phi")
NAMES = ("dtheta", "dphi", "ddtheta", "ddphi", "m", "l", "g", "h", "r", "I1", "I2", "I3", "R1", "R2", "R3", "M3", "pi")
MOST_TERMS = 4_000  # of a polynomial; beyond that 50 digits decide


class Unprovable(Exception):
    """An expression that is no fraction of polynomials, or too long for one."""


def need_sympy() -> Any:
    """sympy. Raises MissingLibrary where it is not installed."""
    return optional("sympy", "the equation doctor", "'pendpin[doctor]'")


@cache
def _ring() -> tuple[Any, dict[str, Any]]:
    """The ring of polynomials and its generators by name; st, ct, sp, cp are the sines and cosines of the angles."""
    sympy = need_sympy()
    names = ("st", "ct", "sp", "cp", *ANGLES, *NAMES)
    domain, *generators = sympy.ring(names, sympy.QQ)
    return domain, dict(zip(names, generators, strict=True))


class Quotient:
    """A fraction of two polynomials, with the arithmetic of a number."""

    __slots__ = ("den", "num")

    def __init__(self, num: Any, den: Any) -> None:
        if len(num) > MOST_TERMS or len(den) > MOST_TERMS:
            raise Unprovable
        self.num, self.den = num, den

    def __add__(self, other: Any) -> "Quotient":
        """Sum."""
        other = _quotient(other)
        if self.den == other.den:
            return Quotient(self.num + other.num, self.den)
        return Quotient(
            _times(self.num, other.den) + _times(other.num, self.den), _times(self.den, other.den)
        ).lowered()

    def __mul__(self, other: Any) -> "Quotient":
        """Product."""
        other = _quotient(other)
        return Quotient(_times(self.num, other.num), _times(self.den, other.den)).lowered()

    def __truediv__(self, other: Any) -> "Quotient":
        """Quotient. Raises Unprovable for a division by 0."""
        other = _quotient(other)
        if not _reduced(other.num):
            raise Unprovable
        return Quotient(_times(self.num, other.den), _times(self.den, other.num)).lowered()

    def __neg__(self) -> "Quotient":
        """Opposite."""
        return Quotient(-self.num, self.den)

    def __sub__(self, other: Any) -> "Quotient":
        """Difference."""
        return self + -_quotient(other)

    def __rsub__(self, other: Any) -> "Quotient":
        """Difference."""
        return _quotient(other) + -self

    def __rtruediv__(self, other: Any) -> "Quotient":
        """Quotient."""
        return _quotient(other) / self

    def __pow__(self, exponent: int) -> "Quotient":
        """Whole powers."""
        value = _quotient(1)
        for _ in range(abs(exponent)):
            value = value * self
        return value if exponent >= 0 else _quotient(1) / value

    __radd__, __rmul__ = __add__, __mul__

    def lowered(self) -> "Quotient":
        """Without the monomial that numerator and denominator share."""
        if not self.num:
            return Quotient(self.num, self.den.ring.one)
        above, below = self.num.tail_degrees(), self.den.tail_degrees()
        shared = tuple(map(min, above, below))
        if not any(shared):
            return self
        monomial = self.den.ring({shared: 1})
        return Quotient(self.num.exquo(monomial), self.den.exquo(monomial))

    @property
    def zero(self) -> bool:
        """Whether it is identically 0."""
        return not _reduced(self.num)


def _times(a: Any, b: Any) -> Any:
    if len(a) * len(b) > 20 * MOST_TERMS:
        raise Unprovable
    return a * b


def constant(value: Quotient) -> bool:
    """Whether a fraction is free of angles and rates."""
    g = _ring()[1]
    moving = [g[name] for name in ("st", "ct", "sp", "cp", *COORDINATES)]
    quotient, rest = _reduced(value.num), 0
    if any(value.den.degree(x) > 0 for x in moving):
        quotient, rest = divmod(quotient, value.den)
    return value.zero or (not rest and all(quotient.degree(x) <= 0 for x in moving))


def _reduced(polynomial: Any) -> Any:
    """The normal form: no square of a sine."""
    _, g = _ring()
    relations = [g["st"] ** 2 + g["ct"] ** 2 - 1, g["sp"] ** 2 + g["cp"] ** 2 - 1]
    return polynomial.rem(relations)


def _quotient(value: Any) -> Quotient:
    if isinstance(value, Quotient):
        return value
    domain, _ = _ring()
    return Quotient(domain(int(value)), domain.one)


def _sine_and_cosine(x: Quotient) -> tuple[Quotient, Quotient]:
    """Of a whole combination of the angles and of quarter turns. Raises Unprovable for any other."""
    domain, g = _ring()
    if not x.den.is_ground:
        raise Unprovable
    sine, cosine = _quotient(0), _quotient(1)
    angles = {g["theta"]: ("st", "ct"), g["phi"]: ("sp", "cp")}
    rest = x.num.quo_ground(x.den.LC)
    for angle, (s, c) in angles.items():
        count = Fraction(str(rest.coeff(angle)))
        rest = rest - angle * rest.coeff(angle)
        sine, cosine = _turned(sine, cosine, Quotient(g[s], domain.one), Quotient(g[c], domain.one), count)
    quarters = Fraction(str(rest.coeff(g["pi"]))) * 2
    if rest - g["pi"] * rest.coeff(g["pi"]):
        raise Unprovable
    return _turned(sine, cosine, _quotient(1), _quotient(0), quarters)


def _turned(sine: Quotient, cosine: Quotient, s: Quotient, c: Quotient, count: Fraction) -> tuple[Quotient, Quotient]:
    if count.denominator != 1 or abs(count) > 12:
        raise Unprovable
    if count < 0:
        s = -s
    for _ in range(abs(int(count))):
        sine, cosine = sine * c + cosine * s, cosine * c - sine * s
    return sine, cosine


def _elementwise(function: Callable[[Any], Any]) -> Any:
    one_by_one = np.frompyfunc(function, 1, 1)
    return lambda x: np.asarray(one_by_one(np.asarray(x, dtype=object)), dtype=object)


def _no_root(x: Any) -> Any:
    raise Unprovable


@cache
def polynomials() -> Any:
    """Arithmetic on Quotients."""
    return SimpleNamespace(
        asarray=_elementwise(_quotient),
        sin=_elementwise(lambda x: _sine_and_cosine(x)[0]),
        cos=_elementwise(lambda x: _sine_and_cosine(x)[1]),
        sqrt=_elementwise(_no_root),
        pi=Quotient(_ring()[1]["pi"], _ring()[0].one),
    )


def polynomial_base(names: Mapping[str, Any] | tuple[str, ...]) -> dict[str, Any]:
    """The quantities of that name as polynomials, each an array (1,)."""
    domain, g = _ring()
    return {name: _single(Quotient(g[name], domain.one)) for name in names}


@cache
def symbolic() -> Any:
    """Arithmetic on sympy's expressions."""
    sympy = need_sympy()
    return SimpleNamespace(
        asarray=_elementwise(sympy.sympify),
        sin=_elementwise(sympy.sin),
        cos=_elementwise(sympy.cos),
        sqrt=_elementwise(sympy.sqrt),
        pi=sympy.pi,
    )


def symbolic_base(names: tuple[str, ...]) -> dict[str, Any]:
    """The quantities of that name as sympy's symbols, each an array (1,)."""
    sympy = need_sympy()
    return {name: _single(sympy.Symbol(name)) for name in names}


@cache
def printed_quantities(pendulum: Pendulum) -> Quantities:
    """Quantities in sympy's symbols, the accelerations and reactions as they are printed, not solved for."""
    base = symbolic_base((*COORDINATES, *PARAMETERS[pendulum.rod], *UNKNOWNS))
    return Quantities(base, pendulum, symbolic())


def _single(value: Any) -> Any:
    array = np.empty(1, dtype=object)
    array[0] = value
    return array


@cache
def fifty_digits() -> Any:
    """Arithmetic on mpmath's numbers of 50 digits."""
    from pendpin.equations.numbers import exact

    numbers = exact(50)
    return SimpleNamespace(
        **vars(numbers), pi=numbers.asarray("3.14159265358979323846264338327950288419716939937510582097")
    )
