"""No step jumps over what acts: pulses of any length anywhere in a run, tracks in any count of time, user effects."""

import math
from decimal import Decimal
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

import pendpin as pp
import scenes
from effect_cases import EFFECTS, MODELS
from laws import law
from pendpin.dynamics.pace import declared_pace
from pendpin.effects import Gravity, JointEffect, Motor, Rotation, Support, Torque
from pendpin.effects.pace import SIGNS, STEADY, Pace, join_paces, measure_pace

METHODS = ("dop853", "rk45", "rk23", "radau", "bdf", "lsoda")
ROD = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.02),))
INERTIA = ROD.rods[0].properties.I1 + 0.25  # kg m² about the joint


class Pulse(JointEffect):
    """A torque about theta that turns a free rod at rest to the rate `impulse` / J, within a few widths of time."""

    kind: Literal["pulse"] = "pulse"
    at: float  # s
    width: float  # s
    impulse: float  # N m s

    @property
    def on(self):
        """The joint it acts on."""
        return ("theta",)

    def torques(self, t, q, v, xp=np):
        """Torque (1,) in N m: a Gaussian."""
        return np.array([self.impulse / self.width / np.sqrt(np.pi) * xp.exp(-(((t - self.at) / self.width) ** 2))])


class PacedPulse(Pulse):
    """The same, which says how fast it changes."""

    kind: Literal["paced"] = "paced"

    def pace(self, begin, end, negligible):
        """Its width, near it."""
        return Pace(self.at + np.array([-7, 7]) * self.width, np.array([np.inf, self.width, np.inf]))


run_of = partial(scenes.run_of, model=ROD, samples=2)


@law(12)
@given(
    method=st.sampled_from((*METHODS, "taylor")),
    width=st.floats(-4, -1).map(lambda x: 10**x),
    place=st.floats(0.05, 0.95),
    duration=st.sampled_from([2.0, 30.0]),
    start=st.sampled_from([0.0, -7.5, 100.0]),
)
def test_pulses_are_seen(method, width, place, duration, start) -> None:
    """A rod at rest without gravity ends at the rate that the pulse's whole impulse gives, whatever the method."""
    at, tolerance = start + place * duration, 1e-7
    pulse = PacedPulse(at=at, width=width, impulse=0.1)
    run = run_of(pulse, method=method, tolerance=tolerance, duration=duration, time=start)
    past = (math.erf((start + duration - at) / width) - math.erf((start - at) / width)) / 2
    assert run.v[-1, 0] == pytest.approx(0.1 * past / INERTIA, abs=1e3 * tolerance)


def pulse_track(path: Path, first: str, duration: float, interval: float, at: float, width: float) -> Path:
    """A CSV track that goes from 0 to 0.05 m within some widths of time, its times written from `first` on."""
    rows = [
        f"{Decimal(first) + Decimal(repr(interval)) * i},{0.025 * (1 + math.erf((i * interval - at) / width))!r},0,0"
        for i in range(round(duration / interval) + 1)
    ]
    path.write_text("\n".join(rows))
    return path


@law(6)
@given(method=st.sampled_from(METHODS), width=st.floats(0.05, 0.5), at=st.floats(4, 26))
def test_tracks_are_seen(method, width, at, tmp_path_factory) -> None:
    """A rod at rest whose support moves once, anywhere in 30 s, is where the finest run has it."""
    path = pulse_track(tmp_path_factory.mktemp("track") / "track.csv", "0", 30.0, 0.02, at, width)
    effects = (Gravity(), Support(csv=path))
    exact = run_of(*effects, method="dop853", tolerance=1e-12, duration=30.0)
    run = run_of(*effects, method=method, tolerance=1e-7, duration=30.0)
    assert np.abs(exact.q[-1, 1]) > 1e-9
    assert np.abs(run.q - exact.q).max() < 1e-4


def ramp_scene(path: Path, interval: float, rows: int, size: float, duration: float, angles=(0.2, 0.4)) -> pp.Scene:
    """A rod whose pivot goes `size` m along x and z at half of the run, in so many rows, by the cubic of a smooth step."""
    t = interval * np.arange(round(duration / interval) + 2)
    s = np.clip((t - duration / 2) / (rows * interval), 0, 1)
    x = size * s * s * (3 - 2 * s)
    path.write_text("\n".join(f"{a:.9g},{b!r},0,{b!r}" for a, b in zip(t, x.tolist(), strict=True)))
    model = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.01),))
    effects = (Gravity(), Support(csv=path))
    return pp.Scene(duration=duration, model=model, start=pp.Start(positions=angles), effects=effects)


