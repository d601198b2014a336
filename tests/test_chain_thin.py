"""Chains of thin rods: the equations in directions, and angles read back from directions through cos(phi) = 0."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from chain_energies import energy, thin_energy
from fifty_digits import TILTED, G, alike, error, fifty_digits, mixed, point_masses, state
from laws import law
from pendpin.equations import recursion
from pendpin.equations.chain import kinematics, solution, system, thin
from pendpin.errors import InputError

seeds = st.integers(0, 2**32 - 1)
laws = law(25)


def about_z(angle):
    return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])


@laws
@given(seeds, st.sampled_from((1, 3, 10)), st.booleans(), st.booleans())
def test_one_state_of_thin_rods_vs_the_chain_equations(seed, n, near_poles, windy):
    """`Dynamics.acceleration` takes ABA where few rods are away from their poles, and elsewhere the chain equations.

    The largest of 2,400 differences where ABA is taken was 3e-12 of the largest acceleration, at lengths up to 100 : 1.
    """
    rng = np.random.default_rng(seed)
    rods = [pp.Rod(length=length, mass=mass) for length, mass in rng.uniform(0.3, 1.0, (n, 2))]
    drag = [pp.effects.Drag(diameter=0.05, wind=(2.0, 1.0, 0.0))] if windy else []
    dynamics = pp.bind(pp.Scene(model=pp.Chain(rods=rods), effects=[pp.effects.Gravity(), *drag]))
    q, v = rng.uniform(-3, 3, (2, 2 * n))
    q[1::2] = rng.uniform(-1.5, 1.5, n) / np.sqrt(n)
    q[1] = np.pi / 2 - 1e-4 if near_poles else q[1]
    found = dynamics.acceleration(0.3, q, v)
    expected = dynamics.engine.evaluate(np.array([0.3]), q[None], v[None]).acceleration[0]
    assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()
    again = found.copy()
    dynamics.acceleration(0.3, v, q)
    np.testing.assert_array_equal(found, again)


@laws
@given(seeds, st.sampled_from((1, 8)))
def test_thin_chain_in_directions_vs_angles(seed, n):
    """A single rod goes by a closed form in angles, and by the system in directions."""
    rng = np.random.default_rng(seed)
    some, (q, v) = mixed(n, rng, thin=1.0), state(n, rng)
    force = rng.normal(size=(n, 3))
    d, rate = thin.directions(q, v)
    moment = np.cross(d, rng.normal(size=(n, 3)))
    there = thin.solve(some, d, rate, TILTED, force=force, moment=moment)
    here = solution.solve(some, q, v, TILTED, force=force, moment=moment)
    frames = kinematics.positions(some, q).frames
    F = np.einsum("nij,ni->nj", frames, there.force)
    np.testing.assert_allclose(F, here.force, rtol=0, atol=1e-12 * abs(F).max())
    np.testing.assert_array_equal(here.Mc, 0)
    reading = thin.read(d[None], rate[None], there.acceleration[None], q)
    np.testing.assert_allclose(reading.q[0], q, atol=1e-13)
    np.testing.assert_allclose(reading.v[0], v, atol=1e-9)
    scale = abs(here.acceleration).max()
    np.testing.assert_allclose(reading.a[0], here.acceleration, atol=1e-9 * scale)
    energies = energy(some, q, v, G)
    np.testing.assert_allclose(thin_energy(some, d, rate, G), energies, rtol=1e-11)


@pytest.mark.parametrize("pole", [np.pi / 2, -np.pi / 2])
def test_thin_chain_is_regular_at_the_pole(pole):
    """The middle one of three rods at cos(phi) = 0: the same as the whole turned about the vertical."""
    some, rng = alike(3, 0.0), np.random.default_rng(8)
    q, v = state(3, rng)
    q[1, 1] = pole
    d, rate = thin.directions(q, v)
    here = thin.solve(some, d, rate, G)
    turn = about_z(0.9)
    turned = thin.solve(some, d @ turn.T, rate @ turn.T, G)
    np.testing.assert_allclose(turned.acceleration, here.acceleration @ turn.T, atol=1e-13)
    np.testing.assert_allclose(turned.force, here.force @ turn.T, atol=1e-13)
    F = np.einsum("nij,ni->nj", kinematics.positions(some, q).frames, here.force)
    np.testing.assert_allclose(solution.solve(some, q, v, G).force, F, atol=1e-13)


def test_thin_solution_ignores_what_leads_off_the_sphere():
    some, rng = alike(3, 0.0), np.random.default_rng(9)
    d, rate = thin.directions(*state(3, rng))
    straight, off = thin.solve(some, d, rate, G), thin.solve(some, 1.01 * d, rate + 0.1 * d, G)
    np.testing.assert_allclose(off.acceleration, straight.acceleration, atol=1e-12)
    np.testing.assert_allclose((straight.acceleration * d).sum(-1), -(rate**2).sum(-1), atol=1e-13)


@pytest.mark.parametrize("n", [10, 50, 200])
def test_the_recursion_keeps_the_digits_of_long_straight_chains(n):
    """Where rods hang in one line, an antisymmetric part of the articulated inertias would grow threefold a rod."""
    some, q = alike(n, 0.0), np.zeros((n, 2))
    q[0] = 0.8, 0.3
    d, rate = thin.directions(q, np.zeros_like(q))
    expected = np.cross(d, thin.solve(some, d, rate, G).acceleration)
    found, _ = recursion.thin_turning(some, d, rate, G)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14 * np.sqrt(n) * 10 * np.abs(expected).max())


def path(n, rng, times):
    """SmoothLoop angles, their rates and accelerations (k, n, 2), that go through several poles and turns."""
    amplitude, speed, phase = rng.uniform(0.5, 2.5, (3, n, 2))
    angle = speed * times[:, None, None] + phase
    return amplitude * np.sin(angle), amplitude * speed * np.cos(angle), -amplitude * speed**2 * np.sin(angle)


@laws
@given(seeds)
def test_angles_are_read_back_along_a_path(seed):
    """Directions of a path, and its second derivatives by differences; compared away from the poles."""
    rng, times, h = np.random.default_rng(seed), np.linspace(0, 4, 1600), 1e-5
    q, v, a = path(2, rng, times)
    d, rate = thin.directions(q, v)
    after, before = (thin.directions(q + t * v + t * t / 2 * a, v + t * a)[1] for t in (h, -h))
    found = thin.read(d, rate, (after - before) / (2 * h), q[0])
    clear = np.abs(np.cos(q[..., 1])).min(1) > 0.05
    same_pair = (
        np.abs(np.exp(1j * (found.q - q)) - 1).max((1, 2)) < 1e-9
    )  # close by a pole the other pair may be nearer
    keep = clear & same_pair
    assert keep.any()
    np.testing.assert_allclose(found.v[keep], v[keep], atol=1e-9)
    np.testing.assert_allclose(found.a[keep], a[keep], atol=1e-3)
    np.testing.assert_allclose(thin.directions(found.q, found.v)[0], d, atol=1e-13)
    assert np.abs(np.diff(found.q[:, 0], axis=0)).max() < 0.5 * np.pi + 1e-9


@pytest.mark.parametrize("theta", [0.0, 0.8])
def test_full_turns_through_the_pole_are_read_as_such(theta):
    phi = np.linspace(-0.25 * np.pi, 4.75 * np.pi, 241)  # hits every pole on the way exactly
    q = np.stack([np.full_like(phi, theta), phi], -1)[:, None]
    v = np.broadcast_to([0.0, 2.0], q.shape)
    d, rate = thin.directions(q, v)
    found = thin.read(d, rate, -4 * d, q[0])
    np.testing.assert_allclose(found.q, q, atol=1e-12)
    np.testing.assert_allclose(found.v, v, atol=1e-7)
    np.testing.assert_allclose(found.a[np.abs(np.cos(phi)) > 1e-3], 0, atol=1e-9)


def test_a_rod_at_rest_at_the_pole_keeps_the_angle_before():
    q = np.array([[[0.3, 1.5]], [[0.3, np.pi / 2]], [[0.3, np.pi / 2]]])
    d, rate = thin.directions(q, np.zeros_like(q))
    d[1:] = [1.0, 0.0, 0.0]
    found = thin.read(d, rate, np.zeros_like(d), q[0, :])
    np.testing.assert_allclose(found.q, q, atol=1e-12)
    np.testing.assert_array_equal(found.v, 0)


@pytest.mark.parametrize("distance", [1e-2, 1e-5, 0.0])
def test_thin_rods_under_torques_at_the_pole_vs_fifty_digits(distance):
    """The moment grows as 1/cos(phi): the elimination breaks down, the direct solution does not."""
    some, rng = alike(4, 0.0), np.random.default_rng(0)
    (q, v), torque = state(4, rng), rng.normal(size=(4, 2))
    q[-1, 1] = np.pi / 2 - distance
    a, F, Mc = fifty_digits(some, q, v, G, torque)
    found = solution.solve(some, q, v, G, torque=torque)
    assert max(error(found.acceleration, a), error(found.force, F), error(found.Mc, Mc)) < 3e-15


def test_point_masses_in_directions_vs_direct_solution(monkeypatch):
    rng = np.random.default_rng(13)
    some = point_masses(20, rng)
    d, rate = thin.directions(*state(20, rng))
    usual = thin.solve(some, d, rate, G)
    monkeypatch.setattr(system, "Eliminated", system.Direct)
    direct = thin.solve(some, d, rate, G)
    np.testing.assert_allclose(direct.force, usual.force, atol=1e-13 * abs(usual.force).max())
    np.testing.assert_allclose(np.cross(usual.force, d), 0, atol=1e-13 * abs(usual.force).max())


def test_a_thick_rod_has_no_place_in_directions():
    with pytest.raises(InputError, match="axial inertia"):
        thin.solve(alike(2, 0.1), np.eye(3)[:2], np.zeros((2, 3)), G)
