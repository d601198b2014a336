"""What is fuzzed: the readers of files with their seeds and words, and the verdict on one input."""

import json
import os
import re
import shutil
import signal
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any, NamedTuple

from mutations import NUMBERS, unpacked

ROOT = Path(__file__).parents[1]
SECONDS = 10  # of processor time, for one input
MANY = 40  # rods
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
    from pendpin.model.write_models import chain_urdf
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
    from pendpin import Trajectory, simulate
    from pendpin.scene import Scene, builtin_scene, load_scene

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
        track = read_track(path, ("t", "x", "y", "z"))
        times = np.linspace(*track.ends, 7)
        found = [track.at(times, order) for order in range(3)]
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