@pytest.mark.parametrize(
    ("interval", "rows", "size"), [(1e-3, 10, 0.01), (1e-2, 12, 0.05), (4e-3, 40, 0.003), (2e-3, 7, 0.02)]
)
def test_errors_fall_with_the_tolerance_where_a_track_moves(interval, rows, size, tmp_path) -> None:
    """No two tolerances pass a pulse of the pivot in the same steps: each decade is nearer to the finest run, to a factor.

    Without a corner at each row, dop853 was off by 30 times the tolerance at 1e-7 and by 1000 times at 1e-8.
    """
    scene = ramp_scene(tmp_path / "ramp.csv", interval, rows, size, 4.0)
    runs = [pp.simulate(scene, method="dop853", tolerance=10.0**-k, samples=5) for k in range(4, 14)]
    errors = [np.abs(run.q - runs[-1].q).max() for run in runs[:-2]]
    for k, error in enumerate(errors, 4):
        assert error < 20 * 10.0**-k


@pytest.mark.parametrize("accuracy", [1e-5, 1e-6, 1e-8])
@pytest.mark.parametrize(("interval", "rows", "size"), [(1e-3, 10, 0.01), (1e-2, 12, 0.05), (3e-3, 25, 0.03)])
def test_promises_hold_with_a_moved_pivot(interval, rows, size, accuracy, tmp_path) -> None:
    """Against a run at 1e-13 whose output times are close around the pulse."""
    scene = ramp_scene(tmp_path / "ramp.csv", interval, rows, size, 5.0, (-0.3, 0.4))
    run = pp.simulate(scene, accuracy=accuracy, samples=2)
    around = np.linspace(2.4, 2.6 + rows * interval, 301)
    exact = pp.simulate(scene, method="dop853", tolerance=1e-13, times=[0.0, *around, 5.0])
    assert np.linalg.norm(run.tips[-1] - exact.tips[-1]) <= run.stats.error + 1e-11


@pytest.mark.parametrize("turning", [False, True])
@pytest.mark.parametrize("method", ["dop853", "lsoda"])
def test_time_may_be_counted_from_anywhere(method, turning, tmp_path) -> None:
    """A track in seconds since 1970, or a rate of turning, gives the motion and the steps of one from 0, bit for bit."""
    runs = []
    for first in ("0", "1700000000", "-86400.5"):
        path = pulse_track(tmp_path / "track.csv", first, 10.0, 0.01, 4.0, 0.1)
        if turning:
            path.write_text("\n".join(",".join(row.split(",")[:2]) for row in path.read_text().splitlines()))
        effects = (Gravity(), Rotation(csv=path, axis=(0.0, 0.3, 1.0)) if turning else Support(csv=path))
        runs.append(run_of(*effects, method=method, tolerance=1e-9, duration=10.0, time=float(first)))
    for run in runs[1:]:
        assert np.array_equal(run.q, runs[0].q)
        assert run.stats.steps == runs[0].stats.steps


def test_a_late_start_within_a_track(tmp_path) -> None:
    """Rows with digits that no double has at their time: the run's times are the rows' times, to 1e-12 of the motion."""
    path = pulse_track(tmp_path / "track.csv", "1700000000.123456789", 10.0, 0.01, 4.0, 0.1)
    late = 1700000000.25
    offset = float(Decimal(late) - Decimal("1700000000.123456789"))
    shifted = pulse_track(tmp_path / "shifted.csv", repr(-offset), 10.0, 0.01, 4.0, 0.1)
    runs = [
        run_of(Gravity(), Support(csv=csv), method="dop853", tolerance=1e-10, duration=9.0, time=start)
        for csv, start in ((path, late), (shifted, 0.0))
    ]
    assert np.abs(runs[0].q - runs[1].q).max() < 1e-12


