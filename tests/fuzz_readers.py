"""Coverage-guided fuzzing of what reads files: whatever the bytes, they are taken, or refused with one readable line.

    pip install atheris
    python tests/fuzz_readers.py scene --minutes 20 --folder /tmp/fuzz     # or urdf, npz, csv
    python tests/fuzz_readers.py scene --replay FILE                       # one input again, with its traceback

What is taken is used as well: a scene and a URDF run to their first instant, URDFs and runs are drawn.
Anything but PendpinError is a finding: another exception, a warning, a word on stderr from a C library, a number that
is not finite, 10 s of processor time. Each kind is kept once, in FOLDER/READER/findings, with its traceback beside it;
what ends the process (a crash, 60 s in C code, 4 GB) is kept there by libFuzzer. Exit status 1 if there is any.
"""

import argparse
import json
import os
import re
import resource
import shutil
import signal
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

from mutations import NUMBERS, mutate_text, mutate_zip, unpacked

ROOT = Path(__file__).parents[1]
SECONDS = 10  # of processor time, for one input
SECONDS_IN_C = 60  # where Python's alarm is not heard
MEGABYTES = 4_000
MANY = 40  # rods
INSTRUMENTED = ["pendpin", "tomllib"]
TOML = "[ ] [[ ]] { } = , . \" ' # \\u0000 \\ufeff \n"
URDF = (
    "< > /> </ <!-- --> <![CDATA[ ]]> <?xml <!DOCTYPE &#0; &amp; \" ' robot link joint visual collision material color"
)


class Reader(NamedTuple):
    """What is fuzzed: a file of this name, with these seeds, mutated with these words, read and used by `take`."""

    file: str
    seeds: list[bytes]
    words: list[str]
    take: Callable[[Path], object]


class Finding(BaseException):
    """What no reader may do. Not an Exception: code that wraps every error of a damaged file does not catch it."""


# --- the readers ----------------------------------------------------------------------------------------------------


def reader(name: str, folder: Path) -> Reader:
    """One of the readers; `folder` gets the files that its inputs may name."""
    shutil.copy(ROOT / "urdf" / "universal_rod.urdf", folder / "rod.urdf")
    shutil.copy(ROOT / "examples" / "crane_trolley.csv", folder)
    return {"scene": _scenes, "urdf": _urdfs, "npz": _runs, "csv": _csvs}[name](folder)


def _scenes(folder: Path) -> Reader:
    from pendpin import simulate
    from pendpin.dynamics.dynamics import Dynamics
    from pendpin.model.build import build
    from pendpin.scene import Chain, Scene, Solver, load_scene

    def take(path: Path) -> None:
        scene = load_scene(path)
        if isinstance(scene.model, Chain) and scene.model.count > MANY:  # all of it would take seconds
            first = scene.model.model_copy(update={"rods": scene.model.rods[:MANY], "copies": 1})
            Dynamics(build(first), ())
        else:
            simulate(
                scene.model_copy(
                    update={"duration": 0.0, "solver": Solver(method="dop853", engine=scene.solver.engine)}
                )
            )

    texts = [path.read_text() for path in sorted((ROOT / "examples").glob("*.toml"))]
    schema = json.dumps(Scene.model_json_schema())
    words = sorted(set(re.findall(r'"([a-z_][a-z_0-9]*)"', schema)))
    return Reader("scene.toml", [text.encode() for text in texts], [*words, *NUMBERS.split(), *TOML.split(" ")], take)


def _urdfs(folder: Path) -> Reader:
    import numpy as np

    from pendpin import simulate
    from pendpin.dynamics.dynamics import Dynamics
    from pendpin.model.build import build
    from pendpin.model.write_urdf import chain_urdf
    from pendpin.scene import Chain, Rod, Scene, Solver, UrdfModel

    def take(path: Path) -> None:
        model = UrdfModel(path=path)
        dynamics = Dynamics(build(model), ())
        state = np.sin(1.0 + np.arange(len(dynamics.model.joints)))
        if not np.isfinite(dynamics.acceleration(0.0, state, state)).all():
            raise Finding("an acceleration that is not finite")
        _draw(simulate(Scene(model=model, duration=0.0, solver=Solver(method="dop853"))))

    texts = [path.read_text() for path in sorted((ROOT / "urdf").glob("*.urdf"))]
    texts.append(chain_urdf(Chain(rods=(Rod(length=1.0, mass=1.0, radius=0.01, payload=0.2),), copies=2)))
    texts.append(re.sub(r"<visual>.*?</visual>|<!--.*?-->|\s\s+", "", texts[0], flags=re.DOTALL))
    words = [*sorted(set(re.findall(r"[a-z]+", "".join(texts)))), "continuous", "prismatic", "fixed", "mimic", "mesh"]
    return Reader("rod.urdf", [text.encode() for text in texts], [*words, *NUMBERS.split(), *URDF.split()], take)


