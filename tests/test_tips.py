"""Where the bodies of a URDF end, and how motions are compared where they end nowhere."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.graphics.run_drawing import drawing_of
from pendpin.ground.arrays import EPS
from pendpin.model import kinematics
from pendpin.model.build import build
from pendpin.model.notes import notes
from pendpin.motions.summary import TILT
from pendpin.sweeps.significance import significance

INERTIA = '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.2"/>'


def robot(folder: Path, *parts: str) -> pp.UrdfModel:
    """A URDF with a link `base` and these parts, as a model."""
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="r"><link name="base"/>{"".join(parts)}</robot>')
    return pp.UrdfModel(path=path)


def link(name: str, z: float = 0.0, mass: float = 1.0, shapes: str = "") -> str:
    """A link with its centre of mass at z."""
    return f'<link name="{name}"><inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/>{INERTIA}</inertial>{shapes}</link>'


def joint(
    name: str, parent: str, child: str, at: Any = (0, 0, 0), kind: str = "continuous", axis: str = "1 0 0"
) -> str:
    """A joint."""
    place = " ".join(map(str, at))
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{place}"/>'
    limit = '<limit lower="-9" upper="9" effort="9" velocity="9"/>' if kind == "prismatic" else ""
    return f'<joint name="{name}" type="{kind}">{ends}<axis xyz="{axis}"/>{limit}</joint>'


def drawn(shape: str, z: float, turned: str = "0 0 0") -> str:
    """A visual with its centre at z."""
    return f'<visual><origin xyz="0 0 {z}" rpy="{turned}"/><geometry>{shape}</geometry></visual>'


CYLINDER = drawn('<cylinder radius="0.02" length="1"/>', -0.5)


def tips(model: pp.UrdfModel) -> list[list[float]]:
    """The tips of its bodies."""
    return [np.round(body.tip, 12).tolist() for body in build(model).bodies]


@law(25)
@given(st.lists(st.tuples(*[st.floats(-5, 5, allow_subnormal=False)] * 3), max_size=4), st.booleans())
def test_frames_and_what_hangs_on_a_drawn_rod_do_not_move_its_tip(places: Any, hanging: bool) -> None:
    """Any number of fixed frames anywhere, and a second pendulum half way: the rod ends where it is drawn."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        parts = [link("rod", -0.5, shapes=CYLINDER), joint("a", "base", "rod")]
        for i, place in enumerate(places):
            parts += [f'<link name="mark{i}"/>', joint(f"fix{i}", "rod", f"mark{i}", place, "fixed")]
        if hanging:
            parts += [link("bob", -0.2), joint("b", "rod", "bob", (0, 0, -0.4))]
        assert tips(robot(Path(folder), *parts))[0] == [0, 0, -1]


@pytest.mark.parametrize(
    ("shapes", "tip"),
    [
        (CYLINDER, -1.0),
        (drawn('<box size="0.1 0.05 0.8"/>', -0.4), -0.8),
        (drawn('<box size="0.8 0.05 0.1"/>', -0.4, "0 1.5707963267948966 0"), -0.8),
        (drawn('<capsule radius="0.1" length="0.8"/>', -0.5), -1.0),
        (CYLINDER + drawn('<sphere radius="0.3"/>', -2.0), -1.0),
        (drawn('<cylinder radius="0.3" length="0.05"/>', 0.0), -0.6),  # a disk is no rod
        ("", -0.6),
    ],
)
def test_the_longest_shape_decides(tmp_path: Path, shapes: str, tip: float) -> None:
    """Cylinders, capsules and boxes that are longer than wide; else twice the way to the centre of mass."""
    assert tips(robot(tmp_path, link("rod", -0.3, shapes=shapes), joint("a", "base", "rod")))[0] == [0, 0, tip]


def test_what_is_fixed_to_a_link_is_drawn_with_it(tmp_path: Path) -> None:
    """A hub that turns, with the rod as a link of its own welded to it."""
    parts = [link("hub"), joint("a", "base", "hub"), link("rod", -0.5, shapes=CYLINDER)]
    assert tips(robot(tmp_path, *parts, joint("weld", "hub", "rod", (0, 0.1, 0), "fixed"))) == [[0, 0.1, -1]]


def test_a_link_that_is_not_drawn_ends_at_its_farthest_joint(tmp_path: Path) -> None:
    """As the links of an arm do whose drawings are meshes; the user's choice comes before all."""
    parts = [
        link("upper", -0.1),
        joint("a", "base", "upper"),
        link("lower", -0.2),
        joint("b", "upper", "lower", (0, 0, -0.7)),
    ]
    model = robot(tmp_path, *parts)
    assert tips(model) == [[0, 0, -0.7], [0, 0, -0.4]]
    chosen = pp.UrdfModel(path=model.path, tips={"upper": (0.0, 0.0, -0.65)})
    assert tips(chosen) == [[0, 0, -0.65], [0, 0, -0.4]]
    with pytest.raises(pp.InputError, match=r"model\.tips: link 'uper' is not one of: upper, lower"):
        build(pp.UrdfModel(path=model.path, tips={"uper": (0.0, 0.0, 1.0)}))


