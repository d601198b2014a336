"""The compiled equations are those of the engine they stand in for: the same rates, orders and motions."""

import operator
import signal
import time
import warnings
from _thread import interrupt_main
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from effect_cases import EFFECTS, FIVE, MODELS, URDF
from laws import law
from pendpin import effects as fx
from pendpin.dynamics.compiling import EquationsOfMotion, compilable
from pendpin.dynamics.contacts import Mode
from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Compiled
from pendpin.engines.machine import llvm
from pendpin.engines.machine.llvm import Block, Callback, Code, Function
from pendpin.errors import Halted
from pendpin.ground.libraries import version
from pendpin.integrators import adaptive
from pendpin.model.build import build
from pendpin.runs.preparation import Prepared

pytest.importorskip("llvmlite", reason="llvmlite is not installed: pip install llvmlite")

SYMBOLIC = {name: effect for name, effect in EFFECTS.items() if effect.symbolic}
SEVERAL = (fx.Gravity(), SYMBOLIC["viscous"], SYMBOLIC["support"], SYMBOLIC["push"], SYMBOLIC["earth"])
EXAMPLES = Path(__file__).parents[1] / "examples"


def rates(dynamics: Dynamics, t: float, y: np.ndarray) -> np.ndarray:
    """y' of a state of the engine."""
    dy = np.empty_like(y)
    dynamics.engine.derivative(lambda t: None)[0](dy, t, y)
    return dy


@pytest.mark.parametrize("effects", [(fx.Gravity(),), SEVERAL, *((effect,) for effect in SYMBOLIC.values())], ids=str)
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


@pytest.fixture
def libraries_are_looked_at_again() -> Iterator[None]:
    """What a process remembers of its libraries is forgotten, before and after."""
    for known in (llvm.installed, adaptive.cyrk):
        known.cache_clear()
    yield
    for known in (llvm.installed, adaptive.cyrk):
        known.cache_clear()


