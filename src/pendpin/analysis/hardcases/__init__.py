"""The hard cases: scenes that break simulators, each with a bound from physics or analysis (docs/hard_cases.md)."""

from collections.abc import Sequence

from pendpin.analysis.hardcases import chains, chaos, contacts, long_runs, poles, scales, starts, stiff
from pendpin.analysis.hardcases.base import Case, Outcome
from pendpin.analysis.hardcases.running import Progress, Report, chosen, run_cases

__all__ = ["CASES", "Case", "Outcome", "Report", "hard"]

_FAMILIES = (poles, starts, long_runs, chains, stiff, contacts, scales, chaos)
CASES = {
    case.name: case for case in sorted((c for family in _FAMILIES for c in family.CASES), key=lambda case: case.group)
}


def hard(
    names: Sequence[str] = (),
    methods: Sequence[str] | None = None,
    full: bool = True,
    peers: bool = False,
    progress: Progress = lambda what: None,
) -> Report:
    """Run the hard cases of these names, or all, on the methods that they claim, or on those of `methods` alone.

    full=False takes the short forms; with `peers` other simulators run those, where gravity acts alone, beside "auto".
    `progress` gets the name of what is being run. Raises InputError for an unknown case, MissingLibrary for a missing
    simulator; Ctrl-C ends it with what is done.
    """
    cases = chosen(CASES, names)
    if not peers:
        return run_cases(cases, methods, full, progress)
    from pendpin.analysis.hardcases.other_simulators import hard_peers

    return hard_peers(cases, progress)
