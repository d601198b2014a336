"""What a cross-check found: its rows, the matrix of routes and quantities, and the verdict in words."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np

from pendpin.ground.report import Report, Result, Table
from pendpin.motions.crosschecks.routes import REFERENCE

ROUTE = 12  # letters of a route's name: those of users may be long
ANY_TWO = "any two"


@dataclass(frozen=True)
class CheckRow:
    """The worst difference between two routes in one quantity."""

    quantity: str
    place: str  # the joint or rod
    first: str
    second: str
    relative: float  # to the rounding scale of the quantity (pendpin.motions.crosschecks.rounding_scale)
    ulps: float  # of that scale
    state: int  # where: index of the state
    q: tuple[float, ...]
    v: tuple[float, ...]
    bound: float

    @property
    def ok(self) -> bool:
        """Whether the difference is within the bound; False for NaN."""
        return self.relative <= self.bound


@dataclass(frozen=True, repr=False)
class CheckReport(Result):
    """A cross-check: one row for each quantity and pair of routes."""

    rows: tuple[CheckRow, ...]
    states: int
    in_50_digits: int  # how many of the states the reference_route in 50 digits was given
    routes: tuple[str, ...]
    bound: float

    def report(self, every_pair: bool = False) -> Report:
        """The matrix of routes and quantities, and the verdict in words; before it, if asked for, every pair."""
        pairs = [_pairs(self)] if every_pair else []
        return Report((*pairs, _matrix(self), *_verdict(self)), asdict(self) | {"ok": self.ok}, self.fault)

    @property
    def ok(self) -> bool:
        """Whether every row is within the bound."""
        return all(row.ok for row in self.rows)

    @property
    def worst(self) -> CheckRow:
        """The row with the largest relative difference, NaN above all."""
        return max(self.rows, key=_badness)

    @property
    def worst_route(self) -> tuple[str, CheckRow] | None:
        """The route farthest from the reference_route, and the row that says so; None without a reference_route."""
        in_50_digits = [row for row in self.rows if REFERENCE in (row.first, row.second)]
        if not in_50_digits:
            return None
        row = max(in_50_digits, key=_badness)
        return (row.first if row.second == REFERENCE else row.second), row

    @property
    def against(self) -> str:
        """What the matrix holds each route against: the reference route, or the first one."""
        return REFERENCE if self.in_50_digits else self.routes[0]

    @property
    def verdict(self) -> str:
        """What a comparison along a run says, in a few words."""
        end = "ok" if self.ok else "BROKEN"
        return f"two methods agree to {self.worst.relative:.1e} (worst: {self.worst.quantity}), {end}, along the run"

    @property
    def fault(self) -> str | None:
        """What is broken, as one line that names the quantities, the suspect and the worst state; None if all is ok."""
        broken = [row for row in self.rows if not row.ok]
        if not broken:
            return None
        quantities = ", ".join(dict.fromkeys(row.quantity for row in broken))
        suspects = [name for name in self.routes if all(name in (row.first, row.second) for row in broken)]
        who = f"{suspects[0]} disagrees" if len(suspects) == 1 else "the routes disagree"
        worst = self.worst
        return (
            f"{who} in {quantities}; worst: {worst.quantity} of {worst.place}, {worst.first} against {worst.second}, by "
            f"{worst.relative:.2g} of its terms (bound {self.bound:g}), at state {worst.state}: q = {_numbers(worst.q)}, "
            f"v = {_numbers(worst.v)}"
        )


def _pairs(report: CheckReport) -> Table:
    """Every pair of routes in every quantity."""
    head = ("quantity", "of", "routes", "relative", "ulps", "state", "")
    rows = []
    for row in report.rows:
        figures = f"{row.relative:.1e}", f"{row.ulps:.1f}", str(row.state), "ok" if row.ok else "BROKEN"
        rows.append((row.quantity, row.place, f"{row.first} / {row.second}", *figures))
    return Table(head, rows)


def _matrix(report: CheckReport) -> Table:
    """A line for each route with its worst difference in each quantity, then one for any two routes."""
    quantities = list(dict.fromkeys(row.quantity for row in report.rows))
    pairs = {
        name: [row for row in report.rows if {name, report.against} == {row.first, row.second}]
        for name in report.routes
        if name != report.against
    }
    pairs[ANY_TWO] = [row for row in report.rows if REFERENCE not in (row.first, row.second)]
    cells = {
        name: [_cell([row for row in rows if row.quantity == quantity]) for quantity in quantities]
        for name, rows in pairs.items()
    }
    return Table(("", *quantities), [(name[:ROUTE], *row) for name, row in cells.items()])


def _cell(rows: list[CheckRow]) -> str:
    """The worst figure of some rows, marked where it is beyond the bound; a dash where a route gives no such quantity."""
    if not rows:
        return "-"
    worst = max(rows, key=_badness)
    return f"{'' if worst.ok else '!'}{worst.relative:.0e}"


def _verdict(report: CheckReport) -> Iterator[str]:
    """What the matrix shows and what follows from it, in sentences."""
    few, n = report.in_50_digits, report.states
    where = f"at {few} of the {n} states, the worst among them" if few else f"at {n} states"
    yield (
        f"Largest differences, divided by the size of the terms: each route against {report.against} {where}; "
        f"any two at all {n}."
    )
    if route := report.worst_route:
        name, row = route
        yield f"Farthest from {REFERENCE}: {name}, {row.ulps:.1f} units in the last place in {row.quantity} of {row.place}."
    who = "Both" if len(report.routes) == 2 else f"All {len(report.routes)}"
    if report.ok:
        yield f"{who} routes agree: no difference is above {report.bound:g}, the bound for rounding errors."
    else:
        yield f"BROKEN: the routes do not agree; ! marks differences above the bound {report.bound:g}."


def _badness(row: CheckRow) -> float:
    return np.inf if np.isnan(row.relative) else row.relative


def _numbers(values: tuple[float, ...]) -> str:
    shown = ", ".join(f"{value:.6g}" for value in values[:6])
    return f"({shown}{', ...' if len(values) > 6 else ''})"
