"""Systems in a vertical plane: one to three pendulums, a pivot that moves, a spring, a cart.

Each system is one table: a quantity's name, unit, how it is written, and its formula (tables.py). turns_ is 1 where the
second of two angles is measured from the first link, side_ the sign of an angle against the direction in which a cart moves,
over_ and lift_ are where a pivot is that moves, and reach_ is how long a spring is.
"""

from itertools import product

from pendpin.doctor.systems.azimuth import AZIMUTHAL
from pendpin.doctor.systems.base import Spec
from pendpin.doctor.systems.tables import BODIES, OTHER_WAY, POSES, body_spec

WAVES = {  # how a pivot moves, and how fast
    "0*t": "0*t",
    "a*cos(nu*t)": "-a*nu*sin(nu*t)",
    "-a*cos(nu*t)": "a*nu*sin(nu*t)",
    "a*sin(nu*t)": "a*nu*cos(nu*t)",
    "-a*sin(nu*t)": "-a*nu*cos(nu*t)",
}
AMPLITUDE = 1.3  # rad: where a pendulum is released in equations with that angle

_PLANE = """
theta | 1 | theta q q_1 theta_1
m | kg | m m_1 M m_p m_bob m_pend m_rod
l | m | l L ell l_1 L_1 R r l_p l_pend l_rod
h | m | h d a b s r l_c l_cm h_G r_G r_cm l_1 L l ell R h_cm l_G d_cm
k | m | k k_G i_G rho rho_G k_0 | sqrt(I/m)
kO | m | k k_O i_O rho_O k_0 | sqrt(J/m)
theta0 | 1 | theta_0 theta_m theta_max phi_0 varphi_0 alpha_0 theta_i alpha phi_m varphi_m
J | kg m2 | J I J_O I_O J_1 I_1 J_A I_A I_P J_P I_0 J_0 Theta I_pivot moi J_Oz I_Oz J_Delta I_Delta | m*h*h + I
I | kg m2 | I I_G I_C I_cm I_com J_G J_C J_cm J_S I_S Theta_S
rG | m | *r *r_G *x *R | vector(x, y)
x | m | x x_G x_C x_cm x_1 | h*across(theta)
y | m | y y_G y_C y_cm y_1 z h_y | h*high(theta)
vx | m/s | v_x | dx
vy | m/s | v_y v_z | dy
v | m/s | v v_G v_cm | h*dtheta
omega | 1/s | omega Omega w velocity vel | dtheta
alpha | 1/s2 | alpha acc | ddtheta
w0 | 1/s | omega omega_0 omega_n Omega w w_0 w_n | sqrt(m*g*h/J)
T | N m | T K E_k E_c T_1 E_kin | J*dtheta*dtheta/2
V | N m | V U E_p E_pot PE Pi pe | g*(m*h*high(theta))
E | N m | E H E_0 H_0 | T + V
p | N m s | p p_theta L_O H_O L p_1 p_q | J*dtheta
S | N | T S F_T N R_n F_r F_n R_r R_3 F T_s | m*(h*dtheta**2 - g*high(theta))
Rx | N | R_x O_x A_x F_x H N_x X | m*h*(cos(theta)*ddtheta - sin(theta)*dtheta**2)
Ry | N | R_y O_y A_y F_y V N_y Y | m*(g + h*(rise(theta)*ddtheta - high(theta)*dtheta**2))
Rt | N | R_t F_t O_t R_1 N_t | m*(h*ddtheta + g*rise(theta))
W | N | W F_g G | m*g
mass | - | | vector(vector(J))
force_ | - | | vector(-g*(m*h)*rise(theta))
torque | N m | tau M_O tau_g M N tau_O | -m*g*h*rise(theta)
period | s | T T_0 tau P | 2*pi/w0
lr | m | l_r l_red L_r L_red l_eq L_eq ell_r | J/(m*h)
"""

