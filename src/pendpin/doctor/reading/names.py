"""How quantities are written: letters and names in plain text; and what a printed name means in one system."""

import re
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

from pendpin.doctor.reading.states import DAMPINGS
from pendpin.doctor.reading.tree import Name, Node, Span, Written, unknown

FUNCTIONS = {name: name for name in ("sin", "cos", "tan", "sec", "csc", "cot", "sqrt", "exp")} | {"sen": "sin"}
FUNCTIONS |= dict.fromkeys(("sign", "sgn"), "sign") | dict.fromkeys(("abs", "fabs"), "norm")


def _meanings(table: str) -> dict[str, str]:
    """What each word of a table means: the first word of its entry."""
    return {word: words[0] for words in map(str.split, table.split(",")) for word in words[1:]}


_GREEK = """theta θ ϑ vartheta teta, phi φ ϕ varphi, omega ω, alpha α, psi ψ, beta β, gamma γ, tau τ, pi π, mu μ, lambda λ,
rho ρ varrho, Omega Ω, Delta Δ, delta δ, epsilon ε varepsilon, eta η, xi ξ, zeta ζ, kappa κ, nu ν, sigma σ, chi χ, Phi Φ,
Theta Θ, Psi Ψ, Gamma Γ, Lambda Λ"""
GREEK = _meanings(_GREEK) | _meanings("l ell ℓ, i imath, j jmath")
GREEK |= {name: name for name in (*GREEK.values(), "Sigma") if len(name) > 1}  # Σ alone is a sum
_ANGLE = "theta|phi|omega|alpha|psi|beta|gamma|th|ph"
_RATES = tuple(  # how the name of a rate is spelled
    re.compile(pattern)
    for pattern in (
        r"d(?P<order>2)_?(?P<name>[A-Za-z]+?\d?)_?dt\d?",  # d2x_dt2
        r"d_?(?P<name>[A-Za-z]+?\d?(?:_dot)?)_?dt(?P<last>\d?)",  # dtheta_dt, dwdt1, dtheta_dot_dt
        r"(?P<name>[A-Za-z]+?)_?(?P<index>\d?)_?(?P<order>(?:[dD]|double_?)?[dD]ot(?:_?[dD]ot)?|prime(?:prime)?|punto(?:punto)?|(?<=_)point)_?(?P<last>[\dA-C]?)",
        rf"(?P<order>d(?:d|2)?)_?(?P<name>{_ANGLE}|Theta|Phi|w|v|x|y|z|q|p(?=_?\d))_?(?P<last>[\dA-C]?)",  # ddx1, d2phi
        rf"(?P<name>{_ANGLE}|x|y|z|q)_?(?P<index>[123]?)_?(?P<order>d{{1,2}}|D{{1,2}}|(?<![xyz])(?<![xyz]_)(?<!th)(?:t{{1,2}}|p{{1,2}}))(?:_?(?P<last>[123]))?",
        rf"(?P<name>{_ANGLE}|x)_?(?P<index>[12]?)_?(?P<order>acc)",  # thetaacc
        rf"(?P<name>{_ANGLE}|angle|a(?=[12]_))_?(?P<index>[12]?)_(?P<order>vel|acc|(?<=[12e]_)[va])",  # phi_vel, a1_v
    )
)
_TWICE = re.compile("2|acc|a|d2|dd|DD|tt|pp|puntopunto|[dD][dD]ot|double_?[dD]ot|[dD]ot_?[dD]ot|primeprime")
_ELEMENT = re.compile(  # y(2), y[1], y(2, :), y[:, 1], M(2, 1), M[0][1]
    r"([A-Za-z]\w*)[(\[](?::,\s*)?(\d+(?::\d)?)(?:\s*(?:,|\]\s*\[)\s*(?:(\d)|:))?[)\]]"
)
_SHORT = _meanings("""theta th tht Th Theta angle, phi ph Phi, T KE ke, V PE pe, tau Tau, alpha acceleration""")
_ANGULAR = {
    re.compile(r"ang(?:ular)?_?vel(?:ocity)?", re.I): "omega",
    re.compile(r"ang(?:ular)?_?acc(?:eleration)?", re.I): "alpha",
}
# names made of words: what is measured, of which body: cart_mass, massPendulum, lengthCM, masse; and bodies A and B
_MEANT = _meanings(
    """m mass masse masa massa, g gravitationalconstant gravity grav gravite gravedad gravidade,
    I inertia inertie inercia moi, F force,
    l length len leng longueur longitud comprimento lunghezza laenge"""
)
_MEANT |= _meanings(
    "cm cm com, pole pole, rod rod, bob bob, cart cart trolley chariot carro, pend pendulum pend pendulo"
)
_PHRASE = re.compile("|".join(sorted(_MEANT, key=len, reverse=True)) + r"|\d(?!\d)|[AB](?![a-z])|_", re.I)
_LETTERED = re.compile(rf"([mMlLrRIJhTVUKxyva]|KE|PE|{_ANGLE}|Theta|Phi)([A-C])")
_RUN_ON = re.compile(
    r"([A-Za-z]+?)(\d+|hat\d?|G|(?<=[vaw])[xyz]|(?<=M)c|(?<=F)g|(?<=omega)[xyz]|(?<=I)(?:xx|yy|zz)|"
    r"(?<=\bp)(?:theta|phi|x)\d?)"
)
_STYLED = re.compile(r"(?:^|_)(?:hat|vec)(?=_|\d|$)")
# what is multiplied without a sign in plain text, such as mglsin
_PRODUCT = re.compile(r"(?:sin|sen|cos|tan|sqrt|theta|phi|omega|[mMglLhrIJFTV]\d?)+[xyz]?")
_PIECES = re.compile(
    "|".join(sorted(FUNCTIONS, key=len, reverse=True)) + r"|theta|phi|omega|[A-Za-z]\d+|[A-Za-z](?=_)|."
)
_LATEX_PIECES = re.compile("|".join(sorted(FUNCTIONS, key=len, reverse=True)) + "|.")


