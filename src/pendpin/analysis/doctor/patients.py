"""From statements to equations that can be checked: every reading of a text, and the likeliest of them."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from pendpin.analysis.doctor.checking.dimensions import of_equation
from pendpin.analysis.doctor.checking.mechanics import Pendulum
from pendpin.analysis.doctor.checking.residuals import TOLERANCE, Equation, random_states, relative_error
from pendpin.analysis.doctor.reading.documents import Statement
from pendpin.analysis.doctor.reading.grammar import lone, parse
from pendpin.analysis.doctor.reading.names import CONSTANTS, DIMENSION_OF, VECTORS
from pendpin.analysis.doctor.reading.tokens import tokens
from pendpin.analysis.doctor.reading.tree import Mismatch, Node, Unread, key, symbols, walk

MOST_BRACKETS = 120  # places that are tried for a missing one
MOST_NODES, MOST_SIDES = 2_000, 20  # of an equation that is checked
COORDINATES = {"x", "y", "z"}


Candidate = tuple[Equation, bool, float]  # whether 3g/2l is read as 3g/(2l), and the relative error


@dataclass(frozen=True, eq=False)
class Printed:
    """One equation of a statement, read from `text`, which may hold a bracket more than was printed."""

    statement: Statement
    number: int
    latex: str  # as printed
    text: str
    index: int
    ways: tuple[tuple[tuple[Node, ...], bool], ...] = ()  # sides, and whether 3g/2l is read as 3g/(2l)
    reason: str = ""  # why it cannot be read
    remark: str = ""
    defines: str = ""  # the symbol that it gives a meaning to
    definitions: dict[str, Node] = field(default_factory=dict)
    alone: bool = True  # no other equation stands in its text

    def readings(self) -> Iterator[tuple[Equation, bool]]:
        """Every way to read it, the likeliest first."""
        for sides, tight in self.ways:
            for equation in Equation(sides, definitions=self.definitions).readings():
                yield equation, tight


def printed(statements: tuple[Statement, ...], definitions: dict[str, Node]) -> list[Printed]:
    """The equations of some statements, numbered; symbols that one of them defines are known to those after it."""
    found: list[Printed] = []
    known = dict(definitions)
    for statement in statements:
        for one in _of_statement(statement, len(found) + 1):
            one = replace(one, definitions=dict(known))
            if definition := _defined(one, known):
                known[definition[0]] = definition[1]
                one = replace(one, defines=definition[0])
            found.append(one)
    return found


def _of_statement(statement: Statement, number: int) -> list[Printed]:
    """Its equations, or one that tells why it cannot be read."""
    try:
        text, remark, equations = _parsed(statement.text)
    except Unread as error:
        return [Printed(statement, number, statement.text, statement.text, 0, reason=error.reason)]
    several = len(equations) > 1
    return [
        Printed(
            replace(statement, place=statement.line_of(sides[0].outer[0])),
            number + i,
            text[sides[0].outer[0] : sides[-1].outer[1]].strip() if several else statement.text,
            text,
            i,
            _ways(statement, text, i, sides),
            remark=remark,
            alone=not several,
        )
        for i, sides in enumerate(equations)
        if len(sides) > 1 or statement.name or not statement.place.startswith("line")
    ] or [Printed(statement, number, text, text, 0, reason="no equation: it has one side only")]


def _parsed(text: str) -> tuple[str, str, list[list[Node]]]:
    """A text, with the bracket that is missing, a remark on that, and its equations. Raises Unread."""
    remark = ""
    try:
        equations = parse(text)
    except RecursionError:
        raise Unread("nested too deeply") from None
    except Unread as error:
        mended = _with_bracket(text, error)
        if mended is None:
            raise Unread(f"{error.reason} (character {error.place + 1})") from None
        text, remark = mended
        equations = parse(text)
    nodes = sum(1 for sides in equations for side in sides for _ in walk(side))
    if nodes > MOST_NODES or max(map(len, equations), default=0) > MOST_SIDES:
        raise Unread("too long to be checked: write it as several equations")
    return text, remark, equations


def _ways(statement: Statement, text: str, index: int, sides: list[Node]) -> tuple[tuple[tuple[Node, ...], bool], ...]:
    """The sides, also with 3g/2l read as 3g/(2l), and with the statement's name as the left side."""
    ways = [(tuple(sides), False)]
    if "/" in text:
        ways.append((tuple(parse(text, tight=True)[index]), True))
    if len(sides) == 1 and statement.name:
        named = _name(statement.name)
        ways = [((left, *s), tight) for s, tight in ways for left in named] + ways
    return tuple(ways)


def _name(name: str) -> list[Node]:
    """A key as the left side of an equation, if it is the name of a quantity."""
    try:
        found = lone(name)
    except Unread:
        return []
    known = found and found.kind == "symbol" and not found.value.startswith("?")
    return [replace(found, span=(0, 0))] if found and known else []


def _with_bracket(text: str, error: Unread) -> tuple[str, str] | None:
    """A text with the bracket that is missing, where that makes an equation of vectors or numbers; and a remark."""
    if not error.bracket:
        return None
    candidates = []
    for place in [*[token.start for token in tokens(text)][1 : MOST_BRACKETS + 1], len(text)]:
        fixed = text[:place] + error.bracket + text[place:]
        if (size := _error_of(fixed)) is not None:
            around = f"{text[max(0, place - 10) : place]}{error.bracket}{text[place : place + 10]}"
            candidates.append((size, fixed, f"the bracket {error.bracket} is missing; it is read as ...{around}..."))
    if not candidates:
        return None
    return min(candidates, key=lambda c: c[0])[1:]


