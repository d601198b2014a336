"""Cables: bending stiffness against beams and elasticas, anchors against catenaries, spheres as payloads.

The closed forms are those of Euler and Bernoulli (S. P. Timoshenko, History of Strength of Materials, 1953) and of the
inextensible catenary.
"""

import math
import re
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import root

import pendpin as pp
from pendpin import effects as fx
from pendpin.dynamics.compiling import EquationsOfMotion, records_by_rod
from pendpin.dynamics.dynamics import bind
from pendpin.effects.joints import _asin_over_x
from pendpin.model import kinematics
from pendpin.model.build import build

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
import cables as benchmark

EI, LENGTH, MASS = benchmark.EI, benchmark.LENGTH, benchmark.MASS  # N m², m, kg/m
MIXED = pp.Chain(
    rods=[
        pp.Rod(length=0.5, mass=0.4, radius=0.02, copies=2),
        pp.Rod(length=0.7, mass=0.3, radius=0.03, payload=0.5, payload_radius=0.1),
        pp.Rod(length=0.4, mass=0.2, radius=0.01),
    ]
)


def beam(n: int, radius: float = 1e-3) -> pp.Chain:
    """A beam in n rods."""
    return pp.Chain(rods=[pp.Rod(length=LENGTH / n, mass=MASS * LENGTH / n, radius=radius, copies=n)])


def still(model: pp.Chain, *effects: fx.Effect, **positions: float) -> pp.Scene:
    """A scene of a second, from these positions."""
    return pp.Scene(duration=1.0, model=model, effects=effects, start=pp.Start(positions=positions))


def at_rest(scene: pp.Scene) -> pp.Trajectory:
    """The scene at its equilibrium, one sample."""
    return pp.simulate(scene.replace(start=pp.Start.at_rest(scene)), duration=0.0, samples=1)


angles = st.lists(st.floats(-1.3, 1.3), min_size=8, max_size=8)


