"""Exact derivatives of accelerations, against differences in 50 digits, Pinocchio's own, and what is known by hand."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from effect_cases import EFFECTS, FIVE, MODELS
from laws import law
from pendpin import effects as fx
from pendpin.dynamics.binding import Binding
from pendpin.dynamics.compiling import BoundTree
from pendpin.dynamics.derivatives import Variational
from pendpin.dynamics.parameters import Numbers
from pendpin.equations.base import exact
from pendpin.equations.recursion import accelerations
from pendpin.model.bodies import with_gravity
from pendpin.model.build import build

pytest.importorskip("llvmlite", reason="llvmlite is not installed: pip install llvmlite")
XP = exact(50)
STEP = 1e-12  # of differences in 50 digits: the next term of a central difference is 1e-24 of the derivative
ROUNDING = 1e-13  # of the largest entry: the chain rule on some 1e3 operations of the recursion


def in_fifty_digits(scene: pp.Scene, t: float, y: np.ndarray) -> np.ndarray:
    """The accelerations (nv,) at y = (q, v), by the recursion on mpmath's numbers."""
    model = build(scene.model)
    q, v = np.split(y, 2)
    bound = BoundTree(Binding(model, scene.effects, numbers=Numbers(XP)))
    loads, time = bound.loads, XP.asarray(t)[()]
    tau = loads.torque(time, q, v) if loads.torque else None
    return accelerations(bound.tree, q, v, XP.asarray(loads.field(time)), tau, bound.external(time, q, v), XP)


def difference(scene: pp.Scene, t: float, y: np.ndarray, way: np.ndarray) -> np.ndarray:
    """The derivative (nv,) of the accelerations along a way (2 nv,), by a central difference in 50 digits."""
    y, way = XP.asarray(y), XP.asarray(way)
    ahead, behind = (in_fifty_digits(scene, t, y + s * STEP * way) for s in (1, -1))
    return ((ahead - behind) / (2 * XP.asarray(STEP)[()])).astype(float)


def wide_difference(scene: pp.Scene, t: float, y: np.ndarray, way: np.ndarray) -> np.ndarray:
    """The same (nv,) by a difference of fourth order with a step of 5e-4, for what is smooth there."""
    y, way = XP.asarray(y), XP.asarray(way)
    terms = [s * w * in_fifty_digits(scene, t, y + s * n * 5e-4 * way) for n, w in ((1, 8), (2, -1)) for s in (1, -1)]
    return (sum(terms[1:], terms[0]) / (12 * XP.asarray(5e-4)[()])).astype(float)


CHAINS = MODELS | {"chain of 2": pp.Chain(rods=FIVE[:2]), "chain of 3": pp.Chain(rods=FIVE[:3])}


def scene_of(model: str, effects: Sequence[str]) -> pp.Scene:
    return pp.Scene(model=CHAINS[model], effects=[fx.Gravity(), *(EFFECTS[name] for name in effects)])


# --- by the state ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("effect", [name for name in EFFECTS if name != "gravity"])
@pytest.mark.parametrize("model", ["one rod", "chain of 3"])
def test_every_effect_against_fifty_digits(model: str, effect: str) -> None:
    """Along a random way, at a random state: quadratic drag too, in a flow that vanishes nowhere."""
    scene, random = scene_of(model, [effect]), np.random.default_rng(5)
    equations = Variational(scene)
    y, way = random.uniform(-1, 1, (2, 2 * equations.nv))
    _, change = equations.rates(np.array([0.7]), y[None], way[None, None])
    expected = difference(scene, 0.7, y, way)
    assert np.abs(change[0, 0, equations.nv :] - expected).max() < ROUNDING * 10 * np.abs(expected).max()


WINDS = {
    "wind along x": fx.Drag(density=20.0, diameter=0.06, wind=(3, 0, 0)),
    "wind along y": fx.Drag(density=20.0, diameter=0.06, wind=(0, -1, 0), linear=0.1),
    "wind askew": fx.Drag(density=5.0, diameter=0.06, wind=(2, 1, -0.5), gust=(1, 0, 0), frequency=2.0),
}
LAWS = {**{name: effect for name, effect in EFFECTS.items() if name != "gravity"}, **WINDS}


@cache
def equations_at_rest(model: str, effect: str) -> tuple[pp.Scene, Variational]:
    """Compiled once, for both rests."""
    scene = pp.Scene(model=CHAINS[model], effects=[fx.Gravity(), LAWS[effect]])
    return scene, Variational(scene)


