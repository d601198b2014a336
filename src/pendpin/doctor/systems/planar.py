"""Systems that move in a vertical plane: one pendulum, two, and one on a cart; and a pendulum in polar angle and azimuth.

A body is a point mass at the end of its length, a
uniform rod, or any body with its centre of mass at h and the inertia I about it. Angles are measured from one of POSES.
"""

from itertools import product

import numpy as np

from pendpin.doctor.systems.base import ENERGY_SUMS, Formula, Quantities, Spec, Values
from pendpin.doctor.systems.linkages import POSES, SLIDES, Linkage
from pendpin.doctor.systems.tables import Table, table_spec

BODIES = {"any": "any rigid body", "point": "a point mass on a string or massless rod", "uniform": "a uniform rod"}

_PLANE = """
theta | 1 | theta q q_1 theta_1
m | kg | m m_1 M
g | m/s2 | g G gravity grav
l | m | l L ell l_1 L_1 R r length
h | m | h d a b s r l_c l_cm h_G r_G r_cm l_1 L l ell R h_cm l_G d_cm
k | m | k k_G i_G rho rho_G k_0
kO | m | k k_O i_O rho_O k_0
theta0 | 1 | theta_0 theta_m theta_max phi_0 varphi_0 alpha_0 theta_i alpha phi_m varphi_m
J | kg m2 | J I J_O I_O J_1 I_1 J_A I_A I_P J_P I_0 J_0 J_o I_o
I | kg m2 | I I_G I_C I_cm J_G J_C I_CM J_cm J_S I_S
rG | m | *r *r_G *x *R
x | m | x x_G x_C x_cm x_1
y | m | y y_G y_C y_cm y_1 z h_y
vx | m/s | v_x
vy | m/s | v_y v_z
v | m/s | v v_G v_cm
omega | 1/s | omega Omega w
alpha | 1/s | alpha
w0 | 1/s | omega omega_0 omega_n Omega
T | N m | T K E_k E_c T_1 E_kin KE
V | N m | V U E_p E_pot PE Pi
L | N m | L
E | N m | E H E_0 H_0
p | N m s | p p_theta L_O H_O L p_1 p_q
S | N | T S F_T N R_n F_r F_n R_r R_3 F T_s
Rx | N | R_x O_x A_x F_x H N_x X
Ry | N | R_y O_y A_y F_y V N_y Y
Rt | N | R_t F_t O_t R_1 N_t
W | N | W F_g G
period | s | T T_0 tau P
"""

_TWO = """
theta1 | 1 | theta_1 q_1 alpha_1 phi_1 varphi_1
theta2 | 1 | theta_2 q_2 alpha_2 phi_2 varphi_2
m1 | kg | m_1 M_1 m
m2 | kg | m_2 M_2 m
g | m/s2 | g G gravity grav
l1 | m | l_1 L_1 l L ell ell_1 a_1 a R_1 r_1 r R
l2 | m | l_2 L_2 l L ell ell_2 a_2 b R_2 r_2 r R
h1 | m | h_1 l_c1 r_1 d_1 l_c,1 s_1 l_cm1 l_g1 lc_1 a_1 c_1 l_1 h lc1
h2 | m | h_2 l_c2 r_2 d_2 l_c,2 s_2 l_cm2 l_g2 lc_2 a_2 c_2 l_2 h lc2
I1 | kg m2 | I_1 J_1 I_c1 I_c,1 I_G1 I J
I2 | kg m2 | I_2 J_2 I_c2 I_c,2 I_G2 I J
J1 | kg m2 | J_1 I_1 I_O1
J2 | kg m2 | J_2 I_2 I_O2
x1 | m | x_1
y1 | m | y_1 z_1
x2 | m | x_2
y2 | m | y_2 z_2
xp1 | m | x_1
yp1 | m | y_1 z_1
xp2 | m | x_2
yp2 | m | y_2 z_2
T | N m | T K E_k E_c KE
V | N m | V U E_p PE
T1 | N m | T_1 K_1 E_k1
T2 | N m | T_2 K_2 E_k2
V1 | N m | V_1 U_1 E_p1
V2 | N m | V_2 U_2 E_p2
S1 | N | T_1 S_1 F_1 N_1
S2 | N | T_2 S_2 F_2 N_2
L | N m | L
E | N m | E H
p1 | N m s | p_1 p_theta1 p_theta_1 p_theta,1 ptheta_1 P_1 p_q1 p_phi1
p2 | N m s | p_2 p_theta2 p_theta_2 p_theta,2 ptheta_2 P_2 p_q2 p_phi2
M11 | kg m2 | M_11 m_11 H_11 d_11 B_11 D_11
M12 | kg m2 | M_12 m_12 H_12 d_12 M_21 m_21 B_12 D_12 D_21
M22 | kg m2 | M_22 m_22 H_22 d_22 B_22 D_22
tau1 | N m | tau_1 Q_1
tau2 | N m | tau_2 tau u Q_2
w1 | 1/s | omega_1 w_1
w2 | 1/s | omega_2 w_2
tau | N m | *tau *Q *u *f tau
q | 1 | q *q *theta
mass | kg m2 | *M *H *D *B
weight | N m | *G *g
"""

