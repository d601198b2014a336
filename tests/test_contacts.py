"""Dry friction and stops against exact answers: they stick exactly, slide by Coulomb, bounce in a geometric series."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import quad

import pendpin as pp
import scenes
from laws import law
from pendpin.cli import main
from pendpin.effects import DryFriction, Gravity, Stop
from pendpin.model.kinematics import poses_and_energy

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


@law(60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.sampled_from([0.0, 0.3, 0.7, 1.0]))
@example(19, 3, 0.3)  # these did not end once
@example(4, 4, 0.7)
def test_impacts_on_many_stops_end(seed: int, count: int, restitution: float) -> None:
    """Joints at their stops that kick each other, also where their bounces form an infinite series.

    None moves into its stop afterwards, and energy is not won: bounces of less than 1e-12 rad are left out, each of which
    may change it by 1e-6.
    """
    model = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.02),), copies=count)
    dynamics = pp.bind(pp.Scene(model=model, effects=[Gravity(), Stop(lower=-0.4, upper=0.4, restitution=restitution)]))
    random = np.random.default_rng(seed)
    q, v = (
        random.uniform(-0.4, 0.4, 2 * count),
        random.uniform(-3, 3, 2 * count) * 10 ** random.uniform(-3, 1, 2 * count),
    )
    at = random.random(2 * count) < 0.7
    q[at] = np.copysign(0.4, q[at])
    assert dynamics.contacts is not None
    after = dynamics.contacts.strike(q, v, 0.0)
    before, kinetic = (poses_and_energy(dynamics.model, q[None], rates[None])[1][0] for rates in (v, after))
    assert (np.sign(q[at]) * after[at] <= 0).all()
    assert kinetic <= before * (1 + 1e-3)


def test_a_rate_that_is_rounding_is_no_bounce() -> None:
    """A joint on its stop whose rate is 1e-14 of the others' rests there, and is not struck again and again."""
    dynamics = pp.bind(pp.Scene(model=ROD, effects=[Gravity(), Stop(upper=0.4, restitution=0.5)]))
    assert dynamics.contacts is not None
    after = dynamics.contacts.strike(np.array([0.4, 0.1]), np.array([-1e-14, 1.0]), 0.0)
    assert after.tolist() == [0.0, 1.0]
    bounced = dynamics.contacts.strike(np.array([0.4, 0.1]), np.array([-1e-9, 1.0]), 0.0)
    assert bounced.tolist() == [-1e-9, 1.0]


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
