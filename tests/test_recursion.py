"""Laws of the recursion on every number type: floats against Pinocchio, 50 digits against 80, symbols against floats.

Differences are bounded by rounding: rounding.py sums the terms that enter. Those of compiled symbols are taken in
the norm of the mass matrix's diagonal and measured in eps times its condition number.
"""

import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heyoka_symbols import symbols
from laws import law
from pendpin.equations.base import exact
from pendpin.equations.recursion import accelerations, wrenches
from pendpin.equations.trees import Tree, motions, motions_in_links
from pendpin.ground.arrays import EPS
from pendpin.model.bodies import tree_of
from rounding import ROUNDINGS, terms

GRAVITY = np.array([0.0, 0.0, -9.81])  # m/s²
needs_heyoka = pytest.mark.skipif(find_spec("heyoka") is None, reason="heyoka is not installed: pip install heyoka")


# --- models and states ----------------------------------------------------------------------------------------------


def random_model(n, seed):
    """Joints of both kinds about any axes, branching at random; branch by branch, as Pinocchio's crba needs it."""
    random = np.random.default_rng(seed)
    model, path = pin.Model(), [0]
    model.gravity.linear = random.normal(size=3) * 9.81
    for i in range(n):
        axis = random.normal(size=3)
        kind = pin.JointModelPrismaticUnaligned if random.random() < 0.3 else pin.JointModelRevoluteUnaligned
        path = path[: random.integers(max(1, len(path) - 2), len(path) + 1)]
        joint = model.addJoint(path[-1], kind(*axis / np.linalg.norm(axis)), random_place(random), f"joint_{i}")
        path = [*path, joint]
        sums = random.uniform(0.05, 1, 3)
        R = random_place(random).rotation
        inertia = R @ np.diag(sums.sum() - sums) @ R.T
        body = pin.Inertia(10 ** random.uniform(-1, 1), 0.5 * random.normal(size=3), inertia)
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
    return model


def random_place(random):
    return pin.SE3(pin.exp3(2 * random.normal(size=3)), random.normal(size=3))


def chain(rods, mixed=None):
    """Rods of 1 m, 1 kg, radius 1 cm on universal joints; mixed, a seed, makes each another (mass ratios to 1e4)."""
    random = np.random.default_rng(mixed)
    length, m, r = np.ones(rods), np.ones(rods), np.full(rods, 0.01)
    if mixed is not None:
        length, m, r = 10 ** random.uniform([[-1], [-2], [-3]], [[1], [2], [-1]], (3, rods))
    n, vectors, phi = 2 * rods, np.zeros((2, 2 * rods, 3)), slice(1, None, 2)
    (translations, coms), masses, inertias = vectors, np.zeros(n), np.zeros((n, 3, 3))
    translations[2::2, 2], masses[phi], coms[phi, 2] = -length[:-1], m, -length / 2
    inertias[phi, 0, 0] = inertias[phi, 1, 1] = m * (3 * r**2 + length**2) / 12
    inertias[phi, 2, 2] = m * r**2 / 2
    axes = np.tile([[-1.0, 0, 0], [0, -1.0, 0]], (rods, 1))
    parents, kinds = tuple(range(-1, n - 1)), ("revolute",) * n
    return Tree(parents, kinds, axes, np.tile(np.eye(3), (n, 1, 1)), translations, masses, coms, inertias)


def state(n, seed):
    random = np.random.default_rng(seed)
    return random.uniform(-np.pi, np.pi, n), random.normal(size=n)


def mass_matrix(tree, q, xp=np):
    """Column by column from the wrenches, projected on the joints' axes."""
    zero = np.zeros(len(q))
    return np.stack([torques(tree, wrenches(tree, q, zero, e, np.zeros(3), xp=xp), xp) for e in np.eye(len(q))], -1)


def torques(tree, wrench, xp=np):
    turning = np.array([kind == "revolute" for kind in tree.kinds])[:, None]
    axes = xp.asarray(tree.axes)
    return np.sum(axes * np.where(turning, wrench[..., 3:], wrench[..., :3]), -1) / xp.sqrt(np.sum(axes * axes, -1))