def _runs(folder: Path) -> Reader:
    from pendpin import simulate
    from pendpin.scene import Scene, builtin_scene, load_scene
    from pendpin.trajectory import Trajectory

    def take(path: Path) -> None:
        run = Trajectory.load(path)
        if run.sound < len(run.t):
            raise Finding("numbers that are not finite")
        _draw(run)
        run.energy(), run.imbalance, run.stats.setting

    def short(scene: Scene, **options: Any) -> bytes:
        changed = {"duration": 0.05, "solver": scene.solver.model_copy(update={"samples": 3})}
        return simulate(scene.model_copy(update=changed), **options).save(folder / "run.npz").read_bytes()

    seeds = [
        short(builtin_scene()),
        short(load_scene(ROOT / "examples" / "stops.toml"), energy_balance=True),
        short(load_scene(ROOT / "examples" / "double_pendulum.toml")),
    ]
    words = "descr fortran_order shape <f8 >f8 |O <U1 <i8 |V8 True False None (3,) (3,2) () (-1,) (0,) kind chain urdf"
    return Reader("run.npz", [unpacked(seed) for seed in seeds], [*words.split(), *NUMBERS.split()], take)


def _draw(run: Any) -> None:
    from pendpin.graphics.page import contents
    from pendpin.graphics.run_drawing import drawing_of

    json.dumps(contents(drawing_of(run)), allow_nan=False)


def _csvs(folder: Path) -> Reader:
    import numpy as np

    from pendpin.effects.track import read_track

    def take(path: Path) -> None:
        track = read_track(path)
        times = np.linspace(track.start, track.end, 7)
        found = [read(times) for read in (track.position, track.velocity, track.acceleration)]
        if not np.isfinite(found).all():
            raise Finding("positions that are not finite")

    seed = (ROOT / "examples" / "crane_trolley.csv").read_bytes()
    seeds = [seed, b"t,x,y,z\n0,0,0,0\n1,1,2,3\n2,0,0,1\n", b"\xef\xbb\xbf# a\r\n0,0,0,0\r\n\r\n1,1,2,3\r\n"]
    return Reader("path.csv", seeds, [*NUMBERS.split(), "t,x,y,z", "#", ",", "\n", "\r", '"', ";", "\x0b"], take)


# --- one input ------------------------------------------------------------------------------------------------------


def verdict(reader: Reader, folder: Path, data: bytes, guarded: bool = True) -> str:
    """Whether the bytes are "taken" or "refused". Anything else goes through, as what it is."""
    from pendpin.errors import Note, PendpinError

    path = folder / reader.file
    path.write_bytes(data)
    try:
        with _alarm(), _silence() if guarded else nullcontext(), warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", Note)
            reader.take(path)
    except PendpinError as error:
        if not str(error).isprintable() or len(str(error)) > 2_000:
            raise Finding(f"an unreadable message: {error!s:.200}") from None
        return "refused"
    return "taken"


@contextmanager
def _alarm() -> Iterator[None]:
    """Finding after SECONDS of this process's time."""

    def late(number: int, frame: Any) -> None:
        raise Finding(f"{SECONDS} s of processor time")

    signal.signal(signal.SIGVTALRM, late)
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)


@contextmanager
def _silence() -> Iterator[None]:
    """Finding where something is written to stderr, by Python or by C."""
    kept, file = os.dup(2), os.memfd_create("stderr")
    os.dup2(file, 2)
    try:
        yield
        if written := os.pread(file, 200, 0):
            raise Finding(f"words on stderr: {written!r}")
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(file)


