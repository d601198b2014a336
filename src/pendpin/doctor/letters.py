"""One meaning for each letter of a text: the one under which most of its equations hold.

A letter such as I may stand for two inertias. An equation that holds only if it means there another one than everywhere
else does not hold. A letter that the text defines itself has that meaning, whatever it usually stands for.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import islice

import numpy as np

from pendpin.doctor.checking.conditions import loads_at_zero, small_angles
from pendpin.doctor.checking.dimensions import of_equation
from pendpin.doctor.checking.evaluation import evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, Equation
from pendpin.doctor.printed import Printed, holding
from pendpin.doctor.reading.names import Vocabulary, Written
from pendpin.doctor.reading.tree import Node, Unread, parts, symbols, walk
from pendpin.doctor.systems.base import Spec, System, random_states

Name = tuple[str, str]  # a letter and its index
Again = Callable[..., list[Printed]]  # the equations of a text, read with other words

MOST_COUNTED = 60  # equations that tell which system a text is about
MOST_KNOWN = 20_000  # credits of equations that are remembered
MOST_TRIED = 24  # meanings of letters in equations that do not hold
MOST_LOADS = 3  # unknown forces and dampings of an equation that holds without them
SHORT = 3  # parts of one that is named like a quantity
LONG = 9  # parts of an expression that does not come to a quantity by chance
HARDLY = 0.25  # equations: what one such as L = T - V counts, of names alone
ANSWER, NAMED = (
    2.0,
    0.5,
)  # equations: what a definition that comes to an acceleration, or is named like a quantity, counts
MOST_CHANGED = 4  # letters of a text that mean what they usually do not
TWINS = {"1": "2", "2": "1"}  # indices of two like bodies
OFTEN = 2  # equations that hold with one meaning of a letter, so that a single other one is a slip


def weight(equation: Equation, spec: Spec) -> float:
    """What an equation counts: those of motion and energy say most, and what is true of every system hardly anything."""
    names = equation.names
    kinds = {part.kind for part in parts(equation.sides)}
    if not kinds & {"function", "product", "power"} and not set().union(*map(symbols, equation.sides)) & spec.still:
        return HARDLY
    telling = {name for name in spec.unknowns if name.startswith("dd")} | {"T", "V", "L"}
    return 2.0 if names & telling else 1.0


def telling(equations: list[Printed]) -> list[Printed]:
    """The equations that tell which system a text is about: the first that hold more than a name and its value."""
    return [one for one in equations if one.ways and len(one.names) > 1][:MOST_COUNTED]


def held(equations: list[Printed], system: System, small: bool = False) -> float:
    """How many equations hold, or only for `small` angles; those of motion and energy, which say most, twice."""
    return sum(credit(one, system, small) for one in telling(equations))


@lru_cache(maxsize=MOST_KNOWN)
def credit(one: Printed, system: System, small: bool = False) -> float:
    """What an equation counts for a system: nothing where it does not hold."""
    equation = _to_first_order(one, system) if small else holding(one, system)
    if equation is not None:
        return weight(equation, system.spec)
    if one.defines and not small:
        quantity = answers(one, system)
        return 0.0 if not quantity else ANSWER if quantity in system.spec.unknowns else NAMED
    if 0 < len(one.lacking) <= MOST_LOADS and one.ways and not one.defines:
        return float(any(loads_at_zero(e, system, one.lacking) != "" for e in one.meant(system.spec)))
    return 0.0


def answers(one: Printed, system: System) -> str:
    """The quantity of the system that a definition comes to, such as acc1 = (M22*R1 - M12*R2)/det; empty for none.

    A short one comes to it by chance, unless it is named like it: xs = L*sin(theta).
    """
    spec = system.spec
    if len(one.sides) != 2 or one.sides[0].value != one.defines or one.statement.name:
        return ""
    size, quantities = sum(1 for _ in walk(one.sides[1])), random_states(system)
    names = {name for name in spec.formulas if _named_alike(one.defines, name) and size >= SHORT}
    called = size >= SHORT and re.search(r"acc|dd|ddot|alpha", one.defines)
    names |= {*spec.unknowns} if size >= LONG or called else set()
    for equation in one.meant(spec)[:1] if names else ():
        try:
            with np.errstate(all="ignore"):
                value = evaluate(one.sides[1], equation.context(quantities))
        except (Unread, KeyError):
            return ""
        if value.ndim != 1 or not np.isfinite(value).all():
            return ""
        for name in sorted(names):
            other = quantities[name]
            if other.ndim == 1 and np.abs(value - other).max() <= TOLERANCE * np.abs(other).max():
                return name
        if size >= LONG and "weight" in spec.formulas and len(quantities["weight"]) == len(spec.coordinates):
            for name, other in zip(spec.coordinates, quantities["weight"], strict=True):
                if np.abs(value - other).max() <= TOLERANCE * np.abs(other).max():
                    return f"the moment of the weight on {name}"
    return ""


def _named_alike(own: str, name: str) -> bool:
    """Whether a name of the text's own, such as X1 or pos_x, may be that of a quantity: the same letter, no other index."""
    match = re.fullmatch(r"([A-Za-z]+?)[pG]?(\d*)", name)
    letter, digits = (match[1], match[2]) if match else ("", "")
    indices = re.sub(r"\D", "", own)
    word = own.lstrip("?")
    begins = word[:1].lower() == letter.lower() or re.search(rf"_{letter}(?![a-z])", word)
    return bool(len(letter) == 1 and begins and (indices == digits or not (indices and digits)))


