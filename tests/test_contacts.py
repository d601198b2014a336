"""Dry friction and stops against exact answers: they stick exactly, slide by Coulomb, bounce in a geometric series."""

from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import quad

import pendpin as pp
import scenes
from laws import law
from pendpin.cli import main
from pendpin.dynamics.contacts import Contacts
from pendpin.dynamics.falls import rates_and_mode
from pendpin.effects import DryFriction, Gravity, Stop
from pendpin.ground.arrays import Array

ROD = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.05),))
INERTIA = ROD.rods[0].properties.I1 + 0.25  # kg m² about the joint
G = 9.81


run_of = partial(scenes.run_of, model=ROD, duration=5.0)


def test_a_spinning_joint_comes_to_rest_in_the_exact_time() -> None:
    """theta alone, no gravity: rate falls linearly, stops at J v0 / kinetic, stays there with rate exactly 0."""
    run = run_of(DryFriction(kinetic=0.5), v=(2.0,), duration=3.0)
    stop = INERTIA * 2.0 / 0.5
    sliding = run.t < stop
    assert np.allclose(run.v[sliding, 0], 2.0 - 0.5 / INERTIA * run.t[sliding], atol=1e-10)
    assert (run.v[~sliding, 0] == 0).all()
    assert np.allclose(run.q[~sliding, 0], 2.0**2 * INERTIA / (2 * 0.5), atol=1e-9)
    assert (run.q[~sliding, 0] == run.q[-1, 0]).all()


def test_friction_that_falls_with_speed_stops_a_joint_in_the_exact_time() -> None:
    """theta alone, no gravity: J v' = -F(v), so that it stops after J times the integral of 1 / F, from 0 to v0."""
    friction, v0 = DryFriction(kinetic=0.3, static=0.8, stribeck=2.0), 5.0
    run = run_of(friction, v=(v0,), duration=6.0, samples=601)
    size = lambda v: 0.3 + 0.5 * np.exp(-((v / 2.0) ** 2))  # noqa: E731
    spent = np.array([quad(lambda v: INERTIA / size(v), rate, v0, epsabs=1e-13)[0] for rate in run.v[::50, 0]])
    stop = quad(lambda v: INERTIA / size(v), 0, v0, epsabs=1e-13)[0]
    assert np.allclose(spent, np.minimum(run.t[::50], stop), atol=1e-9)
    assert (run.v[run.t > stop, 0] == 0).all()
    with pytest.raises(pp.InputError, match="stribeck needs static"):
        DryFriction(kinetic=0.3, stribeck=2.0)


def test_small_torques_do_not_start_a_joint() -> None:
    """At rest below the static limit: exactly at rest; just above it: it goes."""
    holding = 0.5 * G * np.sin(0.3)  # N m about theta
    held = run_of(Gravity(), DryFriction(kinetic=0.1, static=holding * 1.001), q=(0.3,))
    assert (held.q == held.q[0]).all()
    assert (held.v == 0).all()
    assert held.stats.events == 0
    goes = run_of(Gravity(), DryFriction(kinetic=0.1, static=holding * 0.999), q=(0.3,))
    assert np.abs(goes.q[:, 0] - 0.3).max() > 0.1


def test_coulomb_decay_is_linear_with_the_exact_number_of_half_swings() -> None:
    """A spring of stiffness k and friction mu: each half swing loses 2 mu / k, until it sticks within mu / k."""
    k, mu, start = 4.0, 0.13, 1.0
    run = run_of(
        pp.effects.Spring(stiffness=k, joints=["theta"]), DryFriction(kinetic=mu), q=(start,), duration=16.0, samples=2
    )
    rest, amplitude, halves = mu / k, start, 0
    while amplitude > rest:
        amplitude, halves = amplitude - 2 * rest, halves + 1
    half_period = np.pi * np.sqrt(INERTIA / k)
    assert run.q[-1, 0] == pytest.approx((-1) ** halves * amplitude, abs=1e-9)
    assert run.v[-1, 0] == 0
    assert run.stats.events == halves
    before = run_of(
        pp.effects.Spring(stiffness=k, joints=["theta"]),
        DryFriction(kinetic=mu),
        q=(start,),
        duration=3.5 * half_period,
        samples=8,
    )
    turning = [start - 2 * rest * n for n in range(4)]
    assert np.allclose(np.abs(before.q[::2, 0])[:4], np.abs(turning), atol=1e-9)


