"""From statements to equations that can be checked: every reading of a text, and the likeliest of them."""

from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, lru_cache

import numpy as np

from pendpin.doctor.checking.residuals import TOLERANCE, Equation, holds, of_equation, relative_error
from pendpin.doctor.reading.documents import Statement
from pendpin.doctor.reading.grammar import parse
from pendpin.doctor.reading.names import CONSTANTS, ENERGY, INERTIA, LENGTH, UNIT_VECTORS, Vocabulary, bound
from pendpin.doctor.reading.states import as_derivatives, dampings, find_rename, highest_rate
from pendpin.doctor.reading.tokens import is_latex, tokens
from pendpin.doctor.reading.tree import (
    Mismatch,
    Name,
    Node,
    Rename,
    Unread,
    Written,
    divide,
    key,
    names_in,
    parts,
    rename,
    walk,
)
from pendpin.doctor.systems.base import LOADS, Spec, System, random_states
from pendpin.doctor.systems.rod import SPECS

MOST_BRACKETS = 120  # places that are tried for a missing one
MOST_NODES, MOST_SIDES = 2_000, 20  # of an equation that is checked
MOST_KNOWN = 50_000  # verdicts on equations that are remembered
SOME = Fraction(7, 10)  # what a function of time alone is at an instant

THIN = System(SPECS["thin"])
Candidate = tuple[Equation, float]  # and its relative error

NOTHING = Vocabulary()  # before a system gives its words


@dataclass(frozen=True, eq=False)
class Printed:
    """One equation of a statement, read from `text`, which may hold a bracket more than was printed."""

    statement: Statement
    number: int
    latex: str  # as printed
    text: str
    index: int
    words: Vocabulary = NOTHING
    ways: tuple[tuple[tuple[Node, ...], bool], ...] = ()  # sides, and whether 3g/2l is read as 3g/(2l)
    reason: str = ""  # why it cannot be read
    remark: str = ""
    defines: str = ""  # the symbol that it gives a meaning to
    definitions: dict[str, Node] = field(default_factory=dict)
    alone: bool = True  # no other equation stands in its text
    renamed: Rename | None = None  # what its names became before they had a meaning, as y[1] a rate

    def readings(self) -> Iterator[Equation]:
        """Every way to read it, the likeliest first."""
        for sides, tight in self.ways:
            yield from Equation(squared(sides), definitions=self.definitions, tight=tight).readings(self.words)

    @cached_property
    def sound(self) -> list[Equation]:
        """The readings whose dimensions agree."""
        return [one for one in self.readings() if not of_equation(one, self.words.spec)[1]]

    @cached_property
    def meant(self) -> list[Equation]:
        """These; all where there are none, as where a length of 1 is not written."""
        return self.sound or [*self.readings()]

    @cached_property
    def letters(self) -> set[Name]:
        """The letters with their indices that stand in it."""
        return letters_in(self.sides)

    @cached_property
    def strange_rates(self) -> set[tuple[str, str]]:
        """The symbols without a meaning whose rates stand in it, and how they are printed, but for any coordinate q_i."""
        rates = (node.children[0] for node in parts(self.sides) if node.kind == "derivative" and node.value == "t")
        found = ((str(p.value), p.written) for p in rates if p.written and str(p.value).startswith("?"))
        return {(name, w.letter + w.index) for name, w in found if w.letter != "q" or w.index in ("1", "2")}

    def read_again(self, text: str, tight: bool) -> list[tuple[Node, ...]]:
        """The sides of each equation of a changed text, its names meaning the same. Raises Unread."""
        equations = parse(text, tight=tight)
        if self.renamed:
            equations = [[rename(side, self.renamed) for side in sides] for sides in equations]
        first = [as_derivatives(_styled(tuple(sides)))[0] for sides in equations]
        return [tuple(bound(side, self.words) for side in sides) for sides in first]

    @property
    def sides(self) -> tuple[Node, ...]:
        """Its sides as it is read first; none where it cannot be read."""
        return self.ways[0][0] if self.ways else ()

    @cached_property
    def names(self) -> set[str]:
        """The symbols in it as it is read first."""
        return names_in(self.sides, {})

    @property
    def unknown(self) -> set[str]:
        """The symbols in it that have no meaning."""
        return self._without_meaning(self.names)

    @cached_property
    def lacking(self) -> set[str]:
        """The symbols in it and in the definitions that it uses that have no meaning."""
        return self._without_meaning(self.names.union(*(node.names for node in self.definitions.values())))

    def _without_meaning(self, names: set[str]) -> set[str]:
        every = (name for name in names - CONSTANTS - self.definitions.keys() if name.startswith("?"))
        return {name for name in every if name.rpartition("_")[0] not in self.definitions}


