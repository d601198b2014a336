"""The laws that every effect keeps: the same on both engines and in all numbers, additive, nothing for nothing."""

import sys
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from effect_cases import EFFECTS, MODELS, URDF, ZERO, on_both, states
from heyoka_symbols import symbols
from laws import law
from pendpin import effects as fx
from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Directions, LongChain, Revolute, Spherical
from pendpin.equations.base import exact
from pendpin.model import kinematics
from pendpin.model.build import build

GRAVITY = fx.Gravity()
THICK = {name: model for name, model in MODELS.items() if not name.startswith("thin")}


def largest(x: np.ndarray) -> float:
    return float(np.abs(x).max())


@pytest.mark.parametrize("model", THICK.values(), ids=THICK)
@pytest.mark.parametrize("effect", EFFECTS.values(), ids=EFFECTS)
def test_both_engines_feel_the_same(model: pp.Chain, effect: fx.Effect) -> None:
    """Pinocchio and the chain equations: the same accelerations to 1e-11."""
    found, other = on_both(model, (GRAVITY, effect), *states(2 * model.count))
    assert largest(found - other) < 1e-11 * largest(found)


@pytest.mark.parametrize("effect", [e for e in EFFECTS.values() if isinstance(e, fx.BodyEffect)], ids=lambda e: e.kind)
@pytest.mark.parametrize("engine", [Revolute, LongChain])
def test_many_states_at_once(engine: type, effect: fx.Effect) -> None:
    """What is computed of all samples is that of each sample alone, and so are the potentials."""
    model, effects = build(MODELS["chain of 5"]), (GRAVITY, effect, EFFECTS["support"], EFFECTS["push"])
    dynamics, (t, q, v) = Dynamics(model, effects), states(10)
    evaluate = engine(model, dynamics.loads).evaluate
    alone = [evaluate(t[i : i + 1], q[i : i + 1], v[i : i + 1]) for i in range(len(t))]
    for found, others in zip(evaluate(t, q, v), zip(*alone, strict=True), strict=True):
        assert largest(found - np.concatenate(others)) < 1e-13 * largest(found)
    poses = kinematics.poses(model, q)
    apart = [dynamics.potentials_at(q[i : i + 1], poses[i : i + 1])[0] for i in range(len(q))]
    np.testing.assert_allclose(dynamics.potentials_at(q, poses), apart, rtol=1e-13)


@pytest.mark.parametrize("effect", [e for e in EFFECTS.values() if not isinstance(e, fx.Bending)], ids=lambda e: e.kind)
def test_a_urdf_feels_the_same(effect: fx.Effect) -> None:
    """The built-in URDF against the chain of the same rod: the same accelerations and wrenches."""
    t, q, v = states(2)
    rod = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.01),))
    urdf, chain = (Dynamics(build(model), (GRAVITY, effect)) for model in (pp.UrdfModel(path=URDF), rod))
    for quantity in ("acceleration", "wrench"):
        found, other = (getattr(dynamics.engine.evaluate(t, q, v), quantity) for dynamics in (urdf, chain))
        assert largest(found - other) < 1e-11 * largest(found)


def test_a_urdf_rod_has_the_radius_of_its_drawing() -> None:
    """So drag knows its diameter."""
    assert build(pp.UrdfModel(path=URDF)).body_arrays.radius == pytest.approx([0.01], rel=1e-14)


@pytest.mark.parametrize("effect", ["push", "drag", "still air", "gust and buoyancy", "support", "rotation"])
@pytest.mark.parametrize("engine", ["pinocchio", "chain"])
def test_thin_rods_carried_as_on_balls_move_the_same(effect: str, engine: str) -> None:
    """The engines in directions against Pinocchio on universal joints, after 0.3 s of motion."""
    model = MODELS["thin chain of 3"]
    start = pp.Start(positions=(0.4, 0.3, -0.2, 0.5, 0.1, 0.6), velocities=(1.0, -1.0, 0.5, 0.2, -0.3, 0.8))
    solver = pp.Solver(tolerance=1e-10, samples=2, engine=engine)
    scene = pp.Scene(duration=0.3, model=model, start=start, effects=(GRAVITY, EFFECTS[effect]), solver=solver)
    assert isinstance(pp.bind(scene).engine, Spherical if engine == "pinocchio" else Directions)
    faint = fx.Viscous(coefficient=1e-15)  # a torque on the joints keeps the rods on angles; 0 would be left out
    on_joints = scene.model_copy(update={"effects": (*scene.effects, faint)})
    assert isinstance(pp.bind(on_joints).engine, Revolute if engine == "pinocchio" else LongChain)
    found, other = pp.simulate(scene), pp.simulate(on_joints)
    assert largest(found.tips[-1] - other.tips[-1]) < 1e-9


