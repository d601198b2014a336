"""The number types that one piece of arithmetic runs on: floats, mpmath's numbers of any precision, heyoka's symbols.

Each is a namespace `xp`, numpy or one with its names: asarray, sqrt, exp, log, sin, cos, tan, tanh, element by element over
arrays, and minimum and maximum of two. Sums, products, `@`, `np.cross`, `np.stack` and the like need no namespace:
numpy does them on object arrays.
"""

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

FUNCTIONS = ("sqrt", "exp", "log", "sin", "cos", "tan", "tanh")


@cache
def exact(digits: int) -> Any:
    """mpmath's numbers of `digits` decimal digits, in object arrays; `asarray` takes floats over without rounding.

    The precision belongs to the namespace, not to the process: several can be used side by side.
    Raises ImportError without mpmath.
    """
    import mpmath

    context = mpmath.mp.clone()
    context.dps = digits
    functions = {name: np.frompyfunc(getattr(context, name), 1, 1) for name in FUNCTIONS}
    convert = np.frompyfunc(context.mpf, 1, 1)
    functions["asarray"] = lambda x: np.asarray(convert(np.asarray(x)), dtype=object)
    return SimpleNamespace(minimum=np.minimum, maximum=np.maximum, **functions)


@cache
def symbols() -> Any:
    """heyoka's expressions in object arrays. Raises ImportError without heyoka."""
    import heyoka

    def on_expressions(function: Any) -> Any:
        return np.frompyfunc(lambda x: function(heyoka.expression(x)), 1, 1)

    def chosen(first: Any, second: Any, test: Any) -> Any:
        first, second = heyoka.expression(first), heyoka.expression(second)
        return heyoka.select(test(first, second), first, second)

    functions = {name: on_expressions(getattr(heyoka, name)) for name in FUNCTIONS}
    functions["minimum"] = np.frompyfunc(lambda x, y: chosen(x, y, heyoka.lt), 2, 1)
    functions["maximum"] = np.frompyfunc(lambda x, y: chosen(x, y, heyoka.gt), 2, 1)
    return SimpleNamespace(asarray=np.asarray, **functions)