@pytest.fixture
def flywheel(tmp_path: Path) -> pp.UrdfModel:
    """A wheel on its axis: its tip and centre of mass do not move."""
    return robot(tmp_path, link("wheel", mass=2.0), joint("spin", "base", "wheel", axis="0 0 1"))


def test_a_flywheel_is_compared_by_its_angle(flywheel: pp.UrdfModel) -> None:
    """Effects, work and precision, and a target accuracy: numbers where there were NaN."""
    brake = fx.Viscous(coefficient=0.1)
    start = pp.Start(velocities={"spin": 3.0})
    scene = pp.Scene(duration=1.0, model=flywheel, start=start, effects=(brake,), solver=pp.Solver(samples=11))
    found = significance(scene)
    (row,) = [row for row in found.rows if row.effect == "viscous"]
    run = pp.simulate(scene, tolerance=1e-10)
    assert row.change == pytest.approx(2 * np.sin((3.0 - run.q[-1, 0]) / 2), rel=1e-6)
    assert row.verdict == "needed"
    report = pp.cost(scene, methods=["dop853", "rk4"], budget=0.05, repetitions=0)
    assert 0 < report.error < 1e-9
    assert all(np.isfinite(point.error) for curve in report.curves for point in curve.points)
    asked = pp.simulate(scene, accuracy=1e-8)
    assert asked.q[-1, 0] == pytest.approx(6.0 * (1 - np.exp(-0.5)), abs=1e-8)  # the wheel's inertia is 0.2


def test_drag_has_no_hold_on_a_body_without_length(flywheel: pp.UrdfModel) -> None:
    """It turns on, exactly; a push at a point of it is refused in one line."""
    start = pp.Start(velocities={"spin": 3.0})
    drag = fx.Drag(diameter=0.1, linear=0.2, wind=(1.0, 2.0, 0.0), buoyancy=True)
    scene = pp.Scene(duration=1.0, model=flywheel, start=start, effects=(fx.Gravity(), drag))
    assert pp.simulate(scene).q[-1, 0] == pytest.approx(3.0, rel=1e-12)
    pushed = scene.model_copy(update={"effects": (fx.Push(link="wheel", force=(1, 0, 0), point=0.9),)})
    with pytest.raises(pp.InputError, match=r"effects\[0\]\.point: link 'wheel' has no tip to measure it along"):
        pp.simulate(pushed)


def test_the_cross_of_a_joint_may_have_mass_in_the_wind(tmp_path: Path) -> None:
    """Its rod feels the drag, the cross none."""
    parts = [link("cross", mass=0.1), joint("theta", "base", "cross"), link("rod", -0.5, shapes=CYLINDER)]
    model = robot(tmp_path, *parts, joint("phi", "cross", "rod", axis="0 1 0"))
    scene = pp.Scene(duration=0.5, model=model, start=pp.Start(positions=(0.5, 0.3)), effects=(fx.Gravity(), fx.Drag()))
    assert np.isfinite(pp.simulate(scene).q).all()


def test_limits_that_are_not_applied_are_noted(tmp_path: Path) -> None:
    """As damping is, once for all joints; not where they are beyond all motion."""
    limits = '<limit lower="{0}" upper="{1}" effort="{1}" velocity="{1}"/></joint>'
    parts = [link("one", -0.5), link("two", -0.5)]
    close = joint("a", "base", "one", kind="revolute").replace("</joint>", limits.format(-1, 1))
    far = joint("b", "one", "two", kind="revolute").replace("</joint>", limits.format(-1e9, 1e9))
    scene = pp.Scene(model=robot(tmp_path, *parts, close, far), effects=(fx.Gravity(),))
    said = "<limit> of 'a': ignored; the effect as_written (--as-written, effects.AsWritten()) lets them act"
    assert notes(scene, build(scene.model)) == (said,)


def test_a_drawing_says_its_notes_and_tells_bodies_apart(tmp_path: Path) -> None:
    """What has no colour of its own has another one than the body before."""
    parts = [link("one", -0.5, shapes=CYLINDER), link("two", -0.5, shapes=CYLINDER)]
    free = joint("a", "base", "one", kind="prismatic"), joint("b", "one", "two", at=(0, 0, -1))
    drawing = drawing_of(pp.simulate(pp.Scene(duration=0.1, model=robot(tmp_path, *parts, *free))))
    assert ["<limit> of 'a': ignored" in note for note in drawing.notes] == [True]
    assert len({shape.color for shape in drawing.shapes}) == 2