def condition(tree, q):
    """The condition number of the mass matrix scaled to a unit diagonal, and that scale."""
    M = mass_matrix(tree, q)
    scale = np.sqrt(np.diag(M))
    return np.linalg.cond(M / np.outer(scale, scale)), scale


def bound(model):
    """Of the terms that enter: roundings, for each joint that they go through."""
    return ROUNDINGS * model.nv * EPS


def mass_terms(model, q):
    """The terms of the mass matrix (nv, nv): of the wrenches at unit accelerations, without gravity."""
    weightless, zero = model.copy(), np.zeros(model.nv)
    weightless.gravity.linear = np.zeros(3)
    slides = np.array(["P" in joint.shortname() for joint in list(model.joints)[1:]])
    columns = [terms(weightless, q, zero, e) for e in np.eye(model.nv)]
    size = np.stack([np.where(slides, column.force, column.moment) for column in columns], -1)
    return np.maximum(size, size.T)


trees = st.builds(random_model, st.integers(1, 8), st.integers(0, 10**6))
seeds = st.integers(0, 10**6)


def test_what_joints_move_is_pinocchios():
    """Places, velocities and spins of branching trees that turn and slide, in the base frame and in each link's."""
    for seed in range(5):
        model = random_model(7, seed)
        (q, v), data = state(model.nv, seed), model.createData()
        pin.forwardKinematics(model, data, q, v)
        places = list(data.oMi)[1:]
        rates = {
            frame: np.array([pin.getVelocity(model, data, i, frame).vector for i in range(1, model.njoints)])
            for frame in (pin.LOCAL_WORLD_ALIGNED, pin.LOCAL)
        }
        origin, axes, velocity, spin = motions(tree_of(model), q, v)
        close = {"rtol": 1e-12, "atol": 1e-12}  # of numbers of size 1 to 10, through up to seven joints
        np.testing.assert_allclose(origin, [place.translation for place in places], **close)
        np.testing.assert_allclose(axes, [place.rotation for place in places], **close)
        np.testing.assert_allclose(np.concatenate([velocity, spin], 1), rates[pin.LOCAL_WORLD_ALIGNED], **close)
        origin, velocity, spin, into_links = motions_in_links(tree_of(model), q, v)
        turned = [place.rotation.T @ place.translation for place in places]
        np.testing.assert_allclose(origin, turned, **close)
        np.testing.assert_allclose(np.concatenate([velocity, spin], 1), rates[pin.LOCAL], **close)
        down = np.array([0.3, -0.2, 1.0])
        np.testing.assert_allclose(into_links(down), [place.rotation.T @ down for place in places], **close)


# --- floats against Pinocchio ---------------------------------------------------------------------------------------


@law(40)
@given(trees, seeds)
def test_accelerations_vs_pinocchio(model, seed):
    """ABA in either convention, with joint torques and external wrenches, on random trees."""
    tree, random = tree_of(model), np.random.default_rng(seed)
    q, v, tau = 2 * random.normal(size=(3, model.nv))
    external = 5 * random.normal(size=(model.nv, 6))
    own = accelerations(tree, q, v, model.gravity.linear, tau, external)
    forces = [pin.Force.Zero(), *map(pin.Force, external)]
    for convention in (pin.Convention.LOCAL, pin.Convention.WORLD):
        theirs = pin.aba(model, model.createData(), q, v, tau, forces, convention)
        entering = terms(model, q, v, own, tau, external, world=convention == pin.Convention.WORLD)
        assert np.all(np.abs(own - theirs) < bound(model) * entering.acceleration)


