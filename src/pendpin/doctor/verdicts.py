"""The verdicts on a document once each of its equations has one: what they say of each other.

An accusation needs a reading that other equations bear out: they hold with it, or one small change makes laws of them too.
No other reading may explain the section as well. A definition is right where an equation that holds, or is mended, uses it.
"""

import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from itertools import combinations, permutations

import numpy as np

from pendpin.doctor.checking.check import euler_lagrange
from pendpin.doctor.checking.evaluation import evaluate
from pendpin.doctor.checking.residuals import (
    TOLERANCE,
    Equation,
    changed,
    holds,
    names_in,
    of_equation,
    relative_error,
    stack_residuals,
)
from pendpin.doctor.letters import HARDLY
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Node, Unread, Written, key, parts, symbols, with_meaning
from pendpin.doctor.recognition import FEW, Reading, Recognition, without
from pendpin.doctor.report import Finding
from pendpin.doctor.systems.base import Dimension, Quantities, Spec, System, free_states, random_states
from pendpin.doctor.systems.planar import POSES
from pendpin.doctor.systems.rod import RODS

EQUALLY = 0.3  # equations: readings that explain about as much
RATIO = 1e-7  # of two residuals that are multiples of each other: of second derivatives eight digits are left
# the line after an equation, if it is the rest of it
GOES_ON = re.compile(r"(?:[\s&$\\{}]|\\q?quad|\\[,;:!]|\\hspace\{[^}]*\}|\\left|\\right)*(?:[+−]|-\s*[\d½(\\])")
ONE_CHANGE = 1.9  # what two changes cost more than
INERTIA = (1, 2, 0)
NEXT = 2  # how far apart equations stand that belong together: the rate of a state may stand between them
LONG = 20  # parts of an equation that is no law by chance
ENERGIES = ("T", "V", "L", "E")
POINTS = ((0, 1, 0), (0, 1, -1))  # powers of kg, m, s of places and speeds


class _Case:
    """An equation, its reading, and what is found about it so far."""

    def __init__(self, finding: Finding, one: Printed, reading: Reading) -> None:
        self.finding, self.one, self.reading = finding, one, reading
        self.system, self.spec = reading.system, reading.system.spec
        side = one.sides[0] if one.sides else None
        self.left: Written | None = side.written if side and side.kind == "symbol" else None  # what stands alone there

    @property
    def confirmed(self) -> bool:
        """Whether it holds, if only under a condition."""
        return self.finding.verdict in ("holds", "holds if")

    @property
    def mends_itself(self) -> bool:
        """Whether its first mend is of the equation, and not of a definition that it uses."""
        return bool(self.finding.mends) and " in the definition of " not in self.finding.mends[0].words

    @cached_property
    def brought(self) -> frozenset[str]:
        """The parameters that a mend writes into an equation whose dimensions do not agree: a text may set them to 1."""
        finding, spec = self.finding, self.spec
        if not (finding.verdict == "fails" and self.mends_itself and finding.equation and finding.dimensions):
            return frozenset()
        new = _quantities(finding.mends[0].equation, spec) - _quantities(finding.equation, spec)
        return new - {*spec.coordinates}

    def meaning(self) -> str:
        """What its first side means, if that is a name."""
        name = str(self.one.sides[0].value)
        return self.finding.equation.meaning(name) if self.finding.equation else name

    def says(self, **said: object) -> None:
        """Another finding takes the place of what was found."""
        self.finding = replace(self.finding, **said)

    def doubt(self, words: str, **said: object) -> None:
        """It is no accusation, and holds no longer, if words say why."""
        if words:
            self.says(**{"verdict": "not checked", "remark": words, "mends": (), "proved": False, **said})


def judge(findings: list[Finding], found: Recognition, again: Callable[[int], Finding]) -> list[Finding]:
    """The findings of a document, weighed against each other; `again` gives one as the whole document is read."""
    cases = [_Case(*three) for three in zip(findings, found.equations, found.chosen, strict=True)]
    _doubt_what_rivals_explain(cases, found)
    _doubt_definitions(cases)
    _doubt_loads_of_one(cases)
    if not found.main.chosen:
        _turn_axes(cases)
        for case, words in [(case, _objection(case, cases)) for case in cases if case.finding.verdict == "fails"]:
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
    wrong: list[_Case] = []
    for case in cases:
        finding = case.finding
        doubtful = finding.doubtful and not finding.mends and not case.reading.unknown
        if (finding.verdict == "fails" or doubtful) and finding.equation and not finding.linear:
            if (source := _follows(finding.equation, wrong, case.system)) and not finding.follows:
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


