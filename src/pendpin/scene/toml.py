"""Scenes as TOML text: plain data with the files that it names relative to the scene's own; the examples of pendpin."""

import re
import tomllib
from pathlib import Path
from typing import Any

from pendpin.effects import Effect, has_kind
from pendpin.errors import InputError, nearest_or_all, shown
from pendpin.ground.files import folder_of, read_whole, text_of
from pendpin.ground.records import Record
from pendpin.scene.models import PinModel, UrdfModel

MAX_SCENE_BYTES = 500_000  # more takes Python's TOML reader seconds
_DEEP_KEY = re.compile(rb"""(?<![\w-])(?:(?:[\w-]+|["'][^"'\n]*["'])[ \t]*\.[ \t]*){50}""")


def read_toml(path: Path) -> dict[str, Any]:
    """The data of a scene file, with whole paths. Raises InputError for text that is not TOML."""
    data = read_whole(path, MAX_SCENE_BYTES, "a scene")
    if data.lstrip().startswith(b"<"):
        raise InputError(f"this is XML, not a scene; if it is a URDF: pendpin run --urdf {path.name}")
    if _DEEP_KEY.search(data):  # Python's TOML reader would take minutes
        raise InputError("not a scene: keys are nested too deep")
    try:
        raw = tomllib.loads(text_of(data, "TOML"))
    except RecursionError:
        raise InputError("not a scene: values are nested too deep") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"not a TOML file: {error}") from None
    except ValueError:  # Python's own limit
        raise InputError("not a scene: a whole number has thousands of digits") from None
    if isinstance(raw.get("model"), str):
        raw["model"] = {"kind": "urdf"} | UrdfModel.from_one(raw["model"])
    effects = raw.get("effects")
    tables = [("path", raw.get("model")), *(("csv", x) for x in (effects if isinstance(effects, list) else ()))]
    for key, table in tables:
        if isinstance(table, dict) and isinstance(table.get(key), str):  # the name of a file
            table[key] = str(path.parent / table[key])
    return raw


def scene_text(scene: Record, folder: Path) -> str:
    """A scene as TOML, files below `folder` relative to it. Raises InputError for what does not go into TOML."""
    import tomlkit

    document = tomlkit.document()
    for key, value in _plain(scene, folder).items():
        if isinstance(value, dict):
            table = tomlkit.table()
            for inner, content in value.items():
                table.add(inner, _inline(content))
            document.add(key, table)
        elif key == "effects" and value:
            tables = tomlkit.aot()
            for effect in value:
                tables.append(tomlkit.item(effect))
            document.add(key, tables)
        else:
            document.add(key, tomlkit.array() if key == "effects" else value)
    return tomlkit.dumps(document)


def _plain(value: Any, folder: Path) -> Any:
    """What was given of a record, as TOML's kinds of values; files below `folder` relative to it."""
    if isinstance(value, Effect) and not has_kind(value):
        reason = f"a {type(value).__name__} cannot be written to TOML: it is code, not one of the kinds of effects"
        raise InputError(reason)
    if isinstance(value, PinModel):
        raise InputError("a pin.Model cannot be written to TOML: save its URDF, and name that")
    if isinstance(value, Record):
        return {name: _plain(inner, folder) for name, inner in value.given().items() if inner is not None}
    if isinstance(value, dict):
        return {name: _plain(inner, folder) for name, inner in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(inner, folder) for inner in value]
    if isinstance(value, Path):
        return str(value.relative_to(folder) if value.is_relative_to(folder) else value)
    if not isinstance(value, str | int | float):
        raise InputError(f"{shown(value)} cannot be written to TOML")
    return value


def _inline(value: Any) -> Any:
    import tomlkit

    if isinstance(value, dict):
        table = tomlkit.inline_table()
        table.update(value)
        return table
    if isinstance(value, list):
        array = tomlkit.array()
        array.extend(_inline(inner) for inner in value)
        return array.multiline(any(isinstance(inner, dict) for inner in value))
    return value


def example_names() -> list[str]:
    """The names of the example scenes."""
    return sorted(path.stem for path in folder_of("examples").glob("*.toml"))


def read_example(name: str) -> tuple[str, list[Path]]:
    """An example scene as text, with its comments, and the files that it names. Raises InputError."""
    names, folder = example_names(), folder_of("examples")
    if name not in names:
        raise InputError(f"{shown(name)} is not an example{nearest_or_all(name, tuple(names))}")
    text = (folder / f"{name}.toml").read_text(encoding="utf-8")
    return text, [folder / file for _, file in re.findall(r'(?m)^(csv|path) = "([^"]+)"', text)]