@law(40)
@given(trees, seeds)
def test_wrenches_vs_pinocchio(model, seed):
    """RNEA's data.f, joint by joint, on random trees at random accelerations, with external wrenches."""
    random = np.random.default_rng(seed)
    q, v, a = 2 * random.normal(size=(3, model.nv))
    external = 5 * random.normal(size=(model.nv, 6))
    data = model.createData()
    pin.rnea(model, data, q, v, a, [pin.Force.Zero(), *map(pin.Force, external)])
    theirs = np.array([f.vector for f in data.f.tolist()[1:]])
    own = wrenches(tree_of(model), q, v, a, model.gravity.linear, external)
    entering = terms(model, q, v, a, external=external)
    assert np.all(
        np.abs(own - theirs) < bound(model) * np.repeat(np.stack([entering.force, entering.moment], -1), 3, -1)
    )


# --- laws -----------------------------------------------------------------------------------------------------------


@law(30)
@given(trees, seeds)
def test_accelerations_invert_wrenches(model, seed):
    """The wrenches at the accelerations that torques cause carry these torques along the axes."""
    tree, random = tree_of(model), np.random.default_rng(seed)
    q, v, tau = 2 * random.normal(size=(3, model.nv))
    a = accelerations(tree, q, v, model.gravity.linear, tau)
    wrench = wrenches(tree, q, v, a, model.gravity.linear)
    off = np.abs(torques(tree, wrench) - tau)
    assert np.all(off < bound(model) * np.abs(mass_matrix(tree, q)) @ terms(model, q, v, a, tau).acceleration)


@law(30)
@given(trees, seeds)
def test_mass_matrix_is_symmetric_and_pinocchios(model, seed):
    """The wrenches at unit accelerations form a symmetric positive definite matrix, the one that CRBA gives."""
    q, _ = state(model.nv, seed)
    M = mass_matrix(tree_of(model), q)
    upper = np.triu(pin.crba(model, model.createData(), q))
    size = mass_terms(model, q)
    assert np.all(np.abs(M - M.T) <= bound(model) * size)
    assert np.all(np.abs(M - (upper + np.triu(upper, 1).T)) <= bound(model) * size)
    assert np.linalg.eigvalsh(M)[0] > -bound(model) * np.linalg.norm(size)


@pytest.mark.parametrize("seed", range(4))
def test_power_balance_in_50_digits(seed):
    """d/dt (v M v / 2) = v . (tau - G), G the torques that hold the tree still: to 20 digits by central differences."""
    xp = exact(50)
    model = random_model(4, seed)
    tree, (q, v) = tree_of(model), state(4, seed)
    q, v, tau, field = map(xp.asarray, (q, v, np.ones(4), model.gravity.linear))
    a = accelerations(tree, q, v, field, tau, xp=xp)
    hold = torques(tree, wrenches(tree, q, 0 * v, 0 * v, field, xp=xp), xp)

    def kinetic(t):
        moved, rate = q + v * t + a * t**2 / 2, v + a * t
        return rate @ mass_matrix(tree, moved, xp) @ rate / 2

    h = xp.asarray(1e-12)[()]
    slope = (kinetic(h) - kinetic(-h)) / (2 * h)
    assert abs(slope - v @ (tau - hold)) < 1e-20 * abs(slope)


def test_many_states_at_once_equal_one_by_one():
    tree = tree_of(random_model(5, 3))
    q, v, a = np.random.default_rng(0).normal(size=(3, 2, 7, 5))
    both = accelerations(tree, q, v, GRAVITY, a), wrenches(tree, q, v, a, GRAVITY)
    assert both[0].shape == (2, 7, 5)
    assert both[1].shape == (2, 7, 5, 6)
    for k in np.ndindex(2, 7):
        np.testing.assert_allclose(both[0][k], accelerations(tree, q[k], v[k], GRAVITY, a[k]), rtol=1e-12)
        np.testing.assert_allclose(both[1][k], wrenches(tree, q[k], v[k], a[k], GRAVITY), rtol=1e-12, atol=1e-12)