@pytest.mark.parametrize(
    ("model", "effect", "moving"),
    [
        pytest.param(model, effect, moving, marks=[pytest.mark.slow] * (model != "one rod" and not feels))
        for model in ("one rod", "chain of 2")
        for effect, feels in ((effect, isinstance(law, fx.Drag)) for effect, law in LAWS.items())
        for moving in ("nothing moves", "the first joint stands")
        if model == "one rod" or moving == "nothing moves" or feels  # others do not feel which of them stand
    ],
)
def test_every_effect_at_rest_against_fifty_digits(model: str, effect: str, moving: str) -> None:
    """Along axes of the state: at a rest relative speeds vanish, and so does their change along the rods.

    In still air |u| u changes by the square of a step of 1e-12, nothing beside what is compared. In wind the flow is
    least at one end of a rod on one side of the rest and at the other end on the other side, so that the rounding of the
    quadrature's weights, which are doubles, enters: a difference of fourth order with a step of 5e-4 is good to 1e-12.
    """
    law, random = LAWS[effect], np.random.default_rng(6)
    scene, equations = equations_at_rest(model, effect)
    q, v = random.uniform(-1, 1, (2, equations.nv))
    v = np.zeros(equations.nv) if moving == "nothing moves" else np.where(np.arange(equations.nv), v, 0.0)
    found = equations.jacobian(0.7, q, v)
    columns = np.hstack([found.of_q, found.of_v])
    windy = isinstance(law, fx.Drag) and (any(law.wind) or law.gust)
    for way in sorted({0, 1, equations.nv - 1, equations.nv, equations.nv + 1, 2 * equations.nv - 1}):
        differences = wide_difference if windy else difference
        expected = differences(scene, 0.7, np.concatenate([q, v]), np.eye(2 * equations.nv)[way])
        assert np.abs(columns[:, way] - expected).max() < ROUNDING * 100 * np.abs(columns).max(), way


@pytest.mark.parametrize("still", [True, False])
def test_the_wind_has_a_derivative_in_still_air(still: bool) -> None:
    """By the wind about none, where the flow at the pivot is 0: against differences in 50 digits."""
    rod, random = MODELS["one rod"], np.random.default_rng(7)
    scene = pp.Scene(model=rod, effects=[fx.Gravity(), fx.Drag(density=20.0)])
    q, v = random.uniform(-1, 1, (2, 2))
    v = 0 * v if still else v
    equations = Variational(scene, [f"effects[1].wind[{i}]" for i in range(3)])
    _, changes = equations.rates(np.zeros(1), np.concatenate([q, v])[None], np.zeros((1, 3, 4)))
    for change, axis in zip(changes[0, :, 2:], np.eye(3), strict=True):
        both = [
            in_fifty_digits(scene.replace({"effects[1].wind": tuple(s * STEP * axis)}), 0.0, np.concatenate([q, v]))
            for s in (1, -1)
        ]
        expected = ((both[0] - both[1]) / (2 * XP.asarray(STEP)[()])).astype(float)
        assert np.abs(change - expected).max() < 1e-11 * (1.0 + np.abs(expected).max())


@law(10)
@given(
    chosen=st.sets(st.sampled_from(sorted(set(EFFECTS) - {"gravity"})), max_size=4),
    model=st.sampled_from(sorted(MODELS)),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_jacobian_holds_the_derivatives_along_all_ways(chosen: set[str], model: str, seed: int) -> None:
    """The derivative along a way is the sum of the columns of the Jacobian times the way's numbers."""
    kinds = {EFFECTS[name].kind: name for name in sorted(chosen)}  # one drag and one rotation at most
    scene, random = scene_of(model, list(kinds.values())), np.random.default_rng(seed)
    equations = Variational(scene)
    nv = equations.nv
    y, way = random.uniform(-1, 1, (2, 2 * nv))
    found = equations.jacobian(0.3, *np.split(y, 2))
    _, change = equations.rates(np.array([0.3]), y[None], way[None, None])
    expected = np.hstack([found.of_q, found.of_v]) @ way
    size = np.abs(np.hstack([found.of_q, found.of_v])).max() * 2 * nv
    assert np.abs(change[0, 0, nv:] - expected).max() <= 1e-14 * size
    assert (change[0, 0, :nv] == way[nv:]).all()


@pytest.mark.parametrize("robot", ["ur5", "panda"])
def test_robots_against_pinocchio(robot: str) -> None:
    """At ten states; both are off by less than 1e-12 of the largest derivative."""
    import pinocchio as pin

    scene = pp.Scene(model=pp.UrdfModel(robot), effects=[fx.Gravity()])
    equations, random = Variational(scene), np.random.default_rng(8)
    model = with_gravity(build(scene.model).pin, np.array([0, 0, -9.81]))
    data = model.createData()
    for _ in range(10):
        q, v = random.uniform(-2.8, 2.8, equations.nv), random.uniform(-2, 2, equations.nv)
        found = equations.jacobian(0.0, q, v)
        pin.computeABADerivatives(model, data, q, v, np.zeros(equations.nv))
        for ours, theirs in ((found.of_q, data.ddq_dq), (found.of_v, data.ddq_dv)):
            assert np.abs(ours - theirs).max() <= 1e-12 * np.abs(theirs).max()


def test_quadratic_drag_at_rest_has_the_derivative_zero() -> None:
    """|u| u is differentiable where u is 0, and its derivative is 0; the linear part stays."""
    rod = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.05),))
    gravity, rest, drags = fx.Gravity(), np.zeros(2), (fx.Drag(), fx.Drag(linear=0.3))
    still = [Variational(pp.Scene(model=rod, effects=[gravity, drag])).jacobian(0, rest, rest) for drag in drags]
    none = Variational(pp.Scene(model=rod, effects=[gravity])).jacobian(0, rest, rest)
    assert (still[0].of_v == none.of_v).all()
    inertia = (3 * 0.05**2 + 1) / 12 + 0.25
    assert np.allclose(np.diag(still[1].of_v), -0.3 / 3 / inertia, rtol=1e-14)


