"""Names of a text that stand for others: entries of vectors, states and their rates, the numbers of two bodies.

All that a text says of its names before a system gives them a meaning. Each step gives every name another one, or none.
"""

import re
from dataclasses import replace
from functools import reduce

from pendpin.doctor.reading.tree import Name, Node, Rename, Written, differentiate, parts, rename, symbol_node

Sides = tuple[Node, ...]

_PAIR, _ENTRY = re.compile(r"\[(\d),(\d)\]"), re.compile(r"\[\d+\]")
_BODIES = ("AB", "ab", "01")  # indices of two bodies
_RATES = re.compile("[dDpfF]")  # in the letter of a vector of rates: dydt, f, and p beside u
_STATES = set("xyzqsu")  # letters of states with numbers, in x_1' = x_2
_DAMPINGS = "damping friction drag alpha beta gamma delta zeta eta lambda mu nu"
DAMPINGS = {*"bcdkfq", *_DAMPINGS.split()}  # letters of dampings
NOWHERE = (0, 0)  # in the text
_SPEEDS = ("speed", "vel", "velocity")
COORDINATE = "coordinate"  # the letter of one for which the text has no name
MOST_STEPS = 4  # from a name to the state it is a rate of


def find_rename(equations: list[Sides]) -> Rename:
    """What the names of some equations become, one step after another."""
    steps = list[Rename]()
    for find in (_name_rates, _settle_elements, _number_bodies, _name_states, _style_matrices, _name_own):
        if change := find(equations):
            steps.append(change)
            equations = [tuple(rename(side, change) for side in sides) for sides in equations]
    return lambda name: reduce(lambda name, change: change(name), steps, name)


def as_derivatives(sides: Sides) -> list[Sides]:
    """What the matrix A or B of x' = A x + B u says: the derivatives of the states' rates, in either order.

    Its rows (0 1 0 0) show where the rates of the coordinates stand; which of them is first, it does not tell.
    """
    left, right = sides[0], sides[-1]
    if len(sides) != 2 or right.kind != "matrix" or not left.written or left.written.letter[:1] not in "AB":
        return [sides]
    (rows, columns), half = right.value, right.value[0] // 2
    if (rows, columns) == (2, 1) or rows not in (2, 4, 6) or columns not in (1, rows):
        return [sides]
    table = [right.children[i : i + columns] for i in range(0, len(right.children), columns)]
    numbers = [[part.value if part.kind == "number" else None for part in row] for row in table]
    for states in ([(i, d) for i in range(half) for d in (0, 1)], [(i, d) for d in (0, 1) for i in range(half)]):
        units = [[int(state == (i, 1)) for state in states] if columns > 1 else [0] for i, _ in states]
        if not all(numbers[k] == units[k] for k, (_, d) in enumerate(states) if d == 0):
            continue
        found = list[Sides]()
        printed = tuple(part for row, (_, d) in zip(table, states, strict=True) if d for part in row)
        for order in ("123"[:half], "213"[:half])[: 1 + (half == 2)]:
            state = lambda i, d, order=order: symbol_node(Written(COORDINATE, d, order[i]), NOWHERE)  # noqa: E731
            by = [state(*one) for one in states] if columns > 1 else [symbol_node(Written("u"), NOWHERE)]
            truth = tuple(differentiate(state(i, 2), one, 1, NOWHERE) for i, d in states if d for one in by)
            given = replace(right, value=(half, columns), children=printed)
            found.append((Node("matrix", NOWHERE, (half, columns), truth), given))
        return found
    return [sides]


def _written(equations: list[Sides]) -> set[Written]:
    return {part.written for sides in equations for part in parts(sides) if part.written}


def _name_rates(equations: list[Sides]) -> Rename | None:
    """speed_1 is the rate of theta_1 beside it; a1_v and a1_a have names of their own where a1 is no angle."""
    written = _written(equations)
    angles = [name for name in written if name.letter in ("theta", "phi") and not name.dots]
    beside = {name: [one for one in angles if one.index == name.index] for name in written if name.letter in _SPEEDS}
    change = {name: replace(one[0], dots=1) for name, one in beside.items() if len(one) == 1}
    lone = [name for name in written if name.letter == "a" and name.dots and replace(name, dots=0) not in written]
    change |= {name: replace(name, letter="d" * name.dots + "a", dots=0) for name in lone}
    return (lambda name: change.get(name, name)) if change else None


