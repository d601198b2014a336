"""How the quantities of a rod are written: every printed name and what it means."""

import re
from dataclasses import dataclass, replace

FUNCTIONS = {"sin", "cos", "tan", "sec", "csc", "cot", "sqrt"}
_LETTERS = """theta phi omega alpha psi beta gamma tau pi mu lambda rho Omega Delta delta epsilon eta xi zeta kappa nu sigma
chi Phi Theta Psi Gamma Lambda"""
GREEK = {name: name for name in _LETTERS.split()}
GREEK |= {"varphi": "phi", "vartheta": "theta", "ell": "l", "imath": "i", "jmath": "j"}
GREEK |= {"ℓ": "l", "ϕ": "phi", "ϑ": "theta"}
GREEK |= dict(zip("θφωαπψ", ("theta", "phi", "omega", "alpha", "pi", "psi"), strict=True))


@dataclass(frozen=True)
class Written:
    """A printed symbol: its letter, how many dots, its index, a hat or bold type, frames before and after."""

    letter: str
    dots: int = 0
    index: str = ""
    styled: bool = False
    frames: str = ""


UNIT_VECTORS = {f"{frame}{i}" for frame in "ab" for i in "123"} | {"xhat", "yhat", "zhat"}
VECTORS = UNIT_VECTORS | {"field", "weight", "rG", "vG", "aG", "omega", "alpha", "R", "rT", "M"}
MATRICES = {f"C_{a}{b}" for a in "IAB" for b in "IAB" if a != b} | {"inertia"}
ANGLES = ("theta", "phi")
SHORT_FUNCTIONS = ("s_theta", "c_theta", "s_phi", "c_phi")  # sines and cosines
CONSTANTS = {"?const", "?constant", "?C", *(f"?{letter}_{i}" for letter in "CVULEHT" for i in "01")}  # not known
STILL = {"m", "l", "g", "h", "r", "Fg", "I1", "I2", "I3", "J1", "J2", "J3"}  # what does not move
UNKNOWNS = ("ddtheta", "ddphi", "R1", "R2", "R3", "M3")  # what the balances are solved for

_RATES = {"q_i": "dq_i", "rG": "vG", "vG": "aG", "omega": "alpha"}
_RATES |= {f"{d}{angle}": f"d{d}{angle}" for angle in ANGLES for d in ("", "d")}
_RATES |= {f"v{c}": f"a{c}" for c in "xyz"} | {c: f"v{c}" for c in "xyz"} | {f"w{c}": f"wd{c}" for c in "123xyz"}
_CENTRE = {"", "G", "G/O", "C", "cm", "CM", "com", "c", "OG", "g", "G,O", "GO", "CG"}
_TIP = {"T", "tip", "P", "t"}
_AXES = {name: i for i, letter in zip("123", "xyz", strict=True) for name in (i, letter, 2 * i, 2 * letter)}
_ENERGIES = {"T": "T", "K": "T", "V": "V", "U": "V", "L": "L", "E": "E", "H": "E"}
_SIMPLE = {"m", "l", "g", "h", "r", "pi", "t"}


def meanings(written: Written) -> tuple[str, ...]:
    """What a printed symbol can mean, the likeliest first; `?name` for one that is not known."""
    found = _base(replace(written, dots=0))
    for _ in range(written.dots):
        found = tuple(_RATES[name] for name in found if name in _RATES)
    return found or (unknown(written),)


def unknown(written: Written) -> str:
    """The name of a symbol that has no meaning of its own."""
    letter, dots, index, frames = written.letter, written.dots, written.index, written.frames
    return "?" + "d" * dots + letter + (f"_{index}" if index else "") + (f"^{frames}" if frames else "")


def _base(written: Written) -> tuple[str, ...]:
    letter, index, styled, frames = written.letter, written.index, written.styled, written.frames
    if letter in ANGLES:
        return (letter,) if index in ("", "1") and not styled else ()
    if letter in ("omega", "w", "alpha"):
        return _turning("w" if letter != "alpha" else "wd", "omega" if letter != "alpha" else "alpha", index)
    if letter in ("s", "c") and index in ANGLES:
        return (f"{letter}_{index}",)
    if letter == "C" and len(frames) == 2:
        return (f"C_{frames}",) if f"C_{frames}" in MATRICES else ()
    if letter in ("a", "b", "e", "n", "i", "j", "k", "x", "y", "z", "v", "r"):
        return _vector(letter, index, styled)
    if letter in ("I", "J"):
        return _inertia(letter, index, styled)
    if letter in ("R", "M", "F", "W"):
        return _load(letter, index, styled)
    if letter == "g" and styled:
        return ("field",)
    if letter == "q":
        return {"1": ("theta",), "2": ("phi",), "i": ("q_i",)}.get(index, ())
    if letter in _ENERGIES:
        known = index in ("", "k", "p", "kin", "pot", "tot")
        energy = {"E_k": "T", "E_p": "V", "E_kin": "T", "E_pot": "V"}.get(f"{letter}_{index}", _ENERGIES[letter])
        return () if not known else ("L", "l") if energy == "L" and not index else (energy,)
    return (letter,) if letter in _SIMPLE and not index else ()


def _turning(component: str, vector: str, index: str) -> tuple[str, ...]:
    index = index.removeprefix("B").lstrip(",/") if index not in ("B", "B/I", "BI") else ""
    if index in "123" and index:
        return (component + index,)
    if index in "xyz" and index:
        return (component + _AXES[index], component + index)
    return (vector,) if index in ("", "IB", "I/B", "AB") else ()


