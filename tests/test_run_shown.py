"""What is shown of a run: representations, figures, animations."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from pendpin import effects as fx
from pendpin.errors import Note
from pendpin.graphics import run_drawing
from pendpin.graphics.drawing import labels_of
from pendpin.graphics.run_drawing import drawing_of
from pendpin.scene import builtin_scene
from test_run_surface import EXAMPLES, SCENES


def test_representations_are_short() -> None:
    """Of a run, however long its chain, under 1,000 characters."""
    for run in (
        pp.simulate(builtin_scene(), duration=0.1),
        pp.simulate(EXAMPLES / "thousand_rods.toml", duration=0.02),
    ):
        assert len(repr(run)) < 1000
        assert len(repr(run.summary())) < 1000
        assert len(repr(run.animate())) < 1000
        assert repr(run).count("\n") == 2


def test_a_run_without_swings_is_shown(tmp_path: Path) -> None:
    """Its URDF is gone, or nothing in it swings: the text and the notebook's page leave the largest swing out."""
    tower = (
        '<robot name="r"><link name="base"/><link name="load"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="{0}" type="continuous">'
        '<parent link="base"/><child link="load"/><axis xyz="{1}"/></joint></robot>'
    )
    for name, axis in (("turntable", "0 0 1"), ("swing", "1 0 0")):
        path = tmp_path / f"{name}.urdf"
        path.write_text(tower.format(name, axis))
        scene = pp.Scene(model=pp.UrdfModel(path), effects=[pp.effects.Gravity()], duration=0.1)
        run = pp.Trajectory.load(pp.simulate(scene, samples=3).save(tmp_path / "run.npz"))
        path.unlink()
        assert repr(run).startswith(f"Trajectory of {name}.urdf")
        assert not {"largest swing", "largest tilt"} & set(run.summary())


def test_plot_on_own_axes() -> None:
    """Two quantities on the axes given; the figure of the run without names."""
    from matplotlib.figure import Figure

    run, axes = pp.simulate(SCENES["smooth"], samples=31), Figure().subplots()
    assert run.plot("theta_1", "R3_1", ax=axes) is axes
    assert [line.get_label() for line in axes.get_lines()] == ["theta_1", "R3_1"]
    np.testing.assert_array_equal(axes.get_lines()[0].get_ydata(), run["theta"])
    assert len(run.plot().axes) >= 4


def test_the_figure_of_a_run() -> None:
    """Titled by the scene; drift only where energy is conserved; up to three rods; units; the path beside."""
    smooth = pp.simulate(SCENES["smooth"].replace(title="A _rod_ of $1"), samples=31).plot()
    texts, labels = [text.get_text() for text in smooth.texts], [ax.get_ylabel() for ax in smooth.axes]
    assert texts[0] == r"A _rod_ of \$1"
    assert any(label.startswith("energy drift") for label in labels)
    assert labels[-3:] == ["y (m)", "z (m)", "z (m)"]  # the same three planes for every run, so that runs compare
    assert smooth._repr_png_().startswith(b"\x89PNG")
    long = SCENES["damped"].replace({"model.copies": 4})
    figure = pp.simulate(long, samples=3, duration=0.1).plot()
    assert figure.texts[0].get_text() == "8 rods under gravity, drag"
    assert not any(ax.get_ylabel().startswith("energy drift") for ax in figure.axes)
    positions = next(ax for ax in figure.axes if ax.get_ylabel() == "position (rad)")
    shown = [line.get_label() for line in positions.get_lines()]
    assert shown == ["theta_1", "phi_1", "theta_4", "phi_4", "theta_8", "phi_8", "3 of 8 rods"]


def test_the_figure_of_chosen_quantities() -> None:
    """A panel for each unit; a name that is none is refused."""
    run = pp.simulate(SCENES["thin chain"], samples=7)
    figure = run.plot("theta_1", "R3_1", "phi_2", "kinetic")
    assert [ax.get_ylabel() for ax in figure.axes] == ["angle (rad)", "R3_1 (N)", "kinetic (J)"]
    assert [line.get_label() for line in figure.axes[0].get_lines()] == ["theta_1", "phi_2"]
    assert run.plot("energy_drift").axes[0].get_ylabel() == "energy_drift"
    with pytest.raises(pp.InputError, match="did you mean 'theta_1'"):
        run.plot("thta_1")


