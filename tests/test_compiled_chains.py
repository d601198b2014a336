"""Compiled equations of chains are loops over rods: one code for any number of them, with the digits of the recursion."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import j0, jn_zeros

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Compiled
from pendpin.engines.machine.passes import recorded_by_rod
from pendpin.engines.machine.tape import Tape
from pendpin.equations.base import exact
from pendpin.equations.recursion import accelerations
from pendpin.equations.trees import inward, outward, total
from pendpin.model.build import build
from test_compiled import rates
from test_recursion import GRAVITY

pytest.importorskip("llvmlite", reason="llvmlite is not installed: pip install llvmlite")

AIR = fx.Drag(wind=(1.0, 2.0, 0.0), gust=(0.0, 1.0, 0.0), frequency=2.0, buoyancy=True)
MOVING = (fx.Support(amplitude=(0.1, 0.0, 0.05), frequency=3.0), fx.Rotation(rate=(0.1, 0.2, 0.3)))
SOME_JOINTS = (
    fx.Spring(stiffness=3.0, rest=0.1, joints=("theta_2", "phi_3")),
    fx.Viscous(coefficient=0.1, joints=("phi_1", "phi_4")),
    fx.Motor(joint="theta_3", torque=0.2, amplitude=0.5, frequency=2.0),
    fx.Push(link="rod_2", force=(1.0, 0.5, 0.0), amplitude=(0.0, 1.0, 0.0), frequency=4.0, point=0.2),
    fx.Push(link="rod_4", torque=(0.1, 0.0, 0.2)),
)


def chain(n: int, seed: int | None = None, thin: bool = False) -> pp.Chain:
    """n rods, 1 m and 1 kg in all; with a seed each another one."""
    random = np.random.default_rng(seed)
    length, mass, radius = np.ones((3, n)) / n
    if seed is not None:
        length, mass, radius = np.exp(random.uniform(-0.7, 0.7, (3, n))) / n
    radius = 0.01 * radius * (not thin)
    return pp.Chain(rods=[pp.Rod(length=x, mass=m, radius=r) for x, m, r in zip(*(length, mass, radius), strict=True)])


def state(n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    return random.uniform(-1.2, 1.2, 2 * n), random.uniform(-3, 3, 2 * n)


def compiled(model: pp.Chain, effects: tuple, form: str = "angles") -> Dynamics:
    dynamics = Dynamics(build(model), effects, "compiled", form)  # type: ignore[arg-type]
    assert isinstance(dynamics.engine, Compiled)
    return dynamics


# --- one code -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("thin", [False, True])
def test_one_code_for_any_number_of_rods(thin: bool) -> None:
    """Four rods and a thousand others have the same equations, recorded and compiled once."""
    form = "directions" if thin else "angles"
    few, many = (compiled(chain(n, seed=n, thin=thin), (fx.Gravity(), AIR), form).engine for n in (4, 1000))
    assert few.equations is many.equations  # type: ignore[attr-defined]


@law(20)
@given(st.integers(2, 40), st.integers(0, 10**6), st.booleans())
def test_any_number_of_any_rods(n: int, seed: int, thin: bool) -> None:
    """The same rates as by the hand-derived equations, with air, a moving support and a turning world."""
    effects, form = (fx.Gravity(), AIR, *MOVING), "directions" if thin else "angles"
    own = compiled(chain(n, seed, thin), effects, form)
    plain = Dynamics(own.model, effects, "chain", form)  # type: ignore[arg-type]
    y = own.engine.pack(*state(n, seed))
    expected, found = rates(plain, 0.3, y), rates(own, 0.3, y)
    assert np.abs(found - expected).max() < 3e-12 * n * np.abs(expected).max()


def test_effects_on_some_joints_and_rods() -> None:
    """What acts on some joints or rods has a share of 0 on the others."""
    for effects in ((effect,) for effect in SOME_JOINTS):
        own = compiled(chain(5, seed=2), (fx.Gravity(), *effects))
        y = own.engine.pack(*state(5, 3))
        expected = rates(Dynamics(own.model, (fx.Gravity(), *effects), "chain"), 0.3, y)
        assert np.abs(rates(own, 0.3, y) - expected).max() < 1e-11 * np.abs(expected).max()


def test_a_users_law_is_compiled_for_all_rods_at_once() -> None:
    """It may look at several joints: here each is coupled to all others."""

    class Coupled(fx.JointEffect):
        kind: str = "coupled"

        def torques(self, t, q, v, xp=np):
            return -0.1 * (q - q.sum() / len(q))

    own = compiled(chain(3), (fx.Gravity(), Coupled()))
    y = own.engine.pack(*state(3, 4))
    expected = rates(Dynamics(own.model, (fx.Gravity(), Coupled()), "chain"), 0.0, y)
    assert np.abs(rates(own, 0.0, y) - expected).max() < 1e-11 * np.abs(expected).max()
    with pytest.raises(pp.InputError, match="longer chains with built-in effects"):
        compiled(chain(101), (fx.Gravity(), Coupled()))


# --- digits ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("n", "seed"), [(5, None), (20, None), (40, None), (20, 3)])
def test_compiled_vs_50_digits(n: int, seed: int | None) -> None:
    """Fused operations in another order: no more than a few times the error of the same recursion in NumPy, or 1e-13."""
    own = compiled(chain(n, seed), (fx.Gravity(),))
    assert own.model.chain is not None
    tree, errors = own.model.tree, []
    for trial in range(3):
        q, v = state(n, trial)
        reference = np.array(accelerations(tree, q, v, GRAVITY, xp=exact(50)), float)
        numpy = accelerations(tree, q, v, GRAVITY)
        machine = rates(own, 0.0, np.concatenate([q, v]))[2 * n :]
        errors.append([np.abs(x - reference).max() / np.abs(reference).max() for x in (numpy, machine)])
    by_numpy, by_machine = np.max(errors, 0)
    assert by_machine < max(5 * by_numpy, 1e-13)


@pytest.mark.parametrize("thin", [False, True])
@pytest.mark.parametrize("n", [1000, pytest.param(10_000, marks=pytest.mark.slow)])
def test_a_hanging_chain_is_a_rope(n: int, thin: bool) -> None:
    """The first four modes by Rayleigh's quotient: the zeros of Bessel's function, up to what n rods differ from a rope.

    That is c / n² of the frequency, with c = 0.031, 1.03, 4.5, 11.9 (measured from 100 rods on). A deviation of 1e-12 would
    be seen at 10,000 rods; the hand-derived route gives the same to 1e-12.
    """
    own = compiled(chain(n, thin=thin), (fx.Gravity(acceleration=1.0),), "directions" if thin else "angles")
    plain = Dynamics(own.model, (fx.Gravity(acceleration=1.0),), "chain", "directions" if thin else "angles")
    for mode, excess in zip(range(4), (0.0306, 1.032, 4.49, 11.92), strict=True):
        omega = jn_zeros(0, mode + 1)[-1] / 2
        shape = 1e-6 * j0(2 * omega * np.sqrt(1 - np.arange(n + 1) / n))
        ratio, other = (_frequency(dynamics, np.diff(shape) * n, thin) / omega - 1 for dynamics in (own, plain))
        assert abs(ratio * n**2 / excess - 1) < 0.01
        assert abs(ratio - other) < 1e-12


def _frequency(dynamics: Dynamics, angles: np.ndarray, thin: bool) -> float:
    """Rayleigh's quotient in rad/s of small angles (n,) of rods 1/n long from the vertical, from their accelerations."""
    n, q = len(angles), np.zeros(2 * len(angles))
    q[::2] = np.diff(angles, prepend=0.0)
    rate = rates(dynamics, 0.0, dynamics.engine.pack(q, 0 * q))
    turning = -rate[3 * n :: 3] if thin else np.cumsum(rate[2 * n :: 2])
    moved, pulled = (np.cumsum(x) / n - x / (2 * n) for x in (angles, turning))
    mass, inertia = 1 / n, 1 / (12 * n**3)
    power = -mass * moved @ pulled - inertia * angles @ turning
    return float(np.sqrt(power / (mass * moved @ moved + inertia * angles @ angles)))