_CART = """
x | m | x q_1 s q z p x_c x_1
theta | 1 | theta phi alpha q_2 varphi psi
M | kg | M m_c m_1 M_c m_C M_1 m_cart m_0 M_cart masscart mass_cart mc cart_mass
m | kg | m m_p m_2 m_P m_1 m_pole M_p masspole mass_pole mp pole_mass m_pend M_pole
g | m/s2 | g G gravity grav
l | m | l L ell l_1 l_p L_p r R length
h | m | l L ell h d length l_1 a l_c b l_p L_p l_cm l_G r R
I | kg m2 | I J I_G I_1 J_1 I_p J_p I_cm I_c J_c I_P
J | kg m2 | J I I_O J_O I_t J_t
xp | m | x_p x_2 x_m x_1 x_G
yp | m | y_p y_2 y_m y y_1 y_G
T | N m | T K E_k E_c KE
V | N m | V U E_p PE
Tc | N m | T_c T_1 K_c K_1 T_M T_C
Tp | N m | T_p T_2 K_p K_2 T_m T_P
S | N | S T R N F_T F_r
L | N m | L
E | N m | E H
q | - | q *q
mass | - | *M *H *D
weight | - | *G *g
px | N m s | p_x p_1
ptheta | N m s | p_theta p_2
F | N | F u f f_x F_x Q_x Q_1 U tau F_c F_1 force
N | N | N H N_x
P | N | P V N_y
"""

_POLAR = """
theta | 1 | theta
phi | 1 | phi
m | kg | m M
g | m/s2 | g G gravity grav
l | m | l L R r ell a
h | m | h l L R r ell a d
J | kg m2 | J I J_1 I_1
rG | m | *r *r_G *x *R
x | m | x
y | m | y
z | m | z
v | m/s | v
T | N m | T K E_k E_c
V | N m | V U E_p
L | N m | L
E | N m | E H
p | N m s | p_phi L_z l_z J_z h_z p L_0 h ell
ptheta | N m s | p_theta
S | N | T S N F_T F R_3
"""


def _body(body: str, m: str, length: str, h: str, inertia: str) -> dict[str, Formula]:
    """The centre of mass and the inertia about it of a body; none where they are parameters."""
    if body == "any":
        return {}
    half, one = (2, 12) if body == "uniform" else (1, 1)
    zero = 0 if body == "point" else 1
    return {
        h: lambda q: q[length] / q.number(half),
        inertia: lambda q: q[m] * q[length] ** 2 * q.number(zero) / q.number(one),
    }


_NO_INERTIA = {
    "any": (),
    "uniform": (),
    "point": ("I", "I1", "I2", "k"),
}  # names that a text on such bodies does not use
AMPLITUDE = 1.3  # rad: where a pendulum is released in equations with that angle


def _energies(linkage: Linkage) -> dict[str, Formula]:
    """The energies, and of two coordinates the matrix form: q, the mass matrix, and the slope of the potential energy."""
    names, energies = linkage.coordinates, {"T": linkage.kinetic, "V": linkage.potential, **ENERGY_SUMS}
    if len(names) == 1:
        return energies
    mass = lambda q: np.stack([np.stack([linkage.mass(a, b)(q) for b in names]) for a in names])  # noqa: E731
    weight = lambda q: np.stack([q.derivative(linkage.potential, name) for name in names])  # noqa: E731
    return {**energies, "q": lambda q: np.stack([q[name] for name in names]), "mass": mass, "weight": weight}