@pytest.mark.usefixtures("libraries_are_looked_at_again")
@pytest.mark.parametrize(("module", "name", "found"), [(llvm, "llvmlite", "0.49.1"), (adaptive, "CyRK", "0.21.0")])
def test_another_series_is_noted_once(module, name: str, found: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its functions may take other arguments: slower ways take over, and one note says what brings the fast ones."""
    monkeypatch.setattr(module, "version", lambda name: found)
    model, looks = build(MODELS["one rod"]), range(3)
    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        seen = [compilable(model, [fx.Gravity()]) if module is llvm else adaptive.cyrk() for _ in looks]
    assert not any(seen)
    (note,) = notes
    assert f"{name} {found} is not used, and runs take about 8 times as long" in str(note.message)
    assert f"pip install '{name}=={module.SERIES}*'" in str(note.message)
    if module is llvm:
        with pytest.raises(pp.MissingLibrary, match=r"pip install 'llvmlite==0.50"):
            Dynamics(model, (fx.Gravity(),), "compiled")


def test_two_threads_compile_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A second code in the place of the first would free it while the first thread runs it."""

    def slow(text: str, operations: int) -> Code:
        time.sleep(0.05)  # so that the other thread comes
        return Code(text, operations)

    monkeypatch.setattr("pendpin.engines.machine.llvm.Code", slow)
    engine = Dynamics(build(MODELS["one rod"]), (fx.Gravity(),), form="angles").engine
    function = Function(EquationsOfMotion(engine, (fx.Gravity(),), 0.0).record)
    with ThreadPoolExecutor(2) as pool:
        one, other = pool.map(lambda _: function.code(), range(2))
    assert one is other


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
    assert np.abs(np.sin(run.q[:, 1])).max() > 0.999  # near the pole


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


class Clipped(fx.JointEffect):
    """A law that runs on floats alone."""

    kind: Literal["clipped"] = "clipped"

    @property
    def smooth(self) -> bool:
        return False

    def torques(self, t: Any, q: np.ndarray, v: np.ndarray, xp: Any = np) -> np.ndarray:
        return np.clip(-v, -0.1, 0.1)


def test_what_has_no_symbols_is_refused() -> None:
    scene = pp.Scene(model=MODELS["one rod"], effects=(fx.Gravity(), Clipped()))
    with pytest.raises(pp.InputError, match=r"effects\[1\]: clipped does not run on symbols"):
        pp.simulate(with_engine(scene, "compiled"))


# --- functions of Python beside machine code --------------------------------------------------------------------------

FUNCTIONS = (
    fx.Torque(lambda t, q, v: 0.3 * np.cos(q) - 0.1 * v**3 + t),
    fx.Torque(lambda t, q, v: np.array([0.2 * np.sin(5 * t) * q[1], v[0]]), joints=["phi_1", "theta_1"]),
)


@pytest.mark.parametrize("effects", [(), (fx.Gravity(),), SEVERAL, (fx.Gravity(), SYMBOLIC["drag"])], ids=str)
@pytest.mark.parametrize("model", ["one rod", "chain of 5", "thin chain of 3"])
def test_the_same_rates_with_functions(model: str, effects: tuple) -> None:
    """Pinocchio's, at a late start too: the torques of functions add up with all else, joint by joint."""
    built, random = build(MODELS[model]), np.random.default_rng(5)
    plain, compiled = (Dynamics(built, (*effects, *FUNCTIONS), engine, start=2.0) for engine in ("auto", "compiled"))
    assert not compiled.engine.compiles  # no loop of C++ can call it
    n = len(built.joints)
    for t in (0.0, 0.7):
        y = np.concatenate([random.uniform(-1.2, 1.2, n), random.uniform(-3, 3, n)])
        expected, found = rates(plain, t, y), rates(compiled, t, y)
        assert np.abs(found - expected).max() < 3e-12 * np.abs(expected).max()  # as in test_the_same_rates


@pytest.mark.parametrize(
    ("every", "options"),
    [
        (None, {}),
        (None, {"method": "rk4", "step": 0.005}),
        (0.05, {"energy_balance": True}),
        *(
            pytest.param(every, options, marks=pytest.mark.slow)
            for every, options in (
                (0.05, {}),
                (0.05, {"method": "rk4", "step": 0.005}),
                (None, {"energy_balance": True}),
            )
        ),
    ],
    ids=str,
)
def test_the_same_motion_with_functions(every: float | None, options: dict) -> None:
    """A run with drag and a law of control, its samples and books, on Pinocchio and beside machine code."""
    control = fx.Torque(lambda t, q, v: -3.0 * q - v, joints=["theta_2"], every=every)
    scene = pp.Scene(
        duration=0.3,
        model=pp.Chain(rods=FIVE[:2]),
        start=pp.Start(positions={"theta_1": 0.7, "phi_2": 0.3}),
        effects=(fx.Gravity(), fx.Drag(density=30.0), control),
    )
    setting = options if "step" in options else options | {"tolerance": 1e-12}
    plain, run = (pp.simulate(with_engine(scene, name), **setting) for name in ("pinocchio", "auto"))
    assert run.stats.engine == "pinocchio, compiled"
    pairs = [(getattr(plain, name), getattr(run, name), name) for name in ("q", "v", "a", "wrench", "kinetic")]
    for one, other, name in [*pairs, *((plain.work[kind], run.work[kind], kind) for kind in plain.work)]:
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(one).max(), err_msg=name)
    assert set(plain.work) == set(run.work)


def test_functions_beside_contacts_are_not_compiled() -> None:
    """What is held goes to the machine code in the place of their torques."""
    effects = fx.Gravity(), fx.DryFriction(kinetic=0.1), FUNCTIONS[0]
    scene = pp.Scene(duration=0.1, model=MODELS["one rod"], effects=effects)
    assert pp.simulate(scene).stats.engine == "pinocchio"
    with pytest.raises(pp.InputError, match='"compiled" takes no Torque beside stops and dry friction; leave it out'):
        pp.simulate(with_engine(scene, "compiled"))


