"""Numbers other than floats: those of 50 digits, which tell what holds from what nearly holds, and sympy's expressions."""

from collections.abc import Callable
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.systems.base import STATES, Formula, Quantities, System, Values
from pendpin.equations.base import exact
from pendpin.ground.libraries import optional

PAIRS = 4  # states in 50 digits from either half of the random states


def need_sympy() -> Any:
    """sympy. Raises MissingLibrary where it is not installed."""
    return optional("sympy", "the equation doctor", "sympy")


@cache
def in_fifty_digits(states: Quantities) -> Quantities:
    """Some of the states in mpmath's numbers of 50 digits, as many of the second half as of the first."""
    numbers = exact(50)
    pi = numbers.asarray("3.14159265358979323846264338327950288419716939937510582097")
    chosen = [place + start for start in (0, STATES // 2) for place in range(PAIRS)]
    base = {name: numbers.asarray(values[chosen]) for name, values in states.base.items()}
    return Quantities(base, states.system, SimpleNamespace(**vars(numbers), pi=pi), states.true)


@cache
def in_symbols(system: System) -> Quantities:
    """Every quantity as sympy's expression in the state, the parameters and the unknowns."""
    sympy = need_sympy()

    def on_each(function: Callable[[Any], Any]) -> Callable[[Any], Values]:
        one_by_one = np.frompyfunc(function, 1, 1)
        return lambda x: np.asarray(one_by_one(np.asarray(x, dtype=object)), dtype=object)

    def derivative(q: Quantities, function: Formula, variable: str) -> Values:
        value, rates = function(q), {sympy.Symbol(name): rate[0] for name, rate in q.direction(variable).items()}
        if variable == "t" and any(str(one) in q.spec.unknowns for x in value.flat for one in x.free_symbols):
            raise Unread("the rate of an acceleration or reaction is not known")
        return on_each(lambda x: sum(x.diff(symbol) * rate for symbol, rate in rates.items()))(value)

    functions = {name: on_each(getattr(sympy, name)) for name in ("sin", "cos", "sqrt")}
    numbers = SimpleNamespace(asarray=on_each(sympy.sympify), pi=sympy.pi, derivative=derivative, **functions)
    names = (*system.spec.state, *system.spec.parameters, *system.spec.unknowns)
    return Quantities({name: np.array([sympy.Symbol(name)], dtype=object) for name in names}, system, numbers)
