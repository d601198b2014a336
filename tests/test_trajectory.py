"""What is saved is what was computed, whole or not at all."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from pendpin.ground.files import write_whole
from pendpin.scene import builtin_scene


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
    rods = run.rod_reactions
    assert rods is not None
    array = (rods.R3 if name == "R3" else getattr(run, name)).copy()
    array.reshape(len(run.t), -1)[7:9, -1] = value
    bad = {"rod_reactions": rods._replace(R3=array)} if name == "R3" else {name: array}
    assert replace(run, **bad).sound == 7
