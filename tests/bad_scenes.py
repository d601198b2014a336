"""Scene files that pendpin refuses, each with a part of what it says."""

import os
from pathlib import Path

from bad_input import SCENE, Case, Content, edited

DURATION, MODEL, ROD = "duration = 0.1", 'kind = "chain"', "{ length = 1.0, mass = 1.0, radius = 0.01 }"
KIND, TOLERANCE, POSITIONS = 'kind = "gravity"', "tolerance = 1e-8", "{ theta_1 = 0.7, phi_1 = 0.4 }"
ENDLESS = "9" * 5000

TOP = {
    "negative duration": (DURATION, "duration = -1", "scene.toml: duration: -1 is below 0"),
    "nan duration": (DURATION, "duration = nan", "scene.toml: duration: nan is not a finite number"),
    "duration beyond a double": (DURATION, "duration = 1e400", "duration: inf is not a finite number"),
    "endless duration": (DURATION, "duration = 1e300", "duration: 1e+300 is above 1e+150"),
    "too long without samples": (DURATION, "duration = 1e9", "1e+09 s at 60 samples a second are more than 2000000"),
    "duration as text": (DURATION, 'duration = "1"', "scene.toml: duration: '1' is not a number"),
    "duration as bool": (DURATION, "duration = true", "scene.toml: duration: True is not a number"),
    "400 digits": (DURATION, f"duration = {'9' * 400}", "duration: a number of 400 digits is beyond double precision"),
    "5,000 digits": (DURATION, f"duration = {ENDLESS}", "a whole number has thousands of digits"),
    "decimal comma": (DURATION, "duration = 1,5", "scene.toml: not a TOML file: Expected newline"),
    "no value": (DURATION, "duration =", "scene.toml: not a TOML file: Invalid value (at line 1"),
    "key twice": (DURATION, "duration = 1\nduration = 1", "not a TOML file: Cannot overwrite a value (at line 2"),
    "unknown key": (DURATION, "durations = 1", "scene.toml: durations: unknown key"),
    "key of no letters": (DURATION, '"" = 1', "scene.toml: '': unknown key"),
    "unknown key with control characters": (
        DURATION,
        r'"a\u001b[31m\nb" = 1',
        r"scene.toml: 'a\x1b[31m\nb': unknown key",
    ),
}

