"""Fits: files, keys and tables that are wrong end in one line."""

import re
from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from fit_scenes import ANGLE, scene_of
from pendpin.effects import DryFriction, Viscous
from pendpin.fitting.data import read_swings, sensors_of
from pendpin.fitting.parameters import free_parameters
from pendpin.model.build import build
from pendpin.scene import Data

GOOD = "t,segment,a1\n" + "\n".join(f"{0.1 * i},1,{np.cos(0.5 * i)}" for i in range(12))
TABLE = {"t": 0.1 * np.arange(40), "segment": np.ones(40), "a1": np.cos(0.5 * np.arange(40))}
BAD = {
    "": "an empty file",
    "t;segment;a1\n0;1;0": "separated by semicolons",
    "t\tsegment\ta1\n0\t1\t0": "separated by tabs",
    "0,1,0\n": "line 1 holds numbers",
    GOOD + GOOD[12:].replace(",1,", ",2,"): "segments 1 and 2 share 12 samples",
    "t,segment,b\n": "there is no column 'a1' among: t, segment, b; [data] says which are read, as in columns = { 'b' =",
    "t,b,segment\n": "as in columns = { 'b' = [...] }",
    "t,segment,a1,a1\n": "column 'a1' is there twice",
    GOOD + "\n2,1": "line 14 has 2 cells",
    GOOD + "\n2,1,high": "line 14, column a1: 'high' is not a number",
    GOOD + "\n0.3,1,0": "line 14, column t: 0.3 s does not come after 1.1 s",
    GOOD + "\nnan,1,0": "line 14, column t: no time",
    GOOD + "\n2,2,0": "segment 2 has 1 sample;",
    GOOD + "\n2,1,inf": "line 14, column a1: an infinite number",
    GOOD + "\n1.2,1,7": "line 14, column a1: it jumps by a turn before 1.2 s",
}


@pytest.mark.parametrize("text", BAD, ids=BAD.values())
def test_a_wrong_file_is_refused_in_one_line(text: str, tmp_path: Path) -> None:
    """With the file, and the line and column."""
    path = tmp_path / "data.csv"
    path.write_text(text)
    with pytest.raises(pp.InputError, match=r"data\.csv: ") as found:
        read_swings(path, ANGLE)
    assert BAD[text] in str(found.value)


def test_a_list_without_files_is_refused() -> None:
    """As a pattern that matches nothing gives one."""
    with pytest.raises(pp.InputError, match="there are no files of swings"):
        read_swings([], ANGLE)


@pytest.mark.parametrize(
    ("free", "said"),
    [
        ("model.rods[1].com", "the scene has 1 rod, counted from 0"),
        ("model.rods[0].massa", "did you mean 'mass'"),
        ("model.rods[0].joint", "not one of: length, mass, radius, com, inertia, payload, payload_radius, at"),
        ("model.rods[0].copies", "is not one of"),
        ("effects[1].static", "set it to a guess"),
        ("effects[0].kind", "is not one of"),
        ("start.positions.theta", "is not a number of a rod or an effect"),
        ("model.rods[0].inertia[3]", "there is no entry [3]"),
        ("", "is not a key path"),
    ],
)
def test_a_wrong_key_is_refused(free: str, said: str) -> None:
    """In one line that names the key."""
    with pytest.raises(pp.InputError) as found:
        free_parameters(scene_of(1, DryFriction(kinetic=1e-3)), free)
    assert said in str(found.value)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"columns": {"a": "theta"}}, "data.columns.a: 'theta' is not a coordinate of a tip"),
        ({"columns": {"a": ("theta", "theta")}}, "data.columns.a: it names a joint twice"),
        ({"columns": {"a": ("theta_2",)}}, "data.columns.a: joint 'theta_2' is not one of"),
        ({"columns": {"a": ("theta",)}, "offsets": "fre"}, "offsets: 'fre' is not one of: free, zero; did you mean"),
        ({"columns": {"a": ("theta",)}, "unit": "degree"}, "unit: 'degree' is not one of"),
    ],
)
def test_a_wrong_table_is_refused(table: dict, said: str) -> None:
    """In one line that names the key."""
    with pytest.raises(pp.InputError) as found:
        sensors_of(Data(**table), build(scene_of(1).model))
    assert said in str(found.value)


def test_columns_of_other_lengths_are_refused() -> None:
    """With both lengths; a table of tables is not a column."""
    for values, said in (([0.0, 1.0], "data: a1 has 2 values, t has 3"), ([[0.0]] * 3, "data: a1 is not a column")):
        with pytest.raises(pp.InputError, match=said):
            read_swings({"t": [0.0, 0.1, 0.2], "segment": [1, 1, 1], "a1": values}, ANGLE)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"free": 5}, "free: 5 is neither a key path nor a list of them"),
        ({"free": [5]}, "is neither a key path nor a list of them"),
        ({"hold_out": {}, "hold_out_start": "all"}, "there are no columns"),
        ({"hold_out": TABLE, "hold_out_start": "all"}, "hold_out_start: 'all' is not between 0 and 1"),
        ({"robust": "yes"}, "robust: 'yes' is neither True nor False"),
        ({"progress": 5}, "progress: 5 is not a function"),
    ],
)
def test_wrong_arguments_are_refused(given: dict, said: str) -> None:
    """Before anything is searched."""
    scene = scene_of(1, Viscous(coefficient=1e-4)).replace(data=ANGLE)
    with pytest.raises(pp.InputError, match=re.escape(said)):
        pp.fit(scene, TABLE, **({"free": "friction"} | given))


def test_tips_that_nothing_moves_are_refused() -> None:
    """From hanging down no joint moves a tip's z; one that the start moves is fitted."""
    scene = scene_of(1, data=Data(columns={"a1": "rod.z"}))
    with pytest.raises(pp.InputError, match=r"data\.columns: no joint moves them"):
        pp.fit(scene, TABLE, "model.rods[0].com")
