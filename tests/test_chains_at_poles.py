"""Chains of thin rods through the pole, where their angles are singular."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from pendpin.equations.exact import direction, direction_rate, planar
from pendpin.model.build import build
from test_chains import G, chain_of, hanging

# --- thin rods through the pole -------------------------------------------------------------------------------------


def test_a_thin_rod_through_the_pole_is_the_exact_swing() -> None:
    """phi swings through pi/2 and on through full turns: 1e-9 after 20 s, no NaN, the steps of the turned swing."""
    rod = chain_of(pp.Rod(length=1.0, mass=1.0))
    through, turned = (
        pp.simulate(hanging(rod, *state, duration=20.0, tolerance=1e-13, samples=401))
        for state in (([0.0, 0.3], [0.0, 9.0]), ([0.3, 0.0], [9.0, 0.0]))
    )
    exact = planar(0.3, 9.0, 2 / 3, G, through.t)
    assert exact[-1] > 20 * np.pi
    assert np.abs(through.q[:, 1] - exact).max() < 1e-9
    assert np.abs(through.q[:, 0]).max() == 0
    assert np.isfinite(through.a).all()
    assert through.stats.steps < 3 * turned.stats.steps


@given(
    theta=st.floats(-7, 7),
    pole=st.sampled_from([-1.5, -0.5, 0.5, 1.5]),
    away=st.floats(-12, -0.5),
    rates=st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
    length=st.floats(0.1, 10),
    payload=st.sampled_from([0.0, 3.0]),
)
def test_a_thin_rod_accelerates_at_its_pole_as_lagrange_says(
    theta: float, pole: float, away: float, rates: tuple[float, float], length: float, payload: float
) -> None:
    """theta'' = (2 theta' phi' sin(phi) - w sin(theta)) / cos(phi), however near to the pole; each to 64 roundings.

    A product of few factors and sums of few products: their terms are counted with their sizes.
    """
    rod = pp.Rod(length=length, mass=1.3, payload=payload)
    scene = pp.Scene(model=chain_of(rod), effects=[pp.effects.Gravity()], duration=1.0)
    q, v = np.array([theta, pole * np.pi + 10**away]), np.array(rates)
    m, h, inertia, *_ = rod.properties
    w = m * h * G / (inertia + m * h * h)
    (s, c), (s1, c1) = ((np.sin(x), np.cos(x)) for x in (q[1], q[0]))
    turn, pull = 2 * v[0] * v[1] * s / c, -w * s1 / c
    along = -(v[0] ** 2) * s * c, -w * c1 * s
    a = pp.bind(scene).acceleration(0.0, q, v)
    for value, terms in zip(a, ((turn, pull), along), strict=True):
        assert abs(value - sum(terms)) <= 64 * np.finfo(float).eps * (sum(map(abs, terms)) + abs(v[0] ** 2) + w)


@pytest.mark.slow
def test_a_thin_chain_whose_middle_rod_goes_through_the_pole() -> None:
    """Against equations in directions, written down here on their own (Lagrange with multipliers): 1e-9 after 10 s.

    The middle rod whirls under a heavy first one, which keeps the motion regular: a chaotic one has no such digits.
    """
    rods = [pp.Rod(length=1.0, mass=100.0), pp.Rod(length=0.5, mass=0.1), pp.Rod(length=0.3, mass=0.02)]
    q, v = [0.0, 0.1, 0.0, 0.4, 0.0, 0.05], [0.0, 0.2, 0.0, 12.0, 0.0, 0.3]
    settings = {"duration": 10.0, "tolerance": 3e-14, "samples": 601}
    run = pp.simulate(hanging(chain_of(*rods), q, v, **settings))
    assert np.abs(run.q[:, 3]).max() > 10 * np.pi  # through the pole and round, many times
    assert np.isfinite(run.a).all()
    ends = directions_chain(rods, run.q[0], run.v[0], run.t[::150])
    assert np.abs(run.tips[::150] - ends).max() < 1e-9
    turned = pp.simulate(
        hanging(chain_of(*rods), *(np.reshape(x, (3, 2))[:, ::-1].ravel() for x in (q, v)), **settings)
    )
    assert run.stats.steps < 3 * turned.stats.steps


def directions_chain(rods: list[pp.Rod], q: np.ndarray, v: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Tips (n, rods, 3) in W of thin rods, from d/dt of the kinetic energy in directions, multipliers for |d| = 1."""
    from scipy.integrate import solve_ivp

    n, length = len(rods), np.array([rod.length for rod in rods])
    mass = np.array([rod.mass for rod in rods])
    beyond = np.array([mass[i + 1 :].sum() for i in range(n)])
    A = np.zeros((n, n))  # T = sum A_ij d_i' . d_j' / 2
    for i in range(n):
        A[i, i] = (mass[i] / 3 + beyond[i]) * length[i] ** 2
        for j in range(i):
            A[i, j] = A[j, i] = (mass[i] / 2 + beyond[i]) * length[i] * length[j]
    weight = (mass / 2 + beyond) * length

    def rates(_, y):
        d, omega = y.reshape(2, n, 3)
        w = np.cross(omega, d)
        system = np.zeros((4 * n, 4 * n))
        right = np.zeros(4 * n)
        system[: 3 * n, : 3 * n] = np.kron(A, np.eye(3))
        for i in range(n):
            system[3 * i : 3 * i + 3, 3 * n + i] = system[3 * n + i, 3 * i : 3 * i + 3] = d[i]
            right[3 * i + 2], right[3 * n + i] = -weight[i] * G, -w[i] @ w[i]
        bend = np.linalg.solve(system, right)[: 3 * n]
        return np.concatenate([w.ravel(), np.cross(d, bend.reshape(n, 3)).ravel()])

    d, w = start_directions(q, v)
    start = np.concatenate([d.ravel(), np.cross(d, w).ravel()])
    y = solve_ivp(rates, (t[0], t[-1]), start, "DOP853", t, rtol=3e-14, atol=1e-14).y
    return np.cumsum(length[:, None] * y.T[:, : 3 * n].reshape(-1, n, 3), 1)


def start_directions(q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions of the rods and their rates in W, by Pinocchio's kinematics of the start."""
    n = len(q) // 2
    model = build(chain_of(pp.Rod(length=1.0, mass=1.0, radius=0.1), copies=n)).pin
    data = model.createData()
    pin.forwardKinematics(model, data, q, v)
    d, w = np.empty((n, 3)), np.empty((n, 3))
    for i in range(n):
        R = data.oMi[2 * i + 2].rotation
        d[i], w[i] = -R[:, 2], np.cross(R @ data.v[2 * i + 2].angular, -R[:, 2])
    return d, w


def test_exact_directions_are_pendpins() -> None:
    """The test's own formulas for one rod's direction and rate say the same as Pinocchio's kinematics."""
    q, v = np.array([0.3, 0.5]), np.array([1.1, -0.7])
    d, w = start_directions(q, v)
    assert np.allclose(d[0], direction(q), atol=1e-15)
    assert np.allclose(w[0], direction_rate(q, v), atol=1e-15)