def test_what_turns_a_thin_rod_about_its_axis_keeps_it_on_its_joint() -> None:
    """A torque in W may do that, and a user's effect unless it says otherwise."""
    model = build(MODELS["thin chain of 3"])
    assert isinstance(Dynamics(model, (EFFECTS["push and torque"],)).engine, Revolute)
    assert isinstance(Dynamics(model, (EFFECTS["push and torque"],), "chain").engine, LongChain)


@law(25)
@given(st.permutations(sorted(EFFECTS)), st.integers(1, 6), st.sampled_from(sorted(THICK)))
def test_the_order_of_the_list_does_not_matter(names: list[str], count: int, model: str) -> None:
    """Bit for bit, on both engines."""
    some = list({effect.sole or name: effect for name in names[:count] for effect in [EFFECTS[name]]}.values())
    given_states = states(2 * THICK[model].count, count=2)
    for one, other in zip(*(on_both(THICK[model], order, *given_states) for order in (some, some[::-1])), strict=True):
        assert (one == other).all()


def test_the_order_of_three_of_a_kind_does_not_matter() -> None:
    """Effects of one kind differ by their parameters."""
    springs = [fx.Spring(stiffness=0.1), fx.Spring(stiffness=0.7, rest=0.3), fx.Spring(stiffness=1e-3, rest=-2.0)]
    found = [on_both(MODELS["one rod"], order, *states(2))[0] for order in permutations(springs)]
    assert all((x == found[0]).all() for x in found)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize("effect", ZERO.values(), ids=ZERO)
def test_no_strength_changes_nothing(model: pp.Chain, effect: fx.Effect) -> None:
    """The same bits as without it, on both engines."""
    given_states = states(2 * model.count)
    without, with_it = (on_both(model, effects, *given_states) for effects in ((GRAVITY,), (GRAVITY, effect)))
    for one, other in zip(without, with_it, strict=True):
        assert (one == other).all()


def test_effects_add() -> None:
    """Twice the force moves the rod as two equal forces do."""
    once, twice = fx.Viscous(coefficient=0.25), fx.Viscous(coefficient=0.5)
    for one, other in zip(*(on_both(MODELS["one rod"], x, *states(2)) for x in ((once, once), (twice,))), strict=True):
        assert (one == other).all()


def test_nothing_is_bound_for_what_the_scene_lacks() -> None:
    """With gravity alone no interface has a function; each effect fills its own only."""
    model = build(MODELS["one rod"])
    interfaces = {"gravity": "", "viscous": "torque", "motor": "torque", "push": "wrench", "drag": "wrench"}
    interfaces |= {"rotation": "wrench", "support": "varying", "spring": "torque", "hold": "torque"}
    for name, used in interfaces.items():
        loads = Dynamics(model, (GRAVITY, EFFECTS[name])).loads
        assert [x for x in ("varying", "torque", "wrench") if getattr(loads, x) is not None] == ([used] if used else [])


# --- potentials -----------------------------------------------------------------------------------------------------


def test_a_spring_pulls_down_its_potential() -> None:
    """By central differences."""
    spring, q = EFFECTS["spring"], np.array([0.3, -0.8, 1.1])
    slope = [(spring.potential(q + h) - spring.potential(q - h)) / 2e-4 for h in 1e-4 * np.eye(3)]
    assert largest(spring.torques(0.0, q, np.zeros(3)) + slope) < 1e-10


