"""What the commands share with Python: other values by key path, robots by name, tables, examples."""

import inspect
import json
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
import typer.main

import pendpin as pp
from bad_input import AtOnce, run_main
from laws import HANG
from pendpin.cli.app import app
from pendpin.cli.outputs import DOING, print_table
from pendpin.errors import InputError, Interrupted, not_one_of
from pendpin.ground.files import folder_of
from pendpin.ground.report import Table


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to run in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_set_duration_samples_and_a_table(folder: Path, capfd: pytest.CaptureFixture) -> None:
    """The same run as by scene.replace, as comma-separated values."""
    assert run_main("new", "double_pendulum") == 0
    (folder / "mine.toml").write_text(capfd.readouterr().out)
    changes = ("--set", "model.rods[0].mass=2", "--set", "solver.method=rk45", "--set", "start.positions.theta_1=0.3")
    assert run_main("run", "mine.toml", *changes, "--duration", "0.5", "--samples", "11", "--out", "mine.csv") == 0
    scene = pp.load_scene("mine.toml").replace({"model.rods[0].mass": 2.0, "start.positions.theta_1": 0.3})
    run = pp.simulate(scene, duration=0.5, samples=11, method="rk45")
    head, *rows = (folder / "mine.csv").read_text().splitlines()
    assert tuple(head.split(",")) == run.names
    np.testing.assert_array_equal([float(row.split(",")[1]) for row in rows], run["theta_1"])


def test_a_run_that_did_not_begin_is_not_saved(folder: Path, capfd: pytest.CaptureFixture) -> None:
    """The refusal of an accuracy that no number can hold writes no file of one sample."""
    assert run_main("run", "--accuracy", "1e-300") == 1
    assert "finer than numbers of 64 bits" in capfd.readouterr().err
    assert not list(folder.iterdir())


def test_python_runs_the_package() -> None:
    """`python -m pendpin` is the command line, exit status and errors included."""
    command = (sys.executable, "-m", "pendpin")
    new = subprocess.run([*command, "new", "single_rod"], capture_output=True, text=True, check=True)
    assert new.stdout == (folder_of("examples") / "single_rod.toml").read_text()
    wrong = subprocess.run([*command, "rnu"], capture_output=True, text=True)
    assert (wrong.returncode, wrong.stderr.count("\n")) == (2, 1)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--set", "model.path"), "is not KEY=VALUE"),
        (("--set", "start.positions.teta=1"), "did you mean 'theta'"),
        (("--set", "duratoin=1"), "duratoin: unknown key; did you mean 'duration'"),
        (("--duration=-1",), "--duration: -1.0 is below 0"),
        (("--samples", "0"), "--samples: 0 is below 1"),
        (("--set", "start.positions.shoulder pitch=0.5"), 'or start.positions."left hip"'),
        (("--out", "run.json"), "its name ends in .json"),
        (("--out", "run.xyz"), "its name ends in .xyz, and what is written is .npz, .csv"),
        (("--out", "run.1.0"), "its name ends in .0"),
        (("--html", "page.xyz"), "its name ends in .xyz, and what is written is .html"),
        (("--html", "page.png"), "its name ends in .png"),
        (("--urdf", "ur55"), "did you mean 'ur5'"),
    ],
)
def test_refused_in_one_line(arguments: tuple[str, ...], says: str, capfd: pytest.CaptureFixture) -> None:
    """Before anything is run."""
    assert run_main("run", *arguments) != 0
    assert says in capfd.readouterr().err
    assert not list(Path().iterdir())


def test_robots_by_name(capfd: pytest.CaptureFixture) -> None:
    """Of example-robot-data."""
    assert run_main("run", "--urdf", "double_pendulum", "--duration", "0.1", "--json") == 0
    assert json.loads(capfd.readouterr().out)["steps"] > 0
    assert pp.Trajectory.load("run.npz").scene["model"]["name"] == "double_pendulum"