def squared(sides: tuple[Node, ...]) -> tuple[Node, ...]:
    """The sides, squared where a speed is set equal to a root, whose sign is that of the motion."""
    left, right = sides if len(sides) == 2 else (None, None)
    if left is None or right is None or left.written is None or right.kind != "function" or right.value != "sqrt":
        return sides
    speed = left.kind == "symbol" and (left.written.dots == 1 or left.written.letter == "v")
    end = left.span[1]
    return (Node("power", left.span, Fraction(2), (left,), ((end, end),)), right.children[0]) if speed else sides


def letters_in(sides: Iterable[Node]) -> set[Name]:
    """The letters with their indices in some expressions."""
    return {part.written.name for part in parts(sides) if part.written}


def parse_statements(statements: tuple[Statement, ...]) -> list[Printed]:
    """The equations of some statements, numbered, as they are written."""
    found: list[Printed] = []
    for statement in statements:
        found += _of_statement(statement, len(found) + 1)
    return found


def name_states(found: list[Printed]) -> list[Printed]:
    """Equations as they are written with the names that they give states, rates and bodies themselves."""
    change = find_rename([one.sides for one in found])
    ways = ([(tuple(rename(side, change) for side in sides), tight) for sides, tight in one.ways] for one in found)
    return [replace(one, ways=tuple(way), renamed=change) for one, way in zip(found, ways, strict=True)]


