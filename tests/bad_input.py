"""What the tests of bad and odd input share: a good URDF, a good scene, and the command run as a user would."""

import re
import sys
import tomllib
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from unittest.mock import patch

from pendpin.cli import main

Content = str | bytes | Callable[[Path], object]  # text, bytes, or what makes the file

ROD = """<?xml version="1.0"?>
<robot name="rod">
  <link name="support"/>
  <joint name="theta" type="revolute">
    <parent link="support"/><child link="cross"/>
    <origin xyz="0 0 0.5" rpy="0 0 0"/>
    <axis xyz="-1 0 0"/>
    <limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/>
  </joint>
  <link name="cross"/>
  <joint name="phi" type="revolute">
    <parent link="cross"/><child link="rod"/>
    <axis xyz="0 -1 0"/>
    <limit lower="-2e9" upper="2e9" effort="2e9" velocity="2e9"/>
  </joint>
  <link name="rod">
    <inertial>
      <origin xyz="0 0 -0.5"/>
      <mass value="1.0"/>
      <inertia ixx="0.0834" ixy="0" ixz="0" iyy="0.0834" iyz="0" izz="0.0002"/>
    </inertial>
    <visual><origin xyz="0 0 -0.5"/><geometry><cylinder radius="0.01" length="1.0"/></geometry></visual>
  </link>
  <joint name="mount" type="fixed"><parent link="rod"/><child link="tip"/><origin xyz="0 0 -1"/></joint>
  <link name="tip"/>
</robot>
"""

SCENE = """duration = 0.1
[model]
kind = "chain"
rods = [{ length = 1.0, mass = 1.0, radius = 0.01 }]
[start]
positions = { theta_1 = 0.7, phi_1 = 0.4 }
[[effects]]
kind = "gravity"
[solver]
tolerance = 1e-8
"""

URDF_SCENE = """duration = 0.1
model = { kind = "urdf", path = "rod.urdf" }
start.positions = [0.7, 0.4]
effects = [{ kind = "gravity" }]
solver.tolerance = 1e-8
"""

FACT = re.compile(
    r"""(?x)
    '[^']*' | <\w+/?>?  # what is quoted, an element of a URDF
    | [^\s:]+(?=:)  # a key path or a file, in front of what is wrong with it
    | (?<!\w)--?\w[\w-]*  # an option or a negative number
    | \b(?:missing|unknown|twice|negative|pipe|device|folder|loop|deep|larger|DOCTYPE|XML|TOML|UTF-8)\b  # what is wrong
    | [\w.]*\d[\w.+-]*  # a number, a name with one
    """
)


@dataclass(frozen=True)
class Case:
    """Input that a command refuses, or takes although it looks odd."""

    name: str
    arguments: tuple[str, ...]
    says: str  # a part of the message; its facts have to be in it, in this order, its other words may be mended
    files: Mapping[str, Content] = field(default_factory=dict)
    status: int = 1

    def __str__(self) -> str:
        return self.name

    @property
    def facts(self) -> list[str]:
        """Key paths, values, names, units of code and options in `says`; the whole of it where it has none."""
        return FACT.findall(self.says) or [self.says]

    def is_said(self, message: str) -> bool:
        """Whether all facts stand in a message, in their order."""
        place = 0
        for fact in self.facts:
            place = message.find(fact, place) + len(fact)
            if place < len(fact):
                return False
        return True

    def lay_out(self, folder: Path) -> None:
        """Write the files of the case into a folder."""
        for name, content in self.files.items():
            if callable(content):
                content(folder / name)
            else:
                (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)


def edited(text: str, *edits: tuple[str, str]) -> str:
    """Text with parts replaced, every one of which is in it."""
    for old, new in edits:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


def run_main(*arguments: str) -> int:
    """The exit status of `pendpin ARGUMENTS`, in this process. Warnings are faults: a user would see them."""
    with patch.object(sys, "argv", ["pendpin", *arguments]), warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            main()
        except SystemExit as end:
            return int(end.code or 0)
    return 0


def contents(folder: Path) -> dict[str, bytes | None]:
    """Everything below a folder: bytes of the files, None for folders."""
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


assert tomllib.loads(SCENE)


class AtOnce:
    """In the place of threading.Timer: it rings when it is started, so that no test waits for a clock."""

    daemon = True

    def __init__(self, limit: float, interrupt: Callable[[], object]) -> None:
        self.start, self.cancel = interrupt, lambda: None