# --- contacts and work ----------------------------------------------------------------------------------------------

CONTACTS = (
    fx.Gravity(),
    fx.Viscous(coefficient=0.1),
    fx.DryFriction(kinetic=0.2, static=0.5, stribeck=0.3, joints=("theta_1", "phi_2")),
    fx.DryFriction(kinetic=0.1, joints=("theta_3",)),
    fx.Stop(lower=-1.0, upper=1.5, joints=("phi_1", "theta_4")),
)


@law(20)
@given(seed=st.integers(0, 2**32 - 1))
def test_held_joints(seed: int) -> None:
    """The articulated body of a held joint goes on as it is; Pinocchio's inverse mass matrix gives the same torques."""
    model, random = build(MODELS["chain of 5"]), np.random.default_rng(seed)
    plain, compiled = (Dynamics(model, CONTACTS, engine) for engine in ("auto", "compiled"))
    assert plain.contacts is not None
    assert compiled.contacts is not None
    assert isinstance(compiled.engine, Compiled)
    machine = replace(compiled.contacts, block=compiled.engine.block())
    held = plain.contacts.holding & (random.uniform(size=10) < 0.5)
    q, v = random.uniform(-1.2, 1.2, 10), np.where(held, 0.0, random.uniform(-3, 3, 10))
    mode = Mode(held, np.where(held, 0.0, np.sign(v)), np.zeros(10))
    (a, holding), (own, own_holding) = (contacts.accelerate(0.0, q, v, mode) for contacts in (plain.contacts, machine))
    assert np.abs(own - a).max() < 1e-11 * np.abs(a).max()  # light rods on heavy: condition 1e3
    assert np.abs(own_holding - holding).max() < 1e-11 * max(1.0, np.abs(holding).max())
    assert (own[held] == 0).all()


@pytest.mark.parametrize("name", ["friction", "stops"])
def test_the_same_events(name: str) -> None:
    """From event to event as SciPy on Pinocchio: the same number of events, and the same motion."""
    pytest.importorskip("CyRK", reason="CyRK is not installed: pip install CyRK")
    scene = pp.load_scene(EXAMPLES / f"{name}.toml")
    plain, own = (
        pp.simulate(with_engine(scene, engine), energy_balance=True, duration=3.0)
        for engine in ("pinocchio", "compiled")
    )
    assert (plain.stats.library, own.stats.library) == ("scipy", "CyRK")
    assert own.stats.events == plain.stats.events
    np.testing.assert_allclose(own.q, plain.q, atol=1e-6)
    for kind, work in plain.work.items():
        np.testing.assert_allclose(own.work[kind], work, atol=1e-6)


@pytest.mark.parametrize("model", ["chain of 5", pytest.param("thin chain of 3", marks=pytest.mark.slow)])
def test_work_in_machine_code(model: str) -> None:
    """The work of every effect, integrated with the motion in machine code and in Python."""
    pytest.importorskip("CyRK", reason="CyRK is not installed: pip install CyRK")
    thin = "thin" in model
    moving = (fx.Support(amplitude=(0.1, 0, 0), frequency=3.0), fx.Drag(wind=(1, 2, 0), diameter=0.1))
    effects = (fx.Gravity(), *moving, *(() if thin else (SYMBOLIC["push"], SYMBOLIC["viscous"])))
    scene = pp.Scene(
        duration=1.0, model=MODELS[model], start=pp.Start(positions={"theta_1": 0.5, "phi_1": 0.2}), effects=effects
    )
    plain, own = (
        pp.simulate(with_engine(scene, name), tolerance=1e-11, energy_balance=True)
        for name in ("pinocchio", "compiled")
    )
    assert own.stats.engine.endswith("compiled")
    assert own.imbalance < 1e-8
    for kind, work in plain.work.items():
        np.testing.assert_allclose(own.work[kind], work, atol=1e-8 * max(1.0, np.abs(work).max()))


