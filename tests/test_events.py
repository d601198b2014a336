"""Events are found by turning points as well as by signs, at their times, in any unit: against exact solutions."""

import runpy
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from scipy import optimize
from scipy.integrate import quad

import pendpin as pp
import scenes
from laws import law
from pendpin.effects import Drag, DryFriction, Gravity, Motor, Spring, Stop
from pendpin.integrators.events import first_crossing

ROD = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.05),))
INERTIA = ROD.rods[0].properties.I1 + 0.25  # kg m² about the joint
G = 9.81
METHODS = ("dop853", "rk45", "rk23", "radau", "bdf", "lsoda")

run_of = partial(scenes.run_of, model=ROD, duration=5.0, method="dop853", samples=2)


@given(
    place=st.floats(0.01, 0.99),
    depth=st.floats(-9, -2).map(lambda x: 10**x),
    bend=st.floats(-1, 2).map(lambda x: 10**x),
    ripple=st.floats(0, 6),
)
@example(place=0.1, depth=0.01, bend=1.0, ripple=0.0)  # 1.7e-18 at the start: once 4e-10 of the interval off
@example(place=0.1, depth=0.01 - 1e-12, bend=1.0, ripple=0.0)
def test_pairs_of_crossings_are_seen(place, depth, bend, ripple) -> None:
    """A function that dips below 0 for an instant, between others that do not."""

    def guards(t):
        dip = bend * (t - place) ** 2 * (1 + 0.3 * np.sin(ripple * t)) - depth
        return np.stack([1.0 + np.cos(ripple * t), dip, 2.0 + np.sin(3 * t)], 1)

    found = first_crossing(guards, np.array([0.0, 1.0]), np.full(3, 1e-13))
    if guards(np.zeros(1))[0, 1] <= 0:
        return
    assert found is not None
    assert found.which == 1
    assert found.fired == [1]
    exact = optimize.brentq(lambda t: guards(np.array([t]))[0, 1], 0.0, place, xtol=1e-16)
    assert abs((found.t - exact) * found.slope) < 1e-14 * max(1.0, bend)  # values up to `bend` are rounded


def test_a_jump_is_found_where_it_is() -> None:
    """A function that has no polynomial."""
    found = first_crossing(lambda t: np.where(t > 0.3, -1.0, 1.0)[:, None], np.array([0.0, 0.5]), np.array([1e-12]))
    assert found is not None
    assert abs(found.t - 0.3) < 1e-12


def test_rounding_is_no_jump() -> None:
    """A function that starts at 0 and is off by its rounding, far above the floor, does not wear out the search."""
    looks = []

    def guards(t):
        looks.append(len(t))
        return np.stack([30 * np.sin(t) + 1e-14 * np.sin(1e9 * t), 20 * (0.7 - t)], 1)

    found = first_crossing(guards, np.linspace(0.0, 1.0, 3), np.full(2, 1e-16))
    assert found is not None
    assert found.fired == [1]
    assert found.t == pytest.approx(0.7, abs=1e-14)
    assert found.slope == pytest.approx(-20.0, abs=1e-9)
    assert len(looks) < 10


@given(
    method=st.sampled_from(METHODS),
    depth=st.floats(-9, -3).map(lambda x: 10**x),
    rate=st.floats(0.5, 5.0),
    torque=st.floats(0.2, 3.0),
)
def test_grazing_an_elastic_stop(method, depth, rate, torque) -> None:
    """A constant torque turns the joint round a hair beyond its stop: it comes back as it came, at once.

    Methods of one step are exact for this motion, so what is tested is that the two crossings in a step are seen; the
    position of the others is off by the tolerance, and an impact makes of that an error in the rate of a / speed of it.
    """
    a = torque / INERTIA
    upper = rate**2 / (2 * a) - depth
    speed = np.sqrt(2 * a * depth)  # at the stop
    hit, after = (rate - speed) / a, 0.2
    off = (1e-9 if method in ("bdf", "lsoda") else 16 * np.spacing(upper)) * a / speed  # rounding of the place
    effects = (Motor(joint="theta", torque=-torque), Stop(upper=upper, restitution=1.0, joints=["theta"]))
    run = run_of(*effects, v=(rate,), duration=hit + after, method=method, tolerance=1e-10)
    assert run.stats.events == 1
    assert run.v[-1, 0] == pytest.approx(-speed - a * after, abs=1e-9 + off)


