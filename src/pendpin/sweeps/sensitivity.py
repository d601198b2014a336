"""Sobol' indices: which share of a measure's variance each varied number causes, alone and with the others."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from pendpin.errors import InputError
from pendpin.ground.arrays import Array
from pendpin.ground.report import Report, Table
from pendpin.sweeps.plan import MOST_CASES, Plan, Spread, check_spreads, pairs, spread_out

LEVEL = 0.95  # of the confidence intervals
RESAMPLES = 200  # bootstrap: the half-widths are then known to a twentieth


def sobol_plan(spreads: Mapping[str, Spread], count: int, seed: int = 0) -> Plan:
    """The cases of Saltelli's scheme: count (keys + 2) of them. Raises InputError for a count that is not a power of 2.

    Each base case has one row of A, one row for each key in which that key's number is B's, and one row of B.
    """
    from scipy.stats import qmc

    if count < 2 or count & (count - 1):
        raise InputError(f"sobol: {count} is not a power of 2 above 1, such as {1 << max(1, int(count).bit_length())}")
    keys = len(spreads)
    if (cases := count * (keys + 2)) > MOST_CASES:
        raise InputError(f"sobol: {count} base cases make {cases} cases, more than {MOST_CASES}")
    check_spreads(spreads)
    unit = qmc.Sobol(2 * keys, rng=seed).random(count)
    rows = np.repeat(unit[:, None, :keys], keys + 2, axis=1)  # (count, keys + 2, keys), all of them A
    for i in range(keys):
        rows[:, 1 + i, i] = unit[:, keys + i]
    rows[:, -1] = unit[:, keys:]
    return pairs(spread_out(spreads, rows.reshape(cases, keys)))


def indices(spreads: Mapping[str, Spread], values: Any, seed: int = 0) -> dict[str, dict[str, float]]:
    """First-order and total indices of each key with half-widths of their 95 % intervals, from a measure (cases,).

    Saltelli et al. 2010 (Computer Physics Communications 181, 259), table 2 (b) and (f); the intervals by bootstrap over the
    base cases. Raises InputError where a case has no value, because the scheme needs every one.
    """
    from scipy import stats

    y = np.asarray(values, float)
    if not np.isfinite(y).all():
        raise InputError(
            f"sobol: {int((~np.isfinite(y)).sum())} of {y.size} cases have no value; narrow what is varied"
        )
    if np.ptp(y) == 0:
        return {key: {"first": 0.0, "first_conf": 0.0, "total": 0.0, "total_conf": 0.0} for key in spreads}
    columns = y.reshape(-1, len(spreads) + 2).T  # (keys + 2, base cases)
    columns = columns - columns[[0, -1]].mean()

    def estimate(base_cases: Array) -> Array:
        a, b, mixed = columns[0, base_cases], columns[-1, base_cases], columns[1:-1, base_cases]
        variance = np.var([a, b]) or np.inf
        return np.array([(b * (mixed - a)).mean(1), ((a - mixed) ** 2).mean(1) / 2]) / variance

    everything = np.arange(columns.shape[1])
    first, total = estimate(everything)
    settings: dict[str, Any] = {"n_resamples": RESAMPLES, "method": "percentile", "vectorized": False}
    spread = stats.bootstrap([everything], estimate, rng=np.random.default_rng(seed), **settings).standard_error
    width = stats.norm.ppf(0.5 + LEVEL / 2) * spread
    table = zip(spreads, first, width[0], total, width[1], strict=True)
    names = ("first", "first_conf", "total", "total_conf")
    return {key: dict(zip(names, map(float, row), strict=True)) for key, *row in table}


def shares_report(spreads: Mapping[str, Spread], measures: Mapping[str, Any], seed: int) -> Report:
    """The shares of each measure (cases,) that the varied numbers cause. Raises InputError where a case has no value."""
    shares = {name: indices(spreads, values, seed) for name, values in measures.items()}
    parts: list[str | Table] = []
    for name, rows in shares.items():
        cells = [(key, *(f"{x:.3f}" for x in row.values())) for key, row in rows.items()]
        parts.append(f"Shares of the variance of {name} (95 % intervals):")
        parts.append(Table(("varied", "alone", "+-", "with all others", "+-"), cells))
    return Report(parts, {"sobol": shares})