def _to_first_order(one: Printed, system: System) -> Equation | None:
    """The reading of an equation that holds for small angles."""
    if one.defines:
        return None
    return next((equation for equation in one.readings() if small_angles(equation, system)), None)


def settled(equations: list[Printed], system: System, again: Again, inside: Sequence[bool]) -> list[Printed]:
    """The equations, each of whose letters has the meaning with which most of those `inside` a section hold."""

    def of_section(every: list[Printed]) -> list[Printed]:
        return [one for one, here in zip(every, inside, strict=True) if here]

    words = next((one.words for one in equations if one.ways), None)
    if words is None or not telling(of_section(equations)):
        return equations
    for _ in range(MOST_CHANGED):
        here, section, better = held(of_section(equations), system), of_section(equations), None
        own = _own(section, system, words)
        singles = ({name: meaning} for name, meaning in islice(_other_meanings(section, system, words), MOST_TRIED))
        for change in filter(None, (_defined_anew(section, system, words), own, *singles)):
            other = replace(words, chosen=words.chosen | change)
            changed = _with(equations, again(other, before=equations, names=change.keys()), change.keys())
            if (most := held(of_section(changed), system)) > here:
                here, better = most, (changed, other)
        if better is None:
            break
        equations, words = better
    return _agreed(equations, system, again, words)


def _own(equations: list[Printed], system: System, words: Vocabulary) -> dict[Name, str]:
    """The letters that equations which do not hold define, all as the text's own: a = (m_1 + m_2) l_1, b = ..."""
    found: dict[Name, str] = {}
    for one in (one for one in equations if one.ways and len(one.sides) == 2):
        left, right = one.sides
        named = (
            right if left.kind == right.kind == "symbol" and left.value in system.spec.state else left
        )  # theta1dot = z1
        written = named.written if named.kind == "symbol" else None
        others = [side for side in one.sides if side is not named]
        if written and not written.dots and any(map(symbols, others)) and holding(one, system) is None:
            name = (written.letter, written.index)
            if (meanings := _meanings(name, words)) and not {*meanings} & {*system.spec.state}:
                found[name] = ""
    return found


