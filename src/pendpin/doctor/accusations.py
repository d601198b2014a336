"""What an accusation rests on: why an equation that does not hold is not accused, and from which wrong one it follows.

An accusation needs a reading that other equations bear out: they hold with it, or one small change makes laws of them too;
or the equation is so long that a small change makes no law of it by chance.
"""

import re
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from itertools import combinations

import numpy as np

from pendpin.doctor.checking.check import euler_lagrange
from pendpin.doctor.checking.evaluation import Equation, evaluate, names_in
from pendpin.doctor.checking.residuals import TOLERANCE, holds, of_equation, stack_residuals
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.tree import Node, Unread, Written, key, parts, symbols
from pendpin.doctor.recognition import FEW, Reading
from pendpin.doctor.report import Finding
from pendpin.doctor.systems.base import Quantities, Spec, System, free_states, random_states
from pendpin.doctor.systems.rod import RODS

RATIO = 1e-7  # of two residuals that are multiples of each other: of second derivatives eight digits are left
# the line after an equation, if it is the rest of it
GOES_ON = re.compile(r"(?:[\s&$\\{}]|\\q?quad|\\[,;:!]|\\hspace\{[^}]*\}|\\left|\\right)*(?:[+−]|-\s*[\d½(\\])")
ONE_CHANGE = 1.9  # what two changes cost more than
LONG = 20  # parts of an equation that is no law by chance
INERTIA = (1, 2, 0)  # powers of kg, m, s
ENERGIES = ("T", "V", "L", "E")
TURNING = ("C11", "C12", "C21", "C22", "D11", "D12")  # entries of a matrix that is not unique


class Case:
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

    @cached_property
    def motions(self) -> list[Quantities]:
        """The motions that it allows as a law though it is wrong, with as many of Lagrange's equations as that needs."""
        names, true, law = (
            [f"dd{name}" for name in self.spec.coordinates],
            random_states(self.system),
            self.finding.equation,
        )
        if law is None or law.energies or not law.names & {*names} or "mass" not in self.spec.formulas:
            return []
        base = {**true.base, **{name: true[name] for name in self.spec.unknowns}}
        found = list[Quantities]()
        with suppress(Unread, KeyError, ValueError, np.linalg.LinAlgError), np.errstate(all="ignore"):
            trials = ({one: true[one] * 0 + float(one == name) for one in names} for name in ("", *names))
            at_rest, *moved = (
                stack_residuals(law, Quantities(base | trial, self.system, np), plain=True) for trial in trials
            )
            slopes = np.array([there - at_rest for there in moved])  # (coordinates, rows, n)
            kept = np.flatnonzero(np.abs(slopes).max((0, 2)) > TOLERANCE * np.abs(slopes).max())[: len(names)]
            for others in map(list, combinations(range(len(names)), len(names) - len(kept))):
                rows = np.concatenate([slopes[:, kept].transpose(1, 0, 2), true["mass"][others]])
                offs = np.concatenate([at_rest[kept], -true["force_"][others]])
                solution = np.linalg.solve(rows.transpose(2, 0, 1), -offs.T[..., None])[..., 0].T
                there = Quantities(base | dict(zip(names, solution, strict=True)), self.system, np)
                found += [there] * holds(law, there)
        return found

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


def objection_to(case: Case, cases: list[Case]) -> str:
    """Why an equation is not accused though it does not hold; empty where it is."""
    finding, one, spec, equation = case.finding, case.one, case.spec, case.finding.equation
    if equation is None:
        return ""
    held = [other.one for other in cases if other.finding.verdict == "holds" and other.one.sides]
    if words := _objection_to_mend(case, cases, equation, held) or _objection_to_kind(case, held):
        return words
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