def _settle_elements(equations: list[Sides]) -> Rename | None:
    """M(2, 1) is M_21, counted from 1; where each has 1 in the second place, G_2 or y(2)."""
    pairs = {(one.letter, *match.groups()) for one in _written(equations) if (match := _PAIR.fullmatch(one.index))}
    matrices = {letter for letter, _, second in pairs if second != "1"}
    from_zero = {letter for letter, first, second in pairs if "0" in first + second}

    def settle(one: Written) -> Written:
        if (match := _PAIR.fullmatch(one.index)) is None:
            return one
        if one.letter not in matrices:
            return replace(one, index=match[1] if one.letter.isupper() else f"[{match[1]}]")
        return replace(one, index="".join(str(int(place) + (one.letter in from_zero)) for place in match.groups()))

    return settle if pairs else None


def _number_bodies(equations: list[Sides]) -> Rename | None:
    """Two bodies are 1 and 2, also those of m_A and l_B, of m_0 and l_c0, or of m[0] and l[1]."""
    indices: dict[str, set[str]] = {}
    for name in _written(equations):
        indices.setdefault(name.letter, set()).add(name.index)
    for first, second in _BODIES:
        of_two = re.compile(rf"c?\[?[{first}{second}]*\]?")
        two = {letter for letter, found in indices.items() if all(map(of_two.fullmatch, found))}
        masses, lengths = (
            {index.strip("c[]") for letter in two & {*letters} for index in indices[letter]}
            for letters in ("mM", "lLr")
        )
        if {first, second} <= masses & lengths:
            break
    else:
        return None
    numbers = str.maketrans(first + second, "12")
    change = lambda name: replace(name, index=name.index.translate(numbers).strip("[]"))  # noqa: E731
    return lambda name: change(name) if name.letter in two else name


def _is_entry(name: Written) -> bool:
    return bool(_ENTRY.fullmatch(name.index))


def _name_states(equations: list[Sides]) -> Rename | None:
    """Names of states for the entries of their vector, and rates for names of their own.

    A line names an entry, th = y[0], or all at once, (th, om) = y. The i-th rate belongs to the i-th state: dy[0] = om or
    dx = (om, acc), or by their numbers x_1' = x_2. Where only th' = y[1] is said, y[0] is th, or in a vector of angles
    before rates y[1 - n].
    """
    pairs = _equal_names(equations)
    computed = {sides[0].written for sides in equations if len(sides) == 2 and sides[1].children}
    stands: dict[Name, Written] = {}  # for what a name stands
    owners: dict[Written, str] = {}  # the vector of which a name is an entry
    for name, place in pairs:
        if _is_entry(place) and not (_is_entry(name) or place.dots or name in computed):
            owners.setdefault(name, place.letter)
            stands.setdefault(place.name, name)
    for letter in {*owners.values()}:
        named = {int(index[1:-1]): name for (vector, index), name in stands.items() if vector == letter}
        back = len(named) if max(named) - min(named) == len(named) - 1 else 1
        if all(name.dots == 1 for name in named.values()):
            stands |= {(letter, f"[{place - back}]"): replace(name, dots=0) for place, name in named.items()}
    owner_of = lambda name: name.letter if _is_entry(name) else owners.get(name)  # noqa: E731
    stated = {name.letter for name in _written(equations) if not name.dots}
    vectors: dict[str, str] = {}  # of rates, and of which vector; also dydt, where the states are x
    for rate, value in pairs:
        owner = owner_of(value)
        named = rate.letter not in stated if rate.dots else _RATES.search(rate.letter)
        if _is_entry(rate) and named and owner not in (None, rate.letter):
            vectors.setdefault(rate.letter, owner)
    of_rate = lambda rate: vectors.get(rate.letter, rate.letter if rate.dots == 1 else "")  # noqa: E731
    known = {of_rate(rate) for rate, value in pairs if _is_entry(rate) and owner_of(value) == of_rate(rate)}
    for rate, value in pairs:
        state = replace(rate, dots=rate.dots - 1)
        if _is_entry(rate):
            state = stands.get((of_rate(rate), rate.index), Written(of_rate(rate), 0, rate.index))
            is_rate = of_rate(rate) in known
        else:
            numbered = value.letter in _STATES and value.index and value not in computed
            is_rate = rate.dots == 1 and (value in owners or numbered)
        if is_rate and not value.dots and value != state:
            stands[value.name] = replace(state, dots=state.dots + 1, styled=False)
    if not stands:
        return None

    def change(written: Written) -> Written:
        for _ in range(MOST_STEPS):
            if written.letter in vectors and _is_entry(written):
                written = replace(written, letter=vectors[written.letter], dots=written.dots or 1)
            elif other := stands.get(written.name):
                written = replace(written, letter=other.letter, index=other.index, dots=written.dots + other.dots)
        return written

    return change


