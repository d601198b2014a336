"""What is saved is what was computed, whole or not at all."""

import pickle
from copy import copy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from pendpin.ground.files import write_whole
from pendpin.scene import builtin_scene
from pendpin.trajectory import RunRecord


@pytest.fixture(scope="module")
def run() -> pp.Trajectory:
    """One second of the built-in rod."""
    return pp.simulate(builtin_scene().model_copy(update={"duration": 1.0}))


def test_a_saved_run_comes_back_bit_for_bit(run: pp.Trajectory, tmp_path: Path) -> None:
    """Every array, the statistics and the scene."""
    again = pp.Trajectory.load(run.save(tmp_path / "run.npz"))
    for name in ("t", "q", "v", "a", "wrench", "kinetic", "potential"):
        assert (getattr(again, name) == getattr(run, name)).all()
    assert all((x == y).all() for x, y in zip(again.reactions(), run.reactions(), strict=True))
    assert (again.tips == run.tips).all()
    assert (again.stats, again.joints, again.scene) == (run.stats, run.joints, run.scene)


def test_runs_are_equal_in_scene_and_numbers(run: pp.Trajectory) -> None:
    """One bit of one number makes another run, and so does another scene with the same numbers."""
    assert run == replace(run, q=run.q.copy())
    assert run != replace(run, q=np.nextafter(run.q, 9))
    assert run != replace(run, scene=run.scene | {"duration": 2.0})
    assert run != 1


def test_the_file_holds_the_named_arrays(run: pp.Trajectory, tmp_path: Path) -> None:
    """The names and shapes that other programs read, without pickle."""
    with np.load(run.save(tmp_path / "run.npz"), allow_pickle=False) as file:
        shapes = {name: file[name].shape for name in file.files}
    n = len(run.t)
    assert shapes["q"] == shapes["v"] == shapes["a"] == (n, 2)
    assert all(shapes[name] == (n, 1) for name in ("R1", "R2", "R3", "M3", "Mc"))
    assert shapes["wrench"] == (n, 2, 6)
    assert shapes["joints"] == (2,)
    assert shapes["meta"] == ()


def test_a_write_that_fails_leaves_the_old_file(tmp_path: Path) -> None:
    """A file is replaced when the new one is complete, never before."""
    path = tmp_path / "file"
    path.write_bytes(b"old")

    def fail(file) -> None:
        file.write(b"half")
        raise OSError(28, "No space left on device")

    with pytest.raises(pp.InputError, match="No space left"):
        write_whole(path, fail)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_reactions_hang_together(run: pp.Trajectory) -> None:
    """The wrench of the joint phi, turned into B, is R1, R2, -R3 and Mc a3."""
    found, phi = run.reactions(), run.q[:, 1]
    force = run.wrench[:, 1, :3] * [1, -1, -1]
    assert np.array_equal(force, np.stack([found.R1[:, 0], found.R2[:, 0], -found.R3[:, 0]], -1))
    assert np.array_equal(found.M3[:, 0], found.Mc[:, 0] * np.cos(phi))
    moment = run.wrench[:, 1, 3:] * [1, -1, -1]
    a3 = np.stack([-np.sin(phi), 0 * phi, np.cos(phi)], -1)
    assert np.abs(moment - found.Mc * a3).max() < 5e-15  # the terms that cancel in it are of 5 N m


@pytest.mark.parametrize("name", ["t", "q", "v", "a", "wrench", "kinetic", "potential", "tips", "R3"])
@pytest.mark.parametrize("value", [np.nan, -np.inf, 1e300])
def test_a_run_is_sound_up_to_its_first_bad_number(run: pp.Trajectory, name: str, value: float) -> None:
    """Whichever array has it; a run without one is sound to its end."""
    assert run.sound == len(run.t)
    array = run.arrays[name].copy()
    array.reshape(len(run.t), -1)[7:9, -1] = value
    assert run.with_arrays(run.arrays | {name: array}).sound == 7


def test_whatever_a_user_gets_can_be_asked(run: pp.Trajectory, tmp_path: Path) -> None:
    """A run, a piece of it, a longer one, one from a file and one that ended early are all public ones."""
    with pytest.raises(pp.RunError) as error:
        pp.simulate(builtin_scene(), duration=1e6, samples=1001, limit=0.05)
    pieces = (run.at(0.3), run.crossings("theta"), run.extend(0.1), pp.Trajectory.load(run.save(tmp_path / "run.npz")))
    for one in (*pieces, error.value.partial, pickle.loads(pickle.dumps(run)), copy(run), replace(run, events=())):
        assert type(one) is pp.Trajectory

    kinds = []
    pp.sweep(builtin_scene(), {"start.positions.theta": [0.1]}, [lambda run: kinds.append(type(run)) or 1.0])
    assert set(kinds) == {pp.Trajectory}


def test_a_class_of_ones_own_stays(run: pp.Trajectory, tmp_path: Path) -> None:
    """What is asked of a run of a subclass is one of that subclass."""

    class Mine(pp.Trajectory):
        """A run with a name."""

    mine = Mine.of(run)
    assert mine == run
    pieces = (
        mine.at(0.3),
        mine.extend(0.1),
        mine.crossings("theta"),
        replace(mine, events=()),
        Mine.load(mine.save(tmp_path / "a.npz")),
    )
    assert {type(one) for one in pieces} == {Mine}


def test_reactions_are_computed_when_they_are_asked_for(run: pp.Trajectory) -> None:
    """Once, and not for other quantities; a copy in another process holds the numbers."""
    calls, whole = [], run.reactions()
    late = replace(run, derived=run.derived._replace(rod_reactions=lambda: calls.append(1) or whole))
    assert (late.wrench == run.wrench).all()
    assert late.sound == len(run.t)
    assert not calls
    assert (late["R3"] == run["R3"]).all()
    assert late == run
    assert calls == [1]
    assert pickle.loads(pickle.dumps(replace(run, derived=run.derived._replace(rod_reactions=lambda: whole)))) == run
    assert not late.reactions().R1.flags.writeable


def test_a_record_shows_and_names_its_numbers(run: pp.Trajectory) -> None:
    """The record below the public run has the same quantities and the same file."""
    record = RunRecord(**{name: getattr(run, name) for name in RunRecord.__dataclass_fields__})
    assert record == run
    assert record.names == run.names
    assert (record["R3"] == run["R3"]).all()
    assert "R3" in record
    assert "effort_gravity_theta" not in record
    assert "effort_gravity_theta" in run
    assert repr(record) in repr(run)
    assert not hasattr(record, "plot")
    with pytest.raises(pp.InputError, match="energy_balance=True"):
        replace(record, work={})["work_gravity"]