def test_bounces_come_in_a_geometric_series() -> None:
    """A constant torque onto a stop: flight times fall by the restitution, the sum is finite, and then it rests."""
    torque, e = 1.0, 0.5
    motor = pp.effects.Motor(joint="theta", torque=torque)
    a = torque / INERTIA
    first = np.sqrt(2 * 1.0 / a)  # s, from -1 rad at rest to the stop at 0
    ends = first * np.array([1.0, 1 + 2 * e, 1 + 2 * e + 2 * e**2])
    for end, speed in zip(ends, a * first * e ** np.arange(1, 4), strict=True):
        run = run_of(motor, Stop(upper=0.0, restitution=e, joints=["theta"]), q=(-1.0,), duration=end + 1e-6, samples=2)
        assert run.v[-1, 0] == pytest.approx(-speed + a * 1e-6, rel=1e-7)
    after = run_of(
        motor, Stop(upper=0.0, restitution=e, joints=["theta"]), q=(-1.0,), duration=first * (1 + 2 * e / (1 - e)) + 0.1
    )
    assert after.q[-1, 0] == 0.0
    assert after.v[-1, 0] == 0.0
    assert 15 < after.stats.events < 40


def test_an_elastic_stop_keeps_the_energy() -> None:
    """Restitution 1: the rod comes back from its stop as it went, again and again."""
    run = run_of(Gravity(), Stop(lower=-0.2, upper=0.5, restitution=1.0), q=(0.4, 0.1), v=(1.0, -0.5), duration=10.0)
    assert run.energy().drift < 1e-8
    assert run.stats.events > 5
    assert run.q.max() <= 0.5
    assert run.q.min() >= -0.2


def test_a_joint_leaves_its_stop_when_the_torque_turns() -> None:
    """Resting on a stop is one-sided: a sinusoidal torque lifts the joint off when it points away."""
    motor = pp.effects.Motor(joint="theta", amplitude=1.0, frequency=1.0)
    run = run_of(motor, Stop(upper=0.0, joints=["theta"]), duration=6.0)
    pressed = run.t < np.pi
    assert (run.q[pressed, 0] == 0).all()
    later = (run.t > np.pi) & (run.t < 2 * np.pi)
    t = run.t[later] - np.pi
    assert np.allclose(run.q[later, 0], -(t - np.sin(t)) / INERTIA, atol=1e-8)


def test_two_stops_hit_at_once() -> None:
    """Two joints that reach their stops in the same instant both reverse; the energy of the impact is counted once."""
    model = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.05),) * 2)
    stop = Stop(upper=0.5, restitution=1.0)
    run = run_of(stop, v=(1.0, 0.0, 0.0, 0.0), model=model, duration=2.0)
    assert run.energy().drift < 1e-8
    assert run.q.max() <= 0.5
    both = run_of(Stop(upper=1.0, restitution=1.0), q=(0.0, 0.0), v=(1.0, 1.0), duration=3.0)
    assert both.q.max() <= 1.0
    assert both.energy().drift < 1e-8


