"""The methods beside the adaptive one: their orders, what they keep, the exact solutions, and what they refuse."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from importlib.util import find_spec
from itertools import pairwise

import numpy as np
import pytest

import pendpin as pp
from effect_cases import EFFECTS
from pendpin import effects as fx
from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import CanonicalForm
from pendpin.integrators.base import Integrator, Run, StepPlan
from pendpin.integrators.choice import integrator_class, integrator_for
from pendpin.integrators.gauss import Gauss, rule
from pendpin.model.build import build
from pendpin.runs.limits import Deadline
from pendpin.runs.preparation import Prepared
from pendpin.runs.run import loop_of, run_prepared
from pendpin.scene import METHODS, fixed_methods, method_of
from scenes import scene_of

GRAVITY = fx.Gravity()
THICK = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.1),))
TWO = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.1), pp.Rod(length=0.7, mass=0.5, radius=0.05)))
THIN = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0),))
THIN_TWO = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0), pp.Rod(length=0.7, mass=0.5)))
ORDERS = {name: METHODS[name].order for name in fixed_methods()}
STEPS = {"euler": 1 / 512, "rk4": 1 / 64, "gauss2": 1 / 64, "gauss4": 1 / 32, "gauss6": 1 / 32}  # s; else 1/256
needs_heyoka = pytest.mark.skipif(find_spec("heyoka") is None, reason="heyoka is not installed: pip install heyoka")


def scene(
    model, *effects, duration=1.0, samples=5, q=(0.7, 0.4, -0.3, 0.2), v=(1.3, -0.8, 0.2, 0.5), **solver
) -> pp.Scene:
    """A chain from a start that takes its angles and rates in turn from those given."""
    nv = 2 * model.count
    given = {"q": np.resize(q, nv), "v": np.resize(v, nv), "duration": duration, "samples": samples}
    return scene_of(model, GRAVITY, *effects, **given, **solver)


def apart(one: pp.Trajectory, other: pp.Trajectory) -> float:
    """The largest distance between tips, m."""
    return float(np.linalg.norm(one.tips - other.tips, axis=-1).max())


# --- segments ----

TWELVE = pp.Chain(rods=(pp.Rod(length=0.2, mass=1.0),), copies=12)


@pytest.mark.parametrize("method", ORDERS)
@pytest.mark.parametrize(
    ("model", "engine"),
    [(THIN, "auto"), (THIN, "compiled"), (THIN_TWO, "auto"), (TWELVE, "auto"), (THICK, "auto"), (THICK, "compiled")],
)
def test_cutting_a_run_changes_nothing(method: str, model: pp.Chain, engine: str) -> None:
    """Segments of one or two samples, and of all of them, give the same motion but for the rounding of the times."""
    angles = method.startswith("gauss") or method == "euler"
    if angles and (engine == "compiled" or not model.all_rods[0].radius):
        return
    given = scene(model, duration=1.0, samples=11, method=method, step=1 / 256, engine=engine)

    def cut(most: int) -> Run:
        prepared = Prepared.of(given)
        loop = loop_of(prepared, lambda t: None)
        done = loop.begin(prepared.q, prepared.v)
        while done.n < len(done.room):
            done, failure = loop.go_on(replace(done, last=done.last._replace(most=most)))
            assert failure is None
        return loop.finish(done, None, None)

    whole, *parts = map(cut, (100, 1, 2))
    shifted_by_nothing = run_prepared(Prepared.of(given), lambda t: None, Deadline(None), shifts=(0.0, 2))
    for q, steps in [*((part.q, part.steps) for part in parts), (shifted_by_nothing.q, shifted_by_nothing.stats.steps)]:
        assert np.abs(q - whole.q).max() < 1e-12
        assert steps == whole.steps


# --- orders ---------------------------------------------------------------------------------------------------------

SHAKEN = fx.Support(amplitude=(0.1, 0.05, -0.1), frequency=3.0)


@pytest.mark.parametrize("method", ORDERS)
@pytest.mark.parametrize("case", ["one rod", "two rods", "shaken and damped"])
def test_measured_order(method: str, case: str) -> None:
    """Over three halvings of the step the error at the samples falls with the method's order, to 0.1."""
    cases = {"one rod": (THICK,), "two rods": (TWO,), "shaken and damped": (THICK, SHAKEN, fx.Viscous(coefficient=0.2))}
    given = scene(*cases[case])
    reference = pp.simulate(given, tolerance=1e-13)
    steps = STEPS.get(method, 1 / 256) / np.array([1, 2, 4, 8])
    errors = [apart(pp.simulate(given, method=method, step=step), reference) for step in steps]
    orders = [np.log2(a / b) for a, b in pairwise(errors) if b > 2e-12]
    assert len(orders) > 0
    assert np.abs(np.array(orders) - ORDERS[method]).max() < 0.1


