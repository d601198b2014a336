"""Each effect against an answer from outside: a closed form, or a balance worked out by hand."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, least_squares

import pendpin as pp
from effect_cases import FIVE, THIN, planar
from pendpin import effects as fx

G = 9.81
GRAVITY = fx.Gravity()
ROD = pp.Rod(length=1.2, mass=0.8, radius=0.05)
M, H, J = 0.8, 0.6, 0.8 * ((3 * 0.05**2 + 1.2**2) / 12 + 0.36)  # kg, m, kg m² about the joint


def at_rest(effects: tuple, theta: float, phi: float = 0.0, t: float = 0.0, rod: pp.Rod = ROD) -> np.ndarray:
    """The accelerations of one rod that is held still at these angles."""
    scene = pp.Scene(model=pp.Chain(rods=(rod,)), effects=effects)
    return pp.bind(scene).acceleration(t, np.array([theta, phi]), np.zeros(2))


# --- joints ---------------------------------------------------------------------------------------------------------


def test_damped_small_swing() -> None:
    """theta'' + 2 c theta' + w² theta = 0: the decrement of every swing is exp(-2 pi c / sqrt(w² - c²))."""
    coefficient, start = 0.15, 1e-4
    c, w = coefficient / (2 * J), np.sqrt(M * G * H / J)
    damped = np.sqrt(w**2 - c**2)
    run = planar((GRAVITY, fx.Viscous(coefficient=coefficient)), ROD, (start, 0.0), 10 * 2 * np.pi / damped, samples=11)
    decrement = run.q[1:, 0] / run.q[:-1, 0]
    assert decrement == pytest.approx(np.exp(-2 * np.pi * c / damped), rel=1e-7)


def test_spring_frequency() -> None:
    """Without gravity, in theta alone: theta = rest + A cos(sqrt(k/J) t), exactly, at any amplitude."""
    run = planar((fx.Spring(stiffness=3.0, rest=0.4, joints=("theta",)),), ROD, (2.4, 0.0), 20.0)
    assert np.abs(run.q[:, 0] - 0.4 - 2.0 * np.cos(np.sqrt(3.0 / J) * run.t)).max() < 1e-9


def test_motor_torques() -> None:
    """A constant and a sinusoidal torque on a free rod, integrated by hand."""
    motor = fx.Motor(joint="theta", torque=0.3, amplitude=0.7, frequency=2.0, phase=0.5)
    t = (run := planar((motor,), ROD, (0.0, 0.0), 5.0)).t
    swing = 0.7 / J * (np.cos(0.5) * t / 2 - (np.sin(2 * t + 0.5) - np.sin(0.5)) / 4)
    assert np.abs(run.q[:, 0] - 0.15 / J * t**2 - swing).max() < 1e-10


def test_a_hold_is_a_damped_spring() -> None:
    """J x'' + d x' + p x = 0 about the target, critically damped: x = x0 (1 + w t) exp(-w t)."""
    w = 3.0
    hold = fx.Motor(joint="theta", target=1.1, proportional=J * w**2, derivative=2 * J * w)
    run = planar((hold,), ROD, (0.1, 0.0), 4.0)
    assert np.abs(run.q[:, 0] - 1.1 + (1 + w * run.t) * np.exp(-w * run.t)).max() < 1e-10


# --- pushes ---------------------------------------------------------------------------------------------------------


def test_a_push_at_the_centre_of_mass_is_gravity() -> None:
    """m g, downwards."""
    push = fx.Push(link="rod", force=(0, 0, -M * G))
    assert np.allclose(at_rest((push,), 0.7, 0.4), at_rest((GRAVITY,), 0.7, 0.4), rtol=1e-14, atol=0)


def test_a_push_at_a_point_of_the_rod() -> None:
    """tan(theta) = F s / (m g h) for a force F across, at s from the joint; theta tilts the rod towards -y."""
    push = fx.Push(link="rod_1", force=(0, -2.5, 0), point=0.9)
    assert np.abs(at_rest((GRAVITY, push), np.arctan(2.5 * 0.9 / (M * G * H)))).max() < 1e-14


