"""The verdicts on a document once each of its equations has one: what they say of each other.

No other reading may explain the section of an accused one as well. A definition is right where an equation that holds,
or is mended, uses it.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import permutations

import numpy as np

from pendpin.doctor.accusations import INERTIA, Case, find_source, meanings_used, objection_to, plain
from pendpin.doctor.checking.evaluation import evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, Equation, changed, holds, relative_error
from pendpin.doctor.letters import HARDLY
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Node, Unread, Written, key, parts, symbols, with_meaning
from pendpin.doctor.recognition import Reading, Recognition, without
from pendpin.doctor.report import Finding
from pendpin.doctor.systems.base import Dimension, System, free_states, random_states
from pendpin.doctor.systems.rod import RODS
from pendpin.doctor.systems.tables import POSES

EQUALLY = 0.3  # equations: readings that explain about as much
NEXT = 2  # how far apart equations stand that belong together: the rate of a state may stand between them
POINTS = ((0, 1, 0), (0, 1, -1))  # powers of kg, m, s of places and speeds


def judge(findings: list[Finding], found: Recognition, again: Callable[[int], Finding]) -> list[Finding]:
    """The findings of a document, weighed against each other; `again` gives one as the whole document is read."""
    cases = [Case(*three) for three in zip(findings, found.equations, found.chosen, strict=True)]
    _doubt_what_rivals_explain(cases, found)
    _doubt_definitions(cases)
    _doubt_loads_of_one(cases)
    if not found.main.chosen:
        _turn_axes(cases)
        for case, words in [(case, objection_to(case, cases)) for case in cases if case.finding.verdict == "fails"]:
            case.doubt(words)
        _doubt_what_was_said_otherwise(cases)
        _doubt_definitions(cases)  # nor does what is no longer accused confirm what it uses
        same, turned = lambda system: without((*POSES, "mirrored"), system.kind), set[int]()
        for i, case in enumerate(cases):  # nothing says that a section alone measures its angles as it does
            other = case.system.kind != found.main.system.kind and same(case.system) == same(found.main.system)
            if case.finding.verdict == "holds" and other and case.reading.credits[i] and not found.main.credits[i]:
                words, section = case.reading.title, case.one.statement.section
                if section in turned or _contradicts_heights(case, cases, found.main):
                    instead = again(i)
                    if instead.doubtful or instead.verdict == "fails":
                        case.finding, case.reading, case.system = instead, found.main, found.main.system
                        turned.add(section)
                        continue
                case.doubt(f"it holds if angles are measured otherwise than in most of the text: {words}")
    wrong: list[Case] = []
    for case in cases:
        finding = case.finding
        doubtful = finding.doubtful and not finding.mends and not case.reading.unknown
        if (finding.verdict == "fails" or doubtful) and finding.equation and not finding.linear:
            if (source := find_source(finding.equation, wrong, case.system)) and not finding.follows:
                case.says(verdict="fails", proved=True, follows=source, remark="")
            elif finding.verdict == "fails":
                wrong.append(case)
    for case in cases:  # where the change of a definition mends what uses it, that alone is wrong
        finding = case.finding
        if finding.verdict == "fails" and finding.mends and finding.follows and not case.mends_itself:
            at = finding.mends[0].words.rpartition(", ")[2]
            mends = tuple(replace(m, words=m.words.partition(" in the definition of ")[0]) for m in finding.mends)
            told = {"error": finding.error, "when": finding.when, "remark": f"equation {finding.number} uses it"}
            cases[finding.follows - 1].says(verdict="fails", proved=finding.proved, mends=mends, **told)
            case.doubt(f"it uses a wrong definition, {at}", follows=0)
    return [case.finding for case in cases]


def _contradicts_heights(case: Case, cases: list[Case], main: Reading) -> bool:
    """Whether what holds for angles from upright is about heights that the text gives with angles from below.

    That is an equation with such a height, as dy/dt = -l sin(theta) dtheta/dt beside y = -l cos(theta), or an energy.
    """
    if "down" not in main.system.kind.split():
        return False
    lefts = [other.left for other in cases if other.confirmed and other.system.kind == main.system.kind and other.left]
    heights = {(left.letter, left.index) for left in lefts if left.letter[:1] in ("y", "z") and not left.dots}
    about = {(part.written.letter, part.written.index) for part in parts(case.one.sides) if part.written}
    return bool(heights & about) or (bool(heights) and case.meaning() in ("V", "L"))


def _doubt_what_rivals_explain(cases: list[Case], found: Recognition) -> None:
    """Take back accusations of what another reading explains that explains the section about as well.

    Of two readings that explain equally much, each of which breaks what the other one saves, neither is the right one.
    """
    for i, case in enumerate(cases):
        mine = case.reading
        here = [k for k, other in enumerate(cases) if other.reading is mine and found.rivals[k] is found.rivals[i]]
        for less, rival in found.rivals[i]:
            if case.finding.verdict == "fails" and rival.credits[i] > 0 and not _contradicts_heights(case, cases, mine):
                case.doubt(f"it does not hold for {mine.title}, but for {rival.title}: say which is meant with --rod")
            breaks = case.finding.verdict == "holds" and mine.credits[i] > 0 and not rival.credits[i] and less < EQUALLY
            if breaks and (saved := [k for k in here if rival.credits[k] > HARDLY and not mine.credits[k]]):
                other = cases[saved[0]].finding
                words = f"it contradicts equation {other.number}, {other.place}: one of the two is wrong"
                case.doubt(words, when="in every motion")


def _doubt_what_was_said_otherwise(cases: list[Case]) -> None:
    """Doubt an equation that holds only because a letter is not what a line before it in its section says.

    v_2 = l_2 w_2 is not the speed of the second of two bobs; so T_2 = m_2 v_2^2/2 is not its kinetic energy there. Where
    x_1 = l_1 sin(theta_1)/2 is a centre of mass, x_2 = x_1 + l_2 sin(theta_2)/2 is not the other one.
    """
    said, section = dict[Written, tuple[str, Node, Dimension | None]](), -1
    for case in cases:
        one, spec, left = case.one, case.spec, case.left
        if one.statement.section != section:
            section = one.statement.section
            said = {
                left: told
                for other in cases
                if other.one.statement.section == section
                for left, told in _inertias(other)
            }
        equation = case.finding.equation if case.finding.verdict == "holds" else None
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
                if relative_error(instead, random_states(case.system)) >= TOLERANCE:
                    case.doubt(f"it does not hold with {plain(name)} as {place} says")
                    break
        if left and len(one.sides) == 2 and case.finding.kind not in ("condition", "definition", "unread"):
            said.pop(left, None)
            of_points = spec.dimensions.get(case.meaning()) in POINTS and case.meaning() not in spec.state
            if case.finding.verdict in ("holds", "not checked") and of_points:
                said[left] = case.finding.place, one.sides[1], spec.dimensions[case.meaning()]


def _inertias(case: Case) -> Iterator[tuple[Written, tuple[str, Node, Dimension]]]:
    """The moment of inertia that an equation gives in masses and lengths: its name, where, and what it is."""
    sides, kind = case.one.sides, case.finding.kind
    inside = (
        symbols(sides[1]) - {"pi"}
        if len(sides) == 2 and kind not in ("condition", "definition", "unread")
        else set[str]()
    )
    if case.left and inside and inside <= case.spec.still and case.spec.dimensions.get(case.meaning()) == INERTIA:
        yield case.left, (case.finding.place, sides[1], INERTIA)


def _doubt_loads_of_one(cases: list[Case]) -> None:
    """Doubt an acceleration with a load beside the other one without: what acts on one coordinate moves both."""
    solved = [case for case in cases if case.confirmed and case.left and case.meaning() in case.spec.unknowns]
    for case, other in permutations(solved, 2):
        beside = abs(case.finding.number - other.finding.number) <= NEXT and case.system is other.system
        if beside and case.meaning() != other.meaning() and _loads(case) and not _loads(other):
            names = " and ".join(sorted(name.lstrip("?") for name in _loads(case)))
            case.doubt(
                f"it holds without {names}, which equation {other.finding.number} beside it does not have", unknown=()
            )


def _loads(case: Case) -> set[str]:
    """The letters of an equation that holds where they are 0."""
    equation = case.finding.equation
    known = equation.definitions.items() if equation else ()
    return {name for name, node in known if node.kind == "number" and not node.value and name in case.one.names}


def _doubt_definitions(cases: list[Case]) -> None:
    """Let a definition hold only if an equation holds with it, or one that says the same."""
    used: dict[str, dict[tuple, Node]] = defaultdict(dict)  # by the symbol, what it is in equations that hold
    for case in cases:
        finding = case.finding
        confirmed = finding.equation if finding.kind != "definition" and case.confirmed else None
        if confirmed and _is_circular(confirmed, case.system):
            confirmed = None
        if finding.verdict == "fails" and finding.mends:  # as it is mended it holds
            confirmed = finding.mends[0].equation if case.mends_itself else finding.equation
        for name, meaning in meanings_used(confirmed) if confirmed else ():
            if f"definition of {name.lstrip('?')}," not in (finding.mends[0].words if finding.mends else ""):
                used[name][key(meaning)] = meaning
    for case in cases:
        one, finding = case.one, case.finding
        if finding.verdict != "holds":
            continue
        if finding.kind == "definition" and len(one.sides) == 2:
            own = one.definitions[one.defines]
            if not any(_same(one, own, other, case.system) for other in used[one.defines].values()):
                words = f"no equation that holds uses {one.defines.lstrip('?')} as it is defined here"
                case.doubt(words, mends=finding.mends, unknown=(one.defines,))
        elif finding.equation and _is_circular(finding.equation, case.system):
            alone = [name for name, _ in meanings_used(finding.equation) if not used[name]]
            case.doubt(
                f"it holds by what {alone[0].lstrip('?')} is here, and nothing else confirms that" if alone else ""
            )


def _is_circular(equation: Equation, system: System) -> bool:
    """Whether an equation only says again what a definition of the text says.

    As T - m g = 0 does beside T = m g, or a derivative by a rate beside a Lagrangian that the text defines.
    """
    inside = set().union(*map(symbols, equation.sides))
    own = sorted(inside & equation.definitions.keys())
    if len(own) != 1 or equation.sides[0] is equation.sides[-1]:
        return False
    variables = {str(part.value) for part in parts(equation.sides) if part.kind == "derivative"}
    others, meant = inside - {*own}, symbols(equation.definitions[own[0]])
    by_rate = bool(variables & {*system.spec.rates})
    within = others - {*system.spec.unknowns} <= meant if by_rate else not variables and others == meant
    return within and holds(equation, free_states(system))


def _same(one: Printed, own: Node, other: Node, system: System) -> bool:
    """Whether two meanings of a symbol are the same, as they are written or in every motion."""
    equation = Equation((own, other), definitions=one.definitions)
    return key(own) == key(other) or holds(equation, random_states(system))


def _turn_axes(cases: list[Case]) -> None:
    """Let coordinates hold that a text measures the other way, and what uses them: several points agree, as y downwards."""
    turned, right = defaultdict[str, list[Case]](list), set[str]()
    for case in cases:
        finding, spec = case.finding, case.spec
        if case.left and case.confirmed:
            right.add(case.left.letter)
        elif case.left and finding.verdict == "fails" and finding.mends:
            name = case.meaning()
            place = spec.dimensions.get(name) == (0, 1, 0) and name not in {*spec.parameters, *spec.coordinates}
            if place and finding.mends[0].words.startswith("the sign of "):
                turned[case.left.letter].append(case)
    for letter, (first, *others) in turned.items():
        alone = not others and letter in ("y", "z") and letter not in right and first.spec.kind not in RODS
        if alone and _holds_turned(first, letter):  # nothing else shows which way it is measured
            first.doubt(f"it holds if {letter} is measured the other way")
    for letter in (letter for letter, wrong in turned.items() if len(wrong) > 1 and letter not in right):
        for case in cases:
            if case.finding.verdict == "fails" and _holds_turned(case, letter):
                words = f"{letter} is measured the other way"
                case.says(verdict="holds if", condition=words, mends=(), when="", proved=False)


def _holds_turned(case: Case, letter: str) -> bool:
    """Whether an equation holds with the coordinates of a letter reversed."""
    equation, states = case.finding.equation, random_states(case.system)
    if equation is None:
        return False
    nodes = [part for part in parts(equation.sides) if part.written and part.written.letter == letter]
    instead = {id(node): -evaluate(node, equation.context(states)) for node in nodes}
    off, size = (changed(equation, states, one) for one in (instead, {}))
    return off is not None and size is not None and bool(np.abs(off).max() < TOLERANCE * np.abs(size).max())
