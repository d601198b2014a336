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
from pendpin.analysis.doctor.checking.mechanics import RODS, Convention
from pendpin.analysis.doctor.checking.residuals import Equation
from pendpin.analysis.doctor.conventions import conventions_of, find_convention, likely_rod
from pendpin.analysis.doctor.mending.mends import Mend, Patient, mends, mends_of_mismatch, styles_of
from pendpin.analysis.doctor.mending.monomials import Printer
from pendpin.analysis.doctor.patients import Candidate, Printed, candidates, kind_of, printed
from pendpin.analysis.doctor.reading.documents import Document
from pendpin.analysis.doctor.reading.grammar import parse
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
    """Every equation with its verdict, for the rod and convention that they were checked in."""

    findings: tuple[Finding, ...]
    rod: str
    convention: Convention
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
    findings = []
    for one in equations:
        progress(f"equation {one.number}")
        hopeless = sum(finding.verdict == "fails" and not finding.mends for finding in findings)
        findings.append(find(one, kind, base, _styles(equations), pairs=hopeless < MOST_HOPELESS))
    if base.words:
        remarks.insert(0, f"The text has its own convention: {base.words}.")
    return Diagnosis(tuple(findings), kind, base, tuple(remarks), _shared(findings), symbols)


def read_symbols(table: dict[str, str]) -> dict[str, Node]:
    """Symbols that are given as expressions. Raises InputError."""
    found = {}
    for name, text in table.items():
        try:
            left, right = parse(name), parse(str(text))
        except Unread as error:
            raise InputError(f"symbols.{name}: {error.reason}") from None
        if len(left) != 1 or len(left[0]) != 1 or left[0][0].kind != "symbol":
            raise InputError(f"symbols.{name}: {shown(name)} is not one symbol")
        if len(right) != 1 or len(right[0]) != 1:
            raise InputError(f"symbols.{name}: {shown(text)} is not one expression")
        found[left[0][0].value] = right[0][0]
    return found


def find(one: Printed, rod: str, convention: Convention, styles: dict[str, str], pairs: bool = True) -> Finding:
    """The verdict on one equation, and its mends; `pairs` also looks for two changes."""
    place = one.statement.place
    unread = Finding(one.number, one.latex, place, "unread", "unread", remark=one.reason)
    if one.reason:
        return unread
    if one.defines:
        return replace(
            unread, kind="definition", remark=f"defines {one.defines.lstrip('?')}, which is put in where it is used"
        )
    try:
        readings = candidates(one, rod, convention)[:MOST_READINGS]
        verdict = check(readings[0][0], rod, convention)
    except Mismatch as error:
        return _mismatched(unread, one, rod, convention, styles, error.reason)
    except Unread as error:
        return replace(unread, remark=error.reason)
    if not verdict.holds:
        return _failing(unread, one, readings, rod, convention, styles, pairs)
    remark = "; ".join(filter(None, (one.remark, verdict.remark)))
    kind = kind_of(readings[0][0])
    return replace(
        unread,
        verdict="holds",
        kind=kind,
        proved=verdict.proved,
        error=verdict.error,
        remark=remark,
        equation=readings[0][0],
    )


def _failing(
    unread: Finding,
    one: Printed,
    readings: list[Candidate],
    rod: str,
    convention: Convention,
    styles: dict[str, str],
    pairs: bool,
) -> Finding:
    """The circumstances and mends of an equation that fails, in the reading that the simplest mend heals."""
    found = [_mends(one, equation, tight, rod, convention, styles, pairs) for equation, tight, _ in readings]
    costs = [healed[0].cost + 0.1 * rank if healed else FAR + rank for rank, healed in enumerate(found)]
    best = costs.index(min(costs))
    equation, _, error = readings[best]
    return replace(
        unread,
        verdict="fails",
        proved=True,
        kind=kind_of(equation),
        error=error,
        when=when(equation, rod, convention),
        scaling=scaling(equation, rod, convention),
        dimensions=of_equation(equation)[1],
        mends=tuple(found[best]),
        remark="; ".join(filter(None, (one.remark, _special(equation, rod, convention)))),
        equation=equation,
    )


def _mends(
    one: Printed, equation: Equation, tight: bool, rod: str, convention: Convention, styles: dict[str, str], pairs: bool
) -> list[Mend]:
    """The mends of one reading of an equation."""
    patient = Patient(equation, one.text, one.index, tight, rod, convention, one.alone)
    return mends(patient, _printer(one, equation, styles), pairs)


def _printer(one: Printed, equation: Equation, styles: dict[str, str]) -> Printer:
    """What prints as an equation does, and else as its document."""
    latex = is_latex(one.text)
    own = styles_of(list(equation.sides), one.text)
    return Printer(latex, {**styles, **own} if latex else own)


def _mismatched(
    unread: Finding, one: Printed, rod: str, convention: Convention, styles: dict[str, str], reason: str
) -> Finding:
    """An equation that mixes numbers and vectors: wrong if a small change makes it hold, else not read."""
    for equation, tight in list(one.readings())[:2]:
        patient = Patient(equation, one.text, one.index, tight, rod, convention, one.alone)
        if found := mends_of_mismatch(patient, _printer(one, equation, styles)):
            verdict = replace(unread, verdict="fails", proved=True, error=1.0, when="in every motion", remark=reason)
            return replace(verdict, kind=kind_of(found[0].equation), mends=tuple(found))
    return replace(unread, remark=reason)


def _special(equation: Equation, rod: str, convention: Convention) -> str:
    """Whether an equation that fails would hold for a more special rod."""
    cases = {"thin": "it holds for a thin rod only", "symmetric": "it holds where I1 = I2"}
    for special, words in reversed(cases.items()):
        if RODS.index(special) < RODS.index(rod):
            with suppress(Unread):
                if check(equation, special, convention).holds:
                    return words
    return ""


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
