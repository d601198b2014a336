"""Impacts, scales and searches of contacts by a second route: trial of every set, other units, what comes next."""

import math
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin.dynamics.contacts import Contacts, Mode, Scales
from pendpin.dynamics.falls import LEAST, LOWER, MOST, RATE, UPPER, Falls, guards_of, rates_and_mode
from pendpin.effects import DryFriction, Effect, Gravity, Motor, Stop
from pendpin.ground.arrays import EPS, Array
from test_contacts_exact import NAMES, ONE, TWO, contacts_of

# --- impacts, by trial of every set of joints that are pushed ----------------------------------------------------------


def impact_by_trial(A: Array, away: Array, back: Array) -> Array:
    """Rates (k,) away from the stops after one impact of joints that touch, by the set of pushed ones that fits best."""
    wanted = back * np.maximum(-away, 0.0)

    def tried(chosen: tuple[bool, ...]) -> tuple[float, Array]:
        pushed, impulse = np.array(chosen), np.zeros(len(away))
        if pushed.any():
            impulse[pushed] = np.linalg.solve(A[np.ix_(pushed, pushed)], (wanted - away)[pushed])
        after = away + A @ impulse
        unfit = max((-impulse * np.diag(A)).max(), (wanted - after).max())
        return unfit, np.where(pushed, wanted, np.maximum(after, wanted))

    return min((tried(chosen) for chosen in product([True, False], repeat=len(away))), key=lambda one: one[0])[1]


def rates_by_trial(A: Array, away: Array, back: Array) -> Array | None:
    """Impacts one by one, until none moves into its stop; None if there are thousands."""
    for _ in range(3000):
        if (away >= 0).all():
            return away
        touch, impulse = away <= 0, np.zeros(len(away))
        after = impact_by_trial(A[np.ix_(touch, touch)], away[touch], back[touch])
        impulse[touch] = np.linalg.solve(A[np.ix_(touch, touch)], after - away[touch])
        away = away + A @ impulse
        away[touch] = after
    return None


@law(60)
@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.sampled_from([0.0, 0.2, 0.5, 0.9, 0.99, 1.0]), min_size=4, max_size=4),
    st.tuples(*[st.booleans()] * 4),
)
def test_impacts_are_those_found_by_trial(seed: int, back: list[float], at: tuple[bool, ...]) -> None:
    """However joints couple and whichever stops they hit, each with its restitution: impacts one by one come to the same.

    A series without end comes to rest on its stops; the sum of its impulses pushes.
    """
    assume(any(at))
    random, touching = np.random.default_rng(seed), np.array(at)
    rods = [pp.Rod(length=10**x, mass=10**y, radius=0.05) for x, y in random.uniform(-0.5, 0.5, (2, 2))]
    stops = [Stop(lower=-0.4, upper=0.4, restitution=e, joints=[name]) for name, e in zip(NAMES, back, strict=True)]
    contacts = pp.bind(pp.Scene(model=pp.Chain(rods=rods), effects=stops)).contacts
    assert contacts is not None
    q, v = random.uniform(-0.3, 0.3, 4), random.uniform(-2, 2, 4)
    side = random.choice([-1.0, 1.0], 4)
    q[touching] = -0.4 * side[touching]
    before = v.copy()
    after = contacts.strike(q, v, 0.0)
    columns, side = contacts.engine.compliance(q, np.flatnonzero(at)), side[touching]
    expected = rates_by_trial(side[:, None] * columns[touching] * side, side * v[touching], np.array(back)[touching])
    assert (v == before).all()
    if expected is not None:
        assert side * after[touching] == pytest.approx(expected, abs=1e-9 * np.abs(v).max())
    impulse = np.linalg.solve(columns[touching], (after - v)[touching])
    assert after == pytest.approx(
        v + columns @ impulse, abs=1e-11 * np.abs(v).max() * (1 + np.abs(columns @ impulse).max())
    )