_MOVED = """
theta | 1 | theta phi q alpha theta_1
t | s | t
m | kg | m M m_1
l | m | l L ell R r l_1 b
a | m | a A b d X_0 Y_0 A_0 a_0 y_0 x_0 z_0 h_0 r R delta epsilon Y X
nu | 1/s | omega Omega w nu gamma omega_d Omega_d omega_0 W omega_f
x0 | m | x_0 x_p x_s x_P x_O X x_pivot x_z | over_
y0 | m | y_0 y_p y_s y_P y_O Y y_pivot h z_0 s y_z z | lift_
dx0 | m/s | | overs_
dy0 | m/s | | lifts_
x | m | x x_1 x_m x_G x_b x_bob x_M x_2 | x0 + l*across(theta)
y | m | y y_1 y_m y_G y_b y_bob y_M z y_2 | y0 + l*high(theta)
vx | m/s | v_x | dx0 + l*cos(theta)*dtheta
vy | m/s | v_y v_z | dy0 + l*rise(theta)*dtheta
v | m/s | v | sqrt(vx**2 + vy**2)
omega | 1/s | omega w | dtheta
alpha | 1/s2 | alpha acc | ddtheta
w0 | 1/s | omega_0 w_0 omega | sqrt(g/l)
T | N m | T K E_k E_c E_kin E_K | m*(vx**2 + vy**2)/2
V | N m | V U E_p E_pot E_P | m*g*y
p | N m s | p p_theta p_phi | m*l*(l*dtheta + cos(theta)*dx0 + rise(theta)*dy0)
mass | - | | vector(vector(m*l**2))
force_ | - | | vector(m*l*(nu**2*(cos(theta)*x0 + rise(theta)*y0) - g*rise(theta)))
"""

_ELASTIC = """
s | m | s
theta | 1 | theta
m | kg | m M
kappa | N/m | k K k_s c kappa
l0 | m | l_0 L_0 r_0 ell_0 l ell L a R s_0 x_0 b
le | m | L l_1 l_e l_eq L_eq r_0 r_eq R_0 l_0 | l0 + m*g/kappa
x | m | x x_1 X | reach_*across(theta)
y | m | y y_1 z Y | reach_*high(theta)
rG | m | *r *r_G *x *R | vector(x, y)
v | m/s | v | sqrt(ds**2 + (reach_*dtheta)**2)
T | N m | T K E_k E_c E_kin | m*(ds**2 + (reach_*dtheta)**2)/2
V | N m | V U E_p E_pot | Vg + Vs
Vg | N m | V_g U_g E_g E_pg | m*g*reach_*high(theta)
Vs | N m | V_s V_e U_s U_e U_k V_k E_s E_e E_el | kappa*(reach_ - l0)**2/2
S | N | F_s F T F_e F_k | kappa*(reach_ - l0)
ps | N m s | p_r p_x p_l p_s p_1 | m*ds
p | N m s | p_theta p_2 L | m*reach_**2*dtheta
mass | - | *M | vector(vector(m, 0), vector(0, m*reach_**2))
force_ | - | | vector(m*reach_*dtheta**2 - m*g*high(theta) - S, -m*reach_*(g*rise(theta) + 2*ds*dtheta))
"""