def test_a_torque_in_the_world() -> None:
    """About -x it turns theta, whatever theta is; about b2 it turns phi."""
    assert at_rest((fx.Push(link="rod", torque=(-0.3, 0, 0)),), 0.8) == pytest.approx([0.3 / J, 0], rel=1e-14)
    theta = 0.8
    b2 = (0.0, -np.cos(theta), np.sin(theta))
    push = fx.Push(link="rod", torque=tuple(0.3 * x for x in b2))
    assert at_rest((push,), theta) == pytest.approx([0, 0.3 / J], abs=1e-15)


# --- air ------------------------------------------------------------------------------------------------------------


def test_terminal_angle_in_steady_wind() -> None:
    """rho C D U² l² cos²(a) / 4 = m g h sin(a), reached by a swing that linear drag damps."""
    wind = 8.0
    lift = 1.3 * 1.1 * 0.1 * wind**2 * 1.2**2 / 4
    angle = brentq(lambda a: lift * np.cos(a) ** 2 - M * G * H * np.sin(a), 0, 1, xtol=1e-15)
    drag = fx.Drag(density=1.3, coefficient=1.1, wind=(0, -wind, 0))
    assert np.abs(at_rest((GRAVITY, drag), angle)).max() < 1e-13
    run = planar((GRAVITY, drag, fx.Viscous(coefficient=2.0)), ROD, (0.0, 0.0), 30.0, samples=2)
    assert run.q[-1, 0] == pytest.approx(angle, abs=1e-11)


def test_terminal_angle_in_a_linear_wind() -> None:
    """tan(a) = k U l² / (2 m g h) where only linear drag acts; the rod settles there by that drag."""
    drag = fx.Drag(coefficient=0, linear=2.0, wind=(0, -3.0, 0))
    run = planar((GRAVITY, drag), ROD, (0.0, 0.0), 60.0, samples=2)
    assert run.q[-1, 0] == pytest.approx(np.arctan(2.0 * 3.0 * 1.2**2 / (2 * M * G * H)), abs=1e-10)


def test_a_rod_that_moves_with_the_wind_feels_none() -> None:
    """Along the rod too: only the flow across counts."""
    still, along = fx.Drag(wind=(0, 0, 0)), fx.Drag(wind=(0, 0, 7.0))
    for drag in (still, along):
        assert np.abs(at_rest((drag,), 0.0)).max() == 0


def test_the_support_carries_the_rod_through_the_air() -> None:
    """A trolley at 2 m/s in still air is a standing one in a wind of -2 m/s."""
    moving = (fx.Support(amplitude=(0, 2.0 / 3.0, 0), frequency=3.0), fx.Drag())
    standing = (fx.Drag(wind=(0, -2.0, 0)),)
    assert np.allclose(at_rest(moving, 0.3, 0.2), at_rest(standing, 0.3, 0.2), rtol=1e-12, atol=0)


def test_gusts() -> None:
    """wind + gust sin(frequency t)."""
    gusty, steady = fx.Drag(wind=(1, 0, 0), gust=(0, 4, 0), frequency=0.5), fx.Drag(wind=(1, 2, 0))
    assert np.allclose(at_rest((gusty,), 0.3, t=np.pi / 3), at_rest((steady,), 0.3), rtol=1e-14, atol=0)


def test_a_rod_as_dense_as_the_water_floats() -> None:
    """At every angle; half as dense, gravity acts upwards as much as it acted downwards."""
    water = M / (np.pi * 0.05**2 * 1.2)
    floats = fx.Drag(density=water, coefficient=0, buoyancy=True)
    assert np.abs(at_rest((GRAVITY, floats), 0.7, 0.4)).max() < 1e-14
    lighter = fx.Drag(density=2 * water, coefficient=0, buoyancy=True)
    assert np.allclose(at_rest((GRAVITY, lighter), 0.7, 0.4), -at_rest((GRAVITY,), 0.7, 0.4), rtol=1e-13, atol=0)


def test_buoyancy_is_that_of_gravity_alone() -> None:
    """The air of the room does not feel the motion of the support."""
    shaken = fx.Support(amplitude=(0, 0.1, 0), frequency=9.0, phase=0.5 * np.pi)
    water = fx.Drag(density=M / (np.pi * 0.05**2 * 1.2), coefficient=0, buoyancy=True)
    assert np.allclose(at_rest((GRAVITY, shaken, water), 0.7), at_rest((shaken,), 0.7), rtol=1e-12, atol=1e-12)


# --- support --------------------------------------------------------------------------------------------------------

FLOQUET = 44.390795  # rad/s, reduced length 1 m, amplitude 0.1 m, g 9.81