def of_word(word: str) -> Written | None:
    """A name in plain text, such as theta_dd, dphi, omega1, I_1, R1, b_1, xhat, y(2); None if it is not one."""
    if word in FUNCTIONS or word == "d":
        return None
    for words, letter in _ANGULAR.items():
        word = words.sub(letter, word)
    if match := _ELEMENT.fullmatch(word):
        vector, index = of_word(match[1]), f"[{match[2]},{match[3]}]" if match[3] else f"[{match[2]}]"
        of_rates = vector is not None and vector.dots and not vector.index
        if vector and of_rates and (len(vector.letter) == 1 or vector.letter in GREEK or match[1].endswith("dot")):
            return replace(vector, index=index)
        return Written(match[1], 0, index)
    for pattern in _RATES:
        if match := pattern.fullmatch(word):
            groups = match.groupdict("")
            if base := of_word(groups["name"] + (groups.get("index") or groups.get("last", ""))):
                return replace(base, dots=base.dots + (2 if _TWICE.fullmatch(groups.get("order", "")) else 1))
    pieces = [_MEANT.get(piece.lower()) or piece for piece in _PHRASE.findall(word) if piece != "_"]
    letters = [piece for piece in pieces if piece in "mgIFl"]
    if len(letters) == 1 and "".join(_PHRASE.findall(word)) == word:  # pole_mass
        number = "".join(filter(str.isdigit, pieces))  # of massBob1
        return Written(letters[0], 0, number or "".join(piece for piece in pieces if piece not in letters))
    letter, _, index = word.partition("_")
    if not index and (match := _RUN_ON.fullmatch(word) or _LETTERED.fullmatch(word)):
        letter, index = match[1], match[2]
    letter = "omega" if letter == "Omega" and index in ("1", "2") else letter
    bare = _STYLED.sub("", index).strip("_").replace("_", ",")
    return Written(_SHORT.get(letter, GREEK.get(letter, letter)), 0, bare, bool(_STYLED.search(index)))


def of_coordinate(name: str) -> Written:
    """The name of a coordinate as it is printed: theta1 is theta with the index 1."""
    letter = name.rstrip("123456789")
    return Written(letter, 0, name[len(letter) :])


def spelled(word: str, latex: bool, code: bool) -> list[str]:
    """A word taken apart into what is multiplied: names, functions and letters; in plain text a name stays whole.

    Two letters beside each other are a product, but not in `code`.
    """
    written = of_word(word)
    if latex:
        angle = len(word) > 2 and written is not None and written.letter in GREEK
        return [word] if angle or word in ("const", "KE", "PE") else _LATEX_PIECES.findall(word)
    known = {*GREEK.values(), "KE", "PE", "of", "is", "to", "by", "we", "an", "in", "it", "as", "on"}
    if written is None or "_" in word or len(written.letter) == 1 or written.letter in known:
        return [word]
    split = _PRODUCT.fullmatch(word) or (len(word) == 2 and not code)
    return _PIECES.findall(word) if split else [word]