_THREE = """
theta{i} | 1 | theta_{i} q_{i} alpha_{i} phi_{i} varphi_{i}
m{i} | kg | m_{i} M_{i} m
l{i} | m | l_{i} L_{i} ell_{i} a_{i} r_{i} R_{i} d_{i} l L
x1 | m | x_1 | l1*across(theta1)
y1 | m | y_1 z_1 | l1*high(theta1)
x2 | m | x_2 | x1 + l2*across(theta2)
y2 | m | y_2 z_2 | y1 + l2*high(theta2)
x3 | m | x_3 | x2 + l3*across(theta3)
y3 | m | y_3 z_3 | y2 + l3*high(theta3)
w{i} | 1/s | omega_{i} w_{i} | dtheta{i}
alpha{i} | 1/s2 | alpha_{i} acc_{i} | ddtheta{i}
T{i} | N m | T_{i} K_{i} E_k{i} | m{i}*(dx{i}**2 + dy{i}**2)/2
V{i} | N m | V_{i} U_{i} E_p{i} | m{i}*g*y{i}
T | N m | T K E_k | (p1*dtheta1 + p2*dtheta2 + p3*dtheta3)/2
V | N m | V U E_p | V1 + V2 + V3
p1 | N m s | p_1 p_theta1 | M11*dtheta1 + M12*dtheta2 + M13*dtheta3
p2 | N m s | p_2 p_theta2 | M12*dtheta1 + M22*dtheta2 + M23*dtheta3
p3 | N m s | p_3 p_theta3 | M13*dtheta1 + M23*dtheta2 + M33*dtheta3
M11 | kg m2 | M_11 m_11 | (m1 + m2 + m3)*l1*l1
M12 | kg m2 | M_12 M_21 m_12 m_21 | (m2 + m3)*l1*l2*cos(theta1 - theta2)
M13 | kg m2 | M_13 M_31 m_13 m_31 | m3*l1*l3*cos(theta1 - theta3)
M22 | kg m2 | M_22 m_22 | (m2 + m3)*l2*l2
M23 | kg m2 | M_23 M_32 m_23 m_32 | m3*l2*l3*cos(theta2 - theta3)
M33 | kg m2 | M_33 m_33 | m3*l3*l3
mass | kg m2 | *M *H *D *A | vector(vector(M11, M12, M13), vector(M12, M22, M23), vector(M13, M23, M33))
weight | N m | *G *g | g*vector((m1 + m2 + m3)*l1*rise(theta1), (m2 + m3)*l2*rise(theta2), m3*l3*rise(theta3))
a_ | - | | (m2 + m3)*l1*l2*sin(theta1 - theta2)
b_ | - | | m3*l1*l3*sin(theta1 - theta3)
c_ | - | | m3*l2*l3*sin(theta2 - theta3)
turned | N m | *C *c *h | vector(a_*w2**2 + b_*w3**2, c_*w3**2 - a_*w1**2, -b_*w1**2 - c_*w2**2)
force_ | - | | -turned - weight
q | 1 | q *q *theta | vector(theta1, theta2, theta3)
"""