@given(angles, st.sampled_from([None, (0.3, -0.5, -2.0), (1.0, 0.0, 0.0)]))
def test_bending_is_a_moment_about_the_normal_of_both_axes(q: list[float], clamp: tuple | None) -> None:
    """Torques about the joints, from moments EI alpha / l on the rods; axes and directions from the poses alone.

    Where the axes are almost parallel, their angle by arctan2 has the rounding error of the cross product.
    """
    model, effect = build(MIXED), fx.Bending(stiffness=EI, clamp=clamp)
    state = np.array([q])
    poses = kinematics.poses(model, state)[0]
    along = -poses[:, :3, 2]
    lengths = np.array([rod.length for rod in MIXED.all_rods])
    moments = np.zeros((4, 3))
    for rod in range(4):
        before = np.array(clamp) / np.linalg.norm(clamp) if rod == 0 and clamp else along[rod - 1]
        span = lengths[0] / 2 if rod == 0 else (lengths[rod - 1] + lengths[rod]) / 2
        if rod or clamp:
            normal = np.cross(along[rod], before)
            size = np.linalg.norm(normal)
            angle = math.atan2(size, along[rod] @ before)
            moment = EI * angle / span * normal / size if size else np.zeros(3)
            moments[rod] += moment
            if rod:
                moments[rod - 1] -= moment
    expected = []
    for joint in range(8):
        axis = kinematics.joint_poses(model, state)[0, joint, :3, joint % 2]
        expected.append(-axis @ moments[joint // 2 :].sum(0))
    each = effect.of_joints(lengths)
    np.testing.assert_allclose(
        effect.torques(0.0, state[0], 0 * state[0], each=each), expected, rtol=0, atol=1e-12 * EI * 20
    )


def test_the_angle_is_that_of_fifty_digits() -> None:
    """asin(x)/x from straight to folded back, to rounding."""
    mpmath = pytest.importorskip("mpmath")
    x = np.concatenate([np.logspace(-12, -1, 23), np.linspace(0.1, 1, 400)])
    with mpmath.workdps(50):
        exact = np.array([float(mpmath.asin(mpmath.mpf(a)) / mpmath.mpf(a)) for a in x])
        cos2 = np.array([float(1 - mpmath.mpf(a) ** 2) for a in x])
    np.testing.assert_allclose(_asin_over_x(x**2, cos2, np), exact, rtol=2e-15)


def test_a_rod_that_is_folded_back_has_a_finite_moment() -> None:
    """Straight, folded exactly, and near both."""
    effect, each = fx.Bending(stiffness=EI), fx.Bending(stiffness=EI).of_joints(np.ones(2))
    for theta in (0.0, 1e-300, 1e-9, 1.0, 3.0, math.pi - 1e-5):
        torque = effect.torques(0.0, np.array([0.0, 0.0, theta, 0.0]), np.zeros(4), each=each)[2]
        assert torque == pytest.approx(-EI * theta, rel=1e-7)
    assert np.isfinite(effect.torques(0.0, np.array([0.0, 0.0, math.pi, 0.0]), np.zeros(4), each=each)).all()


@pytest.mark.parametrize("n", [8, 16, 32, pytest.param(64, marks=pytest.mark.slow)])
def test_a_cantilever_bends_as_a_beam_but_for_a_part_of_its_rods(n: int) -> None:
    """P L³ / (3 EI) (1 + 1/(2 n²)): the rods integrate the moment by the trapezoidal rule, whose error this is."""
    load = 1e-6  # N; the angle is then 1e-6, and its square is lost in 1e-11
    rest = still(
        beam(n),
        fx.Bending(stiffness=EI, clamp=(0, 0, -1)),
        fx.Push(link=f"rod_{n}", force=(load, 0, 0), point=LENGTH / n),
    )
    tip = at_rest(rest).tips[0, -1, 0]
    assert tip / (load * LENGTH**3 / (3 * EI)) == pytest.approx(1 + 1 / (2 * n**2), rel=1e-9)


@pytest.fixture(scope="module")
def errors() -> dict[int, dict[str, float]]:
    """Those of benchmarks/cables.py against Euler and Bernoulli, an elastica by SciPy, and the catenary."""
    return {n: benchmark.errors(n) for n in (6, 12)}


@pytest.mark.slow
@pytest.mark.parametrize("name", [
    "its first frequency", "its second frequency", "reach of a heavy elastica", "force H of a catenary",
])  # fmt: skip
def test_beams_and_ropes_converge_with_the_square_of_the_rods(errors: dict, name: str) -> None:
    """A cantilever's frequencies, a beam that sags by 76 % of its length, and a rope between two points."""
    each = [row[name] for row in errors.values()]
    order = np.log2(np.divide(each[:-1], each[1:]))
    assert np.all(np.abs(order - 2) < 0.1), order


def test_the_anchor_of_a_rope_carries_half_its_weight() -> None:
    """V = mu g L / 2 at both ends, but for the 5e-5 m by which the anchor gives."""
    up = math.acos(benchmark.APART / LENGTH)
    anchor = fx.Anchor(link="rod_8", point=(0, -benchmark.APART, 0), stiffness=1e5)
    start = {"theta_1": math.pi / 2 - up, "theta_5": 2 * up}  # a V
    run = at_rest(still(beam(8), fx.Gravity(), anchor, **start))
    force = anchor.stiffness * (np.array(anchor.point) - run.tips[0, -1])
    support = run.express("phi_1", frame="world")[0, :3]
    np.testing.assert_allclose([force[2], support[2]], MASS * 9.81 * LENGTH / 2, rtol=1e-4)
    np.testing.assert_allclose(force + support, [0, 0, MASS * 9.81 * LENGTH], atol=1e-8)


class Linkage(NamedTuple):
    """Three thin rods from the origin to a fixed point, by end points and constraints: no angles, no springs.

    The kinetic energy of a uniform thin rod is m (a² + a b + b²) / 6 in the velocities a and b of its ends.
    """

    lengths: tuple[float, ...]
    masses: tuple[float, ...]
    gravity: tuple[float, float, float]

    def solve(self, ends: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Accelerations (9,) m/s² of the rods' far ends (3, 3), and the force (3,) N on the last one."""
        M, load, J, curving = np.zeros((9, 9)), np.zeros(9), np.zeros((6, 9)), np.zeros(6)
        for i, mass in enumerate(self.masses):
            here, above = slice(3 * i, 3 * i + 3), slice(3 * i - 3, 3 * i)
            along = ends[i] - (ends[i - 1] if i else 0)
            moving = v[i] - (v[i - 1] if i else 0)
            M[here, here] += mass / 3 * np.eye(3)
            load[here] += mass / 2 * np.array(self.gravity)
            J[i, here], curving[i] = along, moving @ moving
            if i:
                M[above, above] += mass / 3 * np.eye(3)
                M[here, above] = M[above, here] = mass / 6 * np.eye(3)
                load[above] += mass / 2 * np.array(self.gravity)
                J[i, above] = -along
        J[3:, 6:] = np.eye(3)
        whole = np.block([[M, -J.T], [J, np.zeros((6, 6))]])
        x = np.linalg.solve(whole, np.concatenate([load, -curving]))
        return x[:9], x[12:]

    def move(self, ends: np.ndarray, duration: float) -> np.ndarray:
        """Where the far ends (3, 3) are after a time in s, from rest."""

        def rate(t: float, y: np.ndarray) -> np.ndarray:
            return np.concatenate([y[9:], self.solve(y[:9].reshape(3, 3), y[9:].reshape(3, 3))[0]])

        y = np.concatenate([ends.reshape(-1), np.zeros(9)])
        return solve_ivp(rate, (0, duration), y, "DOP853", rtol=1e-11, atol=1e-12).y[:9, -1].reshape(3, 3)


@pytest.mark.parametrize(("lengths", "thetas", "aside"), [
    ((0.4, 1.1, 0.9), (2.1, -1.9, -1.0), 0.0),  # a four-bar in its plane
    ((1.2, 0.5, 1.2), (0.2, math.pi / 2 - 0.2, math.pi / 2 - 0.2), 0.7),  # a swing between two posts, out of its plane
], ids=["four-bar", "swing"])  # fmt: skip
def test_an_anchor_grows_into_a_joint(lengths: tuple, thetas: tuple, aside: float) -> None:
    """Three rods between two points, against their own equations with constraints: the error falls as 1 / stiffness.

    The spring begins with the force of the joint, so that it does not vibrate.
    """
    masses, gravity = (0.3, 0.5, 0.4), 9.81
    down = (gravity * math.sin(aside), 0.0, -gravity * math.cos(aside))
    reference = Linkage(lengths, masses, down)
    start = {f"theta_{i + 1}": theta for i, theta in enumerate(thetas)}
    model = pp.Chain(rods=[pp.Rod(length=a, mass=m) for a, m in zip(lengths, masses, strict=True)])
    ends = pp.simulate(still(model, **start), duration=0.0, samples=1).tips[0]
    _, force = reference.solve(ends, np.zeros((3, 3)))
    exact, errors = reference.move(ends, 1.0), []
    for stiffness in (1e4, 1e5, 1e6):
        point = tuple((ends[-1] + force / stiffness).tolist())
        anchor = fx.Anchor(link="rod_3", point=point, stiffness=stiffness)
        scene = still(model, fx.Gravity(acceleration=gravity, direction=down), anchor, **start)
        errors.append(np.abs(pp.simulate(scene, tolerance=1e-10, samples=2).tips[-1] - exact).max())
    order = np.log10(np.divide(errors[:-1], errors[1:]))
    assert np.all(np.abs(order - 1) < 0.1), (order, errors)
    assert errors[-1] < 1e-4


def test_a_rope_on_a_stiff_anchor_comes_to_rest_from_afar() -> None:
    """20 rods of 5 g on 1e6 N/m, stretched by a metre at the start: each rod lies along the force at its middle."""
    n, mass, length, point, stiffness = 20, 0.005, 0.1, (0.0, 1.0, -0.3), 1e6
    model = pp.Chain(rods=[pp.Rod(length=length, mass=mass, radius=0.002, joint="hinge", copies=n)])
    scene = still(model, fx.Gravity(), fx.Anchor(link=f"rod_{n}", point=point, stiffness=stiffness), theta_1=-0.9)

    def gap(force: np.ndarray) -> np.ndarray:
        """Of the tip and where the anchor's force puts it, m, with the force (2,) N at the support along y and up."""
        sideways, up = force[0], force[1] - mass * 9.81 * (np.arange(n) + 0.5)
        size = np.hypot(sideways, up) / length
        tip = np.array([(sideways / size).sum(), -(up / size).sum()])
        at_end = np.array([sideways, n * mass * 9.81 - force[1]])
        return tip + at_end / stiffness - point[1:]

    force = root(gap, [0.3, 0.6], tol=1e-13).x
    rest = at_rest(scene)
    assert np.hypot(rest["R2_1"][0], rest["R3_1"][0]) == pytest.approx(np.hypot(*force), rel=1e-7)


def test_an_anchor_is_a_spring_and_a_damper() -> None:
    """Its force on the accelerations, through Pinocchio's Jacobian of the point: M (a - a without) = J^T F."""
    random = np.random.default_rng(5)
    q, v = random.uniform(-1, 1, (2, 8))
    point = np.array([0.3, -0.4, -1.0])
    held = fx.Anchor(link="rod_3", point=tuple(point), stiffness=20.0, damping=3.0, at=0.6)
    with_it, without = (bind(still(MIXED, fx.Gravity(), *more)).acceleration(0.0, q, v) for more in ((held,), ()))
    model = build(MIXED)
    pin = pytest.importorskip("pinocchio")
    data = pin.Data(model.pin)
    joint = model.pin.getJointId("phi_3")
    local = pin.computeJointJacobian(model.pin, data, q, joint)
    pin.forwardKinematics(model.pin, data, q)
    pose, arm = data.oMi[joint], np.array([0, 0, -0.6])
    J = pose.rotation @ (local[:3] - np.cross(arm, local[3:].T).T)
    force = 20.0 * (point - pose.translation - pose.rotation @ arm) - 3.0 * J @ v
    M = pin.crba(model.pin, data, q)
    M = np.triu(M) + np.triu(M, 1).T
    np.testing.assert_allclose(M @ (with_it - without), J.T @ force, rtol=0, atol=1e-12 * np.abs(J.T @ force).max())


@pytest.mark.parametrize("effect", [
    fx.Bending(stiffness=EI, clamp=(0.2, -0.3, -1)),
    fx.Anchor(link="rod_4", point=(0.4, 0.5, -1.0), stiffness=30.0),
    fx.Anchor(link="rod_4", point=(0.4, 0.5, -1.0), stiffness=30.0, damping=2.0),
    fx.Drag(density=1000.0, wind=(0.5, 0, 0), buoyancy=True),
], ids=lambda effect: f"{effect.kind}")  # fmt: skip
def test_work_and_energy_balance(effect: fx.Effect) -> None:
    """To 1e-9 of the energy exchanged, and by two methods."""
    random = np.random.default_rng(2)
    scene = pp.Scene(duration=1.0, model=MIXED, effects=(fx.Gravity(), effect),
                     start=pp.Start(positions=list(random.uniform(-0.5, 0.5, 8))))  # fmt: skip
    run = pp.simulate(scene, tolerance=1e-11, method="dop853", samples=9, energy_balance=True)
    energy = run.energy()
    exchanged = sum(np.abs(np.diff(run.work[kind])).sum() for kind in run.work) + np.ptp(run.kinetic)
    gained = run.kinetic + run.potential - run.kinetic[0] - run.potential[0]
    losses = sum(run.work[kind] for kind in run.work if kind == effect.kind and not _is_conservative(effect))
    assert np.abs(gained - losses).max() < 1e-9 * exchanged, energy
    other = pp.simulate(scene, tolerance=1e-10, method="radau", samples=9)
    assert np.abs(other.tips - run.tips).max() < 1e-5


def _is_conservative(effect: fx.Effect) -> bool:
    return isinstance(effect, fx.Bending) or (isinstance(effect, fx.Anchor) and not effect.damping)


def test_taylor_takes_bending_and_anchors() -> None:
    """Both are smooth: the same motion as by dop853."""
    scene = pp.Scene(
        duration=1.0,
        model=pp.Chain(rods=[pp.Rod(length=0.5, mass=0.4, radius=0.02, copies=2)]),
        effects=(fx.Gravity(), fx.Bending(stiffness=0.5), fx.Anchor(link="rod_2", point=(0.2, 0, -0.8), stiffness=9.0)),
        start=pp.Start(positions={"theta_1": 0.4, "phi_2": 0.6}),
    )
    pytest.importorskip("heyoka")
    taylor, other = (pp.simulate(scene, method=m, tolerance=1e-13, samples=5) for m in ("taylor", "dop853"))
    assert np.abs(taylor.q - other.q).max() < 1e-10


def test_what_is_not_there_costs_nothing() -> None:
    """Effects of strength 0: the same bits, the same evaluations; no name of an anchor or bending is bound."""
    start = {"theta_1": 0.4, "phi_2": 0.6}
    none = (fx.Bending(stiffness=0.0), fx.Anchor(link="rod_2", point=(0, 0, 0), stiffness=0.0))
    plain, idle = (pp.simulate(still(MIXED, fx.Gravity(), *more, **start), samples=9) for more in ((), none))
    assert all(np.array_equal(plain.arrays[name], idle.arrays[name]) for name in plain.arrays)
    assert plain.stats.evaluations == idle.stats.evaluations


def test_the_work_of_bending_grows_with_the_number_of_rods() -> None:
    """The compiled loop holds one rod, the same for 100 rods and for 1,000 (benchmarks/cables.py --cost has the times)."""
    counts = []
    for n in (100, 1000):
        dynamics = bind(still(beam(n), fx.Gravity(), fx.Bending(stiffness=EI)))
        assert records_by_rod(dynamics.model, dynamics.effects)
        counts.append(
            len(EquationsOfMotion(dynamics.engine, dynamics.effects, 0.0, by_rod=True).record().tape.operations)
        )
    assert counts[0] == counts[1]


@pytest.mark.parametrize(("effect", "rods", "method", "says"), [
    (fx.Anchor(link="rod_6", point=(0, -1.4, 0), stiffness=1e4, damping=1e5), 6, "auto",
     r"effects\[1\] \(anchor\) decays at .*/s, which radau steps over"),
    (fx.Anchor(link="rod_6", point=(0, -1.4, 0), stiffness=1e4, damping=4e3), 6, "dop853",
     r"effects\[1\] \(anchor\) decays at .* so this took \d+ steps; radau takes far fewer"),
    (fx.Anchor(link="rod_6", point=(0, -1.4, 0), stiffness=1e8), 6, "auto",
     r"effects\[1\] \(anchor\) vibrates at .* rad/s, so this took \d+ steps; a smaller stiffness takes fewer"),
    (fx.Bending(stiffness=2e4), 10, "auto",
     r"effects\[1\] \(bending\) vibrates at .* rad/s, so this took \d+ steps; fewer rods take fewer"),
    (fx.Anchor(link="rod_6", point=(0, -1.4, 0), stiffness=1e4), 6, "auto", ""),
    (fx.Bending(stiffness=3.0), 10, "auto", ""),
])  # fmt: skip
def test_a_stiffness_that_decides_over_the_method_is_said(effect: fx.Effect, rods: int, method: str, says: str) -> None:
    """In a note: where radau steps over a decay, or would; where a vibration makes the steps. Softer ones say nothing."""
    up = math.acos(0.7)
    shape = {"theta_1": math.pi / 2 - up, "theta_4": 2 * up} if rods == 6 else {"theta_1": 1.0, "theta_5": 0.3}
    run = pp.simulate(still(beam(rods), fx.Gravity(), effect, **shape), method=method, tolerance=1e-6, samples=2)
    notes = [note for note in run.stats.notes if note.startswith("effects[1]")]
    assert len(notes) == bool(says)
    assert not says or re.match(says, notes[0])


# --- payloads -------------------------------------------------------------------------------------------------------


def test_a_sphere_falls_through_water_with_the_speed_of_its_drag() -> None:
    """A light rod drags a sphere: at rest in a stream, its angle is that of drag and weight less buoyancy."""
    radius, mass, speed, water = 0.1, 30.0, 0.8, 1000.0
    rod = pp.Rod(length=2.0, mass=0.0, payload=mass, payload_radius=radius)
    scene = still(pp.Chain(rods=[rod]), fx.Gravity(), fx.Drag(density=water, wind=(speed, 0, 0), buoyancy=True))
    tip = at_rest(scene).tips[0, 0]
    drag = water * 0.47 * math.pi * radius**2 * speed**2 / 2
    weight = (mass - water * 4 / 3 * math.pi * radius**3) * 9.81
    assert tip[0] / -tip[2] == pytest.approx(drag / weight, rel=1e-10)


def test_a_sphere_has_its_own_inertia() -> None:
    """2/5 m r² about all axes, on top of a point mass."""
    point, sphere = (pp.Rod(length=1.0, mass=0.5, radius=0.02, payload=2.0, payload_radius=r) for r in (0.0, 0.3))
    more = np.subtract(sphere.properties, point.properties)
    np.testing.assert_allclose(more, [0, 0, *[2 / 5 * 2.0 * 0.3**2] * 3], atol=1e-15)


def test_copies_of_a_rod_are_rods() -> None:
    """The same model as one that is written out."""
    short, long = pp.Rod(length=0.5, mass=0.4, radius=0.02), pp.Rod(length=0.7, mass=0.3, radius=0.03)
    written = pp.Chain(rods=[short, short, short, long], copies=2)
    copied = pp.Chain(rods=[short.model_copy(update={"copies": 3}), long], copies=2)
    assert copied.count == 8
    assert [rod.length for rod in copied.all_rods] == [rod.length for rod in written.all_rods]
    q, v = np.random.default_rng(3).uniform(-1, 1, (2, 16))
    one, other = (bind(still(model, fx.Gravity())).acceleration(0.0, q, v) for model in (written, copied))
    assert np.array_equal(one, other)


def test_loads_in_a_row_are_said(tmp_path: Path) -> None:
    """A rod with a payload that is repeated has one in every copy: beads, or a slip."""
    beads = pp.Chain(rods=[pp.Rod(length=0.5, mass=0.1, payload=2.0, copies=3)])
    scene = pp.Scene(duration=0.1, model=beads, effects=[fx.Gravity()])
    with pytest.warns(pp.errors.Note, match=r"model.rods\[0\]: each of its 3 copies has the payload of 2 kg"):
        pp.simulate(scene)


# --- what is refused ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: fx.Bending(stiffness=-1.0), "stiffness: -1.0 is below 0"),
        (lambda: fx.Bending(stiffness=1.0, clamp=(0, 0, 0)), "clamp: a direction needs a length"),
        (lambda: fx.Bending(stiffness=math.inf), "stiffness"),
        (lambda: fx.Anchor(link="rod_1", point=(math.inf, 0, 0), stiffness=1.0), "point"),
        (lambda: fx.Anchor(link="rod_1", point=(0, 0, 0), stiffness=-1.0), "stiffness: -1.0 is below 0"),
        (lambda: pp.Rod(length=1.0, mass=1.0, payload=1.0, payload_radius=-0.1), "payload_radius: -0.1 is below 0"),
        (lambda: pp.Rod(length=1.0, mass=1.0, payload_radius=0.1), "there is none"),
        (lambda: pp.Rod(length=1.0, mass=1.0, copies=0), "copies: 0 is below 1"),
        (lambda: pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, copies=60_000)], copies=2), "are more than"),
        (lambda: bind(still(MIXED, fx.Anchor(link="rod_9", point=(0, 0, 0), stiffness=1.0))), "rod_9"),
        (lambda: bind(pp.Scene(duration=1.0, model=pp.UrdfModel("ur5"), effects=[fx.Bending(stiffness=1.0)])), "chain"),
        (lambda: fx.Bending(stiffness=math.nan), "stiffness: nan is not a finite number"),
        (lambda: fx.Bending(stiffness=1.0, clamp=(0, math.nan, 1)), "clamp[1]: nan"),
        (lambda: fx.Anchor(link="rod_1", point=(0, 0, 0), stiffness=1.0, damping=-1.0), "damping: -1.0 is below 0"),
        (lambda: fx.Anchor(link="rod_1", point=(0, 0, 0), stiffness=1.0, at=math.inf), "at: inf"),
        (lambda: pp.Rod(length=1.0, mass=1.0, radius=-0.1), "radius: -0.1 is below 0"),
        (lambda: pp.Rod(length=1.0, mass=1.0, copies=10**9), "copies: 1000000000 is above"),
        (lambda: fx.Rotation(csv="nowhere.csv", axis=(0, 0, 1)), "nowhere.csv"),
        (lambda: fx.Rotation(rate=(0, 0, 1), axis=(0, 0, 1)), "csv and axis go together"),
    ],
)  # fmt: skip
def test_what_no_cable_has_is_refused(make, says: str) -> None:
    """One line with the key path."""
    with pytest.raises(pp.InputError) as refused:
        make()
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)
