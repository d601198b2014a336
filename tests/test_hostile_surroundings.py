"""Surroundings that fail: streams that are closed or full, disks, folders, settings. Each command in a process of its own.

Where the work cannot be done: exit status 1, one readable line on stderr, no hang, nothing half written. Where only the
surroundings are poor, the work is done in silence.
"""

import os
import resource
import shutil
import signal
import socket
import stat
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pendpin
from bad_input import SCENE, contents
from laws import HANG
from pendpin import InputError, Trajectory
from pendpin.ground.files import write_whole
from run_files import meta, run_file

# -P: as for the installed command, the working folder is no place to import from; Python 3.13.0 fails if it was removed
COMMAND = [sys.executable, "-P", "-c", "from pendpin.cli import main; main()"]
SETTINGS = {"COLUMNS", "DISPLAY", "HOME", "MPLBACKEND", "MPLCONFIGDIR", "PYTHONIOENCODING", "PYTHONUNBUFFERED", "TERM"}
# no HOME, no DISPLAY, no TERM: in all that follows
PLAIN = {name: value for name, value in os.environ.items() if name not in SETTINGS and not name.startswith("LC_")}
PLAIN |= {"PYTHONPATH": str(Path(pendpin.__file__).parents[1])}
NOBODY = 65534
SECONDS = 300  # of processor time, where a command takes one: beyond it the system ends a command that hangs


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to run in, with a scene and a saved run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    one_rod = {"model": {"kind": "chain", "rods": [{"length": 1.0, "mass": 1.0}]}}
    (tmp_path / "run.npz").write_bytes(run_file(meta=meta(scene=one_rod)))
    return tmp_path


@pytest.fixture
def plain_user() -> Iterator[Path]:
    """A folder of a user whom permissions bind: the superuser becomes another for a while."""
    with tempfile.TemporaryDirectory() as name:
        if os.geteuid() == 0:
            try:
                os.chown(name, NOBODY, NOBODY)
                os.seteuid(NOBODY)
            except OSError:
                pytest.skip("a superuser who cannot become another")
        yield Path(name)
        os.seteuid(os.getuid())


def command(*arguments: str, before: Callable[[], object] = lambda: None, **options: Any) -> Any:
    """`pendpin ARGUMENTS` as a user runs it; `before` is called in the new process."""

    def prepare() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
        before()

    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    given = {"env": PLAIN, "preexec_fn": prepare, "timeout": HANG} | streams
    return subprocess.run([*COMMAND, *arguments], check=False, **given)


def assert_refused(done: Any, says: str) -> None:
    """Exit status 1 and one line that says it."""
    line = done.stderr.decode()
    assert (done.returncode, line.count("\n")) == (1, 1), line
    assert line.startswith("pendpin: ")
    assert says in line


def assert_done(done: Any) -> None:
    """Exit status 0, in silence on stderr."""
    assert (done.returncode, done.stderr) == (0, b"")


# ---- the streams -----------------------------------------------------------------------------------------------------

PRINTING = {
    "run": ("run", "scene.toml"),
    "check": ("check", "scene.toml", "--states", "3"),
    "check, JSON": ("check", "scene.toml", "--states", "3", "--json"),
    "effects": ("effects", "scene.toml"),
    "urdf": ("urdf", "scene.toml"),
    "schema": ("schema",),
    "view": ("view", "run.npz", "--html", "run.html"),
    "help": ("--help",),
}
SHORT = ("schema", "help")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in (*SHORT, "run"))) for name in PRINTING]
)
def test_output_on_a_full_disk(name: str, folder: Path) -> None:
    """What is printed and does not arrive is a failure of every command."""
    with open("/dev/full", "wb") as full:
        done = command(*PRINTING[name], stdout=full)
    assert_refused(done, "pendpin: the output cannot be written: No space left on device\n")


