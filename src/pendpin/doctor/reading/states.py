"""Names of a text that stand for others: entries of vectors, states and their rates, the numbers of two bodies.

All that a text says of its names before a system gives them a meaning. Each step gives every name another one, or none.
"""

import re
from dataclasses import replace

from pendpin.doctor.reading.tree import Node, Rename, Written, parts, rename

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
    entries = [[part.value if part.kind == "number" else None for part in right.children[i : i + columns]]
               for i in range(0, len(right.children), columns)]  # fmt: skip
    for states in ([(i, d) for i in range(half) for d in (0, 1)], [(i, d) for d in (0, 1) for i in range(half)]):
        units = [[int(state == (i, 1)) for state in states] if columns > 1 else [0] for i, _ in states]
        right_rows = all(entries[k] == units[k] for k, (_, d) in enumerate(states) if d == 0)
        if rows not in (2, 4, 6) or columns not in (1, rows) or not right_rows or rows + columns == 3:
            continue

        def derivative(name: Written, by: Written) -> Node:
            below = Node("symbol", NOWHERE, written=name)
            return Node("derivative", NOWHERE, children=(below,), marks=(NOWHERE,), written=by)

        found = list[Sides]()
        printed = (part for k, part in enumerate(right.children) if states[k // columns][1])
        given = replace(right, value=(half, columns), children=tuple(printed))
        for order in ("123"[:half], "213"[:half])[: 1 + (half == 2)]:
            rated = lambda i, d, order=order: Written(COORDINATE, d, order[i])  # noqa: E731
            by = [rated(i, d) for i, d in states] if columns > 1 else [Written("u")]
            truth = tuple(derivative(rated(i, 2), one) for i, d in states if d for one in by)
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

    A line says it: th = y[0], (th, om) = y, dx = (om, acc) beside that, x_1' = x_2, dydt(1) = y(2). Where only
    th' = y[1] does, y[0] is th, or in a vector of angles before rates y[1 - n].
    """
    used = {(w.letter, w.index) for w in _written(equations)}
    entry = lambda w: bool(_ENTRY.fullmatch(w.index))  # noqa: E731

    from_zero = {w.letter for w in _written(equations) if w.dots and w.index == "0"}

    def as_entry(w: Written) -> Written:  # dy1 beside y[1] and dy0
        own = w.dots and w.letter in from_zero and (w.letter, f"[{w.index}]") in used
        return replace(w, index=f"[{w.index}]") if own else w

    pairs, columns, made = list[tuple[Written, Written]](), list[tuple[Written, list[Written]]](), set[Written]()
    for left, right in (sides for sides in equations if len(sides) == 2):
        if left.written and left.kind == "symbol" and right.children:
            made.add(left.written)
        if left.written and right.written and left.kind == right.kind == "symbol":
            pairs.append((as_entry(left.written), as_entry(right.written)))
        for vector, column in ((left, right), (right, left)):
            names = [one.written for one in column.children if one.written and one.kind == "symbol"]
            whole = column.kind == "matrix" and len(names) == len(column.children) > 1
            if whole and vector.written and vector.kind == "symbol":
                columns.append((vector.written, names))

    called, rates, vectors = dict[Name, Written](), dict[Name, Written](), dict[str, str]()
    for left, right in pairs:
        if entry(right) and not (entry(left) or right.dots or left in made or left in called.values()):
            called.setdefault((right.letter, right.index), left)
    for vector, names in columns:
        begin = 0 if (vector.letter, "[0]") in used else 1
        for i, name in enumerate(names, start=begin):
            if (vector.letter, f"[{i}]") in used and name not in called.values():
                called.setdefault((vector.letter, f"[{i}]"), name)
    owners = {name: letter for (letter, _), name in called.items()}
    for left, right in pairs:
        owner = right.letter if entry(right) else owners.get(right)
        if entry(left) and owner not in (None, left.letter) and not left.dots and re.search("[dDpfF]", left.letter):
            vectors[left.letter] = str(owner)

    named_at_once = {name for _, names in columns for name in names}

    def note(rate: Written, state: Written) -> None:
        for name in [name for name, other in rates.items() if other == state]:
            del rates[name]
        if (rate.letter, rate.index) != (state.letter, state.index):
            rates[rate.letter, rate.index] = replace(state, styled=False)

    for left, right in pairs:
        left = replace(left, letter=vectors[left.letter], dots=left.dots + 1) if left.letter in vectors else left
        own = right.letter in _STATES and right.index and right not in made
        if (
            left.dots == 1
            and not right.dots
            and (
                right in owners
                or own
                or {right, replace(left, dots=0)} <= named_at_once
                or (entry(right) and entry(left))
            )
        ):
            note(right, replace(left, dots=0))
    named = {letter: [name for (owner, _), name in sorted(called.items()) if owner == letter] for letter, _ in called}
    states = [names for _, names in columns] + [*named.values()]
    for vector, names in columns:  # the rates of states in their order: some are states too
        for other in states if vector.dots or re.search("[dDfF]", vector.letter) else ():
            moved = any(name in other and other.index(name) != i for i, name in enumerate(names))
            if moved and len(names) == len(other) and not {*names} <= {*other}:
                for rate, state in zip(names, other, strict=True):
                    note(rate, state) if not rate.dots else None
    for letter in named.keys() - {letter for (letter, _), state in rates.items() if entry(state)}:
        places = {
            int(index[1:-1]): name for (owner, index), name in called.items() if owner == letter and name.dots == 1
        }
        back = len(places) if places and max(places) - min(places) == len(places) - 1 else 1
        for place, name in places.items():
            if (state := replace(name, dots=0)) not in owners:
                called.setdefault((letter, f"[{place - back}]"), state)
    if not (called or rates):
        return None

    def change(written: Written) -> Written:
        written = as_entry(written)
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