@pytest.mark.parametrize("method", ["rk45", "radau"])
@pytest.mark.parametrize(
    ("amplitude", "wind", "restitution"),
    [(4.0, (0, 0, 3), 0.5), (7.830017542472281, (2.46352631789195, 0.122604488337136, -1.7135889592948672), 0.0)],
)
def test_a_joint_leaves_its_stop_once(method, amplitude, wind, restitution) -> None:
    """As the torque on its stop passes 0 it leaves with the third power of time, and every method has the same events.

    Radau's interpolation once showed it beyond its stop: without end at the instant it leaves, or again and again just
    after it. The times differ by some tolerances: an error at an impact goes on to the next.
    """
    motor = Motor(joint="theta", amplitude=amplitude, frequency=4.0)
    stop = Stop(lower=-0.3, upper=0.4, restitution=restitution)
    effects = (Gravity(), stop, motor, Drag(density=100.0, wind=wind))
    model = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.03, joint="hinge"),))
    scene = pp.Scene(duration=3.0, model=model, start=pp.Start(velocities=(2.0,)), effects=effects)
    one, other = (pp.simulate(scene, method=name, tolerance=1e-8) for name in (method, "dop853"))
    assert "release" in [event.kind for event in other.events]
    assert [event[1:] for event in one.events] == [event[1:] for event in other.events]
    np.testing.assert_allclose([event.t for event in one.events], [event.t for event in other.events], atol=1e-7)


@law(50)
@given(depth=st.floats(-8.5, -3).map(lambda x: 10**x), stiffness=st.floats(1.0, 20.0))
def test_a_spring_grazes_its_stop(depth, stiffness) -> None:
    """From -1 rad at rest to a stop just short of +1: the motion is mirrored in time about the impact."""
    omega = np.sqrt(stiffness / INERTIA)
    short = np.arccos(1 - depth)  # of the phase, half a turn
    hit = (np.pi - short) / omega
    later = hit + 0.5 * np.pi / omega
    effects = (Spring(stiffness=stiffness, joints=["theta"]), Stop(upper=1 - depth, restitution=1.0))
    run = run_of(*effects, q=(-1.0,), duration=later, tolerance=1e-13)
    assert run.q[-1, 0] == pytest.approx(-np.cos(omega * (2 * hit - later)), abs=1e-10 + 2e-11 / short)


@law(30)
@given(
    method=st.sampled_from(METHODS),
    dip=st.floats(-5, -2).map(lambda x: 10**x),
    frequency=st.floats(0.5, 20.0),
    phase=st.floats(0.3, 2.5),
)
def test_a_rate_that_touches_zero_sticks(method, dip, frequency, phase) -> None:
    """A sliding joint whose rate would go below 0 by a hair stops there, and is held."""
    swing = 1.0 / (INERTIA * frequency)  # rad/s, of a torque of amplitude 1 N m
    motor = Motor(joint="theta", torque=0.2, amplitude=1.0, frequency=frequency, phase=phase + np.pi / 2)
    start = swing * (1 + np.sin(phase)) - dip  # the rate is swing (1 + sin(frequency t + phase)) - dip
    touch = (1.5 * np.pi - np.arccos(1 - dip / swing) - phase) / frequency
    run = run_of(
        motor,
        DryFriction(kinetic=0.2, static=5.0, joints=["theta"]),
        v=(start,),
        duration=touch + 1.0,
        method=method,
        tolerance=1e-10 if method != "rk23" else 1e-8,
    )
    way = (swing - dip) * touch + swing / frequency * (np.cos(phase) - np.cos(frequency * touch + phase))
    assert run.stats.events == 1
    assert run.v[-1, 0] == 0
    assert run.q[-1, 0] == pytest.approx(way, abs=1e-6)