_TWO = """
theta1 | 1 | theta_1 q_1 alpha_1 phi_1 varphi_1
theta2 | 1 | theta_2 q_2 alpha_2 phi_2 varphi_2
lead | - | Deltatheta Deltaphi Deltaalpha | theta1 - second_
lag | - | Deltatheta Deltaphi Deltaalpha | second_ - theta1
m{n} | kg | m_{n} M_{n} m
l1 | m | l_1 L_1 l L ell ell_1 a_1 a R_1 r_1 d_1 r R
l2 | m | l_2 L_2 l L ell ell_2 a_2 b R_2 r_2 d_2 r R
h{n} | m | h_{n} l_c{n} r_{n} d_{n} s_{n} l_cm{n} l_g{n} a_{n} c_{n} l_{n} h
I{n} | kg m2 | I_{n} J_{n} I_c{n} I_G{n} I J
J{n} | kg m2 | J_{n} I_{n} I_O{n} | I{n} + m{n}*h{n}**2
x1 | m | x_1 | h1*across(theta1)
y1 | m | y_1 z_1 | h1*high(theta1)
x2 | m | x_2 | l1*across(theta1) + h2*across(second_)
y2 | m | y_2 z_2 | l1*high(theta1) + h2*high(second_)
r{n} | m | *r_{n} *R_{n} *x_{n} | vector(x{n}, y{n})
xp1 | m | x_1 | l1*across(theta1)
yp1 | m | y_1 z_1 | l1*high(theta1)
xp2 | m | x_2 | l1*across(theta1) + l2*across(second_)
yp2 | m | y_2 z_2 | l1*high(theta1) + l2*high(second_)
T | N m | T K E_k E_c | (p1*dtheta1 + p2*dtheta2)/2
V | N m | V U E_p | g*((m1*h1 + m2*l1)*high(theta1) + m2*h2*high(second_))
T1 | N m | T_1 K_1 E_k1 | (m1*(dx1**2 + dy1**2) + I1*dtheta1**2)/2
T2 | N m | T_2 K_2 E_k2 | (m2*(dx2**2 + dy2**2) + I2*turning_**2)/2
V{n} | N m | V_{n} U_{n} E_p{n} | m{n}*g*y{n}
S1 | N | T_1 S_1 F_1 N_1 | -m1*(ddx1*(x1/h1) + (ddy1 + g)*(y1/h1)) - m2*(ddx2*(x1/h1) + (ddy2 + g)*(y1/h1))
S2 | N | T_2 S_2 F_2 N_2 | -m2*(ddx2*((x2 - xp1)/h2) + (ddy2 + g)*((y2 - yp1)/h2))
p{n} | N m s | p_{n} p_theta{n} P_{n} p_q{n} p_phi{n} | M1{n}*dtheta1 + M{n}2*dtheta2
M11 | kg m2 | M_11 m_11 H_11 d_11 B_11 D_11 | a_ + turns_*(b_ + b_ + d_)
M12 | kg m2 | M_12 m_12 H_12 d_12 M_21 m_21 B_12 D_12 D_21 | b_ + turns_*d_
M22 | kg m2 | M_22 m_22 H_22 d_22 B_22 D_22 | d_
C11 | N m s | C_11 c_11 h_11 V_11 | turns_*s_*dtheta2
C22 | - | C_22 c_22 h_22 V_22 | 0*s_
C12 | N m s | C_12 c_12 h_12 V_12 | s_*turning_
C21 | N m s | C_21 c_21 h_21 V_21 | -s_*dtheta1
D11 | N m s | C_11 c_11 h_11 V_11 | 2*C11
D12 | N m s | C_12 c_12 h_12 V_12 | s_*dtheta2
C1 | N m | | C11*dtheta1 + C12*dtheta2
C2 | N m | | C21*dtheta1
G1 | N m | G_1 g_1 phi_1 Phi_1 N_1 | g*((m1*h1 + m2*l1)*rise(theta1) + turns_*m2*h2*rise(second_))
G2 | N m | G_2 g_2 phi_2 Phi_2 N_2 | g*(m2*h2*rise(second_))
tau1 | N m | tau_1 Q_1
tau2 | N m | tau_2 tau u Q_2
v1 | m/s | v_1 | h1*dtheta1
v2 | m/s | v_2 | sqrt(dx2**2 + dy2**2)
alpha{n} | 1/s2 | alpha_{n} acc_{n} | ddtheta{n}
w{n} | 1/s | omega_{n} w_{n} velocity_{n} vel_{n} angular_velocity_{n} | dtheta{n}
tau | N m | *tau *Q *u *f tau | vector(tau1, tau2)
q | 1 | q *q *theta theta Theta *Theta | vector(theta1, theta2)
mass | kg m2 | *M *H *D *B | vector(vector(M11, M12), vector(M12, M22))
turn | N m s | *C *c *h *H *V | vector(vector(C11, C12), vector(C21, 0))
turn2 | N m s | *C *c *h *H *V | vector(vector(D11, D12), vector(C21, 0))
turned | N m | *C *c *h *H | vector(C1, C2)
weight | N m | *G *g *Phi *phi *tau_g | vector(G1, G2)
pull | N m | *tau_g *G | vector(-G1, -G2)
B | - | *B *b | vector(0, 1)
second_ | - | | turns_*theta1 + theta2
turning_ | - | | turns_*dtheta1 + dtheta2
s_ | - | | m2*l1*h2*sin(theta1 - second_)
a_ | - | | m1*h1*h1 + m2*l1*l1 + I1
b_ | - | | m2*l1*h2*cos(theta1 - second_)
d_ | - | | m2*h2*h2 + I2
f_ | - | | -g*(m1*h1 + m2*l1)*rise(theta1) - s_*turning_**2
k_ | - | | -g*(m2*h2)*rise(second_) + s_*dtheta1**2
force_ | - | | vector(f_ + turns_*k_ + tau1, k_ + tau2)
"""