def conical(theta: float = 0.5) -> tuple[pp.Dynamics, np.ndarray, Callable[[float], np.ndarray]]:
    """A thin rod whose tip goes round a circle: its dynamics, its state at 0, and the tip (3,) at a time in s, exact."""
    dynamics = Dynamics(build(THIN), (GRAVITY,), form="angles")
    rate = np.sqrt(9.81 / (2 / 3 * np.cos(theta)))  # 2 l / 3 is the length of the equivalent point mass
    level, down = np.sin(theta), -np.cos(theta)
    state = np.array([theta, 0.0, 0.0, rate * np.sin(theta)])

    def tip(t: float) -> np.ndarray:
        return np.array([level * np.sin(rate * t), -level * np.cos(rate * t), down])

    return dynamics, state, tip


@pytest.mark.parametrize("name", [name for name, method in METHODS.items() if method.order is not None])
@pytest.mark.parametrize("compiled", [False, True], ids=["called from Python", "compiled"])
def test_every_method_has_the_order_of_its_record(name: str, compiled: bool) -> None:
    """Steps of h and of h/2 on the exact conical motion: the errors differ by 2 to the order, for all in the table.

    An adaptive method gets a tolerance that it always meets and h as its longest step.
    """
    method, (dynamics, y, tip) = METHODS[name], conical()
    if compiled:
        if not method.machine_code or find_spec("llvmlite") is None:
            return
        dynamics = dynamics.in_machine_code
    longest = 0.5 / max(1, 9 - method.order) ** 1.5 / 2
    end, errors = 1.0, []
    for halvings in range(3):
        h = end / (np.ceil(end / longest) * 2**halvings)
        setting = {"step": h} if method.setting == "step" else {"tolerance": 0.1}
        integrator = integrator_for(scene(THIN, method=name, **setting), dynamics)
        derivative, _ = integrator.equations(dynamics.engine, lambda t: None)
        segment = integrator.integrate(derivative, y, np.array([0.0, end]), StepPlan(first=h, longest=h))
        q = segment.y[-1, :2]
        reached = np.array([np.sin(q[1]), -np.sin(q[0]) * np.cos(q[1]), -np.cos(q[0]) * np.cos(q[1])])
        errors.append(float(np.linalg.norm(reached - tip(end))))
    measured = np.log2(errors[-2] / errors[-1])
    assert abs(measured - method.order) < 0.1, errors


def test_every_record_has_its_class_and_a_color_of_its_own() -> None:
    """A record leads to the class that integrates; a name without a record cannot be run."""
    assert all(issubclass(integrator_class(method), Integrator) for method in METHODS.values())
    assert len({method.color for method in METHODS.values()}) == len(METHODS)
    assert sorted(method.price_rank for method in METHODS.values()) == list(range(len(METHODS)))
    unknown = scene(THIN).model_copy(update={"solver": scene(THIN).solver.model_copy(update={"method": "no_method"})})
    with pytest.raises(pp.InputError, match=r"solver\.method: .*no_method.*dop853"):
        pp.simulate(unknown)


@pytest.mark.parametrize("method", ["dop853", "rk45", "radau", pytest.param("taylor", marks=needs_heyoka)])
def test_error_falls_with_tolerance(method: str) -> None:
    """Over 8 decades of tolerance the error falls, by 4 decades and more in all."""
    given, last = scene(THICK), 1e-13 if method != "radau" else 1e-11
    reference = pp.simulate(given, tolerance=1e-14)
    errors = [apart(pp.simulate(given, method=method, tolerance=last * 10.0**k), reference) for k in (8, 6, 4, 2, 0)]
    assert all(b < a or b < 1e-13 for a, b in pairwise(errors))
    assert errors[-1] < max(1e-4 * errors[0], 1e-13)


