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
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the scene, such as model.rods[0].mass=2."),
]
Lock = Annotated[list[str] | None, typer.Option(help="Freeze a joint of the URDF: NAME=POSITION, in rad or m.")]
Mimic = Annotated[str | None, typer.Option(help="Joints of the URDF with <mimic>: free or locked.")]
AsWritten = Annotated[
    bool, typer.Option("--as-written", help="Damping, friction and limits of the URDF act as its file writes them.")
]
Strict = Annotated[
    bool, typer.Option("--strict", help="Refuse a model with findings: impossible inertia, slips in names.")
]
Method = Annotated[str | None, typer.Option(help="Integration method, such as dop853.")]
Tolerance = Annotated[float | None, typer.Option(help="Relative and absolute tolerance of a step.")]
Accuracy = Annotated[
    float | None, typer.Option(help="Target accuracy: largest tip error divided by the chain's length.")
]
Plot = Annotated[Path | None, typer.Option(help="Figure: .png, .pdf or .svg.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]
