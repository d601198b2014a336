"""URDFs that pendpin refuses, each with a part of what it says."""

import os
from pathlib import Path

from bad_input import ROD, URDF_SCENE, Case, Content, edited

MASS, INERTIA, AXIS = '<mass value="1.0"/>', 'ixx="0.0834"', '<axis xyz="0 -1 0"/>'
LIMIT = '<limit lower="-2e9" upper="2e9" effort="2e9" velocity="2e9"/>'
PARENT, LINK = '<parent link="cross"/>', '<link name="cross"/>'
VISUAL = '<cylinder radius="0.01" length="1.0"/>'
END = "</robot>"
LOOP = '<joint name="back" type="fixed"><parent link="tip"/><child link="support"/></joint></robot>'
RING = (
    '<link name="a"/><link name="b"/><joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>'
    '<joint name="ba" type="fixed"><parent link="b"/><child link="a"/></joint></robot>'
)
LAUGHS = (
    '<!DOCTYPE robot [<!ENTITY a "ha">'
    + "".join(f'<!ENTITY {new} "{f"&{old};" * 10}">' for old, new in zip("abcdefghi", "bcdefghij", strict=True))
    + "]>"
)
BOMB = LAUGHS + ROD.split("?>", 1)[1].replace('name="rod"', 'name="&j;"', 1)

NUMBERS = {
    "nan mass": (MASS, '<mass value="nan"/>', "link 'rod': mass value: 'nan' is not a number"),
    "infinite mass": (MASS, '<mass value="inf"/>', "link 'rod': mass value: 'inf' is not a number"),
    "decimal comma": (MASS, '<mass value="1,5"/>', "link 'rod': mass value: '1,5' is not a number"),
    "mass with a unit": (MASS, '<mass value="1.0kg"/>', "link 'rod': mass value: '1.0kg' is not a number"),
    "mass beyond a double": (
        MASS,
        '<mass value="1e400"/>',
        "mass value: '1e400' is too large to compute with; the most is 1e+100",
    ),
    "denormal mass": (
        MASS,
        '<mass value="5e-324"/>',
        "mass 4.94066e-324 kg is too small to compute with; the least is 1e-300",
    ),
    "empty mass": (MASS, '<mass value=""/>', "link 'rod': mass value: '' is not a number"),
    "hexadecimal mass": (MASS, '<mass value="0x10"/>', "mass value: '0x10' is not a number"),
    "digits of another script": (MASS, '<mass value="١"/>', "mass value: '١' is not a number"),
    "two masses in one": (MASS, '<mass value="1 2"/>', "mass value: '1 2' is not a number"),
    "mass without value": (MASS, "<mass/>", "link 'rod': <mass> has no value"),
    "no mass": (MASS, "", "link 'rod': <inertial> has no <mass>"),
    "negative mass": (MASS, '<mass value="-1"/>', "link 'rod': mass -1 kg is negative"),
    "nan inertia": (INERTIA, 'ixx="nan"', "link 'rod': inertia ixx: 'nan' is not a number"),
    "inertia left out": (INERTIA, "", "link 'rod': <inertia> has no ixx"),
    "no inertia": ("<inertia ", "<inertial ", "link 'rod': <inertial> has no <inertia>"),
    "negative about a joint": (INERTIA, 'ixx="-0.3"', "joint 'theta' moves a negative inertia at some positions"),
    "negative about a joint at phi = 90 degrees": (
        'izz="0.0002"',
        'izz="-2e-4"',
        "joint 'theta' moves a negative inertia",
    ),
    "negative for two joints together": ('ixy="0"', 'ixy="0.5"', "moves a negative inertia at some positions"),
    "huge limit": (LIMIT, LIMIT.replace("-2e9", "-1e400"), "limit lower: '-1e400' is too large to compute with"),
    "origin of two numbers": ('xyz="0 0 0.5"', 'xyz="0 0"', "joint 'theta': origin xyz: '0 0' is not 3 numbers"),
    "origin of four numbers": ('rpy="0 0 0"', 'rpy="0 0 0 1"', "origin rpy: '0 0 0 1' is not 3 numbers"),
    "origin with commas": ('xyz="0 0 0.5"', 'xyz="0,0,0.5"', "joint 'theta': origin xyz: '0,0,0.5' is not a number"),
    "nan in an origin": ('rpy="0 0 0"', 'rpy="0 nan 0"', "joint 'theta': origin rpy: 'nan' is not a number"),
    "huge origin": (
        'xyz="0 0 -0.5"',
        'xyz="0 0 1e200"',
        "link 'rod': origin xyz: '1e200' is too large to compute with",
    ),
    "no-break spaces": ('xyz="0 0 0.5"', 'xyz="0\u00a00\u00a00.5"', "joint 'theta': origin xyz: "),
    "zero axis": (AXIS, '<axis xyz="0 0 0"/>', "joint 'phi': axis 0.0 0.0 0.0 has no direction"),
    "axis without xyz": (AXIS, "<axis/>", "joint 'phi': <axis> has no xyz"),
    "axis of two numbers": (AXIS, '<axis xyz="1 0"/>', "joint 'phi': axis xyz: '1 0' is not 3 numbers"),
    "nan axis": (AXIS, '<axis xyz="nan 0 1"/>', "joint 'phi': axis xyz: 'nan' is not a number"),
    "swapped limits": (
        LIMIT,
        LIMIT.replace("-2e9", "5e9"),
        "joint 'phi': its limits are swapped: lower 5e+09 > upper 2e+09",
    ),
    "nan limit": (LIMIT, LIMIT.replace("-2e9", "nan"), "joint 'phi': limit lower: 'nan' is not a number"),
    "no limit": (LIMIT, "", "joint 'phi': a revolute joint needs <limit"),
    "limit without effort": (LIMIT, LIMIT.replace("effort", "force"), "joint 'phi': <limit> has no effort"),
    "negative effort": (LIMIT, LIMIT.replace('effort="2e9"', 'effort="-6"'), "joint 'phi': limit effort is negative"),
    "negative damping": (LIMIT, LIMIT + '<dynamics damping="-1"/>', "joint 'phi': damping is negative"),
    "nan friction": (LIMIT, LIMIT + '<dynamics friction="x"/>', "joint 'phi': dynamics friction: 'x' is not a number"),
}

