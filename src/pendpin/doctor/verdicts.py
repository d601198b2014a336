"""The verdicts on a document once each of its equations has one: what they say of each other.

No other reading may explain the section of an accused one as well. A definition is right where an equation that holds,
or is mended, uses it.
"""

from collections import defaultdict
from contextlib import suppress
from dataclasses import replace
from itertools import permutations, product

import numpy as np

from pendpin.doctor.accusations import MANY, POINTS, objection_to, shows_itself
from pendpin.doctor.cases import Case, find_source, is_last_law, meanings_used, plain, says
from pendpin.doctor.checking.conditions import LOAD_RATIO, TINY, load_of, small_angles
from pendpin.doctor.checking.evaluation import ENERGIES, evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, ZERO, Equation, changed, holds, relative_error, stack_residuals
from pendpin.doctor.reading.names import INERTIA, LENGTH
from pendpin.doctor.reading.tree import Node, Unread, Written, key, names_in, parts, with_meaning
from pendpin.doctor.recognition import Reading, Recognition
from pendpin.doctor.report import Finding
from pendpin.doctor.systems.base import System, Values, free_states, random_states
from pendpin.doctor.systems.rod import RODS
from pendpin.doctor.systems.tables import POSES

EQUALLY = 0.3  # equations: readings that explain about as much
LITTLE = 0.2  # of the equations of a text


def judge(findings: list[Finding], found: Recognition) -> list[Finding]:
    """The findings of a document, weighed against each other."""
    cases = [Case(*three) for three in zip(findings, found.equations, found.chosen, strict=True)]
    small = {case.one.statement.section for case in cases if "small" in case.finding.condition}
    for case in cases:  # beside laws of small angles an energy is one of these too
        equation = case.finding.equation if case.one.statement.section in small else None
        if case.finding.verdict == "fails" and equation and (words := small_angles(equation, case.system, True)):
            case.says(verdict="holds if", condition=words, when="", proved=False)
    solutions = [case.finding.equation for case in cases if case.finding.kind == "solution"]
    own = {key(node) for equation in solutions if equation for node in equation.definitions.values()}
    for case in cases:  # what a solution takes a letter to be, as the frequency of a damped swing
        solves = case.finding.verdict in ("fails", "not checked") and len(case.one.sides) == 2
        if solves and case.left and key(case.one.sides[1]) in own:
            said = {"mends": (), "when": "", "remark": "a solution holds with it", "proved": False}
            case.says(verdict="holds", kind="relation", **said)
    _doubt_what_others_explain(cases, found)
    _doubt_definitions(cases)
    _doubt_loads_of_one(cases)
    _doubt_loads_of_another_size(cases)
    if not found.main.chosen:
        _turn_axes(cases)
        for case in (case for case in cases if case.finding.verdict == "fails"):
            if other := _other_system(case, found):  # as that of a page that comes before a cart
                case.doubt(f"it does not hold for {case.spec.title}, but for {other.title}: say which with --rod")
        for case, words in [(case, objection_to(case, cases)) for case in cases if case.finding.verdict == "fails"]:
            case.doubt(words)
        _doubt_what_is_said_otherwise(cases)
        _doubt_definitions(cases)  # nor does what is no longer accused confirm what it uses
        # nor does what uses a quantity hold without gravity where the text gives that quantity otherwise
        given = {case.meaning(): case for case in cases if case.left and case.finding.equation and not case.confirmed}
        for case in (case for case in cases if case.finding.condition == "there is no gravity"):
            names = case.finding.equation.names & given.keys() if case.finding.equation else set[str]()
            inside = (given[name] for name in sorted(names))
            if other := next((other for other in inside if other is not case and other.spec is case.spec), None):
                words = f"it holds if there is no gravity, but equation {other.one.number} does not, which it uses"
                case.doubt(words, condition="")
        driven = [
            (one, law.names) for one in cases if one.is_true and (law := one.finding.equation) and "nu" in law.names
        ]
        laws = all(names & {"ddtheta", "domega", "alpha"} for _, names in driven)
        for case, _ in driven if laws else ():  # no other line says where the pivot begins
            if " -" in case.spec.kind:
                case.doubt(f"it holds for {case.spec.title}, and nothing says that its pivot begins there")
        for i, case in enumerate(cases):  # nothing says that a section alone measures its angles as it does
            other = {*case.system.kind.split()} ^ {*found.main.system.kind.split()}  # the same system in other angles
            other = other and other <= {*POSES, "mirrored"}
            if case.finding.verdict == "holds" and other and case.reading.credits[i] and not found.main.credits[i]:
                case.doubt(f"it holds if angles are measured otherwise than in most of the text: {case.reading.title}")
    wrong: list[Case] = []
    for case in cases:
        finding = case.finding
        doubtful = finding.doubtful and not finding.mends and not case.reading.unknown
        if (finding.verdict == "fails" or doubtful) and finding.equation:
            if (source := find_source(finding.equation, wrong, case.system)) and not finding.follows:
                case.says(verdict="fails", proved=True, follows=source, remark="")
            elif finding.verdict == "fails":
                wrong.append(case)
    for case in cases:  # where the change of a definition mends what uses it, that alone is wrong
        finding = case.finding
        if finding.verdict == "fails" and finding.mends and finding.follows and not case.mends_itself:
            at = finding.mends[0].words.rpartition(", ")[2]
            mends = tuple(replace(m, words=m.words.partition(" in the definition of ")[0]) for m in finding.mends)
            said = {"error": finding.error, "when": finding.when, "remark": f"equation {finding.number} uses it"}
            cases[finding.follows - 1].says(verdict="fails", proved=finding.proved, mends=mends, **said)
            case.doubt(f"it uses a wrong definition, {at}", follows=0)
    if not found.main.chosen and len(cases) > MANY and found.main.system.kind not in RODS:
        _doubt_where_little_holds(cases)
    return [case.finding for case in cases]


