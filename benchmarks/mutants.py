"""Plants small random faults one by one, and counts those that the tests that reach them notice.

    nice -n 10 python benchmarks/mutants.py 200 mutants.jsonl [--seed 0] [--modules dynamics/contacts.py ...]
    nice -n 10 python benchmarks/mutants.py 0 planted.jsonl --planted   # faults that once were noticed by no test

A fault changes a comparison, a constant, a sign, min and max, or the bound of a slice, in a function (planting.py). No file
is written: pytest collects the tests, and each fault is planted in a process forked from there, in which the code of the
module's functions is exchanged. First coverage.py records once which lines each test executes (mutants.lines); a fault then
meets the tests that execute its line, first those that are quick and execute little else, until one fails or takes far too
long. Slow tests do not run. Faults in equivalent_mutants.txt change nothing that a test could notice. The same command
continues where it stopped; --again repeats those that were left. With --tests sweep sweep_plan only those files take part;
with --hypothesis-profile few property tests have a tenth of their examples, with --cases 1 a test has its first case only,
with --seconds 5 a fault meets tests of 5 s of processor together: less is noticed, and what is left is to be repeated.
"""

import argparse
import gc
import json
import os
import resource
import signal
import sys
import types
from collections import Counter
from collections.abc import Callable, Iterator
from importlib import import_module
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from coverage import Coverage, CoverageData
from rich.console import Console
from rich.table import Table

from planting import Fault, faults_of

TOP = Path(__file__).parents[1]
SOURCE = TOP / "src" / "pendpin"
EQUIVALENT = Path(__file__).with_name("equivalent_mutants.txt")
PLANTED = {  # faults that once were noticed by no test: file, what is changed, and into what
    "settling_time at the first time near": ("sweeps/measures.py", "Changes(*(x[-1:] for", "Changes(*(x[:1] for"),
    "settling_time within 2.06 %": ("sweeps/measures.py", "level = SETTLED * size", "level = 1.03 * SETTLED * size"),
    "flip_time upwards only, of a run": ("sweeps/measures.py", "np.cos(half) +", "np.cos(np.maximum(half, 0)) +"),
    "flip_time upwards only, of many": (
        "runs/batches.py",
        "np.fmin(self.first[place], t)",
        "np.fmin(self.first[place], t if direction > 0 else np.nan)",
    ),
    "lyapunov 3 % too large": ("sweeps/measures.py", "return growth / float(", "return 1.03 * growth / float("),
    "memory of residuals 13 times too short": ("fitting/uncertainty.py", "np.ceil(4 * time)", "np.ceil(0.3 * time)"),
    "the smaller of two bounds": (
        "runs/accuracy/estimate.py",
        "np.maximum(gaps.second * scatter",
        "np.minimum(gaps.second * scatter",
    ),
    "work of impacts off by 5e-5": ("dynamics/contacts.py", "after)[joints] / 2", "after)[joints] / 2.0001"),
    "lift of drag at 0.49 of a rod": ("effects/drag.py", "turn + 0.5 * lift", "turn + 0.49 * lift"),
    "Modes.hertz doubled": ("stability/modes.py", "return self.omega / (2 * np.pi)", "return self.omega / np.pi"),
    "hertz of the table doubled": ("stability/modes.py", "{omega / (2 * np.pi):.6g}", "{omega / np.pi:.6g}"),
    "modes that are left out, one too many": (
        "stability/modes.py",
        "len(self._groups) - len(rows)",
        "len(self._groups) - len(rows) + 1",
    ),
    "the kinetic energy of a run with the other sign": (
        "graphics/report.py",
        "run.kinetic[-1] - run.kinetic[0]",
        "run.kinetic[0] - run.kinetic[-1]",
    ),
    "the potential in the kinetic energy's row": (
        "graphics/report.py",
        "{run.kinetic[-1] - run.kinetic[0]:",
        "{run.potential[-1] - run.potential[0]:",
    ),
    "events that are left out, one too few": (
        "graphics/report.py",
        "and {len(run.events) - MOST_EVENTS}",
        "and {len(run.events) - MOST_EVENTS - 1}",
    ),
    "rows that are left out, one too few": ("ground/report.py", "len(self.rows) - most", "len(self.rows) - most - 1"),
    "per cent of effects ten times too small": (
        "sweeps/significance.py",
        "{100 * row.change:.2g}",
        "{10 * row.change:.2g}",
    ),
    "the fastest swing as the slowest": ("stability/linearize.py", "float(swings.min())", "float(swings.max())"),
    "microseconds called milliseconds": ("verification/work_precision/report.py", "3g} µs", "3g} ms"),
    "the unit of a step left out": ("verification/work_precision/report.py", '" s" if curve.kind', '"" if curve.kind'),
    "the price of a digit over one decade too many": (
        "verification/work_precision/report.py",
        "** (1 / (len(times) - 1))",
        "** (1 / len(times))",
    ),
    "one more digit, the other way about": (
        "verification/work_precision/report.py",
        "{finer[1] / best[1]:.2f}",
        "{best[1] / finer[1]:.2f}",
    ),
    "the tension of the first rod for all": ("graphics/figure.py", "values[:, rod], style", "values[:, 0], style"),
    "the kinetic energy of a figure doubled": (
        "graphics/figure.py",
        "ax.plot(run.t, kinetic, label",
        "ax.plot(run.t, 2 * kinetic, label",
    ),
    "notes that are left out, all of them": ("cli/inputs.py", "{len(said) - MOST_NOTES} more", "{len(said)} more"),
    "the claim of an accuracy without its scale": (
        "verification/agreement/__init__.py",
        "bound += run.stats.error * scale(build(run.source.model))",
        "bound += run.stats.error",
    ),
    "days that are counted ten times too long": ("runs/limits.py", "gained / LONGEST if", "gained / LONGEST / 10 if"),
}
PATIENCE = 10.0  # times the time that the tests took without a fault
START = 30  # s of processor, beside that
HANG = 600  # s on the clock, after which what waits is taken to wait for ever