@dataclass(frozen=True, eq=False)
class Vocabulary:
    """What a printed symbol can mean, the likeliest first; `?name` where that is not known.

    They are those of a system, or none; `renamed` are names of the text, as (letter, index), that stand for another name,
    and `chosen` those that have one meaning in the whole text; an empty one is a meaning of the text's own. What a name in
    `also` stands for is one more meaning of it.
    """

    spec: Any = None  # the system
    renamed: dict[Name, Written] = field(default_factory=dict)
    named: frozenset[str] = frozenset()  # coordinates for which the text has a letter
    chosen: dict[Name, str] = field(default_factory=dict)
    also: dict[Name, Written] = field(default_factory=dict)
    script: bool = False  # Lagrange's function is set in script, so that L is rather a length
    taken: dict[str, Name] = field(default_factory=dict)  # meanings that a letter of the text has first
    given: dict[str, Node] = field(default_factory=dict)  # what some symbols are, whatever the text says
    usual: dict[str, Node] = field(default_factory=dict)  # what others are unless the text says it
    _known: dict[Written, tuple[str, ...]] = field(default_factory=dict, init=False)
    _letters: dict[Name, tuple[tuple[str, ...], ...]] = field(default_factory=dict, init=False)

    @cached_property
    def state(self) -> frozenset[str]:
        """Coordinates and rates."""
        return frozenset(self.spec.state if self.spec else ())

    def words(self, written: Written) -> tuple[str, ...]:
        """The meanings of a printed symbol in every text on the system."""
        return self.spec.words(written) if self.spec else raw(written)

    def among(self, names: set[Name]) -> "Vocabulary":
        """The same in a text with some letters: what is the first meaning of one is no other meaning of another."""
        self = replace(self, script={(SCRIPT_L, "")} <= names and not any(letter == "l" for letter, _ in names))
        several = {letter for letter, index in names if index == "2"}  # beside J_1 and J_2 is J neither
        one_by_one = sorted(name for name in names if name[1] or name[0] not in several)
        untaken = replace(self, taken={})
        free = {name: untaken(Written(name[0], 0, name[1])) for name in one_by_one}
        firsts = [(meanings[0], name) for name, meanings in free.items() if not meanings[0].startswith("?")]
        firsts = [one for one in firsts if one[1][1] != "0" or (one[1][0], "") not in free]  # T may be what T_0 is
        # beside L, which may be a length or Lagrange's function, r and d may be none or a length
        firsts = [one for one in firsts if one[0][0] not in "lh" or ("L", one[1][1]) not in names]
        # beside l, r is none
        own = [("".join(name), name) for name, meanings in free.items() if "".join(name) in meanings]
        return replace(self, taken=dict([*firsts, *own]))

    def choosing(self, change: dict[Name, str]) -> "Vocabulary":
        """The same with one meaning alone for some letters."""
        words = replace(self, chosen=self.chosen | change)
        words._letters.update({name: found for name, found in self._letters.items() if name not in change})
        return words

    def __call__(self, written: Written) -> tuple[str, ...]:
        """The meanings of a printed symbol."""
        if written not in self._known:  # a text of a hundred equations asks for each some thousand times
            self._known[written] = self._find(written)
        return self._known[written]

    def meanings_of(self, name: Name) -> tuple[tuple[str, ...], ...]:
        """The meanings of a letter as it may be printed: all that tells what an equation with it means."""
        if name not in self._letters:
            every = (Written(name[0], dots, name[1], styled) for dots in (0, 1) for styled in (False, True))
            self._letters[name] = tuple(map(self, (*every, Written(name[0], frames="IA"))))
        return self._letters[name]

    def _find(self, written: Written) -> tuple[str, ...]:
        name = written.name
        hit = name in self.renamed
        if other := self.renamed.get(name):
            written = replace(other, dots=other.dots + written.dots, styled=written.styled)
        if written in (Written("t"), Written("pi")):
            return (written.letter,)
        found = self.words(written)
        if self.script and written.letter == "L":
            found = tuple(sorted(found, key="L".__eq__))
        if not hit and (lost := [one for one in found if one.lstrip("d") in self.named]):
            # another letter stands for this coordinate: it may still be a quantity of another unit, as alpha_1
            units = {self.spec.dimensions.get(one) for one in lost}
            found = tuple(one for one in found if self.spec.dimensions.get(one) not in units)
        if more := self.also.get(name):
            found = tuple(dict.fromkeys((*found, *self.words(replace(more, dots=more.dots + written.dots))[:1])))
        mine = found[:1] + tuple(one for one in found[1:] if self.taken.get(one, name) == name)
        found = mine if not written.dots else found
        if (choice := self.chosen.get(name)) is not None:
            found = tuple(meaning for meaning in found if meaning == "d" * written.dots + choice)
        return found or (unknown(written),)