@law(25)
@given(
    method=st.sampled_from(METHODS),
    frequency=st.floats(20.0, 300.0),
    beat=st.floats(0.5, 3.0),
    share=st.floats(0.3, 0.95),
)
def test_beating_motors_loosen_a_joint_when_they_can(method, frequency, beat, share) -> None:
    """A joint at rest comes loose at the first instant at which the torques of two motors pass what holds it."""
    static, kinetic, size = 1.0, 0.5, 0.5 / share

    def torque(t):
        return size * (np.sin(frequency * t) - np.sin((frequency + beat) * t))

    t = np.arange(0.0, 2 * np.pi / beat, 0.002 / frequency * np.pi)
    first = int(np.argmax(np.abs(torque(t)) > static))
    before = np.abs(torque(t[:first]))
    tops = before[1:-1][(before[1:-1] >= before[:-2]) & (before[1:-1] >= before[2:])]
    assume((tops < (1 - 1e-5) * static).all())  # else it may come loose between two of these times
    loose = optimize.brentq(lambda t: abs(torque(t)) - static, t[first - 1], t[first], xtol=1e-15)
    way, after = np.sign(torque(loose)), 0.1 / frequency

    def impulse(t):
        return size * (np.cos((frequency + beat) * t) / (frequency + beat) - np.cos(frequency * t) / frequency)

    motors = [
        Motor(joint="theta", amplitude=s * size, frequency=w) for s, w in ((1, frequency), (-1, frequency + beat))
    ]
    friction = DryFriction(kinetic=kinetic, static=static, joints=["theta"])
    run = run_of(*motors, friction, duration=loose + after, method=method, tolerance=1e-11)
    exact = (impulse(loose + after) - impulse(loose) - way * kinetic * after) / INERTIA
    assert run.stats.events == 1
    assert abs(run.v[-1, 0] - exact) * INERTIA / (static - kinetic) < 1e-9  # s


@law(20)
@given(
    method=st.sampled_from(METHODS),
    tolerance=st.floats(-12, -3).map(lambda x: 10**x),
    restitution=st.sampled_from([0.0, 0.1, 0.3, 0.5, 0.7]),
    height=st.floats(-4, 0).map(lambda x: 10**x),
    torque=st.floats(-2, 2).map(lambda x: 10**x),
    unit=st.integers(-6, 6).map(lambda power: 4.0**power),
    limit=st.sampled_from([0.0, 0.3, -2.0]),
    side=st.sampled_from([-1.0, 1.0]),
    time=st.sampled_from([0.0, -50.0, 1e6]),
)
@example("lsoda", 1e-6, 0.5, 0.3, 2.0, 1.0, 0.0, -1.0, 0.0)  # 16,301 events once
@example("bdf", 1e-6, 0.5, 0.3, 2.0, 1.0, 0.0, -1.0, 0.0)  # more than 200 at once
@example("lsoda", 1e-9, 0.5, 0.3, 2.0, 1.0, 0.0, -1.0, 0.0)
def test_every_method_has_the_same_bounces(
    method, tolerance, restitution, height, torque, unit, limit, side, time
) -> None:
    """A constant torque onto a stop: n impacts, the last of which would go less than 1e-12 rad; then exact rest.

    Whatever the method, its tolerance, the unit of time, the time of the start, the place of the stop and its side.
    """
    last = -np.inf if restitution == 0 else np.log(1e-12 / height) / (2 * np.log(restitution))
    assume(abs(last - round(last)) > 0.05 if restitution else True)  # 2 log(e) times this: 4 % of the least height
    impacts = 1 if restitution == 0 else int(np.floor(last)) + 1
    a = torque / unit**2 / INERTIA
    fall = np.sqrt(2 * height / a)
    rest = fall * (1 + 2 * sum(restitution**k for k in range(1, impacts)))
    stop = Stop(**{"upper" if side > 0 else "lower": side * limit}, restitution=restitution, joints=["theta"])
    effects = (Motor(joint="theta", torque=side * torque / unit**2), stop)
    run = run_of(
        *effects, q=(side * (limit - height),), duration=1.1 * rest, method=method, tolerance=tolerance, time=time
    )
    assert [event.kind for event in run.events] == ["stop"] * impacts
    rounding = (
        100 * np.spacing(abs(limit)) / 1e-12 * np.sqrt(8e-12 / a)
    )  # of the place of the stop, in the last bounces
    off = 2 * np.spacing(abs(time)) + rounding
    assert run.events[-1].t - time == pytest.approx(rest, rel=30 * tolerance + 1e-14, abs=off)
    assert run.v[-1, 0] == 0
    assert run.q[-1, 0] == side * limit


