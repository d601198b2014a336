"""Exact arithmetic for proofs: fractions of polynomials in sines, cosines, rates and parameters.

Two expressions are equal if the numerator of their difference reduces to 0 by sin² = 1 - cos². sympy's polynomial rings
do the algebra.
"""

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.systems.base import Formula, Quantities, Spec, System, Values
from pendpin.ground.libraries import optional

MOST_TERMS = 4_000  # of a polynomial; beyond that 50 digits decide


class Unprovable(Exception):
    """An expression that is not a fraction of polynomials, or is too long."""


def need_sympy() -> Any:
    """sympy. Raises MissingLibrary where it is not installed."""
    return optional("sympy", "the equation doctor", "sympy")


@cache
def _ring(spec: Spec) -> tuple[Any, dict[str, Any]]:
    """The ring of polynomials and its generators by name; "sin theta" and "cos theta" are generators of their own."""
    sympy = need_sympy()
    circular = [f"{f} {angle}" for angle in spec.angles for f in ("sin", "cos")]
    names = (*circular, *spec.state, *spec.unknowns, *spec.parameters, "pi")
    domain, *generators = sympy.ring([sympy.Symbol(name) for name in names], sympy.QQ)
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
        other = self._alike(other)
        if self.den == other.den:
            return Quotient(self.num + other.num, self.den)
        above = _times(self.num, other.den) + _times(other.num, self.den)
        return Quotient(above, _times(self.den, other.den)).lowered()

    def __mul__(self, other: Any) -> "Quotient":
        """Product."""
        other = self._alike(other)
        return Quotient(_times(self.num, other.num), _times(self.den, other.den)).lowered()

    def __truediv__(self, other: Any) -> "Quotient":
        """Quotient. Raises Unprovable for a division by 0."""
        other = self._alike(other)
        if other.zero:
            raise Unprovable
        return Quotient(_times(self.num, other.den), _times(self.den, other.num)).lowered()

    def __neg__(self) -> "Quotient":
        """Opposite."""
        return Quotient(-self.num, self.den)

    def __sub__(self, other: Any) -> "Quotient":
        """Difference."""
        return self + -self._alike(other)

    def __rsub__(self, other: Any) -> "Quotient":
        """Difference."""
        return self._alike(other) + -self

    def __rtruediv__(self, other: Any) -> "Quotient":
        """Quotient."""
        return self._alike(other) / self

    def __pow__(self, exponent: int) -> "Quotient":
        """Whole powers."""
        value = self._alike(1)
        for _ in range(abs(exponent)):
            value = value * self
        return value if exponent >= 0 else self._alike(1) / value

    __radd__, __rmul__ = __add__, __mul__

    def _alike(self, value: Any) -> "Quotient":
        """Another number as a fraction of the same ring."""
        if isinstance(value, Quotient):
            return value
        ring = self.den.ring
        return Quotient(ring(int(value)), ring.one)

    def lowered(self) -> "Quotient":
        """Without the monomial that numerator and denominator share."""
        if not self.num:
            return Quotient(self.num, self.den.ring.one)
        shared = tuple(map(min, self.num.tail_degrees(), self.den.tail_degrees()))
        if not any(shared):
            return self
        monomial = self.den.ring({shared: 1})
        return Quotient(self.num.exquo(monomial), self.den.exquo(monomial))

    @property
    def zero(self) -> bool:
        """Whether it is identically 0: its normal form has no square of a sine."""
        return not self.num.rem(_relations(self.num.ring))

    def moves(self, names: tuple[str, ...]) -> bool:
        """Whether it contains one of these names."""
        generators = [g for g in self.den.ring.gens if str(g) in names]
        return any(part.degree(x) > 0 for part in (self.num, self.den) for x in generators)

    def slope(self, rates: dict[Any, "Quotient"]) -> "Quotient":
        """The derivative, given those of the generators."""
        total = self._alike(0)
        for generator, rate in rates.items():
            above = _times(self.num.diff(generator), self.den) - _times(self.num, self.den.diff(generator))
            total = total + Quotient(above, _times(self.den, self.den)).lowered() * rate if above else total
        return total


def _times(a: Any, b: Any) -> Any:
    if len(a) * len(b) > 20 * MOST_TERMS:
        raise Unprovable
    return a * b