def with_own_letters(equations: list[Printed], system: System, again: Again) -> list[Printed]:
    """The equations, where the letter of a constant that is set equal to something that moves is the text's own."""
    words = next((one.words for one in equations if one.ways), None)
    if words is None:
        return equations
    still = system.spec.still
    anew = _defined_anew(equations, system, words)
    moved = {name for one in equations for name in _moved(one, still)}
    own = {name: "" for name in anew if name in moved and {*_meanings(name, words)} <= still}
    if not own:
        return equations
    anew_words = replace(words, chosen=words.chosen | own)
    changed = _with(equations, again(anew_words, before=equations, names=own), own)
    return changed if held(changed, system) >= held(equations, system) else equations


def _moved(one: Printed, still: frozenset[str]) -> Iterator[Name]:
    """The letter on the left of an equation whose other sides move."""
    if not one.ways:
        return
    left, *others = one.sides
    if left.written and any(symbols(side) - still - {"pi"} for side in others):
        yield left.written.letter, left.written.index


def _with(equations: list[Printed], changed: list[Printed], names: Collection[Name]) -> list[Printed]:
    """The changed equations in place of those that have one of some letters, or a symbol that is defined by it."""
    if len(changed) != len(equations):
        return changed
    return [new if _letters(one) & {*names} else one for one, new in zip(equations, changed, strict=True)]


def _defined_anew(equations: list[Printed], system: System, words: Vocabulary) -> dict[Name, str]:
    """The letters that equations such as s_2 = sin q_2, which use none of these, give another dimension: a meaning anew."""
    found: dict[Name, set[Name]] = {}
    for one in (one for one in equations if one.ways and one.sides[0].written):
        first, *others = one.sides
        assert first.written is not None
        name = (first.written.letter, first.written.index)
        disagree = all(of_equation(equation, system.spec)[1] for equation in one.readings())
        if disagree and not first.written.dots and not {*_meanings(name, words)} & {*system.spec.state}:
            found[name] = {(part.written.letter, part.written.index) for part in _symbols(others) if part.written}
    return {name: "" for name, used in found.items() if not used & found.keys()}


def _letters(one: Printed) -> set[Name]:
    """The letters of an equation and of the definitions that it may use."""
    nodes = [*one.sides, *one.definitions.values()]
    return {(node.written.letter, node.written.index) for node in _symbols(nodes) if node.written}


def _symbols(nodes: list[Node]) -> Iterator[Node]:
    return (part for node in nodes for part in walk(node) if part.written is not None)


def _other_meanings(equations: list[Printed], system: System, words: Vocabulary) -> Iterator[tuple[Name, str]]:
    """Letters of equations that do not hold, with each other meaning; none, "", for those that the text may define."""
    right, wrong = set[Name](), Counter[Name]()
    lone = set[Name]()
    for one in equations:
        if not one.ways:
            continue
        if holding(one, system) is not None:
            right |= _letters(one)
            continue
        wrong.update(_letters(one))
        lone |= {(s.written.letter, s.written.index) for s in one.sides if s.kind == "symbol" and s.written}
    for name, _ in wrong.most_common():
        meanings = _meanings(name, words)
        solved = {*system.spec.state, *system.spec.unknowns}
        own = (name in lone or name not in right) and meanings and not set(meanings) & solved
        for meaning in (*([""] if own else []), *(meanings if len(meanings) > 1 else ())):
            yield name, meaning


def _meanings(name: Name, words: Vocabulary) -> list[str]:
    """What a letter can mean, without dots."""
    if name in words.chosen:
        return []
    return [meaning for meaning in words(Written(name[0], 0, name[1])) if not meaning.startswith("?")]


def _agreed(equations: list[Printed], system: System, again: Again, words: Vocabulary) -> list[Printed]:
    """The equations, where a letter that means another thing in one of them alone means there what it does elsewhere."""
    for _ in range(MOST_CHANGED):
        for name, usual in _slips(equations, system, words):
            other = replace(words, chosen=words.chosen | {name: usual})
            changed = _with(equations, again(other, before=equations, names=[name]), [name])
            lost = sum(holding(one, system) is not None for one in equations)
            lost -= sum(holding(one, system) is not None for one in changed)
            if lost in (0, 1):
                equations, words = changed, other
                break
        else:
            break
    return equations