def time_to_rest(top: float, stop: float, restitution: float, impacts: int) -> float:
    """When a rod let go at `top` has its last impact on a stop: the energy of each flight is known, its time an integral."""
    square = G / 2 / INERTIA * 2  # of the rate: this times the difference of the cosines

    def fall(top: float) -> float:
        """From rest at `top` to the stop: with theta = top - x², the integrand has no singularity."""
        rate = lambda x: np.sqrt(2 * square * np.sin(top - x**2 / 2) * np.sinc(x**2 / 2 / np.pi) / 2)  # noqa: E731
        return quad(lambda x: 2 / rate(x), 0, np.sqrt(top - stop), epsabs=0, epsrel=1e-12)[0]

    time, rise = fall(top), np.cos(stop) - np.cos(top)
    for _ in range(impacts - 1):
        rise *= restitution**2
        time += 2 * fall(np.arccos(np.cos(stop) - rise))
    return time


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "tolerance", [1e-3, *(pytest.param(tolerance, marks=pytest.mark.slow) for tolerance in (1e-6, 1e-9)), 1e-12]
)
def test_a_rod_that_bounces_on_its_stop_comes_to_rest(method: str, tolerance: float) -> None:
    """Let go at 1 rad onto a stop at 0.3 rad, the rates after impacts a geometric series until 21: by every method."""
    stop = Stop(lower=0.3, restitution=0.5, joints=["theta"])
    run = run_of(Gravity(), stop, q=(1.0,), method=method, tolerance=tolerance, duration=3.0)
    assert len(run.events) == 21
    assert run.v[-1, 0] == 0
    assert run.q[-1, 0] == 0.3
    off = 3e-9  # the last bounces take 1e-6 s, and the place of the stop is rounded to 1e-4 of them
    if tolerance <= 1e-6:
        assert run.events[-1].t == pytest.approx(time_to_rest(1.0, 0.3, 0.5, 21), abs=100 * tolerance + off)


@pytest.mark.parametrize("accuracy", [1e-3, 1e-4, 8.6e-7, 1e-8])
def test_bounces_are_integrated_to_an_accuracy(accuracy: float) -> None:
    """Also where a coarse run of the search has tiny bounces."""
    stop = Stop(lower=0.3, restitution=0.5, joints=["theta"])
    start = pp.Start(positions={"theta": 1.0})
    scene = pp.Scene(duration=3.0, model=ROD, start=start, effects=[Gravity(), stop])
    run = pp.simulate(scene, method="radau", accuracy=accuracy)
    assert run.stats.error is not None
    assert run.stats.error <= accuracy
    assert run.q[-1, 0] == 0.3


POWERS = st.integers(-20, 20).map(lambda power: 2.0**power)
RATES, ANGLES = (  # rad/s, rad; none so small that its products lose digits
    st.floats(low, high).map(lambda x: round(x, 12)) for low, high in ((-1.0, 1.0), (-0.45, 0.35))
)


def scaled(method, length, mass, time, q, v, tolerance) -> pp.Trajectory:
    """Two rods with friction and stops, in other units of length, mass and time."""
    torque = mass * (length / time) ** 2
    sizes = ((0.7, 0.9), (0.5, 1.1))
    model = pp.Chain(rods=[pp.Rod(length=a * length, mass=b * mass, radius=0.05 * length) for a, b in sizes])
    start = pp.Start(positions=list(q), velocities=[x / time for x in v])
    effects = [
        Gravity(acceleration=9.81 * length / time**2),
        DryFriction(kinetic=0.2 * torque, static=0.3 * torque),
        Stop(lower=-0.5, upper=0.4, restitution=0.6),
    ]
    solver = pp.Solver(samples=31, method=method, tolerance=tolerance)
    return pp.simulate(pp.Scene(duration=3 * time, model=model, start=start, effects=effects, solver=solver))


