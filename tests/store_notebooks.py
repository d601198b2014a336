"""Run the notebooks of examples/ and store what their cells give, so that a reader on the web sees it.

python tests/store_notebooks.py [NAME.ipynb ...]
"""

import os
import re
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

EXAMPLES = Path(__file__).parents[1] / "examples"
CELL = 300  # s, for a cell, so that none hangs for ever
TEXTS = ("text/plain",)  # of an output, compared; pictures and players depend on fonts and on the last bits
NUMBER = re.compile(r"[-+]?\d[\d.,]*(e[-+]?\d+)?")


def executed(name: str, folder: Path, environment: Mapping[str, str] = os.environ) -> Any:
    """A notebook after a run from top to bottom in a kernel of its own, in a folder."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(EXAMPLES / name, as_version=4)
    options = {"timeout": CELL, "record_timing": False, "resources": {"metadata": {"path": str(folder)}}}
    NotebookClient(notebook, **options).execute(env=dict(environment))
    return notebook


def texts(notebook: Any) -> list[str]:
    """What the cells say, their numbers replaced by #, whose last digits may differ; "" of cells that measure time."""
    found = []
    for cell in notebook.cells:
        said, measured = "", "measures-time" in cell.metadata.get("tags", ())
        for output in () if measured else cell.get("outputs", ()):
            if output.output_type == "stream":
                said += output.text if output.name == "stdout" else ""
            else:
                said += "\n".join(output.data[kind] for kind in TEXTS if kind in output.data)
        found.append(NUMBER.sub("#", said))
    return found


def pure(notebook: Any) -> Any:
    """The notebook without what another run would give otherwise: notes' places in files of the kernel."""
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            if output.get("name") == "stderr":
                output.text = re.sub(r"^.*?: (Note: [^\n]*)\n.*", r"\1", output.text, flags=re.DOTALL)
    return notebook


def main(names: list[str]) -> None:
    """Run and store."""
    import nbformat

    for path in [EXAMPLES / name for name in names] or sorted(EXAMPLES.glob("*.ipynb")):
        with tempfile.TemporaryDirectory() as folder:
            notebook = pure(executed(path.name, Path(folder)))
        nbformat.write(notebook, path)
        print(path.name, path.stat().st_size)


if __name__ == "__main__":
    main(sys.argv[1:])
