"""Measures of a sweep against exact values: of linear motions, and of a rod that goes over the top."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import ellipk

import pendpin as pp
from pendpin import effects as fx
from pendpin.model.build import build
from pendpin.model.kinematics import swings_of_chain, tilts_of_chain
from pendpin.sweeps.extremes import largest
from pendpin.sweeps.measures import (
    MEASURES,
    STATISTICS,
    _difference,
    accumulated,
    divergence,
    evaluate_measure,
    flip_time,
    lyapunov,
    measure,
    period,
    settling_time,
    swing,
)
from sweep_scenes import ROD

pytest.importorskip("xarray")
pytest.importorskip("heyoka")

INERTIA = ROD.properties.I1 + ROD.mass * ROD.properties.h**2  # kg m², about the joint
THIN = pp.Rod(length=1.0, mass=1.0)
UPRIGHT = math.sqrt(1.5 * 9.81)  # 1/s, the rate at which a thin rod of 1 m falls from upright


def sprung(damping: float, duration: float = 10.0, start: float = 0.7) -> pp.Scene:
    """A rod that is turned by a spring of 4 rad²/s² and by friction alone: a linear motion of theta; no gravity."""
    return pp.Scene(
        duration=duration,
        model=pp.Chain(rods=[ROD]),
        start=pp.Start(positions={"theta": start}),
        effects=[fx.Spring(stiffness=4 * INERTIA), fx.Viscous(coefficient=2 * damping * INERTIA)],
        solver=pp.Solver(tolerance=1e-11, samples=round(duration * 100) + 1),
    )


def exact(damping: float, t: np.ndarray | float) -> np.ndarray:
    """theta'' + 2 damping theta' + 4 theta = 0, from rest at 1."""
    root = np.emath.sqrt(damping**2 - 4.0)
    return np.real(np.exp(-damping * np.asarray(t)) * (np.cosh(root * t) + damping / root * np.sinh(root * t)))


def settled_at(damping: float, duration: float) -> float:
    """The last time at which the exact motion is 2 % of its largest distance away from where it ends."""
    end = exact(damping, duration)
    grid = np.linspace(0, duration, 100_001)
    away = np.abs(exact(damping, grid) - end)
    late = int(np.flatnonzero(away > 0.02 * away.max())[-1])
    return brentq(lambda t: abs(exact(damping, t) - end) - 0.02 * away.max(), grid[late], grid[late + 1])


@pytest.mark.parametrize("damping", [0.6, 1.3, 2.5])
@pytest.mark.parametrize("start", [0.7, -0.3])
def test_the_settling_time_is_when_it_is_near_for_good(damping: float, start: float) -> None:
    """The root of the exact motion, of swings and of a creep, of a run and in a sweep."""
    scene = sprung(damping, start=start)
    after = settled_at(damping, scene.duration)
    found = settling_time(pp.simulate(scene))
    assert found == pytest.approx(after, abs=1e-5)
    vectors = pp.sweep(scene, {"start.positions.theta": [start]}, "settling_time").settling_time.values
    assert vectors == pytest.approx([found], abs=1e-6)


def test_a_settling_time_does_not_depend_on_the_samples() -> None:
    """Of few samples it is that of many; nothing that moves at the end has settled, and what does not move has at once."""
    scene = sprung(0.6, start=0.7)
    few, many = (settling_time(pp.simulate(scene, samples=n, tolerance=1e-10)) for n in (61, 2001))
    assert few == pytest.approx(many, abs=1e-7)
    assert np.isnan(settling_time(pp.simulate(scene, samples=61, duration=few * 1.05)))
    assert settling_time(pp.simulate(sprung(0.6, start=0.0), samples=61)) == 0.0


@pytest.mark.parametrize("damping", [0.6, 1.3])
def test_the_spread_of_a_settling_time_covers_its_error(damping: float) -> None:
    """Of few samples too; a swing that just reaches the 2 %, or just misses it, may be either."""
    scene = sprung(damping).replace({"solver.samples": 61, "solver.method": "dop853", "solver.tolerance": 1e-6})
    found = pp.sweep(scene, {"duration": [10.0]}, ["settling_time", "settling_time.spread"])
    error = abs(float(found.settling_time[0]) - settled_at(damping, 10.0))
    assert 0 < error <= float(found["settling_time.spread"][0]) < 0.5