class Text:
    """The equations of a text. Each is bound once for all words that agree on its letters and on what it uses."""

    def __init__(self, raw: list[Printed]) -> None:
        self.raw, self._bound = raw, dict[tuple, Printed]()
        self.letters = set[Name]().union(*(one.letters for one in raw))
        self._names = list[tuple[Node, ...]]()  # before a side alone, which is the left side if it is a quantity's
        for one in raw:
            alone = one.statement.name and one.ways and len(one.ways[0][0]) == 1
            found = list[list[Node]]()
            with suppress(Unread):
                found = parse(one.statement.name) if alone else found
            self._names.append((replace(found[0][0], span=(0, 0)),) if [*map(len, found)] == [1] else ())
        # the letters that tell what each means: u is one of the matrix B
        self._telling = [
            sorted(one.letters | letters_in(name) | {("u", "")}) for one, name in zip(raw, self._names, strict=True)
        ]
        self._letters, self._dampings = set[Name]().union(*self._telling), dampings([one.sides for one in raw])

    def own_words(self, words: Vocabulary) -> Vocabulary:
        """Some words, where letters that the text uses otherwise do not stand for what they usually do."""
        while True:
            words = words.among(self.letters)
            if not (own := _own_letters(self._with_meanings(words), words, self._dampings)):
                return words
            words = replace(words, chosen=words.chosen | own)

    def _with_meanings(self, words: Vocabulary) -> list[Printed]:
        """The equations with the meanings that some words give their letters."""
        system = words.spec.kind.split()[0] if words.spec else ""
        meanings = {name: words.meanings_of(name) for name in self._letters}
        found = []
        for i, one in enumerate(self.raw):
            mark = (i, system, *(meanings[name] for name in self._telling[i]))
            if mark not in self._bound:
                every = [(each, tight) for sides, tight in one.ways for each in as_derivatives(_styled(sides))]
                meant = ((tuple(bound(side, words) for side in sides), tight) for sides, tight in every)
                ways = [(_with_drives(sides, words), tight) for sides, tight in meant]
                for left in (bound(name, words) for name in self._names[i]):
                    if left.kind == "symbol" and not left.value.startswith("?"):
                        ways = [((left, *sides), tight) for sides, tight in ways] + ways
                self._bound[mark] = replace(one, words=words, ways=tuple(ways))
            found.append(self._bound[mark])
        return found

    def bind(self, words: Vocabulary, inside: np.ndarray | None = None) -> list[Printed]:
        """The equations, or those `inside` a section, with the meanings that some words give and the symbols of the text.

        A symbol has the meaning that the last definition before it gave it, or the first one after it, or the usual one.
        """
        bare, made = self._with_meanings(words), list[tuple[int, str, Node]]()
        for i, one in enumerate(bare):
            old = {name for _, name, _ in made} if one.statement.chained else set[str]()
            before = set() if is_latex(one.text) else {name for _, name, _ in made}
            made += [(i, *each) for each in _definitions(one, words.given, before) if each[0] not in old]
        # what is computed is no name of what stands before it, as acc in v_dot = acc
        computed = {one.sides[0].value for one in bare if len(one.sides) == 2 and one.sides[1].children}
        made = [one for one in made if bare[one[0]].sides[0].value == one[1] or one[1] not in computed]
        first = {name: place for place, name, _ in reversed(made)}
        made = [one for one in made if first[one[1]] < one[0] or one[1] not in one[2].names]
        # a damping of a known size, as beta = 2 omega_0, is a special case
        damping = {f"?{'_'.join(name).rstrip('_')}" for name in self._dampings}
        made = [one for one in made if one[1] not in damping or any(name[:1] == "?" for name in one[2].names)]
        # of what is computed twice, each use means what was computed last before it
        twice = {name for name, often in Counter(name for _, name, _ in made).items() if often > 1}

        def latest(node: Node, place: int) -> Node:
            if node.kind == "symbol" and node.value in twice:
                before = [at for at, name, _ in made if name == node.value and at < place]
                return replace(node, value=f"{node.value}@{before[-1]}") if before else node
            if not node.names & twice:
                return node
            return replace(node, children=tuple(latest(child, place) for child in node.children))

        meanings: dict[str, list[tuple[int, Node]]] = {}
        for place, name, node in made:
            meanings.setdefault(name, []).append((place, latest(node, place)))
            meanings |= {f"{name}@{place}": meanings[name][-1:]} if name in twice else {}
        meanings = {n: [(-1, node)] for n, node in words.usual.items()} | meanings
        meanings |= {n: [(-1, node)] for n, node in words.given.items()}
        entries, own = list[Printed](), {place: name for place, name, _ in reversed(made)}
        for i in range(len(bare)) if inside is None else np.flatnonzero(inside).tolist():
            one = bare[i]
            begin, *others = one.sides or (None,)
            if own.get(i) in twice and begin and begin.value == own[i] and any(own[i] in side.names for side in others):
                # as x = x/2, from its last value
                from_last = lambda side, i=i: latest(side, i) if side.children else side  # noqa: E731
                ways = tuple((tuple(map(from_last, sides)), tight) for sides, tight in one.ways)
                mark = (id(one), *sorted(names_in(ways[0][0], {})))  # @ tells which value it is
                one = self._bound.setdefault(mark, replace(one, ways=ways))
            used, sources, fresh = dict[str, Node](), list[tuple](), [*one.names]
            while fresh:  # through definitions too, and the vectors of components
                name = fresh.pop()
                name = name if name in meanings else name.rpartition("_")[0]
                if name in meanings and name not in used:
                    place, used[name] = next((m for m in reversed(meanings[name]) if m[0] <= i), meanings[name][0])
                    sources.append((name, place, id(bare[place]) if place >= 0 else key(used[name])))
                    fresh += used[name].names
            mark = (id(one), own.get(i, ""), frozenset(sources))
            if mark not in self._bound:
                self._bound[mark] = replace(one, definitions=used, defines=own.get(i, ""))
            entries.append(self._bound[mark])
        return entries


