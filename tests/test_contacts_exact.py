"""Parts of contacts against exact values: what holds, which way joints start, falls at constant acceleration, scales."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin.dynamics.contacts import Contacts, Mode, Scales
from pendpin.dynamics.falls import LEAST, LOWER, MOST, RATE, UPPER, Falls, falls_of, guards_of, rates_and_mode
from pendpin.effects import DryFriction, Motor, Stop

ROD = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.05),))
INERTIA = ROD.rods[0].properties.I1 + 0.25  # kg m² about the joint, of theta where phi is 0 and of phi
TWO = pp.Chain(rods=ROD.rods, copies=2)
NAMES = ("theta_1", "phi_1", "theta_2", "phi_2")
ONE = Scales(np.ones(2), np.ones(2), np.ones(2))


def contacts_of(*effects: pp.effects.Effect) -> Contacts:
    """Of a rod without gravity."""
    contacts = pp.bind(pp.Scene(model=ROD, effects=effects)).contacts
    assert contacts is not None
    return contacts


def free(contacts: Contacts) -> Mode:
    """Nothing is held, nothing rubs."""
    return Mode(np.zeros(2, bool), np.zeros(2), np.ones(2))


@pytest.mark.parametrize(
    ("effect", "holds"),
    [
        (Stop(lower=-0.5, joints=["theta"]), [True, False]),
        (Stop(upper=0.5, joints=["phi"]), [False, True]),
        (Stop(lower=-0.5, upper=0.5, joints=["phi"]), [False, True]),
        (DryFriction(kinetic=0.1, joints=["theta"]), [True, False]),
        (DryFriction(kinetic=0.1), [True, True]),
    ],
    ids=["lower", "upper", "both", "friction", "friction on all"],
)
def test_what_can_hold_a_joint(effect: pp.effects.Effect, holds: list[bool]) -> None:
    """A stop on either side, or friction."""
    assert contacts_of(effect).holding.tolist() == holds


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("torque", [0.3, -0.3])
def test_a_stop_holds_what_is_pushed_into_it(side: int, torque: float) -> None:
    """With the torque that pushes; what is pulled off it starts with torque over inertia, on either side."""
    stop = Stop(lower=-0.4, upper=0.4, joints=["theta"])
    contacts = contacts_of(stop, Motor(joint="theta", torque=torque))
    q, v = np.array([0.4 * side, 0.0]), np.zeros(2)
    assert contacts.at_stops(q)[0].tolist() == [0]
    assert contacts.at_stops(q)[1].tolist() == [-side]
    mode = contacts.choose(0.0, q, v, ONE)
    a, holding = contacts.accelerate(0.0, q, v, mode)
    into = torque * side > 0
    assert mode.held.tolist() == [into, False]
    assert holding == pytest.approx([-torque if into else 0.0, 0.0], abs=1e-15)
    assert a == pytest.approx([0.0 if into else torque / INERTIA, 0.0], abs=1e-14)


@pytest.mark.parametrize(("torque", "held"), [(0.49, True), (0.51, False), (-0.49, True), (-0.51, False)])
def test_friction_holds_up_to_its_static_torque(torque: float, held: bool) -> None:
    """Beyond it the joint starts the way that it is pushed, against the kinetic torque."""
    contacts = contacts_of(DryFriction(kinetic=0.2, static=0.5, joints=["theta"]), Motor(joint="theta", torque=torque))
    q, v = np.array([0.1, 0.0]), np.zeros(2)
    mode = contacts.choose(0.0, q, v, ONE)
    assert mode.held.tolist() == [held, False]
    a, _ = contacts.accelerate(0.0, q, v, mode)
    assert a[0] == pytest.approx(0.0 if held else (torque - math.copysign(0.2, torque)) / INERTIA, rel=1e-12)
    if not held:
        assert mode.sign.tolist() == [np.sign(torque), 0]


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("thrown", [0.0, 0.7, -0.7])
def test_a_fall_at_constant_acceleration(sign: int, thrown: float) -> None:
    """Onto the stop that it is pushed to: thrown up, it has its highest point v² / 2a farther away than it is."""
    torque, away = 0.6 * sign, 0.3
    contacts = contacts_of(Stop(lower=-0.4, upper=0.4, joints=["theta"]), Motor(joint="theta", torque=torque))
    a = abs(torque) / INERTIA
    q, v = np.array([sign * (0.4 - away), 0.0]), np.array([thrown, 0.0])
    fall = falls_of(contacts, 0.0, q, v, free(contacts))
    height = away + thrown**2 / (2 * a)
    assert fall.height[0] == pytest.approx(height, rel=1e-12)
    assert fall.height[1] == np.inf
    assert fall.acceleration == pytest.approx([a, 0.0], rel=1e-12)
    with np.errstate(invalid="ignore"):  # of phi, which does not fall
        rate = fall.rate[0]
    assert rate == pytest.approx(math.sqrt(2 * a * height), rel=1e-12)
    assert fall.time[0] == pytest.approx(2 * rate / a, rel=1e-12)  # up, and down again


def test_low_falls_tell_the_shortest_and_the_longest() -> None:
    """Two joints fall 1e-6 and 1e-2 rad, or times as long as the rounding of the clock; a third fall is too high."""
    height, a = np.array([1e-6, 1e-2, 0.5]), np.array([2.0, 0.5, 1.0])
    three = Scales(*np.ones((3, 3)))
    low = Falls(height, a).low(0.0, np.zeros(3), three, 1e-6)
    assert low is not None
    assert low.joints.tolist() == [True, True, False]
    assert (low.shortest, low.longest) == pytest.approx(tuple(np.sqrt(8 * height[:2] / a[:2])), rel=1e-12)
    assert low.scales.position == pytest.approx([1e-6, 1e-2, 1.0], rel=1e-12)
    assert low.scales.rate == pytest.approx([*np.sqrt(2 * height[:2] * a[:2]), 1.0], rel=1e-12)
    late = Falls(height, a).low(1e12, np.zeros(3), three, 1e-6)
    assert late is not None
    assert late.shortest == 64 * math.ulp(1e12)
    assert Falls(height + 0.1, a).low(0.0, np.zeros(3), three, 1e-6) is None


def test_only_the_bounces_that_are_too_small_end() -> None:
    """Two joints leave their stops at once, one by 1e-16 rad and one by 0.01 rad: one rests, one flies."""
    stop, push = Stop(upper=0.4, restitution=0.5), [Motor(joint=name, torque=1.0) for name in ("theta", "phi")]
    contacts = contacts_of(stop, *push)
    a = contacts.engine.compliance(np.array([0.4, 0.4]), np.arange(2)) @ np.ones(2)
    after = np.sqrt(2 * a * np.array([1e-17, 1e-2]))
    rates, mode = rates_and_mode(contacts, 0.0, np.array([0.4, 0.4]), 2 * after, ONE)
    assert rates[0] == 0
    assert mode.held.tolist() == [True, False]
    assert rates[1] == pytest.approx(-after[1], rel=1e-6)


@pytest.mark.parametrize("static", [0.0, 3.0])
def test_scales_are_those_of_the_torques_and_rates(static: float) -> None:
    """Rates of torque over inertia for a radian, or those of the start, or a radian in the run; torques that act or hold."""
    torque, times = 2.0, np.linspace(0, 1e6, 5)

    def scales(torque: float, v: float = 0.0, span: float = 1.0) -> Scales:
        friction = DryFriction(kinetic=static, joints=["theta"]) if static else Stop(upper=1.0, joints=["theta"])
        contacts = contacts_of(friction, Motor(joint="theta", torque=torque))
        return contacts.scales(span * times, np.zeros(2), np.array([v, 0.0]))

    found = scales(torque)
    assert (found.position == 1).all()
    assert found.rate[0] == found.rate[1]
    assert found.rate[0] ** 2 >= max(torque, static) / INERTIA * (1 - 1e-12)
    assert found.torque[0] >= torque + static
    assert scales(torque, 50.0).rate == pytest.approx([50.0, 50.0])
    if not static:
        more = scales(16 * torque)  # in a time 4 times shorter the same
        assert more.rate == pytest.approx(4 * found.rate, rel=1e-12)
        assert more.torque == pytest.approx(16 * found.torque, rel=1e-12)
        assert scales(0.0, span=1e-9).rate == pytest.approx([1e3, 1e3])


@pytest.mark.parametrize(
    ("at", "held_before", "fired", "held_after", "said"),
    [
        (0.0, False, RATE, True, "stick"),
        (0.0, False, RATE, False, "reverse"),
        (0.0, True, LEAST, False, "slip"),
        (0.4, True, LEAST, False, "release"),
        (-0.4, True, MOST, False, "release"),
        (0.4, False, UPPER, False, "stop"),
        (-0.4, False, LOWER, True, "stop"),
    ],
)
def test_what_an_event_is_called(at: float, held_before: bool, fired: int, held_after: bool, said: str) -> None:
    """By what fired and by what is held before and after; joints that nothing happens to are not named."""
    contacts = contacts_of(DryFriction(kinetic=0.2, static=0.5), Stop(lower=-0.4, upper=0.4))
    mode = Mode(np.array([held_before, True]), np.array([float(not held_before), 0.0]), np.ones(2))
    q = np.array([at, 0.0])
    guards = guards_of(contacts, q, mode, ONE, 1e-9)
    numbers = np.flatnonzero((guards.kind == fired) & (guards.joint == 0)).tolist()
    assert guards.changes(q, numbers, np.array([held_after, True])) == [(0, said)]
    assert guards.changes(q, [], np.array([held_before, True])) == []


def test_guards_are_0_where_something_happens() -> None:
    """At a stop, at rest, and at the largest torque that holds; positive before. Landing sets what they say exactly."""
    contacts = contacts_of(
        DryFriction(kinetic=0.2, static=0.5, joints=["theta"]), Stop(lower=-0.4, upper=0.3, joints=["theta"])
    )
    sliding = Mode(np.array([False, False]), np.array([-1.0, 0.0]), np.ones(2))
    guards = guards_of(contacts, np.zeros(2), sliding, ONE, 1e-9)
    named = {kind: i for i, kind in enumerate(guards.kind.tolist())}
    assert set(named) == {RATE, UPPER, LOWER}
    values = guards.values(np.zeros(2), np.array([[0.1, 0.0, -2.0, 0.0], [0.3, 0.0, 0.0, 0.0]]))
    assert values[:, named[RATE]] == pytest.approx([2.0, 0.0])  # it slides backwards
    assert values[:, named[UPPER]] == pytest.approx([0.2, 0.0])
    assert values[:, named[LOWER]] == pytest.approx([0.5, 0.7])
    q, v = np.array([0.3 + 1e-12, 0.1]), np.array([1e-12, 0.2])
    loose = guards.land(q, v, [named[RATE], named[UPPER]])
    assert (q.tolist(), v.tolist(), loose.tolist()) == ([0.3, 0.1], [0.0, 0.2], [0.0, 0.0])


@pytest.mark.parametrize("torque", [0.3, -0.3])
def test_guards_of_a_held_joint_are_what_is_left_of_its_hold(torque: float) -> None:
    """Static friction less the torque that holds, and plus it; at the end it starts the way that it is pushed."""
    contacts = contacts_of(DryFriction(kinetic=0.2, static=0.5, joints=["theta"]), Motor(joint="theta", torque=torque))
    held = Mode(np.array([True, False]), np.zeros(2), np.ones(2))
    guards = guards_of(contacts, np.zeros(2), held, ONE, 1e-9)
    assert guards.kind.tolist() == [MOST, LEAST]
    values = guards.values(np.zeros(1), np.zeros((1, 4)))[0]
    assert values == pytest.approx([0.5 + torque, 0.5 - torque])  # what holds is -torque
    assert guards.land(np.zeros(2), np.zeros(2), [0]).tolist() == [-1.0, 0.0]
    assert guards.land(np.zeros(2), np.zeros(2), [1]).tolist() == [1.0, 0.0]


@law(30)
@given(st.lists(st.floats(-2, 2), min_size=12, max_size=12))
def test_what_rubs_starts_as_it_accelerates(numbers: list[float]) -> None:
    """Joints at rest are held within their static torques, or start the way that they accelerate, however they couple."""
    q, torques, static = np.array(numbers).reshape(3, 4)
    kinetic = np.abs(static)
    pushes = [Motor(joint=name, torque=torque) for name, torque in zip(NAMES, torques.tolist(), strict=True)]
    rubs = [
        DryFriction(kinetic=value, joints=[name]) for name, value in zip(NAMES, kinetic.tolist(), strict=True) if value
    ]
    assume(rubs)
    contacts = pp.bind(pp.Scene(model=TWO, effects=[*pushes, *rubs])).contacts
    assert contacts is not None
    v = np.zeros(4)
    mode = contacts.choose(0.0, q, v, Scales(*np.ones((3, 4))))
    a, holding = contacts.accelerate(0.0, q, v, mode)
    size = 1e-9 * (1 + np.abs(a).max())
    assert (np.abs(holding[mode.held]) <= kinetic[mode.held] + size).all()
    started = ~mode.held & (kinetic > 0)
    assert (mode.sign[started] != 0).all()
    assert (a[started] * mode.sign[started] >= -size).all()