def chain_at_stops(seed: int, count: int, restitution: float, planar: bool) -> tuple[Contacts, Array, Array, Array]:
    """Rods of any size, most joints at their stops and moving; in a plane phi has no stop. Contacts, mass matrix, q, v."""
    random, nv = np.random.default_rng(seed), 2 * count
    sizes = 10 ** random.uniform((-0.5, -1, -3), (0.5, 1, -1), (count, 3))
    model = pp.Chain(rods=[pp.Rod(length=length, mass=mass, radius=radius) for length, mass, radius in sizes])
    free = np.arange(nv) % 2 == 1 if planar else np.zeros(nv, bool)
    dynamics = pp.bind(pp.Scene(model=model))
    joints = [name for name, off in zip(dynamics.model.joints, free, strict=True) if not off]
    stop = Stop(lower=-0.4, upper=0.4, restitution=restitution, joints=joints)
    contacts = pp.bind(pp.Scene(model=model, effects=[Gravity(), stop])).contacts
    assert contacts is not None
    q, v = random.uniform(-0.4, 0.4, nv), random.uniform(-3, 3, nv) * 10 ** random.uniform(-3, 1, nv)
    at = (random.random(nv) < 0.7) & ~free
    q[at] = np.copysign(0.4, q[at])
    q[free] = v[free] = 0.0
    return contacts, np.linalg.inv(contacts.engine.compliance(q, np.arange(nv))), q, v


@law(150)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(1, 5),
    restitution=st.sampled_from([0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 1.0]),
    planar=st.booleans(),
)
@example(19, 3, 0.3, False)
@example(207, 2, 0.3, True)
@example(39779, 5, 0.1, False)  # SciPy's nnls is wrong by 0.2 of it
@example(37560, 5, 0.1, False)
def test_impacts_on_many_stops_end(seed: int, count: int, restitution: float, planar: bool) -> None:
    """Joints at their stops that kick each other, also where their bounces form an infinite series, of any chain.

    None moves into its stop afterwards. The impulses push, and act on joints at their stops only. Energy is not won, and
    none is lost without loss at the stops.
    """
    contacts, mass, q, v = chain_at_stops(seed, count, restitution, planar)
    after = contacts.strike(q, v, 0.0)
    at = np.abs(q) == 0.4
    assert (np.sign(q[at]) * after[at] <= 0).all()
    compliance, energy = np.linalg.inv(mass), v @ mass @ v / 2
    impulse = np.linalg.solve(compliance[np.ix_(at, at)], (after - v)[at])
    size = np.abs(compliance[:, at]) @ np.abs(impulse) + np.abs(v)
    assert (np.abs(v + compliance[:, at] @ impulse - after) <= 1e-9 * size.max()).all()
    # a rate below 1e-12 of the fastest is at rest, and so pushes may be wrong by what ends such a rate
    rest = 1e-12 * (contacts.length * np.abs(v)).max() / contacts.length[at]
    wrong = np.abs(np.linalg.inv(compliance[np.ix_(at, at)])) @ rest + 1e-9 * np.abs(impulse).max(initial=0.0)
    assert (-np.sign(q[at]) * impulse >= -wrong).all()
    assert after @ mass @ after / 2 <= energy * (1 + 1e-9)
    if restitution == 1:
        assert after @ mass @ after / 2 == pytest.approx(energy, rel=1e-9)


@pytest.mark.slow
def test_impacts_of_two_thousand_chains_end() -> None:
    """The same on a sequence of chains that does not change."""
    draw = np.random.default_rng(1).choice
    law_of_one = test_impacts_on_many_stops_end.hypothesis.inner_test  # type: ignore[attr-defined]
    for seed in range(2000):
        law_of_one(seed, int(draw([1, 2, 3, 4, 5])), float(draw([0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 1])), seed % 3 == 0)


def test_an_infinite_series_of_impacts_ends_in_its_limit() -> None:
    """Two joints that kick each other into their stops without end: impacts one by one come to what `strike` has at once."""
    contacts, mass, q, v = chain_at_stops(207, 2, 0.3, True)
    at, side = contacts.at_stops(q)
    compliance, series = np.linalg.inv(mass), v.copy()
    for _ in range(4000):
        into = at[side * series[at] < 0]
        if not len(into):
            break
        impulse = np.linalg.solve(compliance[np.ix_(into, into)], -1.3 * series[into])
        series = series + compliance[:, into] @ impulse
    size = np.abs(v).max()
    assert np.abs(series[at]).max() < 1e-9 * size
    assert np.abs(contacts.strike(q, v, 0.0) - series).max() < 1e-9 * size


