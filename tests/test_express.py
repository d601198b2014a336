"""A joint's wrench in other frames and at other points: `run.express` against the balances of whole parts of a model."""

import numpy as np
import pytest

import pendpin as pp
from pendpin.model import kinematics
from pendpin.model.build import build

TWO = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.1), pp.Rod(length=0.7, mass=0.5, radius=0.05)))
SCENES = {
    "two rods": pp.Scene(
        model=TWO,
        start=pp.Start(positions=(0.7, 0.4, -0.3, 0.9), velocities=(1.3, -0.8, 0.4, 2.0)),
        effects=[pp.effects.Gravity()],
        duration=0.5,
    ),
    "thin chain beyond Pinocchio": pp.Scene(
        model=pp.Chain(rods=(pp.Rod(length=0.01, mass=0.01),), copies=200),
        start=pp.Start(positions={"theta_1": 0.3, "phi_7": 0.2}),
        effects=[pp.effects.Gravity()],
        duration=0.002,
    ),
    "ur5": pp.Scene(
        model=pp.UrdfModel("ur5"),
        start=pp.Start(positions=np.linspace(-1, 1, 6).tolist(), velocities=np.linspace(1, -1, 6).tolist()),
        effects=[pp.effects.Gravity()],
        duration=0.1,
    ),
}


@pytest.fixture(scope="module", params=SCENES, name="run")
def run_of(request: pytest.FixtureRequest) -> pp.Trajectory:
    """A run of each kind of model."""
    return pp.simulate(SCENES[request.param], samples=7, tolerance=1e-10)


def size(run: pp.Trajectory) -> float:
    """The largest force and moment of any joint, by which rounding is measured."""
    return float(np.abs(run.wrench).max())


def test_the_childs_frame_is_that_of_the_wrench(run: pp.Trajectory) -> None:
    """Nothing is turned there, to rounding; the reaction is the opposite, to the bit."""
    for k in (0, len(run.joints) - 1):
        child = run.express(run.joints[k], "child")
        assert np.abs(child - run.wrench[:, k]).max() <= 8e-16 * size(run)
        assert np.array_equal(run.express(run.joints[k], "child", on="parent"), -child)


def test_frames_turn_and_lengths_stay(run: pp.Trajectory) -> None:
    """Forces and moments at the origin have the same length in every frame."""
    for joint in (run.joints[1], run.joints[-1]):
        wrenches = [run.express(joint, frame) for frame in ("world", "parent", "child")]
        for part in (slice(3), slice(3, 6)):
            lengths = [np.linalg.norm(wrench[:, part], axis=1) for wrench in wrenches]
            assert np.ptp(lengths, axis=0).max() <= 1e-14 * size(run)


def test_the_whole_weight_hangs_on_the_first_joint(run: pp.Trajectory) -> None:
    """In W the first joint's force is the sum of m (a - g) of all bodies; differences of tips give the accelerations.

    Independent of the wrenches: places are differenced twice along the motion, over 2e-5 s. Rounding of lengths of 2 m,
    over h², and the next derivative leave 3e-5 of the force; a wrong frame or sign changes all of it.
    """
    model, h = build(run.source.model), 1e-5
    g = np.array([0.0, 0.0, -9.81])

    def centres(q: np.ndarray) -> np.ndarray:
        coms = np.array([[*body.com, 1.0] for body in model.bodies])
        return np.einsum("nrij,rj->nri", kinematics.poses(model, q)[..., :3, :], coms)

    masses = np.array([body.mass for body in model.bodies])
    steps = (run.q + s * h * run.v + (s * h) ** 2 / 2 * run.a for s in (-1, 0, 1))
    before, now, after = map(centres, steps)
    force = np.einsum("r,nri->ni", masses, (before - 2 * now + after) / h**2 - g)
    assert np.abs(run.express(run.joints[0])[:, :3] - force).max() < 1e-4 * size(run)


def test_the_moment_at_another_point(run: pp.Trajectory) -> None:
    """M(P) = M(O) + (O - P) x F in every frame; at the origin of the child's frame it is the joint's own."""
    for frame in ("world", "parent", "child"):
        joint, point = run.joints[-1], np.array([0.1, -0.2, 0.3])
        zero, moved = (run.express(joint, frame, p) for p in ((0, 0, 0), point))
        assert np.array_equal(zero[:, :3], moved[:, :3])
        expected = zero[:, 3:] - np.cross(point, zero[:, :3])
        assert np.abs(moved[:, 3:] - expected).max() <= 1e-14 * max(size(run), 1.0)
    assert np.array_equal(run.express(joint, "child", (0, 0, 0)), run.express(joint, "child"))


def test_a_free_end_bears_no_moment_about_its_centre_of_mass() -> None:
    """The last thin rod carries no moment at its joint; about its centre of mass the moment is the force's arm."""
    run = pp.simulate(SCENES["thin chain beyond Pinocchio"], samples=3)
    wrench = run.express("phi_200", "child", (0, 0, -0.005))
    assert np.abs(wrench[:, 3:] - np.cross((0, 0, 0.005), wrench[:, :3])).max() < 1e-15 * max(1.0, size(run))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (("theta_9",), "theta_9"),
        (("theta_1", "wold"), "frame: 'wold' is not one of: world, parent, child; did you mean 'world'"),
        (("theta_1", "world", (1.0, 2.0)), "point: "),
        (("theta_1", "world", (1.0, 2.0, float("nan"))), "nan is not a finite number"),
        (("theta_1", "world", "here"), "point: 'here' are not numbers"),
        (("theta_1", "world", None, "both"), "on: 'both' is not one of: child, parent"),
    ],
)
def test_other_names_are_refused(call: tuple, words: str) -> None:
    """One line that names the choice."""
    run = pp.simulate(SCENES["two rods"], samples=2)
    with pytest.raises(pp.InputError) as error:
        run.express(*call)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