def test_a_swing_that_just_reaches_the_two_per_cent_may_settle_half_a_period_sooner() -> None:
    """Its time is a number; the difference of two runs would not show how little that is worth."""

    def peak(damping: float) -> float:
        """How far a turning point of the exact motion is beyond the 2 %."""
        end, turns = exact(damping, 10.0), 2 * np.pi / np.sqrt(4 - damping**2)
        return abs(exact(damping, 2.5 * turns) - end) / (1 - end) - 0.02

    touching = brentq(peak, 0.3, 0.9)
    for damping in (touching * (1 + 1e-7), touching * (1 - 1e-7)):
        scene = sprung(damping).replace({"solver.tolerance": 1e-8})
        found = pp.sweep(scene, {"duration": [10.0]}, ["settling_time", "settling_time.spread"])
        assert float(found["settling_time.spread"][0]) > 0.3


@pytest.mark.parametrize("samples", [2, 13, 71, 601])
def test_the_least_angle_of_a_sweep_is_the_turning_point(samples: int) -> None:
    """Between the samples, and of samples too few to tell: the exact one of a damped spring, after half a period."""
    scene, half = sprung(0.6).replace({"solver.samples": samples}), np.pi / math.sqrt(4 - 0.6**2)
    found = pp.sweep(scene, {"start.positions.theta": [0.7, -0.4]}, ["theta.min", "theta.max", "theta.argmax", "swing"])
    turning = exact(0.6, half) / exact(0.6, 0.0)
    np.testing.assert_allclose(found["theta.min"], [0.7 * turning, -0.4], rtol=0, atol=1e-9)
    np.testing.assert_allclose(found["theta.max"], [0.7, -0.4 * turning], rtol=0, atol=1e-9)
    np.testing.assert_allclose(found["theta.argmax"], [0.0, half], rtol=0, atol=1e-8)
    np.testing.assert_allclose(found["swing"], [0.7, 0.4], rtol=0, atol=1e-9)


@given(
    st.lists(st.tuples(st.floats(0.1, 1), st.floats(0.5, 200), st.floats(-3, 3)), min_size=1, max_size=3),
    st.integers(20, 400),
)
@example([(1.0, 2 * math.pi * 19, 0.3)], 20)  # a turn from sample to sample
def test_the_largest_value_between_samples(waves: list[tuple[float, float, float]], samples: int) -> None:
    """Of sums of sines, however many radians in a step: that of 100,001 samples, which is at most exact.

    A series that is not told apart is NaN, never a lower value.
    """
    size, rate, phase = (np.array(column)[:, None] for column in zip(*waves, strict=True))
    t, dense = np.linspace(0, 1, samples), np.linspace(0, 1, 100_001)

    def series(t: np.ndarray) -> np.ndarray:
        return (size * np.sin(rate * t + phase)).sum(0)

    value, when = largest(t, series(t)[None, :, None], (size * rate * np.cos(rate * t + phase)).sum(0)[None, :, None])
    top, slack = series(dense).max(), 1e-10 * size.sum()
    bound = (size * rate**2).sum() * (dense[1] ** 2 / 8)  # a dense sample may be so far below the top
    assert np.isnan(value[0]) or -slack <= value[0] - top <= slack + bound
    assert np.isnan(value[0]) or abs(series(when)[0] - value[0]) <= slack


def test_the_largest_value_behind_a_start_at_rest() -> None:
    """Of t² - 20,000 t⁴, which rises from rest and falls again before the second sample."""
    t = np.linspace(0, 0.1, 11)
    value, when = largest(t, (t**2 - 2e4 * t**4)[None, :, None], (2 * t - 8e4 * t**3)[None, :, None])
    assert (value[0], when[0]) == (pytest.approx(1.25e-5, rel=1e-9), pytest.approx(0.005, rel=1e-6))


@given(st.integers(0, 2**31))
def test_tilts_and_their_rates(seed: int) -> None:
    """Those of the angles from straight down, and their slopes by differences in 1e-6, of chains of one to five rods."""
    random = np.random.default_rng(seed)
    rods = random.integers(1, 6)
    q, v = random.normal(size=(2, 7, 2 * rods))
    squares, rates = tilts_of_chain(q, v)
    np.testing.assert_allclose(2 * np.arcsin(np.sqrt(squares.max(-1))), swings_of_chain(q), rtol=1e-7, atol=1e-14)
    ahead, behind = (tilts_of_chain(q + h * v, v)[0] for h in (1e-6, -1e-6))
    slack = 1e-9 * (1 + np.abs(v).sum(-1)[:, None]) ** 3  # rounding over 2e-6, and (1e-6)² / 6 of the third derivative
    assert (np.abs(rates - (ahead - behind) / 2e-6) <= slack).all()