@pytest.mark.parametrize("method", ORDERS)
def test_the_step_asked_is_the_step_taken(method: str) -> None:
    """Wherever the samples are: at the ends of its steps the motion is the same, but for the rounding of the times."""
    given = scene(THICK, duration=1.0, method=method, step=0.05)
    on, between, coarse = (pp.simulate(given, samples=samples, anyway=True) for samples in (21, 121, 4))
    assert [run.stats.steps for run in (on, between, coarse)] == [20, 20, 20]
    assert [run.stats.step for run in (on, between, coarse)] == [0.05] * 3
    assert np.abs(between.q[::6] - on.q).max() < 1e-13  # twenty steps at rates of order 1, whose times round to 1e-16
    assert np.abs(coarse.q[-1] - on.q[-1]).max() < 1e-13


@pytest.mark.parametrize("method", ORDERS)
def test_samples_inside_steps_have_the_order_of_the_method(method: str) -> None:
    """Of samples that fall on no end of a step but the first, the errors fall as the steps to the power of the order."""
    given, times = scene(THICK, duration=1.0), np.linspace(0.0, 1.0, 38)
    reference = pp.simulate(given, times=times, method="dop853", tolerance=1e-13)
    errors = [
        np.abs(pp.simulate(given, times=times, method=method, step=step, anyway=True).q - reference.q).max()
        for step in (0.04, 0.02)
    ]
    # the next term of the error is a fraction of the step smaller, some tenths here
    assert np.log2(errors[0] / errors[1]) == pytest.approx(ORDERS[method], abs=0.35)


def test_a_step_longer_than_the_run_is_all_of_it() -> None:
    """The last step may be shorter, and the table says how long it was."""
    slow = pp.Chain(rods=(pp.Rod(length=10.0, mass=1.0, radius=0.1),))
    runs = [pp.simulate(scene(slow, duration=0.1, samples=2), method="rk4", step=step) for step in (0.1, 5.0)]
    assert np.array_equal(runs[0].q, runs[1].q)
    assert [run.stats.step for run in runs] == [0.1, 0.1]
    assert runs[0].stats.tolerance is None


def test_a_run_anyway_reaches_its_end() -> None:
    """Its energy is off and a note says from when on; up to there it is the run that ends with an error."""
    start = pp.Start(positions={"theta": 0.5}, velocities={"theta": 3.0})
    rod = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1, mass=1)]), start=start, effects=["gravity"], duration=6.0)
    given = rod.with_solver(method="euler", step=0.04)
    with pytest.raises(pp.RunError) as error:
        pp.simulate(given)
    cut, run = error.value.partial, pp.simulate(given, anyway=True)
    assert run.t[-1] == 6.0
    assert np.array_equal(run.q[: len(cut.t)], cut.q)
    assert run.stats.notes[0].startswith(f"from t = {run.t[len(cut.t)]:.6g} s on the energy is off by over a tenth")
    calm = given.with_solver(method="gauss4", step=0.01)
    assert pp.simulate(calm, anyway=True) == pp.simulate(calm)
    with pytest.raises(pp.InputError, match="anyway: a run with a wrong energy"):
        pp.simulate(scene(TWO), accuracy=1e-3, anyway=True)


def test_a_run_that_ends_early_counts_its_steps_up_to_there() -> None:
    """Two and a half steps a sample, too coarse for a rod of 1 m: the run is cut where its energy is off."""
    start = pp.Start(positions={"theta": 0.5}, velocities={"theta": 3.0})
    rod = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1, mass=1)]), start=start, effects=[pp.effects.Gravity()])
    with pytest.raises(pp.RunError) as error:
        pp.simulate(rod.replace(duration=6.0), method="euler", step=0.04, samples=61)
    run = error.value.partial
    assert run.stats.steps == int(run.t[-1] / 0.04 + 1e-9) > 0
    assert run.stats.step == 0.04
    assert 0.01 < run.energy().drift <= 0.1


@pytest.mark.parametrize("theta", [0.7, 3.0])
@pytest.mark.parametrize(("method", "step"), [("euler", 0.01), ("euler", 0.1), ("rk4", 0.1), ("rk4", 0.3)])
def test_runs_from_rest_have_a_drift_of_a_tenth_at_most(method: str, step: float, theta: float) -> None:
    """The drift that is shown decides: a run ends there or is whole. At rest nothing is exchanged, which ends no run."""
    rod = pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1, mass=1)]), start=pp.Start(positions={"theta": theta}))
    given = rod.replace(duration=6.0, effects=[pp.effects.Gravity()])
    with suppress(pp.RunError):
        assert pp.simulate(given, method=method, step=step).energy().drift <= 0.1
        return
    assert step > 0.01
    with pytest.raises(pp.RunError, match="the energy is off by over a tenth of the energy exchanged") as error:
        pp.simulate(given, method=method, step=step)
    assert error.value.partial.energy().drift <= 0.1