@law(100)
@given(
    rate=st.floats(-5, 2).map(lambda x: 10**x),
    restitution=st.floats(0, 1),
    others=st.tuples(st.floats(-3, 3), st.floats(0.1, 1)),
)
def test_an_impact_takes_the_energy_that_is_lost(rate, restitution, others) -> None:
    """(1 - e²) / 2 times inertia times rate², to rounding, of one joint; of two that are struck at once, each its own."""
    stops = Stop(upper=0.4, restitution=restitution, joints=["theta"])
    contacts = pp.bind(pp.Scene(model=ROD, effects=[stops])).contacts
    assert contacts is not None
    q, v = np.array([0.4, 0.2]), np.array([rate, others[0]])
    inertia = 1 / contacts.engine.compliance(q, np.array([0]))[0, 0]
    lost = -(1 - restitution**2) / 2 * inertia * rate**2
    after = contacts.strike(q, v, 0.0)
    work = contacts.work_of_impacts(q, v, after)
    assert list(work) == ["stop"]
    assert work["stop"] == pytest.approx(lost, rel=1e-12, abs=4e-16 * inertia * rate**2)


class Bumper(Stop):
    """A stop under another name, whose work is counted apart."""

    kind: Literal["bumper"] = "bumper"


def test_two_kinds_of_stops_take_their_own_work() -> None:
    """Of a stop and a bumper that are struck at once, by joints without coupling: each takes what its joint loses."""
    effects = [
        Stop(lower=-0.5, upper=0.4, restitution=0.6, joints=["theta"]),
        Bumper(lower=-0.2, upper=1.0, restitution=0.3, joints=["phi"]),
    ]
    contacts = pp.bind(pp.Scene(model=ROD, effects=effects)).contacts
    assert contacts is not None
    q, v = np.array([0.4, -0.2]), np.array([2.0, -3.0])
    inertia = 1 / np.diag(contacts.engine.compliance(q, np.arange(2)))
    work = contacts.work_of_impacts(q, v, contacts.strike(q, v, 0.0))
    assert work["stop"] == pytest.approx(-(1 - 0.6**2) / 2 * inertia[0] * 2.0**2, rel=1e-14)
    assert work["bumper"] == pytest.approx(-(1 - 0.3**2) / 2 * inertia[1] * 3.0**2, rel=1e-14)


@pytest.mark.parametrize("rate", [-1e-6, -1e-14, -1e-300])
def test_a_bounce_that_goes_nowhere_is_rest(rate: float) -> None:
    """A joint on its stop that leaves with a rate that is rounding, and is pressed back, rests there at once.

    It is not struck again and again. The other joint follows as its mass demands, and no energy is won.
    """
    push = pp.effects.Motor(joint="theta", torque=5.0)
    dynamics = pp.bind(
        pp.Scene(model=ROD, effects=[Gravity(), push, Stop(upper=0.4, restitution=0.5, joints=["theta"])])
    )
    contacts, q, v = dynamics.contacts, np.array([0.4, 0.1]), np.array([rate, 1.0])
    assert contacts is not None
    scales = contacts.scales(np.linspace(0, 1, 9), q, v)
    after, mode = rates_and_mode(contacts, 0.0, q, v, scales)
    assert after[0] == 0
    assert mode.held.tolist() == [True, False]
    assert after[1] == pytest.approx(1.0, abs=2 * abs(rate))
    assert rates_and_mode(contacts, 0.0, q, np.array([-1e-3, 1.0]), scales)[0].tolist() == [-1e-3, 1.0]


def test_several_joints_stick_at_once() -> None:
    """A chain under strong friction ends with every rate exactly 0, hanging crooked."""
    model = pp.Chain(rods=(pp.Rod(length=0.5, mass=1.0, radius=0.02),) * 3)
    run = run_of(
        Gravity(),
        DryFriction(kinetic=0.8),
        q=(0.5, 0.3, -0.4, 0.2, 0.3, -0.1),
        model=model,
        duration=6.0,
        tolerance=1e-9,
    )
    assert (run.v[-1] == 0).all()
    assert np.abs(run.q[-1]).max() > 0.01


