"""Systems that move in a vertical plane: one pendulum, two, and one on a cart; and a pendulum in polar angle and azimuth.

Each is a function that gives accelerations, energies and positions; a body is a point mass at the end of its length, a
uniform rod, or any body with its centre of mass at h and the inertia I about it. Angles are measured from the vertical,
hanging ("down") or upright ("up").
"""

from itertools import product

from pendpin.doctor.systems.base import Formula, Quantities, Spec, Values
from pendpin.doctor.systems.tables import Table, table_spec

BODIES = {"any": "any rigid body", "point": "a point mass on a string or massless rod", "uniform": "a uniform rod"}

_PLANE = """
theta | 1 | theta q q_1 theta_1
m | kg | m m_1 M
g | m/s2 | g
l | m | l L ell l_1 L_1 R r
h | m | h d a b s r l_c l_cm h_G r_G r_cm l_1 L l ell R h_cm l_G d_cm
J | kg m2 | J I J_O I_O J_1 I_1 J_A I_A I_P J_P I_0 J_0 J_o I_o
I | kg m2 | I I_G I_C I_cm J_G J_C I_CM J_cm J_S I_S
x | m | x x_G x_C x_cm x_1
y | m | y y_G y_C y_cm y_1 z h_y
vx | m/s | v_x
vy | m/s | v_y v_z
v | m/s | v v_G v_cm
omega | 1/s | omega Omega w
alpha | 1/s | alpha
w0 | 1/s | omega omega_0 omega_n Omega
T | N m | T K E_k T_1 E_kin KE
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
g | m/s2 | g
l1 | m | l_1 L_1 l L ell ell_1 a_1 a R_1 r_1
l2 | m | l_2 L_2 l L ell ell_2 a_2 b R_2 r_2
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
T | N m | T K E_k KE
V | N m | V U E_p PE
L | N m | L
E | N m | E H
p1 | N m s | p_1 p_theta1 p_theta_1 p_theta,1
p2 | N m s | p_2 p_theta2 p_theta_2 p_theta,2
M11 | kg m2 | M_11 m_11 H_11 d_11 B_11 D_11
M12 | kg m2 | M_12 m_12 H_12 d_12 M_21 m_21 B_12 D_12 D_21
M22 | kg m2 | M_22 m_22 H_22 d_22 B_22 D_22
tau1 | N m | tau_1 Q_1
tau2 | N m | tau_2 tau u Q_2
"""

_CART = """
x | m | x q_1 s q z p
theta | 1 | theta phi alpha q_2 varphi psi
M | kg | M m_c m_1 M_c m_C M_1 m_cart m_0
m | kg | m m_p m_2 m_P m_1 m_pole M_p
g | m/s2 | g
l | m | l L ell l_1
h | m | l L ell h d l_1 a l_c b
I | kg m2 | I J I_G I_1 J_1
J | kg m2 | J I I_O J_O
xp | m | x_p x_2 x_m x_1 x_G
yp | m | y_p y_2 y_m y y_1 y_G
T | N m | T K E_k KE
V | N m | V U E_p PE
L | N m | L
E | N m | E H
px | N m s | p_x p_1
ptheta | N m s | p_theta p_2
F | N | F u f f_x Q_x Q_1
N | N | N H N_x
P | N | P V N_y
"""