def test_the_energy_in_json(capfd: pytest.CaptureFixture) -> None:
    """A drift where energy is conserved; where it is not, the works that were asked for and how they balance."""
    friction = str(Path(__file__).parents[1] / "examples" / "friction.toml")
    found = []
    for arguments in (("--duration", "0.5"), (friction,), (friction, "--energy-balance")):
        assert run_main("run", *arguments, "--json") == 0
        found.append(json.loads(capfd.readouterr().out))
    kept, lost, balanced = found
    assert kept["energy_drift"] < 1e-9
    assert lost["energy_drift"] is None
    assert "work" not in lost
    assert balanced["energy_balance"] < 1e-8
    assert balanced["work"]["gravity"] == pytest.approx(-balanced["work"]["dry_friction"], rel=1e-6)


def test_version_help_and_lists(capfd: pytest.CaptureFixture) -> None:
    """Each ends well and says what it should."""
    for arguments, says in [
        (("--version",), pp.__version__),
        (("-h",), "Usage"),
        (("run", "-h"), "--set"),
        (("hard", "--list"), "thin-pole"),
        (("new", "--list"), "crane            A crane's load on 20 m of rope"),
    ]:
        assert run_main(*arguments) == 0
        assert says in capfd.readouterr().out


def test_ctrl_c_while_the_command_line_is_imported_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    """The first tenths of a second of every command."""
    import pendpin.cli

    class BeingImported:
        def __getattr__(self, name: str) -> None:
            raise KeyboardInterrupt

    monkeypatch.setitem(sys.modules, "pendpin.cli.app", BeingImported())
    with pytest.raises(SystemExit) as end:
        pendpin.cli.main()
    assert end.value.code == 130
    assert capsys.readouterr().err == "pendpin: stopped by the user\n"


def test_what_a_command_was_doing_is_named_by_functions_that_exist() -> None:
    """A limit looks for their names among those of the calls that it ended."""
    texts = [path.read_text() for path in Path(pp.__file__).parent.rglob("*.py")]
    assert [name for name in DOING if not any(f"def {name}(" in text for text in texts)] == []


def test_ctrl_c_in_a_run_has_its_status(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture) -> None:
    """It is that of Ctrl-C anywhere else; the line is that of the run, which says what was done."""

    def interrupted(path: Path) -> None:
        raise Interrupted("stopped by the user after 3 of 9 cases")

    monkeypatch.setattr("pendpin.scene.load_scene", interrupted)
    assert run_main("urdf", "chain.toml") == 130
    assert capfd.readouterr().err == "pendpin: stopped by the user after 3 of 9 cases\n"


LOST = """
import signal, sys, threading
from importlib.machinery import ExtensionFileLoader
from pendpin.cli import app, main

class Loader(ExtensionFileLoader):  # as Cython's modules
    def exec_module(self, module):
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:
            pass

class Going:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)

def run():
    Loader("numcodecs", "numcodecs.so").exec_module(None) if sys.argv[1] == "import" else Going()
    print("goes on", flush=True)
    while True:
        threading.Event().wait(0.1)

app.main = run
signal.signal(signal.SIGINT, signal.default_int_handler)  # it is off where tests run in the background
main()
"""


@pytest.mark.parametrize("where", ["import", "end of an object"])
def test_ctrl_c_is_not_lost(where: str) -> None:
    """Where Python or a library swallows what is raised, it is raised once more."""
    ended = subprocess.run([sys.executable, "-c", LOST, where], capture_output=True, text=True, timeout=HANG)
    assert (ended.returncode, ended.stdout, ended.stderr) == (130, "goes on\n", "pendpin: stopped by the user\n")