def test_runs_share_their_axes_in_one_figure() -> None:
    """Each panel holds both runs, the legend each name once, and the last panel the distance of the tips."""
    scene = SCENES["smooth"]
    run, other = pp.simulate(scene, samples=31), pp.simulate(scene, method="rk4", step=0.005, samples=31)
    alone, both = run.plot(), run.plot(compare=other)
    assert [ax.get_ylabel() for ax in both.axes if ax.get_ylabel() != "tips apart (m)"] == [
        ax.get_ylabel() for ax in alone.axes
    ]
    positions, single = (
        next(ax for ax in figure.axes if ax.get_ylabel() == "position (rad)") for figure in (both, alone)
    )
    assert len(positions.lines) == 2 * len(single.lines)
    assert positions.get_legend_handles_labels()[1] == single.get_legend_handles_labels()[1]
    apart = np.linalg.norm(run.tips[:, -1] - other.tips[:, -1], axis=-1)
    (line,) = next(ax for ax in both.axes if ax.get_ylabel() == "tips apart (m)").lines
    np.testing.assert_array_equal(line.get_ydata(), np.where(apart > 0, apart, np.nan))
    assert line.get_linestyle() == positions.lines[-1].get_linestyle() != single.lines[0].get_linestyle()
    assert "rk4" in both.texts[1].get_text()
    with pytest.raises(pp.InputError, match="a str is not a run"):
        run.plot(compare=["run.npz"])
    with pytest.raises(pp.InputError, match="5 runs are too many"):
        run.plot(compare=[other] * 4)


def test_the_legend_names_what_the_first_run_lacks() -> None:
    """A run at rest beside one that moves, two rods beside five: every curve has a name, each name is there once."""

    def legends(run: pp.Trajectory, compare: pp.Trajectory | None = None) -> dict[str, list[str]]:
        return {ax.get_ylabel(): ax.get_legend_handles_labels()[1] for ax in run.plot(compare=compare).axes}

    hinge = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, joint="hinge")])
    moves = pp.Scene(duration=0.1, model=hinge, effects=[fx.Gravity()], start=pp.Start(positions=[0.5]))
    resting, moving = pp.simulate(moves.replace(start=pp.Start())), pp.simulate(moves)
    assert legends(resting)["energy (J)"] == ["kinetic"]
    assert legends(resting, moving)["energy (J)"] == legends(moving)["energy (J)"]
    rod = pp.Rod(length=1.0, mass=1.0, radius=0.05)
    two, five = (pp.simulate(moves.replace(model=pp.Chain(rods=[rod], copies=n), start=pp.Start())) for n in (2, 5))
    tensions = legends(two, five)["tension R3 (N)"]
    assert tensions == ["rod 1", "rod 2", "rod 3", "rod 5", "3 of 5 rods"]


def test_energy_drift_is_drawn_by_name() -> None:
    """It is what the drift of a run is the largest of; where energy is not conserved there is none."""
    run = pp.simulate(SCENES["smooth"], samples=31)
    assert np.abs(run["energy_drift"]).max() == run.energy().drift
    (line,) = run.plot("energy_drift").axes[0].lines
    np.testing.assert_array_equal(line.get_ydata(), run["energy_drift"])
    with pytest.raises(pp.InputError, match="an effect of this run has no potential"):
        pp.simulate(SCENES["damped"], samples=3, duration=0.1).plot("energy_drift")


def test_animations(tmp_path: Path) -> None:
    """As a page and as a GIF; other names are refused."""
    run = pp.simulate(SCENES["smooth"], samples=5, duration=0.1)
    film = run.animate()
    assert film.save(tmp_path / "a.html").read_bytes().startswith(b"<!DOCTYPE html>")
    assert film.save(tmp_path / "a.gif").read_bytes().startswith(b"GIF89a")
    assert "<iframe" in film._repr_html_()
    assert "largest swing" in run._repr_html_()
    with pytest.raises(pp.InputError, match="ends in one of"):
        film.save(tmp_path / "a.mov")