def _vector(letter: str, index: str, styled: bool) -> tuple[str, ...]:
    """Unit vectors, positions, velocities and accelerations."""
    if letter in "ab" and index in ("1", "2", "3"):
        return (letter + index,) if styled or letter == "b" else (letter + index, "ac" + index)
    if letter in ("e", "n") and index in _AXES and styled:
        return ({"1": "xhat", "2": "yhat", "3": "zhat"}[_AXES[index]],)
    if letter in "ijk":
        return ({"i": "xhat", "j": "yhat", "k": "zhat"}[letter],) if styled and not index else ()
    if letter in "xyz":
        if styled:
            return (letter + "hat",) if not index or index == "I" else ()
        return (letter, letter + "hat") if index in _CENTRE else (letter + "T",) if index in _TIP else ()
    if letter == "r":
        if index in _TIP:
            return ("rT",)
        return () if index not in _CENTRE else ("rG", "r") if index or styled else ("r", "rG")
    return _components(letter, index, styled)


def _components(letter: str, index: str, styled: bool) -> tuple[str, ...]:
    """v and a, of the centre of mass: the vector, or a component along x, y, z of I or 1, 2, 3 of B."""
    if letter not in "va":
        return ()
    bare = re.sub(r"^(?:G|C|cm)[,]?(?=[xyz123])", "", index).rstrip("G").rstrip(",")
    if bare in ("x", "y", "z"):
        return (letter + bare,)
    if bare in ("1", "2", "3"):
        return (("vc" if letter == "v" else "ac") + bare,)
    return ((letter + "G", "speed") if letter == "v" else (letter + "G",)) if index in _CENTRE else ()


def _inertia(letter: str, index: str, styled: bool) -> tuple[str, ...]:
    if index in _AXES:
        return (letter + _AXES[index],)
    if styled or (letter == "I" and not index):
        return ("inertia", "I1")
    return ("I1",) if index in ("G", "C", "cm") else ("J1",) if index in ("", "O", "A", "P") else ()


def _load(letter: str, index: str, styled: bool) -> tuple[str, ...]:
    if letter in ("F", "W"):
        return ("weight" if styled else "Fg",) if (index in ("g", "G") or (letter == "W" and not index)) else ()
    if letter == "R":
        return ("R" + index,) if index in ("1", "2", "3") else ("R",) if not index else ()
    return ("M" + index.lower(),) if index in (*"123cC",) else ("M",) if styled and not index else ()


_PREFIX = re.compile(r"(d{1,2})_?(theta|phi|omega|x|y|z)_?([123])?")
_SUFFIX = re.compile(r"(theta|phi|omega|x|y|z|th|ph)_?([123]?)_?(d{1,2}|d?dot|t{1,2}|p{1,2})(?:_([123]))?")
_SHORT = {"th": "theta", "ph": "phi", "thetadot": "theta", "KE": "T", "PE": "V"}
_SHORT |= {name: GREEK[name] for name in ("ell", "varphi", "vartheta")}
_RUN_ON = re.compile(
    r"([A-Za-z]+?)(\d+|hat|G|hat\d|(?<=v)[xyz]|(?<=a)[xyz]|(?<=M)c|(?<=F)g|(?<=omega)[xyz]|(?<=w)[xyz])"
)
_ORDERS = {"d": 1, "dd": 2, "dot": 1, "ddot": 2, "t": 1, "tt": 2, "p": 1, "pp": 2}


def of_word(word: str) -> Written | None:
    """A name in plain text, such as theta_dd, dphi, omega1, I_1, R1, b_1, xhat; None if it is not one."""
    if word in FUNCTIONS or word == "d":
        return None
    if match := _PREFIX.fullmatch(word):
        return Written(match[2], len(match[1]), match[3] or "")
    if match := _SUFFIX.fullmatch(word):
        return Written(_SHORT.get(match[1], match[1]), _ORDERS[match[3]], match[2] or match[4] or "")
    letter, _, index = word.partition("_")
    if not index and (match := _RUN_ON.fullmatch(word)):
        letter, index = match[1], match[2]
    styled = "hat" in index or "vec" in index
    index = index.replace("hat", "").replace("vec", "").strip("_").replace("_", ",")
    return Written(_SHORT.get(letter, GREEK.get(letter, letter)), 0, index, styled)


def is_word(word: str) -> bool:
    """Whether a word of plain text is one name and not several letters multiplied."""
    if len(word) == 1 or "_" in word:
        return True
    written = of_word(word)
    return written is not None and (not meanings(written)[0].startswith("?") or written.letter in GREEK)


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


_DIMENSIONS = {  # powers of kg, m, s
    (0, 0, -1): "dtheta dphi omega w1 w2 w3 wx wy wz",
    (0, 0, -2): "ddtheta ddphi alpha wd1 wd2 wd3 wdx wdy wdz",
    (1, 0, 0): "m",
    (0, 1, 0): "l h r x y z xT yT zT rG rT",
    (0, 1, -1): "vG vx vy vz vc1 vc2 vc3 speed",
    (0, 1, -2): "g field aG ax ay az ac1 ac2 ac3",
    (1, 2, 0): "I1 I2 I3 J1 J2 J3 inertia",
    (1, 1, -2): "weight R R1 R2 R3 Fg",
    (1, 2, -2): "M M1 M2 M3 Mc T V L E",
}
DIMENSIONS = {powers: names.split() for powers, names in _DIMENSIONS.items()}
DIMENSIONS[0, 0, 0] = ["theta", "phi", "pi", *SHORT_FUNCTIONS, *UNIT_VECTORS, *sorted(MATRICES - {"inertia"})]
DIMENSION_OF = {name: dimension for dimension, names in DIMENSIONS.items() for name in names}