# --- integrators that call machine code themselves ------------------------------------------------------------------


@pytest.mark.parametrize(
    "method", ["dop853", "lsoda", *(pytest.param(name, marks=pytest.mark.slow) for name in ("rk45", "radau"))]
)
def test_without_python_it_is_the_same_motion(method: str) -> None:
    """CyRK's loops around the machine code and around Pinocchio: the same steps, but for rounding."""
    pytest.importorskip("CyRK", reason="CyRK is not installed: pip install CyRK")
    scene = pp.Scene(
        duration=2.0, model=MODELS["chain of 5"], start=pp.Start(positions={"theta_1": 0.5}), effects=SEVERAL
    )
    own, other = (
        pp.simulate(with_engine(scene, name), method=method, tolerance=1e-9) for name in ("compiled", "pinocchio")
    )
    assert own.stats.library == "CyRK"
    assert abs(own.stats.steps - other.stats.steps) <= 0.02 * other.stats.steps
    assert abs(own.stats.evaluations - other.stats.evaluations) <= 0.05 * other.stats.evaluations
    np.testing.assert_allclose(own.q, other.q, atol=1e-6)


def test_methods_have_cyrks_numbers() -> None:
    """The installed CyRK is of the series whose numbers pendpin knows; of another, its loops are not taken."""
    pytest.importorskip("CyRK", reason="CyRK is not installed: pip install CyRK")
    from CyRK.cy.cysolver_api import ODEMethod

    assert version("CyRK").startswith(adaptive.SERIES)
    assert {name: int(ODEMethod[name.upper()]) for name in adaptive.PLACES} == adaptive.PLACES


def test_another_cyrk_is_called_from_python(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("CyRK", reason="CyRK is not installed: pip install CyRK")
    scene = pp.Scene(model=MODELS["one rod"], start=pp.Start(positions={"theta_1": 0.5}), effects=SEVERAL[:2])
    scene = with_engine(scene, "compiled", samples=3)
    own = pp.simulate(scene, duration=1.0, method="dop853", tolerance=1e-9)
    monkeypatch.setattr(adaptive, "cyrk", lambda: None)
    other = pp.simulate(scene, duration=1.0, method="dop853", tolerance=1e-9)
    assert own.stats.steps == other.stats.steps
    np.testing.assert_allclose(other.q, own.q, atol=1e-12)


def test_a_run_in_machine_code_can_be_stopped() -> None:
    """What the progress callback raises, a limit or an interrupt, ends the run with the part that there is."""
    pytest.importorskip("CyRK", reason="CyRK is not installed: pip install CyRK")
    scene = pp.Scene(
        duration=1e4, model=MODELS["one rod"], start=pp.Start(positions={"theta_1": 0.5}), effects=SEVERAL[:2]
    )
    scene = with_engine(scene, "compiled", samples=2)
    pp.simulate(scene, method="dop853", duration=1.0)  # compiles
    with pytest.raises(pp.RunError, match="it takes over 0 s"):
        pp.simulate(scene, method="dop853", tolerance=1e-10, limit=0.0)


def test_machine_code_that_is_stopped_goes_no_farther(monkeypatch: pytest.MonkeyPatch) -> None:
    """After the callback has raised, no step succeeds: the times that are asked about shrink to the one of the stop."""
    pytest.importorskip("CyRK", reason="CyRK is not installed: pip install CyRK")
    solver, start = pp.Solver(engine="compiled", samples=2), pp.Start(positions={"theta_1": 0.5})
    scene = pp.Scene(duration=1e5, model=MODELS["one rod"], start=start, effects=SEVERAL[:1], solver=solver)
    times, real = list[float](), Block.on_progress

    def on_progress(block: Block, callback: Callable[[float], bool]) -> None:
        def answer(t: float) -> bool:
            if stop := callback(t):
                times.append(t)
            return stop

        real(block, answer)

    def stop_at_once(t: float) -> None:
        if t > 0:
            raise Halted("at once")

    monkeypatch.setattr(Block, "on_progress", on_progress)
    with pytest.raises(Halted):
        pp.simulate(scene, method="dop853", tolerance=1e-10, progress=stop_at_once)
    assert times
    assert max(times) - times[0] < 1.0  # s, of 100,000
    assert len(times) < 2000  # evaluations of steps that fail, ever shorter ones


def test_ctrl_c_in_machine_code_stops_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """A signal that comes while CyRK computes is still pending when CyRK calls back: the answer is to stop."""
    pytest.importorskip("CyRK", reason="CyRK is not installed: pip install CyRK")
    answers, real = [], Block.on_progress

    def on_progress(block: Block, callback: Callable[[float], bool]) -> None:
        answers.extend(map(operator.call, (interrupt_main, partial(Callback(callback), 0.0))))  # no Python in between
        real(block, callback)

    monkeypatch.setattr(Block, "on_progress", on_progress)
    scene = with_engine(pp.Scene(duration=1.0, model=MODELS["one rod"]), "compiled", samples=2)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # it is off where tests run in the background
    try:
        pp.simulate(scene, method="dop853")
    finally:
        signal.signal(signal.SIGINT, before)
    assert answers == [None, True]


def with_engine(scene: pp.Scene, engine: str, **others: int) -> pp.Scene:
    return scene.model_copy(update={"solver": scene.solver.with_settings(engine=engine, **others)})


# --- what stays 0 in a motion -----------------------------------------------------------------------------------------

TWO = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.05), pp.Rod(length=0.7, mass=0.5, radius=0.03)])
PLANES = {
    "two rods in a plane of theta": (TWO, {"theta_1": 2.0, "theta_2": -1.0}, {"theta_2": 0.5}, 4),
    "two rods in a plane of phi": (TWO, {"phi_1": 0.7, "phi_2": -0.4}, {"phi_1": 0.5}, 4),
    "thin rods in a plane": (pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)] * 2), {"theta_1": 2.0}, {}, 6),
}