def _slips(equations: list[Printed], system: System, words: Vocabulary) -> Iterator[tuple[Name, str]]:
    """Letters that mean another thing in one equation alone, each with what it means elsewhere.

    I_1 and I_2 are inertias about the same point. Of two parameters that a letter means once each the likelier is meant. A
    letter that stands in one equation alone does not mean what another one means that has that meaning first.
    """
    uses, twins = _uses(equations, system, words)
    takers = {meaning: name for name, found in uses.items() for meaning, often in found.items() if often >= OFTEN}
    for name, own in uses.items():
        meanings = _meanings(name, words)
        found = own + Counter({meaning: often for meaning, often in twins[name].items() if meaning in meanings})
        taken = len(meanings) > 1 and len(found) == 1 and takers.get(next(iter(found)), name) != name
        if taken and sum(found.values()) == 1 and next(iter(found)) != meanings[0]:
            found = Counter({meanings[0]: OFTEN, **found})
        (usual, often), *others = sorted(found.items(), key=lambda pair: (-pair[1], *_rank(pair[0], meanings)))
        alike = [other for other in others if _same_dimension(usual, other[0], system)]
        settled = often >= OFTEN or {usual, *(other for other, _ in alike)} <= system.spec.still
        if len(alike) == 1 and alike[0][1] == 1 and own[alike[0][0]] and settled:
            yield name, usual


def _uses(
    equations: list[Printed], system: System, words: Vocabulary
) -> tuple[dict[Name, Counter[str]], dict[Name, Counter[str]]]:
    """How often each letter has each meaning in equations that hold, and the same letter with the index of a twin."""
    uses: dict[Name, Counter[str]] = defaultdict(Counter)
    twins: dict[Name, Counter[str]] = defaultdict(Counter)
    for one in equations:
        if one.ways and (equation := holding(one, system)) is not None:
            used = dict(_used(equation, words))
            for (letter, index), meaning in used.items():
                uses[letter, index][meaning] += 1
                twin = TWINS.get(index, "")
                if twin and (letter, twin) not in used:
                    twins[letter, twin][meaning.removesuffix(index) + twin] += 1
    return uses, twins


def _rank(meaning: str, meanings: list[str]) -> tuple[int, str]:
    """How likely a letter has a meaning: its place among all."""
    return (meanings.index(meaning) if meaning in meanings else len(meanings), meaning)


def _used(equation: Equation, words: Vocabulary) -> Iterator[tuple[Name, str]]:
    """The letters of an equation with what they mean in it, without dots."""
    for node in _symbols(list(equation.sides)):
        assert node.written is not None
        meaning = equation.meaning(str(node.value))
        yield (node.written.letter, node.written.index), meaning[node.written.dots :]


def _same_dimension(first: str, second: str, system: System) -> bool:
    return system.spec.dimensions.get(first) == system.spec.dimensions.get(second)


def in_use(equations: list[Printed], systems: list[System]) -> set[str]:
    """The symbols without dots and components that some equations use; those of a definition if what it defines is used.

    What comes to a quantity of the system is used as an equation is.
    """
    laws = [bool(one.ways) and bool(answers(one, system)) for one, system in zip(equations, systems, strict=True)]
    used, before = set[str](), -1
    while len(used) > before:
        before = len(used)
        for one, law in zip(equations, laws, strict=True):
            if one.ways and (law or not one.defines or len(one.sides) > 2 or bare(one.defines) in used):
                letters = {bare(name) for name in one.names - {one.defines}}
                used |= letters | {letter.rpartition("_")[0] for letter in letters}
    return used


def bare(name: str) -> str:
    """A symbol without its dots."""
    return name.lstrip("?").lstrip("d") or "d"


def idle(one: Printed) -> str:
    """What to write of a symbol that nothing uses."""
    name = one.defines.lstrip("?")
    return f"no other equation uses {name}: say which quantity it is with --symbols {name}=..."
