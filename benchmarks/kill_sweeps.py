"""Kill -9 at random moments: a sweep's command, by turns with threads and with workers, then its workers.

python benchmarks/kill_sweeps.py [kills] [seed] [side] runs the map of EXAMPLE's flip times again and again. The command is
killed behind a random block and given again until it is done; after that it runs to its end while a worker is killed every
few seconds. Each finished store must hold the same bits as that of an unbroken sweep; no process may be left behind.
"""

import json
import os
import sys
import tempfile
import time
from pathlib import Path
from shutil import rmtree

import numpy as np
import psutil

from kill import process
from pendpin.sweeps.store import load

EXAMPLE = Path(__file__).parents[1] / "examples" / "double_pendulum.toml"
STORE, WHOLE = Path("map.zarr"), Path("whole.zarr")
SIDE = int(([*sys.argv[3:], "200"])[0])  # starts each way
AXES = [f"--vary=start.positions.theta_{i}=-3:3:{SIDE}" for i in (1, 2)]
COMMAND = [sys.executable, "-c", "from pendpin.cli import main; main()", "sweep", str(EXAMPLE), "--tolerance", "1e-9"]
SWEEP = [*COMMAND, *AXES, "--measure=flip_time", "--measure=flip_time.spread", "--out"]
WORKERS = ["--workers", "2"]
PAUSE = (2.0, 6.0)  # s between two deaths of workers
BOTH = 0.25  # of these, in which all workers die
FEWEST = 16  # blocks of a sweep
GONE = 60.0  # s, in which the workers of a killed command end


def differs() -> list[str]:
    """The variables in which the store differs from the unbroken one."""
    one, other = load(STORE), load(WHOLE)
    names = {*one.variables, *other.variables}
    return [str(name) for name in names if not np.array_equal(*(x[name].values.astype(str) for x in (one, other)))]


def workers_of(command: psutil.Process) -> list[psutil.Process]:
    """The processes of a command's cluster."""
    try:
        return [p for p in command.children() if "spawn_main" in " ".join(p.cmdline())]
    except psutil.NoSuchProcess:
        return []


def blocks() -> tuple[int, int]:
    """How many blocks of the store are done, and how many there are."""
    if not STORE.exists():
        return 0, FEWEST
    shape = json.loads((STORE / "done" / "zarr.json").read_text())["shape"]
    return len(list((STORE / "done" / "c").glob("*"))), shape[0]


def command_killed(random: np.random.Generator, kill: bool, options: list[str]) -> bool:
    """Start or resume the sweep and kill it behind a random one of the blocks that are left; whether it was killed."""
    done, count = blocks()
    behind = random.integers(done, count) if kill and done < count else count
    with process([*SWEEP, str(STORE), *options]) as command:
        while command.poll() is None and (behind == count or not STORE.exists() or blocks()[0] < behind):
            time.sleep(0.002)
        if command.poll() is None:
            time.sleep(random.uniform(0.0, 0.1))
            workers = workers_of(psutil.Process(command.pid))
            command.kill()
            assert not psutil.wait_procs(workers, GONE)[1], "workers outlive a killed command"
    assert command.returncode in (0, -9), command.returncode
    return command.returncode != 0


def workers_killed(random: np.random.Generator, kills: int) -> int:
    """Give the sweep's command until it ends well, while up to `kills` workers are killed; how many were.

    A command whose worker was killed ends with status 1, and the next one continues from its store.
    """
    count, status = 0, 1
    while status != 0:
        before = count
        with process([*SWEEP, str(STORE), *WORKERS]) as command:
            while command.poll() is None:
                time.sleep(random.uniform(*PAUSE))
                if before == count < kills and (workers := workers_of(psutil.Process(command.pid))):
                    for worker in workers if random.random() < BOTH else [random.choice(workers)]:
                        worker.kill()
                    count += 1
        status = command.returncode
        assert status == 0 or (status == 1 and count > before), status
    return count


def main() -> None:
    """Print every finished sweep, and the verdict."""
    kills, seed = int(([*sys.argv[1:], "20"])[0]), int(([*sys.argv[2:], "0"])[0])
    random, faults = np.random.default_rng(seed), list[str]()
    process([*SWEEP, str(WHOLE)]).wait()
    count = runs = 0
    while count < kills or STORE.exists():
        if command_killed(random, count < kills, WORKERS if count % 3 == 2 else []):
            count += 1
            done = (load(STORE)["why"].values != "not run").mean()
            print(f"command killed {count} times; {done:.0%} of the cases done", flush=True)
        else:
            faults, runs = faults + differs(), runs + 1
            rmtree(STORE)
    print(f"{count} kills of the command, {runs} sweeps finished; different: {faults or 'none'}", flush=True)
    count = runs = 0
    while count < kills:
        count, runs = count + workers_killed(random, kills - count), runs + 1
        faults += differs()
        rmtree(STORE)
        print(f"{count} kills of workers, {runs} sweeps finished; different: {faults or 'none'}", flush=True)
    print(f"seed {seed}; left behind: {sorted(set(os.listdir()) - {str(WHOLE)}) or 'none'}")
    sys.exit(bool(faults))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        main()