MODELS = {
    "no model": ('[model]\nkind = "chain"\nrods =', "rods =", "scene.toml: rods: unknown key; there are: title"),
    "unknown model": (MODEL, 'kind = "robot"', "model.kind: 'robot' is not one of: chain, urdf"),
    "model without kind": (MODEL, "", "model.kind: missing; it is one of: chain, urdf"),
    "kind as number": (MODEL, "kind = 3", "model.kind: '3' is not one of: chain, urdf"),
    "no rods": (ROD, "", "model.rods: 0 values, where at least 1 are wanted"),
    "rods as number": (f"[{ROD}]", "3", "model.rods: 3 is not a list"),
    "rod as number": (ROD, "3", "model.rods[0]: 3 is not a table"),
    "no length": ("length = 1.0, ", "", "model.rods[0].length: missing"),
    "length 0": ("length = 1.0", "length = 0", "model.rods[0].length: 0 is not above 0"),
    "negative mass": ("mass = 1.0", "mass = -1.0", "model.rods[0].mass: -1.0 is below 0"),
    "no mass at all": ("mass = 1.0", "mass = 0.0", "model.rods[0]: a rod needs a mass or a payload above 0"),
    "denormal rod": (
        ROD,
        "{ length = 5e-324, mass = 1 }",
        "model.rods[0]: the inertia about the joint, 0 kg m², is out of",
    ),
    "huge rod": ("length = 1.0", "length = 1e200", "model.rods[0].length: 1e+200 is above 1e+100"),
    "huge inertia": ("length = 1.0", "length = 1e90", "model.rods[0]: the inertia about the joint, "),
    "negative radius": ("radius = 0.01", "radius = -0.01", "model.rods[0].radius: -0.01 is below 0"),
    "unknown rod key": ("radius = 0.01", "diameter = 0.02", "model.rods[0].diameter: unknown key"),
    "negative inertia": ("radius = 0.01", "inertia = [1, 1, -1]", "model.rods[0].inertia[2]: -1 is below 0"),
    "inertia of two": ("radius = 0.01", "inertia = [1, 1]", "model.rods[0].inertia[2]: missing"),
    "inertia of four": (
        "radius = 0.01",
        "inertia = [1, 1, 1, 1]",
        "model.rods[0].inertia: 4 values, where 3 are wanted",
    ),
    "nothing about the joint": (
        "radius = 0.01",
        "com = 0, inertia = [0, 0, 0]",
        "a centre of mass away from its joint",
    ),
    "negative payload": ("radius = 0.01", "payload = -1", "model.rods[0].payload: -1 is below 0"),
    "no copies": (MODEL, f"{MODEL}\ncopies = 0", "model.copies: 0 is below 1"),
    "copies and a half": (MODEL, f"{MODEL}\ncopies = 1.5", "model.copies: 1.5 is not a whole number"),
    "copies as bool": (MODEL, f"{MODEL}\ncopies = true", "model.copies: True is not a whole number"),
    "10^30 copies": (MODEL, f"{MODEL}\ncopies = 1{'0' * 30}", "model.copies: 1000"),
    "too many rods in all": (
        f"[{ROD}]",
        f"[{f'{ROD},' * 50}]\ncopies = 90000",
        "model: 4500000 rods",
    ),
    "urdf without path": (SCENE, '[model]\nkind = "urdf"', "scene.toml: model: a URDF needs a path or a name"),
    "path as number": (SCENE, '[model]\nkind = "urdf"\npath = 3', "scene.toml: model.path: 3 is not a path"),
    "path with a null byte": (
        SCENE,
        '[model]\nkind = "urdf"\npath = "a\\u0000b"',
        r"a\x00b: cannot be read: a null byte in the path",
    ),
    "path of a folder": (SCENE, '[model]\nkind = "urdf"\npath = ""', ".: cannot be read: it is a folder, not a file"),
    "path without end": (SCENE, f'[model]\nkind = "urdf"\npath = "{"p" * 5000}"', "cannot be read: File name too long"),
    "model as number": ('[model]\nkind = "chain"\nrods =', "model = 3\nx =", "model: 3 is not a table with a `kind`"),
}