@pytest.mark.parametrize("name", ["push", "rotation"])
def test_a_force_pulls_down_its_potential(name: str) -> None:
    """Forces and moments on bodies at rest, by moving and turning each about its centre of mass a little."""
    effect = EFFECTS[name]
    bodies, motion = random_motion(1 if name == "push" else 3)
    zero = np.zeros_like(motion.velocity)
    still = motion._replace(velocity=zero, spin=zero, pivot_velocity=np.zeros(3))
    force, moment = effect.wrench(0.0, bodies, still)
    for i, axis in np.ndindex(*force.shape):
        h = 1e-5 * np.eye(3)[axis]
        ends = [effect.potential(bodies, _moved(bodies, still, i, sign * h, np.zeros(3))) for sign in (1, -1)]
        assert force[i, axis] == pytest.approx((ends[1] - ends[0]) / 2e-5, abs=1e-8)
        ends = [effect.potential(bodies, _moved(bodies, still, i, np.zeros(3), sign * h)) for sign in (1, -1)]
        assert moment[i, axis] == pytest.approx((ends[1] - ends[0]) / 2e-5, abs=1e-8)


def random_motion(n: int, seed: int = 3) -> tuple[fx.Bodies, fx.Motion]:
    """Bodies of any inertia in any motion."""
    random = np.random.default_rng(seed)
    A, (m, radius) = random.uniform(-1, 1, (n, 3, 3)), random.uniform(0.1, 1, (2, n))
    R = np.linalg.qr(random.normal(size=(n, 3, 3)))[0]
    R *= np.linalg.det(R)[:, None, None]
    com, tip, origin, velocity, spin = random.uniform(-1, 1, (5, n, 3))
    surroundings = random.uniform(-1, 1, (3, 3))
    return fx.Bodies(m, com, A @ A.transpose(0, 2, 1), tip, radius), fx.Motion(origin, R, velocity, spin, *surroundings)


def _moved(bodies: fx.Bodies, motion: fx.Motion, i: int, shift: np.ndarray, turn: np.ndarray) -> fx.Motion:
    """Body i shifted, and turned about its centre of mass, to second order."""
    K = np.cross(np.eye(3), turn)
    rotation, origin = motion.rotation.copy(), motion.origin.copy()
    rotation[i] = (np.eye(3) + K + K @ K / 2) @ rotation[i]
    origin[i] += shift + (motion.rotation[i] - rotation[i]) @ bodies.com[i]
    return motion._replace(origin=origin, rotation=rotation)


def test_energy_is_kept_in_a_turning_world() -> None:
    """Kinetic energy and the potentials of gravity, spring and centrifugal force: constant to 1e-10 over 2 s."""
    effects = (GRAVITY, EFFECTS["spring"], EFFECTS["rotation"])
    start = pp.Start(positions=(0.7, 0.4), velocities=(1.3, -0.8))
    scene = pp.Scene(duration=2.0, model=MODELS["one rod"], start=start, effects=effects)
    run, model = pp.simulate(scene, tolerance=1e-13), build(scene.model)
    bodies, poses, zero = model.body_arrays, kinematics.poses(model, run.q), np.zeros((1, 3))
    total = run.kinetic + kinematics.field_potential(model, poses, GRAVITY.field(0.0)) + effects[1].potential(run.q)
    for i, pose in enumerate(poses):
        total[i] += effects[2].potential(bodies, fx.Motion(pose[:, :3, 3], pose[:, :3, :3], zero, zero))
    assert np.ptp(total) < 1e-10 * largest(run.kinetic)


# --- other numbers --------------------------------------------------------------------------------------------------

SMOOTH = [name for name, effect in EFFECTS.items() if effect.smooth]


def test_what_is_smooth() -> None:
    """All but drag in proportion to the square of the speed."""
    assert sorted(set(EFFECTS) - set(SMOOTH)) == ["drag", "gust and buoyancy", "still air"]
    assert fx.Drag(coefficient=0, linear=0.1).smooth


