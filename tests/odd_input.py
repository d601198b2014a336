"""Input that looks odd and is right: URDFs, scenes and names of files that pendpin takes."""

import os

from bad_input import ROD, SCENE, URDF_SCENE, Case, Content, edited

INERTIAL = ROD[ROD.index("<inertial>") : ROD.index("<visual>")]
LIMIT = '<limit lower="-2e9" upper="2e9" effort="2e9" velocity="2e9"/>'
POINT = '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
INERTIA = ROD[ROD.index("<inertia ixx") : ROD.index("</inertial>")].strip()
VISUAL = '<cylinder radius="0.01" length="1.0"/>'
END = "</robot>"
FOREIGN = """<gazebo reference="rod"><mu1>zero</mu1></gazebo>
<transmission name="t"><type>x</type><joint name="nobody"/></transmission>
<ros2_control name="c" type="system"><joint name="theta"/></ros2_control><unknown><link/><joint/></unknown></robot>"""

URDFS: dict[str, tuple[tuple[str, str], ...]] = {
    "continuous joints": (('type="revolute"', 'type="continuous"'), ('type="revolute"', 'type="continuous"')),
    "continuous without limit": (('name="phi" type="revolute"', 'name="phi" type="continuous"'), (LIMIT, "")),
    "axis of another length": (('xyz="0 -1 0"', 'xyz="0 -250 0"'),),
    "tiny axis": (('xyz="0 -1 0"', 'xyz="0 -5e-324 0"'),),
    "huge axis": (('xyz="0 -1 0"', 'xyz="1e308 -1e308 1e308"'),),
    "no axis": (('<axis xyz="0 -1 0"/>', ""), ('<axis xyz="-1 0 0"/>', '<axis xyz="0 1 0"/>')),
    "slanted axis": (('xyz="0 -1 0"', 'xyz="1 1 1"'),),
    "forms of numbers": (('xyz="0 0 0.5"', 'xyz=" +0. -0.0e7&#9;\n.5E0 "'), ('value="1.0"', 'value=" 1.0&#10;"')),
    "denormal numbers": (('xyz="0 0 0.5"', 'xyz="5e-324 -1e-310 1e-400"'),),
    "no robot name": (('<robot name="rod">', "<robot>"),),
    "comments": ((INERTIA, f"<!-- here -->{INERTIA}<!-- <mass value='nan'/> -->"),),
    "foreign elements": ((END, FOREIGN),),
    "elements 5,000 deep": ((END, "<a>" * 5000 + "</a>" * 5000 + END),),
    "missing texture": (("</geometry>", '</geometry><material name="m"><texture filename="gone.png"/></material>'),),
    "undefined material": (("</geometry>", '</geometry><material name="nobody"/>'),),
    "broken collision": (
        ("<visual>", '<collision><geometry><mesh filename="gone.stl"/></geometry></collision><visual>'),
    ),
    "capsule": ((VISUAL, '<capsule radius="0.01" length="1"/>'),),
    "box and sphere": ((VISUAL, '<box size="0 0.1 1"/></geometry></visual><visual><geometry><sphere radius="1"/>'),),
    "equal limits": ((LIMIT, LIMIT.replace("-2e9", "2e9")),),
    "limits left out": ((LIMIT, '<limit effort="0" velocity="0"/>'),),
    "prismatic": (('name="phi" type="revolute"', 'name="phi" type="prismatic"'),),
    "point mass": ((INERTIA, POINT),),
    "rounded inertia": (('izz="0.0002"', 'izz="0.16681"'),),
    "two inertials": (("<visual>", INERTIAL.replace("1.0", "nan") + "<visual>"),),
}

NAMES: dict[str, tuple[tuple[str, str], ...]] = {
    "link and joint": (('name="phi"', 'name="rod"'),),
    "universe": (('name="phi"', 'name="universe"'),),
    "root_joint": (('name="phi"', 'name="root_joint"'),),
    "symbols": (('name="phi"', 'name="$\\frac{$ [/red] _%d {0} &lt;b&gt; &quot;"'),),
    "hidden": (('name="phi"', 'name="_phi"'),),
    "other scripts": (('name="phi"', 'name="φ 角 🙂"'),),
    "control characters": (('name="phi"', 'name="phi&#9;&#10;&#x9b;31m"'),),
}

WHOLE_URDFS: dict[str, Content] = {
    "UTF-8 with its mark": ROD.encode("utf-8-sig"),
    "UTF-16": ROD.encode("utf-16"),
    "Latin-1": edited(
        ROD, ('version="1.0"', 'version="1.0" encoding="iso-8859-1"'), ("phi", "φ".encode().decode("latin-1"))
    ).encode("latin-1"),
    "lines of Windows": ROD.replace("\n", "\r\n"),
    "one line": ROD.replace("\n", " "),
    "a link to it": lambda path: [(path.parent / "real.xml").write_text(ROD), path.symlink_to("real.xml")],
    "joints before links": edited(ROD, ('<link name="support"/>', ""), (END, '<link name="support"/></robot>')),
}

