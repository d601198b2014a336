"""Chains and URDF trees: every engine, every route, and answers from outside."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from scipy.special import jn_zeros, roots_laguerre

import pendpin as pp
from pendpin.model.build import build
from pendpin.model.notes import notes
from pendpin.model.write_models import chain_urdf
from scenes import scene_of

GRAVITY = (pp.effects.Gravity(),)
G = 9.81


def chain_of(*rods: pp.Rod, copies: int = 1) -> pp.Chain:
    """A chain of these rods."""
    return pp.Chain(rods=rods, copies=copies)


def mixed_rods(count: int, seed: int) -> pp.Chain:
    """Thin and thick rods, masses 0.01 to 100 kg, lengths 0.01 to 10 m."""
    random = np.random.default_rng(seed)
    return chain_of(
        *(
            pp.Rod(
                length=10 ** random.uniform(-2, 1),
                mass=10 ** random.uniform(-2, 2),
                radius=float(random.choice([0.0, 1e-3, 0.1])),
            )
            for _ in range(count)
        )
    )


def hanging(model: pp.Chain, q=(), v=(), **given) -> pp.Scene:
    """A chain under gravity."""
    return scene_of(model, *GRAVITY, q=q, v=v, **given)


# --- accelerations and reactions ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("count", "states"), [(2, 100), (3, 60), (10, 20), (50, 3)])
def test_every_route_agrees_on_mixed_rods(count: int, states: int) -> None:
    """Pinocchio, the chain equations, the recursion and 50 digits, within the bounds that follow from condition."""
    report = pp.crosscheck(hanging(mixed_rods(count, seed=count)), states=states, seed=1)
    assert report.ok, report.fault
    assert set(report.routes) == {"pinocchio", "chain", "recursion"}
    assert "Farthest from 50 digits: " in str(report)


@pytest.mark.parametrize("rod", [pp.Rod(length=1.0, mass=1.0, radius=0.05), pp.Rod(length=1.0, mass=1.0)])
def test_engines_give_the_same_motion(rod: pp.Rod) -> None:
    """Pinocchio and the chain equations, thick rods and thin: tips, rates and reactions."""
    q, v = [0.3, 0.4, 0.5, -0.6, 0.2, 0.1], [1.0, 2.0, -1.0, -2.0, 0.5, 0.7]
    scenes = [hanging(chain_of(rod, copies=3), q, v, tolerance=1e-12, engine=e) for e in ("pinocchio", "chain")]
    one, other = (pp.simulate(scene) for scene in scenes)
    assert np.abs(one.tips - other.tips).max() < 1e-9
    assert np.abs(one.v - other.v).max() < 1e-8
    assert np.abs(np.array(one.reactions()) - np.array(other.reactions())).max() < 1e-7
    assert max(run.energy().drift for run in (one, other)) < 1e-10


def test_a_hanging_chain_carries_its_weight() -> None:
    """At rest the tension of each joint is the weight below it, exactly to rounding; R1, R2 and Mc are 0."""
    model = mixed_rods(20, seed=3)
    run = pp.simulate(hanging(model, duration=0.0))
    weights = np.cumsum([rod.mass for rod in model.rods][::-1])[::-1] * G
    assert np.allclose(run.reactions().R3[0], weights, rtol=1e-14)
    assert np.abs(run.reactions().R1).max() == 0


def test_reactions_agree_with_wrenches_of_the_same_joint() -> None:
    """The cross carries the rod's wrench, seen in its own frame: same lengths."""
    run = pp.simulate(hanging(mixed_rods(3, seed=1), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6], duration=0.1, engine="chain"))
    for part in (slice(0, 3), slice(3, 6)):
        lengths = np.linalg.norm(run.wrench[..., part], axis=-1)
        assert np.allclose(lengths[:, ::2], lengths[:, 1::2], rtol=1e-13)