@pytest.mark.parametrize("phi", [0.0, 0.3])
def test_the_swing_of_a_sweep_is_that_of_a_dense_run(phi: float) -> None:
    """Of two rods in a plane, some of which pass over the top, beyond a turn at the start too, and in space."""
    start = pp.Start(positions={"theta_1": 1.0, "phi_2": phi}, velocities={"theta_2": 2.0})
    solver = pp.Solver(samples=181, tolerance=1e-11)
    scene = pp.Scene(model=pp.Chain(rods=[ROD, ROD]), start=start, effects=[fx.Gravity()], duration=3.0, solver=solver)
    starts = [0.2, 1.1, 2.4, 2.9, 0.2 + 2 * np.pi, 2.9 - 4 * np.pi]
    found = pp.sweep(scene, {"start.positions.theta_1": starts}, "swing").swing.values
    for theta, value in zip(starts, found, strict=True):
        dense = pp.simulate(scene.replace({"start.positions.theta_1": theta}), samples=20_001)
        largest_sample, turned = swings_of_chain(dense.q).max(), np.cumsum(dense.q[:, ::2], 1)
        over = phi == 0 and np.abs(turned - 2 * np.pi * np.round(turned[0] / (2 * np.pi))).max() > np.pi
        bound = 0.5 * np.abs(dense.a).sum(1).max() * (dense.t[1] / 2) ** 2  # a top may be so far above a sample
        assert value == pytest.approx(np.pi, abs=1e-12) if over else -1e-7 < value - largest_sample < bound + 1e-7


def test_the_largest_force_of_a_sweep_is_between_the_samples() -> None:
    """As run.maximum says it, of few samples."""
    scene = sprung(0.6, start=0.7)
    found = pp.sweep(scene.replace({"solver.samples": 13}), {"start.positions.theta": [0.7]}, ["R3.max", "R3.argmax"])
    largest = pp.simulate(scene, samples=13).maximum("R3")
    assert found["R3.max"].values[0] == pytest.approx(largest.value, rel=1e-7)
    assert found["R3.argmax"].values[0] == pytest.approx(largest.t, abs=1e-4)


@pytest.mark.parametrize("duration", [1.0, 3.0])
def test_the_exponent_of_an_upright_rod_is_its_growth(duration: float) -> None:
    """From the same small angle and rate both ways: x = cosh + sinh / k, x' = k sinh + cosh."""
    scene = pp.Scene(
        duration=duration,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=1e-4)]),
        start=pp.Start(positions={"theta": math.pi}),
        effects=[fx.Gravity()],
        solver=pp.Solver(tolerance=1e-12, samples=101),
    )
    k, kt = UPRIGHT, UPRIGHT * duration
    grown = math.hypot(math.cosh(kt) + math.sinh(kt) / k, k * math.sinh(kt) + math.cosh(kt)) / math.sqrt(2)
    stepped = {"method": "rk4", "step": 1e-3, "tolerance": None}  # a step has no tolerance to be apart by
    for setting in ({}, stepped, {"times": tuple(np.linspace(0.0, duration, 101))}):
        assert lyapunov(pp.simulate(scene.with_solver(**setting))) == pytest.approx(
            math.log(grown) / duration, rel=1e-4
        )


def test_the_exponent_of_a_motion_that_ends_is_negative() -> None:
    """Theta and phi each shrink by exp(-t): of the slower of two decays, 1/s, over a long run to the transient of 1 %."""
    scene = sprung(2.5, duration=20.0)  # decays of 1 and 4 a second
    assert lyapunov(pp.simulate(scene.replace(start=pp.Start()))) == pytest.approx(-1.0, abs=0.05)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("joint", ["theta", "phi"])