def test_representations_of_all_else_are_short() -> None:
    """Of scenes, models, dynamics, cross-checks, ensembles and what runs hold."""
    big = pp.load_scene(EXAMPLES / "thousand_rods.toml")
    long = pp.Scene(model={"kind": "chain", "rods": [{"length": 1.0, "mass": 1.0}] * 300})
    listed = long.replace({"start.positions": {f"theta_{i}": 0.1 for i in range(1, 301)}})
    run = pp.simulate(SCENES["smooth"], samples=31)
    things = [
        big,
        big.model,
        big.start,
        long,
        long.model,
        listed,
        listed.start,
        run,
        run.stats,
        run.energy(),
        run.reactions(),
    ]
    things += [pp.bind(big), pp.bind(SCENES["smooth"]).model, pp.crosscheck(SCENES["smooth"], states=20)]
    things += [pp.simulate_many(SCENES["smooth"], [[0.1, 0.2]] * 3, [[0.0, 0.0]] * 3, workers=1)]
    for thing in things:
        assert len(repr(thing)) < 1000
        assert len(str(thing)) < 1000


def test_a_figure_says_that_rods_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of five rods it draws three; a page says that it does not offer every quantity."""
    chain = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)], copies=5)
    run = pp.simulate(pp.Scene(model=chain, duration=0.1), samples=3)
    assert drawing_of(run).notes == ()
    monkeypatch.setattr(run_drawing, "MOST_QUANTITIES", 10)
    (note,) = drawing_of(run).notes
    assert note.startswith(f"10 of {len(run.names) - 1} quantities")
    figure = run.plot()
    legends = [[text.get_text() for text in ax.get_legend().get_texts()] for ax in figure.axes if ax.get_legend()]
    assert sum("3 of 5 rods" in legend for legend in legends) == 2  # positions, tensions


def test_a_summary_says_what_is_pushed_and_the_whole_note() -> None:
    """A rod that is thrown over the top slowly is pushed; a note is not cut; a payload that is a point has no drag."""
    rod = pp.Rod(length=1.0, mass=1.0, radius=0.02, payload=2.0)
    start = pp.Start(positions={"theta": 3.0}, velocities={"theta": 0.1})
    effects = (pp.effects.Gravity(), pp.effects.Drag(density=1.2))
    with pytest.warns(Note, match="payload of rod_1 is a point without drag"):
        run = pp.simulate(pp.Scene(model=pp.Chain(rods=[rod]), effects=effects, start=start, duration=1.0))
    assert "compression up to" in repr(run)
    assert "tension from -" not in repr(run)
    upright = pp.Scene(model=pp.Chain(rods=[rod]), effects=effects[:1], start=pp.Start(positions={"theta": np.pi}))
    shown = repr(pp.simulate(upright, duration=1.0))
    assert "compression from 29.43 to 29.43 N" in shown
    assert "tension" not in shown
    note = "a note of many words " * 20
    assert note in repr(replace(run, stats=replace(run.stats, notes=(note,))))


def test_labels_say_in_what_two_scenes_differ() -> None:
    """Two runs by the same method and setting: the label is the number that is another."""
    scene = builtin_scene().model_copy(update={"duration": 0.5})
    one, other = (pp.simulate(scene.replace({"start.positions.theta": x}), tolerance=1e-9) for x in (0.3, 0.4))
    labels = labels_of([one, other])
    assert labels[0].endswith("start.positions.theta 0.3")
    assert labels[1].endswith("start.positions.theta 0.4")


def test_the_times_of_a_late_run_are_told_apart() -> None:
    """Those of its summary are those of the run from 0 on, later by its start, to the microsecond that is printed."""
    from_0, late = (pp.simulate(SCENES["smooth"].replace({"start.time": t}), duration=2.0) for t in (0.0, 1e9))
    for name, figure in from_0.summary().items():
        if figure.time is not None:
            printed = re.search(r" at ([\d.]+) s", str(late.summary()[name]))
            assert printed, name
            assert float(printed[1]) - 1e9 == pytest.approx(figure.time, abs=2e-6)
    assert "1000000000 to 1000000002 s" in repr(late)
