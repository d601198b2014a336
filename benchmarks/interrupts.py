"""Ctrl-C and --limit in commands with long jobs: how long each works on after it should have ended.

    python benchmarks/interrupts.py [NAME ...] [--after 2] [--limit 1]

Every job runs twice. The first gets SIGINT, as from a terminal, once it has used `--after` s of processor time. The second
has --limit. The table shows how late each process ended. Other processes delay the end too, so the time of the wall is
divided by that over the processor time which the process got until then. LATEST is allowed. Exit status 1 where a job ends
in another way than in one line, or not at all.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.table import Table

TOP = Path(__file__).parents[1]
LATEST = 0.5  # s
HANG = 60.0  # s, after which a process is killed
START = 0.6  # s of processor time, until a command begins to count its limit: Python and its imports
COMMAND = [sys.executable, "-c", "from pendpin.cli import main; main()"]
ONE = "--set duration=1e7 --set solver.samples=2"
MANY = "--vary start.positions.theta=-3:3:400 --vary start.positions.phi=-1.4:1.4:400 --measure"
SCENES = {
    "chain.toml": ("single_rod.toml", "copies = 1000\n", "", "1e7"),
    "five.toml": ("single_rod.toml", "copies = 5\n", "", "1e4"),
    "thirty.toml": ("single_rod.toml", "copies = 30\n", "", "100.0"),
    "drag.toml": ("single_rod.toml", "", '[[effects]]\nkind = "drag"\ndensity = 1.2\n', "50.0"),
}
JOBS = {  # by name; examples by their names
    "run dop853": f"run single_rod.toml --method dop853 {ONE}",
    "run 1,000 rods": "run chain.toml --set solver.samples=2",
    "run taylor": f"run single_rod.toml --method taylor --tolerance 1e-12 {ONE}",
    "run radau": f"run single_rod.toml --method radau {ONE}",
    "run lsoda": f"run single_rod.toml --method lsoda {ONE}",
    "run gauss4": f"run single_rod.toml --method gauss4 --step 0.01 {ONE}",
    "run rk4": f"run single_rod.toml --method rk4 --step 0.02 {ONE}",
    "run Pinocchio": f"run single_rod.toml --method dop853 --set solver.engine=pinocchio {ONE}",
    "run stops": f"run stops.toml {ONE}",
    "run drag": f"run drag.toml {ONE}",
    "run accuracy": "run five.toml --accuracy 1e-8",
    "run five rods, taylor": "run five.toml --method taylor --tolerance 1e-12",
    "run a robot": f"run --urdf panda {ONE}",
    "check": "check double_pendulum.toml --states 10000000",
    "cost": "cost five.toml --thorough",
    "effects": "effects drag.toml --set duration=1e4",
    "hard": "hard",
    "doctor": "doctor equations.md",
    "sweep in vectors": f"sweep single_rod.toml {MANY} swing --out vectors.zarr",
    "sweep one by one": f"sweep drag.toml {MANY} R3.max --out single.zarr",
    "sweep in processes": f"sweep drag.toml {MANY} swing --workers 2 --out workers.zarr",
    "fit": "fit single.toml single.csv --explain-residual",
    "modes": "modes chain.toml",
    "modes of a robot": "modes --urdf panda",
    "stability": "stability kapitza.toml --set model.rods[0].mass=1e-9",
    "lyapunov": "stability five.toml --lyapunov",
    "validate": "validate",
    "reference": "reference thirty.toml --out reference",
}


class Ending(NamedTuple):
    """How a process ended."""

    late: float  # s after it should have, of the wall, but without what others took
    status: int
    said: str  # its last line on stderr
    done: bool = False  # before it was to be stopped

    @property
    def well(self) -> bool:
        """Whether at all, and in one line."""
        if self.done and self.status == 0:
            return True
        return self.status in (1, 130) and self.said.startswith("pendpin: ")

    @property
    def cells(self) -> tuple[str, str]:
        """Those of the table."""
        late = "done before" if self.done else f"{self.late:.2f}{' LATE' if self.late > LATEST else ''}"
        return late, self.said[:80] if self.well else f"WRONG: {self.said[:70]}"


def prepare(folder: Path) -> None:
    """The scenes and data of the jobs."""
    for path in [*(TOP / "examples").glob("*.*"), *(TOP / "examples" / "lab").glob("single.*")]:
        (folder / path.name).write_bytes(path.read_bytes())
    (folder / "equations.md").write_bytes((TOP / "tests" / "printed_derivation.md").read_bytes())
    for name, (base, copies, effects, duration) in SCENES.items():
        text = (TOP / "examples" / base).read_text()
        text = text.replace("duration = 10.0", f"duration = {duration}").replace("[start]", f"{copies}[start]")
        text = text.replace("[solver]", f"{effects}[solver]").replace('method = "dop853"\n', "")
        if copies:
            text = text.replace("theta =", "theta_1 =").replace("phi =", "phi_1 =")
        (folder / name).write_text(text)


def processor_time(pid: int) -> float:
    """s of a process and of its children that have ended, 0 where there is no such process."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def group_time(pid: int) -> float:
    """s of all processes of a group."""
    members = (path.name for path in Path("/proc").glob("[0-9]*"))
    same = [int(name) for name in members if in_group(int(name), pid)]
    return sum(map(processor_time, same))


def in_group(pid: int, group: int) -> bool:
    """Whether a process is in a group."""
    try:
        return os.getpgid(pid) == group
    except OSError:
        return False


def end_of(command: str, folder: Path, after: float, limit: float | None) -> Ending:
    """Run a command; interrupt it after so much processor time, unless it has a limit."""
    more = [] if limit is None else ["--limit", f"{limit:g}"]
    begin = time.monotonic()
    with (folder / "stderr").open("w+") as stderr:
        process = subprocess.Popen(
            [*COMMAND, *command.split(), *more],
            cwd=folder,
            stdout=subprocess.DEVNULL,
            stderr=stderr,
            start_new_session=True,
        )
        used = 0.0
        while process.poll() is None and used < after and time.monotonic() < begin + HANG:
            time.sleep(0.01)
            used = max(used, group_time(process.pid))
        done, stopped = process.returncode is not None, time.monotonic()
        busy = max(1.0, (stopped - begin) / max(used, 0.1))
        if limit is None and not done:
            os.killpg(process.pid, signal.SIGINT)
        try:
            process.wait(HANG)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        stderr.seek(0)
        said = ([line for line in stderr.read().splitlines() if line.strip()] or [""])[-1]
    if limit is None:
        return Ending((time.monotonic() - stopped) / busy, process.returncode, said, done)
    late = (time.monotonic() - begin - limit) / busy - START
    return Ending(max(late, 0.0), process.returncode, said, process.returncode == 0)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="of JOBS; all if left out")
    parser.add_argument("--after", type=float, default=2.0)
    parser.add_argument("--limit", type=float, default=1.0)
    options = parser.parse_args()
    # a shell starts what runs in the background with SIGINT ignored
    signal.signal(signal.SIGINT, signal.default_int_handler)
    table, endings = Table("job", "after Ctrl-C, s", "", "after --limit, s", ""), list[Ending]()
    with tempfile.TemporaryDirectory() as folder:
        prepare(Path(folder))
        for name in options.names or JOBS:
            both = [end_of(JOBS[name], Path(folder), options.after, limit) for limit in (None, options.limit)]
            table.add_row(name, *both[0].cells, *both[1].cells)
            print(name, *both, flush=True)
            endings += both
    Console(width=230).print(table)
    sys.exit(not all(ending.well for ending in endings))


if __name__ == "__main__":
    main()
