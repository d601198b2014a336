"""A rod on a universal joint: what every quantity truly is, how it is written, and the special cases of each kind of rod.

The formulas are those of docs/derivation.md, in the convention of the text, for any type of number; names of that page's own
convention end in _. The accelerations and reactions come from pendpin.equations, run on floats, 50-digit numbers or symbols.
"""

import re
from typing import Any

import numpy as np

from pendpin.doctor.reading.names import ANGLES, SHORT_FUNCTIONS, UNIT_VECTORS, Written
from pendpin.doctor.systems.base import (
    UNITS,
    Formula,
    Quantities,
    Spec,
    Values,
    dot,
    formulas,
    names_written,
    plain_name,
    read_table,
    with_zeros,
)
from pendpin.equations import newton_euler
from pendpin.equations.base import RodInertia

AXES = {"I": ("xhat", "yhat", "zhat"), "A": ("a1", "a2", "a3"), "B": ("b1", "b2", "b3")}
VECTORS = UNIT_VECTORS | {"field", "weight", "rG", "vG", "aG", "omega", "alpha", "R", "rT", "M"}
MATRICES = {f"C_{a}{b}" for a in "IAB" for b in "IAB" if a != b} | {"inertia", "inertiaO"}
STILL = {"m", "l", "g", "h", "r", "Fg", "I1", "I2", "I3", "J1", "J2", "J3"}  # what does not move
UNKNOWNS = ("ddtheta", "ddphi", "R1", "R2", "R3", "M3")  # what the balances are solved for
_ANY = "h I1 I2 I3 J1 J2 J3"
KINDS: dict[str, tuple[str, str, dict[str, str], str]] = {  # title, parameters, what these give, further common names
    "point": ("a point mass on a massless rod", "m l g", {"h": "l", "I1": "0*m", "I3": "0*m"}, ""),
    "thin": ("a uniform thin rod", "m l g", {"h": "l/2", "I1": "m*l*l/12", "I3": "0*m"}, ""),
    "uniform": (
        "a uniform rod of radius r",
        "m l g r",
        {"h": "l/2", "I1": "m*l*l/12 + m*r*r/4", "I3": "m*r*r/2"},
        "r I1 I2 I3",
    ),
    "symmetric": ("any rod with I1 = I2", "m l g h I1 I3 r", {}, _ANY),
    "general": ("any rod", "m l g h I1 I2 I3 r", {}, _ANY),
}
RODS = tuple(KINDS)


def solve(q: Quantities) -> dict[str, Values]:
    """The accelerations and reactions of the true motion."""
    zero, convention = q.number(0), q.convention
    field = np.stack([zero, zero, q["g"] + zero], -1)
    angles, rates = (np.stack([q[f"{d}theta_"], q[f"{d}phi_"]], -1) for d in ("", "d"))
    inertia: Any = [q[name] for name in ("m", "h", "I1", "I2", "I3")]
    answer = newton_euler.solve(RodInertia(*inertia), angles, rates, field, q.xp)
    sign = convention.along
    unknowns = {"R1": answer.R1, "R2": sign * answer.R2, "R3": answer.R3, "M3": sign * answer.M3}
    names = ("ddphi", "ddtheta") if convention.swapped else ("ddtheta", "ddphi")
    return unknowns | {names[0]: convention.theta * answer.theta_dd, names[1]: convention.phi * answer.phi_dd}


def turned(q: Quantities, rows: Values) -> Values:
    """A tensor given by its components (3, 3, n) in B, in I."""
    axes = [q[axis] for axis in AXES["B"]]
    parts = (rows[i, j] * axes[i][:, None] * axes[j][None] for i in range(3) for j in range(3))
    return sum(parts, start=q.number(0))


def _tensor(letter: str) -> Formula:
    """The inertia tensor about G or the joint, in I."""

    def value(q: Quantities) -> Values:
        rows = [[q[f"{letter}{i + 1}"] if i == j else q.number(0) for j in range(3)] for i in range(3)]
        return turned(q, np.array(rows))

    return value