# --- by numbers of the scene ----------------------------------------------------------------------------------------

RODS = [f"model.rods[{i}].{name}" for i in (0, 2) for name in ("length", "mass", "radius", "payload")]
KEYS = {
    "viscous": ["effects[1].coefficient"],
    "spring": ["effects[1].stiffness", "effects[1].rest"],
    "sinusoid motor": [f"effects[1].{name}" for name in ("torque", "amplitude", "frequency", "phase")],
    "hold": ["effects[1].target", "effects[1].proportional", "effects[1].derivative"],
    "push": ["effects[1].force[1]", "effects[1].point"],
    "drag": [f"effects[1].{name}" for name in ("diameter", "wind[2]", "linear", "density", "coefficient")],
    "gust and buoyancy": ["effects[1].gust[0]", "effects[1].frequency", "effects[1].density"],
    "support": ["effects[1].amplitude[0]", "effects[1].frequency", "effects[1].phase"],
    "rotation": ["effects[1].rate[1]"],
    "earth": ["effects[1].latitude"],
    "clamped bending": ["effects[1].stiffness", *(f"effects[1].clamp[{i}]" for i in range(3))],
}


def number(scene: pp.Scene, key: str) -> float:
    from pendpin.ground.arguments import parsed

    value = scene
    for part in parsed(key):
        value = value[part] if isinstance(part, int) else getattr(value, part)
    return float(value)


@pytest.mark.parametrize("model", ["one rod", "chain of 3"])
@pytest.mark.parametrize("effect", list(KEYS))
def test_numbers_of_the_scene_against_differences(model: str, effect: str) -> None:
    """Numbers of rods, of gravity and of each effect; some are 0, and have a derivative all the same.

    The fourth-order difference of doubles with steps of 1e-3 is good to about 1e-10 of the largest of them.
    """
    scene, random = scene_of(model, [effect]), np.random.default_rng(11)
    rods = [key for key in RODS if model != "one rod" or "[0]" in key]
    keys = [*rods, "effects[0].acceleration", "effects[0].direction[1]", *KEYS[effect], "start.time"]
    keys = [key for key in keys if not key.endswith("payload") or number(scene, key) > 0.1]
    equations = Variational(scene, keys)
    nv, y = equations.nv, random.uniform(-1, 1, 2 * equations.nv)
    _, found = equations.rates(np.array([0.7]), y[None], np.zeros((1, len(keys), 2 * nv)))
    for key, change in zip(keys, found[0, :, nv:], strict=True):
        x = number(scene, key)
        h = 1e-3 * (abs(x) or 1.0)

        def at(moved: float, key: str = key, x: float = x) -> np.ndarray:
            time = 0.7 + (moved if key == "start.time" else 0.0)
            return pp.bind(scene.replace({key: x + moved})).acceleration(time, *np.split(y, 2))

        expected = (45 * (at(h) - at(-h)) - 9 * (at(2 * h) - at(-2 * h)) + at(3 * h) - at(-3 * h)) / (60 * h)
        assert np.abs(change - expected).max() < 1e-9 * max(np.abs(expected).max(), np.abs(at(0.0)).max()), key


@pytest.mark.parametrize("model", ["one rod", "chain of 5"])
def test_derivatives_side_by_side_are_those_one_by_one(model: str) -> None:
    """Nine numbers, which are two groups of lanes, and each alone: the same operations on the same numbers."""
    scene, random = scene_of(model, ["drag", "support"]), np.random.default_rng(3)
    effects = ("0].acceleration", "1].linear", "1].density", "2].amplitude[0]", "2].frequency")
    keys = [*RODS[:3], "start.time", *(f"effects[{name}" for name in effects)]
    size = 2 * len(build(scene.model).joints)
    y, w = random.uniform(-1, 1, size), random.uniform(-1, 1, (len(keys), size))
    _, together = Variational(scene, keys).rates(np.array([0.7]), y[None], w[None])
    for key, way, found in zip(keys, w, together[0], strict=True):
        _, alone = Variational(scene, [key]).rates(np.array([0.7]), y[None], way[None, None])
        assert np.abs(found - alone[0, 0]).max() <= ROUNDING * np.abs(together).max(), key


