"""The doctor's main line: a document in, a verdict and mends for each of its equations out."""

from collections import defaultdict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from pendpin.analysis.doctor.checking.check import check
from pendpin.analysis.doctor.checking.circumstances import scaling, when
from pendpin.analysis.doctor.checking.dimensions import of_equation
from pendpin.analysis.doctor.checking.mechanics import RODS, Pendulum
from pendpin.analysis.doctor.checking.residuals import Equation
from pendpin.analysis.doctor.conventions import (
    conventions_of,
    find_convention,
    likely_rod,
    of_another_motion,
    uses_polar_angles,
)
from pendpin.analysis.doctor.mending.mends import Mend, Patient, mends, mends_of_mismatch, styles_of
from pendpin.analysis.doctor.mending.monomials import Printer
from pendpin.analysis.doctor.patients import Candidate, Printed, candidates, kind_of, printed
from pendpin.analysis.doctor.reading.documents import Document
from pendpin.analysis.doctor.reading.grammar import lone
from pendpin.analysis.doctor.reading.tokens import is_latex
from pendpin.analysis.doctor.reading.tree import Mismatch, Node, Unread
from pendpin.errors import InputError, brief, not_one_of, shown
from pendpin.late import from_above

MOST_READINGS = 3  # of an equation that fails, whose mends are compared
FAR = 10.0  # the cost of no mend at all
MOST_HOPELESS = 10  # equations without a mend, after which two changes are no longer tried


@dataclass(frozen=True, eq=False, repr=False)
class Finding:
    """What is found about one equation. verdict: holds, fails or unread; error relative to its terms."""

    number: int
    latex: str
    place: str
    kind: str
    verdict: str
    proved: bool = False
    error: float = 0.0
    remark: str = ""
    when: str = ""
    scaling: str = ""
    dimensions: str = ""
    mends: tuple[Mend, ...] = ()
    equation: Equation | None = None

    def __repr__(self) -> str:
        return brief(f"Finding: equation {self.number}, {self.place}, {self.kind}: {self.verdict}. {self.latex}")


