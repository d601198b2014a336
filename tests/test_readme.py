"""The README's Python lines as a plain script, without `if __name__ == "__main__":`, with the extra `fast` and without."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import pendpin
from laws import HANG

TOP = Path(__file__).parents[1]
MANY = "pp.simulate_many(scene, [[0.1, 0.2], [0.3, 0.4]], [[0.0, 0.0], [1.0, 0.0]])\n"  # no process unless asked for
FAST = ("CyRK", "heyoka", "llvmlite")


@pytest.mark.parametrize("hidden", [pytest.param((), marks=pytest.mark.slow, id="with fast"), FAST], ids=str)
def test_the_readme_runs_as_a_script(hidden: tuple[str, ...], tmp_path: Path) -> None:
    """Every line of it; a process that it started would run the script again and end in a traceback."""
    blocks = re.findall(r"^```python\n(.*?)^```$", (TOP / "README.md").read_text(), re.M | re.S)
    assert blocks
    (tmp_path / "readme.py").write_text("".join([*blocks, MANY]))
    without = (
        tmp_path / "without"
    )  # a place whose sitecustomize hides libraries, also from processes that a script starts
    without.mkdir()
    (without / "sitecustomize.py").write_text(f"import sys\nsys.modules.update(dict.fromkeys({hidden}))\n")
    path = os.pathsep.join([str(without), str(Path(pendpin.__file__).parents[1])])
    done = subprocess.run(
        [sys.executable, "readme.py"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": path, "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        timeout=HANG,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "run.png").stat().st_size > 0
    assert (tmp_path / "run.html").stat().st_size > 0
