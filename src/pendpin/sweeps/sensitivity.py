"""Sobol' indices: which share of a measure's variance each varied number causes, alone and with the others (SALib)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from pendpin.errors import InputError
from pendpin.ground.libraries import optional
from pendpin.sweeps.plan import MOST_CASES, Plan, Spread, check_spreads, pairs
from pendpin.sweeps.task import EXTRA

LEVEL = 0.95  # of the confidence intervals
OF_ZERO = 1 << 32  # in place of the seed 0, which SALib takes for none


def problem(spreads: Mapping[str, Spread]) -> dict[str, Any]:
    """The numbers and their spreads as SALib takes them."""
    return {
        "num_vars": len(spreads),
        "names": list(spreads),
        "bounds": [[one, other] for _, one, other in spreads.values()],
        "dists": ["unif" if kind == "uniform" else "norm" for kind, _, _ in spreads.values()],
    }


def sobol_plan(spreads: Mapping[str, Spread], count: int, seed: int = 0) -> Plan:
    """The cases of Saltelli's scheme: count (keys + 2) of them. Raises InputError for a count that is not a power of 2."""
    if count < 2 or count & (count - 1):
        raise InputError(f"sobol: {count} is not a power of 2 above 1, such as {1 << max(1, int(count).bit_length())}")
    if (cases := count * (len(spreads) + 2)) > MOST_CASES:
        raise InputError(f"sobol: {count} base cases make {cases} cases, more than {MOST_CASES}")
    check_spreads(spreads)
    rows = _salib("sample").sample(problem(spreads), count, calc_second_order=False, seed=seed)
    return pairs({key: rows[:, i] for i, key in enumerate(spreads)})


def indices(spreads: Mapping[str, Spread], values: Any, seed: int = 0) -> dict[str, dict[str, float]]:
    """First-order and total indices of each key with half-widths of their 95 % intervals, from a measure (cases,).

    Raises InputError where a case has no value: the scheme needs every one.
    """
    y = np.asarray(values, float)
    if not np.isfinite(y).all():
        raise InputError(
            f"sobol: {int((~np.isfinite(y)).sum())} of {y.size} cases have no value; narrow what is varied"
        )
    if np.ptp(y) == 0:
        return {key: {"first": 0.0, "first_conf": 0.0, "total": 0.0, "total_conf": 0.0} for key in spreads}
    saltelli = problem(spreads)
    shares = _salib("analyze").analyze(saltelli, y, calc_second_order=False, conf_level=LEVEL, seed=seed or OF_ZERO)
    names = {"first": "S1", "first_conf": "S1_conf", "total": "ST", "total_conf": "ST_conf"}
    return {
        key: {name: float(shares[salib_name][i]) for name, salib_name in names.items()} for i, key in enumerate(spreads)
    }


def _salib(part: str) -> Any:
    return optional(f"SALib.{part}.sobol", "sobol", EXTRA)
