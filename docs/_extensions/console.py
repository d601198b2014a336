"""Cells of a tutorial that call a command or write a file, shown as a reader does it in a terminal or an editor.

The kernel runs `!pendpin run`; the page shows `$ pendpin run`. `%%writefile page.md` becomes a caption with the name.
"""

from typing import Any

from docutils import nodes


def show(app: Any, document: Any) -> None:
    """Change how these cells look; they have been run by now, or will be from their own text."""
    for cell in document.findall(lambda node: isinstance(node, nodes.container) and "cell_input" in node["classes"]):
        for block in list(cell.findall(nodes.literal_block)):
            text = block.astext()
            if text.startswith("%%writefile "):
                _show_file(block, text)
            elif all(line.startswith(("!", " ")) for line in text.splitlines()):
                _rewrite(block, "\n".join(line.replace("!", "$ ", 1) for line in text.splitlines()), "console")


def _show_file(block: Any, text: str) -> None:
    head, _, rest = text.partition("\n")
    name = head.split()[1]
    language = {"toml": "toml", "py": "python", "csv": "text", "md": "latex", "tex": "latex"}
    place = block.parent.index(block)
    block.parent.insert(place, nodes.paragraph("", "", nodes.literal("", name), nodes.Text(":")))
    _rewrite(block, rest, language.get(name.rsplit(".", 1)[-1], "text"))


def _rewrite(block: Any, text: str, language: str) -> None:
    block.children = [nodes.Text(text)]
    block.rawsource = text
    block["language"] = language


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("doctree-read", show)
    return {"parallel_read_safe": True}
