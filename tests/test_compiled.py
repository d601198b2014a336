"""The compiled equations are those of the engine they stand in for: the same rates, orders and motions."""

import numpy as np
import pytest

import pendpin as pp
from effect_cases import EFFECTS, MODELS, URDF
from pendpin import effects as fx
from pendpin.dynamics.dynamics import Dynamics
from pendpin.model.build import build

pytest.importorskip("heyoka", reason="heyoka is not installed: pip install heyoka")

SMOOTH = {name: effect for name, effect in EFFECTS.items() if effect.smooth}
SEVERAL = (fx.Gravity(), SMOOTH["viscous"], SMOOTH["support"], SMOOTH["push"], SMOOTH["earth"])


def rates(dynamics: Dynamics, t: float, y: np.ndarray) -> np.ndarray:
    """y' of a state of the engine."""
    dy = np.empty_like(y)
    dynamics.engine.derivative(lambda t: None)[0](dy, t, y)
    return dy


@pytest.mark.parametrize("effects", [(fx.Gravity(),), SEVERAL, *((effect,) for effect in SMOOTH.values())], ids=str)
@pytest.mark.parametrize("model", ["one rod", "chain of 5"])
def test_the_same_rates(model: str, effects: tuple) -> None:
    """Pinocchio's, and those of the recursion in machine code, at random states: within the terms' rounding."""
    built, random = build(MODELS[model]), np.random.default_rng(5)
    plain, compiled = (Dynamics(built, effects, engine, form="angles", start=2.0) for engine in ("auto", "compiled"))
    n = len(built.joints)
    for t in (0.0, 0.7):
        y = np.concatenate([random.uniform(-1.2, 1.2, n), random.uniform(-3, 3, n)])
        expected, found = rates(plain, t, y), rates(compiled, t, y)
        assert np.abs(found - expected).max() < 3e-12 * np.abs(expected).max()  # light rods on heavy: condition 1e3


def test_any_urdf_compiles() -> None:
    """A tree from a file goes the same way as a chain."""
    scene = pp.Scene(model=pp.UrdfModel(path=URDF), effects=(fx.Gravity(),), start=pp.Start(positions={"theta": 1.0}))
    plain, compiled = (pp.simulate(with_engine(scene, name), tolerance=1e-12) for name in ("pinocchio", "compiled"))
    assert compiled.stats.engine == "pinocchio, compiled"
    np.testing.assert_allclose(compiled.q, plain.q, atol=1e-10)


def test_thin_rods_are_compiled_in_directions() -> None:
    """So that nothing happens at the pole: a rod that swings through phi = 90 degrees keeps its energy."""
    scene = pp.Scene(
        duration=5.0,
        model=MODELS["thin chain of 3"],
        start=pp.Start(positions={"phi_1": 1.2}, velocities={"phi_1": 4.0, "theta_1": 1e-3}),
        effects=(fx.Gravity(),),
    )
    run = pp.simulate(with_engine(scene, "compiled"), tolerance=1e-12)
    assert run.stats.engine == "chain, in directions, compiled"
    assert run.energy().drift < 1e-10
    assert np.abs(run.q[:, 1]).max() > np.pi / 2


@pytest.mark.parametrize("model", MODELS)
def test_a_compiled_step_is_the_same_step(model: str) -> None:
    """rk4 with its four stages in machine code goes step by step as rk4 on the same equations."""
    scene = pp.Scene(duration=1.0, model=MODELS[model], start=pp.Start(positions={"theta_1": 0.5}), effects=SEVERAL[:2])
    form = "directions" if "thin" in model else "angles"
    compiled = with_engine(scene, "compiled").by("rk4", 0.01)
    if form == "directions":  # the torque keeps thin rods on angles
        compiled = compiled.model_copy(update={"effects": SEVERAL[:1]})
        scene = scene.model_copy(update={"effects": SEVERAL[:1]})
    one, other = pp.simulate(compiled), pp.simulate(scene.by("rk4", 0.01))
    assert one.stats.evaluations == other.stats.evaluations
    # directions and quaternions have truncation errors of their own, 1e-7 here
    np.testing.assert_allclose(one.q, other.q, atol=1e-6 if form == "directions" else 1e-12)


def test_what_has_no_symbols_is_refused() -> None:
    scene = pp.Scene(model=MODELS["one rod"], effects=(fx.Gravity(), fx.Drag()))
    with pytest.raises(pp.InputError, match=r"effects\[1\]: drag is not smooth, as solver.engine: compiled needs it"):
        pp.simulate(with_engine(scene, "compiled"))
    long = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1, mass=1, radius=0.1)], copies=101), effects=(fx.Gravity(),))
    with pytest.raises(pp.InputError, match="up to 100 rods"):
        pp.simulate(with_engine(long, "compiled"))


def with_engine(scene: pp.Scene, engine: str) -> pp.Scene:
    return scene.model_copy(update={"solver": scene.solver.replaced(engine=engine)})