_CART = """
x | m | x X q_1 s q z p x_c x_1
theta | 1 | theta phi alpha q_2 varphi psi
M | kg | M m_c m_1 M_c M_1 m_cart m_0 M_cart m_w M_w m_k
m | kg | m m_p m_2 m_1 m_pole M_p m_pend M_pole M_pend m_b m_r m_rod m_bob
l | m | l L ell l_1 l_p L_p r R length l_pole l_pend l_rod
h | m | l L ell h d l_1 a l_c b l_p L_p l_cm l_G r R l_pole l_pend
I | kg m2 | I J I_G I_1 J_1 I_p J_p i_p I_cm I_c J_c I_pole I_pend I_rod I_com Theta
J | kg m2 | J I I_O J_O I_t J_t | m*h*h + I
xp | m | x_p x_2 x_m x_1 x_G X_m X_p | x + h*(side_*across(theta))
yp | m | y_p y_2 y_m y y_1 y_G Y_m Y_p | h*high(theta)
rp | m | *r_p *r_m *r_2 *r *x_p | vector(xp, yp)
T | N m | T K E_k E_c | (px*dx + ptheta*dtheta)/2
V | N m | V U E_p | g*(m*h*high(theta))
Tc | N m | T_c T_1 K_c K_1 T_M T_cart K_cart | M*dx**2/2
Tp | N m | T_p T_2 K_p K_2 T_m T_pole T_pend K_pole K_pend | T - Tc
omega | 1/s | omega w | dtheta
Vc | N m | V_c U_c V_1 U_1 V_M U_M | 0*V
Vp | N m | V_p U_p V_2 U_2 V_m U_m | V
S | N | S T R N F_T F_r | -(N*(xp - x) + P*yp)/h
Sc | N | S T R N F_T F_r | -S
M11 | kg | M_11 m_11 H_11 D_11 | M + m
M12 | kg m | M_12 M_21 m_12 m_21 H_12 H_21 D_12 | b_
M22 | kg m2 | M_22 m_22 H_22 D_22 | J
turn | - | *C *H | vector(vector(0, -side_*(m*h)*sin(theta)*dtheta), vector(0, 0))
turned | - | *C *c *h | vector(F - f_, 0)
q | - | q *q | vector(x, theta)
mass | - | *M *H *D | vector(vector(M + m, b_), vector(b_, J))
weight | - | *G *g *Phi | vector(0, -k_)
pull | - | *tau_g *G | vector(0, k_)
B | - | *B *b | vector(1, 0)
px | N m s | p_x p_1 | (M + m)*dx + b_*dtheta
ptheta | N m s | p_theta p_2 | b_*dx + J*dtheta
F | N | F u f f_x f_c F_x Q_x Q_1 U tau F_c F_1 force F_ext F_a
N | N | N H N_x | m*ddxp
P | N | P V N_y | m*(g + ddyp)
b_ | - | | side_*(m*h)*cos(theta)
f_ | - | | F + side_*(m*h)*sin(theta)*dtheta**2
k_ | - | | -g*(m*h)*rise(theta)
force_ | - | | vector(f_, k_)
"""

