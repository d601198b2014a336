"""The hard cases: scenes that break simulators, each with a bound from physics or analysis (docs/hard_cases.md)."""

from collections.abc import Sequence

from pendpin.verification.claims import Progress, choose_cases
from pendpin.verification.hardcases import chains, chaos, poles, stiff
from pendpin.verification.hardcases.base import Case, HardReport, Outcome, outcomes, reported

_FAMILIES = (poles, chaos, chains, stiff)
CASES = {
    case.name: case for case in sorted((c for family in _FAMILIES for c in family.CASES), key=lambda case: case.group)
}


def hard(
    names: Sequence[str] = (),
    methods: Sequence[str] | None = None,
    full: bool = True,
    peers: bool = False,
    progress: Progress = lambda what: None,
) -> HardReport:
    """Run the hard cases with these names, or all of them, on their methods, or only on those of `methods`.

    full=False runs the short forms. With `peers`, other simulators and "auto" run the short forms of the cases in which
    only gravity acts. `progress` is called with the name of the case and method. After Ctrl-C the report holds the
    outcomes so far. Raises InputError for an unknown case, MissingLibrary for a missing simulator.
    """
    cases = tuple(choose_cases(CASES, names, "hard").values())
    if not peers:
        return reported(cases, lambda case: outcomes(case, methods, full, progress))
    from pendpin.verification.hardcases.other_simulators import contests, run_on_peers

    return reported(contests(cases), lambda case: run_on_peers(case, progress))
