"""Reading scenes from TOML files."""

import re
import tomllib
from pathlib import Path
from typing import Any

from pendpin.errors import InputError, inside
from pendpin.files import read_whole
from pendpin.scene.scene import Scene

MAX_SCENE_BYTES = 500_000  # more takes Python's TOML reader seconds
_DEEP_KEY = re.compile(rb"""(?<![\w-])(?:(?:[\w-]+|["'][^"'\n]*["'])[ \t]*\.[ \t]*){50}""")


def load_scene(path: str | Path) -> Scene:
    """Read a scene from a TOML file; the files that it names are relative to that file. Raises InputError."""
    path = Path(path)
    with inside(str(path)):
        raw = _read_toml(path)
        raw |= {"model": _placed(raw["model"], "path", path.parent)} if "model" in raw else {}
        if isinstance(raw.get("effects"), list):
            raw["effects"] = [_placed(effect, "csv", path.parent) for effect in raw["effects"]]
        try:
            return Scene(**raw)
        except InputError as error:  # the file's name says enough
            raise InputError(str(error).removeprefix("Scene: ")) from None


def _placed(table: Any, key: str, folder: Path) -> Any:
    """A table whose `key` names a file relative to `folder`, with the whole path; anything else as it is."""
    if isinstance(table, dict) and isinstance(table.get(key), str):
        return table | {key: str(folder / table[key])}
    return table


def _read_toml(path: Path) -> dict[str, Any]:
    data = read_whole(path, MAX_SCENE_BYTES, "a scene")
    if data.lstrip().startswith(b"<"):
        raise InputError("not a TOML scene but XML; a scene names a URDF as [model] kind and path")
    if _DEEP_KEY.search(data):  # Python's TOML reader would take minutes
        raise InputError("not a scene: keys are nested too deep")
    try:
        return tomllib.loads(data.decode("utf-8-sig"))  # a mark at the start, as some editors write, is no fault
    except UnicodeDecodeError as error:
        raise InputError(f"not a TOML file: byte {error.start} is not UTF-8 text") from None
    except RecursionError:
        raise InputError("not a scene: values are nested too deep") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"not a TOML file: {error}") from None
    except ValueError:  # Python's own limit
        raise InputError("not a scene: a whole number has thousands of digits") from None