def _contradicts_heights(case: _Case, cases: list[_Case], main: Reading) -> bool:
    """Whether what holds for angles from upright is about heights that the text gives with angles from below.

    That is an equation with such a height, as dy/dt = -l sin(theta) dtheta/dt beside y = -l cos(theta), or an energy.
    """
    if "down" not in main.system.kind.split():
        return False
    lefts = [other.left for other in cases if other.confirmed and other.system.kind == main.system.kind and other.left]
    heights = {(left.letter, left.index) for left in lefts if left.letter[:1] in ("y", "z") and not left.dots}
    about = {(part.written.letter, part.written.index) for part in parts(case.one.sides) if part.written}
    return bool(heights & about) or (bool(heights) and case.meaning() in ("V", "L"))


def _doubt_what_rivals_explain(cases: list[_Case], found: Recognition) -> None:
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


def _doubt_what_was_said_otherwise(cases: list[_Case]) -> None:
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
                    case.doubt(f"it does not hold with {_plain(name)} as {place} says")
                    break
        if left and len(one.sides) == 2 and case.finding.kind not in ("condition", "definition", "unread"):
            said.pop(left, None)
            of_points = spec.dimensions.get(case.meaning()) in POINTS and case.meaning() not in spec.state
            if case.finding.verdict in ("holds", "not checked") and of_points:
                said[left] = case.finding.place, one.sides[1], spec.dimensions[case.meaning()]


def _inertias(case: _Case) -> Iterator[tuple[Written, tuple[str, Node, Dimension]]]:
    """The moment of inertia that an equation gives in masses and lengths: its name, where, and what it is."""
    sides, kind = case.one.sides, case.finding.kind
    inside = symbols(sides[1]) - {"pi"} if len(sides) == 2 and kind not in ("definition", "unread") else set[str]()
    if case.left and inside and inside <= case.spec.still and case.spec.dimensions.get(case.meaning()) == INERTIA:
        yield case.left, (case.finding.place, sides[1], INERTIA)


def _doubt_loads_of_one(cases: list[_Case]) -> None:
    """Doubt an acceleration with a load beside the other one without: what acts on one coordinate moves both."""
    solved = [case for case in cases if case.confirmed and case.left and case.meaning() in case.spec.unknowns]
    for case, other in permutations(solved, 2):
        beside = abs(case.finding.number - other.finding.number) <= NEXT and case.system is other.system
        if beside and case.meaning() != other.meaning() and _loads(case) and not _loads(other):
            names = " and ".join(sorted(name.lstrip("?") for name in _loads(case)))
            case.doubt(
                f"it holds without {names}, which equation {other.finding.number} beside it does not have", unknown=()
            )


def _loads(case: _Case) -> set[str]:
    """The letters of an equation that holds where they are 0."""
    equation = case.finding.equation
    known = equation.definitions.items() if equation else ()
    return {name for name, node in known if node.kind == "number" and not node.value and name in case.one.names}


def _doubt_definitions(cases: list[_Case]) -> None:
    """Let a definition hold only if an equation holds with it, or one that says the same."""
    used: dict[str, dict[tuple, Node]] = defaultdict(dict)  # by the symbol, what it is in equations that hold
    for case in cases:
        finding = case.finding
        confirmed = finding.equation if finding.kind != "definition" and case.confirmed else None
        if confirmed and _is_circular(confirmed, case.system):
            confirmed = None
        if finding.verdict == "fails" and finding.mends:  # as it is mended it holds
            confirmed = finding.mends[0].equation if case.mends_itself else finding.equation
        for name, meaning in _meanings_used(confirmed) if confirmed else ():
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
            alone = [name for name, _ in _meanings_used(finding.equation) if not used[name]]
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


