"""Libraries that may be missing, C functions of theirs, their versions; and a cache of what a thread computed lately."""

import atexit
import ctypes
import signal
import sys
from collections.abc import Callable, Hashable, Mapping
from contextlib import suppress
from contextvars import copy_context
from functools import cache, partial
from importlib import import_module
from importlib.machinery import ExtensionFileLoader
from importlib.util import find_spec
from math import inf
from pathlib import Path
from threading import Event, Thread, Timer, current_thread, local, main_thread
from time import monotonic
from types import FrameType, SimpleNamespace
from typing import Any, Generic, TypeVar

from pendpin.errors import MissingLibrary, say_note

T = TypeVar("T")
# s, after which a wait for another thread begins anew: Ctrl-C does not wake one whose signal another thread has taken, or
# which it reached as it queued for the interpreter (CPython 3.11: 2 of 200 sweeps in threads went on for a minute).
TICK = 0.1
abandoned: list[Thread] = []  # computations that could not be stopped


def optional(library: str, what: str, package: str) -> Any:
    """A library that need not be installed. Raises MissingLibrary, which says what needs it and what to install."""
    try:
        return import_module(library)
    except ImportError:
        raise MissingLibrary(f"{what} needs {library.partition('.')[0]}: pip install {package}") from None


def wait_for(compute: Callable[[], T], seconds: float | None = None) -> T:
    """What C or C++ computes, in a thread that Ctrl-C need not wait for, nor this call after `seconds` (TimeoutError)."""
    if seconds is None and current_thread() is not main_thread():  # which Ctrl-C does not reach
        return compute()
    outcome, ended = list[T | BaseException](), Event()

    def work() -> None:
        try:
            outcome.append(compute())
        except BaseException as error:  # raised in the thread that waits
            outcome.append(error)
        ended.set()

    thread = Thread(target=copy_context().run, args=(work,), daemon=True)
    try:
        thread.start()
        end = inf if seconds is None else monotonic() + seconds
        while not outcome and (left := end - monotonic()) > 0.0:  # a join that is interrupted takes the thread for one
            ended.wait(min(TICK, left))  # that has ended
    finally:
        if not outcome and thread.ident is not None:
            abandoned.append(thread)
            atexit.register(thread.join)
    if not outcome:
        raise TimeoutError
    if isinstance(outcome[0], BaseException):
        raise outcome[0]
    return outcome[0]


def heed_interrupts() -> None:
    """Let no Ctrl-C be lost, as 1 of 200 sweeps went on after it: KeyboardInterrupt is raised again where Python ignores it.

    That is in what it calls as an object goes; and as a module in C begins, where Cython swallows what is raised. Signals
    belong to the main thread: in another one nothing is done.
    """
    if current_thread() is not main_thread():
        return

    def again() -> None:
        timer = Timer(TICK / 10, signal.pthread_kill, (main_thread().ident, signal.SIGINT))
        timer.daemon = True
        timer.start()

    def interrupt(number: int, frame: FrameType | None) -> None:
        while frame:
            if isinstance(frame.f_locals.get("self"), ExtensionFileLoader):
                return again()
            frame = frame.f_back
        raise KeyboardInterrupt

    def ignored(what: Any) -> None:
        if what.exc_type is KeyboardInterrupt:
            again()
        else:
            before(what)

    signal.signal(signal.SIGINT, interrupt)
    before, sys.unraisablehook = sys.unraisablehook, ignored


def heyoka() -> Any:
    """The library, imported. Raises MissingLibrary."""
    # one that another thread still imports, as after a limit, is waited for, and not taken half imported
    imported = partial(optional, "heyoka", "solver.method: taylor", "heyoka")
    return imported() if "heyoka" in sys.modules else wait_for(imported)


def c_functions(package: str, file: str, names: Mapping[str, tuple[str, Any, tuple[Any, ...]]]) -> Any:
    """Functions in a file of a package that is not imported: `names` has symbol, result, arguments. OSError and others."""
    spec = find_spec(package)
    assert spec is not None
    assert spec.origin is not None
    (path,) = Path(spec.origin).parent.glob(file)
    library, functions = ctypes.CDLL(str(path)), {}
    for name, (symbol, result, arguments) in names.items():
        functions[name] = library[symbol]
        functions[name].restype, functions[name].argtypes = result, arguments
    return SimpleNamespace(**functions)


def say_unused(library: str, reason: str) -> None:
    """A note, at the line of the caller's caller, that a library is there and cannot be used."""
    say_note(f"{library} is not used, and runs take about 8 times as long: {reason}", stacklevel=4)


VERSION = "0.1.0"


def installed(*libraries: str) -> dict[str, str | None]:
    """The versions of libraries by the names of their packages; None for one that is not installed."""
    versions: dict[str, str | None] = dict.fromkeys(libraries)
    for name in libraries:
        with suppress(ImportError):  # PackageNotFoundError is one
            versions[name] = version(name)
    return versions


_find = cache(find_spec)  # of a library that is not imported it takes a fifth of a millisecond


def is_there(library: str) -> bool:
    """Whether a library is installed, without importing it."""
    return sys.modules[library] is not None if library in sys.modules else _find(library) is not None


@cache
def version(library: str) -> str:
    """The version of an installed library by the name of its package; reading it takes a millisecond, once."""
    from importlib import metadata

    return metadata.version(library)


class Recent(Generic[T]):
    """The results of the last few keys asked for."""

    def __init__(self, most: int) -> None:
        self._most, self.known = most, dict[Hashable, T]()

    def look_up(self, key: Hashable, make: Callable[[], T], lasts: Callable[[], bool] = lambda: True) -> T:
        """The result of a key, made if it is not known; what does not last, or has a key without a hash, is not kept."""
        try:
            found = self.known.pop(key, None)
        except TypeError:  # as of a user's own effect that holds a list
            return make()
        made = make() if found is None else found
        if found is not None or lasts():
            self.known[key] = made  # behind those that were not asked for since
        while len(self.known) > self._most:
            self.known.pop(next(iter(self.known)))
        return made


class ThreadCache(local, Recent[T]):
    """The same for each thread, as what is kept may hold scratch memory."""
