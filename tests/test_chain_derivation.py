"""The O(n) chain route: against 50 digits, Pinocchio, the closed form of one rod, exact answers and its own laws."""

import tracemalloc

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chain_energies import energy
from fifty_digits import KINDS, TILTED, G, alike, error, fifty_digits, mixed, rods, state
from laws import law
from pendpin.equations import newton_euler
from pendpin.equations.base import RodInertia
from pendpin.equations.chain import kinematics, solution, system
from pendpin.equations.chain.kinematics import ChainInertia
from pendpin.errors import InputError

seeds = st.integers(0, 2**32 - 1)
laws = law(25)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("loaded", [False, True])
def test_chain_vs_fifty_digits(kind, loaded):
    n, rng = 6, np.random.default_rng(3)
    some, (q, v) = KINDS[kind](n, rng), state(n, rng)
    loads = {}
    if loaded and kind != "point masses":  # a point mass takes no moment
        loads = {"torque": rng.normal(size=(n, 2)), "force": rng.normal(size=(n, 3)), "moment": rng.normal(size=(n, 3))}
    a, F, Mc = fifty_digits(some, q, v, TILTED, **loads)
    found = solution.solve(some, q, v, TILTED, **loads)
    assert error(found.acceleration, a) < 5e-15
    assert error(found.force, F) < 2e-15
    assert error(found.Mc, Mc) < 2e-14


def test_hundred_rods_vs_fifty_digits():
    rng = np.random.default_rng(1)
    some, (q, v) = mixed(100, rng), state(100, rng)
    a, F, Mc = fifty_digits(some, q, v, G)
    found = solution.solve(some, q, v, G)
    assert max(error(found.acceleration, a), error(found.force, F), error(found.Mc, Mc)) < 5e-15