def test_a_joint_without_inertia_divides_by_zero():
    tree = chain(1)._replace(masses=np.zeros(2), inertias=np.zeros((2, 3, 3)))
    with np.errstate(all="ignore"):
        assert not np.isfinite(accelerations(tree, *state(2, 0), GRAVITY)).any()
    with pytest.raises(ZeroDivisionError):
        accelerations(tree, *state(2, 0), GRAVITY, xp=exact(30))


# --- digits ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", [random_model(8, 1), random_model(8, 2)])
def test_50_digits_vs_80(model):
    """Each precision keeps to itself, and the digits it promises are right."""
    tree, (q, v) = tree_of(model), state(8, 5)
    few, many = (accelerations(tree, q, v, model.gravity.linear, xp=exact(digits)) for digits in (50, 80))
    assert 0 < np.abs(few - many).max() < 1e-46 * np.abs(many).max()


@pytest.mark.parametrize(
    ("rods", "alike", "mixed"),
    [(5, 1e-13, 5e-12), (20, 5e-12, 2e-11), pytest.param(60, 5e-12, 2e-11, marks=pytest.mark.slow)],
)
def test_floats_vs_50_digits_in_chains(rods, alike, mixed):
    """The largest relative error of the accelerations over some states, for like rods and for mixed ones."""
    for tree, bound in ((chain(rods), alike), (chain(rods, mixed=rods), mixed)):
        for seed in range(max(1, 40 // rods)):
            q, v = state(2 * rods, seed)
            reference_route = accelerations(tree, q, v, GRAVITY, xp=exact(50))
            assert (
                np.abs(accelerations(tree, q, v, GRAVITY) - reference_route).max()
                < bound * np.abs(reference_route).max()
            )


def test_exact_numbers_take_floats_over_unrounded():
    xp = exact(50)
    assert xp.asarray([0.1])[0] == 0.1
    assert abs(xp.sqrt(xp.asarray([2.0]))[0] ** 2 - 2) < 1e-49
    assert abs(exact(80).sqrt(exact(80).asarray([2.0]))[0] ** 2 - 2) < 1e-79


def test_libraries_of_other_number_types_load_late():
    """Importing the recursion brings neither mpmath nor heyoka nor Pinocchio."""
    code = """if True:
        import sys
        import pendpin.equations.base, pendpin.equations.recursion
        print({'mpmath', 'heyoka', 'pinocchio', 'scipy'} & set(sys.modules))"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


# --- symbols --------------------------------------------------------------------------------------------------------


def expressions(tree):
    """The accelerations in heyoka's symbols, and the variables q and v."""
    import heyoka

    n = len(tree.parents)
    variables = np.array([heyoka.expression(f"{name}{i}") for name in "qv" for i in range(n)], dtype=object)
    return list(accelerations(tree, variables[:n], variables[n:], GRAVITY, xp=symbols())), list(variables)


@needs_heyoka
@pytest.mark.parametrize("tree", [chain(1), chain(3), chain(2, mixed=1), tree_of(random_model(3, 7))])
def test_compiled_symbols_vs_floats(tree):
    import heyoka

    out, variables = expressions(tree)
    compiled = heyoka.cfunc(out, vars=variables, compact_mode=True)
    for seed in range(20):
        q, v = state(len(tree.parents), seed)
        own = accelerations(tree, q, v, GRAVITY)
        cond, scale = condition(tree, q)
        difference = np.abs((compiled(np.concatenate([q, v])) - own) * scale).max()
        assert difference < 50 * EPS * cond * np.abs(own * scale).max()


@needs_heyoka
@pytest.mark.parametrize(("rods", "terms"), [(1, 50), (2, 277), (3, 647)])
def test_symbols_stay_few(rods, terms):
    """Zeros and ones fold away: the Taylor integrator's decomposition has no more terms (plain ABA: 62, 436, 1079)."""
    import heyoka

    out, variables = expressions(chain(rods))
    system = list(zip(variables, variables[2 * rods :] + out, strict=True))
    taylor = heyoka.taylor_adaptive(system, [0.1] * 4 * rods, compact_mode=True)
    assert len(taylor.decomposition) <= terms
