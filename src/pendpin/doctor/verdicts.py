"""The verdicts on a document once each of its equations has one: what they say of each other.

An accusation needs a reading that other equations bear out: they hold with it, or one small change makes laws of them too.
No other reading may explain the section as well. A definition is right where an equation that holds, or is mended, uses it.
"""

import re
from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from pendpin.doctor.checking.check import euler_lagrange
from pendpin.doctor.checking.dimensions import of_equation
from pendpin.doctor.checking.evaluation import evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, Equation, relative_error, stack_residuals
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Node, Unread, Written, key, parts, symbols, with_meaning
from pendpin.doctor.recognition import FEW, Recognition, without
from pendpin.doctor.report import Finding
from pendpin.doctor.systems.base import Dimension, Spec, System, free_states, random_states
from pendpin.doctor.systems.planar import POSES
from pendpin.doctor.systems.rod import RODS

EQUALLY = 0.3  # equations: readings that explain about as much
RATIO = 1e-7  # of two residuals that are multiples of each other: of second derivatives eight digits are left
# the line after an equation, if it is the rest of it
GOES_ON = re.compile(r"(?:[\s&$\\{}]|\\q?quad|\\[,;:!]|\\hspace\{[^}]*\}|\\left|\\right)*(?:[+−]|-\s*[\d½(\\])")
ONE_CHANGE = 1.9  # what two changes cost more than
HOLDING = ("holds", "holds if")
ENERGIES = ("T", "V", "L", "E")
POINTS = ((0, 1, 0), (0, 1, -1))  # powers of kg, m, s of places and speeds