@pytest.mark.parametrize("kind", ["mixed", "thin among mixed", "thin tail"])
def test_direct_solution_vs_elimination(kind, monkeypatch):
    """The two ways to the same balances, on a batch; the direct one is what hard states fall back to."""
    rng = np.random.default_rng(12)
    some, (q, v) = KINDS[kind](5, rng), rng.uniform(-1, 1, (2, 3, 5, 2))
    usual = solution.solve(some, q, v, G)
    monkeypatch.setattr(system, "Eliminated", system.Direct)
    direct = solution.solve(some, q, v, G)
    np.testing.assert_allclose(direct.wrench, usual.wrench, atol=1e-13 * abs(usual.wrench).max())
    np.testing.assert_allclose(direct.acceleration, usual.acceleration, atol=1e-13 * abs(usual.acceleration).max())


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
    found = solution.solve(some, q, v, G, torque=torque, force=force, moment=moment)
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
    kinetic, potential = energy(some, q, v, G)
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
    found, exact = solution.solve(one, q, v, TILTED), newton_euler.solve(RodInertia(1.3, 0.4, *inertia), q, v, TILTED)
    force = np.stack([exact.R1, exact.R2, -exact.R3], -1)
    for mine, other in ((found.force, force), (found.M3, exact.M3), (found.Mc, exact.Mc)):
        np.testing.assert_allclose(mine, other, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(found.acceleration, np.stack([exact.theta_dd, exact.phi_dd], -1), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("radius", [0.0, 0.1])
def test_hanging_at_rest_every_joint_carries_the_weight_below(radius):
    n = 50
    some = rods(np.geomspace(0.01, 100, n), np.geomspace(10, 0.01, n), np.full(n, radius))
    found = solution.solve(some, np.zeros((n, 2)), np.zeros((n, 2)), G)
    np.testing.assert_allclose(-found.force[..., 2], 9.81 * np.cumsum(some.m[::-1])[::-1], rtol=1e-14)
    np.testing.assert_array_equal(found.force[:, :2], 0)
    np.testing.assert_array_equal(found.acceleration, 0)
    np.testing.assert_array_equal(found.wrench[:, 3:], 0)


@pytest.mark.parametrize("size", [1e-3, 1e-9, 1e-17, 1e-30])
@pytest.mark.parametrize("kind", ["ordinary", "mixed", "thin among mixed"])
def test_close_to_rest_vs_fifty_digits(kind, size):
    """Where the rods hardly move, rounding is to be measured by the weights, not by what little happens."""
    rng = np.random.default_rng(4)
    some = KINDS[kind](6, rng)
    q, v = (size * x for x in state(6, rng))
    a, F, _ = fifty_digits(some, q, v, G)
    found = solution.solve(some, q, v, G)
    assert np.abs(found.acceleration - a.astype(float)).max() < 1e-15 * max(9.81 / some.l.min(), np.abs(a).max())
    assert error(found.force, F) < 2e-15


@pytest.mark.parametrize("size", [1e-9, 1e-13, 1e-17, 1e-21])
def test_long_chain_close_to_rest_swings_in_proportion(size):
    some, (q, v) = alike(300, 0.01), state(300, np.random.default_rng(4))
    one, two = (solution.solve(some, t * size * q, t * size * v, G).acceleration for t in (1, 2))
    np.testing.assert_allclose(two, 2 * one, atol=1e-12 + 1e-6 * size * 9.81)


@pytest.mark.parametrize("radius", [0.0, 0.01])
def test_forces_that_cancel_the_field_leave_no_reactions(radius):
    some, (q, _) = alike(30, radius), state(30, np.random.default_rng(0))
    found = solution.solve(some, q, np.zeros((30, 2)), TILTED, force=-some.m[:, None] * TILTED)
    np.testing.assert_allclose(found.force, 0, atol=1e-13)
    np.testing.assert_allclose(found.acceleration, 0, atol=1e-12)


def test_nothing_acts_nothing_happens():
    found = solution.solve(alike(4, 0.1), np.full((4, 2), 0.3), np.zeros((4, 2)), np.zeros(3))
    np.testing.assert_array_equal(found.acceleration, 0)
    np.testing.assert_array_equal(found.force, 0)


@laws
@given(seeds)
def test_power_of_torques_and_pushes_is_the_change_of_energy(seed):
    n, rng = 5, np.random.default_rng(seed)
    some, (q, v) = alike(n, 0.3), state(n, rng)
    torque, force, moment = rng.normal(size=(n, 2)), rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
    a = solution.solve(some, q, v, TILTED, torque=torque, force=force, moment=moment).acceleration
    moving = kinematics.motion(some, q, v)
    spin = np.einsum("nij,nj->ni", moving.frames, moving.omega)
    power = (torque * v).sum() + (force * moving.centre_velocities).sum() + (moment * spin).sum()
    h = 1e-5
    ahead, back = (sum(energy(some, q + t * v, v + t * a, TILTED)) for t in (h, -h))
    scale = energy(some, q, v, TILTED)[0] * (1 + np.abs(v).max() + np.abs(a).max())
    assert (ahead - back) / (2 * h) == pytest.approx(power, abs=1e-8 * scale)


def test_batch_equals_single_states():
    n, rng = 7, np.random.default_rng(5)
    some = mixed(n, rng, thin=0.3)
    q, v = (rng.uniform(-1, 1, (2, 3, n, 2)) for _ in range(2))
    field = rng.normal(size=(2, 3, 3))
    found = solution.solve(some, q, v, field)
    kinetic, potential = energy(some, q, v, G)
    moving, at = kinematics.motion(some, q, v), kinematics.positions(some, q)
    for i in np.ndindex(2, 3):
        single = solution.solve(some, q[i], v[i], field[i])
        np.testing.assert_allclose(found.acceleration[i], single.acceleration, rtol=1e-11)
        np.testing.assert_allclose(found.wrench[i], single.wrench, rtol=1e-11, atol=1e-11 * abs(single.wrench).max())
        np.testing.assert_allclose((kinetic[i], potential[i]), energy(some, q[i], v[i], G), rtol=1e-14)
        for ours, alone in zip(moving, kinematics.motion(some, q[i], v[i]), strict=True):
            np.testing.assert_allclose(ours[i], alone, rtol=0, atol=1e-13 * abs(alone).max())
        np.testing.assert_array_equal(at.tips[i], moving.tips[i])


def test_velocities_are_the_rates_of_positions():
    n, rng = 6, np.random.default_rng(6)
    some, (q, v) = mixed(n, rng), state(n, rng)
    moving, h = kinematics.motion(some, q, v), 1e-6
    ahead, back = (kinematics.positions(some, q + t * v) for t in (h, -h))
    np.testing.assert_allclose(moving.tip_velocities, (ahead.tips - back.tips) / (2 * h), atol=1e-7)
    np.testing.assert_allclose(moving.centre_velocities, (ahead.centres - back.centres) / (2 * h), atol=1e-7)


def test_memory_grows_with_the_rods_only():
    def peak(n):
        some, (q, v) = alike(n, 0.05), state(n, np.random.default_rng(0))
        solution.solve(some, q, v, G)
        tracemalloc.start()
        solution.solve(some, q, v, G)
        size = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return size

    assert peak(4000) < 2.2 * peak(2000) < 20e6


def test_orientation_keeps_its_digits_down_a_long_chain():
    q, _ = state(2000, np.random.default_rng(2))
    B = kinematics.positions(alike(2000, 0.1), q).frames
    np.testing.assert_allclose(B.swapaxes(1, 2) @ B, np.broadcast_to(np.eye(3), B.shape), atol=2e-13)


def test_nan_passes_through():
    q = np.full((3, 2), 0.1)
    q[1, 0] = np.nan
    assert np.isnan(solution.solve(alike(3, 0.1), q, np.zeros((3, 2)), G).acceleration).all()


def test_a_rod_that_cannot_be_is_named():
    with pytest.raises(InputError, match="rod 2"):
        ChainInertia([1, 1], [1, 1], [1, 1], [0.1, 0.1], [0.1, 0.2], [0.1, 0.0])
