"""Sweeps that are cut, broken off, killed, shared out or badly asked for: the same bits in the end, or one line."""

import contextlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin.cli import main
from pendpin.errors import Interrupted
from pendpin.sweeps import plan, workers
from pendpin.sweeps import sweep as sweeps
from pendpin.sweeps.cases import LOOSER, Task, run_block
from pendpin.sweeps.figure import doubtful_cells
from pendpin.sweeps.measures import MEASURES, SPREAD, STATISTICS
from pendpin.sweeps.store import Blocks, load, write_table
from sweep_scenes import KEYS, assert_same, scene, small, stop_after

pytest.importorskip("xarray")
pytest.importorskip("heyoka")


@given(
    shape=st.lists(st.integers(1, 7), min_size=1, max_size=4).map(tuple),
    wanted=st.integers(1, 2500),
)
def test_blocks_are_runs_of_cases(shape: tuple[int, ...], wanted: int) -> None:
    """They cover every case once, each a run of cases in C order that is a box of the grid."""
    blocks = Blocks(shape, wanted)
    count = int(np.prod(shape))
    places = np.arange(count).reshape(shape)
    seen = []
    for block in range(blocks.blocks):
        begin, end = blocks.span(block)
        assert end - begin <= max(wanted, 1)
        np.testing.assert_array_equal(places[blocks.region(block)].ravel(), np.arange(begin, end))
        seen += range(begin, end)
    assert sorted(seen) == list(range(count))
    assert Blocks(shape, int(np.prod(blocks.chunks))).chunks == blocks.chunks


@law(10)
@given(cut=st.integers(1, 30), seed=st.integers(0, 2**31))
def test_a_case_does_not_depend_on_its_neighbours(cut: int, seed: int) -> None:
    """Whatever else is in the vector: the same bits, beside a case that cannot go on too."""
    random = np.random.default_rng(seed)
    start = np.round(random.uniform(-3, 3, 31), 3)
    start[0] = 1e9  # doubles are coarse there, and steps many
    task = Task(scene(duration=0.5), plan.pairs({KEYS[0]: start, KEYS[1]: -start}), ("theta_1.final", "flip_time"))
    whole = run_block(task, 0, 31)
    parts = [run_block(task, 0, cut), run_block(task, cut, 31)]
    np.testing.assert_array_equal(whole.values, np.concatenate([part.values for part in parts]))


@pytest.mark.slow
@law(6)
@given(data=st.data(), setting=st.sampled_from([{"tolerance": 1e-9}, {"accuracy": 1e-3}]))
def test_the_cut_the_order_and_the_interrupts_do_not_matter(data: st.DataObject, setting: dict) -> None:
    """Any blocks, any order, any number of threads, broken off anywhere and gone on with: the same bits, `why` too."""
    count = 23
    rows = np.round(np.random.default_rng(5).uniform(-3, 3, (count, 2)), 2)
    rows[7] = 1e9  # is simulated on its own
    order = np.array([*data.draw(st.permutations(range(count - 1))), count - 1])
    size, threads = data.draw(st.integers(1, count)), data.draw(st.integers(1, 3))
    chosen = scene(duration=0.4).replace(solver=pp.Solver(samples=5, **setting))
    measures = ("theta_1.final", "flip_time", "R3_1.max")
    whole = run_block(Task(chosen, plan.pairs(dict(zip(KEYS, rows.T, strict=True))), measures), 0, count)
    vary = plan.pairs(dict(zip(KEYS, rows[order].T, strict=True)))
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setattr(sweeps, "_block_size", lambda task, workers: size)
        patch.setattr(sweeps, "cores", lambda: threads)
        store = Path(folder) / "map.zarr"
        for stop in sorted(data.draw(st.sets(st.integers(1, count), max_size=2))):
            with contextlib.suppress(Interrupted):
                pp.sweep(chosen, vary, measures, out=store, workers=1, progress=stop_after(stop))
        found = pp.sweep(chosen, vary, measures, out=store)
        np.testing.assert_array_equal(np.stack([found[name].values for name in measures], -1), whole.values[order])
        assert found.why.values.tolist() == [whole.why[i] for i in order]