@pytest.mark.parametrize("name", SHORT)
def test_output_that_is_closed(name: str, folder: Path) -> None:
    """The same with `>&-`."""
    done = command(*PRINTING[name], before=lambda: os.close(1), stdout=None)
    assert_refused(done, "pendpin: the output cannot be written: Bad file descriptor\n")


@pytest.mark.parametrize("name", SHORT)
def test_reader_that_is_gone(name: str, folder: Path) -> None:
    """`pendpin ... | true` ends in silence, as other programs do, but not as a success."""
    reading, writing = os.pipe()
    os.close(reading)
    done = command(*PRINTING[name], stdout=writing)
    os.close(writing)
    assert (done.returncode, done.stderr) == (1, b"")


MEASURED = """
[data]
unit = "degrees"
columns = { theta = ["theta_1"] }
"""
WRITING = {  # their files are the arguments with a suffix, behind the first file
    "doctor": ("doctor", "page.md", "--html", "new.html"),
    "fit": ("fit", "scene.toml", "swing.csv", "--free", "model.rods[0].com", "--out", "new.toml", "--csv", "new.csv"),
    "modes": ("modes", "scene.toml", "--html", "new.html", "--plot", "new.svg"),
    "section": ("section", "scene.toml", *("--at", "theta_1 = 0", "--of", "theta_1,phi_1"), "--plot", "new.svg"),
    "cost": ("cost", "scene.toml", "--methods", "dop853,rk4", "--plot", "new.svg"),
    "validate": ("validate", "conical", "--methods", "dop853", "--html", "new.html"),
}


@pytest.fixture
def papers(folder: Path) -> Path:
    """The folder, with equations that fail and a measured swing beside them."""
    shutil.copy(Path(__file__).parent / "printed_derivation.md", folder / "page.md")
    (folder / "scene.toml").write_text(
        SCENE.replace("0.1\n", "20.0\n", 1).replace("phi_1 = 0.4", "phi_1 = 0") + MEASURED
    )
    t = np.linspace(0.0, 2.0, 201)
    np.savetxt("swing.csv", np.stack([t, 20 * np.cos(3.8 * t)], 1), delimiter=",", header="t,theta", comments="")
    return folder


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name != "fit")) for name in WRITING])
def test_files_are_written_though_the_reader_is_gone(name: str, papers: Path) -> None:
    """`pendpin doctor page.md --html new.html | head -1`: the page is there, whatever becomes of the table."""
    before, arguments = contents(papers), WRITING[name]
    reading, writing = os.pipe()
    os.close(reading)
    done = command(*arguments, stdout=writing, env=PLAIN | {"PYTHONUNBUFFERED": "1"})
    os.close(writing)
    assert (done.returncode, done.stderr) == (1, b"")
    assert set(contents(papers)) - set(before) == {argument for argument in arguments if argument.startswith("new.")}


def test_a_report_is_printed_though_its_page_cannot_be_written(papers: Path) -> None:
    """A disk that is full as the page comes takes no report with it."""
    done = command(
        "modes",
        "scene.toml",
        "--html",
        "new.html",
        before=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1_000, 1_000)),
    )
    assert_refused(done, "new.html: cannot be written: File too large")
    assert b"The rest (all 0) is stable." in done.stdout


def test_errors_that_nobody_can_hear(folder: Path) -> None:
    """With stderr closed or full the exit status is still right, and the line does not turn up among the output."""
    for arguments, status in {("plot", "gone.npz"): 1, ("run", "--frob"): 2}.items():
        done = command(*arguments, before=lambda: os.close(2))
        assert (done.returncode, done.stdout, done.stderr) == (status, b"", b"")
    with open("/dev/full", "wb") as full:
        assert command("schema", stdout=full, stderr=full).returncode == 1


def test_no_streams_at_all(folder: Path) -> None:
    """As a daemon may start it: the run is saved whole, under no stream's number, and the lost table is a failure."""
    done = command("run", "scene.toml", "--out", "new.npz", before=lambda: os.closerange(0, 3))
    assert (done.returncode, done.stdout, done.stderr) == (1, b"", b"")
    assert len(Trajectory.load("new.npz").t) > 1