def _with_drives(sides: tuple[Node, ...], words: Vocabulary) -> tuple[Node, ...]:
    """The sides of a law of accelerations, where sines and cosines of time alone, as a drive is, are some number.

    Of a system whose pivot moves in time they are what they are.
    """
    spec = words.spec
    laws = names_in(sides, {}) & {*spec.unknowns} if spec else set[str]()
    if spec is None or "t" in spec.parameters or not (laws or any(highest_rate(side) > 1 for side in sides)):
        return sides

    def settle(node: Node) -> Node:
        if node.kind == "function" and any(part.value == "t" for part in walk(node)) and not node.names & words.state:
            return Node("number", node.span, SOME, bracketed=node.bracketed)
        return replace(node, children=tuple(map(settle, node.children))) if node.children else node

    return tuple(map(settle, sides))


def _own_letters(equations: list[Printed], words: Vocabulary, dampings: set[Name]) -> dict[Name, str]:
    """Letters that do not stand for the constants or vectors that they may stand for elsewhere.

    Such as a_1 that equations give another dimension, s = l theta that varies, q of a number, and b that multiplies a rate
    wherever it stands.
    """
    spec, found = words.spec, dict[Name, set[Name]]()
    for one in (one for one in equations if len(one.sides) == 2 and one.sides[0].written and spec):
        left, right = one.sides
        assert left.written is not None
        name, meanings = left.written.name, {*words(left.written)}
        is_vector = meanings == {"q"}
        fixed = is_vector or meanings <= spec.still or right.names <= spec.still
        moves = meanings & {*spec.state} and (name in words.renamed or not right.names <= spec.still)
        number = is_vector and right.children and not any(part.kind == "matrix" for part in parts([right]))
        usual = name in words.chosen or left.written.dots or ("".join(name) in meanings and not number) or moves
        controls = meanings & {*LOADS} and any(one.startswith("?") for one in right.names)  # as u = -(k_1 x + k_2 v)
        if usual or controls or not right.names or not fixed:
            continue
        varies = meanings <= spec.still and bool(right.names & {*spec.state})
        if number or varies or not one.sound:
            found[name] = letters_in([right])
    own = {name: "" for name, used in found.items() if not used & found.keys()}
    for part in (part for one in equations for part in parts(one.sides) if part.kind == "function" and spec):
        angle = part.children[0].written if part.value in ("sin", "cos") else None
        meanings = words(angle) if angle and angle.name not in words.chosen | words.renamed else ()
        if angle and meanings and not {(0, 0, 0), None} & {*map(spec.dimensions.get, meanings)}:
            own[angle.name] = ""  # alpha in a sine is no acceleration
    for name in dampings if spec else ():
        if name not in words.chosen and {*words(Written(name[0], 0, name[1]))} <= spec.still | {"alpha"}:
            own[name] = ""
    return own


def _styled(sides: tuple[Node, ...]) -> tuple[Node, ...]:
    """The sides, where a name alone that is set equal to a matrix is one, however it is printed."""
    if len(sides) < 2 or not any(side.kind == "matrix" for side in sides):
        return sides
    alone = lambda side: side.kind == "symbol" and side.written and not side.written.dots  # noqa: E731
    return tuple(replace(s, written=replace(s.written, styled=True)) if alone(s) and s.written else s for s in sides)