def _rate(name: str, order: int = 1) -> Formula:
    """The rate of a quantity; the second gives its acceleration."""
    return lambda q: q.derivative(lambda there: there["d" * (order - 1) + name], "t")


def _plane(body: str, pose: str) -> Spec:
    linkage = Linkage(("theta",), (("theta",),), (("m", "I", ("h",)),), pose)
    sign = -1 if pose == "up" else 1  # of the weight's moment
    s, c = (lambda q: q.xp.sin(q["theta"])), (lambda q: q.xp.cos(q["theta"]))
    formulas = {
        **_body(body, "m", "l", "h", "I"),
        **_energies(linkage),
        "J": linkage.mass("theta", "theta"),
        "k": lambda q: q.xp.sqrt(q["I"] / q["m"]),
        "kO": lambda q: q.xp.sqrt(q["J"] / q["m"]),
        "rG": lambda q: np.stack([q["x"], q["y"]]),
        "x": linkage.place("x", ("h",)),
        "y": linkage.place("y", ("h",)),
        "vx": _rate("x"),
        "vy": _rate("y"),
        "v": lambda q: q["h"] * q["dtheta"],
        "omega": lambda q: q["dtheta"] + q.number(0),
        "alpha": lambda q: q["ddtheta"] + q.number(0),
        "w0": lambda q: q.xp.sqrt(q["m"] * q["g"] * q["h"] / q["J"]),
        "period": lambda q: q.number(2) * q.xp.pi / q["w0"],
        "p": linkage.momentum("theta"),
        "S": lambda q: q["m"] * (q["h"] * q["dtheta"] ** 2 + sign * q["g"] * c(q)),
        "Rt": lambda q: q["m"] * (q["h"] * q["ddtheta"] + sign * q["g"] * s(q)),
        "Rx": lambda q: q["m"] * q["h"] * (c(q) * q["ddtheta"] - s(q) * q["dtheta"] ** 2),
        "Ry": lambda q: q["m"] * (q["g"] + sign * q["h"] * (s(q) * q["ddtheta"] + c(q) * q["dtheta"] ** 2)),
        "W": lambda q: q["m"] * q["g"],
    }
    title = f"a pendulum in a plane, {BODIES[body]}, in its angle from {POSES[pose][0]}"
    parameters = ("m", "g", "l", "theta0", *(("h", "I") if body == "any" else ()))
    extra = ("h", "I", "J") if body == "any" else ("h",)
    return table_spec(
        f"plane {body} {pose}",
        title,
        Table(_PLANE, _NO_INERTIA[body]),
        linkage.coordinates,
        parameters,
        formulas,
        linkage.solve,
        extra=(*extra, "omega", "v", "x"),
        values={"theta0": AMPLITUDE},
    )


def _pair(body: str, relative: bool, pose: str, loads: tuple[str, ...]) -> tuple[Linkage, dict[str, Formula]]:
    """Two links and what is true of them."""
    second = ("theta1", "theta2") if relative else ("theta2",)
    bodies = (("m1", "I1", ("h1",)), ("m2", "I2", ("l1", "h2")))
    linkage = Linkage(("theta1", "theta2"), (("theta1",), second), bodies, pose, forces=("tau1", "tau2"))
    ends = {"1": ("h1",), "2": ("l1", "h2"), "p1": ("l1",), "p2": ("l1", "l2")}
    zeros: dict[str, Formula] = {name: lambda q: q.number(0) for name in ("tau1", "tau2") if name not in loads}
    return linkage, {
        **_body(body, "m1", "l1", "h1", "I1"),
        **_body(body, "m2", "l2", "h2", "I2"),
        **_energies(linkage),
        **{f"J{i}": (lambda q, i=i: q[f"I{i}"] + q[f"m{i}"] * q[f"h{i}"] ** 2) for i in (1, 2)},
        **{f"{axis}{end}": linkage.place(axis, lengths) for axis in "xy" for end, lengths in ends.items()},
        **{f"p{i}": linkage.momentum(f"theta{i}") for i in (1, 2)},
        **{f"w{i}": (lambda q, i=i: q[f"dtheta{i}"] + q.number(0)) for i in (1, 2)},
        "tau": lambda q: np.stack([q["tau1"], q["tau2"]]),
        **{f"T{i}": _moving_energy(i) for i in "12"},
        **{f"V{i}": (lambda q, i=i: q[f"m{i}"] * q["g"] * q[f"y{i}"]) for i in "12"},
        "S2": lambda q: _pull(q, "2", ("2",)),
        "S1": lambda q: _pull(q, "1", ("1", "2")),
        **{f"M{i}{j}": linkage.mass(f"theta{i}", f"theta{j}") for i, j in ((1, 1), (1, 2), (2, 2))},
        **zeros,
    }