def judge(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings of a document, weighed against each other."""
    findings = _definitions(_explained_otherwise(findings, found), found)
    if not found.main.chosen:
        findings = _measured_otherwise(_said_otherwise(_borne_out(findings, found), found), found)
    wrong: list[tuple[Finding, Printed]] = []
    answers = []
    for finding, one, reading in zip(findings, found.equations, found.chosen, strict=True):
        doubtful = finding.verdict == "not checked" and finding.when and not finding.mends and not reading.unknown
        if (finding.verdict == "fails" or doubtful) and finding.equation and not finding.linear:
            if (source := _follows(finding.equation, wrong, reading.system)) and not finding.follows:
                finding = replace(finding, verdict="fails", proved=True, follows=source, remark="")
            elif finding.verdict == "fails":
                wrong.append((finding, one))
        answers.append(finding)
    for i, finding in enumerate(answers):  # where the change of a definition mends what uses it, that alone is wrong
        if finding.verdict == "fails" and finding.mends and finding.follows and not _mends_itself(finding):
            source, at = answers[finding.follows - 1], finding.mends[0].words.rpartition(", ")[2]
            mends = tuple(
                replace(mend, words=mend.words.partition(" in the definition of ")[0]) for mend in finding.mends
            )
            told = {"error": finding.error, "when": finding.when, "remark": f"equation {finding.number} uses it"}
            answers[finding.follows - 1] = replace(source, verdict="fails", proved=finding.proved, mends=mends, **told)
            answers[i] = replace(_unless(finding, f"it uses a wrong definition, {at}"), follows=0)
    return answers


def _left(one: Printed) -> Written | None:
    """The name that stands alone on the left side of an equation."""
    return one.sides[0].written if one.sides and one.sides[0].kind == "symbol" else None


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


def _measured_otherwise(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, where an equation holds under a condition if its section alone measures its angles as it does."""
    answers, main = [], found.main.system
    same = lambda system: without((*POSES, "mirrored"), system.kind)  # noqa: E731
    for i, (finding, reading) in enumerate(zip(findings, found.chosen, strict=True)):
        alone = reading.system.kind != main.kind and same(reading.system) == same(main) and not found.main.credits[i]
        if alone and finding.verdict == "holds" and reading.credits[i]:
            words = f"angles are measured otherwise here than in most of the text: for {reading.title}"
            finding = replace(finding, verdict="holds if", condition=words)
        answers.append(finding)
    return answers


def _said_otherwise(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, where no equation holds only because a letter is not what a line before it in its section says.

    v_2 = l_2 w_2 is not the speed of the second of two bobs; so T_2 = m_2 v_2^2/2 is not its kinetic energy there. Where
    x_1 = l_1 sin(theta_1)/2 is a centre of mass, x_2 = x_1 + l_2 sin(theta_2)/2 is not the other one.
    """
    said, answers, section = dict[Written, tuple[str, Node, Dimension | None]](), list[Finding](), -1
    for finding, one, reading in zip(findings, found.equations, found.chosen, strict=True):
        if one.statement.section != section:
            said, section = {}, one.statement.section
        left, spec = _left(one), reading.system.spec
        equation = finding.equation if finding.verdict == "holds" else None
        for part in parts(equation.sides) if equation and said else ():
            assert equation is not None
            name, dimension = part.written, spec.dimensions.get(equation.meaning(str(part.value)))
            if name is None or name == left or name not in said or said[name][2] != dimension:
                continue
            place, meaning, _ = said[name]
            first, *rest = equation.sides
            sides = first, *(with_meaning(side, name, "?said") for side in rest)
            instead = replace(equation, sides=sides, definitions=equation.definitions | {"?said": meaning})
            with suppress(Unread):
                if relative_error(instead, random_states(reading.system)) >= TOLERANCE:
                    finding = _unless(finding, f"it does not hold with {_plain(name)} as {place} says")
                    break
        answers.append(finding)
        if left and len(one.sides) == 2 and finding.kind not in ("condition", "definition", "unread"):
            meaning = str(one.sides[0].value)
            meaning = finding.equation.meaning(meaning) if finding.equation else meaning
            of_points = spec.dimensions.get(meaning) in POINTS and meaning not in spec.state
            if finding.verdict in ("holds", "not checked") and of_points:
                said[left] = finding.place, one.sides[1], spec.dimensions[meaning]
            else:
                said.pop(left, None)
    return answers


def _definitions(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, where a definition holds only if an equation holds with it, or one that says the same."""
    used: dict[str, dict[tuple, Node]] = defaultdict(dict)  # by the symbol, what it is in equations that hold
    for finding, reading in zip(findings, found.chosen, strict=True):
        confirmed = finding.equation if finding.kind != "definition" and finding.verdict in HOLDING else None
        if confirmed and _is_circular(confirmed, reading.system):
            confirmed = None
        if finding.verdict == "fails" and finding.mends:  # as it is mended it holds
            confirmed = finding.mends[0].equation if _mends_itself(finding) else finding.equation
        for name, meaning in _meanings_used(confirmed) if confirmed else ():
            if f"definition of {name.lstrip('?')}," not in (finding.mends[0].words if finding.mends else ""):
                used[name][key(meaning)] = meaning
    answers = []
    for finding, one, reading in zip(findings, found.equations, found.chosen, strict=True):
        if finding.kind == "definition" and finding.verdict == "holds" and len(one.sides) == 2:
            own = one.definitions[one.defines]
            if not any(_same(one, own, other, reading.system) for other in used[one.defines].values()):
                words = f"no equation that holds uses {one.defines.lstrip('?')} as it is defined here"
                finding = replace(_unless(finding, words), mends=finding.mends, unknown=(one.defines,))
        elif finding.verdict == "holds" and finding.equation and _is_circular(finding.equation, reading.system):
            alone = [name for name, _ in _meanings_used(finding.equation) if not used[name]]
            words = f"it holds by what {alone[0].lstrip('?')} is here, and nothing else confirms that" if alone else ""
            finding = _unless(finding, words)
        answers.append(finding)
    return answers


def _is_circular(equation: Equation, system: System) -> bool:
    """Whether an equation only says again what a definition of the text says: T - m g = 0 beside T = m g."""
    inside = set().union(*map(symbols, equation.sides))
    own = sorted(inside & equation.definitions.keys())
    if len(own) != 1 or inside - {*own} != symbols(equation.definitions[own[0]]):
        return False
    if equation.sides[0] is equation.sides[-1] or any(part.kind == "derivative" for part in parts(equation.sides)):
        return False
    with suppress(Unread, KeyError):
        return relative_error(equation, free_states(system)) < TOLERANCE
    return False


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


@dataclass(frozen=True)
class _Evidence:
    """What shows that the equations of a document are meant for one system, and who is accused.

    How points move confirms how others do, and no balance or energy.
    """

    laws: int  # that hold
    motions: int  # the laws and the equations on how points move that hold
    near: int  # accused equations of several terms that one small change makes a law
    accused: int


def _evidence(findings: list[Finding], found: Recognition) -> dict[str, _Evidence]:
    """What bears out each system."""
    evidence: dict[str, _Evidence] = {}
    for spec in {reading.system.kind: reading.system.spec for reading in found.chosen}.values():
        here = [f for f, reading in zip(findings, found.chosen, strict=True) if reading.system.kind == spec.kind]
        laws = [f.equation for f in here if f.verdict in HOLDING and f.kind != "definition" and f.equation]
        telling = [one for one in laws if one.names & {*spec.parameters}]
        accused = [f for f in here if f.verdict == "fails"]
        different = {f.mends[0].words if f.mends else f.latex for f in accused}
        near = sum(is_near(f, spec) for f in accused)
        evidence[spec.kind] = _Evidence(sum(_is_law(one, spec) for one in telling), len(telling), near, len(different))
    return evidence


def _borne_out(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, without accusations of what no other equation of the document bears out."""
    findings = _turned_axes(findings, found)
    specs = [reading.system.spec for reading in found.chosen]
    evidence, few = _evidence(findings, found), sum(1 for one in found.equations if one.ways) < FEW
    is_entry = lambda one: one.sides[0].kind == "symbol" and str(one.sides[0].value) in ("M11", "M12", "M22")  # noqa: E731
    held = [one for f, one in zip(findings, found.equations, strict=True) if f.verdict == "holds" and one.sides]
    right, entries = {key(side) for one in held for side in one.sides}, any(map(is_entry, held))
    brought = [
        _brought(f, spec) if f.verdict == "fails" else frozenset() for f, spec in zip(findings, specs, strict=True)
    ]
    written = {
        name for f, spec in zip(findings, specs, strict=True) if f.equation for name in _quantities(f.equation, spec)
    }
    lone = [_left(one) for one in found.equations]
    given = {name for f, name in zip(findings, lone, strict=True) if f.verdict in HOLDING and name}
    named = lambda one: one.sides[-1].kind == "symbol"  # noqa: E731  a state that gets a name
    pairs = zip(findings, found.equations, lone, strict=True)
    doubted = {name: f.place for f, one, name in pairs if f.unknown and name and not named(one)}

    def objection(i: int) -> str:
        """Why an equation is not accused though it does not hold; empty where it is."""
        finding, one, spec, borne = findings[i], found.equations[i], specs[i], evidence[specs[i].kind]
        assert finding.equation is not None
        if _mends_itself(finding) and _says_nothing(finding.mends[0].equation, found.chosen[i].system):
            return f"as I read it, for {spec.title}, it does not hold, and no small change makes it hold"
        used = _meanings_used(finding.equation) if _mends_itself(finding) else ()
        own = [name for name, meaning in used if key(meaning) not in right and symbols(meaning) - {"pi"}]
        if own := [name for name in own if name not in ("?s", "?c")]:
            return f"it does not hold, but nothing confirms {own[0].lstrip('?')}, which it uses"
        for part in parts(one.sides[1:] if _mends_itself(finding) else ()):
            state = finding.equation.meaning(str(part.value)) in spec.state
            if part.written and part.written in doubted.keys() - given and not state:
                return f"it does not hold, but what {_plain(part.written)} is, {doubted[part.written]}, is not checked"
        left = lone[i]
        new = finding.mends[0].equation.sides[0].written if _mends_itself(finding) else left
        if all(side.kind == "symbol" for side in one.sides) and any(side.value in spec.state for side in one.sides):
            return "it gives a state a name"
        guess = bool(finding.mends) and finding.mends[0].cost > ONE_CHANGE  # two changes
        other = left and new and (new.letter != left.letter or " is too many" in finding.mends[0].words)
        if left and other and guess:
            return f"it does not hold if {_plain(left)} means {spec.printed.get(str(one.sides[0].value), 'known')}"
        moves = any(symbols(side) - spec.still - {"pi"} for side in one.sides[1:])
        if left and finding.dimensions and moves and _is_still(finding.equation, spec):
            return f"it does not hold if {_plain(left)} means a constant: its dimension is another one"
        if is_entry(one) and not entries:
            return "it is not an entry of the mass matrix as it stands; its row may be multiplied by something"
        if few and spec.kind in RODS:
            return ""
        if brought[i] and (brought.count(brought[i]) > 1 or brought[i] - written):  # not by mistake
            return f"it does not hold, but where {' = '.join(sorted(brought[i]))} = 1, as in other equations"
        if _mends_itself(finding) and finding.dimensions and (ones := _brought_into_bare_sides(finding, spec)):
            return f"it does not hold, but where {' = '.join(ones)} = 1"
        rest = one.statement.after  # and what is read next
        after = rest if rest.strip() else "".join(o.latex for o in found.equations if o.number == one.number + 1)
        if one.latex.lstrip(" &").startswith("+") or GOES_ON.match(after):
            return "it goes on from what stands before it, or in the next line"
        energy = lambda e: {e.meaning(str(s.value)) for s in e.sides if s.kind == "symbol"} & {*ENERGIES}  # noqa: E731
        if _mends_itself(finding) and energy(finding.equation) != energy(finding.mends[0].equation):
            return f"as I read it, {finding.mends[0].words}: it may be the beginning of a longer equation"
        of_names = lambda node: all(part.kind == "symbol" for part in node.children) or node.kind == "symbol"  # noqa: E731
        sums = [side for side in one.sides if side.kind == "sum"]  # as T - V
        names = bool(sums) and all(side.kind in ("symbol", "sum") and of_names(side) for side in one.sides)
        names = names and not one.names & one.definitions.keys() - {one.defines}  # else it is as wrong as they are
        others = [side for side in one.sides if side.value not in ENERGIES]
        still = len(others) < len(one.sides) and all(symbols(side) <= spec.still for side in others)  # as V = m g h
        if still or (names and not (finding.mends and "sign" in finding.mends[0].words)):
            return "it is a formula in general"
        near = borne.near - is_near(finding, spec)
        if borne.laws + near < 1:
            return f"as I read it, for {spec.title}, it does not hold; but no other equation shows that it is meant so"
        support = borne.laws if _is_law(finding.equation, spec) else borne.motions
        if borne.accused - borne.near > 2 * (support + near) + 1:
            return f"as I read it, for {spec.title}, it does not hold; but too many others do not hold either"
        return ""

    return [
        _unless(finding, objection(i)) if finding.verdict == "fails" and finding.equation else finding
        for i, finding in enumerate(findings)
    ]


def _turned_axes(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings, where a text measures a coordinate the other way: all of several points agree on it, as y downwards."""
    turned: dict[str, list[int]] = defaultdict(list)
    right = set[str]()
    for i, (finding, one, reading) in enumerate(zip(findings, found.equations, found.chosen, strict=True)):
        name = _left(one)
        if name and finding.verdict in HOLDING:
            right.add(name.letter)
        elif name and finding.verdict == "fails" and _turns_an_axis(finding, reading.system.spec):
            turned[name.letter].append(i)
    answers = list(findings)
    for letter, places in turned.items():
        for i in places if len(places) > 1 and letter not in right else ():
            words = f"{letter} is measured the other way"
            answers[i] = replace(findings[i], verdict="holds if", condition=words, mends=(), when="", proved=False)
    return answers


def _mends_itself(finding: Finding) -> bool:
    """Whether its first mend is of the equation, and not of a definition that it uses."""
    return bool(finding.mends) and " in the definition of " not in finding.mends[0].words


def _turns_an_axis(finding: Finding, spec: Spec) -> bool:
    """Whether an equation says where a point is along an axis, and holds with another sign."""
    if finding.equation is None:
        return False
    name = finding.equation.meaning(str(finding.equation.sides[0].value))
    place = spec.dimensions.get(name) == (0, 1, 0) and name not in {*spec.parameters, *spec.coordinates}
    return place and bool(finding.mends) and finding.mends[0].words.startswith("the sign of ")


def _is_still(equation: Equation, spec: Spec) -> bool:
    """Whether the first side is a name for what does not move."""
    return equation.meaning(str(equation.sides[0].value)) in spec.still


def _plain(name: Written) -> str:
    """A name as it is typed."""
    return name.letter + ("_" + name.index if name.index else "")


def _says_nothing(equation: Equation, system: System) -> bool:
    """Whether all sides of an equation are the same number in every state, as g/g and 1."""
    with suppress(Unread, KeyError, ValueError):
        context = equation.context(free_states(system))  # on the true motion every law is 0
        sides = [np.atleast_1d(evaluate(side, context)) for side in equation.sides if side.kind != "number"]
        values = [side for side in sides if side.ndim == 1]
        return len(values) == len(sides) and all(np.ptp(side) <= TOLERANCE for side in values)
    return False


def is_near(finding: Finding, spec: Spec) -> bool:
    """Whether one small change, other than a term too many or too few, makes a law of an equation of several terms.

    Or one that makes the dimensions agree.
    """
    if not finding.mends or finding.mends[0].cost > ONE_CHANGE or finding.equation is None:
        return False
    if not _mends_itself(finding):
        return True
    if finding.dimensions and not of_equation(finding.mends[0].equation, spec)[1]:
        return True
    mended, words = finding.mends[0].equation, finding.mends[0].words
    terms = sum(len(part.children) if part.kind == "sum" else 1 for part in mended.sides)
    return terms >= 3 and _is_law(mended, spec) and not words.startswith(("the term ", "the factor "))


def _brought(finding: Finding, spec: Spec) -> frozenset[str]:
    """The parameters that a mend writes into an equation whose dimensions do not agree: what a text may have set to 1."""
    if not (_mends_itself(finding) and finding.equation and finding.dimensions):
        return frozenset()
    return _quantities(finding.mends[0].equation, spec) - _quantities(finding.equation, spec) - {*spec.coordinates}


def _brought_into_bare_sides(finding: Finding, spec: Spec) -> list[str]:
    """The parameters that a mend brings into sides without any, as p into p/(m l^2): a text may have set m and l to 1."""
    assert finding.equation is not None
    pairs = zip(finding.equation.sides, finding.mends[0].equation.sides, strict=False)
    sides = [[symbols(side) & spec.still for side in pair] for pair in pairs if key(pair[0]) != key(pair[1])]
    return sorted(set().union(*(new for _, new in sides))) if sides and not any(old for old, _ in sides) else []


def _is_law(equation: Equation, spec: Spec) -> bool:
    """Whether an equation is about more than how points move: a mass, a force, an energy or gravity is in it."""
    names = equation.names
    heavy = any(name == "g" or spec.dimensions.get(name, (0, 0, 0))[0] for name in names)
    return heavy and bool(names & {*spec.parameters})


def _quantities(equation: Equation, spec: Spec) -> frozenset[str]:
    """The coordinates and parameters in an equation."""
    return frozenset(equation.names & {*spec.parameters, *spec.coordinates})


def _follows(equation: Equation, wrong: list[tuple[Finding, Printed]], system: System) -> int:
    """The first wrong equation that another one follows from; 0 for none.

    What it is off by, in each of its components, is what an earlier one is off by, or what follows of that for the motion.
    """
    states, known = random_states(system), list[tuple[int, np.ndarray]]()
    with suppress(Unread, KeyError, ValueError):
        off = stack_residuals(equation, states, plain=True)
        for source, printed in wrong:
            if (other := source.equation) is None:
                continue
            with suppress(Unread, KeyError, ValueError):
                known += [(source.number, row) for row in stack_residuals(other, states, plain=True)]
                if other.meaning(str(printed.sides[0].value)) in ("L", "T", "V"):
                    context = other.context(states)
                    lefts, true = (euler_lagrange(other.sides[i], system.spec) for i in (-1, 0))
                    pairs = zip(lefts, true, strict=True)
                    known += [(source.number, evaluate(a, context) - evaluate(b, context)) for a, b in pairs]
        rows = [row for row in off if np.abs(row).max() > TOLERANCE * np.abs(off).max()]
        if any(
            np.abs(np.diff(np.split(row, 2), axis=0)).max() <= RATIO * np.abs(row).max() for row in rows
        ):  # of constants alone each is a multiple of any other
            return 0
        sources = [next((number for number, other in known if _is_multiple(row, other)), 0) for row in rows]
        return min(sources, default=0)
    return 0


def _is_multiple(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether one residual is another times what depends on the parameters alone, which halves of the states share."""
    if one.shape != other.shape or not np.abs(other).min() > 0:
        return False
    first, second = np.split(one / other, 2)
    return bool(np.abs(first - second).max() <= RATIO * np.abs(first).max())