@law(30)
@given(st.lists(st.floats(-2, 2), min_size=8, max_size=8), st.sets(st.integers(0, 3), min_size=1))
def test_joints_that_come_to_rest_push_nothing_else(numbers: list[float], joints: set[int]) -> None:
    """Their rates end exactly; the momentum of every other joint is what it was."""
    contacts = pp.bind(pp.Scene(model=TWO, effects=[Stop(upper=3.0)])).contacts
    assert contacts is not None
    (q, v), some = np.array(numbers).reshape(2, 4), np.array(sorted(joints))
    after = contacts.rest(q, v, some)
    assert (after[some] == 0).all()
    momentum = np.linalg.solve(contacts.engine.compliance(q, np.arange(4)), after - v)
    assert np.delete(momentum, some) == pytest.approx(0, abs=1e-9 * (1 + np.abs(momentum).max()))


# --- other units of length ----------------------------------------------------------------------------------------------

CART = """<robot name="cart"><link name="base"/>
<link name="car"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="car"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
<link name="pole"><inertial><origin xyz="0 0 {half}"/><mass value="0.5"/>
<inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="a" type="continuous"><parent link="car"/><child link="pole"/><axis xyz="0 -1 0"/></joint>
<link name="weight"><inertial><origin xyz="0 0 0"/><mass value="0.1"/>
<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="end" type="fixed"><parent link="pole"/><child link="weight"/><origin xyz="0 0 {long}"/></joint></robot>"""


class Cart(NamedTuple):
    """A pole on a cart, told in units of length of 1 / k m; kg and s are as they are."""

    contacts: Contacts
    k: float
    lengths: Array  # what lengths per joint are multiplied by: k of the slide, 1 of the pole

    def state(self, x: float, a: float) -> Array:
        return np.array([x, a]) * self.lengths

    def scales(self, q: Array, v: Array) -> Scales:
        return self.contacts.scales(np.linspace(0, 3, 7), q, v)


def cart(folder: Path, k: float, kinetic: float = 0.3, pull: float = 0.0) -> Cart:
    """With friction and stops on both joints, gravity and a force on the cart."""
    file = folder / f"cart_{k:g}.urdf"
    file.write_text(CART.format(half=-0.4 * k, long=-0.8 * k, inertia=0.03 * k**2))
    effects: list[Effect] = [Gravity(acceleration=9.81 * k), Motor(joint="x", torque=pull * k)]
    for name, unit, force in (("x", k, k), ("a", 1.0, k**2)):
        effects += [
            DryFriction(kinetic=kinetic * force, static=2 * kinetic * force, joints=[name]),
            Stop(lower=-0.5 * unit, upper=0.5 * unit, restitution=0.6, joints=[name]),
        ]
    contacts = pp.bind(pp.Scene(model=pp.UrdfModel(path=file), effects=effects)).contacts
    assert contacts is not None
    return Cart(contacts, k, np.array([k, 1.0]))


NEARBY = st.sampled_from([-0.5, -0.2, 0.0, 0.3, 0.5])
SPEED = st.sampled_from([-2.0, -1e-9, 0.0, 0.4])