_POLAR = """
theta | 1 | theta
phi | 1 | phi
m | kg | m M
g | m/s2 | g
l | m | l L R r ell a
h | m | h l L R r ell a d
J | kg m2 | J I J_1 I_1
x | m | x
y | m | y
z | m | z
v | m/s | v
T | N m | T K E_k
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


def _energies(table: dict[str, Formula]) -> dict[str, Formula]:
    return table | {"L": lambda q: q["T"] - q["V"], "E": lambda q: q["T"] + q["V"]}


def _partial(of: str, by: str) -> Formula:
    return lambda q: q.derivative(lambda there: there[of], by)


def _plane(body: str, up: bool) -> Spec:
    sign = -1 if up else 1  # of the weight's moment
    s, c = (lambda q: q.xp.sin(q["theta"])), (lambda q: q.xp.cos(q["theta"]))

    def solve(q: Quantities) -> dict[str, Values]:
        return {"ddtheta": -sign * q["m"] * q["g"] * q["h"] * s(q) / q["J"]}

    formulas = _energies(
        {
            **_body(body, "m", "l", "h", "I"),
            "J": lambda q: q["I"] + q["m"] * q["h"] ** 2,
            "x": lambda q: q["h"] * s(q),
            "y": lambda q: -sign * q["h"] * c(q),
            "vx": lambda q: q["h"] * c(q) * q["dtheta"],
            "vy": lambda q: sign * q["h"] * s(q) * q["dtheta"],
            "v": lambda q: q["h"] * q["dtheta"],
            "omega": lambda q: q["dtheta"] + q.number(0),
            "alpha": lambda q: q["ddtheta"] + q.number(0),
            "w0": lambda q: q.xp.sqrt(q["m"] * q["g"] * q["h"] / q["J"]),
            "period": lambda q: q.number(2) * q.xp.pi / q["w0"],
            "T": lambda q: q["J"] * q["dtheta"] ** 2 / q.number(2),
            "V": lambda q: -sign * q["m"] * q["g"] * q["h"] * c(q),
            "p": lambda q: q["J"] * q["dtheta"],
            "S": lambda q: q["m"] * (q["h"] * q["dtheta"] ** 2 + sign * q["g"] * c(q)),
            "Rt": lambda q: q["m"] * (q["h"] * q["ddtheta"] + sign * q["g"] * s(q)),
            "Rx": lambda q: q["m"] * q["h"] * (c(q) * q["ddtheta"] - s(q) * q["dtheta"] ** 2),
            "Ry": lambda q: q["m"] * (q["g"] + sign * q["h"] * (s(q) * q["ddtheta"] + c(q) * q["dtheta"] ** 2)),
            "W": lambda q: q["m"] * q["g"],
        }
    )
    parameters = ("m", "g", "l", *(("h", "I") if body == "any" else ()))
    where = "its angle from upright" if up else "its angle from the vertical"
    title = f"a pendulum in a plane, {BODIES[body]}, in {where}"
    kind = f"plane {body}{' up' if up else ''}"
    extra = ("h", "I", "J") if body == "any" else ("h",)
    return table_spec(
        kind,
        title,
        Table(_PLANE),
        ("theta",),
        parameters,
        ("ddtheta",),
        formulas,
        solve,
        (),
        (*extra, "omega", "v", "x"),
    )


def _two(body: str, relative: bool, equal: bool, up: bool, drive: str = "") -> Spec:
    sign = -1 if up else 1

    def angles(q: Quantities) -> tuple[Values, Values, Values, Values]:
        """The absolute angles and their rates."""
        first, second = q["theta1"], q["theta2"]
        rates = q["dtheta1"], q["dtheta2"]
        return (first, first + second, rates[0], sum(rates)) if relative else (first, second, *rates)  # type: ignore[return-value]

    def inertias(q: Quantities) -> tuple[Values, Values, Values]:
        first = q["I1"] + q["m1"] * q["h1"] ** 2 + q["m2"] * q["l1"] ** 2
        return first, q["m2"] * q["l1"] * q["h2"], q["I2"] + q["m2"] * q["h2"] ** 2

    def solve(q: Quantities) -> dict[str, Values]:
        a, b, da, db = angles(q)
        first, mixed, second = inertias(q)
        c, s = q.xp.cos(a - b), q.xp.sin(a - b)
        weight = sign * q["g"]
        right = [-mixed * s * db**2 - (q["m1"] * q["h1"] + q["m2"] * q["l1"]) * weight * q.xp.sin(a)]
        right += [mixed * s * da**2 - q["m2"] * q["h2"] * weight * q.xp.sin(b)]
        if drive == "acrobot":
            right = [right[0] - q["tau2"], right[1] + q["tau2"]]
        if drive == "both":
            right = [right[0] + q["tau1"] - q["tau2"], right[1] + q["tau2"]]
        det = first * second - (mixed * c) ** 2
        dda = (second * right[0] - mixed * c * right[1]) / det
        ddb = (first * right[1] - mixed * c * right[0]) / det
        return {"ddtheta1": dda, "ddtheta2": ddb - dda if relative else ddb}

    def kinetic(q: Quantities) -> Values:
        a, b, da, db = angles(q)
        first, mixed, second = inertias(q)
        return (first * da**2 + second * db**2) / q.number(2) + mixed * q.xp.cos(a - b) * da * db

    def potential(q: Quantities) -> Values:
        a, b, *_ = angles(q)
        first = (q["m1"] * q["h1"] + q["m2"] * q["l1"]) * q.xp.cos(a)
        return -sign * q["g"] * (first + q["m2"] * q["h2"] * q.xp.cos(b))

    def matrix(i: int, j: int) -> Formula:
        def value(q: Quantities) -> Values:
            a, b, *_ = angles(q)
            first, mixed, second = inertias(q)
            off = mixed * q.xp.cos(a - b)
            absolute = {(1, 1): first, (1, 2): off, (2, 2): second}
            if not relative or (i, j) == (2, 2):
                return absolute[i, j] + q.number(0)
            return first + q.number(2) * off + second if (i, j) == (1, 1) else second + off

        return value

    def place(i: int, name: str, end: str) -> Formula:
        def value(q: Quantities) -> Values:
            a, b, *_ = angles(q)
            xp, length = q.xp, q["h1" if end == "h" else "l1"]
            turn = xp.sin if name == "x" else xp.cos
            factor = 1 if name == "x" else -sign
            if i == 1:
                return factor * length * turn(a)
            return factor * (q["l1"] * turn(a) + q["h2" if end == "h" else "l2"] * turn(b))

        return value

    formulas = _energies(
        {
            **_body(body, "m1", "l1", "h1", "I1"),
            **_body(body, "m2", "l2", "h2", "I2"),
            **{f"J{i}": (lambda q, i=i: q[f"I{i}"] + q[f"m{i}"] * q[f"h{i}"] ** 2) for i in (1, 2)},
            **{f"{n}{i}": place(i, n, "h") for n in "xy" for i in (1, 2)},
            **{f"{n}p{i}": place(i, n, "l") for n in "xy" for i in (1, 2)},
            "T": kinetic,
            "V": potential,
            "p1": _partial("T", "dtheta1"),
            "p2": _partial("T", "dtheta2"),
            "M11": matrix(1, 1),
            "M12": matrix(1, 2),
            "M22": matrix(2, 2),
        }
    )
    loads = {"acrobot": ("tau2",), "both": ("tau1", "tau2"), "": ()}[drive]
    formulas |= {name: (lambda q: q.number(0)) for name in ("tau1", "tau2") if name not in loads}
    parameters = ("m1", "m2", "g", "l1", "l2", *(("h1", "h2", "I1", "I2") if body == "any" else ()))
    if equal:
        pairs = [(name, name[:-1] + "1") for name in parameters if name.endswith("2")]
        formulas |= {name: (lambda q, other=other: q[other] + q.number(0)) for name, other in pairs}
        parameters = tuple(name for name in parameters if not name.endswith("2"))
    kinds = {"point": "point masses", "uniform": "uniform rods", "any": "rigid bodies"}[body]
    which = "relative" if relative else "absolute"
    where = "upright" if up else "the vertical"
    title = f"a double pendulum in a plane of {'equal ' * equal}{kinds}, in {which} angles from {where}"
    driven = {"acrobot": ", with a torque at the second joint", "both": ", with torques at both joints", "": ""}[drive]
    sums = ("sin theta1-theta2", "cos theta1-theta2") if not relative else ("sin theta1+theta2", "cos theta1+theta2")
    kind = f"double {body} {which}{' equal' * equal}{' up' * up}{f' {drive}' if drive else ''}"
    return table_spec(
        kind,
        title + driven,
        Table(_TWO),
        ("theta1", "theta2"),
        (*parameters, *loads),
        ("ddtheta1", "ddtheta2"),
        formulas,
        solve,
        sums,
    )


def _cart(body: str, up: bool, mirrored: bool) -> Spec:
    sign, side = (-1 if up else 1), (-1 if mirrored else 1)

    def solve(q: Quantities) -> dict[str, Values]:
        s, c = q.xp.sin(q["theta"]), q.xp.cos(q["theta"])
        mh, total = q["m"] * q["h"], q["M"] + q["m"]
        push = q["F"] + side * mh * s * q["dtheta"] ** 2
        fall = -sign * mh * q["g"] * s
        det = total * q["J"] - (mh * c) ** 2
        ddx = (q["J"] * push - side * mh * c * fall) / det
        return {"ddx": ddx, "ddtheta": (total * fall - side * mh * c * push) / det}

    def kinetic(q: Quantities) -> Values:
        c, dx, dtheta = q.xp.cos(q["theta"]), q["dx"], q["dtheta"]
        square = (q["M"] + q["m"]) * dx**2 + q["J"] * dtheta**2
        return square / q.number(2) + side * q["m"] * q["h"] * c * dx * dtheta

    formulas = _energies(
        {
            **_body(body, "m", "l", "h", "I"),
            "J": lambda q: q["I"] + q["m"] * q["h"] ** 2,
            "xp": lambda q: q["x"] + side * q["h"] * q.xp.sin(q["theta"]),
            "yp": lambda q: -sign * q["h"] * q.xp.cos(q["theta"]),
            "T": kinetic,
            "V": lambda q: -sign * q["m"] * q["g"] * q["h"] * q.xp.cos(q["theta"]),
            "px": _partial("T", "dx"),
            "ptheta": _partial("T", "dtheta"),
            "N": lambda q: q["m"] * q.derivative(lambda there: there["dxp"], "t"),
            "P": lambda q: q["m"] * (q["g"] + q.derivative(lambda there: there["dyp"], "t")),
        }
    )
    parameters = ("M", "m", "g", "l", *(("h", "I") if body == "any" else ()), "F")
    where = "upright" if up else "the vertical"
    title = f"a pendulum on a cart, {BODIES[body]}, its angle from {where}{', positive the other way' * mirrored}"
    kind = f"cart-pole {body}{' up' * up}{' mirrored' * mirrored}"
    return table_spec(
        kind, title, Table(_CART), ("x", "theta"), parameters, ("ddx", "ddtheta"), formulas, solve, (), ("J", "I", "F")
    )


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

    formulas = _energies(
        {
            **{name: f for name, f in _body(body, "m", "l", "h", "J").items() if name == "h"},
            **(
                {"J": lambda q: q["m"] * q["l"] ** 2 / q.number(3 if body == "uniform" else 1)} if body != "any" else {}
            ),
            "x": lambda q: q["h"] * q.xp.sin(q["theta"]) * q.xp.cos(q["phi"]),
            "y": lambda q: q["h"] * q.xp.sin(q["theta"]) * q.xp.sin(q["phi"]),
            "z": lambda q: -sign * q["h"] * q.xp.cos(q["theta"]),
            "v": lambda q: q["h"] * q.xp.sqrt(square(q)),
            "T": lambda q: q["J"] * square(q) / q.number(2),
            "V": lambda q: -sign * q["m"] * q["g"] * q["h"] * q.xp.cos(q["theta"]),
            "p": lambda q: q["J"] * q["dphi"] * q.xp.sin(q["theta"]) ** 2,
            "ptheta": lambda q: q["J"] * q["dtheta"],
            "S": lambda q: q["m"] * (q["h"] * square(q) + sign * q["g"] * q.xp.cos(q["theta"])),
        }
    )
    parameters = ("m", "g", "l", *(("h", "J") if body == "any" else ()))
    where = "upwards" if up else "downwards"
    title = f"a spherical pendulum, {BODIES[body]}: theta is the polar angle from {where} and phi the azimuth"
    kind = f"polar {body}{' up' * up}"
    return table_spec(
        kind, title, Table(_POLAR), ("theta", "phi"), parameters, ("ddtheta", "ddphi"), formulas, solve, (), ("J", "p")
    )


_FLAGS = (False, True)
PLANE = [_plane(body, up) for body, up in product(BODIES, _FLAGS)]
TWO = [_two(body, a, b, c) for body, a, b, c in product(BODIES, _FLAGS, _FLAGS, _FLAGS)]
ACROBOT = [_two(body, True, False, False, drive) for body, drive in product(BODIES, ("acrobot", "both"))]
CART = [_cart(body, up, mirrored) for body, up, mirrored in product(BODIES, _FLAGS, _FLAGS)]
POLAR = [_polar(body, up) for body, up in product(BODIES, _FLAGS)]
FAMILIES = {"plane": PLANE, "polar": POLAR, "cart-pole": CART, "double": TWO, "acrobot": ACROBOT}
