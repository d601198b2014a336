"""Jobs shared among threads, or among processes that end when the process that started them ends, for any reason."""

import os
import signal
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from threading import Thread
from typing import TypeVar

from pendpin.errors import RunError

Job = TypeVar("Job")
Result = TypeVar("Result")

GUARD = 'in a script put the call under `if __name__ == "__main__":`'
DIED = f"a worker process has ended unexpectedly; {GUARD}; if memory ran out, take fewer workers"


def cores() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_threads(
    task: Callable[[Job], Result], jobs: Sequence[Job], workers: int, stop: Callable[[], None] = lambda: None
) -> Generator[tuple[int, Result], None, None]:
    """The results of `task`, in the order of completion, each with the index of its job, from threads of this process.

    Close the iterator to end them: `stop` tells running jobs to end early, and the rest is not begun.
    """
    pool = ThreadPoolExecutor(workers)
    try:
        yield from _results({pool.submit(task, job): place for place, job in enumerate(jobs)})
    finally:
        stop()
        pool.shutdown(cancel_futures=True)


def in_processes(
    task: Callable[[Job], Result], jobs: Sequence[Job], workers: int
) -> Generator[tuple[int, Result], None, None]:
    """The results of spans in their order, from several processes, or from this one where one worker is enough.

    Close the iterator to end them: they stop at once, as they do where this process is killed. What a task raises is
    raised here; RunError where a process dies.
    """
    if workers == 1:
        yield from ((place, task(job)) for place, job in enumerate(jobs))
        return
    context = get_context("spawn")  # heyoka and BLAS have threads, which a fork does not survive
    listening, open_end = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(workers, context, _tie, (listening,))
    try:
        with _without_interrupts():
            places = {pool.submit(task, job): place for place, job in enumerate(jobs)}
        yield from _results(places)
        pool.shutdown()
    except BrokenProcessPool:
        raise RunError(DIED) from None
    finally:
        open_end.close()  # ends the running processes
        pool.shutdown(cancel_futures=True)


def _results(places: dict[Future[Result], int]) -> Generator[tuple[int, Result], None, None]:
    for done in as_completed(places):
        yield places.pop(done), done.result()  # popped, so that a result that was read takes no memory


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Processes that start in the block do not receive Ctrl-C; this process handles it after the block."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _tie(link: Connection) -> None:
    """End this process when the other end of the link is closed, also by the end of its process."""

    def wait() -> None:
        with suppress(EOFError, OSError):
            link.recv_bytes()
        os._exit(1)

    Thread(target=wait, daemon=True).start()