@law(12)
@given(
    method=st.sampled_from(["dop853", "rk45"]),
    length=POWERS,
    mass=st.integers(-200, 200).map(lambda power: 2.0**power),
    q=st.tuples(*[ANGLES] * 4),
    v=st.tuples(*[RATES] * 4),
)
@example(method="dop853", length=1.0, mass=2.0, q=(0.0, -0.375, 0.0, 0.0), v=(0.0, 1.0, 0.0, 0.0))
def test_units_of_length_and_mass_change_no_bit(method, length, mass, q, v) -> None:
    """The same scene in units a million times smaller and larger, by powers of 2, which round nothing: the same bits.

    Nothing less holds for any start: a joint that grazes its stop magnifies a rounding to its square root.
    """
    runs = [scaled(method, *sizes, 1.0, q, v, 1e-8) for sizes in ((1.0, 1.0), (length, mass))]
    for name in ("q", "v", "a"):
        assert np.array_equal(getattr(runs[0], name), getattr(runs[1], name))
    assert runs[0].stats.events == runs[1].stats.events


UNITS = [(1e6, 1e6, 1e3), (1e-6, 1e3, 1e-6), (1e3, 1e-6, 1e-3), (1e-3, 1.0, 1e6)]


@pytest.mark.parametrize(
    ("method", "scales"),
    [
        *((method, scales) for method in ("dop853", "rk45") for scales in UNITS),
        *((method, UNITS[0]) for method in ("rk23", "radau", "lsoda")),
        pytest.param("bdf", UNITS[0], marks=pytest.mark.slow),
    ],
)
def test_units_do_not_matter(method, scales) -> None:
    """Units of time too: in which the tolerance of rates is another, and so are the steps, hundreds of them."""
    tolerance = 1e-12 if method in ("dop853", "rk45") else 1e-9
    start = (0.3, -0.2, 0.1, 0.25), (0.9, -0.4, 0.6, 0.8)
    runs = [scaled(method, *sizes, *start, tolerance) for sizes in ((1.0, 1.0, 1.0), scales)]
    assert np.abs(runs[0].q - runs[1].q).max() < 1e-9
    assert runs[0].stats.events == runs[1].stats.events > 4


@pytest.mark.parametrize("length", [1e-6, 1e-4, 1.0, 1e3])
def test_friction_is_small_or_large_against_the_weight(length) -> None:
    """A rod of any length let go level moves against friction of a tenth of its weight's torque, and not against more."""
    weight = 9.81 * length / 2  # N m, of 1 kg
    model = pp.Chain(rods=[pp.Rod(length=length, mass=1.0, radius=0.01 * length)])
    start, end = pp.Start(positions={"theta": np.pi / 2}), 0.1 * np.sqrt(length)
    moved = []
    for share in (0.1, 1 - 1e-9, 1 + 1e-9):
        effects = [Gravity(), DryFriction(kinetic=0.1 * weight, static=share * weight, joints=["theta"])]
        run = pp.simulate(
            pp.Scene(duration=end, model=model, start=start, effects=effects, solver=pp.Solver(samples=2))
        )
        moved.append(abs(run.q[-1, 0] - run.q[0, 0]))
    assert moved[0] > 0.05
    assert moved[1] == pytest.approx(moved[0], rel=1e-6)
    assert moved[2] == 0