def raw(written: Written) -> tuple[str, ...]:
    """The meanings in a text of which nothing is known: none."""
    return (unknown(written),)


UNIT_VECTORS = {f"{frame}{i}" for frame in "ab" for i in "123"} | {"xhat", "yhat", "zhat"}
ANGLES = ("theta", "phi")
SCRIPT_L = "ℒ"  # Lagrange's function, however it is set in script
SHORT_FUNCTIONS = ("s_theta", "c_theta", "s_phi", "c_phi")  # sines and cosines
CONSTANTS = {"?const", "?constant", "?C", *(f"?{letter}_{i}" for letter in "CVULEHT" for i in "01")}  # not known
MOST_DOTS = 6
FUNCTIONS_OF_STATE = {"T", "V", "Veff", "L", "E", "x", "y", "z", "rG", "b3"}
MASS, LENGTH, INERTIA, ENERGY = (1, 0, 0), (0, 1, 0), (1, 2, 0), (1, 2, -2)  # powers of kg, m, s
FORCE = (1, 1, -2)


def bound(node: Node, words: Vocabulary) -> Node:
    """A tree whose names are the first meanings that some words give them.

    A bracket that only says what a quantity depends on, as in D(phi), is no factor. In M(q), where the argument is all
    coordinates at once, M is a matrix or vector, however it is printed.
    """
    if node.kind == "symbol":
        assert node.written is not None
        named = _named(node.written, node.span, words)
        return replace(named, bracketed=node.bracketed) if node.bracketed else named
    children = tuple(bound(child, words) for child in node.children)
    if node.kind == "derivative":
        return replace(node, value=words(node.written)[0] if node.written else "t", children=children)
    if node.kind != "product":
        return replace(node, children=children) if children else node
    left, factors, units = [0], [children[0]], words.spec.dimensions if words.spec else {}
    for i, (before, child) in enumerate(pairwise(children), start=1):
        base = child.children[0] if child.kind == "power" else child
        angle = base.kind == "symbol" and base.value in words.state and base.written and not base.written.dots
        beside = base.bracketed or before.span[1] == base.span[0]
        if before.value in ("?s", "?c") and angle and beside:  # s(theta) and s\\theta are a sine
            name, span = "sin" if before.value == "?s" else "cos", (before.span[0], base.outer[1])
            short = Node("function", span, name, (base,), (before.span,))
            factors[-1] = short if base is child else replace(child, span=(span[0], child.span[1]), children=(short,))
            continue
        inside = child.children if child.kind == "matrix" else (child,)
        names = {part.value if part.kind == "symbol" else "" for part in inside}
        is_name = before.kind in ("symbol", "derivative") and not before.bracketed
        of_state = str(before.value).startswith("?") or before.value in FUNCTIONS_OF_STATE
        of_place = units.get(before.value) == ENERGY and names <= {"x", "y", "z"}  # as U(y)
        in_brackets = child.kind == "matrix" or bool(child.bracketed)
        called = {*words.state, *(f"d{name}" for name in words.state), "t", "q", "dq"}  # L(t, q, dq)
        several = len(inside) > 1 and names <= called and before.written is not None and not before.written.styled
        moving = bool(names) and names <= words.state and not any(name in words.spec.coordinates for name in names)
        product = moving and before.written is not None and before.written.letter in {*DAMPINGS, "L"}  # as b (x')
        only = names <= {"q", "dq"} or (of_state and names <= {*words.state} and not product) or of_place
        if in_brackets and is_name and (several or only):
            if names <= {"q", "dq", "t"} and names & {"q", "dq"} and left[-1] == i - 1 and before.written is not None:
                factors[-1] = _named(replace(before.written, styled=True), before.span, words)
        else:
            left.append(i)
            factors.append(child)
    if len(left) == len(children):
        return replace(node, children=children)
    if len(factors) == 1:
        return factors[0] if node.bracketed is None else replace(factors[0], bracketed=node.bracketed)
    operators, marks = (tuple(listed[i] for i in left) for listed in (node.value, node.marks))
    return replace(node, value=operators, children=tuple(factors), marks=marks)


def _named(written: Written, span: Span, words: Vocabulary) -> Node:
    """A printed name as a node; with dots over what has no name for its rate, a derivative in time."""
    found = words(written)
    if 0 < written.dots < MOST_DOTS and found[0].startswith("?"):
        return Node("derivative", span, "t", (_named(replace(written, dots=written.dots - 1), span, words),))
    return Node("symbol", span, found[0], written=written)
