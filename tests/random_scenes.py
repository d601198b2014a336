"""A campaign of random scenes: whatever a scene holds, it runs with a correct energy balance, or ends with one line.

    python tests/random_scenes.py --count 10000 --seed 0          # prints a table; faults go to --folder
    python tests/random_scenes.py --replay 4711 --seed 0          # one of them again, with its traceback

Outcomes of a scene (energy_bound.py derives the bound):
  balanced   the run came to its end and its energy is off by no more than its tolerance or step allows
  coarse     so too, but its tolerance or step allows a tenth of the energy exchanged and more, at which pendpin itself stops
  no balance it came to its end; without an energy balance its energy cannot be checked
  refused    InputError, in one line
  stopped    RunError, in one line, with the run so far, whose energy balance has the same bound
Everything else is a fault: another exception, a warning, a message of several lines, a number that is not finite, an
energy error above the bound, more than 20 s of processor time, the end of the process.
"""

import argparse
import json
import multiprocessing
import os
import signal
import sys
import tempfile
import traceback
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from energy_bound import STATES, Balance, balance_of
from laws import HANG
from scene_generator import Case, case_of
from test_input_properties import toml

MARGIN = 3.0  # times the bound: it has local errors in the mean, at samples. Measured: 2.1 at most, in 7,092 runs
MANY = 301  # samples of a second look, where there were too few to see how fast a motion gets between them
COARSE = 0.1  # of the energy exchanged, from where a bound promises nothing
LATE = 20.0  # s of processor time, of a scene; the system counts them
A_WORKER = 250  # scenes, after which another takes over
FAULT = "FAULT"


class Outcome(NamedTuple):
    """What came of a scene."""

    kind: str
    method: str
    words: str = ""
    off: float = 0.0  # over the bound
    share: float = 0.0  # off, over the energy exchanged


def outcome(case: Case) -> Outcome:
    """Run a scene and return its outcome; nothing is raised."""
    from pendpin.errors import Note

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", Note)
        try:
            return _checked(case)
        except Exception as error:
            return Outcome(FAULT, _method(case), _place(error))


def _checked(case: Case) -> Outcome:
    from pendpin import InputError, RunError, Scene, simulate

    method = _method(case)
    try:
        scene = Scene(**case.scene)
        run, kind, words = simulate(scene, energy_balance=case.energy_balance, limit=case.limit), "balanced", ""
    except InputError as error:
        return _readable(Outcome("refused", method, str(error)))
    except RunError as error:
        run, kind, words = error.partial, "stopped", str(error)
    if run is None or run.sound < len(run.t):
        return Outcome(FAULT, method, f"numbers that are not finite; {words}")
    found = _readable(Outcome(kind, method, words))
    with np.errstate(all="ignore"):
        balance = balance_of(scene, run)
    few = len(run.t) < STATES and scene.solver.samples != MANY
    if few and balance is not None and not balance.off <= MARGIN * balance.bound:
        return _checked(case._replace(scene=case.scene | {"solver": case.scene["solver"] | {"samples": MANY}}))
    return found if found.kind == FAULT else _balanced(found, balance)


def _balanced(found: Outcome, balance: Balance | None) -> Outcome:
    """The outcome of a run with this energy balance."""
    if balance is None:
        return found if found.kind == "stopped" else found._replace(kind="no balance")
    off, share = (balance.off / max(x, 1e-300) for x in (balance.bound, balance.moved))
    found = found._replace(off=off, share=share)
    if not off <= MARGIN:
        return found._replace(
            kind=FAULT, words=f"energy balance off by {off:.2g} of the bound, {share:.2g} of what is exchanged"
        )
    if found.kind == "balanced" and balance.bound > COARSE * balance.moved > 1e-300:  # less is rest
        return found._replace(kind="coarse")
    return found


def _readable(found: Outcome) -> Outcome:
    if (found.words.isprintable() and 10 < len(found.words) < 1200) or not found.words:
        return found
    return found._replace(kind=FAULT, words=f"an unreadable message: {found.words!r:.300}")


def _method(case: Case) -> str:
    return str(case.scene["solver"]["method"])


def _place(error: Exception) -> str:
    lines = [frame for frame in traceback.extract_tb(error.__traceback__) if "pendpin" in frame.filename]
    place = f"{Path(lines[-1].filename).name}:{lines[-1].lineno}" if lines else "nowhere in pendpin"
    return f"{type(error).__name__} in {place}: {error!s:.200}"


# --- workers --------------------------------------------------------------------------------------------------------


def _work(pipe: Connection, parent: Connection, folder: Path, seed: int) -> None:
    """Run the scenes whose numbers come, until there is None, or nobody at the other end."""
    parent.close()
    os.nice(10)
    stderr = os.memfd_create("stderr")
    os.dup2(stderr, 2)
    while (number := pipe.recv()) is not None:
        signal.setitimer(signal.ITIMER_PROF, LATE)  # where it runs out, the process ends
        found, said = outcome(case_of(seed, number, folder)), os.fstat(stderr).st_size
        if said and found.kind != FAULT:
            words = os.pread(stderr, 200, 0)
            found = found._replace(kind=FAULT, words=f"words on stderr: {words!r}; {found.words}")
        os.ftruncate(stderr, 0)
        os.lseek(stderr, 0, os.SEEK_SET)
        pipe.send(found)