@pytest.mark.parametrize("count", [1, 3])
def test_routes_agree_under_torques_and_wrenches(count: int) -> None:
    """Every route feels the scene's other effects: viscous joints, drag in wind, a push, a spring."""
    effects = pp.effects
    loaded = (
        effects.Viscous(coefficient=0.1),
        effects.Spring(stiffness=3.0),
        effects.Drag(wind=(3.0, 1.0, 0.0)),
        effects.Push(link="rod_1", force=(1.0, -2.0, 0.5), point=0.2),
    )
    scene = hanging(chain_of(pp.Rod(length=1.0, mass=1.0, radius=0.05), copies=count))
    report = pp.crosscheck(scene.model_copy(update={"effects": (*GRAVITY, *loaded)}), states=60)
    assert report.ok, report.fault
    assert set(report.routes) == {"pinocchio", "chain", "recursion"}


# --- small swings ---------------------------------------------------------------------------------------------------


def frequencies(model: pp.Chain) -> np.ndarray:
    """Squares of the small-swing frequencies, from Pinocchio's derivatives at rest."""
    pin_model = pin.Model(build(model).pin)
    pin_model.gravity.linear = np.array([0, 0, -G])
    zero, data = np.zeros(pin_model.nv), pin.Data(pin_model)  # the results are views into data
    stiffness, _, _ = pin.computeABADerivatives(pin_model, data, zero, zero, zero)
    return np.sort(np.linalg.eigvals(-stiffness).real)


def test_point_masses_swing_at_the_laguerre_frequencies() -> None:
    """n equal point masses on massless rods: omega² = (g/l) times the roots of L_n, twice each (two planes)."""
    n, length = 10, 0.5
    found = frequencies(chain_of(pp.Rod(length=length, mass=0.0, payload=0.2), copies=n))
    expected = np.repeat(G / length * roots_laguerre(n)[0], 2)
    assert np.allclose(found, expected, rtol=1e-9)


def long_frequencies(n: int, count: int) -> np.ndarray:
    """The lowest frequencies of n thin links of length 1/n, by the chain equations at small angles."""
    dynamics = pp.bind(hanging(chain_of(pp.Rod(length=1.0 / n, mass=1.0 / n), copies=n), engine="chain"))
    small = 1e-5
    states = np.zeros((n, 2 * n))
    states[:, ::2] = small * np.eye(n)
    bend = dynamics.engine.evaluate(np.zeros(n), states, 0 * states).acceleration[:, ::2].T / small
    compliance = -np.linalg.inv(bend)  # its largest eigenvalues are well conditioned, those of its inverse are not
    return np.sort(1 / np.sqrt(np.sort(np.linalg.eigvals(compliance).real)[-count:]))


