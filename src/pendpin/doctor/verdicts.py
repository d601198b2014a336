"""The verdicts on a document once each of its equations has one: what they say of each other.

An accusation needs a reading that other equations bear out: they hold with it, and use the same letters. No other reading
may explain the section as well. A definition is right where an equation that holds uses it.
"""

from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from pendpin.doctor.checking.check import euler_lagrange
from pendpin.doctor.checking.evaluation import evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, Equation, relative_error, residuals, stack_residuals
from pendpin.doctor.findings import Finding
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Node, Unread, key, symbols
from pendpin.doctor.recognition import FEW, Reading, Recognition
from pendpin.doctor.systems.base import Spec, System, free_states, random_states
from pendpin.doctor.systems.rod import RODS

EQUALLY = 0.3  # equations: readings that explain about as much
RATIO = 1e-7  # of two residuals that are multiples of each other: of second derivatives eight digits are left
MOST_STRANGE = 1  # letters of an accused equation that no equation which holds has


def judge(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings of a document, weighed against each other."""
    findings = _definitions(_doubted(findings, found), found)
    return _linked(_borne_out(_unsupported(findings, found), found), found)


def _dropped(finding: Finding, words: str) -> Finding:
    """A finding that is no accusation after all."""
    return replace(finding, verdict="not checked", remark=words, mends=(), proved=False)


@dataclass(frozen=True)
class _Evidence:
    """The laws of a document that hold for one system, with how its points move, the quantities, and who is accused.

    How points move confirms how others do, and no balance or energy.
    """

    laws: int
    motions: int  # the laws and the equations on how points move
    names: frozenset[str]
    accused: int

    def objection(self, finding: Finding, one: Printed, spec: Spec) -> str:
        """Why an equation is not accused though it does not hold; empty where it is."""
        if all(side.kind == "symbol" for side in one.sides) and not one.names & spec.still:
            return "it says what a name stands for"
        if one.latex.lstrip(" &").startswith("+"):
            return "it goes on from what stands before it"
        names = all(_is_of_names(side) for side in one.sides) and any(side.kind == "sum" for side in one.sides)
        if names and not (finding.mends and "sign" in finding.mends[0].words):
            return "it is a formula in general"
        energies = [side for side in one.sides if side.value in ("T", "V", "E", "L")]
        if energies and all(symbols(side) <= spec.still for side in one.sides if side not in energies):
            return "it is a formula in general"
        assert finding.equation is not None
        support = self.laws if _is_law(finding.equation, spec) else self.motions
        if not self.laws:
            return f"as I read it, for {spec.title}, it does not hold; but no other equation shows that it is meant so"
        if self.accused > 2 * support + 1:
            return f"as I read it, for {spec.title}, it does not hold; but too many others do not hold either"
        strange = _quantities(finding.equation, spec) - self.names
        if len(strange) > MOST_STRANGE and spec.kind not in RODS:
            return f"it does not hold, but no equation that holds confirms what {', '.join(sorted(strange))} is"
        return ""


def _is_of_names(node: Node) -> bool:
    """Whether an expression is a sum of names, as T - V."""
    return node.kind == "symbol" or (node.kind == "sum" and all(part.kind == "symbol" for part in node.children))


def _is_law(equation: Equation, spec: Spec) -> bool:
    """Whether an equation is about more than how points move: a mass, a force, an energy or gravity is in it."""
    names = equation.names
    return bool(names & {*spec.parameters}) and any(
        name == "g" or spec.dimensions.get(name, (0, 0, 0))[0] for name in names
    )


def _quantities(equation: Equation, spec: Spec) -> frozenset[str]:
    """The coordinates and parameters in an equation."""
    return frozenset(equation.names & {*spec.parameters, *spec.coordinates})


def _borne_out(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, without accusations of what no other equation of the document bears out."""
    if found.main.chosen:
        return findings
    evidence: dict[str, _Evidence] = {}
    for kind in {reading.system.kind for reading in found.chosen}:
        here = [f for f, reading in zip(findings, found.chosen, strict=True) if reading.system.kind == kind]
        laws = [
            f.equation for f in here if f.verdict in ("holds", "holds if") and f.kind != "definition" and f.equation
        ]
        spec = next(reading.system.spec for reading in found.chosen if reading.system.kind == kind)
        telling = [one for one in laws if _quantities(one, spec) & {*spec.parameters}]
        names = frozenset().union(*(_quantities(one, spec) for one in telling))
        count = sum(_is_law(one, spec) for one in telling)
        accused = {f.mends[0].words if f.mends else f.latex for f in here if f.verdict == "fails"}
        evidence[kind] = _Evidence(count, len(telling), names, len(accused))
    answers, few = [], sum(1 for one in found.equations if one.ways) < FEW
    for finding, one, reading in zip(findings, found.equations, found.chosen, strict=True):
        spec = reading.system.spec
        if finding.verdict == "fails" and finding.equation and not (few and spec.kind in RODS):
            own = _follows(finding.equation, found, reading.system, findings) or _of_another(one, found, reading)
            words = own or evidence[spec.kind].objection(finding, one, spec)
            finding = _dropped(finding, words) if words else finding
        answers.append(finding)
    return answers


def _linked(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, where a wrong equation that follows from an earlier wrong one says so."""
    wrong: list[tuple[Finding, Printed]] = []
    answers = []
    for finding, one, reading in zip(findings, found.equations, found.chosen, strict=True):
        if finding.verdict == "fails" and finding.equation and not finding.linear:
            source = next((f for f, o in wrong if _is_consequence(finding.equation, f, o, reading.system)), None)
            finding = replace(finding, follows=source.number) if source else finding
            wrong += [] if source else [(finding, one)]
        answers.append(finding)
    return answers


def _is_consequence(equation: Equation, source: Finding, printed: Printed, system: System) -> bool:
    """Whether what an equation is off by is what an earlier one is off by, or what follows of that for the motion."""
    states = random_states(system)
    with suppress(Unread, KeyError, ValueError):
        off = np.concatenate([rows for rows, _ in residuals(equation, states)])
        assert source.equation is not None
        rows = [np.concatenate([rows for rows, _ in residuals(source.equation, states)])]
        if source.equation.meaning(str(printed.sides[0].value)) in ("L", "T", "V"):
            context = source.equation.context(states)
            lefts = euler_lagrange(source.equation.sides[-1], system.spec)
            true = euler_lagrange(source.equation.sides[0], system.spec)
            rows += [(evaluate(a, context) - evaluate(b, context))[None] for a, b in zip(lefts, true, strict=True)]
        return any(_is_multiple(off, row) for row in rows)
    return False


def _is_multiple(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether one residual is another times what depends on the parameters alone, which halves of the states share."""
    if one.shape != other.shape or len(one) != 1 or not np.abs(other).min() > 0:
        return False
    first, second = np.split(one[0] / other[0], 2)
    return bool(np.abs(first - second).max() <= RATIO * np.abs(first).max())


def _of_another(one: Printed, found: Recognition, reading: Reading) -> str:
    """Whether letters of an equation have rates elsewhere in its section that the system does not have; in words."""
    pairs = zip(found.equations, reading.strangers, strict=True)
    moving = set().union(*(letters for other, letters in pairs if other.statement.section == one.statement.section))
    strange = sorted(moving & {letter + index for letter, index in one.letters})
    return f"it does not hold for {reading.title}, which has no rate of {', '.join(strange)}" if strange else ""


def _follows(accused: Equation, found: Recognition, system: System, findings: list[Finding]) -> str:
    """Whether an equation of motion follows from the Lagrangian that the text itself gives, which is not accused."""
    if not any(name.startswith("dd") for name in accused.names):
        return ""
    for one, finding in zip(found.equations, findings, strict=True):
        doubtful = finding.verdict == "not checked" and finding.equation is not None and bool(finding.when)
        if doubtful and finding.equation and finding.equation.meaning(str(one.sides[0].value)) == "L":
            states = free_states(system)
            context = finding.equation.context(states)
            with suppress(Unread, KeyError, ValueError):
                residual = stack_residuals(accused, states)
                for left in euler_lagrange(one.sides[-1], system.spec):
                    if _is_multiple(residual, evaluate(left, context)[None]):
                        return f"it follows from the Lagrangian of {finding.place}, which is not as I read it"
    return ""


def _doubted(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, without accusations of what another reading explains that explains the section about as well.

    Of two readings that explain equally much, each of which breaks what the other one saves, neither is the right one.
    """
    answers = []
    for i, finding in enumerate(findings):
        mine = found.chosen[i]
        for less, rival in found.rivals[i]:
            if finding.verdict == "fails" and rival.credits[i] > 0:
                words = f"it does not hold for {mine.title}, but for {rival.title}: say which is meant with --rod"
                finding = replace(finding, verdict="not checked", remark=words, mends=(), proved=False)
            here = [k for k, other in enumerate(found.chosen) if other is mine and found.rivals[k] is found.rivals[i]]
            breaks = finding.verdict == "holds" and mine.credits[i] > 0 and not rival.credits[i]
            if breaks and less < EQUALLY and (saved := [k for k in here if rival.credits[k] > mine.credits[k] == 0]):
                other = findings[saved[0]]
                words = f"it contradicts equation {other.number}, {other.place}: one of the two is wrong"
                finding = replace(finding, verdict="not checked", remark=words, proved=False, when="in every motion")
        answers.append(finding)
    return answers


def _definitions(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, where a definition holds only if an equation holds with it, or one that says the same."""
    used: dict[str, list[Node]] = defaultdict(list)  # by the symbol, what it is in equations that hold
    for finding in findings:
        if finding.equation and finding.kind != "definition" and finding.verdict in ("holds", "holds if"):
            for name, meaning in _meanings_used(finding.equation):
                used[name].append(meaning)
    answers = []
    for i, (finding, one) in enumerate(zip(findings, found.equations, strict=True)):
        if finding.kind == "definition" and finding.verdict == "holds" and len(one.sides) == 2:
            system, own = found.chosen[i].system, one.definitions[one.defines]
            if not any(
                _same(one, own, other, system) for other in {key(node): node for node in used[one.defines]}.values()
            ):
                words = f"no equation that holds uses {one.defines.lstrip('?')} as it is defined here"
                finding = replace(finding, verdict="not checked", remark=words, proved=False, unknown=(one.defines,))
        answers.append(finding)
    return answers


def _unsupported(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, without accusations of equations that stand on a definition which nothing confirms.

    Nor of an entry of a mass matrix beside which no other entry holds: its row may be divided by something.
    """
    held = [one for f, one in zip(findings, found.equations, strict=True) if f.verdict == "holds"]
    right, entries = {key(side) for one in held for side in one.sides}, any(map(_is_entry, held))
    answers = []
    for finding, one in zip(findings, found.equations, strict=True):
        inside = " in the definition of " in finding.mends[0].words if finding.mends else False
        if finding.verdict == "fails" and finding.equation and not inside and not found.main.chosen:
            used = _meanings_used(finding.equation)
            own = [name for name, meaning in used if key(meaning) not in right and symbols(meaning) - {"pi"}]
            if own := [name for name in own if name not in ("?s", "?c")]:
                words = f"it does not hold, but nothing confirms {own[0].lstrip('?')}, which it uses"
                finding = replace(finding, verdict="not checked", remark=words, mends=(), proved=False)
            elif _is_entry(one) and not entries:
                words = "it is not an entry of the mass matrix as it stands; its row may be multiplied by something"
                finding = replace(finding, verdict="not checked", remark=words, mends=(), proved=False)
        answers.append(finding)
    return answers


def _is_entry(one: Printed) -> bool:
    """Whether an equation gives an entry of a mass matrix."""
    return bool(one.sides) and one.sides[0].kind == "symbol" and str(one.sides[0].value) in ("M11", "M12", "M22")


def _same(one: Printed, own: Node, other: Node, system: System) -> bool:
    """Whether two meanings of a symbol are the same, as they are written or in every motion."""
    with suppress(Unread):
        equation = Equation((own, other), definitions=one.definitions)
        return key(own) == key(other) or relative_error(equation, random_states(system)) < TOLERANCE
    return False


def _meanings_used(equation: Equation) -> Iterator[tuple[str, Node]]:
    """The symbols of the text that an equation uses, also through definitions, and what they are in it."""
    seen, fresh = set[str](), set().union(*map(symbols, equation.sides)) & equation.definitions.keys()
    while fresh:
        seen |= fresh
        yield from ((name, equation.definitions[name]) for name in fresh)
        fresh = (
            set().union(*(symbols(equation.definitions[name]) for name in fresh)) & equation.definitions.keys() - seen
        )