def test_a_store_broken_off_goes_on_with_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After an interrupt in the middle; what is done is kept and shown."""
    monkeypatch.setattr(sweeps, "_block_size", lambda task, workers: 3)
    whole = small()
    seen = []

    def stop(done: int, count: int) -> None:
        seen.append(done)
        if done >= 9:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as stopped:
        small(tmp_path / "map.zarr", progress=stop)
    partial = load(tmp_path / "map.zarr")
    done = np.isfinite(partial.swing.values)
    assert 9 <= done.sum() < 24
    np.testing.assert_array_equal(partial.swing.values[done], whole.swing.values[done])
    assert_same(stopped.value.partial, partial)
    assert_same(small(tmp_path / "map.zarr"), whole)


class CtrlC(pp.effects.JointEffect):
    """The user stops the run that gets beyond this time."""

    kind: Literal["ctrl_c"] = "ctrl_c"
    after: float

    @property
    def smooth(self) -> bool:
        return False

    def torques(self, t: Any, q: np.ndarray, v: np.ndarray, xp: Any = np) -> np.ndarray:
        if np.max(t) > self.after:
            raise KeyboardInterrupt
        return 0.0 * q


def interrupt(run: pp.Trajectory) -> float:
    """A measure in which the user stops."""
    raise KeyboardInterrupt


@pytest.mark.parametrize(("effects", "measure"), [((CtrlC(after=0.05),), "swing"), ((), interrupt)])
def test_a_sweep_that_is_stopped_while_a_case_is_timed_says_so(effects: tuple, measure: Any, tmp_path: Path) -> None:
    """In a run or beside one: not that this run ended, but that the sweep did, and that there is no result yet."""
    store = tmp_path / "map.zarr"
    says = "stopped by the user before the first of 3 cases; nothing is kept"
    with pytest.raises(Interrupted, match=f"^{says}$") as stopped:
        pp.sweep(scene(*effects, duration=0.1), {KEYS[0]: [0.1, 0.2, 0.3]}, measure, out=store)
    assert (stopped.value.partial.why.values == "not run").all()
    assert not store.exists()


def test_a_store_shows_what_is_not_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In `why`, in the order of the measures, and not hatched as doubtful."""
    monkeypatch.setattr(sweeps, "_block_size", lambda task, workers: 4)
    with pytest.raises(Interrupted):
        pp.sweep(
            scene(duration=0.5), {KEYS[0]: np.linspace(0, 3, 12)}, ["swing", "theta_2.final", "theta_2.final.spread"],
            out=tmp_path / "a.zarr", workers=1, progress=stop_after(4),
        )  # fmt: skip
    found = load(tmp_path / "a.zarr")
    assert list(found.data_vars) == ["swing", "theta_2.final", "theta_2.final.spread", "why"]
    waiting = found.why.values == "not run"
    assert 4 <= (~waiting).sum() < 12
    np.testing.assert_array_equal(np.isnan(found.swing.values), waiting)
    assert not doubtful_cells(found, "theta_2.final")[waiting].any()
    monkeypatch.setattr(sys, "argv", ["pendpin", "map", str(tmp_path / "a.zarr"), "--json"])
    with pytest.raises(SystemExit, match=r"^0$"):
        main()
    shown = json.loads(capsys.readouterr().out)
    assert shown["not_run"] == waiting.sum()
    assert shown["measures"]["swing"]["none"] == 0  # of the cases that were run


@pytest.mark.parametrize("varied", [plan.grid, plan.pairs])
def test_a_store_and_memory_hold_the_same_dataset(varied: Callable[..., plan.Plan], tmp_path: Path) -> None:
    """The numbers that are varied too, whether they are dimensions or not; and so does the table of the cases."""
    cases = varied({KEYS[0]: [0.0, 1.0], KEYS[1]: [0.5, 0.7]})
    kept, stored = (pp.sweep(scene(duration=0.1), cases, "swing", out=out) for out in (None, tmp_path / "a.zarr"))
    assert kept.identical(stored)
    tables = [write_table(found, tmp_path / "a.csv").read_text() for found in (kept, stored)]
    assert tables[0] == tables[1]
    assert len(tables[0].splitlines()) == 1 + cases.count


