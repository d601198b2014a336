"""Kill -9 at random moments: a run with a checkpoint is killed and continued; its result is compared.

Every process is given a random moment between its start-up and the time that the whole run takes, and is killed there by
the system unless it is done; the same command then continues the run. At the end of a run its arrays and counts are
compared, and the next run begins. python benchmarks/kill.py [kills] [seed]
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from pendpin import Trajectory

SCENE = """duration = 300.0
[model]
kind = "chain"
rods = [{ length = 1.0, mass = 1.0, radius = 0.02 }]
copies = 3
[start]
positions = { theta_1 = 0.7, phi_1 = 0.4, theta_2 = 0.5, phi_3 = -0.3 }
[[effects]]
kind = "gravity"
[solver]
method = "dop853"
tolerance = 1e-12
samples = 6001
"""
EVERY = 0.05  # s between two saves
CLOCKS = ("seconds", "compile_seconds")  # of the statistics: what may differ
CHECKPOINT, RESULT, WHOLE = Path("run.ckpt"), Path("run.npz"), Path("whole.npz")
COMMAND = [sys.executable, "-c", "from pendpin.cli import main; main()", "run", "scene.toml"]
RESUMABLE = [*COMMAND, "--checkpoint", str(CHECKPOINT), "--every", str(EVERY)]


def process(command: list[str]) -> subprocess.Popen:
    """A command, with nothing shown."""
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def contents(path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """All arrays of a saved run, and its meta without the clock."""
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    meta = json.loads(str(arrays.pop("meta")))
    return arrays, {name: value for name, value in meta.items() if name not in CLOCKS}


def differing(one: Path, other: Path) -> list[str]:
    """The arrays and counts in which two saved runs differ."""
    pairs = zip(contents(one), contents(other), strict=True)
    names = [[name for name in a | b if not np.array_equal(a.get(name), b.get(name))] for a, b in pairs]
    return names[0] + names[1]


def unbroken() -> tuple[float, float]:
    """Seconds from the start of a process to its first save, and of the whole run."""
    begin = time.perf_counter()
    with process(RESUMABLE) as run:
        while not CHECKPOINT.exists() and run.poll() is None:
            time.sleep(0.001)
        ready = time.perf_counter() - begin
    assert run.returncode == 0
    took = time.perf_counter() - begin
    with process([*COMMAND, "--out", str(WHOLE)]) as run:
        pass
    assert run.returncode == 0
    assert not differing(RESULT, WHOLE)  # saving changes nothing
    return ready, took


def killed(after: float | None) -> bool:
    """Start or resume the run, and kill it so many seconds later, if at all, unless it is done."""
    with process(RESUMABLE) as run:
        try:
            run.wait(after)
        except subprocess.TimeoutExpired:
            run.kill()
    assert run.returncode in (0, -9), run.returncode
    return run.returncode != 0


def state() -> tuple[str, str]:
    """What a killed process left: how far the checkpoint is, and whether there is a result."""
    if RESULT.exists():
        Trajectory.load(RESULT)  # whole, or it raises
    result = "whole" if RESULT.exists() else ""
    if not CHECKPOINT.exists():
        return "not yet", result
    with np.load(CHECKPOINT) as file:
        return f"{len(file['samples'])} samples, {int(file['counts'][1])} evaluations", result


def main() -> None:
    """Print every kill, and the verdict."""
    kills, seed = int(([*sys.argv[1:], "50"])[0]), int(([*sys.argv[2:], "0"])[0])
    random, table = np.random.default_rng(seed), Table("kill", "s after start", "run", "checkpoint", "result")
    ready, took = unbroken()
    RESULT.unlink()
    count, runs, unfinished, faults = 0, 0, False, []
    while count < kills or unfinished:
        after = random.uniform(ready, took) if count < kills else None
        was_killed, unfinished = killed(after), CHECKPOINT.exists() or not RESULT.exists()
        if unfinished:
            assert was_killed
            count += 1
            table.add_row(str(count), f"{after:.2f}", str(runs + 1), *state())
        else:
            runs += 1
            faults += [(runs, name) for name in differing(RESULT, WHOLE)]
            RESULT.unlink()
    left = sorted(set(os.listdir()) - {"scene.toml", str(WHOLE)})
    console = Console()
    console.print(table)
    console.print(f"first save {ready:.2f} s after the start, {took:.2f} s for the whole run; seed {seed}")
    console.print(
        f"{count} kills, {count} resumes, {runs} runs completed; different from the unbroken run: {faults or 'none'}"
    )
    console.print(
        f"compared: {', '.join(contents(WHOLE)[0])} and every count; unfinished neighbours left behind: {len(left)}"
    )
    sys.exit(bool(faults))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        Path("scene.toml").write_text(SCENE)
        main()