# --- Gauss methods --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("s", [1, 2, 3])
def test_rule_is_symplectic_and_of_its_order(s: int) -> None:
    """b_i a_ij + b_j a_ji = b_i b_j exactly in w, sum_j a_ij c_j^(k-1) = c_i^k / k and sum b_j c_j^(k-1) = 1 / k."""
    c, b, w, a = rule(s)
    assert (w == -w.T).all()
    for k in range(1, 2 * s + 1):
        np.testing.assert_allclose(b @ c ** (k - 1), 1 / k, rtol=1e-15)
        if k <= s:
            np.testing.assert_allclose(a @ c ** (k - 1), c**k / k, rtol=0, atol=5e-16)


def test_canonical_form_is_the_lagrangian_one() -> None:
    """Along the motion p' = F; F = dL/dq by central differences of v p / 2 - potential; the slopes by differences too."""
    dynamics = Dynamics(build(TWO), (GRAVITY, EFFECTS["spring"], EFFECTS["push"]), form="angles")
    form, (q, v) = CanonicalForm(dynamics.engine.model, dynamics.loads), np.random.default_rng(4).normal(size=(2, 4))
    a, h = dynamics.acceleration(0.3, q, v), 1e-5
    ends = [form.momentum(q + s * h * v + h * h / 2 * a, v + s * h * a) for s in (1, -1)]
    now = form.at(0.3, q, v)
    np.testing.assert_allclose(now.force, (ends[0] - ends[1]) / (2 * h), rtol=1e-7, atol=1e-8)
    np.testing.assert_allclose(now.mass @ v, form.momentum(q, v), rtol=0, atol=1e-14)
    np.testing.assert_allclose(form.velocity(q, form.momentum(q, v)), v, rtol=0, atol=1e-13)


@pytest.mark.parametrize("method", ["gauss2", "gauss4", "gauss6"])
@pytest.mark.parametrize("model", [THICK, TWO], ids=["one rod", "two rods"])
def test_a_step_is_symplectic(method: str, model: pp.Chain) -> None:
    """D^T S D = S for the derivative D of one large step in (q, p), by central differences; S = [[0, 1], [-1, 0]]."""
    dynamics = Dynamics(build(model), (GRAVITY,), form="angles")
    form, nv = CanonicalForm(dynamics.engine.model, dynamics.loads), len(dynamics.model.joints)

    def step(x: np.ndarray) -> np.ndarray:
        integrator = Gauss(method_of(method), 0.1)
        derivative, _ = integrator.equations(dynamics.engine, lambda t: None)
        y = np.concatenate([x[:nv], form.velocity(*np.split(x, 2))])
        end = integrator.integrate(derivative, y, np.array([0.0, 0.1])).y[-1]
        return np.concatenate([end[:nv], form.momentum(*np.split(end, 2))])

    q, v = np.random.default_rng(2).normal(size=(2, nv))
    x, h = np.concatenate([q, form.momentum(q, v)]), 1e-5
    D = np.array([(step(x + h * e) - step(x - h * e)) / (2 * h) for e in np.eye(2 * nv)]).T
    S = np.kron([[0, 1], [-1, 0]], np.eye(nv))
    assert np.abs(D.T @ S @ D - S).max() < 1e-8 * np.abs(D).max() ** 2
    assert np.abs(D - np.eye(2 * nv)).max() > 0.1  # it moved


@pytest.mark.parametrize("method", ["gauss2", "gauss4", "gauss6"])
def test_gauss_runs_back_to_its_start(method: str) -> None:
    """Reversibility to round-off at a coarse step: forward, the rates reversed, forward again."""
    there = pp.simulate(scene(TWO, duration=2.0), method=method, step=0.05)
    back = pp.simulate(scene(TWO, duration=2.0, q=there.q[-1], v=-there.v[-1]), method=method, step=0.05)
    assert np.abs(back.q[-1] - there.q[0]).max() < 1e-11
    assert np.abs(back.v[-1] + there.v[0]).max() < 1e-10