def test_an_effect_that_does_not_say_is_sampled_and_the_run_says_so() -> None:
    """Its pulse is seen where it is not shorter than the samples are apart; effects without time are not sampled."""
    run = run_of(Pulse(at=7.3, width=0.05, impulse=0.1), method="dop853", tolerance=1e-9, duration=20.0)
    assert run.v[-1, 0] == pytest.approx(0.1 / INERTIA, abs=1e-7)
    assert len(run.stats.notes) == 1
    assert "effects[0] (pulse) does not declare how fast it changes with time" in run.stats.notes[0]
    assert not run_of(Gravity(), method="dop853", tolerance=1e-9, duration=1.0).stats.notes
    motor = Motor(joint="theta", amplitude=1.0, frequency=3.0)
    assert not run_of(motor, method="dop853", tolerance=1e-9, duration=1.0).stats.notes


def test_a_fixed_step_that_is_too_long_is_noted() -> None:
    """A method with a fixed step keeps it; a note names what changes faster."""
    motor = Motor(joint="theta", amplitude=1.0, frequency=300.0)
    scene = pp.Scene(duration=1.0, model=ROD, effects=[motor])
    (note,) = pp.simulate(scene, method="rk4", step=0.02).stats.notes
    assert note == "effects[0] (motor) changes within 0.0105 s: take a smaller step than 0.02 s"
    assert not pp.simulate(scene, method="rk4", step=0.01).stats.notes


@law(50)
@given(
    at=st.floats(0.5, 9.5),
    width=st.floats(-2.5, -1.5).map(lambda x: 10**x),
    size=st.floats(-6, 0).map(lambda x: 10**x),
    slow=st.floats(0.1, 3.0),
)
def test_small_fast_changes_are_found_among_large_slow_ones(at, width, size, slow) -> None:
    """A pulse on a sinusoid bounds the steps where it acts, to some widths, and not far away.

    Pulses that stand out: in steps of many widths the sinusoid is closer to a polynomial than the pulse is high.
    """
    assume((16 * slow * width) ** 5 / 3e4 < 0.03 * size)
    t = np.linspace(0.0, 10.0, (1 << 14) + 1)
    signal = np.sin(slow * t) + size * np.exp(-(((t - at) / width) ** 2))
    pace = measure_pace(t, signal[:, None], 1e-9)
    near = at + np.array([-1.0, 0.0, 1.0]) * width
    assert (pace.at(near) < 8 * width).all()
    assert len(pace.corners) < 40
    lengths = np.diff(np.concatenate([[0.0], pace.corners, [10.0]]))
    assert (lengths / np.minimum(lengths, pace.shortest)).sum() < 300 + 40 * slow


