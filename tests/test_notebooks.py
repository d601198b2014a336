"""The notebooks of examples/, run from top to bottom in a kernel of their own."""

import json
import os
import signal
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest

from store_notebooks import EXAMPLES, executed, texts

NOTEBOOKS = sorted(path.name for path in EXAMPLES.glob("*.ipynb"))


@pytest.fixture
def mark() -> Iterator[str]:
    """A word in the environment of all processes that a notebook starts; none of them outlives the test."""
    word = f"notebook-{uuid.uuid4()}"
    yield word
    for pid in processes_of(word):
        os.kill(pid, signal.SIGKILL)


@pytest.mark.slow
@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_runs_from_top_to_bottom(name: str, mark: str, tmp_path: Path) -> None:
    import nbformat

    notebook, stored = executed(name, tmp_path, os.environ | {"PENDPIN_TEST": mark}), nbformat.read(EXAMPLES / name, 4)
    nbformat.validate(stored)
    assert texts(notebook) == texts(stored), "python tests/store_notebooks.py"
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    shown = [output["data"] for output in outputs if output.output_type == "execute_result"]
    assert any("<iframe" in data.get("text/html", "") for data in shown), "no player"
    assert any("image/png" in data for data in shown), "no figure"
    errors = [output.text for output in outputs if output.get("name") == "stderr" and "Note: " not in output.text]
    assert errors == []
    assert processes_of(mark) == []
    assert os.listdir(tmp_path) == []


def test_notebooks_hold_what_their_cells_give() -> None:
    """A reader on the web sees it: a player and a figure in each, no error, in less than 5 MB."""
    assert NOTEBOOKS == ["first_steps.ipynb", "robots.ipynb", "stability.ipynb"]
    for name in NOTEBOOKS:
        notebook = json.loads((EXAMPLES / name).read_text())
        cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
        assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
        outputs = [output for cell in cells for output in cell["outputs"]]
        assert not any(output["output_type"] == "error" for output in outputs)
        data = [output["data"] for output in outputs if "data" in output]
        assert any("<iframe" in "".join(one.get("text/html", "")) for one in data)
        assert any("image/png" in one for one in data)
        assert (EXAMPLES / name).stat().st_size < 5e6


def processes_of(word: str) -> list[int]:
    """Processes whose environment holds a word."""
    found = []
    for process in Path("/proc").glob("[0-9]*/environ"):
        try:
            if word.encode() in process.read_bytes():
                found.append(int(process.parent.name))
        except OSError:  # another user's, or it has just ended
            continue
    return found