REST = {
    "unknown joint": ("theta_1", "theta_9", "scene.toml: start.positions: joint 'theta_9' is not one of: theta, phi"),
    "wrong count": (POSITIONS, "[0.7]", "scene.toml: start.positions: a list of 1, where the model has 2 joints"),
    "nan in a list": (POSITIONS, "[0, nan]", "start.positions[1]: nan is not a finite number"),
    "start as text": (POSITIONS, '"up"', "start.positions: 'up' is not a list"),
    "angle as text": ("theta_1 = 0.7", 'theta_1 = "40°"', "'40°' is not a number; for numbers in degrees write unit"),
    "nested start": ("theta_1 = 0.7", "theta_1.x = 0.7", "start.positions.theta_1: {'x': 0.7} is not a number"),
    "unknown start": ("positions", "angles", "start.angles: unknown key"),
    "start as number": (f"[start]\npositions = {POSITIONS}", "[[start]]", "start: [{}] is not a table"),
    "unknown effect": (KIND, 'kind = "gravty"', "effects[0].kind: 'gravty' is not one of: gravity"),
    "effect without kind": (KIND, "", "effects[0].kind: missing; it is one of: gravity"),
    "unknown effect key": (KIND, f"{KIND}\ng = 9.81", "effects[0].g: unknown key"),
    "no direction": (KIND, f"{KIND}\ndirection = [0, 0, 0]", "effects[0].direction: a direction needs a length"),
    "negative gravity": (KIND, f"{KIND}\nacceleration = -9.81", "effects[0].acceleration: -9.81 is below 0"),
    "too much gravity": (
        KIND,
        f"{KIND}\nacceleration = 1e150",
        "scene.toml: start: positions, rates, forces or energies",
    ),
    "angles lost in rounding": (
        "theta_1 = 0.7",
        "theta_1 = 9007199254740993",
        "start.positions.theta: 9.0072e+15 is beyond 1e+09: doubles",
    ),
    "huge rate": ("positions = {", "velocities = { phi_1 = 1e90 }\npositions = {", "too large to compute with"),
    "unknown method": (TOLERANCE, 'method = "magic"', "solver.method: 'magic' is not one of: auto, dop853, rk45"),
    "tolerance 0": (TOLERANCE, "tolerance = 0", "solver.tolerance: 0 is below 1e-14"),
    "large tolerance": (TOLERANCE, "tolerance = 1", "solver.tolerance: 1 is above 0.1"),
    "no samples": (TOLERANCE, "samples = 0", "solver.samples: 0 is below 1"),
    "one sample": (TOLERANCE, "samples = 1", "solver.samples: 1 is the start alone; a run has 2 or more"),
    "too many samples": (TOLERANCE, "samples = 3000000", "solver.samples: 3000000 is above 2000000"),
    "samples of no time": (SCENE, SCENE.replace("0.1", "0", 1) + "samples = 3", "a duration of 0 has 1 sample"),
    "unknown solver key": (TOLERANCE, "tol = 1e-8", "solver.tol: unknown key"),
    "solver as text": ("[solver]\n" + TOLERANCE, 'x = "y"', "effects[0].x: unknown key"),
    "three faults": (f"{DURATION}\n", "a = 1\nb = 2\nc = 3\n", "start, effects, solver, data; 2 other faults: b, c"),
    "what is missing then": (
        ROD,
        ROD.replace("mass", "mas"),
        "model.rods[0].mas: unknown key; did you mean 'mass'?; another fault: model.rods[0].mass is missing",
    ),
    "effects as table": (
        "[[effects]]",
        "[effects]",
        "effects: {'kind': 'gravity'} is a table, not a list; a list of tables begins with [[effects]]",
    ),
    "damping": (KIND, 'kind = "damping"', "as_written; did you mean 'viscous'?"),
    "key that is like no other": (TOLERANCE, "zzz = 1", "solver.zzz: unknown key; there are: method, engine"),
}

WHOLE: dict[str, tuple[Content, str]] = {
    "empty": ("", "scene.toml: it is empty; `pendpin new` prints a scene to start from"),
    "comment only": ("# nothing\n", "scene.toml: it is empty; `pendpin new` prints"),
    "effects as number": ("effects = 3\n" + SCENE.replace("[[effects]]\n" + KIND, ""), "effects: 3 is not a list"),
    "effect in a list as number": (
        "effects = [3]\n" + SCENE.replace("[[effects]]\n" + KIND, ""),
        "effects[0]: 3 is not a table with a `kind`",
    ),
    "solver as number": ("solver = 3\n" + SCENE.split("[solver]")[0], "solver: 3 is not a table"),
    "binary": (bytes(range(256)) * 40, "scene.toml: not a TOML file: "),
    "not UTF-8": (SCENE.encode() + b"# \xff\xfe", "is not UTF-8 text"),
    "UTF-16": (SCENE.encode("utf-16"), "scene.toml: not a TOML file: byte 0 is not UTF-8 text"),
    "truncated": (SCENE[:70], "scene.toml: not a TOML file: "),
    "a URDF": (
        "<?xml version='1.0'?><robot/>",
        "this is XML, not a scene; if it is a URDF: pendpin run --urdf scene.toml",
    ),
    "JSON": ('{"duration": 1}', "scene.toml: not a TOML file: Invalid statement (at line 1, column 1)"),
    "10 MB": ("#" * 10_000_000, "scene.toml: larger than the 0.5 MB that a scene may have"),
    "nested 10,000 deep": (f"x = {'[' * 10_000}{']' * 10_000}", "scene.toml: not a scene: values are nested too deep"),
    "tables 10,000 deep": (f"{'.'.join('a' * 100_000)} = 1", "scene.toml: not a scene: keys are nested too deep"),
    "tables 10,000 deep, quoted": ('"a b".' * 10_000 + "c = 1", "keys are nested too deep"),
    "nested 400 deep": (f"{SCENE}x = {'[' * 400}{']' * 400}", "scene.toml: solver.x: unknown key"),
    "40,000 unknown keys": (
        "".join(f"k{i} = 1\n" for i in range(40_000)),
        "start, effects, solver, data; 40000 other faults: model, k1, k10, ...",
    ),
    "a pipe": (os.mkfifo, "scene.toml: cannot be read: it is a pipe, not a file"),
    "a device": (lambda path: path.symlink_to("/dev/zero"), "scene.toml: cannot be read: it is a device, not a file"),
    "a folder": (Path.mkdir, "scene.toml: cannot be read: it is a folder, not a file"),
}