class Planter:
    """In the place of pytest's own loop: collected tests run in forked processes, each with a fault."""

    def __init__(self, faults: list[Fault], options: argparse.Namespace, done: Callable[[Fault, str], None]) -> None:
        self._faults, self._options, self._done = faults, options, done
        self._lines, self._seconds = options.file.with_suffix(".lines"), options.seconds
        self._failed = list[str]()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note a failed test."""
        if report.failed:
            self._failed.append(report.nodeid)

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Record, then plant."""
        items, cases = dict[str, pytest.Item](), Counter[str]()
        for item in session.items:
            cases[function_of(item.nodeid)] += 1
            if cases[function_of(item.nodeid)] <= self._options.cases:
                items[item.nodeid] = item
        if not self._lines.exists():
            print(f"{len(items)} tests: which lines they execute", flush=True)
            in_a_fork(lambda: self._record(items), resource.RLIM_INFINITY)
        reach = Reach(self._lines)
        for fault in self._faults:
            chosen = reach.choose(fault, self._seconds)
            most = START + int(PATIENCE * sum(reach.seconds[name] for name in chosen))
            self._done(fault, in_a_fork(lambda: self._meet(fault, [items[x] for x in chosen if x in items]), most))  # noqa: B023
        return True

    def _record(self, items: dict[str, pytest.Item]) -> str:
        """Which lines of the package each test executes that passes without a fault, and how long it takes."""
        seconds = dict[str, float]()
        recorder = Coverage(
            data_file=str(self._lines.with_suffix(".coverage")), include=[f"{SOURCE}/*"], config_file=False
        )
        recorder.set_option("run:core", "ctrace")
        recorder.start()
        for name, item in items.items():
            recorder.switch_context(name)
            begin = sum(os.times()[:4])
            self._run(item)
            seconds[name] = sum(os.times()[:4]) - begin
        recorder.stop()
        recorder.save()
        self._lines.write_text(json.dumps({name: x for name, x in seconds.items() if name not in self._failed}))
        return ""

    def _run(self, item: pytest.Item) -> None:
        """Run a test, and make and take down all its fixtures."""
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)

    def _meet(self, fault: Fault, items: list[pytest.Item]) -> str:
        """The first test that notices a fault, or nothing."""
        exchange_code(fault)
        for item in items:
            self._run(item)
            if self._failed:
                return self._failed[0]
        return ""


