"""How quantities are written: a letter with dots, an index, a hat; names in plain text; letters that stand for others."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace

FUNCTIONS = {"sin", "cos", "tan", "sec", "csc", "cot", "sqrt"}
_LETTERS = """theta phi omega alpha psi beta gamma tau pi mu lambda rho Omega Delta delta epsilon eta xi zeta kappa nu sigma
chi Phi Theta Psi Gamma Lambda"""
GREEK = {name: name for name in _LETTERS.split()}
GREEK |= {"varphi": "phi", "vartheta": "theta", "ell": "l", "imath": "i", "jmath": "j"}
GREEK |= {"varepsilon": "epsilon", "varrho": "rho"}
GREEK |= {"ℓ": "l", "ϕ": "phi", "ϑ": "theta"}
_SIGNS = """α alpha β beta γ gamma δ delta ε epsilon ζ zeta η eta θ theta κ kappa λ lambda μ mu ν nu ξ xi π pi ρ rho σ sigma
τ tau φ phi χ chi ψ psi ω omega Δ Delta Ω Omega Φ Phi Ψ Psi Γ Gamma Λ Lambda Θ Theta"""
LETTERS: dict[str, str] = dict(zip(_SIGNS.split()[1::2], _SIGNS.split()[::2], strict=True))  # alpha is printed α
GREEK |= {letter: name for name, letter in LETTERS.items()}


@dataclass(frozen=True)
class Written:
    """A printed symbol: its letter, how many dots, its index, a hat or bold type, frames before and after."""

    letter: str
    dots: int = 0
    index: str = ""
    styled: bool = False
    frames: str = ""


_PREFIX = re.compile(r"(d{1,2})_?(theta|phi|omega|alpha|psi|th|ph|w|v|x|y|z|q)_?([0123])?")
_SUFFIX = re.compile(
    r"(theta|phi|omega|alpha|psi|x|y|z|q|th|ph)_?([123]?)_?(d{1,2}|d?dot|(?<![xyz])(?<![xyz]_)(?:t{1,2}|p{1,2}))(?:_([123]))?"
)
_OVER_DT = re.compile(r"d(?P<twice>2|d)?_?(?P<name>[A-Za-z][A-Za-z]*?\d?)_?dt2?")
_DOTTED = re.compile(r"(?P<name>[A-Za-z]+?)_?(?P<index>\d?)_?(?P<twice>d|D)?[dD]ot(?P<last>\d?)")
_OF_STATE = re.compile(r"([A-Za-z]\w*)[(\[](?::,\s*)?(\d+)[)\]]")
_SHORT = {"th": "theta", "ph": "phi", "Th": "theta", "thetadot": "theta", "KE": "T", "PE": "V"}
_SHORT |= {name: GREEK[name] for name in ("ell", "varphi", "vartheta")}
_RUN_ON = re.compile(
    r"([A-Za-z]+?)(\d+|hat|G|hat\d|(?<=v)[xyz]|(?<=a)[xyz]|(?<=M)c|(?<=F)g|(?<=omega)[xyz]|(?<=w)[xyz])"
)
_ORDERS = {"d": 1, "dd": 2, "dot": 1, "ddot": 2, "t": 1, "tt": 2, "p": 1, "pp": 2}


def of_word(word: str) -> Written | None:
    """A name in plain text, such as theta_dd, dphi, omega1, I_1, R1, b_1, xhat; None if it is not one."""
    if word in FUNCTIONS or word == "d":
        return None
    if match := _OF_STATE.fullmatch(word):
        return Written(match[1], 0, f"[{match[2]}]")
    for pattern in (_OVER_DT, _DOTTED):  # as dtheta_dt and thetaDot1
        if match := pattern.fullmatch(word):
            parts = match.groupdict()
            if base := of_word(parts["name"] + (parts.get("index") or parts.get("last") or "")):
                return replace(base, dots=base.dots + (2 if parts["twice"] else 1))
    if match := _PREFIX.fullmatch(word):
        return Written(_SHORT.get(match[2], match[2]), len(match[1]), match[3] or "")
    if match := _SUFFIX.fullmatch(word):
        return Written(_SHORT.get(match[1], match[1]), _ORDERS[match[3]], match[2] or match[4] or "")
    letter, _, index = word.partition("_")
    if not index and (match := _RUN_ON.fullmatch(word)):
        letter, index = match[1], match[2]
    styled = "hat" in index or "vec" in index
    index = index.replace("hat", "").replace("vec", "").strip("_").replace("_", ",")
    return Written(_SHORT.get(letter, GREEK.get(letter, letter)), 0, index, styled)


def is_rate(word: str) -> bool:
    """Whether a word of plain text is a rate, such as theta_1dot."""
    return bool(_PREFIX.fullmatch(word) or _SUFFIX.fullmatch(word))


def is_word(word: str) -> bool:
    """Whether a word of plain text is one name and not several letters multiplied."""
    if len(word) == 1 or "_" in word:
        return True
    written = of_word(word)
    return written is not None and (len(written.letter) == 1 or written.letter in {*GREEK.values(), "KE", "PE"})


def letters_of(word: str, latex: bool) -> list[str]:
    """A word taken apart into functions, Greek names and single letters: mglcos is m g l cos."""
    greek = [] if latex else ["theta", "phi", "omega"]
    names = sorted([*FUNCTIONS, *greek], key=lambda name: -len(name))
    pattern = re.compile("|".join(names) + r"|[A-Za-z]\d+|[A-Za-z](?=_)|.")
    if not latex and "_" in word:
        return [word]
    if not latex and not re.search("|".join(names), word) and len(word) > 4:
        return [word]  # a name that is not known, rather than five letters
    return pattern.findall(word)


@dataclass(frozen=True, eq=False)
class Vocabulary:
    """What a printed symbol can mean, the likeliest first; `?name` where that is not known.

    `words` are those of a system; `renamed` are names of the text, as (letter, index), that stand for another name, and
    `chosen` those that have one meaning in the whole text; an empty one is a meaning of the text's own. What a name in
    `also` stands for is one more meaning of it.
    """

    words: Callable[[Written], tuple[str, ...]]
    renamed: dict[tuple[str, str], Written] = field(default_factory=dict)
    state: frozenset[str] = frozenset()  # coordinates and rates
    named: frozenset[str] = frozenset()  # coordinates for which the text has a letter
    chosen: dict[tuple[str, str], str] = field(default_factory=dict)
    also: dict[tuple[str, str], Written] = field(default_factory=dict)

    def __call__(self, written: Written) -> tuple[str, ...]:
        """The meanings of a printed symbol."""
        name = (written.letter, written.index)
        hit = name in self.renamed
        if not hit and self.named and {name.lstrip("d") for name in self.words(written)} & self.named:
            return (unknown(written),)  # another letter stands for this coordinate
        if other := self.renamed.get(name):
            written = replace(other, dots=other.dots + written.dots)
        if written in (Written("t"), Written("pi")):
            return (written.letter,)
        found = self.words(written)
        if more := self.also.get(name):
            found = tuple(dict.fromkeys((*found, *self.words(replace(more, dots=more.dots + written.dots))[:1])))
        if (choice := self.chosen.get(name)) is not None:
            found = tuple(meaning for meaning in found if meaning == "d" * written.dots + choice)
        return found or (unknown(written),)


def unknown(written: Written) -> str:
    """The name of a symbol that has no meaning of its own."""
    letter, dots, index, frames = written.letter, written.dots, written.index, written.frames
    return "?" + "d" * dots + letter + (f"_{index}" if index else "") + (f"^{frames}" if frames else "")


def raw(written: Written) -> tuple[str, ...]:
    """The meanings in a text of which nothing is known: none."""
    return (unknown(written),)


UNIT_VECTORS = {f"{frame}{i}" for frame in "ab" for i in "123"} | {"xhat", "yhat", "zhat"}
ANGLES = ("theta", "phi")
SHORT_FUNCTIONS = ("s_theta", "c_theta", "s_phi", "c_phi")  # sines and cosines
CONSTANTS = {"?const", "?constant", "?C", *(f"?{letter}_{i}" for letter in "CVULEHT" for i in "01")}  # not known
