"""The doctor's main line: a document in, a verdict and mends for each of its equations out."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from typing import Any

import numpy as np

from pendpin.doctor.checking.check import bare, check, in_use, is_general, quantity_of, when
from pendpin.doctor.checking.conditions import (
    PIVOT,
    ROUGHLY,
    SAID_SMALL,
    holds_as_stated,
    holds_if,
    loads_at_zero,
    loads_in_words,
    may_be_linear,
    small_angles,
    without,
)
from pendpin.doctor.checking.residuals import TOLERANCE, Equation, holds, of_equation, relative_error
from pendpin.doctor.letters import MOST_LOADS
from pendpin.doctor.mending.changes import Patient
from pendpin.doctor.mending.mends import Mend, mends, mends_of_definition, styles_of
from pendpin.doctor.mending.writing import Writer
from pendpin.doctor.printed import Candidate, Printed, candidates, holding, kind_of
from pendpin.doctor.reading.documents import Document
from pendpin.doctor.reading.names import CONSTANTS, bound
from pendpin.doctor.reading.tokens import is_latex
from pendpin.doctor.reading.tree import Mismatch, Unread, parts, symbols, with_meaning
from pendpin.doctor.recognition import REMEDY, Reading, read
from pendpin.doctor.report import Diagnosis, Finding
from pendpin.doctor.systems.base import System, linearised, random_states
from pendpin.doctor.verdicts import judge

MOST_READINGS = 3  # of an equation that fails, whose mends are compared
FAR = 10.0  # the cost of no mend at all
MOST_HOPELESS = 5  # equations without a mend, after which two changes are no longer tried


@np.errstate(all="ignore")  # what has no value, as 0 times infinite, is said not to have one
def examine(document: Document, choices: dict[str, Any], progress: Callable[[str], object]) -> Diagnosis:
    """Check every equation of a document. Raises InputError for a rod, convention or symbol that has no meaning."""
    found = read(document, choices)
    equations = found.equations
    used = in_use(equations, [reading.system for reading in found.chosen])
    styles: dict[bool, dict[str, str]] = {True: {}, False: {}}
    for one in reversed([one for one in equations if one.ways]):  # quantities are printed as where each is seen first
        styles[is_latex(one.text)] |= styles_of(one, one.sides)
    doctors = {id(reading): _Doctor(reading, styles, used) for reading in (found.main, *found.chosen)}
    pairs = [(doctors[id(reading)], one) for reading, one in zip(found.chosen, equations, strict=True)]
    findings, tried = list[Finding](), list[list[Candidate]]()
    for doctor, one in pairs:
        progress(f"equation {one.number}")
        finding, readings = doctor.first(one)
        findings.append(finding)
        tried.append(readings)
        if finding.verdict == "holds" and finding.kind != "definition" and finding.equation:
            doctor.neighbours.append(finding.equation)
    for i, (doctor, one) in enumerate(pairs):
        if tried[i]:
            progress(f"equation {one.number}")
            hopeless = sum(finding.doubtful for finding in findings)
            findings[i] = doctor.second(findings[i], one, tried[i], hopeless < MOST_HOPELESS)
    findings = [doctor.through_definitions(one, findings) for (doctor, _), one in zip(pairs, findings, strict=True)]
    findings = tuple(judge(findings, found))
    wrong = found.main.unknown and any(finding.verdict == "fails" for finding in findings)
    title, remarks = (found.main.system.spec.title, ()) if wrong else (found.title, found.main.remarks)
    return Diagnosis(findings, found.main.system, title, remarks, document.skipped)


@dataclass(frozen=True)
class _Doctor:
    """Who examines the equations that one reading explains, and knows how the document prints quantities."""

    reading: Reading
    styles: dict[bool, dict[str, str]]  # in LaTeX, and in plain text
    in_use: set[str]  # the symbols that the laws of the text use, also through definitions
    neighbours: list[Equation] = field(default_factory=list)  # those that hold in this reading
    healed: dict[tuple[str, int], list[Mend]] = field(
        default_factory=dict
    )  # mends of definitions, by name and equation

    @property
    def system(self) -> System:
        """What the equations are about."""
        return self.reading.system

    def first(self, one: Printed) -> tuple[Finding, list[Candidate]]:
        """The verdict on an equation, or its readings where none holds."""
        found = Finding(one.number, one.latex, one.statement.place, "unread", "not checked", remark=one.reason)
        if one.reason:
            return found, []
        general = any(is_general(equation, self.system) for equation in islice(one.readings(), MOST_READINGS))
        if general or self._names_energies(one):
            return replace(found, verdict="holds", kind="law", remark="it is true of every system"), []
        if quantity := quantity_of(one, self.system):
            words = f"it is {self.system.spec.printed.get(quantity[0], quantity[0])}"
            equation = replace(quantity[1], sides=(one.sides[1], one.sides[1]))
            return replace(found, verdict="holds", kind="relation", remark=words, equation=equation), []
        said = self.reading.says(one)
        try:
            readings = candidates(one, self.system)
            right, proved, error = check(readings[0][0], self.system)
        except Unread as unread:
            if said:
                return replace(found, kind="condition", remark=said), []
            if isinstance(unread, Mismatch):
                return replace(found, remark=unread.reason), []
            return self._unread(found, one, unread.reason)
        equation = readings[0][0]
        found = replace(found, kind="definition" if one.defines else kind_of(equation, self.system.spec))
        if right:
            if idle := self._idle(one):
                return replace(found, remark=idle, unknown=(one.defines,)), []
            found = replace(found, verdict="holds", proved=proved, equation=equation, error=error)
            return replace(found, remark=one.remark), []
        if equation.names <= set(self.system.spec.state) and said:
            return replace(found, kind="condition", remark=said), []
        if not equation.names - {"pi"}:
            return replace(found, kind="condition", remark="it is about numbers alone: nothing to check"), []
        for reading in one.readings():
            if condition := holds_as_stated(reading, self.system, one.statement.context):
                found = replace(found, verdict="holds if", condition=condition, equation=reading, remark=one.remark)
                return found, []
        if said:
            return replace(found, kind="condition", remark=said), []
        return found, readings

    def second(self, found: Finding, one: Printed, readings: list[Candidate], pairs: bool) -> Finding:
        """The verdict on an equation of which no reading holds: it fails if a small change mends it."""
        readings = readings[:MOST_READINGS]
        for equation, _ in readings:
            if held := self._holds_without_loads(replace(found, remark=one.remark), equation):
                return held
            if self.reading.unknown:  # a condition of a system that nothing shows says nothing
                continue
            if condition := holds_if(equation, self.system, self.neighbours, self.reading.chosen):
                healed = tuple(mends(self._patient(one, equation), False))
                found = replace(found, verdict="holds if", condition=condition, equation=equation)
                return replace(found, mends=healed, remark=one.remark)
        if ROUGHLY.search(one.latex):
            return replace(found, remark="it says itself that it is not exact")
        system = self._to_first_order(one) or self.system
        healed = [mends(self._patient(one, equation, system), pairs) for equation, _ in readings]
        costs = [some[0].cost + 0.1 * rank if some else FAR + rank for rank, some in enumerate(healed)]
        best = costs.index(min(costs))
        equation, error = readings[best]
        remarks = [one.remark, found.remark]
        if linear := system is not self.system:
            remarks.append("it is compared to the first order in the angles")
            error = relative_error(equation, random_states(system))
        for convention in self.reading.conventions:  # that would make it right
            if holds(equation, random_states(replace(self.system, convention=convention))):
                remarks.append(f"it holds if {convention.words}")
                break
        said = {"error": error, "when": when(equation, system), "dimensions": of_equation(equation, system.spec)[1]}
        found = replace(found, **said, equation=equation, linear=linear)
        one_or_sound = (m for m in healed[best] if m.count == 1 or not of_equation(m.equation, self.system.spec)[1])
        if right := tuple(one_or_sound):
            remark = "; ".join(filter(None, remarks))
            return replace(found, verdict="fails", proved=not linear, mends=right, remark=remark)
        if self.reading.unknown:
            words = f"it does not hold for {system.spec.title}, and nothing says that it is meant to: {REMEDY}"
            return replace(found, remark=words)
        words = f"as I read it, for {system.spec.title}, it does not hold, and no small change makes it hold"
        return replace(found, remark="; ".join(filter(None, (words, *remarks))))

    def _holds_without_loads(self, found: Finding, equation: Equation) -> Finding | None:
        """The verdict on an equation that holds without one letter, such as a damping b, if no other that holds has it."""
        known = {part.written for other in self.neighbours for part in parts(other.sides)}
        nodes = (node for node in parts(equation.sides) if node.kind == "symbol")
        letters = {node.written: equation.meaning(str(node.value)) for node in nodes}
        for written, meaning in letters.items():
            if written and written not in known and meaning in self.system.spec.still:
                letter = f"?{written.letter}_{written.index}".rstrip("_")
                own = replace(equation, sides=tuple(with_meaning(side, written, letter) for side in equation.sides))
                sure = [*letters.values()].count(meaning) > 1  # beside m, M(t) is no mass
                if condition := loads_at_zero(own, self.system, {letter}, sure):
                    return self._with_loads(found, own, {letter}, condition)
        return None

    def _with_loads(self, found: Finding, equation: Equation, loads: set[str], condition: str) -> Finding:
        """The verdict on an equation that holds under the `condition` that some loads are 0."""
        told = "small" not in condition and not all(map(PIVOT.match, loads))
        words = loads_in_words(equation, self.system, loads) if told else None
        if words:
            return replace(found, verdict="holds", remark=words, equation=without(equation, loads))
        if words is None:
            return replace(found, verdict="holds if", condition=condition, equation=without(equation, loads))
        names = " and ".join(sorted(name.lstrip("?") for name in loads))
        remark = f"it holds where {condition}, but {names} acts as no damping, spring or drive that I know"
        return replace(found, remark=remark, unknown=tuple(sorted(loads)))

    def through_definitions(self, found: Finding, findings: list[Finding]) -> Finding:
        """The finding of a wrong equation, with mends of a definition that it uses where those are likelier.

        A definition with which another equation holds is right.
        """
        if not found.when or found.equation is None:
            return found
        inside = lambda equation: set().union(*map(symbols, equation.sides))  # noqa: E731
        for name in sorted(found.equation.definitions.keys() & inside(found.equation)):
            using = [f for f in findings if f.equation and f.kind != "definition" and name in inside(f.equation)]
            sources = [one for one in self.reading.equations if one.defines == name and len(one.sides) == 2]
            sources = [replace(one, words=self.reading.words) for one in sources]
            if len(sources) != 1 or not all(f.when for f in using):
                continue
            wrong = [f.equation for f in (*using, found) if f.equation]
            writer = self._patient(sources[0], Equation(sources[0].sides)).writer
            healed = list[Mend]()
            for one in wrong[:MOST_READINGS]:  # each of these is tried once for all that use the definition
                if (mark := (name, id(one))) not in self.healed:
                    self.healed[mark] = mends_of_definition(one, sources[0], wrong, self.system, writer)
                if healed := self.healed[mark]:
                    break
            if healed and (not found.mends or healed[0].cost < found.mends[0].cost):
                found = replace(found, verdict="fails", proved=True, mends=tuple(healed), remark="")
                found = replace(found, follows=sources[0].number)
        return found

    def _unread(self, found: Finding, one: Printed, reason: str) -> tuple[Finding, list[Candidate]]:
        """An equation that has no value: it may define a symbol, or hold where an unknown load is 0."""
        lacking, name = one.lacking, one.defines.lstrip("?")
        if idle := self._idle(one):
            return replace(found, kind="definition", remark=idle, unknown=(one.defines,)), []
        if one.defines and not one.unknown - {one.defines}:
            return replace(found, verdict="holds", kind="definition", remark=f"it says what {name} is"), []
        for equation in one.readings() if len(lacking) <= MOST_LOADS and not one.defines else ():
            if condition := loads_at_zero(equation, self.system, lacking):
                return self._with_loads(replace(found, kind="equation of motion"), equation, lacking, condition), []
        # with a load a small change may make it hold where the load is 0, as another of the text holds there
        others = [o for o in self.reading.equations if o is not one and o.lacking == lacking and not o.defines]
        alike = (loads_at_zero(e, self.system, lacking) for o in others for e in o.readings())
        if not one.defines and lacking and not self.reading.unknown and (condition := next(filter(None, alike), "")):
            equation = without(next(one.readings()), lacking)
            with suppress(Unread):
                remark = f"compared where {condition}, as another equation holds"
                if (error := relative_error(equation, random_states(self.system))) > TOLERANCE:
                    return replace(found, kind="equation of motion", remark=remark), [(equation, error)]
        return replace(found, remark=reason, unknown=tuple(sorted(one.unknown))), []

    def _names_energies(self, one: Printed) -> bool:
        """Whether it only gives energies their names, as L = T - U, whatever the text takes T and U to be."""
        terms = [term for side in one.sides for term in (side.children if side.kind == "sum" else (side,))]
        if one.names & CONSTANTS or any(term.kind != "symbol" for term in terms):
            return False
        words = replace(self.reading.words, chosen={})
        equation = Equation(tuple(bound(side, words) for side in one.sides))
        readings = (e for e in equation.readings(words) if e.names <= {"T", "V", "L", "E"} and len(e.names) > 2)
        return any(holds(e, random_states(self.system)) for e in readings)

    def _idle(self, one: Printed) -> str:
        """What to write of a symbol that an equation defines and nothing uses, so that nothing tells whether it is right."""
        name = one.defines.lstrip("?")
        idle = bool(name) and len(one.sides) == 2 and bare(one.defines) not in self.in_use
        return f"no other equation uses {name}: say which quantity it is with --symbols {name}=..." if idle else ""

    def _to_first_order(self, one: Printed) -> System | None:
        """The system for small angles, for an equation that may be meant so: the text says it, or another one holds so."""
        system, may = self.system, may_be_linear(next(one.readings()), self.system)
        if not (may and system.spec.analytic and (SAID_SMALL.search(one.statement.context) or self._has_linear)):
            return None
        return replace(system, spec=linearised(system.spec))

    @cached_property
    def _has_linear(self) -> bool:
        """Whether an equation of the text holds for small angles, and not in general."""
        others = (one for one in self.reading.equations if one.ways and not holding(one, self.system))
        return any(small_angles(equation, self.system) for one in others for equation in one.readings())

    def _patient(self, one: Printed, equation: Equation, system: System | None = None) -> Patient:
        """One reading of an equation, printed as the equation is, and else as its document."""
        own = styles_of(one, equation.sides)
        latex = is_latex(one.text) or ("*" not in one.text and any(map(is_latex, self.styles[True].values())))
        writer = Writer(one.text, latex, {**self.styles[latex], **own}, self.system.spec)
        return Patient(replace(one, words=self.reading.words), equation, system or self.system, writer)