def _meanings_used(equation: Equation) -> list[tuple[str, Node]]:
    """The symbols of the text that an equation uses, also through definitions, and what they are in it."""
    names = sorted(names_in(equation.sides, equation.definitions) & equation.definitions.keys())
    return [(name.partition("@")[0], equation.definitions[name]) for name in names]  # of what is computed twice each


def _turn_axes(cases: list[_Case]) -> None:
    """Let coordinates hold that a text measures the other way, and what uses them: several points agree, as y downwards."""
    turned, right = defaultdict[str, list[_Case]](list), set[str]()
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
        if (
            not others and letter in ("y", "z") and letter not in right and first.spec.kind not in RODS
        ):  # nothing else shows which way it is measured
            first.doubt(f"it holds if {letter} is measured the other way")
    for letter in (letter for letter, wrong in turned.items() if len(wrong) > 1 and letter not in right):
        for case in (case for case in cases if case.finding.verdict == "fails" and case.finding.equation):
            equation, states = case.finding.equation, random_states(case.system)
            assert equation is not None
            nodes = [part for part in parts(equation.sides) if part.written and part.written.letter == letter]
            instead = {id(node): -evaluate(node, equation.context(states)) for node in nodes}
            off, size = (changed(equation, states, one) for one in (instead, {}))
            if off is not None and size is not None and np.abs(off).max() < TOLERANCE * np.abs(size).max():
                words = f"{letter} is measured the other way"
                case.says(verdict="holds if", condition=words, mends=(), when="", proved=False)


def _objection(case: _Case, cases: list[_Case]) -> str:
    """Why an equation is not accused though it does not hold; empty where it is."""
    finding, one, spec, left = case.finding, case.one, case.spec, case.left
    equation = finding.equation
    if equation is None:
        return ""
    held = [other.one for other in cases if other.finding.verdict == "holds" and other.one.sides]
    if case.mends_itself:
        mended = finding.mends[0].equation
        if finding.mends[0].words.count(" is too many") > 1 or _says_nothing(mended, case.system):
            return f"as I read it, for {spec.title}, it does not hold, and no small change makes it hold"
        if finding.dimensions and (lone := re.fullmatch(r"the term (\S+) is too many", finding.mends[0].words)):
            return f"it holds without {lone[1]}, whose unit does not fit: it may stand for a load"
        right = {key(side) for other in held for side in other.sides}
        own = [n for n, meaning in _meanings_used(equation) if key(meaning) not in right and symbols(meaning) - {"pi"}]
        if own := [name for name in own if name not in ("?s", "?c")]:
            return f"it does not hold, but nothing confirms {own[0].lstrip('?')}, which it uses"
        given = {other.left for other in cases if other.confirmed}
        named = lambda other: other.one.sides[-1].kind == "symbol"  # noqa: E731  a state that gets a name
        doubted = {o.left: o.finding.place for o in cases if o.finding.unknown and o.left and not named(o)}
        for part in parts(one.sides[1:]):
            state = equation.meaning(str(part.value)) in spec.state
            if part.written and part.written in doubted.keys() - given and not state:
                return f"it does not hold, but what {_plain(part.written)} is, {doubted[part.written]}, is not checked"
        new = mended.sides[0].written
        other = left and new and (new.letter != left.letter or " is too many" in finding.mends[0].words)
        if left and other and finding.mends[0].cost > ONE_CHANGE:  # two changes
            return f"it does not hold if {_plain(left)} means {spec.printed.get(str(one.sides[0].value), 'known')}"
    if all(side.kind == "symbol" for side in one.sides) and any(side.value in spec.state for side in one.sides):
        return "it gives a state a name"
    is_entry = lambda one: one.sides[0].kind == "symbol" and str(one.sides[0].value) in ("M11", "M12", "M22")  # noqa: E731
    if is_entry(one) and not any(map(is_entry, held)):
        return "it is not an entry of the mass matrix as it stands; its row may be multiplied by something"
    if spec.kind in RODS and sum(1 for other in cases if other.one.ways) < FEW:
        return ""
    written = {name for o in cases if o.finding.equation for name in _quantities(o.finding.equation, o.spec)}
    again = sum(other.brought == case.brought for other in cases) > 1
    ones = case.brought if again or case.brought - written else frozenset[str]()  # not by mistake
    if ones := ones or _brought_into_bare_sides(case):
        return f"it does not hold, but where {' = '.join(sorted(ones))} = 1"
    rest = one.statement.after  # and what is read next
    after = rest if rest.strip() else "".join(o.one.latex for o in cases if o.one.number == one.number + 1)
    if one.latex.lstrip(" &").startswith("+") or GOES_ON.match(after):
        return "it goes on from what stands before it, or in the next line"
    of_names = lambda node: all(part.kind == "symbol" for part in node.children) or node.kind == "symbol"  # noqa: E731
    sums = [side for side in one.sides if side.kind == "sum"]  # as T - V
    names = bool(sums) and all(side.kind in ("symbol", "sum") and of_names(side) for side in one.sides)
    names = names and not one.names & one.definitions.keys() - {one.defines}  # else it is as wrong as they are
    others = [side for side in one.sides if side.value not in ENERGIES]
    still = len(others) < len(one.sides) and all(symbols(side) <= spec.still for side in others)  # as V = m g h
    if still or (names and not (finding.mends and "sign" in finding.mends[0].words)):
        return "it is a formula in general"
    # what shows that the text is about this system: laws of it that hold, or that one small change makes hold
    here = [o for o in cases if o.spec.kind == spec.kind and o.finding.equation]
    true = [o.finding.equation for o in here if o.confirmed and o.finding.kind != "definition"]
    true = [other for other in true if other and other.names & {*spec.parameters}]
    laws, accused = [other for other in true if _is_law(other, spec)], [o for o in here if o.finding.verdict == "fails"]
    near = sum(_is_near(other) for other in accused if other is not case)
    if not laws and not near and not _is_telling(case):
        return f"as I read it, for {spec.title}, it does not hold; but no other equation shows that it is meant so"
    different = {o.finding.mends[0].words if o.finding.mends else o.one.latex for o in accused}
    support = len(laws if _is_law(equation, spec) else true) + near
    if len(different) - near - _is_near(case) > 2 * support + 1:
        return f"as I read it, for {spec.title}, it does not hold; but too many others do not hold either"
    return ""