def _objection_to_mend(case: Case, cases: list[Case], equation: Equation, held: list[Printed]) -> str:
    """Why the first mend of an equation, or a name that it uses, accuses nobody; empty where it may."""
    finding, one, spec, left = case.finding, case.one, case.spec, case.left
    if not case.mends_itself:
        return ""
    mended = finding.mends[0].equation
    if finding.mends[0].words.count(" is too many") > 1 or _says_nothing(mended, case.system):
        return f"as I read it, for {spec.title}, it does not hold, and no small change makes it hold"
    matrices = any(part.kind == "matrix" for part in parts(mended.sides))  # whose entries have several units
    if finding.dimensions and of_equation(mended, spec)[1] and not matrices:
        return f"as I read it, for {spec.title}, it does not hold; nor do the units of its letters agree"
    old, shown = (re.sub("sin|cos", "", text) for text in (finding.mends[0].old, finding.mends[0].new))
    if old == shown and (finding.mends[0].count > 1 or " places" in finding.mends[0].words):  # sin for cos, twice
        return f"as I read it, for {spec.title}, it does not hold; it may measure its angles otherwise"
    if finding.dimensions and (lone := re.fullmatch(r"the term (\S+) is too many", finding.mends[0].words)):
        return f"it holds without {lone[1]}, whose unit does not fit: it may stand for a load"
    right = {key(side) for other in held for side in other.sides}
    own = [n for n, meaning in meanings_used(equation) if key(meaning) not in right and symbols(meaning) - {"pi"}]
    if own := [name for name in own if name not in ("?s", "?c")]:
        return f"it does not hold, but nothing confirms {own[0].lstrip('?')}, which it uses"
    given = {other.left for other in cases if other.confirmed}
    named = lambda other: other.one.sides[-1].kind == "symbol"  # noqa: E731  a state that gets a name
    doubted = {o.left: o.finding.place for o in cases if o.finding.unknown and o.left and not named(o)}
    for part in parts(one.sides[1:]):
        state = equation.meaning(str(part.value)) in spec.state
        if part.written and part.written in doubted.keys() - given and not state:
            return f"it does not hold, but what {plain(part.written)} is, {doubted[part.written]}, is not checked"
    new = mended.sides[0].written
    other = left and new and (new.letter != left.letter or " is too many" in finding.mends[0].words)
    another = left and new and new.letter != left.letter and left not in given
    another = another and [*map(key, mended.sides[1:])] == [*map(key, one.sides[1:])]  # nothing but its name
    if left and another:
        return f"nothing shows what {plain(left)} means here"
    if left and other and finding.mends[0].cost > ONE_CHANGE:  # two changes
        return f"it does not hold if {plain(left)} means {spec.printed.get(str(one.sides[0].value), 'known')}"
    return ""


def _objection_to_kind(case: Case, held: list[Printed]) -> str:
    """Why what an equation is about may be meant otherwise: a name of a state, an inertia, an entry of a matrix."""
    finding, one, spec, left = case.finding, case.one, case.spec, case.left
    if all(side.kind == "symbol" for side in one.sides) and any(side.value in spec.state for side in one.sides):
        return "it gives a state a name"
    if (
        left
        and {"point", "furuta"} & {*spec.kind.split()}
        and not finding.dimensions
        and spec.dimensions.get(case.meaning()) == INERTIA
    ):
        return f"as I read it, for {spec.title}, it does not hold; an inertia may be that of another body"
    if one.sides[0].kind == "symbol" and str(one.sides[0].value) in TURNING:
        return "the matrix of velocity terms is not unique: this is another entry than the one that I know"
    is_entry = lambda one: one.sides[0].kind == "symbol" and str(one.sides[0].value) in ("M11", "M12", "M22")  # noqa: E731
    if is_entry(one) and not any(map(is_entry, held)):
        return "it is not an entry of the mass matrix as it stands; its row may be multiplied by something"
    return ""


def plain(name: Written) -> str:
    """A name as it is typed."""
    return name.letter + ("_" + name.index if name.index else "")


def _says_nothing(equation: Equation, system: System) -> bool:
    """Whether all sides of an equation are the same number in every state, as g/g and 1."""
    with suppress(Unread, KeyError, ValueError):
        context = equation.context(free_states(system))  # on the true motion every law is 0
        sides = [np.atleast_1d(evaluate(side, context)) for side in equation.sides if side.kind != "number"]
        return all(side.ndim == 1 and np.ptp(side) <= TOLERANCE for side in sides)
    return False


def _is_near(case: Case) -> bool:
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


def _is_telling(case: Case) -> bool:
    """Whether one small change makes a law of a long equation, which no other change of that many does by chance."""
    mends = case.finding.mends if case.mends_itself else ()
    if not mends or mends[0].cost > ONE_CHANGE or mends[0].words.startswith("the term "):
        return False
    size, mend = sum(1 for _ in parts(case.one.sides)), mends[0]
    another = re.sub(r"\d+", "", mend.old) == re.sub(r"\d+", "", mend.new)  # numbers differ between systems
    return size >= LONG and not another and _is_law(mends[0].equation, case.spec)


def _brought_into_bare_sides(case: Case) -> set[str]:
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


def find_source(equation: Equation, wrong: list[Case], system: System) -> int:
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
    if equation.energies or not equation.names & {f"dd{name}" for name in system.spec.coordinates}:
        return 0
    with np.errstate(all="ignore"):
        alike = (case for case in wrong if case.system is system)
        return next((one.finding.number for one in alike if any(holds(equation, there) for there in one.motions)), 0)


def _is_multiple(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether one residual is another times what depends on the parameters alone, which halves of the states share."""
    if one.shape != other.shape or not np.abs(other).min() > 0:
        return False
    first, second = np.split(one / other, 2)
    return bool(np.abs(first - second).max() <= RATIO * np.abs(first).max())


def meanings_used(equation: Equation) -> list[tuple[str, Node]]:
    """The symbols of the text that an equation uses, also through definitions, and what they are in it."""
    names = sorted(names_in(equation.sides, equation.definitions) & equation.definitions.keys())
    return [(name.partition("@")[0], equation.definitions[name]) for name in names]  # of what is computed twice each