# --- the largest swing ----------------------------------------------------------------------------------------------


def test_the_swing_of_a_chain_by_its_angles_vs_by_its_poses() -> None:
    """Downwards turned through the frames of 50 rods gives their directions within the rounding of its 100 rotations."""
    chain = pp.Chain(rods=[pp.Rod(length=0.02 + 0.01 * (i % 3), mass=0.1, radius=0.001) for i in range(50)])
    model, random = build(chain), np.random.default_rng(3)
    q = random.uniform(-2, 2, (20, 100))
    q[10:, 1::2] = 0.0  # in the plane of theta
    by_poses = kinematics.swings_at(replace(model, chain=None), q)
    for part in (slice(10), slice(10, 20)):
        assert np.abs(kinematics.swings_of_chain(q[part]) - by_poses[part]).max() < 100 * EPS


ROPE = "0 0 0.3"  # m, where the two hinges of the gantry are on its trolley


def gantry(folder: Path, slide: str = "1 0 0", at: Any = (0, 0, 0)) -> pp.Scene:
    """A trolley that slides along an axis, and a rope with a load on two hinges of it; it rolls and swings."""
    parts = [link("trolley", 0.1, 5.0), '<link name="cross"/>', link("rope", -2.0)]
    parts += [joint("slide", "base", "trolley", at, "prismatic", slide), joint("x", "trolley", "cross", ROPE.split())]
    parts += [joint("y", "cross", "rope", axis="0 1 0")]
    start = pp.Start(positions={"x": 0.1, "y": 0.3}, velocities={"slide": 3.0})
    return pp.Scene(model=robot(folder, *parts), start=start, duration=2.0, effects=[fx.Gravity()])


@pytest.mark.parametrize(("slide", "at"), [("1 0 0", (0, 0, 0)), ("1 0 0", (7, -3, 20)), ("0 1 0", (0, 0, -5))])
def test_a_gantry_has_the_swing_of_its_rope(tmp_path: Path, slide: str, at: Any) -> None:
    """cos(swing) = cos(x) cos(y), wherever the trolley is: in the summary, and in a sweep that integrates in vectors."""
    scene = gantry(tmp_path, slide, at)
    run = pp.simulate(scene)
    rope = np.arccos(np.cos(run["x"]) * np.cos(run["y"])).max()
    assert np.radians(run.summary()[TILT].value) == pytest.approx(rope, abs=1e-7)
    swept = pp.sweep(scene, {"start.positions.y": [0.3, 0.3]}, "swing").swing.values
    assert swept == pytest.approx([rope, rope], abs=1e-7)


def test_what_no_joint_tilts_has_no_swing(tmp_path: Path) -> None:
    """A turntable with an arm that lies flat, on a trolley."""
    parts = [link("trolley", 0.1), joint("slide", "base", "trolley", kind="prismatic"), '<link name="hand"/>']
    parts += [link("arm", 0.2), joint("turn", "trolley", "arm", axis="0 0 1"), joint("end", "arm", "hand", (1, 0, 0))]
    parts += [link("rod", -0.5), joint("hinge", "arm", "rod", (1, 0, 0))]
    model = robot(tmp_path, *parts)
    run = pp.simulate(pp.Scene(model=model, start=pp.Start(positions={"hinge": 0.2}), duration=0.5), samples=3)
    assert run.summary()[TILT].value == pytest.approx(np.degrees(0.2))
    still = robot(tmp_path, *parts[:2])
    assert TILT not in pp.simulate(pp.Scene(model=still, duration=0.5), samples=3).summary()


def test_slides_are_in_metres(tmp_path: Path) -> None:
    """In figures, and beside each joint where both kinds are drawn; not known once the URDF is gone."""
    run = pp.simulate(gantry(tmp_path), samples=5)
    position, speed, both = run.plot("slide"), run.plot("slide_rate"), run.plot()
    assert [figure.axes[0].get_ylabel() for figure in (position, speed, run.plot("x"))] == [
        "slide (m)",
        "slide_rate (m/s)",
        "x (rad)",
    ]
    panel = next(ax for ax in both.axes if ax.get_ylabel() == "position (rad or m)")
    assert [text.get_text() for text in panel.get_legend().get_texts()] == ["slide (m)", "x (rad)", "y (rad)"]
    loaded = pp.Trajectory.load(run.save(tmp_path / "run.npz"))
    (tmp_path / "robot.urdf").unlink()
    assert loaded.plot("slide").axes[0].get_ylabel() == "slide (rad or m)"
    assert TILT not in loaded.summary()