def trace(frequency: float) -> float:
    """Of the monodromy matrix of the upright rod, from two runs over one period next to it."""
    small, period = 1e-5, 2 * np.pi / frequency
    drive = fx.Support(amplitude=(0, 0, 0.1), frequency=frequency)
    rod = pp.Rod(length=1.5, mass=1.0)  # reduced length 2 l / 3
    ends = [planar((GRAVITY, drive), rod, (np.pi + x, v), period, samples=2) for x, v in ((small, 0), (0, small))]
    return (ends[0].q[-1, 0] - np.pi + ends[1].v[-1, 0]) / small


def test_kapitza() -> None:
    """Upright is unstable 0.1 % below the Floquet bound and stable 0.1 % above it; the bound itself to 1e-6."""
    assert trace(0.999 * FLOQUET) > 2 > trace(1.001 * FLOQUET) > -2
    bound = brentq(lambda w: trace(w) - 2, 0.999 * FLOQUET, 1.001 * FLOQUET, xtol=1e-7)
    assert bound == pytest.approx(FLOQUET, rel=1e-6)


@pytest.mark.parametrize(("frequency", "stands"), [(1.01 * FLOQUET, True), (0.99 * FLOQUET, False)])
def test_kapitza_over_many_periods(frequency: float, stands: bool) -> None:
    """Released 1 mrad from upright: it stays within some, or falls."""
    drive = fx.Support(amplitude=(0, 0, 0.1), frequency=frequency)
    run = planar((GRAVITY, drive), pp.Rod(length=1.5, mass=1.0), (np.pi + 1e-3, 0), 12.0, tolerance=1e-9, samples=1201)
    assert (np.abs(run.q[:, 0] - np.pi).max() < 0.02) == stands


def test_free_fall_of_the_support(tmp_path) -> None:
    """Falling with g, a pendulum moves as without gravity; the positions come from a file."""
    t = np.linspace(-0.5, 3.5, 41)
    rows = "".join(f"{x!r}, {x / 3!r}, 0.25, {1 - G / 2 * x * x!r}\n" for x in t.tolist())
    (tmp_path / "fall.csv").write_text(f"t, x, y, z\n# a stone\n{rows}")
    chain = {"model": pp.Chain(rods=FIVE), "start": pp.Start(velocities=dict.fromkeys(("theta_1", "phi_3"), 2.0))}
    solver = pp.Solver(tolerance=1e-12, samples=4)
    falling = (GRAVITY, fx.Support(csv=tmp_path / "fall.csv"))
    found, free = (pp.simulate(pp.Scene(duration=3.0, effects=x, solver=solver, **chain)) for x in (falling, ()))
    assert np.abs(found.q - free.q).max() < 1e-10
    assert np.ptp(found.kinetic) < 1e-10 * found.kinetic[0]


def test_a_file_of_positions_is_the_motion_it_samples(tmp_path) -> None:
    """A sinusoid sampled 50 times a second: position, velocity and acceleration between the rows."""
    sinusoid = fx.Support(amplitude=(0.3, 0.0, -0.1), frequency=2.0, phase=0.4)
    t = np.linspace(0, 10, 501)
    np.savetxt(tmp_path / "sinusoid.csv", np.column_stack([t, sinusoid.position(t)]), delimiter=",", fmt="%.17g")
    read, between = fx.Support(csv=tmp_path / "sinusoid.csv"), np.linspace(0.5, 9.5, 333)
    for name, most in (("position", 1e-10), ("velocity", 1e-8), ("acceleration", 2e-6)):
        found, expected = getattr(read, name)(between), getattr(sinusoid, name)(between)
        assert found.shape == (333, 3)
        assert np.abs(found - expected).max() < most
        assert np.array_equal(getattr(read, name)(between[7]), found[7])


def test_resonance_of_a_driven_support() -> None:
    """Small swings under a = A w² sin(w t): the linear answer, integrated by SciPy."""
    amplitude, w = 1e-5, 2.5
    run = planar((GRAVITY, fx.Support(amplitude=(0, amplitude, 0), frequency=w)), ROD, (0.0, 0.0), 10.0)
    linear = solve_ivp(
        lambda t, y: [y[1], -M * H * (G * y[0] + amplitude * w**2 * np.sin(w * t)) / J],
        (0, 10),
        [0, 0],
        "DOP853",
        run.t,
        rtol=1e-12,
        atol=1e-16,
    )
    assert np.abs(run.q[:, 0] - linear.y[0]).max() < 1e-11


