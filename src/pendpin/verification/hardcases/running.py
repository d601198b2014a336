"""Running the catalogue: every case on each of its methods, and the outcomes."""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any

from pendpin.errors import MissingLibrary
from pendpin.ground.report import Report, Result, Table
from pendpin.motions.simulate import simulate
from pendpin.verification.claims import Progress, attempt, collect, describe_broken
from pendpin.verification.hardcases.base import Case, Outcome, Solve

FIELDS = ("name", "group", "title", "physics", "why", "figure", "bound", "derivation", "methods")  # of a case, in JSON


@dataclass(frozen=True, repr=False)
class HardReport(Result):
    """The outcomes so far, and their cases."""

    outcomes: tuple[Outcome, ...]
    cases: tuple[Case, ...]
    stopped: bool = False  # True if the user stopped it before the end

    @property
    def broken(self) -> tuple[Outcome, ...]:
        """The claims that did not hold."""
        return tuple(outcome for outcome in self.outcomes if outcome.claimed and not outcome.ok)

    @property
    def fault(self) -> str | None:
        """The broken claims in one line; None if all claims hold."""
        return describe_broken(self.broken)

    def report(self) -> Report:
        """What was measured of each case on each method, which runs failed, and how many claims are broken."""
        cases = ["", *(o.case for o in self.outcomes)]  # each named once
        rows = [
            ("" if o.case == before else o.case, o.method, o.shown, f"{o.bound:.1e}", o.verdict, f"{o.seconds:.2f}")
            for before, o in zip(cases, self.outcomes, strict=False)
        ]
        words = [f"{o.case} on {o.method}: {o.failure}" for o in self.outcomes if o.failure]
        if claims := [o for o in self.outcomes if o.claimed]:
            words.append(f"{len(claims)} claims, {len(self.broken)} broken, {sum(o.seconds for o in claims):.0f} s")
        outcomes = [asdict(o) | {"ok": o.ok, "verdict": o.verdict} for o in self.outcomes]
        described = [{name: getattr(case, name) for name in FIELDS} for case in self.cases]
        data = {"ok": not self.broken, "stopped": self.stopped, "outcomes": outcomes, "cases": described}
        head = ("case", "method", "measured", "bound", "verdict", "seconds")
        return Report((Table(head, rows), *words), data, self.fault)


def catalogue_report(cases: Iterable[Case]) -> Report:
    """The names of hard cases, their titles and bounds."""
    rows = [(case.name, case.title, f"{case.bound:.1e}") for case in cases]
    data = [{name: getattr(case, name) for name in ("name", "title", "figure", "bound")} for case in cases]
    return Report((Table(("case", "what", "bound"), rows),), data)


def reported(cases: Sequence[Case], outcomes_of: Callable[[Case], Iterator[Outcome]]) -> HardReport:
    """The outcomes of all cases; after Ctrl-C those so far."""
    results, stopped = collect(outcome for case in cases for outcome in outcomes_of(case))
    return HardReport(results, tuple(cases), stopped)


def outcomes(case: Case, methods: Sequence[str] | None, full: bool, progress: Progress) -> Iterator[Outcome]:
    """A case on its methods and beside them, or only on those in `methods`."""
    for method in case.methods:
        if methods is None or method in methods:
            progress(f"{case.name} on {method}")
            yield outcome(case, method, full)
    if case.beside is not None and methods is None:
        progress(f"{case.name}, beside")
        begin = time.process_time()
        beside = case.beside()
        seconds = (time.process_time() - begin) / max(len(beside), 1)
        for name, measured in beside.items():
            yield Outcome(case.name, name, measured, case.bound, None, seconds, claimed=False, beside=True)


def outcome(case: Case, method: str, full: bool) -> Outcome:
    """One case on one of its methods, with its setting."""
    setting: dict[str, Any] = dict(case.methods[method])
    return measured(case, method, lambda scene: simulate(scene, method=method, **setting), full)


def measured(case: Case, method: str, solve: Solve, full: bool) -> Outcome:
    """One case solved by `solve`; an error of the run is an outcome too."""
    begin = time.process_time()
    figure, error = attempt(lambda: float(case.measure(solve, full)))  # JSON takes no NumPy numbers
    failure = error and str(error)
    if figure is not None and not isfinite(figure):
        figure, failure = None, "its numbers are not finite"
    missing, seconds = isinstance(error, MissingLibrary), time.process_time() - begin
    return Outcome(case.name, method, figure, case.bound, failure, seconds, claimed=not missing, left_out=missing)
