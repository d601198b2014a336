"""Systems with an azimuth: a spherical pendulum, and a pendulum on an arm that turns about the vertical (Furuta's).

As planar.py: each is one table of quantities, their units, how they are written, and their formulas.
"""

from itertools import product

from pendpin.doctor.systems.base import Spec, formula
from pendpin.doctor.systems.tables import BODIES, OTHER_WAY, POSES, body_spec

# of the azimuth, for a spherical pendulum that keeps its polar angle
conical_rate = formula("sqrt(m*g*h/J/cos(theta))")

_POLAR = """
theta | 1 | theta
phi | 1 | phi
m | kg | m M
l | m | l L R r ell a
h | m | h l L R r ell a d
J | kg m2 | J I J_1 I_1
rG | m | *r *r_G *x *R | vector(x, y, z)
x | m | x | h*sin(theta)*cos(phi)
y | m | y | h*sin(theta)*sin(phi)
z | m | z | h*high(theta)
v | m/s | v | h*sqrt(square_)
T | N m | T K E_k E_c | J*square_/2
V | N m | V U E_p | m*g*z
p | N m s | p_phi L_z l_z J_z J h_z p L_0 h ell | J*dphi*sin(theta)**2
ptheta | N m s | p_theta | J*dtheta
S | N | T S N F_T F R_3 | m*(h*square_ - g*high(theta))
square_ | - | | dtheta**2 + (dphi*sin(theta))**2
mass | - | | vector(vector(J, 0), vector(0, J*sin(theta)**2))
force_ | - | | vector(J*dphi**2*sin(theta)*cos(theta) - m*g*h*rise(theta), -2*J*dtheta*dphi*sin(theta)*cos(theta))
ex | 1 | *e_x *i *x *u_x | vector(1, 0, 0)
ey | 1 | *e_y *j *y *u_y | vector(0, 1, 0)
ez | 1 | *e_z *k *z *u_z | vector(0, 0, 1)
er | 1 | *e_r *e_rho *u_r | vector(sin(theta)*cos(phi), sin(theta)*sin(phi), high(theta))
et | 1 | *e_theta *u_theta | vector(cos(theta)*cos(phi), cos(theta)*sin(phi), rise(theta))
ep | 1 | *e_phi *u_phi | vector(-sin(phi), cos(phi), 0*phi)
at | m/s2 | a_theta | h*(ddtheta - dphi**2*sin(theta)*cos(theta))
ap | m/s2 | a_phi | h*(ddphi*sin(theta) + 2*dtheta*dphi*cos(theta))
W | N | | vector(0, 0, -m*g)
"""

_FURUTA = """
theta | 1 | theta
phi | 1 | phi
m | kg | m m_p M_p m_2 m_1
b | m | L L_r l_1 r R L_1 L_a l_a l_0 L_0 l_r l_arm
l | m | L_p l_2 l L_2 l_p L_1 l_1 l_pend
h | m | l_p l h l_2 l_c2 L_2 L_p l_c l_1 d
J0 | kg m2 | J_r I_0 +J_1 I_1 J_a I_a J J_arm J_b I_b I_r +J_0
Jt | kg m2 | +J_0 J_t J_T alpha | J0 + m*b*b
I | kg m2 | J_p I J_2 I_2 I_p J J_1 I_1 I_G
J | kg m2 | +J_2 J I J_p I_2 I_p J_1 I_1 | m*h*h + I
x | m | x x_p x_2 x_G | b*cos(theta) - side_*h*across(phi)*sin(theta)
y | m | y y_p y_2 y_G | b*sin(theta) + side_*h*across(phi)*cos(theta)
z | m | z z_p z_2 z_G | h*high(phi)
rG | m | *r *r_p *r_G *r_2 | vector(x, y, z)
rA | m | *r_h *r_A *r_1 *r_a | b*er
ex | 1 | *e_x *i *x *u_x | vector(1, 0, 0)
ey | 1 | *e_y *j *y *u_y | vector(0, 1, 0)
ez | 1 | *e_z *k *z *u_z | vector(0, 0, 1)
er | 1 | *e_r *e_rho *u_r | vector(cos(theta), sin(theta), 0)
et | 1 | *e_theta *e_t *u_t *u_theta | vector(-sin(theta), cos(theta), 0)
v | m/s | v v_p v_G v_2 | sqrt(square_)
square_ | - | | ((b*b + (h*sin(phi))**2)*dtheta + 2*b_/m*dphi)*dtheta + (h*dphi)**2
Ta | N m | T_arm T_a T_1 T_r K_1 K_a | J0*dtheta**2/2
Tp | N m | T_p T_2 K_2 K_p | T - Ta
Tv | N m | T_trans T_t T_v | m*square_/2
Tw | N m | T_rot T_w T_omega | I*(dphi**2 + (sin(phi)*dtheta)**2)/2
T | N m | T K E_k | (ptheta*dtheta + pphi*dphi)/2
V | N m | V U E_p | m*g*z
ptheta | N m s | p_theta p_1 p_alpha p_phi | M11*dtheta + b_*dphi
pphi | N m s | p_phi p_2 p_alpha p_theta | b_*dtheta + J*dphi
tau1 | N m | tau u tau_1 Q_1 T F M tau_m
M11 | kg m2 | M_11 m_11 D_11 | J0 + m*b*b + J*sin(phi)**2
M12 | kg m2 | M_12 M_21 m_12 m_21 D_12 D_21 | b_
M22 | kg m2 | M_22 m_22 D_22 | J
G2 | N m | G_2 g_2 | g*(m*h)*rise(phi)
mass | - | *M *H *D | vector(vector(M11, b_), vector(b_, J))
weight | - | *G *g | vector(0, G2)
turned | - | *C *c *h | vector(J*sin(2*phi)*dtheta*dphi - s_*dphi**2, -J*sin(2*phi)/2*dtheta**2)
load | - | *Q *F *tau *u tau | vector(tau1, 0)
force_ | - | | load - turned - weight
q | - | q *q *theta | vector(theta, phi)
b_ | - | | side_*(m*b*h)*cos(phi)
s_ | - | | side_*(m*b*h)*sin(phi)
"""


def _polar(body: str, up: bool) -> Spec:
    pose, where = ("up", "upwards") if up else ("down", "downwards")
    title = f"a spherical pendulum, {BODIES[body][0]}: theta is the polar angle from {where} and phi the azimuth"
    others = {"kind": f"polar {body}{' up' * up}", "title": title, "extra": ("J", "p")}
    more = {} if body == "any" else {"J": "I + m*h**2"}
    return body_spec(_POLAR, "theta phi", "m g l h J", body, pose, more, " ", **others)


def _furuta(body: str, pose: str, mirrored: bool) -> Spec:
    title = f"a pendulum on an arm that turns (Furuta's), {BODIES[body][0]}, theta the arm's angle and phi its own, "
    title += f"from {POSES[pose][0]}{OTHER_WAY * mirrored}"
    others = {"kind": f"furuta {body} {pose}{' mirrored' * mirrored}", "title": title, "extra": ("J", "I")}
    more = {"side_": "-1" if mirrored else "1"}
    return body_spec(_FURUTA, "theta phi", "m g l b J0 * tau1", body, pose, more, " ", **others)


_FLAGS, _SINGLE = (False, True), ("any", "point", "uniform")
AZIMUTHAL = {
    "polar": [_polar(body, up) for body, up in product(_SINGLE, _FLAGS)],
    "furuta": [_furuta(*three) for three in product(_SINGLE, ("down", "up"), _FLAGS)],
}