class _Worker:
    """A process that runs scenes, one after the other, and can be killed at each."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.pipe, there = multiprocessing.Pipe()
        self.process = multiprocessing.Process(target=_work, args=(there, self.pipe, folder, seed), daemon=True)
        self.process.start()
        there.close()
        self.left = A_WORKER

    def run(self, number: int) -> Outcome:
        """The outcome of a scene, or what became of the process in place of it; then the worker is used up."""
        self.left -= 1
        self.pipe.send(number)
        try:
            if not self.pipe.poll(HANG):  # it waits for a lock that a thread held at the fork
                self.process.kill()
            return self.pipe.recv()
        except EOFError:
            self.process.join()
            self.left, ended = 0, self.process.exitcode
            late = f"no end after {LATE:g} s of processor time"
            return Outcome(FAULT, "?", late if ended == -signal.SIGPROF else f"the process ended with {ended}")

    def close(self) -> None:
        if self.process.is_alive():
            self.pipe.send(None)
        self.process.join(10)
        self.process.kill()


def outcomes(numbers: range, seed: int, folder: Path) -> Iterator[tuple[int, Outcome]]:
    """The outcomes of scenes, run in a process of their own."""
    worker = _Worker(folder, seed)
    for number in numbers:
        if not worker.left:
            worker.close()
            worker = _Worker(folder, seed)
        yield number, worker.run(number)
    worker.close()


# --- the campaign ---------------------------------------------------------------------------------------------------


def campaign(numbers: range, seed: int, folder: Path) -> int:
    """Run scenes, keep faults, print the table; the number of faults."""
    found: dict[int, Outcome] = {}
    for number, result in outcomes(numbers, seed, folder / "files"):
        found[number] = result
        with (folder / "outcomes.jsonl").open("a") as file:
            file.write(json.dumps({"number": number, **result._asdict()}) + "\n")
        if result.kind == FAULT:
            keep(seed, number, folder, result)
        elif not result.kind.startswith("stopped"):
            (folder / "files" / f"path_{seed}_{number}.csv").unlink(missing_ok=True)
        if len(found) % 100 == 0:
            print(f"{len(found)} of {len(numbers)}: {_counts(found.values())}", flush=True)
    print(table(found))
    return sum(result.kind == FAULT for result in found.values())


def keep(seed: int, number: int, folder: Path, result: Outcome) -> None:
    """Write a scene as TOML."""
    case = case_of(seed, number, folder / "files")
    head = f"# {result.words}\n# number {number}, seed {seed}, energy_balance {case.energy_balance}, limit {case.limit} s\n"
    (folder / f"fault_{seed}_{number}.toml").write_text(
        head + "".join(f"{key} = {toml(value)}\n" for key, value in case.scene.items())
    )
    print(f"FAULT {number} ({result.method}): {result.words}", flush=True)


def _counts(results: Any) -> str:
    return ", ".join(f"{kind} {count}" for kind, count in Counter(r.kind for r in results).most_common())


def table(found: dict[int, Outcome]) -> str:
    """Counts by method and outcome, and the largest energy errors."""
    kinds = ["balanced", "coarse", "no balance", "refused", "stopped", FAULT]
    rows: dict[str, list[Outcome]] = defaultdict(list)
    for result in found.values():
        rows[result.method].append(result)
        rows["all"].append(result)
    lines = [("method  " + "".join(f"{kind:>10}" for kind in [*kinds, "off/bound", "off/moved"]))]
    for method, results in sorted(rows.items()):
        counts = Counter(result.kind for result in results)
        balance = [result for result in results if result.kind == "balanced"]
        worst = [max((getattr(r, name) for r in balance), default=0.0) for name in ("off", "share")]
        cells = [f"{counts[kind]:>10}" for kind in kinds] + [f"{figure:>10.2g}" for figure in worst]
        lines.append(f"{method:<8}" + "".join(cells))
    return "\n".join(lines)


def main() -> None:
    """Run the campaign, or one scene of it."""
    parser = argparse.ArgumentParser(description="Run random scenes and check what comes of them.")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()) / "pendpin_scenes")
    parser.add_argument("--replay", type=int)
    chosen = parser.parse_args()
    (chosen.folder / "files").mkdir(parents=True, exist_ok=True)
    if chosen.replay is not None:
        case = case_of(chosen.seed, chosen.replay, chosen.folder / "files")
        print("".join(f"{key} = {toml(value)}\n" for key, value in case.scene.items()), case[1:])
        print(_checked(case))
        return
    sys.exit(campaign(range(chosen.first, chosen.first + chosen.count), chosen.seed, chosen.folder) > 0)


if __name__ == "__main__":
    main()