def test_a_store_of_another_version_is_not_called_foreign(tmp_path: Path) -> None:
    """It may hold hours of results: they can be read, and nobody is told to delete them."""
    zarr = pytest.importorskip("zarr")
    small(tmp_path / "a.zarr")
    zarr.open_group(tmp_path / "a.zarr", mode="r+").attrs["pendpin_sweep"] = 1
    with pytest.raises(pp.InputError, match=r"another version of pendpin, in format 1 instead of \d+; xarray"):
        load(tmp_path / "a.zarr")


def test_a_full_disk_ends_in_a_line_and_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No file may grow in the middle of the sweep; later the same call ends with the same bits."""
    resource = pytest.importorskip("resource")
    monkeypatch.setattr(sweeps, "_block_size", lambda task, workers: 3)
    whole, limits = small(), resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill(done: int, count: int) -> None:
        if done >= 9:
            resource.setrlimit(resource.RLIMIT_FSIZE, (10, limits[1]))

    try:
        with pytest.raises(pp.InputError, match=r"map\.zarr: cannot be written: File too large$"):
            small(tmp_path / "map.zarr", progress=fill)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert (load(tmp_path / "map.zarr").why.values == "").sum() >= 9
    assert_same(small(tmp_path / "map.zarr"), whole)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["map.zarr"]


def test_a_store_of_another_sweep_is_refused(tmp_path: Path) -> None:
    """In one line that says what differs; nothing in it changes."""
    store = tmp_path / "map.zarr"
    first = small(store)
    with pytest.raises(pp.InputError, match="another sweep"):
        pp.sweep(scene(duration=1.0), {KEYS[0]: [0.0, 1.0]}, ["flip_time", "swing"], out=store)
    with pytest.raises(pp.InputError, match=r"another sweep: duration: 1\.0 there and 1\.5 here"):
        pp.sweep(
            scene(duration=1.5), {KEYS[0]: np.linspace(-3, 3, 6), KEYS[1]: np.linspace(-2, 2, 4)},
            ["flip_time", "swing"], out=store,
        )  # fmt: skip
    assert_same(load(store), first)
    (tmp_path / "other").mkdir()
    with pytest.raises(pp.InputError, match="not a store of a sweep"):
        small(tmp_path / "other")


def test_other_readers_open_a_store(tmp_path: Path) -> None:
    """xarray opens it without a warning and selects by a short name; the key path is an attribute."""
    import xarray

    keys = ("model.rods[0].length", "model.rods[1].length", "effects[0].acceleration")
    pp.sweep(scene(duration=0.1), {key: [2.0] for key in keys}, ["swing"], out=tmp_path / "a.zarr")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = xarray.open_zarr(str(tmp_path / "a.zarr"))
    assert found.swing.dims == ("rods_0_length", "rods_1_length", "acceleration")
    assert tuple(found[name].attrs["key"] for name in found.swing.dims) == keys
    assert np.isfinite(found.swing.sel(acceleration=2.0, rods_1_length=2.0)).all()


def test_a_damaged_store_is_mended_or_refused(tmp_path: Path) -> None:
    """Values that are gone are run again; of arrays that are gone, or hold something else, a line speaks."""
    store = tmp_path / "map.zarr"
    whole = small(store).load()
    shutil.rmtree(store / "swing" / "c")
    assert (load(store).why.values == "not run").all()
    assert_same(small(store), whole)
    shutil.copytree(store, kept := tmp_path / "kept.zarr")
    next(path for path in (store / "flip_time" / "c").rglob("*") if path.is_file()).write_bytes(b"something else")
    for gone in (None, "why", "theta_1", "zarr.json"):
        if gone:
            shutil.rmtree(store)
            shutil.copytree(kept, store)
            (store / gone).unlink() if gone == "zarr.json" else shutil.rmtree(store / gone)
        for use in (load, small):
            with pytest.raises(pp.InputError, match="delete it or name another") as caught:
                use(store)
            assert len(str(caught.value).splitlines()) == 1


def test_a_block_that_was_half_written_is_run_again(tmp_path: Path) -> None:
    """What counts is the mark that it is done."""
    import zarr

    store = tmp_path / "map.zarr"
    whole = small(store)
    group = zarr.open_group(str(store), mode="r+")
    group["done"][0] = 0
    group["swing"][0, 0] = 99.0
    assert_same(small(store), whole)


@pytest.mark.slow
def test_a_killed_command_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    """Kill -9 behind its third block and again behind its ninth (benchmarks/kill_sweeps.py kills at random)."""
    scene(tolerance=1e-9).save(tmp_path / "two.toml")
    store, axes = tmp_path / "map.zarr", {key: np.linspace(-3, 3, 60) for key in KEYS}
    vary = [f"--vary={key}=-3:3:60" for key in KEYS]
    code = "from pendpin.cli import main; raise SystemExit(main())"
    command = [sys.executable, "-c", code, "sweep", "two.toml", *vary, "--measure=flip_time", "--out", str(store)]
    for behind in (3, 9):
        with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL) as process:
            while process.poll() is None and len(list((store / "done" / "c").glob("*"))) < behind:
                time.sleep(0.001)
            process.kill()
        left = (load(store).why.values == "not run").mean()
        assert 0 < left < 1
    subprocess.run(command, cwd=tmp_path, stdout=subprocess.DEVNULL, check=True)
    assert_same(load(store), pp.sweep(tmp_path / "two.toml", axes, "flip_time"))


@pytest.mark.slow
def test_processes_give_the_same_bits(tmp_path: Path) -> None:
    """Two on this machine, and a Dask cluster of two."""
    distributed = pytest.importorskip("distributed")
    assert_same(small(workers=2), small())
    with distributed.LocalCluster(2, host="127.0.0.1", dashboard_address=None, threads_per_worker=1) as cluster:
        assert_same(small(dask=cluster.scheduler_address), small())


def ended(run: pp.Trajectory) -> float:
    """A measure that ends its process, as where memory runs out."""
    return os._exit(9) if run.q[0, 0] > 2.9 else float(run.q[-1, 0])


@pytest.mark.slow
def test_a_process_that_dies_ends_the_sweep_in_a_line(tmp_path: Path) -> None:
    """And what was done before is in the store."""
    with pytest.raises(pp.RunError, match="a worker process has ended unexpectedly"):
        pp.sweep(scene(), {KEYS[0]: np.linspace(-3, 3, 40)}, ended, out=tmp_path / "map.zarr", workers=2)
    assert (load(tmp_path / "map.zarr").why.values == "not run").any()


@pytest.mark.slow
@pytest.mark.parametrize("pause", [0.0, 2.0])
def test_a_cluster_without_workers_ends_the_sweep(pause: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """In one line, and not never: while blocks run, and when others are done whose results go with their worker."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(workers, "PATIENCE", 2.0)
    vary = dict.fromkeys(KEYS, np.linspace(-1.0, 1.0, 100))

    def end_workers(done: int, _: int) -> None:
        if done:
            time.sleep(pause)
            cluster.scale(0)

    with (
        distributed.LocalCluster(1, host="127.0.0.1", dashboard_address=None, threads_per_worker=1) as cluster,
        pytest.raises(pp.RunError, match="every worker of the cluster is lost"),
    ):
        pp.sweep(scene(), vary, dask=cluster.scheduler_address, progress=end_workers)