@dataclass(frozen=True, eq=False)
class Shared:
    """One mend that heals several equations."""

    old: str
    new: str
    numbers: tuple[int, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis:
    """Every equation with its verdict, for the pendulum that they were checked for."""

    findings: tuple[Finding, ...]
    pendulum: Pendulum
    remarks: tuple[str, ...] = ()
    shared: tuple[Shared, ...] = ()
    symbols: dict[str, Node] = field(default_factory=dict)

    @cached_property
    def harm(self) -> Any:
        """What the wrong equations do when they are solved; None where they cannot be. Computed when it is asked for."""
        return from_above("Diagnosis.harm")(self)

    @property
    def ok(self) -> bool:
        """Whether some equation could be read, and every one that could holds."""
        read = [finding for finding in self.findings if finding.verdict != "unread"]
        return bool(read) and all(finding.verdict == "holds" for finding in read)

    @property
    def wrong(self) -> tuple[Finding, ...]:
        """The equations that fail."""
        return tuple(finding for finding in self.findings if finding.verdict == "fails")

    def __repr__(self) -> str:
        found = "; ".join(f"{finding.number} {finding.verdict}" for finding in self.findings)
        return brief(
            f"Diagnosis of {len(self.findings)} equations, {len(self.wrong)} wrong: {found}; print() shows all"
        )

    def __str__(self) -> str:
        """The report as text."""
        return from_above("Diagnosis.text")(self)

    def to_json(self) -> list[dict[str, Any]]:
        """The findings for machines (docs/doctor.md)."""
        return from_above("Diagnosis.to_json")(self)


def examine(
    document: Document, rod: str | None, convention: str | None, progress: Callable[[str], object] = lambda what: None
) -> Diagnosis:
    """Check every equation of a document. Raises InputError for a rod, convention or symbol that has no meaning."""
    rod, convention = rod or document.rod, convention or document.convention
    if rod is not None and rod not in RODS:
        raise InputError(f"rod: {not_one_of(rod, RODS)}")
    symbols = read_symbols(document.symbols)
    equations = printed(document.statements, symbols)
    kind = rod or likely_rod(equations)

    base, remarks = (conventions_of(convention), []) if convention is not None else find_convention(equations, kind)
    doctor = _Doctor(Pendulum(kind, base), _styles(equations), uses_polar_angles(equations))
    findings = []
    for one in equations:
        progress(f"equation {one.number}")
        hopeless = sum(finding.verdict == "fails" and not finding.mends for finding in findings)
        findings.append(doctor.find(one, pairs=hopeless < MOST_HOPELESS))
    if rod is None and kind == "point":
        words = "These are equations of a point mass on a massless rod or string"
        remarks.insert(0, f"{words}; for a rod with mass write --rod thin.")
    if base.words:
        remarks.insert(0, f"The text has its own convention: {base.words}.")
    return Diagnosis(tuple(findings), doctor.pendulum, tuple(remarks), _shared(findings), symbols)


def read_symbols(table: dict[str, str]) -> dict[str, Node]:
    """Symbols that are given as expressions. Raises InputError."""
    found = {}
    for name, text in table.items():
        try:
            left, right = lone(name), lone(str(text))
        except Unread as error:
            raise InputError(f"symbols.{name}: {error.reason}") from None
        if left is None or left.kind != "symbol":
            raise InputError(f"symbols.{name}: {shown(name)} is not one symbol")
        if right is None:
            raise InputError(f"symbols.{name}: {shown(text)} is not one expression")
        found[left.value] = right
    return found


@dataclass(frozen=True)
class _Doctor:
    """Who examines the equations of a document: about which pendulum they are, and how the document prints quantities."""

    pendulum: Pendulum
    styles: dict[str, str]
    polar: bool  # some of its equations hold in polar angle and azimuth

    def find(self, one: Printed, pairs: bool) -> Finding:
        """The verdict on one equation, and its mends; `pairs` also looks for two changes."""
        found = Finding(one.number, one.latex, one.statement.place, "unread", "unread", remark=one.reason)
        if one.reason:
            return found
        if one.defines:
            words = f"defines {one.defines.lstrip('?')}, which is put in where it is used"
            return replace(found, kind="definition", remark=words)
        try:
            readings = candidates(one, self.pendulum)[:MOST_READINGS]
            verdict = check(readings[0][0], self.pendulum)
        except Mismatch as error:
            return self._mismatched(found, one, error.reason)
        except Unread as error:
            return replace(found, remark=error.reason)
        if not verdict.holds:
            another = of_another_motion(readings[0][0], self.polar)
            return replace(found, remark=another) if another else self._failing(found, one, readings, pairs)
        equation, remark = readings[0][0], _joined(one.remark, verdict.remark)
        found = replace(found, verdict="holds", kind=kind_of(equation), equation=equation, remark=remark)
        return replace(found, proved=verdict.proved, error=verdict.error)

    def _failing(self, found: Finding, one: Printed, readings: list[Candidate], pairs: bool) -> Finding:
        """The circumstances and mends of an equation that fails, in the reading that the simplest mend heals."""
        healed = [mends(*self._patient(one, equation, tight), pairs) for equation, tight, _ in readings]
        costs = [some[0].cost + 0.1 * rank if some else FAR + rank for rank, some in enumerate(healed)]
        best = costs.index(min(costs))
        equation, _, error = readings[best]
        return replace(
            found,
            verdict="fails",
            proved=True,
            kind=kind_of(equation),
            error=error,
            when=when(equation, self.pendulum),
            scaling=scaling(equation, self.pendulum),
            dimensions=of_equation(equation)[1],
            mends=tuple(healed[best]),
            remark=_joined(one.remark, self._special(equation)),
            equation=equation,
        )

    def _mismatched(self, found: Finding, one: Printed, reason: str) -> Finding:
        """An equation that mixes numbers and vectors: wrong if a small change makes it hold, else not read."""
        for equation, tight in list(one.readings())[:2]:
            if healed := mends_of_mismatch(*self._patient(one, equation, tight)):
                found = replace(found, verdict="fails", proved=True, error=1.0, when="in every motion")
                return replace(found, kind=kind_of(healed[0].equation), mends=tuple(healed), remark=reason)
        return replace(found, remark=reason)

    def _patient(self, one: Printed, equation: Equation, tight: bool) -> tuple[Patient, Printer]:
        """One reading of an equation, and what prints as the equation does, and else as its document."""
        latex, own = is_latex(one.text), styles_of(list(equation.sides), one.text)
        patient = Patient(equation, one.text, one.index, tight, self.pendulum, one.alone)
        return patient, Printer(latex, {**self.styles, **own} if latex else own)

    def _special(self, equation: Equation) -> str:
        """Whether an equation that fails would hold for a more special rod."""
        cases = {"symmetric": "it holds where I1 = I2", "thin": "it holds for a thin rod only"}
        cases["point"] = "it holds for a point mass on a massless rod (--rod point)"
        for special, words in cases.items():
            if RODS.index(special) < RODS.index(self.pendulum.rod):
                with suppress(Unread):
                    if check(equation, replace(self.pendulum, rod=special)).holds:
                        return words
        return ""


def _joined(*remarks: str) -> str:
    return "; ".join(filter(None, remarks))


def _styles(equations: list[Printed]) -> dict[str, str]:
    """How a document prints its quantities: as where each is seen first."""
    found: dict[str, str] = {}
    for one in reversed([one for one in equations if one.ways and is_latex(one.text)]):
        found |= styles_of(list(one.ways[0][0]), one.text)
    return found


def _shared(findings: list[Finding]) -> tuple[Shared, ...]:
    """First mends that are the same in several equations."""
    groups: dict[tuple[str, str], list[int]] = defaultdict(list)
    for finding in findings:
        for mend in finding.mends[:1]:
            if mend.old and mend.new:
                groups[mend.old, mend.new].append(finding.number)
    return tuple(Shared(*pair, tuple(numbers)) for pair, numbers in groups.items() if len(numbers) > 1)
