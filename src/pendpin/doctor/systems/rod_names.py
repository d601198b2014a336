"""How the quantities of a rod on a universal joint are written: every printed name and what it means."""

import re
from dataclasses import replace

from pendpin.doctor.reading.names import ANGLES, SHORT_FUNCTIONS, UNIT_VECTORS, Written

VECTORS = UNIT_VECTORS | {"field", "weight", "rG", "vG", "aG", "omega", "alpha", "R", "rT", "M"}
MATRICES = {f"C_{a}{b}" for a in "IAB" for b in "IAB" if a != b} | {"inertia", "inertiaO"}
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
    """What a printed symbol can mean, the likeliest first; none for one that is not known."""
    found = _base(replace(written, dots=0))
    for _ in range(written.dots):
        found = tuple(_RATES[name] for name in found if name in _RATES)
    return found


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
        return {"1": ("theta",), "2": ("phi",), "i": ("q_i",), "": ("q_i",)}.get(index, ())
    if letter in _ENERGIES:
        known = index in ("", "k", "c", "p", "kin", "pot", "tot")
        energy = {"E_k": "T", "E_c": "T", "E_p": "V", "E_kin": "T", "E_pot": "V"}.get(
            f"{letter}_{index}", _ENERGIES[letter]
        )
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
        if styled or index == "I":
            return (letter + "hat",) if index in ("", "I") else ()
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
    if letter == "J" and styled:
        return ("inertiaO",)
    if styled or (letter == "I" and not index):
        return ("inertia", "I1", *(() if styled else ("J1",)))
    return ("I1",) if index in ("G", "C", "cm") else ("J1",) if index in ("", "O", "A", "P") else ()


def _load(letter: str, index: str, styled: bool) -> tuple[str, ...]:
    if letter in ("F", "W"):
        return ("weight" if styled else "Fg",) if (index in ("g", "G") or (letter == "W" and not index)) else ()
    if letter == "R":
        return ("R" + index,) if index in ("1", "2", "3") else ("R",) if not index else ()
    if index or styled:
        return ("M" + index.lower(),) if index in (*"123cC",) else ("M",) if not index else ()
    return ("M", "m")


_POWERS = {  # powers of kg, m, s
    (0, 0, -1): "dtheta dphi omega w1 w2 w3 wx wy wz",
    (0, 0, -2): "ddtheta ddphi alpha wd1 wd2 wd3 wdx wdy wdz",
    (1, 0, 0): "m",
    (0, 1, 0): "l h r x y z xT yT zT rG rT",
    (0, 1, -1): "vG vx vy vz vc1 vc2 vc3 speed",
    (0, 1, -2): "g field aG ax ay az ac1 ac2 ac3",
    (1, 2, 0): "I1 I2 I3 J1 J2 J3 inertia inertiaO",
    (1, 1, -2): "weight R R1 R2 R3 Fg",
    (1, 2, -2): "M M1 M2 M3 Mc T V L E",
}
DIMENSIONS = {powers: names.split() for powers, names in _POWERS.items()}
DIMENSIONS[0, 0, 0] = [
    "theta",
    "phi",
    "pi",
    *SHORT_FUNCTIONS,
    *UNIT_VECTORS,
    *sorted(MATRICES - {"inertia", "inertiaO"}),
]
DIMENSION_OF = {name: dimension for dimension, names in DIMENSIONS.items() for name in names}

LATEX = {"theta": r"\theta", "phi": r"\phi", "Mc": "M_c", "Fg": "F_g", "omega": r"\omega", "alpha": r"\dot{\omega}"}
LATEX |= {f"{d * 'd'}{angle}": rf"\{d * 'd'}ot{{\{angle}}}" for angle in ("theta", "phi") for d in (1, 2)}
LATEX |= {f"{c}hat": rf"\hat{{{c}}}" for c in "xyz"} | {f"{f}{i}": rf"\hat{{{f}}}_{i}" for f in "ab" for i in "123"}
LATEX |= {"speed": "v", "pi": r"\pi", "inertia": r"\mathbf{I}", "field": r"\mathbf{g}", "weight": r"\mathbf{F}_g"}
LATEX |= {f"{f}{i}": f"{f}_{i}" for f in "IJRM" for i in "123"} | {f"{f}{c}": f"{f}_{c}" for f in "va" for c in "xyz"}
LATEX |= {f"w{i}": rf"\omega_{i}" for i in "123"} | {f"wd{i}": rf"\dot{{\omega}}_{i}" for i in "123"}
LATEX |= {"rG": r"\mathbf{r}_G", "vG": r"\mathbf{v}_G", "aG": r"\mathbf{a}_G", "R": r"\mathbf{R}", "M": r"\mathbf{M}"}
LATEX |= {f"{f}_{angle}": f"{f}_\\{angle}" for f in "sc" for angle in ("theta", "phi")}
LATEX |= {f"ac{i}": f"a_{{G,{i}}}" for i in "123"} | {f"vc{i}": f"v_{i}" for i in "123"}