def _values(effect: fx.Effect, xp, convert) -> list:
    """What an effect answers, on numbers made by `convert` from floats."""
    t = convert(np.array(0.7))[()]
    if isinstance(effect, fx.FieldEffect):
        return [effect.field(t, xp)]
    if isinstance(effect, fx.JointEffect):
        k = 1 if effect.on else 4
        each = effect.of_joints(np.array([0.5, 0.8]))
        given = {} if each is None else {"each": each}
        return [effect.torques(t, convert(np.linspace(-1, 1, k)), convert(np.linspace(3, -2, k)), xp, **given)]
    bodies, motion = random_motion(1 if effect.on else 3)
    return list(effect.wrench(t, bodies, fx.Motion(*(convert(x) for x in motion[:-1])), xp))


@pytest.mark.parametrize("name", EFFECTS)
def test_the_same_lines_run_on_fifty_digits(name: str) -> None:
    """Floats and mpmath's numbers agree to rounding."""
    xp = exact(50)
    for one, other in zip(_values(EFFECTS[name], np, np.asarray), _values(EFFECTS[name], xp, xp.asarray), strict=True):
        assert largest(one - other.astype(float)) < 1e-13 * max(1.0, largest(one))


LINEAR_DRAG = fx.Drag(coefficient=0, linear=0.4, wind=(1, 2, 3))


@pytest.mark.parametrize("effect", [*(EFFECTS[name] for name in SMOOTH), LINEAR_DRAG])
def test_the_same_lines_run_on_symbols(effect: fx.Effect) -> None:
    """Floats and heyoka's compiled expressions agree to rounding."""
    hy = pytest.importorskip("heyoka")
    names, numbers_in = [], []

    def variables(x: np.ndarray) -> np.ndarray:
        fresh = [f"x{len(names) + i}" for i in range(x.size)]
        names.extend(fresh)
        numbers_in.extend(x.ravel())
        return np.array([hy.expression(name) for name in fresh] or [0.0], dtype=object).reshape(x.shape)

    found = _values(effect, symbols(), variables)
    expressions = [hy.expression(x) for x in np.concatenate([np.ravel(x) for x in found])]
    compiled = hy.cfunc(expressions, [hy.expression(name) for name in names])
    expected = np.concatenate([np.ravel(x) for x in _values(effect, np, np.asarray)])
    assert largest(compiled(np.array(numbers_in)) - expected) < 1e-13 * max(1.0, largest(expected))


# --- nothing for nothing --------------------------------------------------------------------------------------------


def code_run(effects: tuple[fx.Effect, ...]) -> set[str]:
    """The functions of pendpin that evaluations of a scene run, as module.function."""
    dynamics, seen = Dynamics(build(MODELS["one rod"]), effects), set()
    derivative, _ = dynamics.engine.derivative(lambda t: None)
    y, dy = np.array([0.3, 0.2, 1.0, -2.0]), np.empty(4)

    def note(frame, event: str, _) -> None:
        if event == "call" and "pendpin" in frame.f_code.co_filename:
            seen.add(f"{Path(frame.f_code.co_filename).stem}.{frame.f_code.co_name}")

    sys.setprofile(note)
    try:
        for t in (0.0, 0.1, 0.2):
            derivative(dy, t, y)
    finally:
        sys.setprofile(None)
    return seen


def test_gravity_alone_runs_no_code_of_any_effect() -> None:
    """One evaluation is the derivative itself and Pinocchio's call: no pose, no effect."""
    assert code_run((GRAVITY,)) == {"pinocchio.derivative"}


@pytest.mark.parametrize("name", ["viscous", "spring", "motor", "push", "drag", "rotation", "support"])
def test_an_effect_runs_no_code_of_another(name: str) -> None:
    """The modules of the effects that run are those of the effects that the scene lists."""
    homes = {path.stem for path in Path(fx.__file__).parent.glob("*.py")} - {"__init__", "base", "track"}
    run = {function.partition(".")[0] for function in code_run((GRAVITY, EFFECTS[name]))} & homes
    own = type(EFFECTS[name]).__module__.rpartition(".")[2]
    assert run == {own}