# --- the search -----------------------------------------------------------------------------------------------------


def search(name: str, minutes: float, folder: Path) -> None:
    """Fuzz one reader for so long. Does not return: libFuzzer ends the process, as do its findings."""
    import atheris

    with atheris.instrument_imports(include=INSTRUMENTED):
        import pendpin.graphics.page  # with what draws: later imports are not instrumented
        import pendpin.graphics.run_drawing  # noqa: F401

        target = reader(name, _fresh(folder / "files"))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    seeds, findings = _fresh(folder / "seeds"), _fresh(folder / "findings")
    for number, seed in enumerate(target.seeds):
        (seeds / f"seed_{number}").write_bytes(seed)
    counts, kinds = Counter[str](), set[str]()

    def one(data: bytes) -> None:
        try:
            found = verdict(target, folder / "files", data)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # Rust's panics are no Exception
            found = "findings"
            _keep(error, data, findings, kinds)
        counts[found] += 1
        if counts.total() % 1000 == 0:
            (folder / "counts.json").write_text(json.dumps(counts))

    def mutated(data: bytes, most: int, seed: int) -> bytes:
        random = Random(seed)
        if random.random() < 0.2:
            return atheris.Mutate(data, most)
        if random.random() < 0.3:  # most of what has been found by now is refused early
            data = random.choice(target.seeds)
        if name == "npz":
            return mutate_zip(data, target.words, random, lambda part: atheris.Mutate(part, most))[:most]
        return mutate_text(data, target.words, random)[:most]

    options = [
        f"-max_total_time={int(minutes * 60)}",
        f"-timeout={SECONDS_IN_C}",
        f"-rss_limit_mb={MEGABYTES}",
        f"-artifact_prefix={findings}/",
        "-max_len=32768",
        "-len_control=0",
        "-mutate_depth=2",
        "-print_final_stats=1",
    ]
    atheris.Setup([sys.argv[0], *options, str(_fresh(folder / "corpus")), str(seeds)], one, custom_mutator=mutated)
    atheris.Fuzz()


def _searched(name: str, minutes: float, folder: Path) -> int:
    """Search in a process of its own, and say what came of it: 1 if anything was found, else 0."""
    shutil.rmtree(folder / "findings", ignore_errors=True)
    child = os.fork()
    if child == 0:
        search(name, minutes, folder)
    _, status = os.waitpid(child, 0)
    found = sorted(path.name for path in (folder / "findings").iterdir())
    print(f"{name}: {(folder / 'counts.json').read_text()}, findings: {found}")
    return 1 if found or status else 0


def _fresh(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _keep(error: BaseException, data: bytes, findings: Path, kinds: set[str]) -> None:
    """Save the first input of each kind of finding: the same error in the same line of pendpin is one kind."""
    lines = [frame for frame in traceback.extract_tb(error.__traceback__) if "pendpin" in frame.filename]
    place = f"{Path(lines[-1].filename).stem}_{lines[-1].lineno}" if lines else "unknown"
    kind = f"{type(error).__name__}_{place}"
    if kind not in kinds:
        kinds.add(kind)
        (findings / kind).write_bytes(data)
        (findings / f"{kind}.txt").write_text("".join(traceback.format_exception(error)), errors="replace")
        print(f"FINDING {kind}: {error!s:.200}", flush=True)


def main() -> None:
    """Search, or replay."""
    parser = argparse.ArgumentParser(description="Fuzz one of pendpin's readers.")
    parser.add_argument("reader", choices=["scene", "urdf", "npz", "csv"])
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()) / "pendpin_fuzz")
    parser.add_argument("--replay", type=Path, nargs="+")
    chosen = parser.parse_args()
    if not chosen.replay:
        sys.exit(_searched(chosen.reader, chosen.minutes, _fresh(chosen.folder / chosen.reader)))
    for path in chosen.replay:
        with tempfile.TemporaryDirectory() as folder:
            target = reader(chosen.reader, Path(folder))
            print(f"{path}: {verdict(target, Path(folder), path.read_bytes(), guarded=False)}")


if __name__ == "__main__":
    main()
