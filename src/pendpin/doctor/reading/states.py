"""Names of a text that stand for others: entries of vectors, states and their rates, the numbers of two bodies.

All that a text says of its names before a system gives them a meaning. Each step gives every name another one, or none.
"""

import re
from dataclasses import replace

from pendpin.doctor.reading.tree import Node, Rename, Written, differentiate, parts, rename, symbol_node

Sides = tuple[Node, ...]
Name = tuple[str, str]  # a letter and its index

_PAIR, _ENTRY = re.compile(r"\[(\d),(\d)\]"), re.compile(r"\[\d+\]")
_STATES = set("xyzqsu")  # letters of states with numbers, in x_1' = x_2
NOWHERE = (0, 0)  # in the text
COORDINATE = "coordinate"  # the letter of one for which the text has no name
MOST_STEPS = 4  # from a name to the state it is a rate of


def find_renames(equations: list[Sides]) -> list[Rename]:
    """What the names of some equations become, one step after another."""
    found = list[Rename]()
    for find in (_settle_elements, _number_bodies, _name_states, _name_own_rates, _style_matrices, _name_differences):
        if change := find(equations):
            found.append(change)
            equations = [tuple(rename(side, change) for side in sides) for sides in equations]
    return found


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
    """Two bodies are 1 and 2, also those of m_A and l_B, or of m[0] and l[1]; and q_1, q_2 are q_0, q_1 that both move."""
    written = _written(equations)
    indices = {
        letter: {name.index for name in written if name.letter == letter} for letter in {w.letter for w in written}
    }
    rates = {(name.letter, name.index) for name in written if name.dots}
    if any({(letter, "0"), (letter, "1")} <= rates and (letter, "2") not in rates for letter, _ in rates):
        shifted = str.maketrans("01", "12")
        return lambda name: replace(name, index=name.index.translate(shifted))
    masses, lengths = (set[str]().union(*(indices.get(one, ()) for one in letters)) for letters in ("mM", "lLr"))
    for pair in (("A", "B"), ("a", "b"), ("[0]", "[1]"), ("[1]", "[2]")):
        if {*pair} <= masses & lengths:
            numbers = dict(zip(pair, "12", strict=True))
            # of vectors those with two entries
            two = {letter for letter, found in indices.items() if pair[0][0] != "[" or found <= {*pair, ""}}
            if pair[0] == "[0]":
                two |= {letter for letter, found in indices.items() if {"0", "1"} <= found <= {"0", "1", ""}}
                numbers |= {"0": "1", "1": "2"}
            return lambda name: replace(name, index=numbers.get(name.index, name.index)) if name.letter in two else name
    return None