_CART_TWO = """
x | m | x q_1 q_0 s z x_c x_0
theta1 | 1 | theta_1 q_2 phi_1 alpha_1
theta2 | 1 | theta_2 q_3 phi_2 alpha_2
M | kg | M m_c M_c m_0 m_cart
m{n} | kg | m_{n} M_{n} m
l{n} | m | l_{n} L_{n} l L
h{n} | m | h_{n} l_c{n} r_{n} d_{n} a_{n} l_{n} L_{n} l L
I{n} | kg m2 | I_{n} J_{n} I J
x1 | m | x_1 | x + side_*(h1*across(theta1))
y1 | m | y_1 h_1 | h1*high(theta1)
x2 | m | x_2 | x + side_*(l1*across(theta1) + h2*across(theta2))
y2 | m | y_2 h_2 | l1*high(theta1) + h2*high(theta2)
vc | m/s | v_c v_0 v_M | dx
v1 | m/s | v_1 | sqrt(dx1**2 + dy1**2)
v2 | m/s | v_2 | sqrt(dx2**2 + dy2**2)
T | N m | T K E_k | (px*dx + p1*dtheta1 + p2*dtheta2)/2
T0 | N m | T_0 T_c T_M K_c K_0 | M*dx**2/2
T1 | N m | T_1 K_1 | (m1*(dx1**2 + dy1**2) + I1*dtheta1**2)/2
T2 | N m | T_2 K_2 | (m2*(dx2**2 + dy2**2) + I2*dtheta2**2)/2
V | N m | V U E_p | V1 + V2
V{n} | N m | V_{n} U_{n} | m{n}*g*y{n}
px | N m s | p_x p_1 | m_*dx + b_*dtheta1 + c_*dtheta2
p1 | N m s | p_theta1 p_2 | b_*dx + a_*dtheta1 + e_*dtheta2
p2 | N m s | p_theta2 p_3 | c_*dx + e_*dtheta1 + d_*dtheta2
F | N | F u f F_x Q_x Q_1 U tau
m_ | - | | M + m1 + m2
b_ | - | | side_*(m1*h1 + m2*l1)*cos(theta1)
c_ | - | | side_*(m2*h2)*cos(theta2)
a_ | - | | m1*h1**2 + I1 + m2*l1**2
e_ | - | | m2*l1*h2*cos(theta1 - theta2)
d_ | - | | m2*h2**2 + I2
s_ | - | | m2*l1*h2*sin(theta1 - theta2)
f_ | - | | -side_*(m1*h1 + m2*l1)*sin(theta1)*dtheta1
k_ | - | | -side_*(m2*h2)*sin(theta2)*dtheta2
mass | - | *M *H *D | vector(vector(m_, b_, c_), vector(b_, a_, e_), vector(c_, e_, d_))
turn | - | *C *H | vector(vector(0, f_, k_), vector(0, 0, s_*dtheta2), vector(0, -s_*dtheta1, 0))
turned | - | *C *c *h | vector(f_*dtheta1 + k_*dtheta2, s_*dtheta2**2, -s_*dtheta1**2)
weight | - | *G *g | vector(0, g*(m1*h1 + m2*l1)*rise(theta1), g*(m2*h2)*rise(theta2))
load | - | *Q *F *tau *u tau | vector(F, 0, 0)
force_ | - | | load - turned - weight
q | - | q *q *theta | vector(x, theta1, theta2)
B | - | *B *b | vector(1, 0, 0)
"""


def _plane(body: str, pose: str) -> Spec:
    extra = ("h", *("I", "J") * (body == "any"), "omega", "v", "x")
    title = f"a pendulum in a plane, {BODIES[body][0]}, in its angle from {POSES[pose][0]}"
    others = {"kind": f"plane {body} {pose}", "title": title, "extra": extra, "values": {"theta0": AMPLITUDE}}
    return body_spec(_PLANE, "theta", "m g l theta0 *", body, pose, {}, " ", **others)


def _two(body: str, relative: bool, equal: bool, pose: str, drive: str = "") -> Spec:
    loads = {"": (), "acrobot": ("tau2",), "both": ("tau1", "tau2")}[drive]
    driven = ("", ", with a torque at the second joint", ", with torques at both joints")[len(loads)]
    more = {name: "0" for name in ("tau1", "tau2") if name not in loads} | {"turns_": str(int(relative))}
    more |= {f"{name}2": f"{name}1" for name in "mlhI"} if equal else {}
    kinds = {"point": "point masses", "uniform": "uniform rods", "any": "rigid bodies", "tip": BODIES["tip"][0]}[body]
    which, both = ("relative", "theta1+theta2") if relative else ("absolute", "theta1-theta2")
    kind = f"double {body} {which}{' equal' * equal} {pose} {drive}".rstrip()
    title = (
        f"a double pendulum in a plane of {'equal ' * equal}{kinds}, in {which} angles from {POSES[pose][0]}{driven}"
    )
    absent = ("h1", "h2") * (body in ("point", "tip"))  # l_c1 is no length
    others = {"kind": kind, "title": title, "absent": absent, "atoms": (f"sin {both}", f"cos {both}")}
    return body_spec(_TWO, "theta1 theta2", f"m1 m2 g l1 l2 * {' '.join(loads)}", body, pose, more, "12", **others)