def test_a_rod_flips_forwards_and_backwards(sign: int, joint: str) -> None:
    """At 2 K(k²) / rate, the elliptic integral, either way about either axis; of a run and in vectors."""
    rate = 9.0  # rad/s; theta'² = rate² - 6 g sin²(theta / 2)
    scene = pp.Scene(
        duration=1.0,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=1e-4)]),
        start=pp.Start(velocities={joint: sign * rate}),
        effects=[fx.Gravity()],
        solver=pp.Solver(tolerance=1e-12, samples=7),
    )
    time = 2 * float(ellipk(6 * 9.81 / rate**2)) / rate
    assert flip_time(pp.simulate(scene, method="dop853")) == pytest.approx(time, abs=1e-7)  # the radius changes 1e-8
    found = pp.sweep(scene, {f"start.velocities.{joint}": [sign * rate, sign * 7.0]}, "flip_time").flip_time.values
    assert found[0] == pytest.approx(time, abs=1e-7)
    assert math.isnan(found[1])


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("rate", "looser", "spread"),
    [
        (4.0, 4.1, math.pi / 3.9 - math.pi / 4.0),  # over the top at the latest when both differ by 0.1 t less
        (4.0, 3.9, math.pi / 3.9 - math.pi / 4.0),
        (3.0, 3.05, 0.0),  # 0.14 rad short of the top, and as much off as 0.05
        (3.1, 3.0, math.inf),  # 0.04 short of it, and as much off as 0.1
        (3.1, 3.1 + 1e-9, 0.0),
        (3.2, 3.1, math.inf),  # 0.06 beyond it
    ],
)
def test_the_spread_of_a_flip_is_what_two_runs_differ(sign: int, rate: float, looser: float, spread: float) -> None:
    """Of a rod that turns freely for 1 s: the times at which its angle, give or take the difference, passes half a turn."""
    scene = sprung(0.0, duration=1.0, start=0.0).replace(effects=[], solver=pp.Solver(samples=2))
    runs = [pp.simulate(scene.replace({"start.velocities.theta": sign * x})) for x in (rate, looser)]
    assert evaluate_measure(measure("flip_time.spread"), *runs) == pytest.approx(spread, abs=1e-8)


DOUBLE = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.02), pp.Rod(length=0.8, mass=0.7, radius=0.02)])


@pytest.mark.parametrize(
    ("setting", "one", "two"),
    [
        # both runs flip at the same time by chance
        pytest.param({"method": "gauss4", "step": 0.01}, 2.6601403, -2.16739549, marks=pytest.mark.slow),
        ({"method": "euler", "step": 0.002}, 2.1600035, 1.8885761),
        ({"method": "euler", "step": 0.002}, -2.2852807, -0.3020710),  # the motion just misses the top
        ({"method": "rk4", "step": 0.004}, 2.1600035, 0.6852257),
        ({"method": "dop853", "tolerance": 1e-4}, -2.6, -1.4),
    ],
)
def test_a_flip_is_as_far_off_as_its_spread_says(setting: dict, one: float, two: float) -> None:
    """Of a double pendulum let go at rest, beside a run of high accuracy; the estimate of euler is good to 10 %."""
    start = pp.Start(positions={"theta_1": one, "theta_2": two})
    scene = pp.Scene(duration=2.5, model=DOUBLE, start=start, effects=[fx.Gravity()])
    right = flip_time(pp.simulate(scene, method="taylor", tolerance=1e-15))
    solver = pp.Solver(samples=301, **setting)
    found = pp.sweep(
        scene.replace(solver=solver), {"start.positions.theta_1": [one]}, ["flip_time", "flip_time.spread"]
    )
    off = abs(found["flip_time"].values[0] - right)
    assert found["flip_time.spread"].values[0] >= 0.9 * (math.inf if math.isnan(off) else off)


@pytest.mark.parametrize(
    ("one", "two", "right"), [(1.9637659, 0.30426667, 3.259807), (-2.89493694, -1.85523248, 0.456351)]
)
@pytest.mark.parametrize("method", ["dop853", "taylor"])
def test_the_first_passage_does_not_depend_on_the_samples(method: str, one: float, two: float, right: float) -> None:
    """Two thin rods let go at rest: one rod passes the top and turns back between two samples; times to 2e-6 s."""
    model = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)] * 2)
    start = pp.Start(positions={"theta_1": one, "theta_2": two})
    scene = pp.Scene(duration=5.0, model=model, start=start, effects=[fx.Gravity()])
    for samples in (2, 5, 11, 601):
        run = pp.simulate(scene, method=method, tolerance=1e-11, samples=samples)
        assert flip_time(run) == pytest.approx(right, abs=2e-6)


