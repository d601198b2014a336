"""What commands read: scenes with what the options change in them, and what is odd in a scene."""

import tomllib
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, BadParameter, Option

from pendpin.cli.outputs import say
from pendpin.errors import InputError, amount, inside

if TYPE_CHECKING:
    from pendpin.scene import Scene

MOST_NOTES = 12  # lines before a table


@dataclass(frozen=True)
class SceneInput:
    """The scene that the options of a command describe, and where it comes from."""

    scene: "Scene"
    path: Path | None
    urdf: str | None
    strict: bool

    @property
    def files(self) -> list[Path | None]:
        """The files that are read, None for each that is left out: none of them may be written."""
        tracks = [getattr(effect, "csv", None) for effect in self.scene.effects]
        return [self.path, getattr(self.scene.model, "path", None), *tracks]

    @contextmanager
    def noted(self) -> Iterator["Scene"]:
        """The scene, after what is odd in its model: findings, which `strict` refuses, and notes; errors inside name it."""
        from pendpin.model.build import build
        from pendpin.model.notes import notes

        with inside(str(self.urdf or self.path or "the built-in rod")):
            model = build(self.scene.model)
            if self.strict and model.findings:
                more = f" (the first of {len(model.findings)} findings)" * (len(model.findings) > 1)
                raise InputError(f"{model.findings[0]}{more}; --strict refuses this")
            if model.findings:
                others = len(model.findings) - 1
                more = f"; {amount(others, 'more finding')} in bind(scene).model.findings" if others else ""
                say(f"pendpin: finding: {model.findings[0]}{more}")
            said = notes(self.scene, model)
            for note in said[:MOST_NOTES]:
                say(f"pendpin: note: {note}")
            if len(said) > MOST_NOTES:
                say(f"pendpin: note: {len(said) - MOST_NOTES} more notes; bind(scene).model.notes has them all")
            yield self.scene


def on_scene(command: Callable[..., None]) -> Callable[..., None]:
    """A command that takes a SceneInput first, as typer sees it: with the options that describe the scene in its place."""

    def run(
        scene: SceneFile = None,
        urdf: UrdfFile = None,
        lock: Lock = None,
        mimic: Mimic = None,
        as_written: AsWritten = False,
        strict: Strict = False,
        changes: Changes = None,
        **options: Any,
    ) -> None:
        from pendpin.effects import AsWritten, Gravity
        from pendpin.scene import Scene, UrdfModel, builtin_scene, load_scene

        if scene is not None and urdf is not None:
            raise BadParameter("give a scene or a URDF, not both")
        if urdf == "":
            raise BadParameter("the name of the URDF is empty", param_hint="--urdf")
        if as_written and scene is None and urdf is None:
            raise BadParameter("the built-in rod has no damping, friction or limits; --as-written needs --urdf FILE")
        if urdf:
            chosen = Scene(model=UrdfModel(urdf), effects=(Gravity(),))
        else:
            chosen = builtin_scene() if scene is None else load_scene(scene)
        if as_written and not isinstance(chosen.model, UrdfModel):
            raise BadParameter("the model is a chain of rods; --as-written is for a URDF")
        if as_written and not any(isinstance(effect, AsWritten) for effect in chosen.effects):
            chosen = chosen.replace(effects=(*chosen.effects, AsWritten()))
        if lock or mimic is not None:
            chosen = _lock_joints(chosen, lock or (), mimic)
        values = once_each(map(_change, changes or ()), "--set")
        if scene is None and urdf is None and any(path.startswith("model.rods") for path in values):
            said = "the built-in rod is a URDF; `pendpin new > rod.toml` writes it as a scene with model.rods"
            raise BadParameter(said, param_hint="--set")
        command(SceneInput(chosen.replace(values), scene, urdf, strict), **options)

    *shared, _ = signature(run).parameters.values()
    _, *further = (option.replace(kind=option.KEYWORD_ONLY) for option in signature(command).parameters.values())
    wrapped: Any = wraps(command)(run)
    wrapped.__signature__ = signature(command).replace(parameters=[*shared, *further])
    return wrapped