@pytest.mark.parametrize("method", ["dop853", "radau", "taylor"])
@pytest.mark.parametrize("plane", PLANES)
def test_what_stays_0_is_not_integrated(plane: str, method: str) -> None:
    """A motion in a plane is that of a start 1e-200 beside the plane, by equations of half as many numbers."""
    pytest.importorskip("heyoka" if method == "taylor" else "CyRK")
    model, positions, velocities, size = PLANES[plane]
    start = pp.Start(positions=positions, velocities=velocities)
    scene = pp.Scene(duration=2.0, model=model, start=start, effects=[fx.Gravity()]).by(method, 1e-11)
    prepared = Prepared.of(scene)
    assert len(prepared.dynamics.engine.pack(prepared.q, prepared.v)) == size
    beside = np.where(prepared.q == 0, 1e-200, prepared.q)
    other = scene.replace(start=pp.Start(positions=beside.tolist(), velocities=prepared.v.tolist()))
    assert len(Prepared.of(other).dynamics.engine.pack(beside, prepared.v)) > size
    one, two = pp.simulate(scene), pp.simulate(other)
    for name in ("q", "v", "a", "wrench", "tips"):
        np.testing.assert_allclose(getattr(one, name), getattr(two, name), atol=2e-8, err_msg=name)


def test_equations_of_a_plane_refuse_another_motion() -> None:
    """Where a state leaves the plane, nothing is dropped in silence."""
    scene = pp.Scene(duration=1.0, model=TWO, start=pp.Start(positions={"theta_1": 1.0}), effects=[fx.Gravity()])
    engine = Prepared.of(scene).dynamics.engine
    with pytest.raises(ValueError, match="leaves the plane"):
        engine.pack(np.full(4, 0.1), np.zeros(4))