ROD_LINE = "{ length = 1.0, mass = 1.0, radius = 0.01 }"
POSITIONS, KIND, TOLERANCE = "{ theta_1 = 0.7, phi_1 = 0.4 }", 'kind = "gravity"', "tolerance = 1e-8"
SCENES: dict[str, tuple[tuple[str, str], ...]] = {
    "whole numbers": ((ROD_LINE, "{ length = 1, mass = 2, radius = 0 }"), ("0.1", "1"), ("0.7", "1")),
    "names without _1": (("theta_1", "theta"), ("phi_1", "phi")),
    "a full list": ((POSITIONS, "[0.7, -0.0]"),),
    "an empty table": ((POSITIONS, "{}"),),
    "minus zero": (("radius = 0.01", "radius = -0.0"), ("0.7", "-0.0")),
    "denormal angle": (("0.7", "5e-324"),),
    "large angle": (("0.7", "1e6"),),
    "2^53 kg": (("mass = 1.0", "mass = 9007199254740993"),),
    "no effects": (("[[effects]]\n" + KIND, ""), ("duration", "effects = []\nduration")),
    "two gravities": ((KIND, f"{KIND}\n[[effects]]\n{KIND}\ndirection = [1, 0, 0]"),),
    "tiny direction": ((KIND, f"{KIND}\ndirection = [0, 5e-324, -5e-324]"),),
    "huge direction": ((KIND, f"{KIND}\ndirection = [1e150, 1e150, -1e150]"),),
    "no gravity at all": ((KIND, f"{KIND}\nacceleration = 0"),),
    "no time": (("duration = 0.1", "duration = 0"),),
    "no time, one sample": (("duration = 0.1", "duration = 0"), (TOLERANCE, "samples = 1")),
    "two samples": ((TOLERANCE, "samples = 2"),),
    "denormal time": (("duration = 0.1", "duration = 5e-324\nsolver.samples = 2"), ("[solver]\n" + TOLERANCE, "")),
    "loosest tolerance": ((TOLERANCE, "tolerance = 0.1"),),
    "tightest tolerance": ((TOLERANCE, "tolerance = 1e-14"),),
    "point mass": ((ROD_LINE, "{ length = 1, mass = 0, payload = 1 }"),),
    "inverted": ((ROD_LINE, "{ length = 1, mass = 1, com = -0.5, inertia = [1, 1, 1] }"),),
    "tiny rod": ((ROD_LINE, "{ length = 1e-9, mass = 1e-12 }"), ("0.1", "1e-5\n")),
    "huge rod": ((ROD_LINE, "{ length = 1e6, mass = 1e9, radius = 1e3 }"),),
    "one copy": ((KIND, KIND), (ROD_LINE, ROD_LINE), ("rods", "copies = 1\nrods")),
    "twelve digits of nothing": (("0.7", "0.700_000_000_000"),),
    "comments": (("[start]", "# kind = 'robot'\n[start] # é 角 🙂"),),
}

WHOLE_SCENES: dict[str, Content] = {
    "UTF-8 with its mark": SCENE.encode("utf-8-sig"),
    "lines of Windows": SCENE.replace("\n", "\r\n"),
    "the least": 'duration = 0.1\nmodel = { kind = "chain", rods = [{ length = 1, mass = 1 }] }',
}

PLACES = {
    "spaces": "a b  c.toml",
    "another script": "маятник 振り子 🙂.toml",
    "markup": "[bold]x[red].toml",
    "not UTF-8": os.fsdecode(b"p\xff\xfe.toml"),
    "line feed": "a\nb.toml",
    "escape codes": "\x1b[31mred.toml",
    "percent and braces": "%s{0}$x$.toml",
    "longest name": "n" * 245 + ".toml",
    "no suffix": "scene",
}


def _case(name: str, scene: Content, urdf: Content = "") -> Case:
    return Case(name, ("run", "scene.toml"), "", {"scene.toml": scene, "rod.urdf": urdf}, 0)


CSV_OF_WINDOWS = "\ufefft,x,y,z\r\n# m\r\n0,0,0,0\r\n\r\n 1 ,1e-1,.2,-0\r\n".encode()
BY_CSV = edited(SCENE, (KIND, 'kind = "support"\ncsv = "path.csv"'))

CASES = [
    Case("csv: as Windows writes it", ("run", "scene.toml"), "", {"scene.toml": BY_CSV, "path.csv": CSV_OF_WINDOWS}, 0),
    *(_case(f"urdf: {name}", URDF_SCENE, edited(ROD, *edits)) for name, edits in URDFS.items()),
    *(_case(f"urdf: {name}", URDF_SCENE, urdf) for name, urdf in WHOLE_URDFS.items()),
    *(_case(f"scene: {name}", edited(SCENE, *edits)) for name, edits in SCENES.items()),
    *(_case(f"scene: {name}", scene) for name, scene in WHOLE_SCENES.items()),
    *(Case(f"place: {name}", ("run", place), "", {place: SCENE}, 0) for name, place in PLACES.items()),
]
ROTOR = edited(
    ROD,
    (ROD[ROD.index("<visual>") : ROD.index('</link>\n  <joint name="mount')], ""),
    ('<origin xyz="0 0 -0.5"/>', ""),
    (ROD[ROD.index('<joint name="mount') : ROD.index(END)], ""),
)
NAMED_CASES = [
    *(_case(f"name: {name}", URDF_SCENE, edited(ROD, *edits)) for name, edits in NAMES.items()),
    _case("urdf: a rotor without a length", URDF_SCENE, ROTOR),
    _case("scene: a disc without a length", edited(SCENE, (ROD_LINE, "{ length = 5e-324, mass = 1, radius = 0.1 }"))),
]
