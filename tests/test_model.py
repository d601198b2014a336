"""Scenes and URDFs become the same model, and names mean what they say."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from pendpin.ground.files import folder_of
from pendpin.model.bodies import mass_matrix
from pendpin.model.build import build

ROD = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.01),))
URDF = pp.UrdfModel(path=folder_of("urdf") / "universal_rod.urdf")
GRAVITY = (pp.effects.Gravity(),)
angle, rate = st.floats(-np.pi, np.pi), st.floats(-100, 100)


@given(st.tuples(angle, angle), st.tuples(rate, rate))
def test_rod_from_urdf_equals_rod_from_code(q: tuple, v: tuple) -> None:
    """Accelerations and wrenches of the two models: within 4 ulps of the terms that enter them."""
    urdf, code = (pp.bind(pp.Scene(model=model, effects=GRAVITY)) for model in (URDF, ROD))
    spin = 1 + np.abs(v).max() ** 2
    scale = spin * max(1.0, 1 / np.cos(q[1]) ** 2)  # theta'' grows like the inverse inertia about its axis
    difference = urdf.acceleration(0.0, q, v) - code.acceleration(0.0, q, v)
    assert np.abs(difference).max() <= 4 * np.spacing(20 * scale)
    assert np.abs(urdf.wrenches(0.0, q, v) - code.wrenches(0.0, q, v)).max() <= 4 * np.spacing(20 * spin)


def test_the_universal_joint_of_a_urdf_is_recognised() -> None:
    """Same frames, same inertia, same tip as the rod from code."""
    (from_urdf,), (from_code,) = build(URDF).rods, build(ROD).rods
    assert np.array_equal(from_urdf.frame, from_code.frame)
    assert np.array_equal(from_urdf.base, from_code.base)
    assert from_urdf.inertia == pytest.approx(from_code.inertia, rel=1e-15)
    assert np.array_equal(build(URDF).bodies[0].tip, [0, 0, -1])


def test_a_joint_that_turns_the_other_way_is_recognised_with_its_sign(tmp_path: Path) -> None:
    """theta counter-clockwise, phi clockwise, mounted turned: all routes still agree."""
    text = URDF.path.read_text().replace('<axis xyz="-1 0 0"/>', '<axis xyz="1 0 0"/>')
    text = text.replace(
        '<origin xyz="0 0 0" rpy="0 0 0"/>\n    <axis', '<origin xyz="0 0 0" rpy="0.1 0.2 0.3"/>\n    <axis', 1
    )
    (tmp_path / "turned.urdf").write_text(text)
    scene = pp.Scene(model=pp.UrdfModel(path=tmp_path / "turned.urdf"), effects=GRAVITY)
    assert build(scene.model).rods[0].sign == -1
    report = pp.crosscheck(scene, states=500)
    assert report.ok, report.fault


def test_continuous_joints_are_plain_angles(tmp_path: Path) -> None:
    """A continuous joint counts turns: the same model, the same motion."""
    text = URDF.path.read_text().replace('type="revolute"', 'type="continuous"')
    (tmp_path / "continuous.urdf").write_text(text)
    start = pp.Start(positions={"phi": 0.1}, velocities={"theta": 20.0})
    runs = [
        pp.simulate(pp.Scene(duration=2.0, model=model, start=start, effects=GRAVITY))
        for model in (URDF, pp.UrdfModel(path=tmp_path / "continuous.urdf"))
    ]
    assert np.array_equal(runs[0].q, runs[1].q)
    assert runs[1].q[-1, 0] > 4 * np.pi


def test_a_single_rod_may_be_written_with_numbers() -> None:
    """theta_1 is theta where there is one rod."""
    for names in (("theta", "phi"), ("theta_1", "phi_1")):
        start = pp.Start(positions=dict(zip(names, (0.1, 0.2), strict=True)))
        run = pp.simulate(pp.Scene(duration=0.0, model=ROD, start=start))
        assert run.q.tolist() == [[0.1, 0.2]]
        assert run.joints == ("theta", "phi")


def test_payload_is_folded_in() -> None:
    """A massless rod with a payload is a point mass; a payload adds by Steiner's rule."""
    point = pp.Rod(length=2.0, mass=0.0, payload=3.0).properties
    assert point == (3.0, 2.0, 0.0, 0.0, 0.0)
    rod = pp.Rod(length=2.0, mass=1.0, payload=3.0)
    about_joint = rod.properties.I1 + rod.properties.m * rod.properties.h**2
    assert about_joint == pytest.approx(1.0 * 2.0**2 / 3 + 3.0 * 2.0**2, rel=1e-15)
    assert rod.properties.h == pytest.approx((1.0 * 1.0 + 3.0 * 2.0) / 4.0, rel=1e-15)


# --- negative inertia -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("com", "beyond"), [(-0.01, True), (0.0, False), (2.0, False), (2.01, True), (None, False)])
def test_a_centre_of_mass_beyond_the_rod_is_a_finding(com: float | None, beyond: bool) -> None:
    """The equations hold for it; a slip is said."""
    rod = pp.Rod(length=2.0, mass=1.0, com=com, inertia=(1.0, 1.0, 0.1))
    findings = build(pp.Chain(rods=[rod])).findings
    assert [text.split(" is ")[0] for text in findings] == [f"model.rods[0].com: {com} m"] * beyond


def test_a_model_counts_in_words() -> None:
    """One joint, not 1 joints."""
    hinge = pp.Rod(length=1.0, mass=1.0, joint="hinge")
    one, two = (repr(pp.bind(pp.Scene(model=pp.Chain(rods=[hinge], copies=n))).model) for n in (1, 2))
    assert one == "Model of 1 joint, 1 body, 1 rod on its joint"
    assert two == "Model of 2 joints, 2 bodies, 2 rods on their joints"


@pytest.mark.parametrize("factor", [1e-20, 1e-9, 1.0, 1e6])
def test_a_mass_matrix_goes_with_the_masses(factor: float) -> None:
    """Of any size, also those that Pinocchio by itself would lose."""
    scenes = [pp.Scene(model=pp.Chain(rods=[pp.Rod(length=1.0, mass=m, radius=0.1)], copies=2)) for m in (1.0, factor)]
    usual, other = (mass_matrix(build(scene.model).pin, np.array([0.3, -0.4, 0.7, 1.1])) for scene in scenes)
    np.testing.assert_allclose(other, factor * usual, rtol=1e-13, atol=1e-15 * factor)


@given(st.lists(st.tuples(st.booleans(), st.sampled_from([-1.0, 0.3, 1.0]), st.booleans()), min_size=1, max_size=4))
def test_a_thin_rod_at_its_pole_is_the_first_one(rods: list[tuple[bool, float, bool]]) -> None:
    """Whose axis goes along that of theta, to either side; neither a rod with a radius nor a hinge."""
    kinds = [{"radius": 0.0 if thin else 0.1, "joint": "hinge" if hinge else "universal"} for thin, _, hinge in rods]
    model = build(pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, **kind) for kind in kinds]))
    q = np.zeros(len(model.joints))
    for rod, (_, turn, hinge) in zip(model.rods, rods, strict=True):
        q[rod.first if hinge else rod.phi] = turn * (np.pi / 2 - 1e-5)
    at_pole = [thin and abs(turn) == 1 and not hinge for thin, turn, hinge in rods]
    expected = next((rod.link for rod, there in zip(model.rods, at_pole, strict=True) if there), None)
    assert model.thin_at_pole(q, 1e-4) == expected
    assert model.thin_at_pole(q, 1e-6) is None