def _error_of(text: str) -> float | None:
    """The least error of a text's first equation over its meanings; None where it cannot be read."""
    try:
        sides = parse(text)[0]
    except (Unread, IndexError):
        return None
    errors = []
    for equation in Equation(tuple(sides)).readings():
        try:
            if not of_equation(equation)[1]:
                errors.append(relative_error(equation, random_states(Pendulum("thin"))))
        except Unread:
            continue
    return min(errors, default=None)


def _defined(one: Printed, known: dict[str, Node]) -> tuple[str, Node] | None:
    """The symbol that an equation defines, an unknown one alone on a side, and its meaning."""
    if not one.ways or len(one.ways[0][0]) != 2:
        return None
    left, right = one.ways[0][0]
    for symbol, meaning in ((left, right), (right, left)):
        name, others = symbol.value, symbols(meaning)
        fresh = symbol.kind == "symbol" and name.startswith("?")
        fresh = fresh and (name not in known or key(known[name]) == key(meaning))
        settled = name not in CONSTANTS and not any(other.startswith("?") for other in others)
        if fresh and name not in others and (symbol is left or settled):
            return name, meaning
    return None


def candidates(one: Printed, pendulum: Pendulum) -> list[Candidate]:
    """The reading that holds, or else those that have a meaning, the likeliest first. Raises Unread."""
    found: dict[float, tuple[tuple[bool, float], Candidate]] = {}  # by the error: equal ones come to the same
    reasons: list[Unread] = []
    for rank, (equation, tight) in enumerate(one.readings()):
        try:
            error = relative_error(equation, random_states(pendulum))
        except Unread as unread:
            reasons.append(unread)
            continue
        if error < TOLERANCE:
            return [(equation, tight, error)]
        order = (bool(of_equation(equation)[1]), float(rank))
        known = found.get(round(error, 9))
        if known is None or order < known[0]:
            found[round(error, 9)] = (order, (equation, tight, error))
    if not found:
        mixed = [reason for reason in reasons if isinstance(reason, Mismatch)]
        raise (mixed or reasons or [Unread("it has no meaning")])[0]
    listed = [candidate for _, candidate in sorted(found.values(), key=lambda pair: pair[0])]
    if _of_the_tip(listed[0][0], pendulum):
        raise Unread(
            "x, y, z may belong to the tip, for which it holds, or to the centre of mass, for which it fails: say which"
        )
    return listed


def _of_the_tip(equation: Equation, pendulum: Pendulum) -> bool:
    """Whether a condition on coordinates, none of them alone on a side, holds for the tip."""
    lone = {side.value for side in equation.sides}
    if not equation.names & COORDINATES or lone & COORDINATES or equation.meanings.keys() - COORDINATES:
        return False
    tip = replace(equation, meanings={name: f"{name}T" for name in COORDINATES})
    return relative_error(tip, random_states(pendulum)) < TOLERANCE


def kind_of(equation: Equation) -> str:
    """What an equation is about, in a word or two."""
    names = equation.names
    first = equation.sides[0]
    lone = str(equation.meanings.get(first.value, first.value)) if first.kind == "symbol" else ""
    for kind, members in KINDS:
        if lone in members:
            return kind
    if any(name.startswith("C_") for name in names):
        return "direction cosines"
    if names & {"M3", "Mc", "M1", "M2", "M"} or _is_moment(equation):
        return "moment balance"
    if names & {"R1", "R2", "R3", "R"}:
        return "force balance"
    if names & {"L", "T", "V", "E"}:
        return "energy"
    if names & {"ddtheta", "ddphi", "alpha", "wd1", "wd2", "wd3"}:
        return "equation of motion"
    return "relation"


def _is_moment(equation: Equation) -> bool:
    found, disagreement = of_equation(equation)
    if disagreement:
        return bool(equation.names & {"I1", "I2", "I3"})
    return found == (1, 2, -2) and bool(equation.names & {"R1", "R2", "R3", "R", "ddtheta", "ddphi", "alpha"})


KINDS: tuple[tuple[str, set[str]], ...] = (
    ("unit vectors", {name for name in VECTORS if DIMENSION_OF.get(name) == (0, 0, 0)}),
    ("angular velocity", {"omega", "w1", "w2", "w3", "wx", "wy", "wz"}),
    ("angular acceleration", {"alpha", "wd1", "wd2", "wd3", "wdx", "wdy", "wdz"}),
    ("position", {"rG", "rT", "x", "y", "z", "xT", "yT", "zT", "h"}),
    ("velocity", {"vG", "vx", "vy", "vz", "vc1", "vc2", "vc3", "speed"}),
    ("acceleration", {"aG", "ax", "ay", "az", "ac1", "ac2", "ac3"}),
    ("explicit acceleration", {"ddtheta", "ddphi"}),
    ("reaction", {"R", "R1", "R2", "R3", "M3", "Mc", "M", "M1", "M2"}),
    ("kinetic energy", {"T"}),
    ("potential energy", {"V"}),
    ("Lagrangian", {"L"}),
    ("energy", {"E"}),
    ("inertia", {"inertia", "I1", "I2", "I3", "J1", "J2", "J3"}),
)
