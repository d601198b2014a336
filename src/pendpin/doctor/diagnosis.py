"""The doctor's main line: a document in, a verdict and mends for each of its equations out."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import islice, product
from typing import Any

import numpy as np

from pendpin.doctor.checking.check import check, is_general, quantity_of, when
from pendpin.doctor.checking.conditions import (
    PIVOT,
    ROUGHLY,
    TINY,
    holds_if,
    is_identity,
    loads_at_zero,
    loads_in_words,
    may_be_linear,
    without,
)
from pendpin.doctor.checking.residuals import TOLERANCE, Equation, holds, of_equation, relative_error
from pendpin.doctor.checking.solutions import solved
from pendpin.doctor.letters import MOST_LOADS
from pendpin.doctor.mending.changes import Patient
from pendpin.doctor.mending.mends import mends, mends_of_definition, styles_of
from pendpin.doctor.mending.writing import Writer
from pendpin.doctor.printed import Candidate, Printed, candidates, kind_of
from pendpin.doctor.reading.documents import Document
from pendpin.doctor.reading.names import CONSTANTS, bound
from pendpin.doctor.reading.states import dampings
from pendpin.doctor.reading.tokens import is_latex
from pendpin.doctor.reading.tree import Mismatch, Unread, key, names_in
from pendpin.doctor.recognition import REMEDY, Reading, read
from pendpin.doctor.report import Diagnosis, Finding
from pendpin.doctor.systems.base import System, random_states
from pendpin.doctor.systems.tables import FAMILIES
from pendpin.doctor.verdicts import judge

MOST_READINGS = 3  # of an equation that fails, whose mends are compared
SMALL_SWINGS = "the angles are small, to the first order"
FAR = 10.0  # the cost of no mend at all
MOST_HOPELESS = 5  # equations without a mend, after which two changes are no longer tried


@np.errstate(all="ignore")  # what has no value, as 0 times infinite, is said not to have one
def examine(document: Document, choices: dict[str, Any], progress: Callable[[str], object]) -> Diagnosis:
    """Check every equation of a document. Raises InputError for a rod, convention or symbol that has no meaning."""
    found = read(document, choices)
    equations = found.equations
    styles: dict[bool, dict[str, str]] = {True: {}, False: {}}
    for one in reversed([one for one in equations if one.ways]):  # quantities are printed as where each is seen first
        styles[is_latex(one.text)] |= styles_of(one, one.sides)
    doctors = {id(reading): _Doctor(reading, styles) for reading in (found.main, *found.chosen)}
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
        hopeless = sum(finding.doubtful for finding in findings)
        if tried[i]:
            progress(f"equation {one.number}")
            findings[i] = doctor.second(findings[i], one, tried[i], hopeless < MOST_HOPELESS)
        elif sisters := doctor.as_sister(one):
            finding = doctor.second(findings[i], one, sisters, False)
            findings[i] = finding if finding.verdict == "fails" else findings[i]
    for doctor in doctors.values():
        findings = doctor.through_definitions(findings)
    findings = tuple(judge(findings, found))
    wrong = found.main.unknown and any(finding.verdict == "fails" for finding in findings)
    title, remarks = (found.main.system.spec.title, ()) if wrong else (found.title, found.main.remarks)
    return Diagnosis(findings, found.main.system, title, remarks, document.skipped)


@dataclass(frozen=True)
class _Doctor:
    """Who examines the equations that one reading explains, and knows how the document prints quantities."""

    reading: Reading
    styles: dict[bool, dict[str, str]]  # in LaTeX, and in plain text
    neighbours: list[Equation] = field(default_factory=list)  # those that hold in this reading
    quantities: dict[str, str] = field(default_factory=dict)  # what definitions come to, by the names of these

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
        if solution := solved(one, self.reading.equations, self.system):
            equation, number = solution
            said = {"condition": SMALL_SWINGS, "remark": f"it solves equation {number}", "equation": equation}
            return replace(found, verdict="holds if", kind="solution", **said), []
        quantity = quantity_of(one, self.system)
        if quantity:  # a letter may mean in it what it means in no equation that holds, but something else there
            used = {pair for other in self.neighbours for pair in other.meanings.items() if pair[0] in other.names}
            own = {(name, meaning) for name, meaning in quantity[1].meanings.items() if name != meaning}
            quantity = None if any((name, name) in used for name, _ in own - used) else quantity
        if quantity:
            self.quantities[one.defines] = quantity[0]
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
            found = replace(found, verdict="holds", proved=proved, equation=equation, error=error)
            return replace(found, remark=one.remark), []
        if not equation.names - {"pi"}:
            return replace(found, kind="condition", remark="it is about numbers alone: nothing to check"), []
        if said:
            return replace(found, kind="condition", remark=said), []
        return found, readings

    def as_sister(self, one: Printed) -> list[Candidate]:
        """The readings of a definition as what its name says: acc1 beside an acc2 that is the second acceleration."""
        name = one.defines
        if not name or name in self.quantities or any(name in names_in(other.sides, {}) for other in self.neighbours):
            return []
        tables = str.maketrans("12", "21"), str.maketrans("xyXY", "yxYX")
        known = ((self.quantities.get(name.translate(table), ""), table) for table in tables)
        meant = next((quantity.translate(table) for quantity, table in known if quantity), "")
        if len(one.sides) != 2 or meant not in random_states(self.system) or meant in self.quantities.values():
            return []
        named = (replace(equation, meanings=equation.meanings | {name: meant}) for equation in one.meant)
        with suppress(Unread):
            return [(e, relative_error(e, random_states(self.system))) for e in islice(named, MOST_READINGS)]
        return []

    def second(self, found: Finding, one: Printed, readings: list[Candidate], pairs: bool) -> Finding:
        """The verdict on an equation of which no reading holds: it fails if a small change mends it."""
        readings, spec = readings[:MOST_READINGS], self.system.spec
        context = f"{one.statement.before} {one.statement.after}"
        likely = [equation for equation, _ in readings]
        known = [equation.meanings for equation in likely]  # another rod may have what this one lacks, as a radius
        every = (*likely, *(equation for equation in one.readings() if equation.meanings not in known))
        sound = [equation for equation in every if not of_equation(equation, spec)[1]]
        # of a system that nothing shows, conditions say nothing
        for equation in () if self.reading.unknown else sound or every:
            only_stated = self.reading.chosen or equation not in likely
            if condition := holds_if(equation, self.system, context, self.neighbours, only_stated):
                healed = tuple(mends(self._patient(one, equation), False))
                said = {"condition": condition, "equation": equation, "mends": healed, "remark": one.remark}
                return replace(found, verdict="holds if", **said)
        if ROUGHLY.search(one.latex):
            return replace(found, remark="it says itself that it is not exact")
        healed = [mends(self._patient(one, equation), pairs) for equation, _ in readings]
        swings = [] if any(healed) else [pair for pair in readings if may_be_linear(pair[0], self.system)]
        family = FAMILIES.get(spec.kind.split()[0], ()) if swings else ()
        near = [replace(self.system, spec=one, scale=TINY) for one in (spec, *family)]
        if swings and not any(holds(equation, random_states(one)) for (equation, _), one in product(swings, near)):
            doctor = replace(self, reading=replace(self.reading, system=near[0]))  # which nothing alike explains either
            readings, healed = swings, [mends(doctor._patient(one, equation), False) for equation, _ in swings]
            found = replace(found, remark="read as a law of small angles" * any(healed))
        costs = [some[0].cost + 0.1 * rank if some else FAR + rank for rank, some in enumerate(healed)]
        best = costs.index(min(costs))
        equation, error = readings[best]
        remarks = [one.remark, found.remark]
        for convention in self.reading.conventions:  # that would make it right
            if holds(equation, random_states(replace(self.system, convention=convention))):
                remarks.append(f"it holds if {convention.words}")
                break
        said = {"error": error, "when": when(equation, self.system), "dimensions": of_equation(equation, spec)[1]}
        found = replace(found, **said, equation=equation)
        one_or_sound = (m for m in healed[best] if m.count == 1 or not of_equation(m.equation, spec)[1])
        if right := tuple(one_or_sound):
            remark = "; ".join(filter(None, remarks))
            return replace(found, verdict="fails", proved=True, mends=right, remark=remark)
        if self.reading.unknown:
            words = f"it does not hold for {spec.title}, and nothing says that it is meant to: {REMEDY}"
            return replace(found, remark=words)
        words = f"as I read it, for {spec.title}, it does not hold, and no small change makes it hold"
        return replace(found, remark="; ".join(filter(None, (words, *remarks))))

    def _with_loads(self, found: Finding, equation: Equation, loads: set[str], condition: str) -> Finding:
        """The verdict on an equation that holds under the `condition` that some loads are 0."""
        small = condition.rpartition(" and ")[2] if "small" in condition else ""
        linear = small and any(side.kind == "matrix" for side in equation.sides)  # of which nothing tells a load
        testable = not (linear or all(map(PIVOT.match, loads)))
        words = loads_in_words(equation, self.system, loads, TINY if small else 1.0) if testable else None
        if words:
            said = {"verdict": "holds if", "condition": small} if small else {"verdict": "holds"}
            return replace(found, **said, remark=words, equation=without(equation, loads))
        if words is None:
            return replace(found, verdict="holds if", condition=condition, equation=without(equation, loads))
        names = " and ".join(sorted(name.lstrip("?") for name in loads))
        remark = f"it holds where {condition}, but {names} acts as no damping, spring or drive that I know"
        return replace(found, remark=remark, unknown=tuple(sorted(loads)))

    def through_definitions(self, findings: list[Finding]) -> list[Finding]:
        """The findings, where wrong equations have the mends of a definition that they use if these are likelier.

        A definition with which another equation holds is right.
        """
        findings = [*findings]
        for source in (one for one in self.reading.equations if one.defines and len(one.sides) == 2):
            name, own = source.defines, next(key(side) for side in source.sides if side.value != source.defines)
            using = [
                i
                for i, finding in enumerate(findings)
                if finding.kind != "definition"
                and (equation := finding.equation)
                and name in equation.definitions
                and key(equation.definitions[name]) == own
                and name in names_in(equation.sides, equation.definitions)
            ]
            wrong = [f.equation for f in map(findings.__getitem__, using) if f.equation and f.when]
            if not wrong or len(wrong) < len(using):
                continue
            source = replace(source, words=self.reading.words)
            writer = self._patient(source, Equation(source.sides)).writer
            tried = (mends_of_definition(one, source, wrong, self.system, writer) for one in wrong[:MOST_READINGS])
            if healed := next(filter(None, tried), []):
                for i in using:
                    if not findings[i].mends or healed[0].cost < findings[i].mends[0].cost:
                        said = {"mends": tuple(healed), "remark": "", "follows": source.number}
                        findings[i] = replace(findings[i], verdict="fails", proved=True, **said)
        return findings

    def _unread(self, found: Finding, one: Printed, reason: str) -> tuple[Finding, list[Candidate]]:
        """An equation that has no value: it may define a symbol, or hold where an unknown load is 0."""
        lacking, name = one.lacking, one.defines.lstrip("?")
        constant = bool(lacking) and not (one.defines or one.strange_rates)  # for all that the text shows
        if constant and is_identity(next(one.readings()), self.system):
            return replace(found, verdict="holds", kind="identity", remark="it is true whatever its letters mean"), []
        loads = set[str]().union(*(o.lacking for o in self.reading.equations if o.names & {*self.system.spec.unknowns}))
        if one.defines and not one.unknown - {one.defines} - loads:
            return replace(found, verdict="holds", kind="definition", remark=f"it says what {name} is"), []
        if one.defines and not any(one.defines in o.names for o in self.reading.equations if o.number != one.number):
            idle = f"no other equation uses {name}: say which quantity it is with --symbols {name}=..."
            return replace(found, kind="definition", remark=idle, unknown=(one.defines,)), []
        without_loads = list[Finding]()
        for equation in one.readings() if len(lacking) <= MOST_LOADS and not one.defines else ():
            if condition := loads_at_zero(equation, self.system, lacking):
                loaded = replace(found, kind="equation of motion")
                without_loads.append(self._with_loads(loaded, equation, lacking, condition))
        if without_loads:  # in b/(2 m L^2) L is a length, as b is a damping then
            return next((one for one in without_loads if one.verdict != "not checked"), without_loads[0]), []
        # with a load a small change may make it hold where the load is 0, as another of the text that shows the load does
        others = (o for o in self.reading.equations if o.lacking == lacking and not o.defines)
        alike = (
            condition
            for equation in (equation for other in others for equation in other.readings())
            if (condition := loads_at_zero(equation, self.system, lacking))
            and loads_in_words(equation, self.system, lacking)
        )
        rates = dampings([other.sides for other in self.reading.equations])  # or what multiplies rates alone
        rates = {f"?{'_'.join(name).rstrip('_')}" for name in rates}
        quiet = " and ".join(f"{name.lstrip('?')} = 0" for name in sorted(lacking)) if lacking <= rates else ""
        known = not one.defines and lacking and (quiet or not self.reading.unknown)
        if known and (condition := next(alike, quiet)):
            equation = without(next(one.readings()), lacking)
            with suppress(Unread):
                remark = f"compared where {condition}"
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

    def _patient(self, one: Printed, equation: Equation) -> Patient:
        """One reading of an equation, printed as the equation is, and else as its document."""
        own = styles_of(one, equation.sides)
        latex = is_latex(one.text) or ("*" not in one.text and any(map(is_latex, self.styles[True].values())))
        writer = Writer(one.text, latex, {**self.styles[latex], **own}, self.system.spec)
        return Patient(replace(one, words=self.reading.words), equation, self.system, writer)