def _lock_joints(scene: "Scene", lock: Sequence[str], mimic: str | None) -> "Scene":
    from pendpin.scene import UrdfModel

    if not isinstance(scene.model, UrdfModel):
        raise BadParameter("the model is a chain of rods; --lock and --mimic are for the joints of a URDF")
    pairs = []
    for text in lock:
        name, _, position = text.rpartition("=")
        try:
            pairs.append((name, float(position)))
        except ValueError:
            raise BadParameter(f"{text!r} is not NAME=POSITION, such as elbow=0.5", param_hint="--lock") from None
    settings = {"lock": dict(scene.model.lock) | once_each(pairs, "--lock")}
    try:
        model = UrdfModel(**(scene.model.model_dump() | settings | ({"mimic": mimic} if mimic is not None else {})))
    except InputError as error:
        raise BadParameter(str(error).removeprefix("UrdfModel: ")) from None
    return scene.model_copy(update={"model": model})


def _change(text: str) -> tuple[str, Any]:
    """The key path and the value of KEY=VALUE: a value as in TOML, or text without quotes."""
    path, equals, value = text.partition("=")
    if not equals:
        raise BadParameter(f"{text!r} is not KEY=VALUE, such as model.rods[0].mass=2", param_hint="--set")
    try:
        return path.strip(), tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return path.strip(), value.strip()


def with_duration(scene: "Scene", duration: float | None, samples: int | None) -> "Scene":
    """A scene with the duration and samples of the options."""
    changes = {"duration": duration, "solver.samples": samples}
    for path, value in changes.items():
        try:
            scene = scene if value is None else scene.replace({path: value})
        except InputError as error:
            reason = str(error).removeprefix("Scene: ").rsplit(f"{path}: ", 1)[-1]
            raise BadParameter(reason, param_hint=f"--{path.removeprefix('solver.')}") from None
    return scene


@contextmanager
def naming_options(*options: str) -> Iterator[None]:
    """What raises InputError `name: reason` in the block is wrong usage of --name, if that is one of some options."""
    try:
        yield
    except InputError as error:
        name, reason = str(error).removeprefix("--").partition(": ")[::2]
        if options and name not in options:
            raise
        raise BadParameter(reason, param_hint=f"--{name}") from None


def once_each(pairs: Iterable[tuple[str, Any]], option: str) -> dict[str, Any]:
    """Values by name, from an option that may be repeated. Raises BadParameter for a name that is given twice."""
    named = dict[str, Any]()
    for name, value in pairs:
        if name in named:
            raise BadParameter(f"{name} is given twice; give it once", param_hint=option)
        named[name] = value
    return named


def refuse_alone(given: Any, option: str, needed: str) -> None:
    """Raise BadParameter for an option that is given without the one that it belongs to."""
    if given:
        raise BadParameter(f"it does nothing without {needed}", param_hint=option)


def split_at_commas(texts: Sequence[str] | None) -> list[str]:
    """The names in all texts of an option that may be repeated, each with one name or several between commas."""
    return [name.strip() for text in texts or () for name in text.split(",")]


# --- the options that several commands share ------------------------------------------------------------------------


def path(text: str) -> Path:  # older typers show its name as the type in the help
    """The path of a scene file. Raises BadParameter for an empty name, of which Path makes the working folder."""
    if not text:
        raise BadParameter("the name of the scene file is empty")
    return Path(text)


SceneFile = Annotated[Path | None, Argument(parser=path, help="Scene file (TOML); the built-in single rod if absent.")]
UrdfFile = Annotated[
    str | None, Option(metavar="FILE|NAME", help="A URDF, or a robot such as ur5, in gravity, from rest.")
]
SET = "Change a value of the scene, such as model.rods[0].mass=2."
Changes = Annotated[list[str] | None, Option("--set", metavar="KEY=VALUE", help=SET)]
Lock = Annotated[list[str] | None, Option(metavar="NAME=POSITION", help="Freeze a joint of the URDF; in rad or m.")]
Mimic = Annotated[str | None, Option(metavar="free|locked", help="Joints of the URDF with <mimic>.")]
AsWritten = Annotated[bool, Option("--as-written", help="Damping, friction and limits act as the URDF writes them.")]
Strict = Annotated[bool, Option("--strict", help="Refuse a model with findings: impossible inertia, slips in names.")]
Method = Annotated[str | None, Option(help="Integration method, such as dop853.")]
Tolerance = Annotated[float | None, Option(help="Relative and absolute tolerance of a step.")]
Accuracy = Annotated[float | None, Option(help="Target accuracy: largest tip error divided by the chain's length.")]
Plot = Annotated[Path | None, Option(help="Figure: .png, .pdf or .svg.")]
Limit = Annotated[float | None, Option(min=0, help="Stop after this time in s, and say what it was doing.")]
Json = Annotated[bool, Option("--json", help="Print JSON instead of a table.")]
