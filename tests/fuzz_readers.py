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
import resource
import shutil
import sys
import tempfile
import traceback
from collections import Counter
from pathlib import Path
from random import Random

from fuzz_targets import reader, verdict
from mutations import mutate_text, mutate_zip

SECONDS_IN_C = 60  # where Python's alarm is not heard
MEGABYTES = 4_000
INSTRUMENTED = ["pendpin", "tomllib"]


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