def test_the_first_steps_of_two_runs_are_the_same() -> None:
    """A flip within them is off by less than the tolerance, and its spread is not 0."""
    scene = pp.Scene(duration=3.0, model=pp.Chain(rods=[ROD]), effects=[fx.Gravity()])
    scene = scene.replace({"start.positions.theta": -2.85, "start.velocities.theta": -1.4})
    right = flip_time(pp.simulate(scene, method="taylor", tolerance=1e-15))
    one, looser = (pp.simulate(scene, samples=601, method="dop853", tolerance=x, duration=0.3) for x in (1e-4, 1e-2))
    assert abs(flip_time(one) - right) <= evaluate_measure(measure("flip_time.spread"), one, looser) < 1e-3


def test_the_period_of_small_swings() -> None:
    """2 pi / 2 s for a spring of 4 rad²/s²; none where theta rises through 0 only once."""
    scene = sprung(0.0)
    assert period(pp.simulate(scene)) == pytest.approx(math.pi, abs=1e-9)
    assert math.isnan(period(pp.simulate(scene, duration=4.0)))
    assert period(pp.simulate(scene, duration=6.0)) == pytest.approx(math.pi, abs=1e-9)


def test_the_swing_is_the_largest_angle() -> None:
    """Of the start of a swing without friction that starts at rest."""
    assert swing(pp.simulate(sprung(0.0))) == pytest.approx(0.7, abs=1e-9)
    found = pp.sweep(sprung(0.0), {"start.positions.theta": [0.7, -0.4]}, "swing").swing.values
    assert found == pytest.approx([0.7, 0.4], abs=1e-9)


def test_the_divergence_is_that_of_the_ends() -> None:
    """2 sin(x / 2) for two rods that end at angles x apart, whatever their length; infinite where one ended early."""
    long = pp.Chain(rods=[pp.Rod(length=3.0, mass=1.0, radius=0.02)])
    inertia = long.rods[0].properties.I1 + 1.5**2
    scene = sprung(0.0, duration=1.0).replace(model=long, effects=[fx.Spring(stiffness=4 * inertia)])
    one, other = (pp.simulate(scene.replace({"start.positions.theta": start})) for start in (0.7, 0.8))
    apart = 0.1 * math.cos(2.0)  # theta is proportional to its start
    assert divergence(one, other) == pytest.approx(2 * math.sin(abs(apart) / 2), rel=1e-7)
    assert divergence(one, one) == 0
    assert divergence(one, pp.simulate(scene, samples=11)) == math.inf
    two = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0), pp.Rod(length=2.0, mass=1.0)])
    still = [
        pp.simulate(
            pp.Scene(
                duration=1.0,
                model=two,
                start=pp.Start(positions={"theta_2": x}),
                effects=[fx.Gravity(acceleration=0.0)],
            )
        )
        for x in (0.0, 0.1)
    ]
    assert divergence(*still) == pytest.approx(2 * 2 * math.sin(0.05) / 3, rel=1e-9)  # over the farthest tip's distance
    assert divergence(*still[::-1]) == pytest.approx(
        2 * 2 * math.sin(0.05) / math.hypot(1 + 2 * math.cos(0.1), 2 * math.sin(0.1))
    )


def test_angles_add_up_from_the_support_on() -> None:
    """Those of a chain, about each axis for itself; joints of other names each for itself."""
    rod, hinge = pp.Rod(length=1, mass=1), pp.Rod(length=1, mass=1, joint="hinge", hangs_on="rod_1")
    assert accumulated(build(pp.Chain(rods=[rod, rod]))) == [[0], [0, 2], [1], [1, 3]]
    assert accumulated(build(pp.Chain(rods=[rod]))) == [[0], [1]]
    assert accumulated(build(pp.Chain(rods=[rod, rod, hinge]))) == [[0], [0, 2], [0, 4], [1], [1, 3]]
    assert accumulated(build(pp.UrdfModel("ur5"))) == [[joint] for joint in range(6)]


@pytest.mark.parametrize(
    ("statistic", "value"),
    [
        ("max", 0.7),
        ("min", -0.7),
        ("final", 0.7 * math.cos(9.0)),
        ("mean", 0.7 * math.sin(9.0) / 9.0),
        ("rms", 0.7 * math.sqrt(0.5 + math.sin(18.0) / 36.0)),
    ],
)
def test_statistics_of_a_swing(statistic: str, value: float) -> None:
    """Of 0.7 cos(2 t) over 4.5 s, to the samples' (2 dt)² / 8; in vectors, and of a run."""
    scene = sprung(0.0, duration=4.5)
    found = pp.sweep(scene, {"start.positions.theta": [0.7]}, f"theta.{statistic}")[f"theta.{statistic}"].values
    assert found == pytest.approx([value], abs=5e-5)
    single = evaluate_measure(measure(f"theta.{statistic}"), pp.simulate(scene), pp.simulate(scene))
    assert single == pytest.approx(found[0], abs=1e-8)


