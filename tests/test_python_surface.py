"""The Python surface, line by line as docs/python.md shows it; and that everything public shows itself briefly."""

import copy
import importlib
import inspect
import pickle
import pkgutil
import pydoc
import re
import shutil
from functools import cached_property
from pathlib import Path
from types import FunctionType, MethodType

import numpy as np
import pytest

import pendpin as pp
from pendpin.sweeps.plan import cases_of
from pendpin.sweeps.significance import significance
from pendpin.verification.hardcases import hard

TOP = Path(__file__).parents[1]
ROD = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)])
FALLING = pp.Scene(model=ROD, start={"positions": {"theta": 1.0}}, effects=[pp.effects.Gravity()], duration=0.5)


@pytest.mark.slow
def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """docs/python.md, block after block, beside the files of the crane."""
    for name in ("crane.toml", "crane_trolley.csv"):
        shutil.copy(TOP / "examples" / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for block in re.findall(r"```python\n(.*?)```", (TOP / "docs" / "python.md").read_text(), re.DOTALL):
        exec(block, names)  # our own text
    assert pp.load_scene("faster.toml") == names["faster"]
    assert len(names["run"].t) == 301
    np.testing.assert_array_equal(names["some"].t, np.linspace(1.0, 5.0, 9))
    assert len(repr(names["run"]).splitlines()) == 3
    assert names["theta"].shape == names["x"].shape == names["energy"].shape == (301,)
    assert names["longer"].t[-1] == 25.0
    assert names["q"].shape == (len(names["falling"].t), names["pin_model"].nq)
    assert len(pp.bind(pp.Scene(model=names["stiff"])).model.joints) == 5
    assert names["braked"].work["torque"][-1] < 0
    assert {"run.csv", "run.png", "two.png", "run.html"} <= {path.name for path in tmp_path.iterdir()}


def test_reports_show_themselves_briefly() -> None:
    """Whatever they hold."""
    cost = pp.cost(FALLING, methods=["dop853"], budget=0.02)
    doctor = pp.diagnose("\\phi'' = - \\frac{3 g}{2 l} \\sin(\\phi)")
    compared = pp.diagnose(FALLING, accelerations=lambda q, v: [0.0] * 2)
    reports = [cost, *cost.curves, doctor, *doctor.findings, compared]
    reports += [significance(FALLING), hard(["thin-pole"], full=False)]
    for report in reports:
        assert 10 < len(repr(report)) < 1000


@pytest.mark.parametrize("name", pp.__all__)
def test_every_public_name_explains_itself(name: str) -> None:
    """help() begins with a sentence, and shows no wall of annotations."""
    thing = getattr(pp, name)
    shown = pydoc.plain(pydoc.render_doc(thing))
    assert thing.__doc__
    assert thing.__doc__[0].isupper()
    assert "Annotated[" not in shown


def test_every_public_function_is_documented() -> None:
    """By a docstring of its own, or by that of the method that it overrides, as help() and the reference show it."""
    names = [module.name for module in pkgutil.walk_packages(pp.__path__, "pendpin.")]
    modules = [importlib.import_module(name) for name in names if not name.endswith("__main__")]
    things = {thing for home in modules for thing in vars(home).values() if isinstance(thing, FunctionType | type)}
    silent = []
    for thing in things:
        if thing.__qualname__.startswith("_") or not thing.__module__.startswith("pendpin."):
            continue
        members = vars(thing) if isinstance(thing, type) else ()
        public = [thing, *(getattr(thing, name) for name in members if not name.startswith("_"))]
        called = [x for x in public if isinstance(x, FunctionType | MethodType | property | cached_property | type)]
        called = [x for x in called if not getattr(x, "__name__", "").startswith("_")]  # FrozenDict.pop = _refuse
        silent += [f"{thing.__qualname__}: {x}" for x in called if not inspect.getdoc(x)]
    assert not silent


def test_every_function_takes_the_path_of_a_scene() -> None:
    """As `simulate` does; what is neither a scene nor a path is refused in one line."""
    path = TOP / "examples" / "single_rod.toml"
    scene = pp.load_scene(path)
    assert np.array_equal(
        pp.bind(path).acceleration(0.0, [0.1, 0.2], [0.3, 0.4]),
        pp.bind(scene).acceleration(0.0, [0.1, 0.2], [0.3, 0.4]),
    )
    assert pp.crosscheck(str(path), states=2).ok
    assert pp.simulate_many(path, [[0.1, 0.2]], [[0.0, 0.0]], workers=1).q.shape == (1, 601, 2)
    assert pp.Start.at_rest(path).positions == dict.fromkeys(("theta", "phi"), 0.0)
    for function in (pp.bind, pp.crosscheck, lambda given: pp.simulate_many(given, [[0.1, 0.2]], [[0.0, 0.0]])):
        with pytest.raises(pp.InputError, match="is not a Scene, nor the path of a scene file"):
            function({"duration": 1.0})


def test_a_scene_cannot_be_changed() -> None:
    """Not in its tables either, so that no check is skipped; copies are equal, and equal scenes have equal hashes."""
    given = FALLING
    for change in (
        lambda table: table.__setitem__("theta", np.nan),
        lambda table: table.update(theta=3.0),
        lambda table: table.pop("theta"),
    ):
        with pytest.raises(pp.InputError, match=r"scene\.replace"):
            change(given.start.positions)
    with pytest.raises(pp.InputError, match="duration: -3 is below 0"):
        given.copy(update={"duration": -3})
    for same in (pickle.loads(pickle.dumps(given)), copy.deepcopy(given), copy.copy(given), given.copy()):
        assert same == given
        assert hash(same) == hash(given)
    assert hash(pp.UrdfModel(name="panda", lock={"panda_finger_joint1": 0.0})) != hash(pp.UrdfModel(name="panda"))


def test_a_run_cannot_be_changed(tmp_path: Path) -> None:
    """Its arrays are read-only, also in a part of it and read from a file; tables of it are its caller's own."""
    run = pp.simulate(FALLING, energy_balance=True)
    for one in (run, run.at([0.3]), run.extend(0.1), pp.Trajectory.load(run.save(tmp_path / "run.npz"))):
        assert not any(array.flags.writeable for array in one.arrays.values())
        assert not one["theta_1"].flags.writeable
    table = run.to_xarray()
    table["q"] *= 2
    np.testing.assert_array_equal(table["q"], 2 * run.q)


NUMBERS = ([0.1, 0.2], [0.0, 0.0])
REFUSED = {
    "energy_balance: 'no'": lambda run: pp.simulate(FALLING, energy_balance="no"),
    "energy_balance: nan": lambda run: pp.simulate(FALLING, energy_balance=float("nan")),
    "anyway: 'no'": lambda run: pp.simulate(FALLING, anyway="no"),
    "anyway: -1.0": lambda run: pp.simulate(FALLING, anyway=-1.0),
    "limit: nan": lambda run: pp.simulate(FALLING, limit=float("nan")),
    "limit: '5'": lambda run: pp.simulate(FALLING, limit="5"),
    "limit: True": lambda run: pp.simulate(FALLING, limit=True),
    "every: '5'": lambda run: pp.simulate(FALLING, checkpoint="never.npz", every="5"),
    "[1.0] is not the path": lambda run: pp.simulate(FALLING, checkpoint=[1.0]),
    "states: None": lambda run: pp.crosscheck(FALLING, states=None),
    "states: '1'": lambda run: pp.crosscheck(FALLING, states="1"),
    "states: nan": lambda run: pp.crosscheck(FALLING, states=float("nan")),
    "states: 1.0": lambda run: pp.crosscheck(FALLING, states=1.0),
    "states: True": lambda run: pp.crosscheck(FALLING, states=True),
    "seed: -1": lambda run: pp.crosscheck(FALLING, states=1, seed=-1),
    "t: None": lambda run: pp.bind(FALLING).acceleration(None, *NUMBERS),
    "t: inf": lambda run: pp.bind(FALLING).wrenches(np.inf, *NUMBERS),
    "q: 'x'": lambda run: pp.bind(FALLING).acceleration(0.0, "x", "y"),
    "q: [1j, 0]": lambda run: pp.bind(FALLING).acceleration(0.0, [1j, 0], [0, 0]),
    "q: [nan, 0.0] are not finite": lambda run: pp.bind(FALLING).energy([np.nan, 0.0], [0.0, 0.0]),
    "v: [0.0, inf] are not finite": lambda run: pp.bind(FALLING).acceleration(0.0, [0.0, 0.0], [0.0, np.inf]),
    "['theta'] is not the name": lambda run: run.plot(["theta"]),
    "compare: 1.0": lambda run: run.plot(compare=1.0),
    "compare: 0": lambda run: run.plot(compare=0),
    "None is not the path": lambda run: run.save(None),
    "0 is not the path": lambda run: run.to_csv(0),
    "abc.xyz: its name ends in .xyz, and what is written is .npz": lambda run: run.save("abc.xyz"),
    "1.0: its name ends in .0, and what is written is .csv, .txt": lambda run: run.to_csv("1.0"),
    "3 is not the path": lambda run: pp.Trajectory.load(3),
    "b'x.html' is not the path": lambda run: run.animate().save(b"x.html"),
    "method: 0 ": lambda run: pp.simulate(FALLING, method=pytest.importorskip("pandas").Series([1])),
    "method: ": lambda run: pp.simulate(FALLING, method=np.array(["rk4"])),
    "'\\ud800' is not the path": lambda run: run.save("\ud800"),
    "update: 'x'": lambda run: FALLING.copy(update="x"),
    "positions: {0.5} is not a table": lambda run: pp.Start(positions={0.5}),
    "states: 100000000": lambda run: pp.crosscheck(FALLING, states=10**8),
    "methods: True": lambda run: pp.cost(FALLING, methods=True),
    "methods: 1 ": lambda run: pp.validate(methods=[1]),
    "methods: 0 ": lambda run: pp.validate(methods=0),
    "accuracy: None": lambda run: pp.cost(FALLING, accuracy=None),
    "accuracy: 'x'": lambda run: significance(FALLING, accuracy="x"),
    "3 is not the path of": lambda run: cases_of(3),
    "peers: 0": lambda run: pp.cost(FALLING, peers=0),
    "thorough: 'no'": lambda run: pp.cost(FALLING, thorough="no"),
    "repetitions: 1.5": lambda run: pp.cost(FALLING, repetitions=1.5),
    "budget: nan": lambda run: pp.cost(FALLING, budget=float("nan")),
    "progress: None": lambda run: pp.cost(FALLING, progress=None),
    "progress: 1": lambda run: pp.validate(progress=1),
    "progress: 'x'": lambda run: pp.simulate_many(FALLING, [NUMBERS[0]], [NUMBERS[1]], progress="x"),
    "progress: 0": lambda run: pp.sweep(FALLING, {"model.rods[0].mass": [1.0]}, progress=0),
}


@pytest.mark.parametrize("message", REFUSED)
def test_arguments_of_another_kind_are_refused_by_name(message: str) -> None:
    """In one line, whichever function they are given to; nothing is taken for true or for a number."""
    with pytest.raises(pp.errors.InputError) as raised:
        REFUSED[message](pp.simulate(FALLING, samples=2))
    assert str(raised.value).startswith(message)


def test_arguments_of_numpy_are_those_of_python() -> None:
    """And a limit that never comes is none."""
    plain = pp.simulate(FALLING, samples=3, energy_balance=True)
    assert pp.simulate(FALLING, samples=3, energy_balance=np.True_) == plain
    for limit in (np.inf, 1e300, np.float32(500), np.int64(500)):
        assert pp.simulate(FALLING, samples=3, energy_balance=True, limit=limit) == plain
    assert pp.crosscheck(FALLING, states=np.int64(3)) == pp.crosscheck(FALLING, states=3)
    bound = pp.bind(FALLING)
    np.testing.assert_array_equal(
        bound.acceleration(np.float32(0), np.array([1, 0]), (0, 1)), bound.acceleration(0.0, [1.0, 0.0], [0.0, 1.0])
    )