def _plain(name: Written) -> str:
    """A name as it is typed."""
    return name.letter + ("_" + name.index if name.index else "")


def _says_nothing(equation: Equation, system: System) -> bool:
    """Whether all sides of an equation are the same number in every state, as g/g and 1."""
    with suppress(Unread, KeyError, ValueError):
        context = equation.context(free_states(system))  # on the true motion every law is 0
        sides = [np.atleast_1d(evaluate(side, context)) for side in equation.sides if side.kind != "number"]
        return all(side.ndim == 1 and np.ptp(side) <= TOLERANCE for side in sides)
    return False


def _is_near(case: _Case) -> bool:
    """Whether one small change, other than a term too many or too few, makes a law of an equation of several terms.

    Or one that makes the dimensions agree.
    """
    if not case.finding.mends or case.finding.mends[0].cost > ONE_CHANGE:
        return False
    mended, words = case.finding.mends[0].equation, case.finding.mends[0].words
    if not case.mends_itself or (case.finding.dimensions and not of_equation(mended, case.spec)[1]):
        return True
    terms = sum(len(part.children) if part.kind == "sum" else 1 for part in mended.sides)
    return terms >= 3 and _is_law(mended, case.spec) and not words.startswith(("the term ", "the factor "))


def _is_telling(case: _Case) -> bool:
    """Whether one small change makes a law of a long equation, which no other change of that many does by chance."""
    mends = case.finding.mends if case.mends_itself else ()
    if not mends or mends[0].cost > ONE_CHANGE or mends[0].words.startswith("the term "):
        return False
    size, mend = sum(1 for _ in parts(case.one.sides)), mends[0]
    another = re.sub(r"\d+", "", mend.old) == re.sub(r"\d+", "", mend.new)  # numbers differ between systems
    return size >= LONG and not another and _is_law(mends[0].equation, case.spec)


def _brought_into_bare_sides(case: _Case) -> set[str]:
    """The parameters that a mend brings into sides without any, as p into p/(m l^2): a text may have set m and l to 1."""
    if not (case.mends_itself and case.finding.equation and case.finding.dimensions):
        return set()
    pairs = zip(case.finding.equation.sides, case.finding.mends[0].equation.sides, strict=False)
    sides = [[symbols(side) & case.spec.still for side in pair] for pair in pairs if key(pair[0]) != key(pair[1])]
    return set().union(*(new for _, new in sides)) if not any(old for old, _ in sides) else set()