def _cosines(source: str, target: str) -> Formula:
    """The matrix that turns components in one frame into those in another."""

    def value(q: Quantities) -> Values:
        first, second = (target, source) if not q.convention.transposed else (source, target)
        return np.stack([np.stack([dot(q[row], q[column]) for column in AXES[second]]) for row in AXES[first]])

    return value


# name, unit, how it is printed where the text does not print it, how it is written (as names_written says, ~, % and & as in
# _INDICES), and what it is where that is no parameter or unknown
TABLE = r"""
{d}theta_ | - | | | theta_sign*({d}phi if swapped else {d}theta)
{d}phi_ | - | | | phi_sign*({d}theta if swapped else {d}phi)
st_ | - | | | sin(theta_)
ct_ | - | | | cos(theta_)
s_ | - | | | sin(phi_)
c_ | - | | | cos(phi_)
x_ | - | | | vector(1, 0, 0)
y_ | - | | | vector(0, 1, 0)
z_ | - | | | vector(0, 0, 1)
a2_ | - | | | vector(0, ct_, -st_)
a3_ | - | | | vector(0, st_, ct_)
b1_ | - | | | vector(c_, -st_*s_, -ct_*s_)
b2_ | - | | | a2_
b3_ | - | | | vector(s_, st_*c_, ct_*c_)
pi | 1 | \pi | +pi
theta | 1 | \theta | theta theta_1 +q_1
phi | 1 | \phi | phi phi_1 +q_2
q_i | - | | +q +q_i
d{q} | 1/s | \dot{\{q}}
dd{q} | 1/s2 | \ddot{\{q}}
s_{q} | 1 | s_\{q} | +s_{q} | sin({q})
c_{q} | 1 | c_\{q} | +c_{q} | cos({q})
a1 | 1 | \hat{a}_1 | +a_1 | x_
a2 | 1 | \hat{a}_2 | +a_2 | along*a2_
a3 | 1 | \hat{a}_3 | +a_3 | along*a3_
b1 | 1 | \hat{b}_1 | +b_1 | b1_
b2 | 1 | \hat{b}_2 | +b_2 | along*b2_
b3 | 1 | \hat{b}_3 | +b_3 | along*b3_
xhat | 1 | \hat{x} | *e_@ *n_@ *i *x +x_I *x x | x_
yhat | 1 | \hat{y} | *e_@ *n_@ *j *y +y_I *y y | y_sign*y_
zhat | 1 | \hat{z} | *e_@ *n_@ *k *z +z_I *z z | z_sign*z_
m | kg | | +m M
l | m | | +l +L
r | m | | r +r~
h | m | | +h
g | m/s2 | | g
I1 | kg m2 | I_1 | +I_@ +I_@@ I_G J_G I_C J_C I_cm J_cm I *I
I2 | kg m2 | I_2 | +I_@ +I_@@ | I1
I3 | kg m2 | I_3 | +I_@ +I_@@
J1 | kg m2 | J_1 | +J_@ +J_@@ J J_O J_A J_P I_O I_A I_P - - I | I1 + m*h**2
J2 | kg m2 | J_2 | +J_@ +J_@@ | I2 + m*h**2
J3 | kg m2 | J_3 | +J_@ +J_@@ | I3
Fg | N | F_g | F_g W W_g | m*g
field | m/s2 | \mathbf{g} | *g | g*z_
weight | N | \mathbf{F}_g | *F_g *W *W_g | m*field
rG | m | \mathbf{r}_G | +r~ | h*b3_
rT | m | | +r_T +r_tip +r_P | l*b3_
vG | m/s | \mathbf{v}_G | +v~ | h*(dphi_*b1_ + dtheta_*c_*b2_)
aG | m/s2 | \mathbf{a}_G | +a~ | h*(ag1_*b1_ + (ddtheta_*c_ - 2*dtheta_*dphi_*s_)*b2_ + ag3_*b3_)
ag1_ | - | | | ddphi_ + dtheta_*dtheta_*s_*c_
ag3_ | - | | | -(dphi_*dphi_ + dtheta_*dtheta_*c_*c_)
omega | 1/s | \omega | +omega& +w& | -dtheta_*c_*b1_ + dphi_*b2_ + -dtheta_*s_*b3_
alpha | 1/s2 | \dot{\omega} | +alpha& | al1_*b1_ + ddphi_*b2_ + (-ddtheta_*s_ - dtheta_*dphi_*c_)*b3_
al1_ | - | | | -ddtheta_*c_ + dtheta_*dphi_*s_
speed | m/s | v | - +v~ | sqrt(dot(vG, vG))
{c} | m | | {c}~ | dot(rG, {c}hat)
{c}T | m | | {c}_T {c}_tip {c}_P | dot(rT, {c}hat)
v{c} | m/s | v_{c} | +v_{c} +v_G{c} +v_C{c} +v_cm{c} +v_{c}G | dot(vG, {c}hat)
a{c} | m/s2 | a_{c} | +a_{c} +a_G{c} +a_C{c} +a_cm{c} +a_{c}G | dot(aG, {c}hat)
vc{i} | m/s | v_{i} | +v_{i} +v_G{i} +v_C{i} +v_cm{i} +v_{i}G | dot(vG, b{i})
ac{i} | m/s2 | a_{G,{i}} | a_{i} +a_G{i} +a_C{i} +a_cm{i} +a_{i}G | dot(aG, b{i})
w{c} | 1/s | | +omega_{c} +omega_B{c} +w_{c} +w_B{c} | dot(omega, {c}hat)
w{i} | 1/s | \omega_{i} | +omega_@ +omega_B@ +w_@ +w_B@ | dot(omega, b{i})
wd{c} | 1/s2 | | +alpha_{c} +alpha_B{c} | dot(alpha, {c}hat)
wd{i} | 1/s2 | \dot{\omega}_{i} | +alpha_@ +alpha_B@ | dot(alpha, b{i})
R{i} | N | R_{i} | +R_{i}
R | N | \mathbf{R} | +R | R1*b1_ + along*R2*b2_ + -R3*b3_
Mc | N m | M_c | +M_c | M3/c_
M | N m | \mathbf{M} | +M | along*Mc*a3_
M1 | N m | M_1 | +M_1 | dot(M, b1)
M2 | N m | M_2 | +M_2 | dot(M, b2)
M3 | N m | M_3 | +M_3
T | N m | | +E_k +E_c +E_kin +T% +K% | (m*dot(vG, vG) + (I1*w1**2 + I2*w2**2 + I3*w3**2))/2
V | N m | | +E_p +E_pot +V% +U% | -m*g*h*c_*ct_
L | N m | | +L% | T - V
E | N m | | +E +E_tot +H% | T + V
"""
# indices of the centre of mass, of energies, and of how B turns
_INDICES = {"~": "_ _G _C _CG _cm _com _GO _OG", "%": "_ _k _c _p _kin _pot _tot", "&": "_ _B _BI _IB _AB"}
ROWS = read_table(TABLE, 5)
FORMULAS: dict[str, Formula] = formulas({row[0]: row[4] for row in ROWS if row[4]})
FORMULAS |= {f"C_{a}{b}": _cosines(a, b) for a in "IAB" for b in "IAB" if a != b}
FORMULAS |= {"inertia": _tensor("I"), "inertiaO": _tensor("J")}
LATEX = {name: printed for name, _, printed, *_ in ROWS if printed} | {"inertia": r"\mathbf{I}"}
DIMENSION_OF = {name: powers for name, unit, *_ in ROWS if (powers := UNITS[unit]) is not None}
DIMENSION_OF |= dict.fromkeys(MATRICES, (0, 0, 0)) | dict.fromkeys(("inertia", "inertiaO"), (1, 2, 0))
_RATES = {"q_i": "dq_i", "rG": "vG", "vG": "aG", "omega": "alpha"}
_RATES |= {f"{d}{angle}": f"d{d}{angle}" for angle in ANGLES for d in ("", "d")}
_RATES |= {f"v{c}": f"a{c}" for c in "xyz"} | {c: f"v{c}" for c in "xyz"} | {f"w{c}": f"wd{c}" for c in "123xyz"}
_TENSORS = {"inertia": "*I I", "inertiaO": "*J", "t": "+t"}
_INDEXED = {
    r[0]: " ".join(w[:-1] + end for w in r[3].split() for end in _INDICES.get(w[-1], w[-1]).split()) for r in ROWS
}
_WRITTEN = names_written(_INDEXED | _TENSORS)