@pytest.mark.parametrize(
    "effects", [(DryFriction(kinetic=0.3, static=0.4),), (Stop(lower=-0.3, upper=0.3, restitution=0.6),)]
)
def test_both_engines_agree(effects) -> None:
    """Pinocchio and the chain equations, through sticking and impacts."""
    model = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.05),) * 2)
    runs = [
        run_of(Gravity(), *effects, q=(0.2, 0.1, -0.2, 0.25), model=model, duration=1.0, engine=engine, tolerance=1e-10)
        for engine in ("pinocchio", "chain")
    ]
    assert np.abs(runs[0].q - runs[1].q).max() < 1e-7
    assert runs[0].stats.events == runs[1].stats.events


def test_a_start_beyond_a_stop_is_refused() -> None:
    """One line that names the joint and its limits."""
    with pytest.raises(pp.InputError, match=r"start\.positions\.theta: 1 is beyond its stop at 0\.5"):
        run_of(Stop(upper=0.5), q=(1.0,))
    with pytest.raises(pp.InputError, match=r"start\.positions\.theta: 1 is beyond its stop at 0\.5"):
        pp.simulate(scenes.scene_of(ROD, Stop(upper=0.5), q=(1.0,)), method="radau", accuracy=1e-3)


NONSENSE = {
    'kind = "dry_friction"': "effects[0].kinetic: missing",
    'kind = "dry_friction"\nkinetic = -1': "effects[0].kinetic: -1",
    'kind = "dry_friction"\nkinetic = 1\nstatic = 0.5': "effects[0]: static, 0.5 N m, is below kinetic, 1 N m",
    'kind = "dry_friction"\nkinetic = nan': "effects[0].kinetic: nan",
    'kind = "dry_friction"\nkinetic = 1\njoints = ["knee"]': "effects[0].joints: joint 'knee' is not one of: theta, phi",
    'kind = "stop"': "effects[0]: a stop needs lower, upper or both",
    'kind = "stop"\nupper = 1\nrestitution = 1.5': "effects[0].restitution: 1.5",
    'kind = "stop"\nlower = 1\nupper = -1': "effects[0]: lower, 1 rad, is not below upper, -1 rad",
    'kind = "stop"\nupper = inf': "effects[0].upper: inf",
    'kind = "stop"\nupper = 0.5\njoints = "theta"': "effects[0].joints: 'theta'",
}


@pytest.mark.parametrize("text", NONSENSE)
def test_nonsense_is_refused_in_one_line(text: str, tmp_path: Path, capfd, monkeypatch) -> None:
    """`pendpin run` ends with exit status 1 and one line that names the place; nothing is written."""
    (tmp_path / "scene.toml").write_text(
        f'[model]\nkind = "chain"\nrods = [{{ length = 1, mass = 1 }}]\n[[effects]]\n{text}\n'
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["pendpin", "run", "scene.toml"])
    with pytest.raises(SystemExit) as ended:
        main()
    said = capfd.readouterr().err
    assert ended.value.code == 1
    assert said.count("\n") == 1
    assert NONSENSE[text] in said
    assert [path.name for path in tmp_path.iterdir()] == ["scene.toml"]


@pytest.mark.parametrize("method", ["dop853", "radau"])
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_joints_that_nothing_accelerates_fall_at_no_rate(method: str) -> None:
    """A planar pair bounces low while its phi stay at 0: inf m times 0 m/s² is no number, and nobody hears of it."""
    stop = Stop(lower=-0.05, upper=0.9, restitution=0.3, joints=("theta_1",))
    start = pp.Start(positions={"theta_1": 0.3, "theta_2": 0.1})
    scene = pp.Scene(model=pp.Chain(rods=ROD.rods * 2), duration=3.0, start=start, effects=(Gravity(), stop))
    run = pp.simulate(scene, method=method)
    assert len(run.events) > 3
    theta = run.at(np.linspace(0.3, 2.9, 301))["theta_1"]
    assert theta.min() > -0.05 - 1e-9