def constant(value: Quotient, spec: Spec) -> bool:
    """Whether a fraction is free of angles, rates and accelerations: each of its slopes is 0."""
    _, g = _ring(spec)
    one = Quotient(value.den.ring.one, value.den.ring.one)
    return all(value.slope(_rates(g, name, one, spec)).zero for name in (*spec.state, *spec.unknowns))


def _rates(g: dict[str, Any], name: str, rate: Quotient, spec: Spec) -> dict[Any, Quotient]:
    """The rates of the generators that move with a name at some rate: an angle moves its sine and cosine."""
    if name not in spec.angles:
        return {g[name]: rate}
    s, c = (g[f"{f} {name}"] for f in ("sin", "cos"))
    one = s.ring.one
    return {g[name]: rate, s: Quotient(c, one) * rate, c: Quotient(-s, one) * rate}


@cache
def _relations(ring: Any) -> list[Any]:
    generators = {str(x): x for x in ring.gens}
    pairs = ((x, generators["cos" + name[3:]]) for name, x in generators.items() if name.startswith("sin "))
    return [s**2 + c**2 - 1 for s, c in pairs]


def _sine_and_cosine(spec: Spec, x: Quotient) -> tuple[Quotient, Quotient]:
    """Of a whole combination of the angles and of quarter turns. Raises Unprovable for any other."""
    domain, g = _ring(spec)
    if not x.den.is_ground:
        raise Unprovable
    one, zero = Quotient(domain.one, domain.one), Quotient(domain.zero, domain.one)
    sine, cosine = zero, one
    rest = x.num.quo_ground(x.den.LC)
    for angle in spec.angles:
        count = Fraction(str(rest.coeff(g[angle])))
        rest = rest - g[angle] * rest.coeff(g[angle])
        s, c = (Quotient(g[f"{f} {angle}"], domain.one) for f in ("sin", "cos"))
        sine, cosine = _turned(sine, cosine, s, c, count)
    quarters = Fraction(str(rest.coeff(g["pi"]))) * 2
    if rest - g["pi"] * rest.coeff(g["pi"]):
        raise Unprovable
    return _turned(sine, cosine, one, zero, quarters)


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


@cache
def _polynomials(spec: Spec) -> Any:
    """Arithmetic on Quotients."""
    domain, g = _ring(spec)
    number = lambda x: x if isinstance(x, Quotient) else Quotient(domain(int(x)), domain.one)  # noqa: E731

    def no_root(x: Any) -> Any:
        raise Unprovable

    return SimpleNamespace(
        asarray=_elementwise(number),
        sin=_elementwise(lambda x: _sine_and_cosine(spec, x)[0]),
        cos=_elementwise(lambda x: _sine_and_cosine(spec, x)[1]),
        sqrt=_elementwise(no_root),
        pi=Quotient(g["pi"], domain.one),
        derivative=_derivative,
    )


@cache
def polynomial_states(system: System, true: bool) -> Quantities:
    """Every quantity as a fraction of polynomials; the unknowns those of the true motion, or free."""
    domain, g = _ring(system.spec)
    names = (*system.spec.state, *system.spec.parameters, *(() if true else system.spec.unknowns))
    base = {name: np.array([Quotient(g[name], domain.one)], dtype=object) for name in names}
    return Quantities(base, system, _polynomials(system.spec), true)


def _derivative(q: Quantities, function: Formula, variable: str) -> Values:
    """The derivative of a function of the state by the rules, in time or by a coordinate or rate."""
    spec, g = q.spec, _ring(q.spec)[1]
    value = function(polynomial_states(q.system, False))
    if (q.true or variable == "t") and any(entry.moves(spec.unknowns) for entry in value.reshape(-1)):
        raise Unread("the rate of an acceleration or reaction is not known")
    rates: dict[Any, Any] = {}
    for name, rate in q.direction(variable).items():
        rates |= _rates(g, name, rate[0], spec)
    return np.asarray(np.frompyfunc(lambda entry: entry.slope(rates), 1, 1)(value), dtype=object)


@cache
def fifty_digits() -> Any:
    """Arithmetic on mpmath's numbers of 50 digits."""
    from pendpin.equations.base import exact

    numbers = exact(50)
    return SimpleNamespace(
        **vars(numbers), pi=numbers.asarray("3.14159265358979323846264338327950288419716939937510582097")
    )