def _is_law(equation: Equation, spec: Spec) -> bool:
    """Whether an equation is about more than how points move: a mass, a force, an energy or gravity is in it."""
    names = equation.names
    heavy = any(name == "g" or spec.dimensions.get(name, (0, 0, 0))[0] for name in names)
    return heavy and bool(names & {*spec.parameters})


def _quantities(equation: Equation, spec: Spec) -> frozenset[str]:
    """The coordinates and parameters in an equation."""
    return frozenset(equation.names & {*spec.parameters, *spec.coordinates})


def _follows(equation: Equation, wrong: list[_Case], system: System) -> int:
    """The first wrong equation that another one follows from; 0 for none.

    What it is off by, in each of its components, is what an earlier one is off by, or what follows of that for the motion.
    """
    states, known = random_states(system), list[tuple[int, np.ndarray]]()
    with suppress(Unread, KeyError, ValueError):
        off = stack_residuals(equation, states, plain=True)
        for source in wrong:
            number, other = source.finding.number, source.finding.equation
            assert other is not None
            with suppress(Unread, KeyError, ValueError):
                known += [(number, row) for row in stack_residuals(other, states, plain=True)]
                if source.meaning() in ("L", "T", "V"):
                    context = other.context(states)
                    lefts, true = (euler_lagrange(other.sides[i], system.spec) for i in (-1, 0))
                    pairs = zip(lefts, true, strict=True)
                    known += [(number, evaluate(a, context) - evaluate(b, context)) for a, b in pairs]
        rows = [row for row in off if np.abs(row).max() > TOLERANCE * np.abs(off).max()]
        if any(_is_multiple(row, np.ones_like(row)) for row in rows):
            return 0  # of constants alone each is a multiple of any other
        sources = [next((number for number, other in known if _is_multiple(row, other)), 0) for row in rows]
        if source := min(sources, default=0):
            return source
    return next((case.finding.number for case in wrong if _holds_with(equation, case, system)), 0)


def _holds_with(equation: Equation, source: _Case, system: System) -> bool:
    """Whether an equation holds in the motions that a wrong law allows, with as many of Lagrange's as that needs."""
    names, true, wrong = (
        [f"dd{name}" for name in system.spec.coordinates],
        random_states(system),
        source.finding.equation,
    )
    moving = equation.names & {*names} and "mass" in system.spec.formulas and source.system is system
    if not moving or wrong is None or wrong.energies or equation.energies or not wrong.names & {*names}:
        return False
    base = {**true.base, **{name: true[name] for name in system.spec.unknowns}}
    with suppress(Unread, KeyError, ValueError, np.linalg.LinAlgError), np.errstate(all="ignore"):
        at = [
            Quantities(base | {one: true[one] * 0 + float(one == name) for one in names}, system, np)
            for name in ("", *names)
        ]
        start, *moved = (stack_residuals(wrong, q, plain=True) for q in at)
        own = np.array([there - start for there in moved])  # (coordinates, rows, n): the slopes
        laws = np.einsum("ijn->jin", true["mass"]), -true["force_"]
        kept = np.flatnonzero(np.abs(own).max((0, 2)) > TOLERANCE * np.abs(own).max())[: len(names)]
        for others in combinations(range(len(names)), len(names) - len(kept)):
            slopes = np.concatenate([own[:, kept], laws[0][:, [*others]]], 1)
            offsets = np.concatenate([start[kept], laws[1][[*others]]])
            found = np.linalg.solve(slopes.transpose(2, 1, 0), -offsets.T[..., None])[..., 0].T
            there = Quantities(base | dict(zip(names, found, strict=True)), system, np)
            if relative_error(wrong, there) < TOLERANCE and relative_error(equation, there) < TOLERANCE:
                return True
    return False


def _is_multiple(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether one residual is another times what depends on the parameters alone, which halves of the states share."""
    if one.shape != other.shape or not np.abs(other).min() > 0:
        return False
    first, second = np.split(one / other, 2)
    return bool(np.abs(first - second).max() <= RATIO * np.abs(first).max())
