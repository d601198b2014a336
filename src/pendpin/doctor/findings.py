"""What is found about the equations of a document: a verdict on each, and what mends it."""

from dataclasses import dataclass

from pendpin.doctor.checking.residuals import Equation
from pendpin.doctor.mending.mends import Mend
from pendpin.doctor.recognition import UNKNOWN
from pendpin.doctor.systems.base import System
from pendpin.errors import brief

VERDICTS = ("holds", "holds if", "fails", "not checked")


@dataclass(frozen=True, eq=False, repr=False)
class Finding:
    """What is found about one equation. `verdict` is one of VERDICTS; `condition` says when it holds."""

    number: int
    latex: str
    place: str
    kind: str
    verdict: str
    condition: str = ""
    proved: bool = False
    error: float = 0.0  # relative to its terms
    remark: str = ""
    when: str = ""
    dimensions: str = ""
    mends: tuple[Mend, ...] = ()
    equation: Equation | None = None
    linear: bool = False  # compared to the first order
    follows: int = 0  # the number of the wrong equation that it follows from; 0 for none
    unknown: tuple[str, ...] = ()  # the symbols for want of which it is not checked

    def __repr__(self) -> str:
        return brief(f"Finding: equation {self.number}, {self.place}, {self.kind}: {self.verdict}. {self.latex}")


@dataclass(frozen=True, eq=False)
class Shared:
    """One mend that heals several equations."""

    old: str
    new: str
    numbers: tuple[int, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Findings:
    """Every equation with its verdict, for the system that they were checked for."""

    findings: tuple[Finding, ...]
    system: System
    title: str
    remarks: tuple[str, ...] = ()
    shared: tuple[Shared, ...] = ()
    skipped: tuple[str, ...] = ()  # the lines with an equals sign that were not read as equations

    @property
    def ok(self) -> bool:
        """Whether some equation, no definition, holds, if only under a condition, and none fails or is doubtful."""
        verdicts = {finding.verdict for finding in self.findings if finding.kind != "definition"}
        return bool(verdicts & {"holds", "holds if"}) and "fails" not in verdicts and not self.doubtful

    @property
    def system_is_known(self) -> bool:
        """Whether the equations are about a system that pendpin knows."""
        return self.title != UNKNOWN

    @property
    def unchecked(self) -> tuple[Finding, ...]:
        """The equations that say something which is not checked."""
        return tuple(found for found in self.findings if found.verdict == "not checked" and found.kind != "condition")

    @property
    def doubtful(self) -> tuple[Finding, ...]:
        """The equations that do not hold as they are read, without a small change that would show what is wrong."""
        return tuple(finding for finding in self.findings if finding.verdict == "not checked" and finding.when)

    @property
    def wrong(self) -> tuple[Finding, ...]:
        """The equations that fail."""
        return tuple(finding for finding in self.findings if finding.verdict == "fails")
