"""The verdicts on a document once each of its equations has one: what they say of each other.

An accusation needs a reading that other equations bear out: they hold with it, and use the same letters. No other reading
may explain the section as well. A definition is right where an equation that holds uses it.
"""

import re
from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from pendpin.doctor.checking.check import euler_lagrange
from pendpin.doctor.checking.evaluation import evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, Equation, relative_error, stack_residuals
from pendpin.doctor.findings import Finding
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Node, Unread, key, parts, symbols
from pendpin.doctor.recognition import FEW, Reading, Recognition
from pendpin.doctor.systems.base import Spec, System, free_states, random_states
from pendpin.doctor.systems.rod import RODS

EQUALLY = 0.3  # equations: readings that explain about as much
RATIO = 1e-7  # of two residuals that are multiples of each other: of second derivatives eight digits are left
MOST_STRANGE = 1  # letters of an accused equation that no equation which holds has
# the line after an equation, if it is the rest of it
GOES_ON = re.compile(r"(?:[\s&$\\{}]|\\q?quad|\\[,;:!]|\\hspace\{[^}]*\}|\\left|\\right)*(?:[+−]|-\s*[\d½(\\])")
HOLDING = ("holds", "holds if")


def judge(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings of a document, weighed against each other."""
    findings = _definitions(_explained_otherwise(findings, found), found)
    if not found.main.chosen:
        findings = _borne_out(_standing(findings, found), found)
    wrong: list[tuple[Finding, Printed]] = []
    answers = []
    for finding, one, reading in zip(findings, found.equations, found.chosen, strict=True):
        if finding.verdict == "fails" and finding.equation and not finding.linear:
            source = next((f for f, o in wrong if _is_consequence(finding.equation, f, o, reading.system)), None)
            finding = replace(finding, follows=source.number) if source else finding
            wrong += [] if source else [(finding, one)]
        answers.append(finding)
    return answers


def _unless(finding: Finding, words: str) -> Finding:
    """A finding that is no accusation if words say why."""
    return replace(finding, verdict="not checked", remark=words, mends=(), proved=False) if words else finding


def _explained_otherwise(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, without accusations of what another reading explains that explains the section about as well.

    Of two readings that explain equally much, each of which breaks what the other one saves, neither is the right one.
    """
    answers = []
    for i, finding in enumerate(findings):
        mine = found.chosen[i]
        here = [k for k, other in enumerate(found.chosen) if other is mine and found.rivals[k] is found.rivals[i]]
        for less, rival in found.rivals[i]:
            if finding.verdict == "fails" and rival.credits[i] > 0:
                words = f"it does not hold for {mine.title}, but for {rival.title}: say which is meant with --rod"
                finding = _unless(finding, words)
            breaks = finding.verdict == "holds" and mine.credits[i] > 0 and not rival.credits[i] and less < EQUALLY
            if breaks and (saved := [k for k in here if rival.credits[k] > mine.credits[k] == 0]):
                other = findings[saved[0]]
                words = f"it contradicts equation {other.number}, {other.place}: one of the two is wrong"
                finding = replace(_unless(finding, words), when="in every motion")
        answers.append(finding)
    return answers


def _definitions(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, where a definition holds only if an equation holds with it, or one that says the same."""
    used: dict[str, dict[tuple, Node]] = defaultdict(dict)  # by the symbol, what it is in equations that hold
    for finding in findings:
        if finding.equation and finding.kind != "definition" and finding.verdict in HOLDING:
            for name, meaning in _meanings_used(finding.equation):
                used[name][key(meaning)] = meaning
    answers = []
    for finding, one, reading in zip(findings, found.equations, found.chosen, strict=True):
        if finding.kind == "definition" and finding.verdict == "holds" and len(one.sides) == 2:
            own = one.definitions[one.defines]
            if not any(_same(one, own, other, reading.system) for other in used[one.defines].values()):
                words = f"no equation that holds uses {one.defines.lstrip('?')} as it is defined here"
                finding = replace(_unless(finding, words), mends=finding.mends, unknown=(one.defines,))
        answers.append(finding)
    return answers


def _same(one: Printed, own: Node, other: Node, system: System) -> bool:
    """Whether two meanings of a symbol are the same, as they are written or in every motion."""
    with suppress(Unread):
        equation = Equation((own, other), definitions=one.definitions)
        return key(own) == key(other) or relative_error(equation, random_states(system)) < TOLERANCE
    return False


def _meanings_used(equation: Equation) -> Iterator[tuple[str, Node]]:
    """The symbols of the text that an equation uses, also through definitions, and what they are in it."""
    known = equation.definitions
    seen, fresh = set[str](), set().union(*map(symbols, equation.sides)) & known.keys()
    while fresh:
        seen |= fresh
        yield from ((name, known[name]) for name in fresh)
        fresh = set().union(*(symbols(known[name]) for name in fresh)) & known.keys() - seen


def _standing(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, without accusations of equations that stand on a definition which nothing confirms.

    Nor of an entry of a mass matrix beside which no other entry holds: its row may be divided by something.
    """
    is_entry = lambda one: one.sides[0].kind == "symbol" and str(one.sides[0].value) in ("M11", "M12", "M22")  # noqa: E731
    held = [one for f, one in zip(findings, found.equations, strict=True) if f.verdict == "holds" and one.sides]
    right, entries = {key(side) for one in held for side in one.sides}, any(map(is_entry, held))
    answers = []
    for finding, one in zip(findings, found.equations, strict=True):
        inside = bool(finding.mends) and not _mends_itself(finding)
        words = ""
        if finding.verdict == "fails" and finding.equation and not inside:
            used = _meanings_used(finding.equation)
            own = [name for name, meaning in used if key(meaning) not in right and symbols(meaning) - {"pi"}]
            if own := [name for name in own if name not in ("?s", "?c")]:
                words = f"it does not hold, but nothing confirms {own[0].lstrip('?')}, which it uses"
            elif is_entry(one) and not entries:
                words = "it is not an entry of the mass matrix as it stands; its row may be multiplied by something"
        answers.append(_unless(finding, words))
    return answers


@dataclass(frozen=True)
class _Evidence:
    """The laws of a document that hold for one system, with how its points move, the quantities, and who is accused.

    How points move confirms how others do, and no balance or energy.
    """

    laws: int
    motions: int  # the laws and the equations on how points move
    names: frozenset[str]
    accused: int

    def objection(self, finding: Finding, one: Printed, after: str, spec: Spec) -> str:
        """Why an equation is not accused though it does not hold; empty where it is."""
        if all(side.kind == "symbol" for side in one.sides) and not one.names & spec.still:
            return "it says what a name stands for"
        if one.latex.lstrip(" &").startswith("+") or GOES_ON.match(after):
            return "it goes on from what stands before it, or in the next line"
        assert finding.equation is not None
        energy = lambda e: {e.meaning(str(s.value)) for s in e.sides if s.kind == "symbol"} & {"T", "V", "L", "E"}  # noqa: E731
        if _mends_itself(finding) and energy(finding.equation) != energy(finding.mends[0].equation):
            return f"as I read it, {finding.mends[0].words}: it may be the beginning of a longer equation"
        of_names = lambda node: all(part.kind == "symbol" for part in node.children) or node.kind == "symbol"  # noqa: E731
        sums = [side for side in one.sides if side.kind == "sum"]  # as T - V
        names = bool(sums) and all(side.kind in ("symbol", "sum") and of_names(side) for side in one.sides)
        energies = [side for side in one.sides if side.value in ("T", "V", "E", "L")]
        still = energies and all(symbols(side) <= spec.still for side in one.sides if side not in energies)
        if still or (names and not (finding.mends and "sign" in finding.mends[0].words)):
            return "it is a formula in general"
        letters: dict[str, set[tuple[str, str]]] = defaultdict(set)
        for node in parts(finding.equation.sides):
            if node.written:
                letters[finding.equation.meaning(str(node.value))].add((node.written.letter, node.written.index))
        if twice := [name for name, found in letters.items() if len(found) > 1]:
            return f"it does not hold, but as I read it two of its letters mean {twice[0]}"
        support = self.laws if _is_law(finding.equation, spec) else self.motions
        if not self.laws:
            return f"as I read it, for {spec.title}, it does not hold; but no other equation shows that it is meant so"
        if self.accused > 2 * support + 1:
            return f"as I read it, for {spec.title}, it does not hold; but too many others do not hold either"
        if brought := _brought(finding, spec) - self.names:
            return f"it does not hold, but where {' = '.join(sorted(brought))} = 1: no equation that holds has it"
        strange = _quantities(finding.equation, spec) - self.names
        if len(strange) > MOST_STRANGE and spec.kind not in RODS:
            return f"it does not hold, but no equation that holds confirms what {', '.join(sorted(strange))} is"
        return ""


def _mends_itself(finding: Finding) -> bool:
    """Whether its first mend is of the equation, and not of a definition that it uses."""
    return bool(finding.mends) and " in the definition of " not in finding.mends[0].words


def _brought(finding: Finding, spec: Spec) -> frozenset[str]:
    """The parameters that a mend writes into an equation whose dimensions do not agree: what a text may have set to 1."""
    if not (_mends_itself(finding) and finding.equation and finding.dimensions):
        return frozenset()
    return _quantities(finding.mends[0].equation, spec) - _quantities(finding.equation, spec) - {*spec.coordinates}


def _is_law(equation: Equation, spec: Spec) -> bool:
    """Whether an equation is about more than how points move: a mass, a force, an energy or gravity is in it."""
    names = equation.names
    heavy = any(name == "g" or spec.dimensions.get(name, (0, 0, 0))[0] for name in names)
    return heavy and bool(names & {*spec.parameters})


def _quantities(equation: Equation, spec: Spec) -> frozenset[str]:
    """The coordinates and parameters in an equation."""
    return frozenset(equation.names & {*spec.parameters, *spec.coordinates})


def _borne_out(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, without accusations of what no other equation of the document bears out."""
    evidence: dict[str, _Evidence] = {}
    for spec in {reading.system.kind: reading.system.spec for reading in found.chosen}.values():
        here = [f for f, reading in zip(findings, found.chosen, strict=True) if reading.system.kind == spec.kind]
        laws = [f.equation for f in here if f.verdict in HOLDING and f.kind != "definition" and f.equation]
        telling = [one for one in laws if _quantities(one, spec) & {*spec.parameters}]
        names = frozenset().union(*(_quantities(one, spec) for one in telling))
        accused = {f.mends[0].words if f.mends else f.latex for f in here if f.verdict == "fails"}
        count = sum(_is_law(one, spec) for one in telling)
        evidence[spec.kind] = _Evidence(count, len(telling), names, len(accused))
    answers, few = [], sum(1 for one in found.equations if one.ways) < FEW
    pairs = [*zip(findings, (reading.system.spec for reading in found.chosen), strict=True)]
    brought = [_brought(finding, spec) if finding.verdict == "fails" else frozenset() for finding, spec in pairs]
    for finding, one, reading in zip(findings, found.equations, found.chosen, strict=True):
        spec, words = reading.system.spec, ""
        if finding.verdict == "fails" and finding.equation and not (few and spec.kind in RODS):
            words = _follows(finding.equation, found, reading.system, findings) or _of_another(one, found, reading)
            rest = one.statement.after  # and what is read next
            after = rest if rest.strip() else "".join(o.latex for o in found.equations if o.number == one.number + 1)
            ones = _brought(finding, spec)
            if ones and brought.count(ones) > 1:  # not by mistake
                words = words or f"it holds where {' = '.join(sorted(ones))} = 1, as another of the text does"
            words = words or evidence[spec.kind].objection(finding, one, after, spec)
        answers.append(_unless(finding, words))
    return answers


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


def _is_consequence(equation: Equation, source: Finding, printed: Printed, system: System) -> bool:
    """Whether what an equation is off by is what an earlier one is off by, or what follows of that for the motion."""
    states = random_states(system)
    with suppress(Unread, KeyError, ValueError):
        off = stack_residuals(equation, states, plain=True)
        assert source.equation is not None
        rows = [stack_residuals(source.equation, states, plain=True)]
        if source.equation.meaning(str(printed.sides[0].value)) in ("L", "T", "V"):
            context = source.equation.context(states)
            lefts, true = (euler_lagrange(source.equation.sides[i], system.spec) for i in (-1, 0))
            rows += [(evaluate(a, context) - evaluate(b, context))[None] for a, b in zip(lefts, true, strict=True)]
        return any(_is_multiple(off, row) for row in rows)
    return False


def _is_multiple(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether one residual is another times what depends on the parameters alone, which halves of the states share."""
    if one.shape != other.shape or len(one) != 1 or not np.abs(other).min() > 0:
        return False
    first, second = np.split(one[0] / other[0], 2)
    return bool(np.abs(first - second).max() <= RATIO * np.abs(first).max())