def test_gauss_keeps_energy_within_bounds() -> None:
    """Over about 200 swings at 22 steps a swing the energy error of gauss4 does not grow; that of rk4 does."""
    given = scene(THICK, duration=320.0, samples=321)
    errors = []
    for method in ("gauss4", "rk4"):
        total = pp.simulate(given, method=method, step=0.08).energy().total
        errors.append([np.abs(part - total[0]).max() / abs(total[0]) for part in np.array_split(total, 4)])
    (first, *_, last), (rk4_first, *_, rk4_last) = errors
    assert last < 1.1 * first < 1e-3
    assert rk4_last > 2 * rk4_first


def test_gauss_sums_are_compensated() -> None:
    """gauss6 at a step with a truncation error below round-off: 2,500 steps leave the energy to 1e-13."""
    run = pp.simulate(scene(THICK, duration=25.0), method="gauss6", step=0.01)
    assert run.energy().drift < 3e-13


def test_gauss_integrates_the_work() -> None:
    """What is integrated beside the motion has its order: kinetic and potential energy change by what the air takes."""
    run = pp.simulate(scene(THICK, fx.Viscous(coefficient=0.2)), method="gauss6", step=0.01, energy_balance=True)
    assert abs(run.work["viscous"][-1] - (run.energy().total[-1] - run.energy().total[0])) < 1e-10


# --- what is refused ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"method": "rk4", "step": 0.0}, "step: 0.0 is not above 0"),
        ({"method": "rk4", "step": -1.0}, "step: -1.0 is not above 0"),
        ({"method": "rk4"}, "step: rk4 takes a step, in s"),
        ({"method": "gauss4", "tolerance": 1e-8}, "tolerance: gauss4 takes a step, not a tolerance"),
        ({"method": "rk4", "step": 0.01, "tolerance": 1e-8}, "tolerance: rk4 takes a step, not a tolerance"),
        ({"method": "dop853", "step": 0.01}, "step: dop853 takes a tolerance"),
        ({"step": 0.01, "tolerance": 1e-8}, "step: auto takes a tolerance"),
        ({"method": "taylor", "tolerance": 1e-19}, "tolerance: 1e-19 is below 1e-18"),
        ({"method": "rk4", "step": 1e-12}, "solver.step: 1e-12 s takes more than 1e+09 steps"),
        ({"method": "rk4", "step": 5e-324}, "solver.step: 5e-324 s takes"),
    ],
)
def test_settings_that_do_not_fit(given: dict, message: str) -> None:
    with pytest.raises(pp.InputError) as caught:
        pp.simulate(scene(THICK), **given)
    assert message in str(caught.value)


def test_a_fault_that_follows_from_another_is_not_counted() -> None:
    """That no step is given follows from the tolerance in its place."""
    with pytest.raises(pp.InputError) as caught:
        pp.simulate(scene(THICK), method="rk4", tolerance=1e-9)
    assert str(caught.value).endswith("rk4 takes a step, not a tolerance")


def test_a_setting_given_in_the_call_displaces_that_of_the_scene() -> None:
    """A tolerance or a step of the scene that the method given in the call does not take is left out."""
    assert pp.simulate(scene(THICK, tolerance=1e-6), method="rk4", step=0.1).stats.tolerance is None
    assert pp.simulate(scene(THICK, method="rk4", step=0.1), method="rk45").stats.tolerance == 1e-10


@pytest.mark.parametrize("method", ["rk4", "gauss4", "taylor"])
def test_contacts_are_left_to_the_adaptive_lane(method: str) -> None:
    solver = {"method": method} | ({} if method == "taylor" else {"step": 0.01})
    with pytest.raises(pp.InputError, match=f"solver.method: {method}.*dop853|is not smooth"):
        pp.simulate(scene(THICK, fx.Stop(upper=1.0), **solver))


def test_gauss_needs_pinocchio() -> None:
    with pytest.raises(pp.InputError, match="need Pinocchio"):
        pp.simulate(scene(THICK, method="gauss4", step=0.01, engine="chain"))


def test_a_step_far_too_large_ends_in_one_line() -> None:
    """Where the stage equations have no solution in reach, or the numbers overflow."""
    fast = {"v": (300.0, 200.0), "duration": 40.0}
    for method in ("gauss4", "rk4"):
        with pytest.raises(pp.RunError, match=r"take a smaller (tolerance or )?step|not a finite number|grow beyond"):
            pp.simulate(scene(THICK, **fast), method=method, step=10.0)