def _doubt_where_little_holds(cases: list[Case]) -> None:
    """Take back the accusations of a text of which little or not even twice as much holds: it is rather read wrongly.

    What one change makes hold is read rightly where it is very long, or the last of the laws of all coordinates.
    """
    right = sum(case.confirmed and says(case.one) for case in cases)
    wrong = [case for case in cases if case.finding.verdict == "fails"]
    wrong = [case for case in wrong if not (shows_itself(case) or is_last_law(case, cases))]
    little = sum(case.confirmed for case in cases) < LITTLE * len(cases)
    if little or right < 2 * sum(not case.finding.follows for case in wrong):
        for case in wrong:
            case.doubt(f"it does not hold for {case.spec.title}; but too little of this text does", follows=0)


def _doubt_what_others_explain(cases: list[Case], found: Recognition) -> None:
    """Take back accusations of what another reading explains that explains the section about as well.

    Of two readings that explain equally much, each of which breaks what the other one saves, neither is the right one.
    """
    for i, case in enumerate(cases):
        mine = case.reading
        here = [k for k, other in enumerate(cases) if other.reading is mine and found.close[k] is found.close[i]]
        for less, one in found.close[i]:
            if case.finding.verdict == "fails" and one.credits[i] > 0:
                case.doubt(f"it does not hold for {mine.title}, but for {one.title}: say which is meant with --rod")
            breaks = case.finding.verdict == "holds" and mine.credits[i] > 0 and not one.credits[i] and less < EQUALLY
            if breaks and (saved := [k for k in here if one.credits[k] >= 1 and not mine.credits[k]]):
                other = cases[saved[0]].finding
                words = f"it contradicts equation {other.number}, {other.place}: one of the two is wrong"
                case.doubt(words, when="in every motion")