def test_a_command_runs_in_another_thread(capfd: pytest.CaptureFixture) -> None:
    """Signals are for the main thread alone."""
    ended, before = [], signal.signal(signal.SIGINT, signal.default_int_handler)  # as where no test ran before
    try:
        thread = threading.Thread(target=lambda: ended.append(run_main("schema")))
        thread.start()
        thread.join()
    finally:
        signal.signal(signal.SIGINT, before)
    assert ended == [0]
    assert json.loads(capfd.readouterr().out)


def test_paragraphs_of_help_have_one_line_each() -> None:
    """Typer keeps the line ends of those after the first."""
    for command in app.registered_commands:
        _, *further = inspect.getdoc(command.callback).split("\n\n")
        assert not [text for text in further if "\n" in text]


def test_names_that_differ_in_a_number_are_listed_as_one() -> None:
    """Every kind of name is then in a line that would not hold all names."""
    names = [f"{kind}_{i}{end}" for kind, end in [("theta", ""), ("theta", "_rate"), ("R3", "")] for i in range(1, 21)]
    assert not_one_of("swing", [*names, "tip_x"]).endswith(
        ": theta_1 to theta_20, theta_1_rate to theta_20_rate, R3_1 to R3_20, tip_x"
    )


def test_lines_of_wrong_usage_name_the_option_once(capfd: pytest.CaptureFixture) -> None:
    """Not the record or the key path behind it; a table of a run is no run."""
    for arguments, says in [
        (("run", "--samples", "1"), "pendpin: Invalid value for --samples: 1 is the start alone"),
        (("run", "--duration", "-1"), "pendpin: Invalid value for --duration: -1.0 is below 0"),
        (
            ("run", "--duration", "1e6"),
            "pendpin: Invalid value for --duration: 1e+06 s at 60 samples a second are more",
        ),
        (("cost", "--methods", "foo"), "pendpin: Invalid value for --methods: 'foo' is not one of"),
        (("cost", "--accuracy", "2"), "pendpin: Invalid value for --accuracy: 2.0 is not between"),
        (("effects", "--accuracy", "-1"), "pendpin: Invalid value for --accuracy: -1.0 is not between"),
        (("run", "--set", "model.rods[0].mass=2"), "pendpin: Invalid value for --set: the built-in rod is a URDF"),
        (("run", "--html"), "pendpin: Option '--html' requires an argument; see pendpin run --help"),
        (("run", ""), "pendpin: Invalid value for 'SCENE': the name of the scene file is empty"),
        (("plot", "run.csv"), "pendpin: run.csv: a table, not a run"),
    ]:
        assert run_main(*arguments) == 1 + (arguments[0] != "plot")
        assert capfd.readouterr().err.startswith(says)