def _of_statement(statement: Statement, number: int) -> list[Printed]:
    """Its equations, or one that tells why it cannot be read."""
    unread = Printed(statement, number, statement.text, statement.text, 0)
    text, remark = statement.text, ""
    try:
        try:
            equations = parse(text)
        except Unread as error:
            if (mended := _with_bracket(text, error.bracket)) is None:
                raise Unread(f"{error.reason} (character {error.place + 1})") from None
            text, remark = mended
            equations = parse(text)
        nodes = sum(1 for sides in equations for _ in parts(sides))
        if nodes > MOST_NODES or max(map(len, equations), default=0) > MOST_SIDES:
            raise Unread("too long to be checked: write it as several equations")
    except Unread as error:
        return [replace(unread, reason=error.reason)]
    several = len(equations) > 1
    if several and len(equations[0]) == 1 and equations[0][0].kind == "symbol" and not statement.name:
        return [replace(unread, reason="it gives values to several names at once: write an equation for each")]
    found = []
    for i, sides in enumerate(equations):
        if len(sides) > 1 or statement.name or not statement.place.startswith("line"):
            start, end = sides[0].outer[0], sides[-1].outer[1]
            latex = text[start:end].strip() if several else statement.text.strip().removesuffix("\\\\").strip()
            tight = parse(text, tight=True)[i] if "/" in text else sides
            ways = [(tuple(sides), False)] + [(tuple(tight), True)] * ([*map(key, tight)] != [*map(key, sides)])
            below = statement.text.count("\n", 0, start)
            line = f"line {int(statement.place.removeprefix('line ')) + below}" if below else statement.place
            own = replace(statement, place=line)
            found.append(
                Printed(own, number + len(found), latex, text, i, ways=tuple(ways), remark=remark, alone=not several)
            )
    return found or [replace(unread, text=text, reason="no equation: it has one side only")]


def _definitions(one: Printed, given: dict[str, Node], before: set[str]) -> list[tuple[str, Node]]:
    """The symbols without a meaning that stand alone on a side of an equation, and what they are.

    What was computed `before` may get another value from its last one.
    """
    sides, base, meaning = list(one.sides), None, None
    if len(sides) > 1 and sides[0].kind == "power" and sides[0].value == 2:  # v^2 = ... defines v
        base, meaning = sides[0].children[0], Node("power", sides[1].span, Fraction(1, 2), (sides[1],))
    elif len(sides) == 2 and sides[0].kind == "product" and sides[0].value == ("*", "*"):  # 2 beta = b/m defines beta
        number, factor = sides[0].children
        if number.kind == "number":
            base, meaning = factor, divide(sides[1], number, sides[1].span, sides[1].span[0])
    named = base and base.kind == "symbol" and base.value.startswith("?")
    if base and meaning and named and base.value not in {*given, *sides[1].names}:
        return [(base.value, meaning)]
    sides = sides[:-1] if len(sides) > 2 and sides[-1].value in ("?const", "?constant") else sides
    # in den_2 = den_1 the second name is known, where the first is not
    own = [side.value for side in sides[:1] if side.kind == "symbol" and side.value.startswith("?")]
    known = lambda side: side.value in given or (own and side.value not in own and side.value in before)  # noqa: E731
    fresh = [side for side in sides if side.kind == "symbol" and side.value.startswith("?") and not known(side)]
    others = [side for side in sides if side not in fresh]
    for symbol in fresh:
        new = lambda side, name=symbol.value: name in before or name not in side.names  # noqa: E731
        meanings = [side for side in others if new(side) and side.kind != "number"]
        meanings.sort(key=lambda side: any(name.startswith("?") for name in side.names))
        if meanings and (symbol is sides[0] or symbol.value not in CONSTANTS or len(sides) > 2):
            return [(other.value, meanings[0]) for other in fresh]
    return []


