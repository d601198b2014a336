"""Running the catalogue: every case on each of its methods, and the outcomes."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any

from pendpin.errors import InputError, Interrupted, PendpinError, brief, not_one_of
from pendpin.hardcases.base import Case, Outcome, Solve, on_method

Progress = Callable[[str], None]  # called with the name of the case and method


@dataclass(frozen=True, repr=False)
class HardReport:
    """The outcomes so far, and their cases."""

    outcomes: tuple[Outcome, ...]
    cases: tuple[Case, ...]
    stopped: bool = False  # True if the user stopped it before the end

    def __repr__(self) -> str:
        claims = sum(outcome.claimed for outcome in self.outcomes)
        cases = "; ".join(f"{o.case} on {o.method}: {o.shown}, {o.verdict}" for o in self.outcomes)
        return brief(f"Hard cases: {claims} claims, {len(self.broken)} broken. {cases}")

    @property
    def broken(self) -> tuple[Outcome, ...]:
        """The claims that did not hold."""
        return tuple(outcome for outcome in self.outcomes if outcome.claimed and not outcome.ok)

    @property
    def fault(self) -> str | None:
        """The broken claims in one line; None if all claims hold."""
        if not self.broken:
            return None
        return "broken: " + "; ".join(map(_line, self.broken))

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain data, for JSON."""
        outcomes = [asdict(o) | {"ok": o.ok, "verdict": o.verdict} for o in self.outcomes]
        cases = [{name: getattr(case, name) for name in _FIELDS} for case in self.cases]
        return {"ok": not self.broken, "stopped": self.stopped, "outcomes": outcomes, "cases": cases}


_FIELDS = ("name", "group", "title", "physics", "why", "figure", "bound", "derivation", "methods")


def _line(outcome: Outcome) -> str:
    why = outcome.failure or f"{outcome.measured:.3g} is above {outcome.bound:.3g}"
    return f"{outcome.case} on {outcome.method}: {why}"


def reported(cases: Sequence[Case], outcomes_of: Callable[[Case], Iterator[Outcome]]) -> HardReport:
    """The outcomes of all cases; after Ctrl-C those so far."""
    results: list[Outcome] = []
    try:
        for case in cases:
            results.extend(outcomes_of(case))
    except (KeyboardInterrupt, Interrupted):
        return HardReport(tuple(results), tuple(cases), stopped=True)
    return HardReport(tuple(results), tuple(cases))


def outcomes(case: Case, methods: Sequence[str] | None, full: bool, progress: Progress) -> Iterator[Outcome]:
    """A case on its methods and beside them, or only on those in `methods`."""
    for method in case.methods:
        if methods is None or method in methods:
            progress(f"{case.name} on {method}")
            yield outcome(case, method, full)
    if case.beside is not None and methods is None:
        progress(f"{case.name}, beside")
        begin = time.perf_counter()
        beside = case.beside()
        seconds = (time.perf_counter() - begin) / max(len(beside), 1)
        for name, measured in beside.items():
            yield Outcome(case.name, name, measured, case.bound, seconds, claimed=False, beside=True)


def outcome(case: Case, method: str, full: bool) -> Outcome:
    """One case on one of its methods."""
    return measured(case, method, on_method(case, method), full)


def measured(case: Case, method: str, solve: Solve, full: bool) -> Outcome:
    """One case solved by `solve`; an error of the run is an outcome too."""
    begin, figure, failure = time.perf_counter(), None, None
    try:
        figure = float(case.measure(solve, full))  # JSON takes no NumPy numbers
    except Interrupted:
        raise
    except PendpinError as error:
        failure = str(error)
    if figure is not None and not isfinite(figure):
        figure, failure = None, "its numbers are not finite"
    return Outcome(case.name, method, figure, case.bound, time.perf_counter() - begin, failure)


def chosen(cases: Mapping[str, Case], names: Sequence[str]) -> tuple[Case, ...]:
    """The cases with these names, or all. Raises InputError for an unknown name."""
    for name in names:
        if name not in cases:
            raise InputError(f"hard: case {not_one_of(name, cases)}; `pendpin hard --list` shows all")
    return tuple(cases[name] for name in names or cases)