@pytest.mark.parametrize(
    ("options", "says", "status"),
    [
        (["--vary", f"{KEYS[0]}=0:inf:3"], "not a finite number", 2),
        (["--vary", f"{KEYS[0]}=-1e308:1e308:3"], "not a finite number", 2),
        (["--vary", f"{KEYS[0]}=1:2:0"], "FROM:TO:COUNT", 2),
        (["--vary", f"{KEYS[0]}=0:1:3", "--sample", "5"], "LOW:HIGH", 2),
        (["--vary", f"{KEYS[0]}=-1e308:1e308", "--sample", "5"], "lower and a higher", 2),
        (["--vary", f"{KEYS[0]}=0:1", "--sobol", "1073741824"], "more than", 1),
        (["--vary", f"{KEYS[0]}=1:0", "--sobol", "4"], "lower and a higher", 2),
        (["--vary", f"{KEYS[0]}=0,1", "--zip", "--sample", "2"], "give one of", 2),
        (["--vary", f"{KEYS[0]}=0,1", "--cases", "good.csv"], "leave one of them out", 2),
        (["--vary", f"{KEYS[0]}=0,1", "--csv", "a/b.csv"], "there is no folder", 1),
        (["--vary", f"{KEYS[0]}=0,1", "--plot", "map.bmp"], "png", 1),
        (["--vary", f"{KEYS[0]}=0,1", "--workers", "1000"], "workers: 1000 is not a whole number from 1 to", 1),
        (["--vary", f"{KEYS[0]}=0,1", "--dask", "x", "--workers", "2"], "give one of both", 1),
        (["--vary", f"{KEYS[0]}=0:1:1000000000"], "with a count from 1 to 100000000", 2),
        (["--vary", f"{KEYS[0]}=0,1", "--measure", "theta_1.maximum"], "did you mean 'max'?", 1),
        (["--vary", f"{KEYS[0]}=0,1", "--out", "a/map.zarr"], "there is no folder 'a'", 1),
        (["--vary", f"{KEYS[0]}=0,1", "--out", "m.png", "--plot", "m.png"], "every file needs its own", 1),
        (["--cases", "good.csv", "--csv", "good.csv"], "every file needs its own", 1),
        (["--cases", "head.csv"], "no cases", 1),
        (["--cases", "word.csv"], "line 3: start.positions.theta_1: 'abc' is not a number", 1),
        (["--cases", "quote.csv"], "not a CSV file", 1),
    ],
)
def test_hostile_options(
    options: list[str],
    says: str,
    status: int,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One line, before anything is run; what an option cannot mean is wrong usage."""
    from bad_input import run_main

    monkeypatch.chdir(tmp_path)
    scene().save("two.toml")
    for name, rows in (("good", "1"), ("head", ""), ("word", "\nabc"), ("quote", '"1')):
        Path(f"{name}.csv").write_text(f"{KEYS[0]}\n{rows}\n")
    assert run_main("sweep", "two.toml", *options) == status
    line = capsys.readouterr().err.strip()
    assert says in line
    assert len(line.splitlines()) == 1


def test_the_measures_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    """Each by its name with what it is, without a scene; as JSON too."""
    from bad_input import run_main

    assert run_main("sweep", "--list") == 0
    lines = capsys.readouterr().out
    assert all(name in lines for name in (*MEASURES, *STATISTICS, SPREAD))
    assert run_main("sweep", "--list", "--json") == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["measure"] for row in rows] == list(MEASURES)
    assert all(row["what"].endswith(".") for row in rows)


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Table, CSV, figure; the same again goes on with the store."""
    from bad_input import run_main

    monkeypatch.chdir(tmp_path)
    scene(duration=1.0).save("two.toml")
    command = ["sweep", "two.toml", "--vary", f"{KEYS[0]}=-3:3:3", "--vary", f"{KEYS[1]}=0,1", "--measure", "flip_time"]
    assert run_main(*command, "--out", "map.zarr", "--csv", "map.csv", "--plot", "map.png", "--json") == 0
    assert json.loads(capsys.readouterr().out)["cases"] == 6
    assert len(Path("map.csv").read_text().splitlines()) == 7
    assert run_main("map", "map.zarr", "--plot", "again.svg") == 0
    assert "flip_time (s)" in capsys.readouterr().out
    assert run_main("map", "map.zarr", "--measure", "flip_tme") == 1
    assert "did you mean 'flip_time'?" in capsys.readouterr().err
    assert run_main("sweep", "two.toml", "--vary", "model.rods[0].mass=-1,-2") == 1
    assert run_main("sweep", "two.toml", "--vary", f"{KEYS[0]}=0:1", "--sobol", "2", "--json") == 0
    assert KEYS[0] in json.loads(capsys.readouterr().out)["sobol"]["swing"]
    shutil.rmtree("map.zarr")
    assert run_main("map", "map.zarr") == 1
    assert LOOSER == 100.0


def test_a_store_of_an_older_format_is_refused_unread(tmp_path: Path) -> None:
    """Zarr 2 knows filters that run code when an array is read: such a store is refused by its JSON alone."""
    (tmp_path / ".zgroup").write_text('{"zarr_format": 2}')
    (tmp_path / ".zattrs").write_text('{"pendpin_sweep": 3, "keys": [], "measures": []}')
    with pytest.raises(pp.InputError, match="not a store of a sweep"):
        load(tmp_path)