def _other_system(case: Case, found: Recognition) -> Reading | None:
    """Another system, with angles from the same side, for which what is accused holds as it stands; None for none.

    What moves here moves there.
    """
    (family, *kind), i, equation = case.spec.kind.split(), case.finding.number - 1, case.finding.equation
    inside = [part for part in parts(case.one.sides) if part.written]
    moving = {part.written for part in inside if equation and equation.meaning(str(part.value)) in case.spec.state}
    moves = equation and equation.names & {*case.spec.state, *case.spec.unknowns}
    for other in found.others if moves and family not in RODS else ():
        (name, *words), there = other.system.kind.split(), other.equations[i]
        own = {part.written for part in parts(there.sides) if str(part.value).startswith("?")}
        right = other.credits[i] >= 1 and not there.lacking and not own & moving
        poses = [pose for pose in (*POSES, "mirrored") if pose in {*kind} ^ {*words}]  # one alone where one has none
        if right and name not in (family, *RODS) and len(poses) < 2 and "mirrored" not in poses:
            return other
    return None


def _doubt_what_is_said_otherwise(cases: list[Case]) -> None:
    """Doubt an equation that holds only because a letter is not what another line of its section says.

    v_2 = l_2 w_2 is not the speed of the second of two bobs; so T_2 = m_2 v_2^2/2 is not its kinetic energy there. Where
    x_1 = l_1 sin(theta_1)/2 is a centre of mass, x_2 = x_1 + l_2 sin(theta_2)/2 is not the other one.
    """
    said = [case for case in cases if case.left and len(case.one.sides) == 2 and case.one.sides[1].names - {"pi"}]
    said = [one for one in said if one.finding.kind not in ("condition", "definition", "unread")]
    # nor l(t) = l + s
    said = [one for one in said if not any(part.written == one.left for part in parts(one.one.sides[1:]))]
    said = [one for one in said if one.unit in POINTS or (one.unit == INERTIA and one.meaning() in one.spec.still)]
    for case in cases:
        equation, here = case.finding.equation, dict[Written, Case]()
        if case.finding.verdict != "holds" or equation is None:
            continue
        for one in said:  # a moment of inertia may be given below
            before = one.finding.number < case.finding.number or one.unit == INERTIA
            if before and one.left and one.one.statement.section == case.one.statement.section:
                here[one.left] = one
        for name, one in here.items():
            meanings = [equation.meaning(str(part.value)) for part in parts(equation.sides) if part.written == name]
            same = any(case.spec.dimensions.get(meaning) == one.unit for meaning in meanings)
            if same and name != case.left and one.finding.verdict != "holds if":
                sides = equation.sides[0], *(with_meaning(side, name, "?said") for side in equation.sides[1:])
                value, own = one.one.sides[1], one.finding.equation.meanings if one.finding.equation else {}
                lengths = {name: what for name, what in own.items() if name in ENERGIES}  # as L there
                known, meant = equation.definitions | {"?said": value}, lengths | equation.meanings
                instead = replace(equation, sides=sides, definitions=known, meanings=meant)
                with suppress(Unread):
                    if relative_error(instead, random_states(case.system)) >= TOLERANCE:
                        case.doubt(f"it does not hold with {plain(name)} as {one.finding.place} says")


def _doubt_loads_of_one(cases: list[Case]) -> None:
    """Doubt an acceleration with a load that the other one lacks: what acts on one coordinate moves both."""
    given = ((one, one.finding.equation) for one in cases if one.confirmed and one.left and says(one.one))
    solved = [(one, law.names) for one, law in given if law and law.names & {*one.spec.unknowns} == {one.meaning()}]
    for (case, _), (other, names) in permutations(solved, 2):
        beside = case.system is other.system and case.meaning() != other.meaning()
        if beside and (lacking := _loads(case) - names):
            names = " and ".join(sorted(name.lstrip("?") for name in lacking))
            case.doubt(
                f"it holds without {names}, which equation {other.finding.number} beside it does not have", unknown=()
            )