def meanings(written: Written) -> tuple[str, ...]:
    """What a printed symbol can mean, the likeliest first; none for one that is not known."""
    names = _WRITTEN.get("*" * written.styled + plain_name(written.letter + written.index), ())
    if written.styled and written.letter in ("I", "J", "g"):  # a tensor and the field, whatever their index
        names = names or _WRITTEN["*" + written.letter]
    if written.letter == "C":  # direction cosines
        names = tuple({f"C_{written.frames}"} & MATRICES)
    for _ in range(written.dots):
        names = tuple(_RATES[name] for name in names if name in _RATES)
    return names


_COMMON = ("theta", "phi", "dtheta", "dphi", "ddtheta", "ddphi", "m", "l", "g", "R1", "R2", "R3", "M3", "Mc", "Fg")
_FAMILIES = """x y z; vx vy vz; ax ay az; w1 w2 w3; wd1 wd2 wd3; ac1 ac2 ac3; vc1 vc2 vc3; I1 I2 I3 J1 J2 J3; T V L E
wx wy wz; xT yT zT; M1 M2 M3 Mc; rG vG aG rT; omega alpha; h l r; R M"""
FAMILIES = (
    *(tuple(names.split()) for names in re.split(r"[;\n]", _FAMILIES)),
    *(tuple(sorted(UNIT_VECTORS)), tuple(sorted(MATRICES)), SHORT_FUNCTIONS),
)
_EXTRA = "ddtheta ddphi R1 R2 R3 M3 Mc I1 I2 I3 J1 J2 J3 h theta phi x y z vx vy vz w1 w2 w3"