@pytest.mark.parametrize("most", [200, pytest.param(400, marks=pytest.mark.slow)])
def test_links_swing_like_a_hanging_chain(most: int) -> None:
    """Many thin links approach the continuous chain, omega_k = j0k/2 sqrt(g/L), as 1/n² does."""
    exact = jn_zeros(0, 3) / 2 * np.sqrt(G)
    coarse, middle, fine = (np.abs(long_frequencies(n, 3) / exact - 1) for n in (most // 4, most // 2, most))
    assert np.allclose((np.log2(coarse / middle), np.log2(middle / fine)), 2, atol=0.05)
    assert fine.max() < 8 / most**2


# --- long chains ----------------------------------------------------------------------------------------------------


def test_a_chain_too_long_for_pinocchio_runs_on_the_chain_equations() -> None:
    """300 rods: chosen by itself, energy kept; naming Pinocchio is refused with the reason."""
    model = chain_of(pp.Rod(length=1.0, mass=1.0, radius=0.01), copies=300)
    run = pp.simulate(hanging(model, duration=0.2, tolerance=1e-7))
    assert run.stats.engine == "chain, compiled"
    assert run.energy().drift < 1e-5
    with pytest.raises(pp.InputError, match="too many for Pinocchio"):
        pp.simulate(hanging(model, duration=0.2, engine="pinocchio"))


# --- URDF trees -----------------------------------------------------------------------------------------------------


def test_a_chain_written_as_urdf_is_the_same_model(tmp_path: Path) -> None:
    """Joints, tips, motion and reactions of the written chain are those of the scene's, bit for bit on the same engine."""
    model = chain_of(pp.Rod(length=1.0, mass=1.0, radius=0.1), pp.Rod(length=0.7, mass=2.0, radius=0.05, payload=0.5))
    path = tmp_path / "chain.urdf"
    path.write_text(chain_urdf(model))
    scene = hanging(model, [0.3, 0.1, -0.2, 0.4], engine="pinocchio")
    one, other = pp.simulate(scene), pp.simulate(scene.model_copy(update={"model": pp.UrdfModel(path=path)}))
    assert one.joints == other.joints
    assert np.array_equal(one.q, other.q)
    assert np.allclose(one.tips, other.tips, atol=1e-15)
    assert np.allclose(one.reactions(), other.reactions(), atol=1e-13)


def example_urdf(name: str) -> Path:
    """A URDF of the installed example-robot-data."""
    prefix = Path(pin.__file__).parents[4]
    return prefix / "share/example-robot-data/robots/double_pendulum_description/urdf" / name


@pytest.mark.parametrize(
    "name", ["double_pendulum.urdf", "double_pendulum_continuous.urdf", "double_pendulum_simple.urdf"]
)
def test_example_robot_datas_double_pendulums(name: str) -> None:
    """They load, check, keep their energy, and say that their damping is ignored."""
    scene = pp.Scene(
        duration=5.0,
        model=pp.UrdfModel(path=example_urdf(name)),
        start=pp.Start(positions=[0.5, 0.3]),
        effects=GRAVITY,
    )
    assert pp.crosscheck(scene, states=100).ok
    assert pp.simulate(scene, tolerance=1e-12).energy().drift < 1e-10
    damped = "damping" in example_urdf(name).read_text()
    assert any("damping" in note and "ignored" in note for note in notes(scene, build(scene.model))) == damped


def test_revolute_and_continuous_double_pendulum_move_alike() -> None:
    """The same pendulum with joints of either type: 1e-10 after 5 s."""
    ends = []
    for name in ("double_pendulum.urdf", "double_pendulum_continuous.urdf"):
        model = pp.UrdfModel(path=example_urdf(name))
        start = pp.Start(positions=[0.5, 0.3])
        ends.append(
            pp.simulate(pp.Scene(duration=5.0, model=model, start=start, effects=GRAVITY), tolerance=1e-12).q[-1]
        )
    assert np.abs(ends[0] - ends[1]).max() < 1e-10


def test_several_rods_on_one_support(tmp_path: Path) -> None:
    """A forest in one URDF: each universal joint is recognised, each rod moves as it would alone."""
    one = chain_urdf(chain_of(pp.Rod(length=1.0, mass=1.0, radius=0.05)))
    body = one[one.index('<joint name="theta"') : one.index("</robot>")]
    second = body.replace('"theta"', '"theta_b"').replace('"phi"', '"phi_b"')
    second = second.replace('"rod"', '"rod_b"').replace('"cross"', '"cross_b"')
    second = second.replace('<origin xyz="0.0 0.0 0.0" />', '<origin xyz="2.0 0.0 0.0" rpy="0 0 0.7" />', 1)
    path = tmp_path / "two.urdf"
    path.write_text(one.replace("</robot>", second + "</robot>"))
    scene = pp.Scene(
        duration=1.0,
        model=pp.UrdfModel(path=path),
        start=pp.Start(positions={"theta": 0.5, "phi_b": 0.3}),
        effects=GRAVITY,
    )
    run = pp.simulate(scene)
    assert [rod.link for rod in build(scene.model).rods] == ["rod", "rod_b"]
    assert pp.crosscheck(scene, states=100).ok
    alone = pp.simulate(hanging(chain_of(pp.Rod(length=1.0, mass=1.0, radius=0.05)), [0.5, 0.0], duration=1.0))
    assert np.abs(run.q[:, :2] - alone.q).max() < 1e-8
    assert run.reactions().R3.shape == (61, 2)