def _doubt_loads_of_another_size(cases: list[Case]) -> None:
    """Doubt what holds with a load that does not act in it as it does in most of its section, as A/(m l) for A/(m l^2).

    Of several coordinates each may have its own, as a damping b at each of two joints.
    """
    acting = defaultdict[tuple[int, str], list[tuple[Case, tuple[str, Values]]]](list)
    for case in (case for case in cases if len(case.spec.coordinates) == 1):
        equation = case.finding.equation if case.finding.verdict == "holds" and case.finding.remark else None
        for name in _loads(case) if equation else ():
            if equation and (load := load_of(equation, case.system, {name})):
                acting[case.one.statement.section, name].append((case, load))
    for (_, name), pairs in acting.items():
        for case, (kind, size) in pairs:
            same = [k == kind and bool(np.allclose(n, size, LOAD_RATIO)) for _, (k, n) in pairs]
            if 2 * sum(same) <= len(same):
                other = pairs[same.index(False)][0].finding
                words = f"{name.lstrip('?')} acts in it otherwise than in equation {other.number}, {other.place}"
                case.doubt(words, when="in every motion")


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
        alone = finding.kind == "definition" or _is_derivative(finding.equation, case.system)
        confirmed = finding.equation if case.confirmed and not alone else None
        if finding.verdict == "fails" and finding.mends:  # as it is mended it holds
            confirmed = finding.mends[0].equation if case.mends_itself else finding.equation
        for name, meaning in meanings_used(confirmed) if confirmed else ():
            if f"definition of {name.lstrip('?')}," not in (finding.mends[0].words if finding.mends else ""):
                used[name][key(meaning)] = meaning
    lagrange = dict[str, int]()  # of what a doubtful equation says that it obeys Lagrange, and that equation's number
    for case in cases:
        inside = names_in(case.one.sides, {}) - {*case.spec.state}
        derived = any(part.kind == "derivative" for part in parts(case.one.sides))
        if case.finding.doubtful and derived and len(inside) == 1:
            lagrange.setdefault(inside.pop(), case.finding.number)
    for case in cases:
        one, finding = case.one, case.finding
        if finding.verdict != "holds":
            continue
        if finding.kind == "definition" and one.defines in lagrange:
            words = f"equation {lagrange[one.defines]}, which says that it obeys Lagrange, does not hold with it"
            case.doubt(words, unknown=(one.defines,))
            continue
        if finding.kind == "definition" and len(one.sides) == 2:
            own = one.definitions[one.defines]
            if loads := one.unknown - {one.defines}:  # a solution shows that it is right, whatever these are
                solutions = (o.finding.equation for o in cases if o.finding.kind == "solution")
                solves = any(equation and one.defines in equation.definitions for equation in solutions)
                alike = _act_alike(cases, one.defines, loads)
                if not (all(alike) if alike else solves):
                    load, name = min(loads).lstrip("?"), one.defines.lstrip("?")
                    words = f"the symbol {load} is not known: say what it is with --symbols"
                    words = f"{load} acts otherwise with {name} than without it" if alike else words
                    case.doubt(words, unknown=tuple(sorted(loads)))
            elif not any(
                key(own) == key(other)
                or holds(Equation((own, other), definitions=one.definitions), random_states(case.system))
                for other in used[one.defines].values()
            ):
                words = f"no equation that holds uses {one.defines.lstrip('?')} as it is defined here"
                case.doubt(words, mends=finding.mends, unknown=(one.defines,))
        elif finding.equation and _is_derivative(finding.equation, case.system):
            names = [name.lstrip("?") for name, _ in meanings_used(finding.equation) if not used[name]]
            case.doubt(f"it holds by what {names[0]} is here, and nothing else confirms that" if names else "")


def _act_alike(cases: list[Case], name: str, loads: set[str]) -> list[bool]:
    """Of each equation with a name and each without whether a load is as large, as with 2 gamma and with c."""
    found: dict[bool, list[tuple[str, Values]]] = {True: [], False: []}
    for case in (case for case in cases if case.confirmed and len(case.spec.coordinates) == 1 and len(loads) == 1):
        equation, load = case.finding.equation, None
        if equation and all(equation.definitions.get(one) == ZERO for one in loads):
            load = load_of(equation, case.system, loads, TINY if "small" in case.finding.condition else 1.0)
        found[name in case.one.names] += [load] if load else []
    pairs = product(found[True], found[False])
    return [one == two and bool(np.allclose(size, other, LOAD_RATIO)) for (one, size), (two, other) in pairs]


