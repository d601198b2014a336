"""Writes the reference before Sphinx reads the pages: what can be read off the package is not written twice.

reference/api/*.rst from the public names, reference/commands/*.rst from the command line with the output of an example
each, reference/scene_file.md from the JSON schema, reference/effects.md from the records of the effects with a picture
each, reference/methods.md from the table of methods. None of these files is kept in the repository.
"""

import inspect
import os
import re
import subprocess
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType
from typing import Any

from command_tables import options_table, usage
from docstrings import escaped
from effect_pages import effects_page
from schema_pages import scene_page
from sphinx.util import logging

HERE = Path(__file__).parent
MOST_LINES = 40  # of an example's output
MOST_USERS = 6  # pages of a kind that a name of the API lists
log = logging.getLogger(__name__)


def write_reference(app: Any) -> None:
    """Write all generated pages."""
    folder = Path(app.srcdir) / "reference"
    write_api(folder)
    if fresh(folder / "methods.md", Path(app.srcdir).parent):  # the page that is written last
        return
    write_commands(folder, Path(app.srcdir).parent)
    save(folder / "scene_file.md", scene_page())
    save(folder / "effects.md", effects_page(folder / "effects"))
    (folder / "methods.md").write_text(methods_page(), encoding="utf-8")


def fresh(page: Path, top: Path) -> bool:
    """Whether a page is newer than everything that it is made of."""
    sources = [*(top / "src").rglob("*.py"), *(top / "docs/_extensions").glob("*.py"), *page.parent.glob("*.t*")]
    return page.exists() and page.stat().st_mtime > max(path.stat().st_mtime for path in sources)