def _moving_energy(i: str) -> Formula:
    """The kinetic energy of one of two links."""

    def value(q: Quantities) -> Values:
        across, up = (q.derivative(lambda there, name=name: there[name], "t") for name in (f"x{i}", f"y{i}"))
        turn = q["dtheta1"] + (q["dtheta2"] if i == "2" and " relative" in q.spec.kind else q.number(0))
        turn = q["dtheta2"] if i == "2" and " relative" not in q.spec.kind else turn
        return (q[f"m{i}"] * (across**2 + up**2) + q[f"I{i}"] * turn**2) / q.number(2)

    return value


def _pull(q: Quantities, link: str, carried: tuple[str, ...]) -> Values:
    """What a link pulls along itself on the bodies that it carries."""
    start = (q.number(0), q.number(0)) if link == "1" else (q["xp1"], q["yp1"])
    across, up = ((q[f"{axis}{link}"] - begin) / q[f"h{link}"] for axis, begin in zip("xy", start, strict=True))
    total = q.number(0)
    for i in carried:
        total = total - q[f"m{i}"] * (_rate(f"x{i}", 2)(q) * across + (_rate(f"y{i}", 2)(q) + q["g"]) * up)
    return total


def _two(body: str, relative: bool, equal: bool, pose: str, drive: str = "") -> Spec:
    loads = {"acrobot": ("tau2",), "both": ("tau1", "tau2"), "": ()}[drive]
    linkage, formulas = _pair(body, relative, pose, loads)
    parameters = ("m1", "m2", "g", "l1", "l2", *(("h1", "h2", "I1", "I2") if body == "any" else ()))
    if equal:
        pairs = [(name, name[:-1] + "1") for name in parameters if name.endswith("2")]
        formulas |= {name: (lambda q, other=other: q[other] + q.number(0)) for name, other in pairs}
        parameters = tuple(name for name in parameters if not name.endswith("2"))
    kinds = {"point": "point masses", "uniform": "uniform rods", "any": "rigid bodies"}[body]
    which, where = "relative" if relative else "absolute", POSES[pose][0]
    driven = {"acrobot": ", with a torque at the second joint", "both": ", with torques at both joints", "": ""}[drive]
    title = f"a double pendulum in a plane of {'equal ' * equal}{kinds}, in {which} angles from {where}{driven}"
    kind = f"double {body} {which}{' equal' * equal} {pose}{f' {drive}' if drive else ''}"
    both = f"theta1{'+' if relative else '-'}theta2"
    atoms = (f"sin {both}", f"cos {both}")
    table, parameters = Table(_TWO, _NO_INERTIA[body]), (*parameters, *loads)
    return table_spec(kind, title, table, linkage.coordinates, parameters, formulas, linkage.solve, atoms)