STRUCTURE = {
    "two parents": (
        '<parent link="rod"/><child link="tip"/>',
        '<parent link="support"/><child link="rod"/>',
        "two joints",
    ),
    "kinematic loop": (END, LOOP, "every link hangs on another: a kinematic loop"),
    "detached loop": (END, RING, "a kinematic loop, cut off from 'support': 'b', 'a'"),
    "link on itself": ('<parent link="rod"/>', '<parent link="tip"/>', "a kinematic loop"),
    "two roots": (END, '<link name="stray"/></robot>', "several links hang on nothing: 'support', 'stray'"),
    "unknown parent": (PARENT, '<parent link="gone"/>', "joint 'phi': its parent link 'gone' does not exist"),
    "parent with a space": (PARENT, '<parent link="cross "/>', "joint 'phi': its parent link 'cross ' does not exist"),
    "no parent": (PARENT, "", "joint 'phi': <joint> has no <parent>"),
    "parent without link": (PARENT, "<parent/>", "joint 'phi': its parent link '' does not exist"),
    "mimic of no joint": (AXIS, f"{AXIS}<mimic/>", "joint 'phi': <mimic> names no joint"),
    "nan in mimic": (
        AXIS,
        f'{AXIS}<mimic joint="theta" offset="nan"/>',
        "joint 'phi': mimic offset: 'nan' is not a number",
    ),
    "two numbers in mimic": (
        AXIS,
        f'{AXIS}<mimic joint="theta" multiplier="1 2"/>',
        "mimic multiplier: '1 2' is not a number",
    ),
    "universal joint": (
        'type="revolute"',
        'type="universal"',
        "joint 'theta': type 'universal' is not one of: revolute",
    ),
    "floating joint": ('type="revolute"', 'type="floating"', "joint 'theta': type 'floating' is not one of: revolute"),
    "no joint type": ('type="revolute"', "", "joint 'theta': type '' is not one of: revolute"),
    "same link twice": (END, '<link name="rod"/></robot>', "two links are named 'rod'"),
    "same joint twice": ('name="phi"', 'name="theta"', "two joints are named 'theta'"),
    "link without name": (LINK, "<link/>", "a <link> has no name"),
    "blank joint name": ('name="phi"', 'name=" "', "a <joint> has no name"),
    "escape codes in a name": (PARENT, '<parent link="&#x9b;31m"/>', r"its parent link '\x9b31m' does not exist"),
    "mesh without a name": (VISUAL, "<mesh/>", "link 'rod': <mesh> has no filename"),
    "no geometry": (f"<geometry>{VISUAL}</geometry>", "", "link 'rod': a visual needs a <geometry> with one of: box"),
    "unknown geometry": (VISUAL, "<cone/>", "link 'rod': a visual needs a <geometry> with one of: box"),
    "negative radius": (VISUAL, VISUAL.replace("0.01", "-1"), "link 'rod': cylinder radius: a size is negative"),
    "box of two numbers": (VISUAL, '<box size="1 1"/>', "link 'rod': box size: '1 1' is not 3 numbers"),
    "box without size": (VISUAL, "<box/>", "link 'rod': <box> has no size"),
    "capsule without radius": (VISUAL, '<capsule length="1"/>', "link 'rod': <capsule> has no radius"),
    "color by name": (
        "</geometry>",
        '</geometry><material name="m"><color rgba="red"/></material>',
        "link 'rod': visual: color rgba: 'red' is not",
    ),
    "color of two": (
        END,
        '<material name="m"><color rgba="1 0"/></material>' + END,
        "material 'm': color rgba: '1 0' is not 4",
    ),
    "truncated": (ROD[700:], "", "not well-formed XML"),
    "two documents": (END, END + ROD, "not well-formed XML: junk after document element"),
    "unknown entity": ('name="rod"', 'name="&rod;"', "not well-formed XML: undefined entity"),
    "unknown encoding": ('version="1.0"', 'version="1.0" encoding="klingon"', "not readable as XML: unknown encoding"),
    "entity bomb": (ROD, BOMB, "a URDF has no DOCTYPE and no entities"),
    "another root": ("<robot ", "<sdf ", "not well-formed XML: mismatched tag"),
    "control characters": ('name="rod"', 'name="\x1b[31m"', "not well-formed XML: (invalid token)"),
}


