"""The O(n) chain route: against 50 digits, Pinocchio, the closed form of one rod, exact answers and its own laws."""

import tracemalloc
from itertools import pairwise

import mpmath as mp
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pendpin.derivations import chain, chain_angles, chain_kinematics, chain_thin, newton_euler
from pendpin.derivations.base import RodInertia
from pendpin.derivations.chain_inertia import ChainInertia
from pendpin.errors import InputError

G = np.array([0.0, 0.0, 9.81])  # m/s², in I
TILTED = np.array([0.4, -0.3, 9.7])  # m/s²
seeds = st.integers(0, 2**32 - 1)
laws = settings(max_examples=25, deadline=None)


# --- chains and states -------------------------------------------------------------------------------------------------


def rods(m, length, radius):
    J = m * (3 * radius**2 + length**2) / 12
    return ChainInertia(m, length / 2, length, J, J, m * radius**2 / 2)


def alike(n, radius):
    return rods(np.ones(n), np.ones(n), np.full(n, radius))


def mixed(n, rng, thin=0.0):
    """Masses over four decades, lengths over three, radii down to a thousandth of the length, some rods thin."""
    length = 10 ** rng.uniform(-2, 1, n)
    radius = length * 10 ** rng.uniform(-3, 0, n) * (rng.uniform(size=n) >= thin)
    return rods(10 ** rng.uniform(-2, 2, n), length, radius)