def test_a_thousand_rods_vs_the_banded_route() -> None:
    """Far from rest, at random angles and rates: what both lose is what the condition of such a chain takes."""
    for thin in (False, True):
        form = "directions" if thin else "angles"
        own = compiled(chain(1000, thin=thin), (fx.Gravity(),), form)
        plain = Dynamics(own.model, (fx.Gravity(),), "chain", form)  # type: ignore[arg-type]
        y = own.engine.pack(*(x / 10 for x in state(1000, 1)))
        expected, found = rates(plain, 0.0, y), rates(own, 0.0, y)
        assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


# --- passes ---------------------------------------------------------------------------------------------------------


def test_what_stays_equal_is_carried_once() -> None:
    """A matrix that stays symmetric has six cells, one that stays diagonal three, and what never changes none."""
    tape = Tape()
    xp, x = recorded_by_rod(tape), tape.state(3, 1)
    inward(lambda i, M: (M, None), [np.outer(x, x)], [-1], xp)
    outward(lambda i, M: (M + np.diag(x), None), np.eye(3), [-1], xp)
    outward(lambda i, a: (a, a), np.ones(3), [-1], xp)
    assert [len(one.cells) for one in tape.passes] == [6, 3, 0]
    assert [one.inward for one in tape.passes] == [True, False, False]