SPECS: dict[str, Spec] = {
    kind: Spec(
        kind=kind,
        title=title,
        coordinates=ANGLES,
        parameters=tuple(parameters.split()),
        unknowns=UNKNOWNS,
        formulas=FORMULAS | formulas(given),
        solve=solve,
        words=meanings,
        dimensions=DIMENSION_OF,
        printed=LATEX,
        still=frozenset(STILL),
        common=(*_COMMON, *common.split()),
        families=FAMILIES,
        vectors=frozenset(VECTORS),
        matrices=frozenset(MATRICES),
        moving=("dtheta", "dphi", "sin theta", "cos theta", "sin phi", "cos phi"),
        extra=tuple(_EXTRA.split()),
    )
    for kind, (title, parameters, given, common) in KINDS.items()
}

# other rods that an equation may be about: words, what it is then, how a text says it, and what an equation on it lacks
_THIN, _BOB = r"\bthin\b|slender", r"point mass|\bbob\b|massless|string|simple pendulum"
_SLENDER = with_zeros(SPECS["symmetric"], ("I3", "J3"))  # without inertia about its axis
_OTHERS: dict[str, tuple[str, Spec, str, frozenset[str]]] = {
    "slender": ("I3 = 0 and I1 = I2, as for a thin rod", _SLENDER, _THIN, frozenset(("I3", "J3"))),
    "thin": ("it is a uniform thin rod", SPECS["thin"], _THIN, frozenset(("I3", "J3", "h", "r"))),
    "uniform": ("it is a uniform rod of radius r", SPECS["uniform"], "uniform|cylinder|homogeneous", frozenset("h")),
    "equal": ("I1 = I2", SPECS["symmetric"], r"symmetric|I_?1\s*=\s*I_?2", frozenset(("I1", "I2", "J1", "J2"))),
    "point": ("it is a point mass on a massless rod", SPECS["point"], _BOB, frozenset(("I3", "J3", "h", "r"))),
}
_TRIED = {"general": "slender thin uniform equal point", "symmetric": "slender thin uniform point"}
_TRIED |= {"uniform": "thin point", "thin": "uniform point", "point": "thin"}
SPECIAL = {kind: [_OTHERS[name] for name in names.split()] for kind, names in _TRIED.items()}