def thin_tail(n, rng):
    return rods(10 ** rng.uniform(-1, 1, n), 10 ** rng.uniform(-1, 1, n), np.where(np.arange(n) < n // 2, 0.05, 0.0))


def point_masses(n, rng):
    zero, length = np.zeros(n), 10 ** rng.uniform(-1, 1, n)
    return ChainInertia(10 ** rng.uniform(-1, 1, n), length, length, zero, zero, zero)


def state(n, rng, reach=1.2):
    return rng.uniform(-reach, reach, (n, 2)), rng.normal(size=(n, 2))


# --- the judge: the ten balances of every rod in 50 digits, in I, no unknown eliminated beforehand ----------------------


def vector(x):
    return mp.matrix([mp.mpf(float(t)) for t in x])


def cross(a, b):
    return mp.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def tilde(a):
    return mp.matrix([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def fifty_digit_frames(q, v):
    """Per rod: axes b (columns), a1, omega, and the part of alpha - alpha_above that the rates alone cause."""
    B, omega, out = mp.eye(3), mp.zeros(3, 1), []
    for (theta, phi), (theta_d, phi_d) in zip(q, v, strict=True):
        theta, phi, theta_d, phi_d = (mp.mpf(float(x)) for x in (theta, phi, theta_d, phi_d))
        s_t, c_t, s, c = mp.sin(theta), mp.cos(theta), mp.sin(phi), mp.cos(phi)
        a1, omega_above = B[:, 0], omega
        B = B * mp.matrix([[c, 0, s], [-s_t * s, c_t, s_t * c], [-c_t * s, -s_t, c_t * c]])
        omega = omega_above - theta_d * a1 + phi_d * B[:, 1]
        bias = -theta_d * cross(omega_above, a1) + phi_d * cross(omega, B[:, 1])
        out.append((B, a1, omega, bias))
    return out


def fifty_digits(rods, q, v, field, torque=None, force=None, moment=None):
    """theta'', phi'' (n, 2), F (n, 3) in B and Mc (n,), as arrays of mpmath numbers."""
    with mp.workdps(50):
        n, frames, rows = rods.n, fifty_digit_frames(q, v), []
        for i in range(n):
            rows += joint_rows(rods, frames, i, vector(field)) + rod_rows(rods, frames, i, torque, force, moment)
        x = eliminate(rows, 10 * n)
        F = [[dot(frames[i][0][:, k], x[10 * i : 10 * i + 3]) for k in range(3)] for i in range(n)]
        Mc = [x[10 * i + 3] for i in range(n)]
        alpha = [mp.zeros(3, 1)] + [mp.matrix(x[10 * i + 4 : 10 * i + 7]) for i in range(n)]
        relative = [b - a - frame[3] for (a, b), frame in zip(pairwise(alpha), frames, strict=True)]
        a = [[-dot(r, frame[1]), dot(r, frame[0][:, 1])] for r, frame in zip(relative, frames, strict=True)]
        return np.array(a), np.array(F), np.array(Mc)


def joint_rows(rods, frames, i, field):
    """Base of rod i and tip of rod i - 1 accelerate alike; the relative turning has no part along a3."""
    B, a1, omega, bias = frames[i]
    h, a3 = mp.mpf(rods.h[i]), cross(a1, B[:, 1])
    down = tilde(h * B[:, 2])
    known = h * cross(omega, cross(omega, B[:, 2]))
    rows = [{10 * i + 7 + k: mp.mpf(1), **{10 * i + 4 + j: down[k, j] for j in range(3)}} for k in range(3)]
    twist = {10 * i + 4 + j: a3[j] for j in range(3)}
    if i:
        k_above, (C, _, w, _) = mp.mpf(rods.l[i - 1]) - mp.mpf(rods.h[i - 1]), frames[i - 1]
        known += k_above * cross(w, cross(w, C[:, 2]))
        up = tilde(k_above * C[:, 2])
        for k in range(3):
            rows[k] |= {10 * i - 3 + k: mp.mpf(-1)} | {10 * i - 6 + j: up[k, j] for j in range(3)}
        twist |= {10 * i - 6 + j: -a3[j] for j in range(3)}
    else:
        known -= field
    return [(rows[k], known[k]) for k in range(3)] + [(twist, dot(bias, a3))]


def rod_rows(rods, frames, i, torque, force, moment):
    """Moment about G and force on rod i, accelerations relative to the field."""
    B, _, omega, _ = frames[i]
    m, h, k = (mp.mpf(x) for x in (rods.m[i], rods.h[i], rods.l[i])) if rods.n else ()
    k -= h
    inertia = B * mp.diag([mp.mpf(x[i]) for x in (rods.I1, rods.I2, rods.I3)]) * B.T
    known = -cross(omega, inertia * omega) + (vector(moment[i]) if moment is not None else mp.zeros(3, 1))
    turning = [{10 * i + 4 + j: inertia[r, j] for j in range(3)} for r in range(3)]
    moving = [{10 * i + 7 + r: m} for r in range(3)]
    for joint, sign, lever in ((i, 1, -h), (i + 1, -1, k)):
        if joint == rods.n:
            continue
        C, a1, _, _ = frames[joint]
        arm, a3 = tilde(lever * B[:, 2]), cross(a1, C[:, 1])
        for r in range(3):
            turning[r] |= {10 * joint + j: -sign * arm[r, j] for j in range(3)} | {10 * joint + 3: -sign * a3[r]}
            moving[r][10 * joint + r] = mp.mpf(-sign)
        if torque is not None:
            known += sign * (C[:, 1] * float(torque[joint][1]) - a1 * float(torque[joint][0]))
    push = vector(force[i]) if force is not None else mp.zeros(3, 1)
    return [(turning[r], known[r]) for r in range(3)] + [(moving[r], push[r]) for r in range(3)]


def eliminate(rows, size, reach=24):
    """Gauss with row pivoting on rows ({column: value}, right-hand side) whose entries lie near the diagonal."""
    rows = list(rows)
    for p in range(size):
        best = max(range(p, min(size, p + reach)), key=lambda r: abs(rows[r][0].get(p, 0)))
        rows[p], rows[best] = rows[best], rows[p]
        pivot, rhs = rows[p]
        for r in range(p + 1, min(size, p + reach)):
            row, other = rows[r]
            if factor := row.pop(p, 0) / pivot[p]:
                for column, value in pivot.items():
                    if column != p:
                        row[column] = row.get(column, 0) - factor * value
                rows[r] = row, other - factor * rhs
    x = [mp.mpf(0)] * size
    for p in reversed(range(size)):
        row, rhs = rows[p]
        x[p] = (rhs - sum(value * x[column] for column, value in row.items() if column != p)) / row[p]
    return x


def error(x, exact):
    """Largest error beside the largest value; absolute where all is 0."""
    with mp.workdps(50):
        difference = max(abs(mp.mpf(float(a)) - b) for a, b in zip(np.ravel(x), np.ravel(exact), strict=True))
        scale = max(abs(b) for b in np.ravel(exact))
        return float(difference / scale) if scale > 1e-30 else float(difference)


KINDS = {
    "ordinary": lambda n, rng: alike(n, 1.0),
    "slender": lambda n, rng: alike(n, 0.01),
    "mixed": mixed,
    "thin among mixed": lambda n, rng: mixed(n, rng, thin=0.5),
    "thin above thick": lambda n, rng: rods(np.ones(n), np.ones(n), np.where(np.arange(n) < n - 1, 0.0, 0.05)),
    "thin tail": thin_tail,
    "all thin": lambda n, rng: alike(n, 0.0),
    "point masses": point_masses,
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("loaded", [False, True])
def test_chain_vs_fifty_digits(kind, loaded):
    n, rng = 6, np.random.default_rng(3)
    some, (q, v) = KINDS[kind](n, rng), state(n, rng)
    loads = {}
    if loaded and kind != "point masses":  # a point mass takes no moment
        loads = {"torque": rng.normal(size=(n, 2)), "force": rng.normal(size=(n, 3)), "moment": rng.normal(size=(n, 3))}
    a, F, Mc = fifty_digits(some, q, v, TILTED, **loads)
    found = chain.solve(some, q, v, TILTED, **loads)
    assert error(found.acceleration, a) < 5e-15
    assert error(found.force, F) < 2e-15
    assert error(found.Mc, Mc) < 2e-14


def test_hundred_rods_vs_fifty_digits():
    rng = np.random.default_rng(1)
    some, (q, v) = mixed(100, rng), state(100, rng)
    a, F, Mc = fifty_digits(some, q, v, G)
    found = chain.solve(some, q, v, G)
    assert max(error(found.acceleration, a), error(found.force, F), error(found.Mc, Mc)) < 5e-15


# --- other routes ------------------------------------------------------------------------------------------------------


def two_revolutes(some):
    """The chain in Pinocchio: link frames are B with y and z negated, so are the components of all vectors."""
    model, above = pin.Model(), 0
    model.gravity = pin.Motion(np.array([0.0, 0.0, -9.81, 0.0, 0.0, 0.0]))
    for i in range(some.n):
        at = pin.SE3(np.eye(3), np.array([0.0, 0.0, -some.l[i - 1] if i else 0.0]))
        above = model.addJoint(above, pin.JointModelRevoluteUnaligned(-1.0, 0.0, 0.0), at, f"theta_{i + 1}")
        axis = pin.JointModelRevoluteUnaligned(0.0, -1.0, 0.0)
        above = model.addJoint(above, axis, pin.SE3.Identity(), f"phi_{i + 1}")
        inertia = np.diag([some.I1[i], some.I2[i], some.I3[i]])
        body = pin.Inertia(some.m[i], np.array([0.0, 0.0, -some.h[i]]), inertia)
        model.appendBodyToJoint(above, body, pin.SE3.Identity())
    return model


FLIP = np.array([1.0, -1.0, -1.0])


def external(model, data, some, q, force, moment):
    """Forces on the centres of mass and moments, given in I, as Pinocchio wants them."""
    pin.forwardKinematics(model, data, q.ravel())
    wrenches = pin.StdVec_Force()
    wrenches.extend([pin.Force.Zero() for _ in range(model.njoints)])
    for i in range(some.n):
        R = data.oMi[2 * i + 2].rotation
        f, t = R.T @ (FLIP * force[i]), R.T @ (FLIP * moment[i])
        wrenches[2 * i + 2] = pin.Force(f, t + np.cross([0, 0, -some.h[i]], f))
    return wrenches


@laws
@given(seeds)
def test_chain_vs_pinocchio_with_loads(seed):
    n, rng = 4, np.random.default_rng(seed)
    some, (q, v) = rods(rng.uniform(0.5, 2, n), rng.uniform(0.5, 2, n), rng.uniform(0.1, 0.3, n)), state(n, rng, np.pi)
    torque, force, moment = rng.normal(size=(n, 2)), rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
    model = two_revolutes(some)
    data = model.createData()
    outside = external(model, data, some, q, force, moment)
    a = pin.aba(model, data, q.ravel(), v.ravel(), torque.ravel(), outside)
    found = chain.solve(some, q, v, G, torque=torque, force=force, moment=moment)
    np.testing.assert_allclose(found.acceleration.ravel(), a, rtol=1e-9, atol=1e-10 * abs(a).max())
    pin.rnea(model, data, q.ravel(), v.ravel(), found.acceleration.ravel(), outside)
    wrench = np.array([data.f[2 * i + 2].vector for i in range(n)]) * np.tile(FLIP, 2)
    np.testing.assert_allclose(found.wrench, wrench, rtol=1e-9, atol=1e-10 * abs(wrench).max())


@laws
@given(seeds)
def test_energies_vs_pinocchio(seed):
    n, rng = 5, np.random.default_rng(seed)
    some, (q, v) = mixed(n, rng), state(n, rng, np.pi)
    model = two_revolutes(some)
    data = model.createData()
    kinetic, potential = chain_kinematics.energy(some, q, v, G)
    scale = (some.m * 9.81 * np.cumsum(some.l)).sum()
    assert kinetic == pytest.approx(pin.computeKineticEnergy(model, data, q.ravel(), v.ravel()), rel=1e-12)
    assert potential == pytest.approx(pin.computePotentialEnergy(model, data, q.ravel()), rel=1e-12, abs=1e-13 * scale)


@laws
@given(seeds)
def test_one_rod_vs_closed_form(seed):
    rng = np.random.default_rng(seed)
    inertia = rng.uniform(0.1, 0.2, 3)
    one = ChainInertia(*(np.array([x]) for x in (1.3, 0.4, 1.0, *inertia)))
    q, v = state(1, rng, np.pi)
    found, exact = chain.solve(one, q, v, TILTED), newton_euler.solve(RodInertia(1.3, 0.4, *inertia), q, v, TILTED)
    for name in ("R1", "R2", "R3", "M3", "Mc"):
        np.testing.assert_allclose(getattr(found, name), getattr(exact, name), rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(found.acceleration, np.stack([exact.theta_dd, exact.phi_dd], -1), rtol=1e-12, atol=1e-12)


# --- exact answers and laws --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [0.0, 0.1])
def test_hanging_at_rest_every_joint_carries_the_weight_below(radius):
    n = 50
    some = rods(np.geomspace(0.01, 100, n), np.geomspace(10, 0.01, n), np.full(n, radius))
    found = chain.solve(some, np.zeros((n, 2)), np.zeros((n, 2)), G)
    np.testing.assert_allclose(found.R3, 9.81 * np.cumsum(some.m[::-1])[::-1], rtol=1e-14)
    np.testing.assert_array_equal(found.force[:, :2], 0)
    np.testing.assert_array_equal(found.acceleration, 0)
    np.testing.assert_array_equal(found.wrench[:, 3:], 0)


def test_nothing_acts_nothing_happens():
    found = chain.solve(alike(4, 0.1), np.full((4, 2), 0.3), np.zeros((4, 2)), np.zeros(3))
    np.testing.assert_array_equal(found.acceleration, 0)
    np.testing.assert_array_equal(found.force, 0)


@laws
@given(seeds)
def test_power_of_torques_and_pushes_is_the_change_of_energy(seed):
    n, rng = 5, np.random.default_rng(seed)
    some, (q, v) = alike(n, 0.3), state(n, rng)
    torque, force, moment = rng.normal(size=(n, 2)), rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
    a = chain.solve(some, q, v, TILTED, torque=torque, force=force, moment=moment).acceleration
    moving = chain_kinematics.motion(some, q, v)
    spin = np.einsum("nij,nj->ni", moving.frames, moving.omega)
    power = (torque * v).sum() + (force * moving.centre_velocities).sum() + (moment * spin).sum()
    h = 1e-5
    ahead, back = (sum(chain_kinematics.energy(some, q + t * v, v + t * a, TILTED)) for t in (h, -h))
    assert (ahead - back) / (2 * h) == pytest.approx(power, rel=1e-7, abs=1e-6)


def test_batch_equals_single_states():
    n, rng = 7, np.random.default_rng(5)
    some = mixed(n, rng, thin=0.3)
    q, v = (rng.uniform(-1, 1, (2, 3, n, 2)) for _ in range(2))
    field = rng.normal(size=(2, 3, 3))
    found = chain.solve(some, q, v, field)
    kinetic, potential = chain_kinematics.energy(some, q, v, G)
    moving, at = chain_kinematics.motion(some, q, v), chain_kinematics.positions(some, q)
    for i in np.ndindex(2, 3):
        single = chain.solve(some, q[i], v[i], field[i])
        np.testing.assert_allclose(found.acceleration[i], single.acceleration, rtol=1e-11)
        np.testing.assert_allclose(found.wrench[i], single.wrench, rtol=1e-11, atol=1e-11 * abs(single.wrench).max())
        assert (kinetic[i], potential[i]) == pytest.approx(chain_kinematics.energy(some, q[i], v[i], G), rel=1e-14)
        for ours, alone in zip(moving, chain_kinematics.motion(some, q[i], v[i]), strict=True):
            np.testing.assert_allclose(ours[i], alone, rtol=0, atol=1e-13 * abs(alone).max())
        np.testing.assert_array_equal(at.tips[i], moving.tips[i])


def test_velocities_are_the_rates_of_positions():
    n, rng = 6, np.random.default_rng(6)
    some, (q, v) = mixed(n, rng), state(n, rng)
    moving, h = chain_kinematics.motion(some, q, v), 1e-6
    ahead, back = (chain_kinematics.positions(some, q + t * v) for t in (h, -h))
    np.testing.assert_allclose(moving.tip_velocities, (ahead.tips - back.tips) / (2 * h), atol=1e-7)
    np.testing.assert_allclose(moving.centre_velocities, (ahead.centres - back.centres) / (2 * h), atol=1e-7)


def test_memory_grows_with_the_rods_only():
    def peak(n):
        some, (q, v) = alike(n, 0.05), state(n, np.random.default_rng(0))
        chain.solve(some, q, v, G)
        tracemalloc.start()
        chain.solve(some, q, v, G)
        size = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return size

    assert peak(4000) < 2.2 * peak(2000) < 20e6


def test_orientation_keeps_its_digits_down_a_long_chain():
    q, _ = state(2000, np.random.default_rng(2))
    B = chain_kinematics.positions(alike(2000, 0.1), q).frames
    np.testing.assert_allclose(B.swapaxes(1, 2) @ B, np.broadcast_to(np.eye(3), B.shape), atol=2e-13)


# --- thin rods ---------------------------------------------------------------------------------------------------------


def about_z(angle):
    return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])


@laws
@given(seeds)
def test_thin_chain_in_directions_vs_angles(seed):
    n, rng = 8, np.random.default_rng(seed)
    some, (q, v) = mixed(n, rng, thin=1.0), state(n, rng)
    force = rng.normal(size=(n, 3))
    d, rate = chain_thin.directions(q, v)
    moment = np.cross(d, rng.normal(size=(n, 3)))
    there = chain_thin.solve(some, d, rate, TILTED, force=force, moment=moment)
    here = chain.solve(some, q, v, TILTED, force=force, moment=moment)
    frames = chain_kinematics.positions(some, q).frames
    F = np.einsum("nij,ni->nj", frames, there.force)
    np.testing.assert_allclose(F, here.force, rtol=0, atol=1e-12 * abs(F).max())
    np.testing.assert_array_equal(here.Mc, 0)
    reading = chain_angles.read(d[None], rate[None], there.acceleration[None], q)
    np.testing.assert_allclose(reading.q[0], q, atol=1e-13)
    np.testing.assert_allclose(reading.v[0], v, atol=1e-9)
    scale = abs(here.acceleration).max()
    np.testing.assert_allclose(reading.a[0], here.acceleration, atol=1e-9 * scale)
    energies = chain_kinematics.energy(some, q, v, G)
    np.testing.assert_allclose(chain_thin.energy(some, d, rate, G), energies, rtol=1e-11)


@pytest.mark.parametrize("pole", [np.pi / 2, -np.pi / 2])
def test_thin_chain_is_regular_at_the_pole(pole):
    """The middle one of three rods at cos(phi) = 0: the same as the whole turned about the vertical."""
    some, rng = alike(3, 0.0), np.random.default_rng(8)
    q, v = state(3, rng)
    q[1, 1] = pole
    d, rate = chain_thin.directions(q, v)
    here = chain_thin.solve(some, d, rate, G)
    turn = about_z(0.9)
    turned = chain_thin.solve(some, d @ turn.T, rate @ turn.T, G)
    np.testing.assert_allclose(turned.acceleration, here.acceleration @ turn.T, atol=1e-13)
    np.testing.assert_allclose(turned.force, here.force @ turn.T, atol=1e-13)
    F = np.einsum("nij,ni->nj", chain_kinematics.positions(some, q).frames, here.force)
    np.testing.assert_allclose(chain.solve(some, q, v, G).force, F, atol=1e-13)


def test_thin_solution_ignores_what_leads_off_the_sphere():
    some, rng = alike(3, 0.0), np.random.default_rng(9)
    d, rate = chain_thin.directions(*state(3, rng))
    straight, off = chain_thin.solve(some, d, rate, G), chain_thin.solve(some, 1.01 * d, rate + 0.1 * d, G)
    np.testing.assert_allclose(off.acceleration, straight.acceleration, atol=1e-12)
    np.testing.assert_allclose((straight.acceleration * d).sum(-1), -(rate**2).sum(-1), atol=1e-13)


def path(n, rng, times):
    """Smooth angles, their rates and accelerations (k, n, 2), that go through several poles and turns."""
    amplitude, speed, phase = rng.uniform(0.5, 2.5, (3, n, 2))
    angle = speed * times[:, None, None] + phase
    return amplitude * np.sin(angle), amplitude * speed * np.cos(angle), -amplitude * speed**2 * np.sin(angle)


@laws
@given(seeds)
def test_angles_are_read_back_along_a_path(seed):
    """Directions of a path, and its second derivatives by differences; compared away from the poles."""
    rng, times, h = np.random.default_rng(seed), np.linspace(0, 4, 1600), 1e-5
    q, v, a = path(2, rng, times)
    d, rate = chain_thin.directions(q, v)
    after, before = (chain_thin.directions(q + t * v + t * t / 2 * a, v + t * a)[1] for t in (h, -h))
    found = chain_angles.read(d, rate, (after - before) / (2 * h), q[0])
    closest = np.abs(np.cos(q[..., 1])).min(1).cumprod() if False else np.abs(np.cos(q[..., 1])).min(1)
    clear = closest > 0.05
    same = np.exp(1j * (found.q - q)) - 1
    flipped = np.abs(same).max((1, 2)) > 1e-9  # passing close by a pole between samples takes the other pair
    keep = clear & ~flipped
    assert keep.any()
    np.testing.assert_allclose(found.v[keep], v[keep], atol=1e-9)
    np.testing.assert_allclose(found.a[keep], a[keep], atol=1e-3)
    np.testing.assert_allclose(np.einsum("kni,knij->knj", d, found.frames)[..., 2], 1, atol=1e-13)
    assert np.abs(np.diff(found.q, axis=0))[:, 0].max() < 0.5 * np.pi + 1e-9


@pytest.mark.parametrize("theta", [0.0, 0.8])
def test_full_turns_through_the_pole_are_read_as_such(theta):
    phi = np.linspace(-0.25 * np.pi, 4.75 * np.pi, 241)  # hits every pole on the way exactly
    q = np.stack([np.full_like(phi, theta), phi], -1)[:, None]
    v = np.broadcast_to([0.0, 2.0], q.shape)
    d, rate = chain_thin.directions(q, v)
    found = chain_angles.read(d, rate, -4 * d, q[0])
    np.testing.assert_allclose(found.q, q, atol=1e-12)
    np.testing.assert_allclose(found.v, v, atol=1e-7)
    np.testing.assert_allclose(found.a[np.abs(np.cos(phi)) > 1e-3], 0, atol=1e-9)


def test_a_rod_at_rest_at_the_pole_keeps_the_angle_before():
    q = np.array([[[0.3, 1.5]], [[0.3, np.pi / 2]], [[0.3, np.pi / 2]]])
    d, rate = chain_thin.directions(q, np.zeros_like(q))
    d[1:] = [1.0, 0.0, 0.0]
    found = chain_angles.read(d, rate, np.zeros_like(d), q[0, :])
    np.testing.assert_allclose(found.q, q, atol=1e-12)
    np.testing.assert_array_equal(found.v, 0)


# --- what cannot be solved ---------------------------------------------------------------------------------------------


def test_thin_rod_under_a_torque_at_the_pole_has_no_solution():
    q = np.array([[0.2, 0.3], [0.1, np.pi / 2]])
    with pytest.raises(np.linalg.LinAlgError, match="thin rod"):
        chain.solve(alike(2, 0.0), q, np.zeros((2, 2)), G, torque=np.ones((2, 2)))


def test_thin_rod_under_a_torque_close_to_the_pole_still_has_one():
    q, torque = np.array([[0.2, 0.3], [0.1, np.pi / 2 - 1e-5]]), np.array([[0.0, 0.0], [0.5, 0.0]])
    some = alike(2, 0.0)
    a, F, Mc = fifty_digits(some, q, np.zeros((2, 2)), G, torque)
    found = chain.solve(some, q, np.zeros((2, 2)), G, torque=torque)
    assert max(error(found.acceleration, a), error(found.force, F), error(found.Mc, Mc)) < 1e-14


def test_nan_passes_through():
    q = np.full((3, 2), 0.1)
    q[1, 0] = np.nan
    assert np.isnan(chain.solve(alike(3, 0.1), q, np.zeros((3, 2)), G).acceleration).all()


def test_inputs_that_make_no_sense_are_named():
    with pytest.raises(InputError, match="rod 2"):
        ChainInertia([1, 1], [1, 1], [1, 1], [0.1, 0.1], [0.1, 0.2], [0.1, 0.0])
    with pytest.raises(InputError, match="axial inertia"):
        chain_thin.solve(alike(2, 0.1), np.eye(3)[:2], np.zeros((2, 3)), G)