def test_tables_cut_no_letter(capsys: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a narrow terminal the first column, of names, is as wide as they are, and the other columns wrap."""
    monkeypatch.setenv("COLUMNS", "60")
    name, long = "thick-pole-1mm-0.001", "letters" * 20
    print_table(Table(["case", "method", "verdict"], [[name, long, "ok"], [name, "a few words " * 9, long]]))
    said = capsys.readouterr().out
    assert said.count(name) == 2
    assert "…" not in said
    assert max(map(len, said.splitlines())) <= 60


def test_tables_cut_no_number(capsys: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a narrow terminal a table grows wider rather than show 3e-17 as 3e-1 and, a line below, 7."""
    monkeypatch.setenv("COLUMNS", "40")
    names, number = ["any two", "newton-euler"], "-3.4567e-17"
    print_table(Table(["", *"abcdefg"], [[name, *[number] * 7] for name in names]))
    said = capsys.readouterr().out
    assert said.count(number) == 14
    assert "newton-euler" in said


def test_examples_answer_what_they_ask(capfd: pytest.CaptureFixture) -> None:
    """How far a load swings, also after the trolley has stopped; when a rod comes to rest."""
    for name, says in [
        ("crane", r"farthest sideways.* m at .* s; after half the time .* m"),
        ("friction", "at rest from .* s"),
    ]:
        assert run_main("run", str(folder_of("examples") / f"{name}.toml")) == 0
        assert re.search(says, capfd.readouterr().out)
    rest = pp.Trajectory.load("run.npz")
    assert rest.summary()["at rest from"].value == rest.events[-1].t
    still = rest.t >= rest.events[-1].t
    assert not rest.v[still].any()
    assert rest.v[np.flatnonzero(still)[0] - 1].any()


LONG = {  # commands that can take long, each with what it needs
    "run": (),
    "check": (),
    "cost": (),
    "effects": (),
    "hard": (),
    "modes": (),
    "stability": (),
    "section": ("--at", "theta = 0", "--of", "phi"),
    "bifurcation": ("--vary", "duration=1:2:3", "--strobe", "0.1", "--of", "theta"),
    "validate": (),
    "reference": ("--out", "folder"),
    "doctor": ("text.md",),
    "fit": ("scene.toml", "swing.csv"),
    "sweep": ("scene.toml", "--vary", "duration=1:2:3"),
}


# Options that take several names between commas: two of them, and the function that the command calls with them.
NAMES = {
    ("cost", "--methods"): (("dop853", "rk4"), "pendpin.verification.work_precision.cost.cost"),
    ("validate", "--methods"): (("dop853", "rk4"), "pendpin.verification.agreement.validate"),
    ("fit", "--free"): (("model.rods[0].com", "friction"), "pendpin.fitting.fit"),
    ("section", "--of"): (("theta_rate", "phi_rate"), "pendpin.stability.sections.points.read_crossing"),
    ("bifurcation", "--of"): (("theta_rate", "phi_rate"), "pendpin.stability.sections.strobe"),
    ("doctor", "--convention"): (("z-up", "swapped"), "pendpin.doctor.diagnose.diagnose_file"),
    ("doctor", "--symbols"): (("alpha=theta", "A=J_1"), "pendpin.doctor.diagnose.diagnose_file"),
}


def words_in(values: Iterable[object]) -> list[str]:
    """All words between commas in texts, and in lists of them."""
    texts = [text for value in values for text in ([value] if isinstance(value, str) else value)]
    return [word for text in texts for word in text.split(",")]


@pytest.mark.parametrize(("command", "option"), NAMES)
def test_an_option_of_names_given_twice_adds_to_them(
    command: str, option: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    """As with a comma in one of them: the last one does not replace the first."""
    rod = pp.Rod(length=1, mass=1)
    pp.Scene(model=pp.Chain(rods=[rod]), data={"columns": {"a": ["theta"]}}).save("scene.toml")
    (folder / "text.md").write_text("$a = b$")
    (folder / "swing.csv").write_text("t,a\n" + "".join(f"{i / 10},{i % 7 / 10}\n" for i in range(60)))
    (one, other), function = NAMES[command, option]
    calls = []

    def record(*values: object, **named: object) -> None:
        texts = [x for x in (*values, *named.values()) if isinstance(x, str | list | tuple)]
        calls.append(words_in(x for x in texts if all(isinstance(part, str) for part in x)))
        raise InputError("recorded")

    monkeypatch.setattr(function, record)
    needed = [word for word in LONG[command] if word not in ("--of", "phi", "theta")]
    for given in ((f"{one},{other}",), (one, other), (f" {one}", f"{other} ")):
        assert run_main(command, *needed, *(word for text in given for word in (option, text))) != 0
        assert "recorded" in capfd.readouterr().err
    together, twice, spaced = ([word.strip() for word in call] for call in calls)
    assert together == twice == spaced
    assert {one, other} <= set(together)


def test_every_option_with_commas_may_be_repeated() -> None:
    """Those whose help speaks of commas, or shows one between two names."""
    commands = typer.main.get_command(app).commands
    options = {
        (name, option.opts[0]): option.multiple
        for name, command in commands.items()
        for option in command.params
        if option.param_type_name == "option" and re.search(r"commas|\w,\w", option.help or "")
    }
    assert set(options) == {*NAMES, ("sweep", "--vary")}
    assert all(options.values())


@pytest.mark.parametrize(
    ("arguments", "needed"),
    [
        (("run", "--every", "3"), "--checkpoint"),
        (("run", "--every", "5"), "--checkpoint"),
        (("stability", "--planar"), "--lyapunov"),
        (("stability", "--plot", "x.png"), "--lyapunov"),
        (("fit", "scene.toml", "swing.csv", "--hold-out-start", "0.2"), "--hold-out"),
        (("section", "--at", "theta = 0", "--of", "phi", "--plot", "x.png"), "--of"),
        (("urdf",), "--list"),
        (("modes", "--mode", "1"), "--html"),
        (("sweep", "--sampling", "latin"), "--sample"),
        (("run", "--urdf", ""), "--urdf: the name of the URDF is empty"),
        (("run", "--set", "duration=1", "--set", "duration = 2"), "--set: duration is given twice"),
        (
            ("run", "--urdf", "ur5", "--lock", "elbow_joint=1", "--lock", "elbow_joint=2"),
            "--lock: elbow_joint is given",
        ),
        (("doctor", "x.md", "--symbols", "alpha=theta,A=J_1", "--symbols", "alpha=phi"), "--symbols: alpha is given"),
    ],
)
def test_an_option_that_needs_another_is_refused_without_it(
    arguments: tuple[str, ...], needed: str, capfd: pytest.CaptureFixture
) -> None:
    """In one line that names the other, with the status of wrong usage; also where it says the default.

    So is a name that is given twice, of which one value would be dropped, and an empty name.
    """
    assert run_main(*arguments) == 2
    said = capfd.readouterr().err
    assert said.startswith("pendpin: ")
    assert said.count("\n") == 1
    assert needed in said
    assert not list(Path().iterdir())


def test_a_command_in_the_background_ends_at_its_limit(monkeypatch: pytest.MonkeyPatch, capfd) -> None:
    """A shell makes it ignore Ctrl-C, which the limit does not, and which it ignores again afterwards."""
    monkeypatch.setattr("threading.Timer", AtOnce)
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        assert run_main("hard", "--limit", "7") == 1
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
    assert "stopped after 7 s (--limit)" in capfd.readouterr().err


def test_a_limit_that_never_comes_is_the_longest_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thread refuses to wait for longer, with a traceback beside the command's output."""
    waits = []
    monkeypatch.setattr("threading.Timer", lambda limit, _: waits.append(limit) or AtOnce(limit, lambda: None))
    assert run_main("check", "--states", "2", "--limit", "inf") == 0
    assert waits == [threading.TIMEOUT_MAX]


@pytest.mark.parametrize("command", [name for name in LONG if name != "run"])
def test_every_long_command_ends_at_its_limit(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd
) -> None:
    """In one line, which says so; a run has a limit of its own (test_limits)."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("threading.Timer", AtOnce)
    rod, gravity = pp.Rod(length=1, mass=1), pp.effects.Gravity()
    scene = pp.Scene(model=pp.Chain(rods=[rod]), effects=[gravity], data={"columns": {"a": ["theta"]}})
    scene.save("scene.toml")
    Path("text.md").write_text("$a = b$")
    Path("swing.csv").write_text("t,a\n" + "".join(f"{i / 10},{i % 7 / 10}\n" for i in range(60)))
    assert run_main(command, *LONG[command], "--limit", "7") == 1
    said = capfd.readouterr().err
    assert said.startswith("pendpin: ")
    assert said.count("\n") == 1
    assert "stopped after 7 s (--limit)" in said


def test_no_command_without_a_limit_can_take_long() -> None:
    """The commands of the help have --limit, or read, write and draw what is there."""
    short = {"view", "plot", "urdf", "new", "schema", "map"}
    named = {command.name or command.callback.__name__ for command in app.registered_commands if command.callback}
    assert named == set(LONG) | short