def save(path: Path, text: str) -> None:
    """Write a page where it changes, so that Sphinx reads only those that do."""
    path.parent.mkdir(exist_ok=True, parents=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def heading(text: str, line: str = "=") -> str:
    """A heading in reStructuredText."""
    return f"{text}\n{line * len(text)}\n\n"


# --- Python ----------------------------------------------------------------------------------------------------------


def write_api(folder: Path) -> None:
    """A page for each public name, and the page that lists them by purpose."""
    import pendpin as pp

    groups = tomllib.loads((folder / "api.toml").read_text(encoding="utf-8"))["groups"]
    named = [name for group in groups for name in group["names"]]
    groups.append({"title": "Further", "names": [name for name in pp.__all__ if name not in named]})
    lines = [heading("Python"), "``import pendpin as pp``: these names, and no others, are public.\n"]
    for group in groups:
        names = [name for name in group["names"] if name in pp.__all__]
        if names:
            lines += ["", heading(group["title"], "-"), ".. list-table::", "   :widths: 25 75", ""]
            lines += [f"   * - :doc:`{name} <api/{name}>`\n     - {summary(getattr(pp, name))}" for name in names]
    lines += ["", ".. toctree::", "   :hidden:", "", *(f"   api/{name}" for name in pp.__all__)]
    save(folder / "api.rst", "\n".join(lines) + "\n")
    for name in pp.__all__:
        save(folder / "api" / f"{name}.rst", api_page(name, getattr(pp, name), folder / "api_examples" / f"{name}.py"))


def summary(thing: Any) -> str:
    """The first sentence of a docstring, ready for reStructuredText."""
    return escaped(" ".join((thing.__doc__ or "").split("\n\n")[0].split()))


def api_page(name: str, thing: Any, example: Path) -> str:
    """One name: its docstring, and an example that the tests run."""
    text = heading(name)
    if name == "effects":
        text += f"{summary(thing)}\n\n:doc:`/reference/effects` lists every effect with its formula and parameters.\n\n"
    elif isinstance(thing, ModuleType):
        text += f".. automodule:: {thing.__name__}\n   :members: {', '.join(thing.__all__)}\n"
    elif isinstance(thing, type):
        text += f".. autoclass:: pendpin.{name}\n   :members:\n   :inherited-members: BaseModel, BaseException, Mapping\n"
    else:
        text += f".. autofunction:: pendpin.{name}\n"
    if example.exists():
        text += "\n" + heading("Example", "-") + f".. literalinclude:: /reference/api_examples/{name}.py\n"
    users = pages_that_use(name)
    if users:
        text += "\nUsed in: " + ", ".join(f":doc:`/{page}`" for page in users) + ".\n"
    return text


def pages_that_use(name: str) -> list[str]:
    """Tutorials, how-to pages, others and scripts of the gallery with `pp.name` in their code, a few of each."""
    docs, word = HERE.parent, re.compile(rf"\bpp\.{name}\b")
    kinds = ("start/*.md", "how-to/*.md", "*.md", "gallery_scripts/plot_*.py")
    users = [
        [path for path in sorted(docs.glob(kind)) if word.search(path.read_text(encoding="utf-8"))][:MOST_USERS]
        for kind in kinds
    ]
    places = [path.relative_to(docs).with_suffix("").as_posix() for kind in users for path in kind]
    return [place.replace("gallery_scripts", "gallery") for place in places if place != "index"]


# --- commands --------------------------------------------------------------------------------------------------------


def write_commands(folder: Path, top: Path) -> None:
    """A page for each command: its help and the output of an example, which is run here."""
    from pendpin.cli.app import app

    said = tomllib.loads((folder / "commands.toml").read_text(encoding="utf-8"))["commands"]
    commands = {command.name or command.callback.__name__: command.callback for command in app.registered_commands}
    names = list(commands)
    with ThreadPoolExecutor(2) as pool:
        outputs = dict(zip(names, pool.map(lambda name: output(said.get(name, {}), top), names), strict=True))
    for name in names:
        save(folder / "commands" / f"{name}.rst", command_page(name, commands[name], said.get(name, {}), outputs[name]))
    table = [f"   * - :doc:`pendpin {name} <commands/{name}>`\n     - {summary(commands[name])}" for name in names]
    lines = [heading("Commands"), (HERE.parent / "reference" / "commands_intro.txt").read_text(encoding="utf-8")]
    lines += [".. list-table::", "   :widths: 30 70", "", *table, "", ".. toctree::", "   :hidden:", ""]
    save(folder / "commands.rst", "\n".join([*lines, *(f"   commands/{name}" for name in names)]) + "\n")


def output(said: dict[str, Any], top: Path) -> str:
    """What the example of a command prints, in a folder that holds the example scenes."""
    if "example" not in said:
        return ""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "examples").symlink_to(top / "examples")
        environment = os.environ | {"COLUMNS": "79", "NO_COLOR": "1", "TERM": "dumb"}
        done = subprocess.run(said["example"], shell=True, cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode != said.get("status", 0):
        log.warning("`%s` ends with status %d: %s", said["example"], done.returncode, done.stderr.strip())
    lines = [line.rstrip() for line in (done.stdout + done.stderr).splitlines()]
    return "\n".join(lines[:MOST_LINES] + (["..."] if len(lines) > MOST_LINES else []))


def command_page(name: str, command: Any, said: dict[str, Any], printed: str) -> str:
    """The page of one command: an example with its output, and the table of its options."""
    text = heading(f"pendpin {name}")
    if "example" in said:
        text += said["text"] + "\n\n" + block("console", "$ " + re.sub(r"(?<!\\)\n", "\n$ ", said["example"]))
        text += block("text", printed) if printed else ""
    lead = "\n\n".join(
        escaped(" ".join(part.split())) for part in inspect.cleandoc(command.__doc__ or "").split("\n\n")
    )
    return (
        text + heading("Options", "-") + block("console", usage(name, command)) + lead + "\n\n" + options_table(command)
    )


def block(language: str, text: str) -> str:
    """A block of code in reStructuredText."""
    return f".. code-block:: {language}\n\n" + "\n".join(f"   {line}" for line in text.splitlines()) + "\n\n"


# --- methods ---------------------------------------------------------------------------------------------------------


def methods_page() -> str:
    """The table of integration methods."""
    from pendpin.scene.methods import METHODS

    lines = ["# Methods", "", (HERE.parent / "reference" / "methods_intro.txt").read_text(encoding="utf-8")]
    lines += ["| method | family | set by | order | stages | symplectic | L-stable | finds events |", "|" + "---|" * 8]
    for method in METHODS.values():
        facts = (method.symplectic, method.damps, method.handles_events)
        order = "varies" if method.order is None else f"{method.order:g}"
        marks = " | ".join("yes" if fact else "" for fact in facts)
        lines.append(f"| `{method.name}` | {method.family} | {method.setting} | {order} | {method.stages} | {marks} |")
    return "\n".join(lines) + "\n"


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("builder-inited", write_reference, priority=100)
    return {"parallel_read_safe": True}