def _is_derivative(equation: Equation | None, system: System) -> bool:
    """Whether an equation is a derivative by a rate of what the text defines, which is true of any function."""
    if equation is None or not equation.definitions.keys() & names_in(equation.sides, {}):
        return False
    variables = {str(part.value) for part in parts(equation.sides) if part.kind == "derivative"}
    return bool(variables & {*system.spec.rates}) and holds(equation, free_states(system))


def _turn_axes(cases: list[Case]) -> None:
    """Let coordinates hold that a text measures otherwise, and what uses them.

    They may begin at another point, as y = l - l cos theta. Of the other direction, as y downwards, several points agree.
    """
    turned, right = defaultdict[str, list[Case]](list), set[str]()
    for case in cases:
        finding, spec = case.finding, case.spec
        if case.left and case.confirmed:  # y_0 = y_1 holds with y downwards, too
            right |= set() if _holds_turned(case, case.left.letter) else {case.left.letter}
        elif case.left and finding.verdict == "fails" and finding.mends:
            name = case.meaning()
            place = spec.dimensions.get(name) == LENGTH and name not in {*spec.parameters, *spec.coordinates}
            if place and _is_offset(case):
                words = f"{plain(case.left)} is measured from another point"
                case.says(verdict="holds if", condition=words, mends=(), when="", proved=False)
            elif place and finding.mends[0].words.startswith("the sign of "):
                turned[case.left.letter].append(case)
    with_g = [case for case in cases if case.is_true and "g" in {name.letter for name in case.written}]
    for letter in ("g", *sorted(({"y", "z"} | turned.keys()) - right)):
        words = f"{letter} is measured the other way" if letter != "g" else "gravity points the other way"
        wrong = [case for case in cases if case.finding.verdict == "fails" and _holds_turned(case, letter)]
        # as of angles below the horizontal: of gravity more than one agree, and more than say otherwise
        falls = letter == "g" and len(wrong) > max(1, sum(not _holds_turned(case, "g") for case in with_g))
        for case in wrong:
            if falls or len(turned[letter]) > 1:
                case.says(verdict="holds if", condition=words, mends=(), when="", proved=False)
            elif letter in ("y", "z") and case.spec.kind not in RODS:  # nothing shows which way
                case.doubt(f"it holds if {words}")
    places = [case.left.letter for case in cases if case.left and case.is_true and case.unit == LENGTH]
    unsaid = {*"yz"} - right.intersection(places)
    for case in (case for letter in unsaid for case in turned[letter] if case.spec.kind not in RODS):
        equation = case.finding.equation if case.finding.verdict == "fails" else None
        if equation and {*case.finding.mends[0].swaps} <= {*map(id, equation.sides)}:  # of a whole side
            case.doubt(f"it holds if {plain(case.left) if case.left else ''} is measured the other way")


def _is_offset(case: Case) -> bool:
    """Whether the sides of an equation differ by what does not move, which the halves of the states share."""
    if case.finding.equation is None or case.finding.dimensions:
        return False
    with suppress(Unread):
        rows = stack_residuals(case.finding.equation, random_states(case.system), plain=True)
        first, second = np.split(rows, 2, axis=1)
        return bool(np.abs(first - second).max() < TOLERANCE * np.abs(rows).max())
    return False


def _holds_turned(case: Case, letter: str) -> bool:
    """Whether an equation holds with the coordinates of a letter reversed."""
    equation, states = case.finding.equation, random_states(case.system)
    if equation is None:
        return False
    named = [(part, equation.definitions.get(str(part.value), part).written) for part in parts(equation.sides)]
    nodes = [part for part, written in named if written and written.letter == letter]  # or another name of it
    with suppress(Unread):
        instead = {id(node): -evaluate(node, equation.context(states)) for node in nodes}
        off, size = changed(equation, states, instead), max((np.abs(x).max() for x in instead.values()), default=0.0)
        return off is not None and bool(np.abs(off).max() < TOLERANCE * size)
    return False