def _equal_names(equations: list[Sides]) -> list[tuple[Written, Written]]:
    """The names that are set equal, each alone or as the entries of a vector: what is named or a rate, and its value."""
    used, found = {name.name for name in _written(equations)}, list[tuple[Written, Written]]()
    for left, right in (sides for sides in equations if len(sides) == 2):
        if left.kind == right.kind == "symbol" and left.written and right.written:
            found.append((left.written, right.written))
        for vector, column in ((left, right), (right, left)):
            names = [one.written for one in column.children if one.written and one.kind == "symbol"]
            whole = column.kind == "matrix" and len(names) == len(column.children) > 1
            if whole and vector.written and vector.kind == "symbol":
                begin = 0 if "[0]" in {index for _, index in used} else 1
                entries = [replace(vector.written, index=f"[{i}]") for i, _ in enumerate(names, start=begin)]
                rates = vector is left and (vector.written.dots or _RATES.search(vector.written.letter))
                found += zip(entries, names, strict=True) if rates else zip(names, entries, strict=True)
    return found


def _style_matrices(equations: list[Sides]) -> Rename | None:
    """A letter that is equal to a matrix is one wherever it stands, however it is printed: M = [...], inv(M)."""
    tables = [sides for sides in equations if any(side.kind == "matrix" for side in sides)]
    equal = {side.written for sides in tables for side in sides if side.kind == "symbol" and side.written}
    inside = _written([tuple(side for side in sides if side.kind == "matrix") for sides in tables])
    moving = {replace(name, dots=0) for name in _written(equations) if name.dots and name.letter in "xyz"}  # or a cart
    matrices = {written for written in equal - inside - moving if not written.styled and not written.dots}
    return (lambda name: replace(name, styled=name.styled or name in matrices)) if matrices else None


def _name_own(equations: list[Sides]) -> Rename | None:
    """What is only written like a rate has a name of its own: dtheta = theta2 - theta1, or xdot(2) where no x stands."""
    written = _written(equations)
    stated = {name.letter for name in written if not name.dots}
    own = {name for name in written if name.dots == 1 and _is_entry(name) and name.letter not in stated}
    for left, right in (sides for sides in equations if len(sides) == 2):
        two = right.kind == "sum" and len(right.children) == 2
        if two and left.written and left.written.dots == 1:
            own |= {left.written} if all(t.written and not t.written.dots for t in right.children) else set()
    return (lambda name: replace(name, letter=f"d{name.letter}", dots=0) if name in own else name) if own else None


def dampings(equations: list[Sides]) -> set[Name]:
    """Letters that stand in products with one rate only, wherever something moves."""
    orders: dict[Name, set[int]] = {}

    def visit(node: Node, around: int) -> None:
        if node.kind == "product":  # also of fractions and brackets
            around += _order(node)
        elif node.kind != "power" or node.value < 0:
            around = around if node.kind == "symbol" else 0
        if node.kind == "symbol" and node.written and node.written.letter in DAMPINGS and not node.written.dots:
            orders.setdefault(node.written.name, set()).add(around)
        for child in node.children:
            visit(child, around - _order(child) * (node.kind == child.kind == "product"))

    def moves(sides: Sides) -> bool:
        """Whether it is a sum in which something moves, and no b/2m or r^2 + b r."""
        every = [*parts(sides)]
        return any(p.kind == "sum" for p in every) and any(p.written and p.written.dots for p in every)

    for side in (side for sides in equations if moves(sides) for side in sides):
        visit(side, 0)
    return {name for name, found in orders.items() if found == {1}}


def _order(node: Node) -> int:
    """How many rates are multiplied in an expression."""
    if node.kind == "power":
        return abs(int(node.value)) * _order(node.children[0])
    if node.kind == "product":
        return sum(map(_order, node.children))
    written = node.written if node.kind == "symbol" else None
    return int(written is not None and (written.dots == 1 or (written.letter in ("omega", "w") and not written.dots)))


def highest_rate(node: Node) -> int:
    """The highest order in time of what stands in an expression: 2 for an acceleration."""
    if node.kind == "symbol" and node.written:
        return node.written.dots + (node.written.letter in ("omega", "w"))
    return (node.kind == "derivative" and node.value == "t") + max(map(highest_rate, node.children), default=0)