@law(40)
@given(
    q=st.tuples(NEARBY, NEARBY),
    v=st.tuples(SPEED, SPEED),
    pull=st.sampled_from([-3.0, 0.0, 40.0]),
    kinetic=st.sampled_from([0.05, 0.7]),
)
def test_the_unit_of_length_changes_nothing(q, v, pull, kinetic, tmp_path_factory) -> None:
    """A cart with its pole in m and in quarters of a m: scales, rates, modes and guards are the same, each in its unit."""
    one, other = (cart(tmp_path_factory.getbasetemp(), k, kinetic, pull) for k in (1.0, 4.0))
    (q1, v1), (q4, v4) = ((c.state(*q), c.state(*v)) for c in (one, other))
    scales1, scales4 = one.scales(q1, v1), other.scales(q4, v4)
    turn = other.lengths
    near = lambda x: pytest.approx(x, rel=1e-10, abs=1e-13)  # noqa: E731
    assert scales4.position / turn == near(scales1.position)
    assert scales4.rate / turn == near(scales1.rate)
    assert scales4.torque / (turn * 4 ** np.array([0, 2])) == near(scales1.torque)
    after1, mode1 = rates_and_mode(one.contacts, 0.0, q1, v1, scales1)
    after4, mode4 = rates_and_mode(other.contacts, 0.0, q4, v4, scales4)
    assert after4 / turn == near(after1)
    assert (mode4.held.tolist(), mode4.sign.tolist()) == (mode1.held.tolist(), mode1.sign.tolist())
    guards1, guards4 = (
        guards_of(c.contacts, p, m, s, 1e-9) for c, p, m, s in ((one, q1, mode1, scales1), (other, q4, mode4, scales4))
    )
    assert guards4.kind.tolist() == guards1.kind.tolist()
    unit = np.where(guards1.kind >= MOST, np.array([4.0, 16.0])[guards1.joint], turn[guards1.joint])
    assert guards4.floor / unit == near(guards1.floor)
    assert guards4.offset / unit == near(guards1.offset)


@law(20)
@given(st.lists(st.floats(-1, 1), min_size=8, max_size=8), st.sampled_from([(-1, 1), (1, -1), (-1, -1)]))
def test_mirror_images_have_the_same_scales(numbers: list[float], signs: tuple[int, int]) -> None:
    """In the planes of theta and of phi: positions, rates and torques."""
    contacts = pp.bind(pp.Scene(model=TWO, effects=[Gravity(), DryFriction(kinetic=0.1)])).contacts
    assert contacts is not None
    (q, v), mirror, times = np.array(numbers).reshape(2, 4), np.tile(signs, 2), np.linspace(0, 1, 5)
    for one, other in zip(contacts.scales(times, q, v), contacts.scales(times, mirror * q, mirror * v), strict=True):
        assert one == pytest.approx(other, rel=1e-9)


# --- what is small ---------------------------------------------------------------------------------------------------------


def test_a_guard_a_hundredth_of_the_tolerance_below_0_is_no_event() -> None:
    """Of the scales of the run; at the finest tolerance a few roundings of rates and of stops; 1e-12 of torques."""
    contacts = contacts_of(DryFriction(kinetic=0.2, static=0.5), Stop(lower=-0.4, upper=0.3))
    scales = Scales(np.ones(2), np.full(2, 5.0), np.full(2, 7.0))
    mode = Mode(np.array([False, True]), np.array([1.0, 0.0]), np.full(2, 7.0))
    coarse, fine = (guards_of(contacts, np.zeros(2), mode, scales, tolerance) for tolerance in (1e-6, 0.0))
    kinds = coarse.kind.tolist()
    assert kinds == [RATE, UPPER, LOWER, MOST, LEAST]
    assert coarse.floor == pytest.approx([5e-8, 1e-8, 1e-8, 7e-12, 7e-12], rel=1e-6)
    assert fine.floor[:3] / [5.0, 0.3, 0.4] / EPS == pytest.approx([4.5] * 3)