@law(30)
@given(
    rate=st.floats(0.0, 3.0).map(lambda x: 10**x),
    pulse=st.floats(-4, -1).map(lambda x: 10**x),
    size=st.floats(-6, 1).map(lambda x: 10**x),
)
def test_eighth_differences_over_a_step_are_negligible(rate, pulse, size) -> None:
    """A step is eight strides of a power of 2, such that nothing else happens within; or one interval, or all of them."""
    t, negligible = np.linspace(0.0, 1.0, 1025), 1e-9
    signal = np.sin(rate * t) + size * np.exp(-(((t - 0.4) / pulse) ** 2))
    pace = measure_pace(t, signal[:, None], negligible)
    bounds = np.concatenate([[0.0], pace.corners, [1.0]])
    for begin, end, step in zip(
        np.rint(bounds * 1024)[:-1], np.rint(bounds * 1024)[1:], pace.shortest * 1024, strict=True
    ):
        assert step in (1, np.inf) or (step in 8 * 2.0 ** np.arange(8) and step < 1024)
        if np.isfinite(step) and step > 1:
            one = signal[int(begin) : int(end) + 1]
            some = one[np.arange(len(one) - int(step))[:, None] + np.arange(9) * int(step) // 8]
            assert (np.abs(some @ SIGNS) <= negligible * np.abs(signal).max()).all()


@pytest.mark.parametrize("method", ["radau", "bdf", "dop853", "lsoda"])
def test_methods_that_may_step_over_a_jump_say_so(method: str) -> None:
    """radau and bdf damp a jump of a user's function as a fast decay: from rest they are wrong by percents."""
    jumps = Torque(lambda t, q, v: -0.1 * np.sign(v), joints=["theta"])
    noted = [note for note in run_of(Gravity(), jumps, method=method, duration=0.5).stats.notes if "jumps" in note]
    assert len(noted) == (method in {"radau", "bdf"})
    assert not any("jumps" in note for note in run_of(Gravity(), method=method, duration=0.5).stats.notes)


class Controller:
    """A controller with a gain, as an object and as its method."""

    def __init__(self, gain=1.0):
        self.gain = gain

    def torque(self, t, q, v):
        return -self.gain * v

    __call__ = torque


LAWS = [
    lambda t, q, v: -v,
    lambda t, q, v: -v * np.cos(t),
    lambda *state: -state[2],
    partial(lambda k, t, q, v: -k * v, 2.0),
    Controller().torque,
    Controller(),
    np.vectorize(lambda t, q, v: -v, signature="(),(n),(n)->(n)"),
]


@pytest.mark.parametrize("law", LAWS)
def test_a_function_is_sampled_unless_it_declares_its_pace(law) -> None:
    """Whatever kind of function: what it does between the samples, nobody can see."""
    for declared, noted in (({}, True), ({"steady": True}, False), ({"shortest": 1.0}, False)):
        notes = run_of(Gravity(), Torque(law, **declared), method="dop853", duration=0.1).stats.notes
        assert any("does not declare how fast" in note for note in notes) == noted


@pytest.mark.parametrize("name", EFFECTS)
def test_built_in_effects_have_a_pace(name: str) -> None:
    """None of pendpin's own is sampled, and one to which time makes no difference acts alike at all times, to the bit."""
    effect = EFFECTS[name]
    pace = declared_pace(effect, 0.0, 1.0, 1e-10)
    assert pace is not None
    dynamics = pp.bind(pp.Scene(model=MODELS["chain of 5"], effects=[effect]))
    state = np.random.default_rng(3).uniform(-1, 1, (2, 10))
    early, late = (dynamics.acceleration(t, *state) for t in (0.3, 1.7))
    assert np.array_equal(early, late) == np.isinf(pace.shortest).all()


@law(15)
@given(
    method=st.sampled_from((*METHODS, "rk4", "gauss2", "gauss4")),
    begin=st.floats(0.05, 0.9),
    width=st.floats(-2.8, -1.3).map(lambda x: 10**x),
    duration=st.sampled_from([1.0, 7.0]),
    start=st.sampled_from([0.0, -7.5, 100.0]),
)
@example(method="rk4", begin=0.24691, width=1e-3, duration=5.0, start=0.0)  # 5 ms of 5 s
def test_rectangular_pulses_have_their_whole_impulse(method, begin, width, duration, start) -> None:
    """A function that switches on and off, in floats of the clock: each jump is located, and no step crosses it.

    A free rod turns at the rate of the impulse, whatever the method and its step; rounding of the switching times,
    some units in the last place of the clock, over the width is all that is left.
    """
    on, off = start + begin * duration, start + (begin + width) * duration

    def torque(t, q, v):
        return np.array([1.0 if on <= t < off else 0.0])

    setting = {"step": duration / 20} if method in ("rk4", "gauss2", "gauss4") else {"tolerance": 1e-6}
    at = pp.Start(time=start)
    scene = pp.Scene(duration=duration, model=ROD, start=at, effects=[Torque(torque, joints=["theta"])])
    run = pp.simulate(scene, method=method, samples=2, **setting)
    rounding = 1e-14 * (abs(start) + duration)
    assert run.v[-1, 0] * INERTIA == pytest.approx(off - on, rel=1e-12, abs=rounding)
    if "step" in setting:  # these methods are exact for a constant torque
        turned = (off - on) * (start + duration - (on + off) / 2)
        assert run.q[-1, 0] * INERTIA == pytest.approx(turned, rel=1e-10, abs=duration * rounding)


class Damper(JointEffect):
    """A damper of a user's own, which declares nothing."""

    kind: Literal["damper"] = "damper"

    def torques(self, t, q, v, xp=np):
        """N m."""
        return -0.2 * v


class DeclaredDamper(Damper):
    """One that declares all."""

    kind: Literal["declared damper"] = "declared damper"

    @property
    def smooth(self):
        """It is."""
        return True

    def pace(self, begin, end, negligible):
        """Time makes no difference."""
        return STEADY


class Brake(DeclaredDamper):
    """One that declares that it is not smooth."""

    kind: Literal["brake"] = "brake"

    def torques(self, t, q, v, xp=np):
        """N m."""
        return -0.01 * np.sign(v)

    pace = DeclaredDamper.pace  # other torques than those that it was declared of

    @property
    def smooth(self):
        """It is not."""
        return False


@pytest.mark.parametrize(
    ("effect", "says"),
    [
        (Damper(), ["does not declare how fast", "does not declare that it is smooth"]),
        (DeclaredDamper(), []),
        (Torque(lambda t, q, v: -0.2 * v), ["does not declare how fast", "does not declare that it is smooth"]),
        (Torque(lambda t, q, v: -0.2 * v, steady=True, gradual=True), []),
        (Torque(lambda t, q, v: -0.2 * np.sin(50 * t) * v, shortest=0.06, gradual=True), []),
        (Torque(lambda t, q, v: -0.01 * np.sign(v), steady=True, gradual=True), []),
        (Torque(lambda t, q, v: -0.01 * np.sign(v), steady=True, gradual=False), ["is not smooth"]),
        (Brake(), ["is not smooth"]),
        (pp.effects.Drag(diameter=0.04), []),
        (pp.effects.Viscous(coefficient=0.1), []),
    ],
    ids=[
        *("damper", "declared damper", "torque", "declared torque", "torque of time", "torque that jumps"),
        *("torque said to jump", "brake", "drag", "viscous"),
    ],  # names of functions hold addresses, which differ from one process of the tests to another
)
def test_an_estimated_error_names_what_it_assumes(effect, says) -> None:
    """What is declared to be smooth is not noted, nor is what is pendpin's own."""
    start = pp.Start(positions={"theta": 1.0, "phi": 0.3}, velocities={"phi": 0.5})
    scene = pp.Scene(duration=2.0, model=ROD, start=start, effects=(Gravity(), effect))
    notes = pp.simulate(scene, method="dop853", accuracy=1e-4).stats.notes
    assert len(notes) == len(says), notes
    assert all(f"effects[1] ({effect.kind})" in note and words in note for note, words in zip(notes, says, strict=True))


def test_a_record_tells_one_function_from_another() -> None:
    """By source and by the values that it holds, the same in every process: a checkpoint must not go on with another."""

    def recorded(function):
        return Torque(function).model_dump(mode="json")["function"]

    def held(gain):
        return lambda t, q, v: [-gain * x for x in v]

    def scaled(gain, t, q, v):
        return -gain * v

    for make in (held, Controller, lambda gain: Controller(gain).torque, lambda gain: partial(scaled, gain)):
        assert recorded(make(1.0)) == recorded(make(1.0))
        assert recorded(make(1.0)) != recorded(make(2.0))
    assert recorded(LAWS[0]) != recorded(held(1.0))


def test_paces_join() -> None:
    """The corners of all, and the shortest time of each piece."""
    pace = join_paces(
        [Pace(np.array([2.0]), np.array([1.0, np.inf])), Pace(np.array([1.0, 2.0]), np.array([9, 0.5, 9]))]
    )
    assert pace.corners.tolist() == [1.0, 2.0]
    assert pace.shortest.tolist() == [1.0, 0.5, 9.0]


class Misdeclared(PacedPulse):
    """A pulse with one shortest time for three pieces."""

    kind: Literal["misdeclared"] = "misdeclared"

    def pace(self, begin, end, negligible):
        """Too few numbers."""
        return Pace(np.array([1.0, 2.0]), np.array([0.1]))


class Number(PacedPulse):
    """A pulse whose pace is a time in s."""

    kind: Literal["number"] = "number"

    def pace(self, begin, end, negligible):
        """The shortest time alone."""
        return 0.1


def test_a_pace_that_makes_no_sense_is_refused() -> None:
    """In one line that names the effect and what would be right."""
    with pytest.raises(pp.InputError, match=r"misdeclared: its pace has corners .* one more than corners"):
        run_of(Misdeclared(at=1.0, width=0.1, impulse=0.1), method="dop853", tolerance=1e-9, duration=3.0)
    with pytest.raises(pp.InputError, match=r"number: its pace returned 0.1; return a Pace, such as Pace.even"):
        run_of(Number(at=1.0, width=0.1, impulse=0.1), method="dop853", tolerance=1e-9, duration=3.0)
