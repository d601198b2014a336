"""The scene file, key by key, from the JSON schema that `pendpin schema` prints."""

import json
from typing import Any

LEAD = """# The scene file

A scene is a TOML file. `pendpin new` prints one with comments, and `pendpin schema` prints this page as a JSON schema, with
which an editor completes and checks the file. SI units and radians everywhere, unless `unit = "degrees"` says otherwise.
Unknown keys are refused, with the key that was probably meant.

```{literalinclude} ../../examples/single_rod.toml
:language: toml
```

A number anywhere in a scene has a **key path**, such as `model.rods[0].mass`, `effects[1].coefficient` or
`start.positions.theta_1`. Error messages, `scene.replace`, `--set`, `--vary` and `--free` all use it.
"""
TABLES = {
    "Scene": ("The file", "The keys at the top of the file, and its tables."),
    "Chain": ('[model] with kind = "chain"', ""),
    "Rod": ("One of [model] rods", ""),
    "UrdfModel": ('[model] with kind = "urdf"', ""),
    "Start": ("[start]", ""),
    "Solver": ("[solver]", ""),
    "Data": ("[data]", ""),
}
TAIL = """## [[effects]]

One table for each effect, with a `kind`; [effects](effects.md) lists the keys of each kind.
"""


def scene_page() -> str:
    """The whole page."""
    from pendpin.scene import Scene

    schema = Scene.model_json_schema()
    records = {"Scene": schema, **schema["$defs"]}
    parts = [LEAD]
    for name, (title, lead) in TABLES.items():
        text = lead or records[name]["description"]
        parts.append(f"## {title}\n\n{text}\n\n{keys_table(records[name])}")
    return "\n".join([*parts, TAIL])


def keys_table(record: dict[str, Any]) -> str:
    """The keys of one record: type and bounds, default, meaning."""
    required = record.get("required", [])
    lines = ["| key | value | default | meaning |", "|---|---|---|---|"]
    for key, said in record["properties"].items():
        default = "required" if key in required else default_of(said)
        meaning = said.get("description", "").replace("|", "\\|")
        lines.append(f"| `{key}` | {kind_of(said)} | {default} | {meaning} |")
    return "\n".join(lines) + "\n"


def default_of(said: dict[str, Any]) -> str:
    """The default as TOML writes it."""
    default = said.get("default")
    if default is None or isinstance(default, dict):
        return "absent"
    return f"`{json.dumps(default)}`"


def kind_of(said: dict[str, Any]) -> str:
    """The type of a value in words, with its bounds."""
    if "const" in said:
        return f'`"{said["const"]}"`'
    if "enum" in said:
        return ", ".join(f'`"{value}"`' for value in said["enum"])
    if "$ref" in said:
        return "table"
    branches = [b for b in said.get("anyOf", said.get("oneOf", [])) if b.get("type") != "null"]
    if branches:
        return " or ".join(dict.fromkeys(map(kind_of, branches)))
    match said.get("type"):
        case "array" if "prefixItems" in said:
            return f"{len(said['prefixItems'])} numbers"
        case "array":
            items = said.get("items", {})
            return "list of tables" if "$ref" in items or "oneOf" in items else f"list of {kind_of(items)}s"
        case "object":
            return "table"
        case "number" | "integer" as kind:
            return ("number" if kind == "number" else "whole number") + bounds(said)
        case "boolean":
            return "`true` or `false`"
        case "string":
            return "text"
    return "any"


def bounds(said: dict[str, Any]) -> str:
    """The bounds of a number that a reader needs: those of all numbers (1e150) are left out."""
    low = [f"above {said['exclusiveMinimum']:g}"] if "exclusiveMinimum" in said else []
    if "minimum" in said and abs(said["minimum"]) < 1e100:
        low = [f"at least {said['minimum']:g}"]
    high = [f"at most {said['maximum']:g}"] if "maximum" in said and abs(said["maximum"]) < 1e100 else []
    return ", " + ", ".join(low + high) if low + high else ""