@lru_cache(maxsize=500)
def _with_bracket(text: str, bracket: str) -> tuple[str, str] | None:
    """A text with the bracket that is missing, where that makes an equation of vectors or numbers; and a remark.

    Of several places that with the least error of the text's first equation over its meanings for a rod.
    """
    words, tried = Vocabulary(THIN.spec), list[tuple[float, int]]()
    at = lambda place: text[:place] + bracket + text[place:]  # noqa: E731
    for place in [*[token.start for token in tokens(text)][1 : MOST_BRACKETS + 1], len(text)] if bracket else ():
        with suppress(Unread, IndexError):
            for equation in Equation(tuple(parse(at(place), words)[0])).readings(words):
                if not of_equation(equation, THIN.spec)[1]:
                    tried.append((relative_error(equation, random_states(THIN)), place))
    if not tried:
        return None
    place = min(tried)[1]
    around = at(place)[max(0, place - 10) : place + len(bracket) + 10]
    return at(place), f"the bracket {bracket} is missing; it is read as ...{around}..."


@lru_cache(maxsize=MOST_KNOWN)
def holding(one: Printed, system: System) -> Equation | None:
    """The reading of an equation that holds; None where none does, or where it says what a symbol is."""
    if one.lacking or (one.defines and len(one.sides) == 2):
        return None
    return next((equation for equation in one.meant if holds(equation, random_states(system))), None)


def candidates(one: Printed, system: System) -> list[Candidate]:
    """The reading that holds, or else those that have a meaning, the likeliest first. Raises Unread."""
    found: dict[float, tuple[tuple[bool, float], Candidate]] = {}  # by the error: equal ones come to the same
    reasons: list[Unread] = []
    for rank, equation in enumerate(one.readings()):
        try:
            error = relative_error(equation, random_states(system))
        except Unread as unread:
            reasons.append(unread)
            continue
        if error < TOLERANCE:
            return [(equation, error)]
        order = (bool(of_equation(equation, system.spec)[1]), float(rank))
        same = found.get(round(error, 9))
        if same is None or order < same[0]:
            found[round(error, 9)] = (order, (equation, error))
    if not found:
        mixed = [reason for reason in reasons if isinstance(reason, Mismatch)]
        raise (mixed or reasons or [Unread("it has no meaning")])[0]
    return [candidate for _, candidate in sorted(found.values(), key=lambda pair: pair[0])]


def kind_of(equation: Equation, spec: Spec) -> str:
    """What an equation is about, in a word or two: what it is solved for, or else what stands in it."""
    first, names = equation.sides[0], equation.names
    lone = str(equation.meanings.get(first.value, first.value)) if first.kind == "symbol" else ""
    if lone.startswith("dd"):
        return "explicit acceleration"
    if kind := SOLVED_FOR.get(lone) or OF_DIMENSION.get(spec.dimensions.get(lone, ())):
        return kind
    dimension, disagreement = of_equation(equation, spec)
    reactions, moves = names & REACTIONS, any(name.startswith(("dd", "wd")) or name == "alpha" for name in names)
    is_about = {
        "direction cosines": any(name.startswith("C_") for name in names),
        "moment balance": dimension == ENERGY and not disagreement and (reactions or moves),
        "force balance": reactions,
        "energy": names & {"T", "V", "L", "E"},
        "equation of motion": moves,
    }
    return next((kind for kind, is_it in is_about.items() if is_it), "relation")


REACTIONS = {"R", "R1", "R2", "R3", "M1", "M2", "M3", "Mc"}
SOLVED_FOR = dict.fromkeys(UNIT_VECTORS, "unit vectors") | dict.fromkeys(REACTIONS, "reaction")
SOLVED_FOR |= {"T": "kinetic energy", "V": "potential energy", "L": "Lagrangian", "E": "energy"}
OF_DIMENSION: dict[tuple, str] = {  # of a quantity by itself: powers of kg, m, s
    LENGTH: "position",
    (0, 1, -1): "velocity",
    (0, 1, -2): "acceleration",
    (0, 0, -1): "angular velocity",
    (0, 0, -2): "angular acceleration",
    INERTIA: "inertia",
}