def test_only_parameters_and_their_products_have_a_truth() -> None:
    """A sum of them may be 0, and nothing is known of a state before it is computed."""
    tape = Tape()
    (x, y), p, q = tape.state(2), tape.parameter(0), tape.parameter(1)
    assert all((p, q, p * q, p * q * p, p**2))
    for term in (
        x,
        -x,
        x * y,
        p * x,
        x * p * q,
        p + q,
        p - q,
        p / q,
        2.0 * (p + q),
        tape.record("sin", p),
        tape.term("time"),
    ):
        with pytest.raises(TypeError, match="may not ask for one"):
            bool(term)


def test_passes_of_numbers() -> None:
    """Outward sums from the base, inward ones from the tips, on a tree with two branches."""
    parents = [-1, 0, 1, 0]
    assert outward(lambda i, above: (above + i, above), 10, parents) == [10, 10, 11, 10]
    assert inward(lambda i, hanging: (hanging, hanging), [1, 2, 3, 4], parents) == [10, 5, 3, 4]
    assert total(np.arange(4)) == 6


# --- what a run imports ------------------------------------------------------------------------------------------------

_WITHOUT = """
import sys
sys.modules.update(dict.fromkeys({absent}))
import pendpin as pp
run = pp.simulate(pp.Scene.model_validate_json(sys.stdin.read()))
run.summary()
sys.stdout.buffer.write(run.q.tobytes() + run.wrench.tobytes())
"""


@pytest.mark.parametrize("thin", [False, True])
def test_a_compiled_chain_needs_neither_pinocchio_nor_scipy(thin: bool) -> None:
    """The motion, the wrenches and the summary of a run, bit for bit: importing these takes longer than most runs."""
    pytest.importorskip("CyRK", reason="CyRK is not installed: pip install CyRK")
    scene = pp.Scene(
        model=chain(6, seed=1, thin=thin),
        start=pp.Start(positions={"theta_1": 0.5}),
        effects=(fx.Gravity(),),
        duration=0.3,
    )
    code = _WITHOUT.format(absent=["pinocchio", "scipy"])
    alone = subprocess.run([sys.executable, "-c", code], input=scene.model_dump_json().encode(), capture_output=True)
    here = pp.simulate(scene)
    assert alone.stdout == here.q.tobytes() + here.wrench.tobytes(), alone.stderr.decode()[-500:]