# ---- disks and folders -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("limit", "arguments", "lost"),
    [
        (1_000, ("run", "scene.toml", "--out", "new.npz"), "new.npz"),
        pytest.param(20_000, ("view", "run.npz", "--html", "new.html"), "new.html", marks=pytest.mark.slow),
        (1_000, ("urdf", "scene.toml", "--out", "new.urdf"), "new.urdf"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_disk_that_fills_up(limit: int, arguments: tuple[str, ...], lost: str, folder: Path) -> None:
    """A file that would grow beyond a limit of the system, as on a full disk: it is not there at all."""
    before = contents(folder)
    done = command(*arguments, before=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    assert_refused(done, f"{lost}: cannot be written: File too large")
    assert contents(folder) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mounted", "reason"), [("size=100k", "No space left on device"), ("ro", "Read-only file system")]
)
def test_small_or_read_only_file_system(mounted: str, reason: str, folder: Path) -> None:
    """What fits is there whole, what does not is not there. The mount is seen by this process only, and goes with it."""
    (folder / "disk").mkdir()
    script = f'mount -t tmpfs -o {mounted} none disk || exit 77; "$@"; status=$?; ls -A disk >listing; exit $status'
    arguments = ("view", "run.npz", "--html", "disk/run.html")
    if not shutil.which("unshare"):
        pytest.skip("no unshare")
    line = ["unshare", "-m", "sh", "-c", script, "sh", *COMMAND, *arguments]
    done = subprocess.run(line, env=PLAIN, capture_output=True, timeout=HANG, check=False)
    if not (folder / "listing").exists():
        pytest.skip("no right to mount")
    assert_refused(done, f"disk/run.html: cannot be written: {reason}")
    assert (folder / "listing").read_text() == ""


def test_what_is_write_protected_stays(plain_user: Path) -> None:
    """A file or folder that its owner protects; a file that may be written keeps its permissions."""
    for file, mode in {"protected": 0o444, "private": 0o600}.items():
        (plain_user / file).write_text("old")
        (plain_user / file).chmod(mode)
    with pytest.raises(InputError, match="protected: cannot be written: it is write-protected"):
        write_whole(plain_user / "protected", lambda file: file.write(b"new"))
    write_whole(plain_user / "private", lambda file: file.write(b"new"))
    assert stat.S_IMODE((plain_user / "private").stat().st_mode) == 0o600
    plain_user.chmod(0o555)
    with pytest.raises(InputError, match="other: cannot be written: Permission denied"):
        write_whole(plain_user / "other", lambda file: file.write(b"new"))
    plain_user.chmod(0o755)
    assert {file.name: file.read_text() for file in plain_user.iterdir()} == {"protected": "old", "private": "new"}


def test_folder_that_is_gone(folder: Path) -> None:
    """A working folder that was removed: nothing can be written there, and elsewhere it does not matter."""

    def leave() -> None:
        (folder / "gone").mkdir()
        os.chdir(folder / "gone")
        (folder / "gone").rmdir()

    scene = str(folder / "scene.toml")
    assert_refused(command("run", scene, before=leave), "run.npz: cannot be written: No such file or directory")
    assert_done(command("urdf", scene, "--out", str(folder / "new.urdf"), before=leave))


def test_huge_files(folder: Path) -> None:
    """Ten gigabytes of nothing are refused by reading no more than is sane."""
    for arguments, name in {("urdf", "big.toml"): "big.toml", ("plot", "big.npz"): "big.npz"}.items():
        with open(name, "wb") as file:
            file.truncate(10_000_000_000)
        assert_refused(command(*arguments), f"{name}: ")
    (folder / "big.toml").rename("rod.urdf")
    assert_refused(command("check", "--urdf", "rod.urdf"), "rod.urdf: larger than the 8 MB")


# ---- settings --------------------------------------------------------------------------------------------------------


def test_poor_settings(folder: Path) -> None:
    """A picture is drawn all the same, and where matplotlib would keep its cache is not said."""
    nowhere = {"HOME": "/proc", "MPLCONFIGDIR": "/proc/none"}
    nonsense = {"LANG": "xx_YY.klingon", "LC_ALL": "zz", "TERM": "no such", "PYTHONIOENCODING": "ascii"}
    assert_done(command("plot", "run.npz", "--out", "schwingung φ.png", env=PLAIN | nowhere | nonsense))
    assert (folder / "schwingung φ.png").is_file()


@pytest.mark.slow
def test_settings_of_matplotlib(folder: Path) -> None:
    """LaTeX for all text, as many have it, does not reach names of joints; a backend that is none is named."""
    (folder / "matplotlibrc").write_text("text.usetex: True\nno such: [\n")
    assert_done(command("plot", "run.npz"))
    done = command("plot", "run.npz", env=PLAIN | {"MPLBACKEND": "none such"})
    assert_refused(done, "matplotlib does not start: ")


def test_tiny_terminal(folder: Path) -> None:
    """The table is printed in whole, whatever the terminal makes of it."""
    done = command("check", "scene.toml", "--states", "3", env=PLAIN | {"COLUMNS": "1"})
    assert_done(done)
    assert "theta_dd" in done.stdout.decode()


# ---- the live view ---------------------------------------------------------------------------------------------------

JUNK = [
    b"",
    bytes(100),
    b"GET / HTTP/9.9\r\n\r\n",
    b"GET / HTTP/1.1\r\n" + b"A: b\r\n" * 200 + b"\r\n",
    b"A" * 70_000,
    b"GET / HTTP/1.1\r\nHost: \xff\xfe\r\n\r\n",
    b"POST / HTTP/1.1\r\nContent-Length: 99\r\n\r\n",
    b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
    b"GET http://[::1 HTTP/1.1\r\n\r\n",
]


@pytest.mark.slow
def test_two_views_at_once_and_junk_sent_to_one(folder: Path) -> None:
    """Each finds a port of its own; what is no request of a browser is answered or dropped, in silence."""
    with two_views() as views:
        ports = [int(view.stdout.readline().split(b"/")[2].split(b":")[1]) for view in views if view.stdout]
        assert len(set(ports)) == 2
        for junk in JUNK:
            assert b"Content-Security-Policy" not in answer(ports[0], junk)  # as the page has
        for view in views:
            view.send_signal(signal.SIGINT)
        for view in views:
            assert view.communicate(timeout=HANG)[1] == b""
            assert view.returncode == 0


def test_two_views_end_with_a_test_that_fails(folder: Path) -> None:
    """Whatever happens beside them, they end with the test."""
    with pytest.raises(ZeroDivisionError), two_views() as views:
        raise ZeroDivisionError
    assert [view.returncode for view in views] == [-signal.SIGKILL, -signal.SIGKILL]


@contextmanager
def two_views() -> Iterator[list[subprocess.Popen]]:
    """Two views that Ctrl-C ends, also where the tests run in the background, in which shells switch that off."""
    line, pipe = [*COMMAND, "view", "run.npz"], subprocess.PIPE
    ctrl_c_on = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)  # noqa: E731
    with ExitStack() as ends:
        views = []
        for _ in range(2):
            view = subprocess.Popen(line, env=PLAIN, stdout=pipe, stderr=pipe, preexec_fn=ctrl_c_on)
            views.append(ends.enter_context(view))
            ends.callback(view.kill)
        yield views


def answer(port: int, junk: bytes) -> bytes:
    """What comes back; nothing where the connection is dropped, which may be while the junk is still being sent."""
    with suppress(ConnectionError), socket.create_connection(("127.0.0.1", port), timeout=HANG) as end:
        end.sendall(junk)
        end.shutdown(socket.SHUT_WR)
        return end.recv(10_000)
    return b""