def _cart(body: str, pose: str, mirrored: bool, two: bool = False) -> Spec:
    turned, more = f"{POSES[pose][0]}{OTHER_WAY * mirrored}", {"side_": "-1" if mirrored else "1"}
    kind = f"cart-{'double' if two else 'pole'} {body} {pose}{' mirrored' * mirrored}"
    if not two:
        title = f"a pendulum on a cart, {BODIES[body][0]}, its angle from {turned}"
        others = {"kind": kind, "title": title, "extra": ("J", "I", "F")}
        return body_spec(_CART, "x theta", "M m g l * F", body, pose, more, " ", **others)
    kinds = "point masses" if body == "point" else "rigid bodies"
    title = f"two pendulums, one below the other, on a cart, {kinds}, their angles from {turned}"
    others = {"kind": kind, "title": title, "atoms": ("sin theta1-theta2", "cos theta1-theta2")}
    return body_spec(_CART_TWO, "x theta1 theta2", "M m1 m2 g l1 l2 * F", body, pose, more, "12", **others)


def _moved(pose: str, over: str, lift: str) -> Spec:
    ways = [f"{wave} {way}" for wave, way in ((over, "to the side"), (lift, "up")) if wave != "0*t"]
    title = (
        f"a pendulum in a plane, a point mass, in its angle from {POSES[pose][0]}; its pivot is {' and '.join(ways)}"
    )
    more = {"over_": over, "lift_": lift, "overs_": WAVES[over], "lifts_": WAVES[lift]}
    others = {"kind": f"moved point {pose} {over} {lift}", "title": title}
    return body_spec(_MOVED, "theta", "t m g l a nu", "point", pose, more, " ", **others)


def _elastic(pose: str, reach: str) -> Spec:
    what = {"s": "its length", "l0 + s": "what it is stretched by", "le + s": "how far it hangs below its rest"}[reach]
    title = f"a point mass on a spring in a plane, in {what} and its angle from {POSES[pose][0]}"
    others = {"kind": f"elastic {reach.replace(' ', '')} {pose}", "title": title}
    return body_spec(_ELASTIC, "s theta", "m g kappa l0", "point", pose, {"reach_": reach, "h": reach}, " ", **others)


def _three(pose: str, equal: bool) -> Spec:
    title = f"a triple pendulum in a plane of {'equal ' * equal}point masses, in absolute angles from {POSES[pose][0]}"
    more = {f"{name}{i}": f"{name}1" for name in "ml" for i in (2, 3)} if equal else {}
    atoms = tuple(f"{f} theta{i}-theta{j}" for f in ("sin", "cos") for i, j in ((1, 2), (1, 3), (2, 3)))
    others = {"kind": f"triple point{' equal' * equal} {pose}", "title": title, "atoms": atoms}
    return body_spec(_THREE, "theta1 theta2 theta3", "m1 m2 m3 g l1 l2 l3", "point", pose, more, "123", **others)


_FLAGS, _VERTICAL, _SINGLE = (False, True), ("down", "up"), ("any", "point", "uniform")
_STILL, *_MOVING = WAVES
_WAYS = [*((_STILL, lift) for lift in _MOVING), *((over, _STILL) for over in _MOVING)]
_WAYS += [("a*cos(nu*t)", "a*sin(nu*t)"), ("a*sin(nu*t)", "a*cos(nu*t)")]
FAMILIES = {
    "plane": [_plane(body, pose) for body, pose in product(_SINGLE, _VERTICAL)],
    "moved": [_moved(pose, *way) for way in _WAYS for pose in _VERTICAL],
    "elastic": [_elastic(pose, reach) for pose, reach in product(_VERTICAL, ("s", "l0 + s", "le + s"))],
    "cart-pole": [_cart(body, pose, mirrored) for body, pose, mirrored in product(_SINGLE, _VERTICAL, _FLAGS)],
    "cart-double": [_cart(body, pose, side, True) for body, pose, side in product(_SINGLE[:2], _VERTICAL, _FLAGS)],
    "double": [_two(b, a, e, p) for p, b, a, e in product(POSES, BODIES, _FLAGS, _FLAGS) if not (e and b == "tip")],
    "triple": [_three(pose, equal) for pose, equal in product(_VERTICAL, _FLAGS)],
    "acrobot": [_two(body, True, False, pose, to) for pose, body, to in product(POSES, BODIES, ("acrobot", "both"))],
} | AZIMUTHAL