@law(100)
@given(
    height=st.floats(-14, 1).map(lambda x: 10**x),
    t=st.sampled_from([0.0, 1.0, 1e4, 1e9]),
    q=st.sampled_from([0.0, 1.0, 1e5]),
    tolerance=st.sampled_from([1e-3, 1e-9, 1e-13]),
)
def test_a_method_is_not_asked_for_less_than_rounding(height: float, t: float, q: float, tolerance: float) -> None:
    """Its tolerance is of the fall, of 1e-12 rad at the least; its error is 16 roundings or more, of place and time."""
    a, ones = 2.0, np.ones(1)
    low = Falls(np.array([height]), np.array([a])).low(t, np.array([q]), Scales(ones, ones, ones), tolerance)
    assert (low is None) == (height >= 0.1)
    if low is None:
        return
    position, rate = low.scales.position[0], low.scales.rate[0]
    rounding = 16 * (np.spacing(q) + math.ulp(t) * math.sqrt(2 * a * height))
    assert position == pytest.approx(min(1.0, max(height, 1e-12, rounding / tolerance)), rel=1e-12)
    assert rate == pytest.approx(min(1.0, math.sqrt(2 * a * position)), rel=1e-12)
    assert low.shortest == low.longest == pytest.approx(max(math.sqrt(8 * height / a), 64 * math.ulp(t)), rel=1e-12)


@pytest.mark.parametrize(
    ("stop", "t", "least"),
    [
        (0.4, 0.0, 1e-12),
        (1e6, 0.0, 64 * np.spacing(1e6)),  # 64 roundings of the place
        (0.4, 1e9, (64 * math.ulp(1e9)) ** 2 / 8),  # at 1 rad/s² this far takes 64 roundings of the time
    ],
)
def test_the_least_bounce(stop: float, t: float, least: float) -> None:
    """What goes less far than 1e-12 rad, or than numbers can tell, in place or in time, rests; a little more flies."""
    contacts = contacts_of(Stop(upper=stop, restitution=0.5, joints=["theta"]), Motor(joint="theta", torque=1.0))
    q = np.array([stop, 0.0])
    a = contacts.engine.compliance(q, np.array([0]))[0, 0]
    scale = a if t else 1.0  # a time of fall is by its acceleration
    for share in (0.98, 1.02):
        v = np.array([-math.sqrt(2 * a * scale * share * least), 0.0])
        rates, mode = rates_and_mode(contacts, t, q, v, ONE)
        assert (rates[0] == 0) == (share < 1)
        assert mode.held[0] == (share < 1)


# --- searches -------------------------------------------------------------------------------------------------------


@law(60)
@given(st.integers(0, 2**32 - 1))
def test_what_sticks_or_rests_fits_by_every_condition(seed: int) -> None:
    """Held joints stay within friction and stops, on either side; free ones do not start into a stop or against it."""
    random = np.random.default_rng(seed)
    torques, kinetic = random.uniform(-3, 3, 4), random.uniform(0, 1.5, 4) * (random.random(4) < 0.6)
    q = random.choice([-0.4, 0.1, 0.4], 4)
    effects = [Motor(joint=name, torque=x) for name, x in zip(NAMES, torques.tolist(), strict=True)]
    effects += [DryFriction(kinetic=x, joints=[n]) for n, x in zip(NAMES, kinetic.tolist(), strict=True) if x]
    contacts = pp.bind(pp.Scene(model=TWO, effects=[*effects, Stop(lower=-0.4, upper=0.4)])).contacts
    assert contacts is not None
    v = np.zeros(4)
    mode = contacts.choose(0.0, q, v, Scales(*np.ones((3, 4))))
    a, holding = contacts.accelerate(0.0, q, v, mode)
    size = 1e-9 * (1 + np.abs(a).max())
    held, free = mode.held, ~mode.held
    can = (kinetic > 0) | (np.abs(q) == 0.4)
    assert not (held & ~can).any()
    assert (a[held] == 0).all()
    assert (holding[free] == 0).all()
    top, low = q == 0.4, q == -0.4
    assert (holding[held & ~low] <= kinetic[held & ~low] + size).all()
    assert (holding[held & ~top] >= -kinetic[held & ~top] - size).all()
    assert (a[free & top] <= size).all()
    assert (a[free & low] >= -size).all()
    assert (mode.sign[free & (kinetic > 0)] != 0).all()
    assert (a[free & (kinetic > 0)] * mode.sign[free & (kinetic > 0)] >= -size).all()