class Reach:
    """Which tests execute which lines, and how long they take."""

    def __init__(self, lines: Path) -> None:
        self.seconds: dict[str, float] = json.loads(lines.read_text())
        self._data = CoverageData(str(lines.with_suffix(".coverage")))
        self._data.read()
        self._executed = Counter[str]()  # lines of the package, by test
        for file in self._data.measured_files():
            self._executed.update(chain.from_iterable(self._data.contexts_by_lineno(file).values()))

    def choose(self, fault: Fault, seconds: float) -> list[str]:
        """Tests that execute a fault's line, or its file where none is known to, of so many s together, the best first."""
        lines = self._data.contexts_by_lineno(str(SOURCE / fault.module))
        here = Counter(chain.from_iterable(lines.values()))
        names = [name for name in lines.get(fault.line) or here if name in self.seconds]
        # quick ones that execute little else come first, one case of each function before the others
        price = {name: self.seconds[name] * self._executed[name] / here[name] for name in names}
        cases = Counter[str]()
        for name in sorted(names, key=price.__getitem__):
            cases[function_of(name)] += 1
            price[name] *= cases[function_of(name)]
        names.sort(key=price.__getitem__)
        spent = np.cumsum([self.seconds[name] for name in names])
        return names[: max(1, int((spent <= seconds).sum()))]


def function_of(name: str) -> str:
    """The name of a test without its case."""
    return name.partition("[")[0]


def in_a_fork(run: Callable[[], str], most: int) -> str:
    """What a function says in a forked process, or "too slow" where it takes more than so much, s of processor."""
    receive, send = os.pipe()
    if child := os.fork():
        os.close(send)
        with os.fdopen(receive) as told:
            text = told.read()
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        return text if status == 0 else "too slow" if status < 0 else "an error"
    try:
        resource.setrlimit(resource.RLIMIT_CPU, (most, most))
        signal.alarm(0 if most == resource.RLIM_INFINITY else HANG)
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (1, 2):
            os.dup2(nowhere, stream)
        os.write(send, run().encode())
        os._exit(0)
    except BaseException:
        os._exit(1)


def exchange_code(fault: Fault) -> None:
    """Give all functions of a module that exist the code that they have with the fault."""
    path = SOURCE / fault.module
    # a module that is imported late would come without the fault
    import_module("pendpin." + fault.module.removesuffix(".py").replace("/", "."))
    right = path.read_text()
    both = (codes(compile(text, str(path), "exec")) for text in (right, fault.planted(right)))
    new = {place(one): other for one, other in zip(*both, strict=True)}
    gc.unfreeze()  # tests/conftest.py freezes what is there, and what is frozen is not listed
    for thing in gc.get_objects():
        if isinstance(thing, types.FunctionType) and thing.__code__.co_filename == str(path):
            thing.__code__ = new[place(thing.__code__)]


def codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """A code and all in it, in the order of the file."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from codes(constant)


def place(code: types.CodeType) -> tuple[str, int, bytes]:
    """What tells a code from the others of its file."""
    return code.co_qualname, code.co_firstlineno, code.co_linetable


def all_modules() -> list[str]:
    """The files of the package."""
    return sorted(str(path.relative_to(SOURCE)) for path in SOURCE.rglob("*.py"))


def planted() -> list[Fault]:
    """Those of PLANTED."""
    found = []
    for name, (module, before, after) in PLANTED.items():
        text = (SOURCE / module).read_text()
        assert text.count(before) == 1, f"{name}: {before} is not there once"
        begin = text.index(before)
        line = text[:begin].count("\n") + 1
        found.append(
            Fault(module, line, name, before, after, begin, begin + len(before), text.splitlines()[line - 1].strip())
        )
    return found


def table(rows: list[dict[str, Any]]) -> Table:
    """Counts by module."""
    shown = Table("module", "planted", "killed", "equivalent", "left")
    for module in [*sorted({row["module"] for row in rows}), "all"]:
        some = [row for row in rows if module in (row["module"], "all")]
        counts = [sum(verdict_of(row) == verdict for row in some) for verdict in ("killed", "equivalent", "left")]
        shown.add_row(module, str(len(some)), *map(str, counts))
    return shown


def verdict_of(row: dict[str, Any]) -> str:
    """What became of a fault."""
    known = {line.strip() for line in EQUIVALENT.read_text().splitlines()}
    names = {row["name"], row["name"].rpartition(" -> ")[0] + " -> any"}
    return "killed" if row["by"] else "equivalent" if names & known else "left"


def plant(faults: list[Fault], options: argparse.Namespace) -> None:
    """Plant faults in this process's children, and write what became of each."""

    def done(fault: Fault, by: str) -> None:
        row = {"module": fault.module, "line": fault.line, "kind": fault.kind, "name": fault.name, "by": by}
        with options.file.open("a") as out:
            out.write(json.dumps(row) + "\n")
        print(f"{fault.kind}, line {fault.line}, {fault.name}: {by or 'LEFT'}", flush=True)

    names = [str(TOP / "tests" / f"test_{name}.py") for name in options.tests] or [str(TOP / "tests")]
    arguments = ["-s", "-n0", "-p", "no:cacheprovider", f"--hypothesis-profile={options.hypothesis_profile}", *names]
    pytest.main(arguments, plugins=[Planter(faults, options, done)])


def main() -> None:
    """Plant what is missing, print the table and what is left."""
    right = {"PYTHONPATH": str(TOP / "src"), "OMP_NUM_THREADS": "1"}
    if not right.items() <= os.environ.items():
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | right)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int)
    parser.add_argument("file", type=Path)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--modules", nargs="+", help="files in src/pendpin; all if left out")
    parser.add_argument("--planted", action="store_true", help="PLANTED in place of random ones")
    parser.add_argument("--again", action="store_true", help="also those that were left")
    parser.add_argument("--hypothesis-profile", default="usual")
    parser.add_argument("--cases", type=float, default=np.inf)
    parser.add_argument("--seconds", type=float, default=np.inf)
    parser.add_argument("--tests", nargs="+", default=[], help="names of files in tests; all if left out")
    options = parser.parse_args()
    modules = options.modules or all_modules()
    chosen = planted() if options.planted else faults_of(SOURCE, modules, options.seed)[: options.count]
    known = rows_of(options.file)
    done = {(row["name"], row["line"]) for row in known.values() if row["by"] or not options.again}
    if missing := [fault for fault in chosen if (fault.name, fault.line) not in done]:
        plant(missing, options)
    rows = rows_of(options.file)
    rows = [rows[key] for fault in chosen if (key := (fault.name, fault.line)) in rows]
    Console().print(table(rows))
    for row in rows:
        if verdict_of(row) == "left":
            print(f"left: {row['module']}, line {row['line']}, {row['name'].partition(': ')[2]}")


def rows_of(file: Path) -> dict[tuple[str, int], dict[str, Any]]:
    """What became of each fault at last, by name and line."""
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    return {(row["name"], row["line"]): row for row in rows}


if __name__ == "__main__":
    main()
