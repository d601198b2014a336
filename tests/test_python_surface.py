"""The Python surface, line by line as docs/python.md shows it; and that everything public shows itself briefly."""

import pydoc
from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from pendpin.analysis.hardcases import hard
from pendpin.analysis.significance import significance

TOP = Path(__file__).parents[1]
ROD = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)])
FALLING = pp.Scene(model=ROD, start={"positions": {"theta": 1.0}}, effects=[pp.effects.Gravity()], duration=0.5)


@pytest.fixture(autouse=True)
def in_examples(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the lines name their files."""
    monkeypatch.chdir(TOP / "examples")


def test_a_scene_varies_and_is_saved(tmp_path: Path) -> None:
    """By key path and by field; what is saved is read back equal; a path runs."""
    scene = pp.load_scene("crane.toml")
    faster = scene.replace({"start.velocities.theta_1": 0.5, "model.rods[0].mass": 2.0}, duration=5.0)
    assert pp.load_scene(faster.save(tmp_path / "faster.toml")) == faster
    assert len(pp.simulate("crane.toml", duration=5.0, samples=301).t) == 301
    np.testing.assert_array_equal(pp.simulate("crane.toml", times=[1.0, 1.5, 2.0]).t, [1.0, 1.5, 2.0])


def test_a_run_is_asked(tmp_path: Path) -> None:
    """Quantities by name, other times, crossings, more time, tables, pictures."""
    run = pp.simulate("crane.toml", duration=5.0, samples=301)
    assert len(repr(run).splitlines()) == 3
    assert all(run[name].shape == (301,) for name in ("theta_1", "R3_2", "tip_x", "kinetic"))
    assert run.at(2.345).q.shape == (1, 10)
    assert run.crossings("theta_1", level=-0.01).t.size
    assert run.extend(1.0).t[-1] == 6.0
    assert run.summary()["largest swing"].unit == "degrees"
    assert run.to_csv(tmp_path / "run.csv").stat().st_size > 0
    assert run.animate().save(tmp_path / "run.html").stat().st_size > 0
    assert "<table>" in run._repr_html_()


def test_particular_starts_and_robots() -> None:
    """Degrees, a cone, rest; a robot by name with a locked joint; a pin.Model; a function that controls."""
    import pinocchio as pin

    assert pp.Start(positions={"theta": 45}, unit="degrees").unit == "degrees"
    one = pp.load_scene("single_rod.toml")
    assert pp.Start.conical(one, angle=0.5).velocities
    assert pp.Start.at_rest(pp.load_scene("triple_pendulum.toml")).positions
    arm = pp.UrdfModel("ur5", lock={"elbow_joint": 0.1}, mimic="locked")
    assert len(pp.bind(pp.Scene(model=arm)).model.joints) == 5
    pin_model = pin.buildModelFromUrdf(str(pp.UrdfModel("ur5").file))
    run = pp.simulate(pp.Scene(model=pin_model, effects=[pp.effects.Gravity()], duration=0.1))
    assert run.configurations(pin_model).shape == (len(run.t), pin_model.nq)
    np.testing.assert_array_equal(pp.bind(one).model.pin.gravity.linear, [0, 0, -9.81])
    brake = pp.effects.Torque(lambda t, q, v: -2.0 * v, joints=["theta_1"])
    assert (
        pp.simulate(one.replace(effects=[*one.effects, brake]), duration=0.1, energy_balance=True).work["torque"].any()
    )


def test_reports_show_themselves_briefly() -> None:
    """Whatever they hold."""
    cost = pp.cost(FALLING, methods=["dop853"], budget=0.02)
    doctor = pp.diagnose("\\phi'' = - \\frac{3 g}{2 l} \\sin(\\phi)")
    compared = pp.diagnose(FALLING, accelerations=lambda q, v: [0.0] * 2)
    reports = [cost, *cost.curves, doctor, *doctor.findings, compared]
    reports += [significance(FALLING), hard(["thin-pole"], full=False)]
    for report in reports:
        assert 10 < len(repr(report)) < 1000


@pytest.mark.parametrize("name", pp.__all__)
def test_every_public_name_explains_itself(name: str) -> None:
    """help() begins with a sentence, and shows no wall of annotations."""
    thing = getattr(pp, name)
    shown = pydoc.plain(pydoc.render_doc(thing))
    assert thing.__doc__
    assert thing.__doc__[0].isupper()
    assert "Annotated[" not in shown
