"""Why the numbers can be believed: three rooms, each one command and one page of docs; here is what they share, a claim.

`pendpin validate` is agreement/, published results. `pendpin hard` is hardcases/, what breaks simulators. `pendpin cost` is
work_precision/, what accuracy costs in time. `pendpin check` is motions/crosschecks: a run's page prints its verdict.
simulators.py runs a scene in MuJoCo, Drake and SciPy for the others.
May import: graphics, motions, runs and what is below them; no other tool.
"""

from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from pendpin.errors import InputError, Interrupted, not_one_of, shown
from pendpin.ground.report import Result

Progress = Callable[[str], None]  # called with the case and method that begin
C = TypeVar("C")


@dataclass(frozen=True)
class Claim:
    """The figure of a case by one method, and the bound that it must not exceed."""

    case: str
    method: str
    measured: float | None  # None where the run failed
    bound: float
    failure: str | None

    @property
    def ok(self) -> bool:
        """Whether the figure is within the bound; False for NaN."""
        return self.measured is not None and bool(self.measured <= self.bound)

    @property
    def verdict(self) -> str:
        """One word for a table."""
        return "ok" if self.ok else "BROKEN"


def collect(claims: Iterable[C]) -> tuple[tuple[C, ...], bool]:
    """The claims, those so far after Ctrl-C, and whether the user stopped them."""
    results: list[C] = []
    try:
        results.extend(claims)  # keeps what came before an exception
    except (KeyboardInterrupt, Interrupted):
        return tuple(results), True
    return tuple(results), False


def choose_cases(cases: Mapping[str, C], names: Sequence[str], command: str) -> dict[str, C]:
    """The cases with these names, or all. Raises InputError for an unknown name."""
    names = [names] if isinstance(names, str) else names
    if not isinstance(names, Sequence):
        raise InputError(f"{command}: {shown(names)} is not a list of cases")
    for name in names:
        if not isinstance(name, str) or name not in cases:
            raise InputError(f"{command}: case {not_one_of(name, cases)}; `pendpin {command} --list` shows all")
    return {name: cases[name] for name in names or cases}


class Claims(Result):
    """What became of some claims, each of which prints as a line."""

    @property
    @abstractmethod
    def broken(self) -> tuple[Claim, ...]:
        """The claims that do not hold."""

    @property
    def fault(self) -> str | None:
        """The broken claims in one line; None if all hold."""
        lines = "; ".join(map(str, self.broken))
        return f"broken: {lines}" if lines else None


def name_once(names: Sequence[str]) -> list[str]:
    """The first column of a table: a name that is that of the row above is left out."""
    return ["" if name == above else name for name, above in zip(names, ["", *names], strict=False)]