def chain(count: int, parent: str = "{before}") -> str:
    """A URDF of links in a row, or all on one parent."""
    inertial = ROD[ROD.index("<inertial>") : ROD.index("<visual>")]
    links = "".join(f'<link name="l{i}">{inertial}</link>' for i in range(count))
    joints = "".join(
        f'<joint name="j{i}" type="continuous"><parent link="{parent.format(before=f"l{i - 1}")}"/><child link="l{i}"/>'
        "</joint>"
        for i in range(1, count)
    )
    return f'<robot name="row">{links}{joints}</robot>'


WHOLE: dict[str, tuple[Content, str]] = {
    "empty": ("", "rod.urdf: the file is empty"),
    "blank": (" \n", "rod.urdf: the file is empty"),
    "binary": (bytes(range(256)) * 40, "rod.urdf: not well-formed XML"),
    "null bytes": (b"\0" * 5000, "rod.urdf: not well-formed XML"),
    "not XML": ("solid mesh\n facet normal 0 0 1\n", "rod.urdf: not well-formed XML"),
    "another format": (
        "<sdf version='1.6'><model name='rod'/></sdf>",
        "the root element is <sdf>; a URDF's is <robot>",
    ),
    "xacro": (
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r"><xacro:property name="m" value="1"/></robot>',
        "it is a xacro file: expand it",
    ),
    "namespace": ('<robot xmlns="urn:x"/>', "the root element is <{urn:x}robot>"),
    "no links": ("<robot/>", "rod.urdf: it has no <link>"),
    "one link": ('<robot><link name="a"/></robot>', "rod.urdf: no joint of it can move"),
    "all massless": (
        edited(chain(2), ("<inertial>", "<n>"), ("</inertial>", "</n>")).replace("inertial", "n"),
        "no inertia",
    ),
    "massless last link": (
        edited(ROD, (MASS, '<mass value="0"/>'), (INERTIA, 'ixx="0"'), ('iyy="0.0834"', 'iyy="0"'), ("0.0002", "0")),
        "joint 'theta' moves no inertia: its links are massless",
    ),
    "point mass in its axis": (
        edited(ROD, ("0 0 -0.5", "0 0 0"), (INERTIA, 'ixx="0"'), ('iyy="0.0834"', 'iyy="0"'), ("0.0002", "0")),
        "joint 'theta' moves no inertia",
    ),
    "entity bomb in UTF-16": (BOMB.encode("utf-16"), "a URDF has no DOCTYPE and no entities"),
    "another file's contents": (
        ROD.replace("<robot", '<!DOCTYPE r SYSTEM "file:///etc/passwd"><robot', 1),
        "a URDF has no DOCTYPE and no entities",
    ),
    "10 MB": (ROD + " " * 10_000_000, "rod.urdf: larger than the 8 MB that a URDF may have"),
    "5,000 links in a row": (chain(5000), "5000 links in a row"),
    "5,000 children": (chain(5000, parent="l0"), "rod.urdf: 4999 joints need about"),
    "30,000 links": ("<robot>" + "".join(f'<link name="{i}"/>' for i in range(30_000)) + "</robot>", "30000 links"),
    "a pipe": (os.mkfifo, "rod.urdf: cannot be read: it is a pipe, not a file"),
    "a folder": (Path.mkdir, "rod.urdf: cannot be read: it is a folder, not a file"),
    "a link to itself": (lambda path: path.symlink_to(path), "rod.urdf: cannot be read: Too many levels"),
    "a link to nothing": (lambda path: path.symlink_to("gone"), "rod.urdf: cannot be read: No such file"),
}


def _cases() -> list[Case]:
    bad: dict[str, tuple[Content, str]] = {
        name: (edited(ROD, (old, new)), says) for name, (old, new, says) in (NUMBERS | STRUCTURE).items()
    } | WHOLE
    run = ("run", "scene.toml")
    cases = [
        Case(f"urdf: {name}", run, says, {"scene.toml": URDF_SCENE, "rod.urdf": urdf})
        for name, (urdf, says) in bad.items()
    ]
    missing = "rod.urdf: cannot be read: No such file or directory"
    return [
        *cases,
        Case("urdf: missing", run, missing, {"scene.toml": URDF_SCENE}),
        Case("urdf: missing, to check", ("check", "--urdf", "rod.urdf"), missing),
        Case(
            "urdf: nan mass, to check",
            ("check", "--urdf", "rod.urdf"),
            "rod.urdf: link 'rod': mass value: 'nan' is not a number",
            {"rod.urdf": edited(ROD, (MASS, '<mass value="nan"/>'))},
        ),
    ]


CASES = _cases()