A = 1.0 / INERTIA  # rad/s², of a torque of 1 N m
STOP, STICKY = Stop(lower=0.0, joints=["theta"]), DryFriction(kinetic=0.5, static=1.0, joints=["theta"])
SWELL = Motor(joint="theta", amplitude=2.0, frequency=1.0)  # N m: 2 sin(t)
EVENTS = {  # effects, the start of theta, and what happens to it when
    "falls on a stop": ((Motor(joint="theta", torque=-1.0), STOP), (0.5, 0.0), [((1.0 / A) ** 0.5, "stop")]),
    "leaves a stop": ((SWELL, Motor(joint="theta", torque=-1.0), STOP), (0.0, 0.0), [(np.pi / 6, "release")]),
    "comes to rest": ((STICKY,), (0.0, 1.0), [(1.0 / (0.5 * A), "stick")]),
    "starts to slide": ((SWELL, STICKY), (0.0, 0.0), [(np.pi / 6, "slip")]),
    "turns back": ((Motor(joint="theta", torque=-2.0), STICKY), (0.0, 1.0), [(1.0 / (2.5 * A), "reverse")]),
}


@pytest.mark.parametrize("name", EVENTS)
def test_a_run_has_its_events(name: str, tmp_path) -> None:
    """Times, joints and kinds, from closed forms; in the file of the run too, and in a run that is continued."""
    effects, (q, v), exact = EVENTS[name]
    scene, ends = partial(run_of, *effects, q=(q,), v=(v,), tolerance=1e-12), exact[-1][0]
    run = scene(duration=ends + 0.2)
    assert [(event.joint, event.kind) for event in run.events] == [("theta", kind) for _, kind in exact]
    assert np.allclose([event.t for event in run.events], [t for t, _ in exact], rtol=0, atol=1e-11)
    assert pp.Trajectory.load(run.save(tmp_path / "run.npz")).events == run.events == run.at([ends / 2]).events
    longer = scene(duration=ends / 2).extend(ends / 2 + 0.2)
    assert np.allclose([event.t for event in longer.events], [t for t, _ in exact], rtol=0, atol=1e-11)


def test_files_from_before_runs_had_events(tmp_path) -> None:
    """They are read; a file whose events do not fit together is refused."""
    run = run_of(Motor(joint="theta", torque=-1.0), STOP, q=(0.5,), tolerance=1e-9)
    arrays = dict(np.load(run.save(tmp_path / "run.npz")))
    twice = {name: np.repeat(array, 2) for name, array in arrays.items() if name.startswith("event_")}
    odd = ({"event_kind": np.array(["jump"])}, twice | {"event_t": np.array([0.4, 0.3])}, {"work_stop": run.kinetic})
    for changed in odd:
        np.savez(tmp_path / "odd.npz", **arrays | changed)
        with pytest.raises(pp.InputError, match=r"arrays of events do not fit|works are not those of its scene"):
            pp.Trajectory.load(tmp_path / "odd.npz")
    np.savez(tmp_path / "odd.npz", **{name: array for name, array in arrays.items() if name != "event_t"})
    with pytest.raises(pp.InputError, match="array 'event_t' is missing"):
        pp.Trajectory.load(tmp_path / "odd.npz")
    np.savez(tmp_path / "old.npz", **{name: array for name, array in arrays.items() if not name.startswith("event_")})
    old = pp.Trajectory.load(tmp_path / "old.npz")
    assert (old.events, old.stats) == ((), run.stats)


@pytest.mark.parametrize("missed", [True, False])
def test_the_benchmark_ends_with_its_status(missed: bool, monkeypatch: pytest.MonkeyPatch, capfd) -> None:
    """Status 1 where a draw is missed, 0 where none is, and nothing but the table is printed."""
    path = Path(__file__).parents[1] / "benchmarks" / "events.py"
    benchmark = runpy.run_path(str(path))
    draw = benchmark["Draw"](np.bool_(missed), np.float64(0.0))
    monkeypatch.setitem(benchmark["main"].__globals__, "KINDS", {"none": (lambda random, method: draw, "s")})
    with pytest.raises(SystemExit) as ended:
        benchmark["main"](1)
    assert (type(ended.value.code), ended.value.code) == (int, int(missed))
    assert "False" not in capfd.readouterr().err


@pytest.mark.slow
def test_the_benchmark_misses_nothing() -> None:
    """A few draws of every kind by every method."""
    path = Path(__file__).parents[1] / "benchmarks" / "events.py"
    done = subprocess.run([sys.executable, path, "2", "1"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
