"""Pinocchio's faults are still those of docs/pinocchio_notes.md, and the forms that pendpin uses instead stay sound.

Each test runs the script of one section, as it stands on the page, and looks at the variables that it leaves. One that
says `mended` is good news: take the section off the page, and see what pendpin can do more simply.
"""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

NOTES = Path(__file__).parents[1] / "docs" / "pinocchio_notes.md"
MENDED = "mended: revisit docs/pinocchio_notes.md"
SECTION = r"^## {}\. .*?```python\n(.*?)```"


def script(section):
    found = re.search(SECTION.format(section), NOTES.read_text(), re.DOTALL | re.MULTILINE)
    assert found, f"docs/pinocchio_notes.md has no script in section {section}"
    return found[1]


def left_by(section):
    """The variables that the script of a section leaves."""
    variables = {}
    exec(compile(script(section), f"pinocchio_notes.md, section {section}", "exec"), variables)
    return variables


def process(section, *arguments):
    """The script of a section in a process of its own, which leaves no core file."""
    code = "import resource; resource.setrlimit(resource.RLIMIT_CORE, (0, 0))\n" + script(section)
    return subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False)


@pytest.mark.filterwarnings("ignore")
def test_digits_in_chains():
    """Chains of 1, 5, 10, 20, 40 and 60 rods: two revolutes keep their digits, the joints of several degrees do not."""
    table = left_by(1)["table"]
    assert max(table["two revolutes", "LOCAL"]) < 1e-13
    assert max(table["two revolutes", "WORLD"]) < 1e-12
    assert max(table["spherical", "LOCAL"][:3]) < 1e-13, "the spherical carrier of thin rods is used up to 10 rods"
    assert table["universal", "WORLD"][4] > 1e-3, MENDED
    assert table["spherical", "WORLD"][4] > 1e-3, MENDED
    assert table["spherical", "LOCAL"][5] > 1e-8, MENDED


def test_lost_symmetry_explains_it():
    """The sweep with its two halves left apart ends in garbage; the symmetric one does not grow."""
    found = left_by(2)
    assert np.abs(found["plain"] - found["plain"].T).max() > 1e3
    assert np.abs(found["kept"]).max() < 1e2


def test_derivatives():
    """Right for two revolutes and the spherical joint, wrong for the other three."""
    table = left_by(3)["table"]
    for form in ("two revolutes", "spherical"):
        assert max(table[form]) < 1e-8
    for form in ("universal", "composite", "spherical ZYX"):
        assert min(table[form]) > 1e-2, f"{form} {MENDED}"


def test_axes_of_the_universal_joint():
    """Parallel, zero and long axes are taken in silence."""
    perpendicular, *others = left_by(4)["answers"].values()
    for accelerations, determinant, checked in others:
        assert not np.isfinite(accelerations).all() or determinant > 1.1, MENDED
        assert checked, MENDED
    assert np.isfinite(perpendicular[0]).all()


def test_forces_that_aba_leaves():
    """data.f of aba equals rnea's only in the LOCAL convention and without external forces."""
    cases = left_by(5)["cases"]
    assert np.abs(cases["LOCAL"][0]).max() < 1e-13
    assert np.abs(cases["WORLD"][0]).max() > 1, MENDED
    assert np.abs(cases["LOCAL, push"][0] - [1, 2, 3]).max() < 1e-13, MENDED
    assert np.abs(cases["same, 3 calls"][1] - 3 * cases["LOCAL, push"][1]).max() < 1e-12, MENDED


def test_poses_after_aba():
    found = left_by(6)
    assert not found["after_aba"].any(), MENDED
    assert abs(found["data"].oMi[found["tip"]].translation[1] - 1) < 1e-15


def test_derivatives_are_views():
    found = left_by(7)
    assert not found["first"].flags.owndata, MENDED
    assert found["first"] != found["before"], MENDED


def test_branches_in_a_row():
    """crba is right for joints numbered branch by branch only; check() tells."""
    found = left_by(8)
    crba, true, checked = found["in_a_row"]
    assert abs(crba - true) < 1e-15
    assert checked
    crba, true, checked = found["scattered"]
    assert abs(crba - true) > 0.1, MENDED
    assert not checked


def test_urdf_is_not_checked():
    """Seven impossible bodies load without an error."""
    found = left_by(9)
    good, *others = ((m.inertias[1], m) for m in found["models"])
    assert good[0].mass == 1
    assert [body.mass for body, _ in others] == [0, 0, -1, 1, 1, 1, 1], MENDED
    assert all(model.check(model.createData()) for _, model in others), MENDED


@pytest.mark.skipif(sys.platform != "linux", reason="the size of the stack is that of Linux")
def test_long_urdf():
    """1,000 links in a row load (pendpin's own limit); 5,000 end the process."""
    assert process(10, "1000").stdout == "2000 frames\n"
    assert process(10, "5000").returncode < 0, MENDED


@pytest.mark.skipif(sys.platform != "linux", reason="memory is counted in another unit elsewhere")
def test_memory_of_data():
    """32 nv³ bytes, twice that while createData runs."""
    per_cube = {make: int(process(11, "150", make).stdout.split()[2]) for make in ("createData", "Data")}
    assert 28 < per_cube["Data"] < 45, MENDED
    assert 60 < per_cube["createData"] < 85, MENDED


def test_small_masses():
    """The lever of a body of 1e-16 kg is lost when it is appended to a joint."""
    levers = left_by(12)["levers"]
    assert levers[1.0] == levers[1e-15] == -0.5
    assert levers[1e-16] > -0.3, MENDED
