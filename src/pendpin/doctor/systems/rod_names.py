"""How the quantities of a rod on a universal joint are written: every printed name and what it means."""

import re
from dataclasses import replace
from functools import cache

from pendpin.doctor.reading.names import ANGLES, SHORT_FUNCTIONS, UNIT_VECTORS, Written

VECTORS = UNIT_VECTORS | {"field", "weight", "rG", "vG", "aG", "omega", "alpha", "R", "rT", "M"}
MATRICES = {f"C_{a}{b}" for a in "IAB" for b in "IAB" if a != b} | {"inertia", "inertiaO"}
STILL = {"m", "l", "g", "h", "r", "Fg", "I1", "I2", "I3", "J1", "J2", "J3"}  # what does not move
UNKNOWNS = ("ddtheta", "ddphi", "R1", "R2", "R3", "M3")  # what the balances are solved for

_RATES = {"q_i": "dq_i", "rG": "vG", "vG": "aG", "omega": "alpha"}
_RATES |= {f"{d}{angle}": f"d{d}{angle}" for angle in ANGLES for d in ("", "d")}
_RATES |= {f"v{c}": f"a{c}" for c in "xyz"} | {c: f"v{c}" for c in "xyz"} | {f"w{c}": f"wd{c}" for c in "123xyz"}
_CENTRE = "(?:_(?:G|G/O|G,O|GO|OG|C|CG|c|cm|CM|com|g))?"
_OF_CENTRE = "(?:(?:G|C|cm),?)?"
_TIP = "_(?:T|tip|P|t)"
_PARTS = "(?:_(?:k|c|p|kin|pot|tot))?"
_TURNING = "(?:_(?:B|BI|B/I|IB|I/B|AB))?"
_AXIS = "(?P<axis>[123]|[xyz]|11|22|33|xx|yy|zz)"
_NUMBERS = {name: i for i, letter, unit in zip("123", "xyz", "ijk", strict=True) for name in (i, letter, unit)}
# how a symbol is written as letter_index, with a star for a hat or bold type, and what it can mean, the likeliest first;
# {n} is the number of its axis and {c} the letter. The first row that fits counts.
WRITINGS: tuple[tuple[str, str], ...] = (
    (r"(?P<name>theta|phi)(?:_1)?", "{name}"),
    (r"\*?q_1", "theta"),
    (r"\*?q_2", "phi"),
    (r"\*?q(?:_i)?", "q_i"),
    (r"\*?(?P<name>[sc]_(?:theta|phi))", "{name}"),
    (rf"\*?(?:omega|w){_TURNING}", "omega"),
    (r"\*?(?:omega|w)_(?:B[,/]?)?(?P<axis>[123])", "w{n}"),
    (r"\*?(?:omega|w)_(?:B[,/]?)?(?P<axis>[xyz])", "w{n} w{c}"),
    (rf"\*?alpha{_TURNING}", "alpha"),
    (r"\*?alpha_(?:B[,/]?)?(?P<axis>[123])", "wd{n}"),
    (r"\*?alpha_(?:B[,/]?)?(?P<axis>[xyz])", "wd{n} wd{c}"),
    (r"\*?b_(?P<axis>[123])", "b{n}"),
    (r"\*a_(?P<axis>[123])", "a{n}"),
    (r"a_(?P<axis>[123])", "a{n} ac{n}"),
    (rf"\*[en]_{_AXIS}|\*(?P<unit>[ijk])", "{c}hat"),
    (r"\*(?P<axis>[xyz])(?:_I)?|(?P<unit>[xyz])_I", "{c}hat"),
    (rf"(?P<axis>[xyz]){_CENTRE}", "{c} {c}hat"),
    (rf"(?P<axis>[xyz]){_TIP}", "{c}T"),
    (rf"\*?r{_TIP}", "rT"),
    (r"r", "r rG"),
    (rf"\*?r{_CENTRE}", "rG r"),
    (rf"\*?v{_CENTRE}", "vG speed"),
    (rf"\*?a{_CENTRE}", "aG"),
    (rf"\*?(?P<name>[va])_{_OF_CENTRE}(?P<axis>[xyz]),?G?", "{name}{c}"),
    (rf"\*?(?P<name>[va])_{_OF_CENTRE}(?P<axis>[123]),?G?", "{name}c{n}"),
    (rf"\*?(?P<name>[IJ])_{_AXIS}", "{name}{n}"),
    (r"\*J.*", "inertiaO"),
    (r"\*I.*", "inertia I1"),
    (r"I", "inertia I1 J1"),
    (r"[IJ]_(?:G|C|cm)", "I1"),
    (r"J|[IJ]_[OAP]", "J1"),
    (r"\*(?:F_[gG]|W(?:_[gG])?)", "weight"),
    (r"F_[gG]|W(?:_[gG])?", "Fg"),
    (r"M", "M m"),
    (r"\*M", "M"),
    (r"\*?R", "R"),
    (r"\*?(?P<name>[RM])_(?P<axis>[123])", "{name}{n}"),
    (r"\*?M_[cC]", "Mc"),
    (r"\*g.*", "field"),
    (r"\*?E_(?:k|c|kin)", "T"),
    (r"\*?E_(?:p|pot)", "V"),
    (rf"\*?[TK]{_PARTS}", "T"),
    (rf"\*?[VU]{_PARTS}", "V"),
    (rf"\*?[EH]{_PARTS}", "E"),
    (r"\*?L", "L l"),
    (rf"\*?L{_PARTS}", "L"),
    (r"\*?(?P<name>m|l|g|h|pi|t)", "{name}"),
)


def meanings(written: Written) -> tuple[str, ...]:
    """What a printed symbol can mean, the likeliest first; none for one that is not known."""
    names = _undotted(replace(written, dots=0))
    for _ in range(written.dots):
        names = tuple(_RATES[name] for name in names if name in _RATES)
    return names


@cache
def _undotted(written: Written) -> tuple[str, ...]:
    cosines = f"C_{written.frames}"
    if written.letter == "C":
        return (cosines,) if cosines in MATRICES else ()
    text = "*" * written.styled + written.letter + (f"_{written.index}" if written.index else "")
    for pattern, names in WRITINGS:
        if match := re.fullmatch(pattern, text):
            parts = match.groupdict()
            number = _NUMBERS.get((parts.get("axis") or parts.get("unit") or "1")[:1], "1")
            return tuple(names.format(name=parts.get("name"), n=number, c="xyz"[int(number) - 1]).split())
    return ()


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