# --- rotation -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("latitude", [90.0, 48.85, 10.0, -33.9, -90.0])
def test_foucault(latitude: float) -> None:
    """The swing plane turns at Omega sin(latitude), clockwise in the north: a fit of x + iy over three swings."""
    rod, start = pp.Rod(length=67.0, mass=0.0, payload=28.0), pp.Start(positions={"phi": 1e-3})
    solver = pp.Solver(tolerance=1e-14, samples=301)
    effects = (GRAVITY, fx.Rotation(latitude=latitude))
    run = pp.simulate(pp.Scene(duration=50.0, model=pp.Chain(rods=(rod,)), start=start, effects=effects, solver=solver))
    z, t = (run.tips[:, 0, 0] + 1j * run.tips[:, 0, 1]) / 67e-3, run.t

    def off(p: np.ndarray) -> np.ndarray:
        swing = complex(*p[:2]) * np.exp(1j * p[2] * t) + complex(*p[3:5]) * np.exp(-1j * p[2] * t)
        return (np.exp(-1j * 1e-5 * p[5] * t) * swing + complex(*p[6:]) - z).view(float)

    guess = [0.5, 0, np.sqrt(G / 67), 0.5, 0, 0, 0, 0]
    fit = least_squares(off, guess, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert 1e-5 * fit.x[5] == pytest.approx(7.292115e-5 * np.sin(np.radians(latitude)), abs=1e-6 * 7.292115e-5)


@pytest.mark.parametrize("rod", [ROD, THIN])
def test_rest_angle_in_a_centrifuge(rod: pp.Rod) -> None:
    """cos(a) = m g h / ((J - I3) Omega²), or 3 g / (2 Omega² l) for a thin rod: there a damped one rests, any way round."""
    m, h, I1, _, I3 = rod.properties
    cosine = m * G * h / ((I1 + m * h * h - I3) * 25.0)
    if rod is THIN:
        assert cosine == pytest.approx(1.5 * G / 25.0)
    effects = (GRAVITY, fx.Rotation(rate=(0, 0, 5.0)), fx.Viscous(coefficient=2.0))
    run = planar(effects, rod, (0.3, 0.0), 30.0, samples=2)
    assert np.cos(run.q[-1]).prod() == pytest.approx(cosine, abs=1e-10)
    assert np.abs(run.v[-1]).max() < 1e-9


def test_a_rod_that_spins_about_a_hinge_at_its_end() -> None:
    """Drake's published case: 1.5 kg, 2 m, g 10, 5 rad/s, held level: F = (0, -37.5, 15) N, T = (15, 0, 0) N m."""
    rod, level = pp.Rod(length=2.0, mass=1.5), -np.pi / 2
    hold = fx.Motor(joint="theta", torque=-15.0)
    effects = (fx.Gravity(acceleration=10.0), fx.Rotation(rate=(0, 0, 5.0)), hold)
    dynamics, q = pp.bind(pp.Scene(model=pp.Chain(rods=(rod,)), effects=effects)), np.array([level, 0.0])
    assert np.abs(dynamics.acceleration(0.0, q, np.zeros(2))).max() < 1e-14
    wrench = dynamics.wrenches(0.0, q, np.zeros(2))[1].reshape(2, 3)
    x, y, z = np.eye(3)
    R = np.stack([x, z, -y], -1)  # the link frame, its -z along +y
    assert np.allclose(R @ wrench.T, np.array([[0, -37.5, 15.0], [15.0, 0, 0]]).T, rtol=0, atol=1e-12)


def test_a_joint_carries_the_weight_less_the_buoyancy() -> None:
    """Of a rod that hangs still in water, its mass less that of the water in its place."""
    rod = pp.Rod(length=1.2, mass=3.0, radius=0.02)
    water = fx.Drag(density=1000.0, diameter=0.04, buoyancy=True)
    run = pp.simulate(pp.Scene(duration=0.1, model=pp.Chain(rods=[rod]), effects=[fx.Gravity(), water]), samples=3)
    assert run["R3"] == pytest.approx(9.81 * (3.0 - 1000.0 * np.pi * 0.02**2 * 1.2), rel=1e-12)