CSVS: dict[str, tuple[Content, str]] = {
    "header only": ("t,x,y,z\n", "0 rows, where at least 2 are wanted"),
    "null bytes": (b"\0" * 5000, "line 1: 1 value instead of 4"),
    "unit": ("0,0,0,0\n1,1m,0,0\n", "line 2: x: '1m' is not a number"),
    "from one end of time to the other": ("-1e308,0,0,0\n1e308,0,0,0\n", "line 1: t: '-1e308' is beyond 1e+150"),
    "too fast": ("0,0,0,0\n1e-160,1,0,0\n2e-160,0,0,0\n", "its positions are too large, or too close in time"),
    "quoted": ('"0","0","0","0"\n"1","0","0","0"\n', "line 1: t: '\"0\"' is not a number"),
    "null byte in a row": ("0,0,0,0\n1,0\0,0,0\n", r"line 2: x: '0\x00' is not a number"),
    "UTF-16": ("0,0,0,0\n1,0,0,0\n".encode("utf-16"), "not a CSV file: byte 0 is not UTF-8 text"),
    "underscores": ("0,0,0,0\n1_0,0,0,0\n", "line 2: t: '1_0' is not a finite number"),
    "a cell without end": (f"0,0,0,0\n1,{'9' * 1_000_000},0,0\n", "line 2: x: '999"),
    "a pipe": (os.mkfifo, "path.csv: cannot be read: it is a pipe, not a file"),
    "10 MB": ("#" * 10_000_000, "larger than the 5 MB that a CSV of positions may have"),
    "a folder": (Path.mkdir, "cannot be read: it is a folder, not a file"),
}
MOVED = edited(SCENE, (KIND, 'kind = "support"\ncsv = "path.csv"'))


def _cases() -> list[Case]:
    bad: dict[str, tuple[Content, str]] = {
        name: (edited(SCENE, (old, new)), says) for name, (old, new, says) in (TOP | MODELS | REST).items()
    } | WHOLE
    cases = [
        Case(f"scene: {name}", ("run", "scene.toml"), says, {"scene.toml": scene})
        for name, (scene, says) in bad.items()
    ]
    return [
        *cases,
        Case("scene: missing", ("run", "scene.toml"), "scene.toml: cannot be read: No such file or directory"),
        *(
            Case(f"csv: {name}", ("run", "scene.toml"), says, {"scene.toml": MOVED, "path.csv": csv})
            for name, (csv, says) in CSVS.items()
        ),
        Case("csv: missing", ("run", "scene.toml"), "cannot be read: No such file or directory", {"scene.toml": MOVED}),
        Case("scene: missing, to check", ("check", "scene.toml"), "scene.toml: cannot be read: No such file"),
        Case("scene: name without end", ("run", "s" * 5000), "cannot be read: File name too long"),
        Case("scene: escape codes in its name", ("run", "\x1b[31m\n.toml"), r"\x1b[31m .toml: cannot be read"),
    ]


CASES = _cases()