def test_a_number_that_is_zero_has_a_derivative() -> None:
    """An effect of strength 0 is left out of a run, but not of the derivative by its strength."""
    rod = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.05),))
    q, v = np.array([0.4, -0.3]), np.array([1.0, 2.0])
    changes = []
    for coefficient in (0.0, 0.3):
        scene = pp.Scene(model=rod, effects=[fx.Gravity(), fx.Viscous(coefficient=coefficient)])
        equations = Variational(scene, ["effects[1].coefficient"])
        changes.append(equations.rates(np.zeros(1), np.concatenate([q, v])[None], np.zeros((1, 1, 4)))[1])
    assert np.allclose(*changes, rtol=1e-13)
    assert changes[0][0, 0, 2:].any()


def test_starts_have_rates() -> None:
    """Positions and rates of the start, in degrees or radians, by name or by place."""
    chain = MODELS["chain of 5"]
    scene = pp.Scene(model=chain, start=pp.Start(positions={"theta_1": 30.0}, unit="degrees"))
    keys = ["start.positions.theta_1", "start.velocities.phi_2", "model.rods[0].mass", "start.time"]
    starts = Variational(scene, keys).starts
    assert starts[0, 0] == np.pi / 180
    assert starts[1, 13] == np.pi / 180
    assert np.count_nonzero(starts) == 2


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("model.rods[9].mass", "the scene has nothing there"),
        ("model.rods[0].com", "no number is given there; set one"),
        ("model.rods[0].colour", "the scene has nothing there"),
        ("model.copies", "has no derivative"),
        ("effects[0].kind", "is not a number"),
        ("effects[0].direction", "is not a number"),
        ("effects[1].kinetic", "acts through events"),
        ("effects[7].coefficient", "the scene has nothing there"),
        ("start.positions.theta_9", "theta_9"),
        ("start.unit", "has no derivative"),
        ("solver.tolerance", "has no derivative"),
        ("duration", "has no derivative"),
    ],
)
def test_keys_without_a_derivative_are_refused(key: str, said: str) -> None:
    """With the key path and the reason, in one line."""
    scene = pp.Scene(model=MODELS["one rod"], effects=[fx.Gravity(), fx.DryFriction(kinetic=0.1)])
    with pytest.raises(pp.InputError, match=said) as error:
        Variational(scene, [key])
    assert "\n" not in str(error.value)


def test_the_axis_of_a_table_of_rates_has_no_derivative(tmp_path: Path) -> None:
    """The rows of a csv are no parameters: its axis is refused, and not taken for a number that changes nothing."""
    (tmp_path / "rate.csv").write_text("t, rate\n" + "\n".join(f"{t}, {0.1 * t * t}" for t in range(12)))
    slewing = fx.Rotation(csv=tmp_path / "rate.csv", axis=(0.0, 0.3, 1.0))
    with pytest.raises(pp.InputError, match="no derivative"):
        Variational(pp.Scene(model=MODELS["one rod"], effects=[slewing]), ["effects[0].axis[1]"])


def test_a_function_has_no_derivative() -> None:
    """A torque that takes floats only is refused by its place."""
    scene = pp.Scene(model=MODELS["one rod"], effects=[fx.Torque(lambda t, q, v: -v)])
    with pytest.raises(pp.InputError, match=r"effects\[0\]"):
        Variational(scene)


def test_friction_that_is_zero_and_stays_so_holds_nothing() -> None:
    """Equations with friction of 0 have the bits of those without, where no direction is that of the friction."""
    rod = pp.Rod(length=1.0, mass=1.0, radius=0.02)
    scene = pp.Scene(model=pp.Chain(rods=[rod]), effects=[fx.Gravity(), fx.DryFriction(kinetic=0.0)], duration=1.0)
    with_it, without = (
        Variational(s, ["model.rods[0].mass"], contacts=True)
        for s in (scene, scene.replace({}, effects=scene.effects[:1]))
    )
    assert with_it.contacts is None
    t, y, w = np.zeros(1), np.array([[0.7, 0.4, 1.3, -0.8]]), np.array([[[0.1, 0.2, -0.3, 0.4]]])
    for one, other in zip(with_it.rates(t, y, w), without.rates(t, y, w), strict=True):
        np.testing.assert_array_equal(one, other)
