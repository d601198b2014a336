"""The effects, one section each: equation, keys, and a picture of the same rod with the effect and without it."""

import inspect
from pathlib import Path
from typing import Any

from schema_pages import keys_table

LEAD = """# Effects

A scene lists its effects, and nothing else acts, not even gravity. Each section has the equation, the keys of the
`[[effects]]` table and, where one rod of 1 m and 1 kg can show it, the angle with gravity alone (grey) and with the effect
added (blue). [Effects](../effects.md) has the sources, and tells when each effect matters and how to write one of your own.
"""
INTERFACES = {
    "FieldEffect": "a field: one acceleration of everything",
    "FrameEffect": "a moving frame of reference",
    "JointEffect": "a torque about joint axes",
    "BodyEffect": "a force and a moment on each rod",
    "ContactEffect": "events: something happens at an instant",
}
SHOWN: dict[str, dict[str, Any]] = {  # an effect that shows in 10 s of a rod that starts at theta = 0.7, phi = 0.4
    "viscous": {"coefficient": 0.1},
    "spring": {"stiffness": 5.0},
    "motor": {"joint": "theta", "amplitude": 1.0, "frequency": 3.0},
    "push": {"link": "rod_1", "force": [0.0, 3.0, 0.0]},
    "bending": {"stiffness": 2.0, "clamp": [0.0, 0.0, -1.0]},
    "anchor": {"link": "rod_1", "point": [0.0, -0.8, -0.6], "stiffness": 10.0},
    "drag": {"wind": [0.0, 6.0, 0.0], "diameter": 0.2},
    "support": {"amplitude": [0.0, 0.1, 0.0], "frequency": 3.0},
    "rotation": {"rate": [0.0, 0.0, 1.0]},
    "dry_friction": {"kinetic": 0.2, "static": 0.3},
    "stop": {"lower": -0.3, "upper": 0.9, "restitution": 0.7, "joints": ["theta"]},
    "as_written": {},
}


def effect_classes() -> list[Any]:
    """The effects that a scene file may name."""
    from typing import get_args

    from pendpin.effects import AnyEffect
    from pendpin.effects.base import Effect

    union = get_args(get_args(AnyEffect)[0])
    classes = [get_args(member)[0] for member in union]
    return [record for record in classes if record is not Effect and record.model_fields["kind"].default]


def effects_page(pictures: Path) -> str:
    """The whole page; its pictures go into a folder beside it."""
    pictures.mkdir(exist_ok=True, parents=True)
    return "\n".join([LEAD, *(section(record, pictures) for record in effect_classes())])


def section(record: Any, pictures: Path) -> str:
    """One effect."""
    kind = record.model_fields["kind"].default
    schema = record.model_json_schema()
    text = f"## {kind}\n\n{formatted(schema['description'])}\n\n"
    text += f"It acts as {interface(record)}.\n\n{keys_table(schema)}\n"
    if kind in SHOWN and draw(kind, record, pictures / f"{kind}.svg"):
        text += f"![theta with and without {kind}](effects/{kind}.svg)\n\n"
        text += f"`{kind}` with {settings(SHOWN[kind])}\n"
    return text


def interface(record: Any) -> str:
    """Which of the interfaces of an effect it uses, in words."""
    names = [parent.__name__ for parent in inspect.getmro(record)]
    return next((words for name, words in INTERFACES.items() if name in names), "an entry of its own")


def formatted(text: str) -> str:
    """A docstring as Markdown: stars and underscores are themselves."""
    return text.replace("*", "\\*").replace("_", "\\_") if "`" not in text else text.replace("*", "\\*")


def settings(values: dict[str, Any]) -> str:
    """The numbers of a picture."""
    return ", ".join(f"`{key} = {value!r}`" for key, value in values.items()).replace("'", '"')


def draw(kind: str, record: Any, path: Path) -> bool:
    """The picture of one effect; False where one rod cannot show it."""
    import matplotlib.pyplot as plt

    import pendpin as pp

    rod = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)])
    start = pp.Start(positions={"theta": 0.7, "phi": 0.4})
    alone = pp.Scene(model=rod, start=start, effects=[pp.effects.Gravity()], duration=10.0)
    try:
        both = alone.replace(effects=[*alone.effects, record(**SHOWN[kind])])
        runs = [pp.simulate(scene, tolerance=1e-8) for scene in (alone, both)]
    except pp.InputError:
        return False
    figure, axes = plt.subplots(figsize=(7, 2.2), layout="constrained")
    for run, color in zip(runs, ("#a0aec0", "#2b6cb0"), strict=True):
        axes.plot(run.t, run["theta"], color=color, linewidth=1.4)
    axes.set(xlabel="time (s)", ylabel="theta (rad)")
    axes.spines[["top", "right"]].set_visible(False)
    plt.rcParams["svg.hashsalt"] = kind
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)
    return True
