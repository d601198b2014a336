"""The number type of heyoka's expressions, on which equations written once over plain arithmetic run too."""

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from pendpin.equations.base import FUNCTIONS
from pendpin.ground import libraries


@cache
def symbols() -> Any:
    """heyoka's expressions in object arrays. Raises ImportError without heyoka."""
    heyoka = libraries.heyoka()

    def on_expressions(function: Any) -> Any:
        return np.frompyfunc(lambda x: function(heyoka.expression(x)), 1, 1)

    def chosen(first: Any, second: Any, test: Any) -> Any:
        first, second = heyoka.expression(first), heyoka.expression(second)
        return heyoka.select(test(first, second), first, second)

    functions = {name: on_expressions(getattr(heyoka, name)) for name in FUNCTIONS}
    functions["minimum"] = np.frompyfunc(lambda x, y: chosen(x, y, heyoka.lt), 2, 1)
    functions["maximum"] = np.frompyfunc(lambda x, y: chosen(x, y, heyoka.gt), 2, 1)
    return SimpleNamespace(asarray=np.asarray, **functions)
