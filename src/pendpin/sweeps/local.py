"""A Dask cluster of processes on this machine, for one sweep: on 127.0.0.1 only, and without web pages.

distributed is imported here: import this module late.
"""

import logging
import signal
from asyncio import ensure_future
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing import active_children
from multiprocessing.resource_tracker import ensure_running
from threading import Event
from typing import Any

from distributed import Nanny, Scheduler, SpecCluster, Worker
from tornado.ioloop import PeriodicCallback

from pendpin.errors import RunError
from pendpin.simulation.processes import GUARD

STARTS = 5  # tries
RENEWED = 3  # s between two looks at the processes
HOST = {"host": "127.0.0.1"}


class _WithoutPages:
    """A node of a cluster without its HTTP server, which listens even where no dashboard is asked for."""

    def start_http_server(self, *_: object, **__: object) -> None:
        """Nothing."""


class LocalScheduler(_WithoutPages, Scheduler):
    """Gives out the blocks, from a thread of this process."""


class LocalWorker(_WithoutPages, Worker):
    """Runs blocks in a process of its own, which its Nanny starts again should it die."""


class LocalCluster(SpecCluster):
    """A scheduler in this process with workers beside it; one that is lost for good has another in its place."""

    async def _start(self) -> None:
        await super()._start()
        self._without = set[Any]()  # names of the workers that had no process at the last look
        self.periodic_callbacks["renew"] = callback = PeriodicCallback(self._renew, 1000 * RENEWED)
        callback.start()

    def _renew(self) -> None:
        """Replace the workers that twice have no process: a Nanny gives up if one is killed while it starts."""
        without = {name for name, nanny in self.workers.items() if not nanny.is_alive()}
        for name in without & self._without:
            self._futures.add(ensure_future(self.workers.pop(name).close()))
        self._without = without
        self.scale(len(self.worker_spec))


@contextmanager
def cluster_of(workers: int) -> Iterator[Any]:
    """A cluster of so many processes; it ends with its context, and with this process. Raises RunError.

    Ctrl-C ends the start at once, and only this process sees it: signals that a thread blocks are blocked in the threads
    and processes that it starts.
    """
    stopped = Event()
    with (
        _silent("asyncio"),
        _silent("tornado.application"),
        ThreadPoolExecutor(1, initializer=_block_interrupts) as pool,
    ):
        starting = pool.submit(_started, workers, stopped)
        try:
            with starting.result() as cluster:
                yield cluster
        except KeyboardInterrupt:
            if not starting.done():
                stopped.set()
                for child in active_children():
                    child.kill()
                with suppress(RunError):
                    starting.result().close()
            raise


def _started(workers: int, stopped: Event) -> Any:
    nanny = {
        "cls": Nanny,
        "options": HOST | {"nthreads": 1, "worker_class": LocalWorker, "silence_logs": logging.CRITICAL},
    }
    for _ in range(STARTS):
        if stopped.is_set():
            break
        with suppress(RuntimeError):  # a process was killed before it was ready
            return LocalCluster(
                workers=dict.fromkeys(range(workers), nanny),
                scheduler={"cls": LocalScheduler, "options": HOST | {"dashboard": False}},
                silence_logs=logging.CRITICAL,  # type: ignore[arg-type]
                shutdown_on_close=False,  # at the end of the process: the context does it
            )
    raise RunError(f"workers: {workers} processes could not be started; {GUARD}")


def _block_interrupts() -> None:
    """Block Ctrl-C in this thread; multiprocessing's tracker of resources, once it runs, does not unblock it."""
    ensure_running()
    if hasattr(signal, "pthread_sigmask"):  # not on Windows
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


@contextmanager
def _silent(name: str) -> Iterator[None]:
    """Nothing but what is critical from a logger: of processes that were killed, others speak."""
    logger = logging.getLogger(name)
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(level)