def test_the_time_of_the_largest_angle() -> None:
    """Half a period after a start on the other side; it is a time, in s, and the largest angle is none."""
    assert [measure(f"theta.{name}").unit for name in ("argmax", "max", "rms")] == ["s", "", ""]
    scene = sprung(0.0, start=-0.7, duration=2.0)
    assert evaluate_measure(measure("theta.argmax"), pp.simulate(scene), pp.simulate(scene)) == pytest.approx(
        math.pi / 2, abs=5e-3
    )


def test_the_spread_is_the_distance_to_the_looser_run() -> None:
    """0 where neither has the measure, infinite where one has it; of a run and of motions in vectors."""
    nan = math.nan
    assert _difference(np.array([1.0, 3.0, nan, nan, 2.0]), np.array([3.0, 1.0, nan, 2.0, nan])).tolist() == [
        2,
        2,
        0,
        math.inf,
        math.inf,
    ]
    one, other = (pp.simulate(sprung(0.0, start=start), duration=1.0) for start in (0.7, 0.8))
    assert evaluate_measure(measure("theta.max.spread"), one, other) == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("effects", [(), (fx.Viscous(coefficient=0.3),)], ids=["swings on", "comes to rest"])
def test_measures_do_not_depend_on_when_a_run_begins(effects: tuple) -> None:
    """Nothing acts that knows the time: every measure of a run, or of it and a looser one, is the same 70 s later."""
    scene = pp.Scene(
        duration=4.0,
        model=pp.Chain(rods=[ROD]),
        start=pp.Start(positions={"theta": 2.0}, velocities={"theta": 6.0}),
        effects=[fx.Gravity(), *effects],
        solver=pp.Solver(method="dop853", samples=401),
    )
    late = scene.replace(start=pp.Start(time=70.0, positions={"theta": 2.0}, velocities={"theta": 6.0}))
    names = [*(MEASURES.keys() - {"multiplier"}), *(f"theta.{statistic}" for statistic in STATISTICS)]
    both = [[pp.simulate(one, tolerance=tolerance) for tolerance in (1e-10, 1e-6)] for one in (scene, late)]
    first, second = ({name: evaluate_measure(measure(name), *runs) for name in names} for runs in both)
    second["theta.argmax"] -= 70.0 * (second["theta.argmax"] >= 70)
    assert second == pytest.approx(first, rel=1e-3, abs=1e-8, nan_ok=True)


def test_the_swing_of_a_rod_that_passes_over_the_top_is_half_a_turn() -> None:
    """Of a run as of a sweep, to the bit: between the samples the angle from straight down has a corner there."""
    scene = pp.Scene(
        model=pp.Chain(rods=[ROD, ROD]),
        start=pp.Start(velocities={"theta_1": 9.0}),
        effects=[fx.Gravity()],
        duration=2.0,
        solver=pp.Solver(samples=41, tolerance=1e-9),
    )
    found = pp.sweep(scene, {"start.velocities.theta_1": [9.0, 10.0]}, "swing").swing.values
    assert swing(pp.simulate(scene)) == np.pi
    assert found.tolist() == [np.pi, np.pi]


def test_the_swing_of_a_hinge_that_passes_over_the_top_is_half_a_turn() -> None:
    """As that of a chain in a plane, to the tolerance: 5e-7 off once."""
    rods = [pp.Rod(length=1.0, mass=1.0, joint="hinge"), pp.Rod(length=1.0, mass=1.0, joint="hinge")]
    solver, start = pp.Solver(samples=41, tolerance=1e-9), pp.Start(velocities={"theta_1": 9.0})
    scene = pp.Scene(model=pp.Chain(rods=rods), start=start, effects=[fx.Gravity()], duration=2.0, solver=solver)
    found = pp.sweep(scene, {"start.velocities.theta_1": [9.0, 10.0]}, "swing").swing.values
    assert found == pytest.approx([np.pi, np.pi], abs=1e-9)