def _name_states(equations: list[Sides]) -> Rename | None:
    """Names of states for the entries of their vector, and rates for names of their own.

    A line names an entry, th = y[0], or all at once, (th, om) = y. The i-th rate belongs to the i-th state: dy[0] = om or
    dx = (om, acc), or by their numbers x_1' = x_2. Where only th' = y[1] is said, y[0] is th, or in a vector of angles
    before rates y[1 - n].
    """
    used = {(w.letter, w.index) for w in _written(equations)}
    entry = lambda w: bool(_ENTRY.fullmatch(w.index))  # noqa: E731
    pairs, made, at_once = list[tuple[Written, Written]](), set[Written](), set[Written]()
    for left, right in (sides for sides in equations if len(sides) == 2):
        if left.written and left.kind == "symbol" and right.children:
            made.add(left.written)
        if left.written and right.written and left.kind == right.kind == "symbol":
            pairs.append((left.written, right.written))
        for vector, column in ((left, right), (right, left)):
            names = [one.written for one in column.children if one.written and one.kind == "symbol"]
            whole = column.kind == "matrix" and len(names) == len(column.children) > 1
            if whole and vector.written and vector.kind == "symbol":
                begin = 0 if (vector.written.letter, "[0]") in used else 1
                entries = [replace(vector.written, index=f"[{i}]") for i, _ in enumerate(names, start=begin)]
                if vector is right or not (vector.written.dots or re.search("[dDfF]", vector.written.letter)):
                    pairs += zip(names, entries, strict=True)
                    at_once |= {*names}
                elif not any(map(entry, names)):
                    pairs += zip(entries, names, strict=True)

    called, owners = dict[Name, Written](), dict[Written, str]()
    for name, place in pairs:
        key = (place.letter, place.index)
        if entry(place) and not (entry(name) or place.dots or name in made - at_once or name in called.values()):
            owners.setdefault(name, place.letter)
            called |= {key: name} if key in used and key not in called else {}
    owner_of = lambda w: w.letter if entry(w) else owners.get(w)  # noqa: E731
    rates, vectors = dict[Name, Written](), dict[str, str]()
    given = dict[Written, list[tuple[str, Written]]]()  # entries of vectors of rates

    def note(rate: Written, state: Written) -> None:
        if not rate.dots and (rate.letter, rate.index) != (state.letter, state.index):
            rates[rate.letter, rate.index] = replace(state, styled=False)

    for left, right in pairs:
        numbered = right.letter in _STATES and right.index and right not in made
        if entry(left):
            given.setdefault(replace(left, index=""), []).append((left.index, right))
        elif left.dots == 1 and (right in owners or numbered):
            note(right, replace(left, dots=0))
    for vector, values in given.items():
        others = [owner for _, value in values if (owner := owner_of(value)) not in (None, vector.letter)]
        if not vector.dots and others and re.search("[dDpfF]", vector.letter):
            vectors[vector.letter] = str(others[0])
        owner = str(vector.letter if vector.dots == 1 else vectors.get(vector.letter))
        states = [(called.get((owner, index), Written(owner, 0, index)), value) for index, value in values]
        if any(owner_of(value) == owner and value != state for state, value in states):
            for state, value in states:
                note(value, state)
    for letter in {*owners.values()} - {state.letter for state in rates.values() if entry(state)}:
        places = {int(key[1][1:-1]): name for key, name in called.items() if key[0] == letter and name.dots == 1}
        back = len(places) if places and max(places) - min(places) == len(places) - 1 else 1
        for place, name in places.items():
            if (state := replace(name, dots=0)) not in owners:
                called.setdefault((letter, f"[{place - back}]"), state)
    if not (called or rates):
        return None

    def change(written: Written) -> Written:
        for _ in range(MOST_STEPS):
            key = (written.letter, written.index)
            if written.letter in vectors and entry(written):
                written = replace(written, letter=vectors[written.letter], dots=written.dots + 1)
            elif other := rates.get(key) or called.get(key):
                more = other.dots + (key in rates)
                written = replace(written, letter=other.letter, index=other.index, dots=written.dots + more)
        return written

    return change


def _name_own_rates(equations: list[Sides]) -> Rename | None:
    """Rates of a state that stands nowhere have names of their own: xdot(2) = ..."""
    written = _written(equations)
    stated = {name.letter for name in written if not name.dots}
    alone = {name for name in written if name.dots == 1 and name.index[:1] == "[" and name.letter not in stated}
    own = lambda name: replace(name, letter=f"{name.letter}dot", dots=0) if name in alone else name  # noqa: E731
    return own if alone else None


def _style_matrices(equations: list[Sides]) -> Rename | None:
    """A letter that is equal to a matrix is one wherever it stands, however it is printed: M = [...], inv(M)."""
    tables = [sides for sides in equations if any(side.kind == "matrix" for side in sides)]
    equal = {side.written for sides in tables for side in sides if side.kind == "symbol" and side.written}
    inside = _written([tuple(side for side in sides if side.kind == "matrix") for sides in tables])
    matrices = {written for written in equal - inside if not written.styled and not written.dots}
    return (lambda name: replace(name, styled=name.styled or name in matrices)) if matrices else None


def _name_differences(equations: list[Sides]) -> Rename | None:
    """A difference that is written like a rate has a name of its own: dtheta = theta2 - theta1."""
    own = set[Written]()
    for left, right in (sides for sides in equations if len(sides) == 2):
        two = right.kind == "sum" and len(right.children) == 2
        if two and left.written and left.written.dots == 1:
            own |= {left.written} if all(t.written and not t.written.dots for t in right.children) else set()
    named = lambda name: replace(name, letter=f"d{name.letter}", dots=0) if name in own else name  # noqa: E731
    return named if own else None