def _cart(body: str, pose: str, mirrored: bool) -> Spec:
    bodies = (("M", "", (SLIDES,)), ("m", "I", (SLIDES, "h")))
    linkage = Linkage(("x", "theta"), (("x",), ("theta",)), bodies, pose, mirrored, ("F", ""))
    formulas = {
        **_body(body, "m", "l", "h", "I"),
        **_energies(linkage),
        "J": linkage.mass("theta", "theta"),
        "xp": linkage.place("x", (SLIDES, "h")),
        "yp": linkage.place("y", (SLIDES, "h")),
        "px": linkage.momentum("x"),
        "ptheta": linkage.momentum("theta"),
        "Tc": lambda q: q["M"] * q["dx"] ** 2 / q.number(2),
        "Tp": lambda q: q["T"] - q["Tc"],
        "S": lambda q: -(q["N"] * (q["xp"] - q["x"]) + q["P"] * q["yp"]) / q["h"],
        "N": lambda q: q["m"] * _rate("xp", 2)(q),
        "P": lambda q: q["m"] * (q["g"] + _rate("yp", 2)(q)),
    }
    where = f"{POSES[pose][0]}{', positive the other way' * mirrored}"
    title = f"a pendulum on a cart, {BODIES[body]}, its angle from {where}"
    kind = f"cart-pole {body} {pose}{' mirrored' * mirrored}"
    parameters = ("M", "m", "g", "l", *(("h", "I") if body == "any" else ()), "F")
    table, extra = Table(_CART, _NO_INERTIA[body]), ("J", "I", "F")
    return table_spec(kind, title, table, linkage.coordinates, parameters, formulas, linkage.solve, extra=extra)


def conical_rate(q: Quantities) -> Values:
    """The rate of the azimuth of a spherical pendulum that keeps its polar angle."""
    return q.xp.sqrt(q["m"] * q["g"] * q["h"] / q["J"] / q.xp.cos(q["theta"]))


def _polar(body: str, up: bool) -> Spec:
    sign = -1 if up else 1

    def solve(q: Quantities) -> dict[str, Values]:
        s, c, turn = q.xp.sin(q["theta"]), q.xp.cos(q["theta"]), q["dphi"]
        down = turn**2 * s * c - sign * q["m"] * q["g"] * q["h"] * s / q["J"]
        return {"ddtheta": down, "ddphi": -q.number(2) * q["dtheta"] * turn * c / s}

    def square(q: Quantities) -> Values:
        return q["dtheta"] ** 2 + (q["dphi"] * q.xp.sin(q["theta"])) ** 2

    inertia = _body(body, "m", "l", "h", "I")
    if body != "any":
        inertia["J"] = lambda q: q["I"] + q["m"] * q["h"] ** 2
    formulas = {
        **inertia,
        "rG": lambda q: np.stack([q["x"], q["y"], q["z"]]),
        "x": lambda q: q["h"] * q.xp.sin(q["theta"]) * q.xp.cos(q["phi"]),
        "y": lambda q: q["h"] * q.xp.sin(q["theta"]) * q.xp.sin(q["phi"]),
        "z": lambda q: -sign * q["h"] * q.xp.cos(q["theta"]),
        "v": lambda q: q["h"] * q.xp.sqrt(square(q)),
        "T": lambda q: q["J"] * square(q) / q.number(2),
        "V": lambda q: q["m"] * q["g"] * q["z"],
        **ENERGY_SUMS,
        "p": lambda q: q["J"] * q["dphi"] * q.xp.sin(q["theta"]) ** 2,
        "ptheta": lambda q: q["J"] * q["dtheta"],
        "S": lambda q: q["m"] * (q["h"] * square(q) + sign * q["g"] * q.xp.cos(q["theta"])),
    }
    where = "upwards" if up else "downwards"
    title = f"a spherical pendulum, {BODIES[body]}: theta is the polar angle from {where} and phi the azimuth"
    parameters = ("m", "g", "l", *(("h", "J") if body == "any" else ()))
    kind, names = f"polar {body}{' up' * up}", ("theta", "phi")
    return table_spec(kind, title, Table(_POLAR), names, parameters, formulas, solve, extra=("J", "p"))


_FLAGS = (False, True)
_VERTICAL = ("down", "up")
PLANE = [_plane(body, pose) for body, pose in product(BODIES, _VERTICAL)]
TWO = [_two(body, a, b, pose) for pose, body, a, b in product(POSES, BODIES, _FLAGS, _FLAGS)]
ACROBOT = [_two(body, True, False, pose, drive) for pose, body, drive in product(POSES, BODIES, ("acrobot", "both"))]
CART = [_cart(body, pose, mirrored) for body, pose, mirrored in product(BODIES, _VERTICAL, _FLAGS)]
POLAR = [_polar(body, up) for body, up in product(BODIES, _FLAGS)]
FAMILIES = {"plane": PLANE, "polar": POLAR, "cart-pole": CART, "double": TWO, "acrobot": ACROBOT}
