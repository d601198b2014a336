"""The options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

SceneFile = Annotated[Path | None, typer.Argument(help="Scene file (TOML); the built-in single rod if absent.")]
UrdfFile = Annotated[
    str | None,
    typer.Option(metavar="FILE|NAME", help="A URDF, or a robot by name such as ur5, under gravity, from rest."),
]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Another value in the scene: model.rods[0].mass=2."),
]
Lock = Annotated[list[str] | None, typer.Option(help="NAME=POSITION freezes a joint of the URDF, in rad or m.")]
Mimic = Annotated[str | None, typer.Option(help="Joints of the URDF with <mimic>: free or locked.")]
Strict = Annotated[bool, typer.Option("--strict", help="Refuse a model with findings: inertia that no real body has.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]
