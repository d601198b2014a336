"""Saved runs, output paths and command lines that pendpin refuses, each with a part of what it says."""

import json
import os
import pickle
from pathlib import Path

import numpy as np

from bad_input import ROD, SCENE, URDF_SCENE, Case, Content
from run_files import (
    NV,
    N,
    Trap,
    at,
    claiming,
    damaged,
    flagged,
    good_run,
    header,
    letters,
    linked,
    meta,
    run_file,
    with_member,
    zipped,
)

NOT = "run.npz: not a run that pendpin saved (pendpin run SCENE saves one): "
GOOD = good_run()
HUGE = "(4611686018427387904,)"
RUNS: dict[str, tuple[Content, str]] = {
    "empty": (b"", f"{NOT}File is not a zip file"),
    "text": ("a run\n", f"{NOT}File is not a zip file"),
    "binary": (bytes(range(256)) * 40, f"{NOT}File is not a zip file"),
    "a single array": (claiming("(3,)"), f"{NOT}File is not a zip file"),
    "a pickle": (pickle.dumps(Trap()), f"{NOT}File is not a zip file"),
    "a pipe": (os.mkfifo, "run.npz: cannot be read: it is a pipe, not a file"),
    "a folder": (Path.mkdir, "run.npz: cannot be read: it is a folder, not a file"),
    "truncated": (run_file()[:-600], f"{NOT}File is not a zip file"),
    "first half lost": (run_file()[900:], NOT),
    "damaged data": (damaged(run_file(), 400), NOT),
    "damaged, compressed": (damaged(zipped(t=claiming("(9,)") + bytes(range(72))), 60), NOT),
    "empty zip": (zipped(), f"{NOT}array 'meta' is missing"),
    "other members": (zipped(x=b"hello"), f"{NOT}array 'x' has no header that NumPy writes"),
    "pickled object array": (run_file(q=np.array([Trap()], dtype=object)), f"{NOT}array 'q' holds no plain numbers"),
    "objects in a record": (zipped(q=claiming("(1,)", "[('a', '|O')]")), f"{NOT}array 'q' holds no plain numbers"),
    "code for a header": (
        zipped(q=header("__import__('os').system('touch trapped')\n")),
        f"{NOT}array 'q' has no header that NumPy writes",
    ),
    "odd literal": (
        zipped(q=header("{'descr': '<f8', 'shape': (1if 1else 2,), '\\d': 1}\n")),
        f"{NOT}array 'q' has no header",
    ),
    "negative shape": (zipped(q=claiming("(-1,)")), f"{NOT}array 'q' holds no plain numbers"),
    "shape of no number": (zipped(q=claiming("('a',)")), NOT),
    "claims 2^62 numbers": (zipped(q=claiming(HUGE)), f"{NOT}its arrays claim 3.69e+19 bytes, more than 4e+09"),
    "claims of 40 dimensions": (zipped(q=claiming("(" + "2," * 40 + ")")), f"{NOT}its arrays claim"),
    "claims a text of 10^12": (zipped(meta=claiming("()", "'<U999999999'")), NOT),
    "claims a header of 4 GB": (zipped(q=header("{}", version=2, length=4_000_000_000)), NOT),
    "long header": (zipped(q=header("{'descr': '<f8'" + " " * 60_000)), NOT),
    "header of 50 MB of blanks": (
        lambda path: path.write_bytes(zipped(q=header(" " * 50_000_000, version=2))),
        f"{NOT}array 'q' has no header",
    ),
    "newer array format": (
        zipped(q=b"\x93NUMPY\x09\x00" + b" " * 99),
        f"{NOT}array 'q' has no header that NumPy writes",
    ),
    "bomb of 50 MB": (
        lambda path: path.write_bytes(run_file(q=np.zeros(6_000_000))),
        f"{NOT}array 'q' is float64 (6000000,)",
    ),
    "encrypted": (flagged(run_file(), 8, 1), f"{NOT}File 'q.npy' is encrypted"),
    "unknown compression": (flagged(run_file(), 10, 99), f"{NOT}That compression method is not supported"),
    **{
        f"{part}0 % of it": (run_file()[: len(run_file()) * part // 10], f"{NOT}File is not a zip file")
        for part in range(1, 10)
    },
    "other byte order": (run_file(q=GOOD["q"].astype(">f8")), f"{NOT}array 'q' is >f8 (4, 2), not float64"),
    "single precision": (run_file(q=GOOD["q"].astype("f4")), f"{NOT}array 'q' is float32 (4, 2), not float64"),
    "more than double precision": (run_file(q=GOOD["q"].astype("g")), f"{NOT}array 'q' is "),
    "dates": (run_file(t=np.arange(N).astype("M8[s]")), f"{NOT}array 't' is datetime64[s] (4,), not float64"),
    "records": (run_file(q=GOOD["q"].view([("a", "f8")])), f"{NOT}array 'q' is [('a', '<f8')] (4, 2), not float64"),
    "bytes for names": (run_file(joints=np.array([b"theta", b"phi"])), f"{NOT}array 'joints' is |S5 (2,), not text"),
    "a zip in the zip": (zipped(run=run_file()), f"{NOT}array 'run' has no header that NumPy writes"),
    "q twice": (with_member(run_file(), "q", b"\x93NUMPY"), f"{NOT}array 'q' is there twice"),
    "data after the data": (
        with_member(run_file(q=None), "q", claiming("(4, 2)") + bytes(72)),
        f"{NOT}array 'q' is longer than its header says",
    ),
    "2,000 arrays": (zipped(**{f"x{i}": b"" for i in range(2000)}), f"{NOT}it holds 2000 arrays, more than 1000"),
    "claims a text of 800 MB": (
        zipped(meta=claiming("()", "'<U200000000'")),
        f"{NOT}its texts claim 8e+08 bytes, more than 4e+08",
    ),
    "text beyond Unicode": (run_file(meta=letters(0x7B, 0x69000000)), f"{NOT}array 'meta' holds"),
    "names beyond Unicode": (
        run_file(joints=letters(0x110000, 0x61).reshape(1).repeat(NV)),
        f"{NOT}array 'joints' holds",
    ),
    "no t": (run_file(t=None), f"{NOT}array 't' is missing"),
    "no meta": (run_file(meta=None), f"{NOT}array 'meta' is missing"),
    "no joints": (run_file(joints=None), f"{NOT}array 'joints' is missing"),
    "no wrench": (run_file(wrench=None), f"{NOT}array 'wrench' is missing"),
    "R1 without R2": (run_file(R2=None), f"{NOT}array 'R2' is missing"),
    "nan in q": (run_file(q=at(GOOD["q"], np.nan)), f"{NOT}array 'q' holds NaN or a number beyond 1e+150"),
    "inf in t": (run_file(t=at(GOOD["t"], np.inf)), f"{NOT}array 't' holds NaN or a number beyond 1e+150"),
    "huge q": (run_file(q=at(GOOD["q"], 1e200)), f"{NOT}array 'q' holds NaN or a number beyond 1e+150"),
    "nan in R3": (run_file(R3=at(GOOD["R3"], np.nan)), f"{NOT}array 'R3' holds NaN or a number beyond 1e+150"),
    "nan in tips": (run_file(tips=at(GOOD["tips"], np.nan)), f"{NOT}array 'tips' holds NaN or a number beyond 1e+150"),
    "falling t": (run_file(t=GOOD["t"][::-1].copy()), f"{NOT}array 't' does not rise"),
    "t of one number": (run_file(t=np.float64(1)), f"{NOT}array 't' has the shape ()"),
    "no samples": (run_file(t=np.zeros(0)), f"{NOT}array 't' has the shape (0,)"),
    "q too short": (run_file(q=GOOD["q"][1:]), f"{NOT}array 'q' is float64 (3, 2), not float64 (4, 2)"),
    "q flat": (run_file(q=GOOD["t"]), f"{NOT}array 'q' is float64 (4,), not float64 (4, 2)"),
    "tips flat": (run_file(tips=GOOD["t"]), f"{NOT}array 'tips' has the shape (4,)"),
    "tips without rods": (run_file(tips=np.zeros((N, 0, 3))), f"{NOT}array 'tips' has the shape (4, 0, 3)"),
    "R1 flat": (run_file(R1=GOOD["t"]), f"{NOT}array 'R1' has the shape (4,)"),
    "whole numbers": (run_file(q=np.zeros((N, NV), int)), f"{NOT}array 'q' is int64 (4, 2), not float64 (4, 2)"),
    "complex numbers": (run_file(v=GOOD["v"] + 1j), f"{NOT}array 'v' is complex128 (4, 2), not float64"),
    "text for numbers": (run_file(a=np.full((N, NV), "1")), f"{NOT}array 'a' is <U1 (4, 2), not float64"),
    "numbers for names": (run_file(joints=np.zeros(2)), f"{NOT}array 'joints' is float64 (2,), not text"),
    "one joint too many": (run_file(joints=np.array(["a", "b", "c"])), f"{NOT}array 'q' is float64 (4, 2), not"),
    "meta as number": (run_file(meta=np.float64(1)), f"{NOT}array 'meta' is float64 (), not text"),
    "meta not JSON": (run_file(meta=np.array("{")), f"{NOT}Expecting property name"),
    "meta a list": (run_file(meta=np.array("[]")), f"{NOT}its format is of another version"),
    "meta nested deep": (run_file(meta=np.array("[" * 200_000)), NOT),
    "meta of a newer version": (run_file(meta=meta(format=99)), f"{NOT}its format is of another version"),
    "meta without scene": (run_file(meta=meta(scene=[])), f"{NOT}meta holds no scene"),
    "meta without steps": (run_file(meta=meta(steps=None)), f"{NOT}meta: steps: None is not a whole number"),
    "meta with text for a number": (run_file(meta=meta(tolerance="x")), f"{NOT}meta: tolerance: 'x' is not a number"),
    "meta with a list for a name": (run_file(meta=meta(method=[1])), f"{NOT}meta: method: [1] is not text"),
}

TWO_RODS = {"model": {"kind": "chain", "rods": [{"length": 1, "mass": 1}], "copies": 2}}
LOST_URDF = {"model": {"kind": "urdf", "path": "gone.urdf"}}
VIEWED = {
    "no scene": ({}, "run.npz: model: None is not a table"),
    "another scene": (TWO_RODS, "run.npz: the run does not fit its model"),
    "broken scene": ({"model": {"kind": "chain", "rods": 3}}, "run.npz: model.rods: 3 is not a list"),
    "lost URDF": (LOST_URDF, "run.npz: gone.urdf: cannot be read: No such file or directory"),
    "half a letter in its scene": ({"model": {"kind": "\ud800"}}, "run.npz: model.kind: '"),
    "half a letter for a key": ({"model": {"kind": "chain", "\ud800": 1}}, r"run.npz: model: '\ud800': "),
    "scene nested deep": ({"model": json.loads("[" * 900 + "]" * 900)}, f"{NOT}meta holds no scene"),
}

GIVEN = {"scene.toml": SCENE}
RUN = ("run", "scene.toml")
IN_A_SCENE = {"rod.urdf": ROD, "u.toml": URDF_SCENE}
TWICE = "this name is given twice; every file needs its own"
TARGETS = [
    Case("html: the run", ("view", "run.npz", "--html", "run.npz"), f"run.npz: {TWICE}", {"run.npz": run_file()}),
    Case("plot of a run: the run", ("plot", "run.png"), f"run.png: {TWICE}", {"run.png": run_file()}),
    Case("out: the URDF of the scene", ("run", "u.toml", "--out", "rod.urdf"), f"rod.urdf: {TWICE}", IN_A_SCENE),
    Case("urdf: the scene", ("urdf", "scene.toml", "--out", "scene.toml"), f"scene.toml: {TWICE}", GIVEN),
    Case("out: a link to the scene", (*RUN, "--out", "l"), f"l: {TWICE}", GIVEN | {"l": linked("scene.toml")}),
    Case("out: a link to itself", (*RUN, "--out", "l"), "l: cannot be written: circular", GIVEN | {"l": linked("l")}),
    Case(
        "out: a folder",
        (*RUN, "--out", "there"),
        "there: cannot be written: it is a folder",
        GIVEN | {"there": Path.mkdir},
    ),
    Case("out: the folder itself", (*RUN, "--out", "."), ".: cannot be written: it is a folder", GIVEN),
    Case("out: a device", (*RUN, "--out", "/dev/null"), "/dev/null: cannot be written: it is a device", GIVEN),
    Case(
        "out: no such folder", (*RUN, "--out", "a/b.npz"), "a/b.npz: cannot be written: there is no folder 'a'", GIVEN
    ),
    Case("out: in a file", (*RUN, "--out", "scene.toml/b"), "there is no folder 'scene.toml'", GIVEN),
    Case("out: a folder that refuses", (*RUN, "--out", "/proc/run.npz"), "/proc/run.npz: cannot be written: ", GIVEN),
    Case("out: name without end", (*RUN, "--out", "r" * 300), "cannot be written: File name too long", GIVEN),
    Case("out: the scene", (*RUN, "--out", "scene.toml"), "scene.toml: this name is given twice", GIVEN),
    Case("out: twice", (*RUN, "--out", "a.png", "--plot", "./a.png"), "a.png: this name is given twice", GIVEN),
    Case(
        "plot: unknown suffix",
        (*RUN, "--plot", "a.bmp"),
        "a.bmp: a picture's name ends in one of: .png, .pdf, .svg",
        GIVEN,
    ),
    Case("plot: no suffix", (*RUN, "--plot", "picture"), "picture: a picture's name ends in one of: .png", GIVEN),
    Case("plot: no such folder", (*RUN, "--plot", "a/b.png"), "a/b.png: cannot be written: there is no folder", GIVEN),
    Case("html: a folder", (*RUN, "--html", "there"), "there: cannot be written", GIVEN | {"there": Path.mkdir}),
    Case("plot of a run: suffix", ("plot", "run.npz", "--out", "a.gif"), "a.gif: a picture's", {"run.npz": run_file()}),
    Case(
        "plot of a run: folder", ("plot", "run.npz", "--out", "a/b.png"), "there is no folder", {"run.npz": run_file()}
    ),
]

USAGE = [
    Case("usage: command", ("frobnicate",), "No such command 'frobnicate'; see pendpin --help", status=2),
    Case("usage: option", ("run", "--frob"), "No such option: --frob", status=2),
    Case("usage: too much", ("run", "a", "b"), "unexpected extra argument", status=2),
    Case("usage: nothing to plot", ("plot",), "Missing argument", status=2),
    Case("usage: no value", ("run", "--tolerance"), "Option '--tolerance' requires an argument", status=2),
    Case("usage: text for a number", ("run", "--tolerance", "abc"), "Invalid value for '--tolerance'", status=2),
    Case("usage: nan tolerance", ("run", "--tolerance", "nan"), "--tolerance: nan is not a finite number", status=2),
    Case("usage: tolerance 0", ("run", "--tolerance", "0"), "--tolerance: 0.0 is below 1e-14; see pendpin", status=2),
    Case("usage: method", ("run", "--method", "magic"), "--method: 'magic' is not one of: auto, dop853", status=2),
    Case("usage: no states", ("check", "--states", "0"), "Invalid value for '--states'", status=2),
    Case("usage: negative seed", ("check", "--seed", "-1"), "Invalid value for '--seed'", status=2),
    Case("usage: scene and URDF", ("check", "a.toml", "--urdf", "b"), "give a scene or a URDF, not both", status=2),
    Case("usage: escape codes", ("\x1b[31m",), "No such command", status=2),
]


def _cases() -> list[Case]:
    commands: dict[str, tuple[str, ...]] = {
        "plot": ("plot", "run.npz"),
        "view": ("view", "run.npz", "--html", "run.html"),
    }
    cases = [
        Case(f"{command}: {name}", arguments, says, {"run.npz": run})
        for name, (run, says) in RUNS.items()
        for command, arguments in commands.items()
    ]
    missing = [
        Case(f"{c}: missing", a, "run.npz: cannot be read: No such file or directory") for c, a in commands.items()
    ]
    viewed = [
        Case(f"view: {name}", commands["view"], says, {"run.npz": run_file(meta=meta(scene=scene))})
        for name, (scene, says) in VIEWED.items()
    ]
    return [*cases, *missing, *viewed, *TARGETS, *USAGE]


CASES = _cases()
