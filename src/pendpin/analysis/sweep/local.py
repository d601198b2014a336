"""A Dask cluster of processes on this machine, for one sweep: on 127.0.0.1 only, and without web pages.

distributed is imported here: import this module late.
"""

import logging

from distributed import Nanny, Scheduler, SpecCluster, Worker

from pendpin.errors import RunError

STARTS = 5  # tries
HOST = {"host": "127.0.0.1"}


class _WithoutPages:
    """A node of a cluster without its HTTP server, which listens even where no dashboard is asked for."""

    def start_http_server(self, *_: object, **__: object) -> None:
        """Nothing."""


class LocalScheduler(_WithoutPages, Scheduler):
    """Gives out the blocks, from a thread of this process."""


class LocalWorker(_WithoutPages, Worker):
    """Runs blocks in a process of its own, which its Nanny starts again should it die."""


def cluster_of(workers: int) -> SpecCluster:
    """A cluster of so many processes; it ends with its context, and with this process. Raises RunError."""
    for _ in range(STARTS):
        try:
            return _started(workers)
        except RuntimeError:  # a process was killed before it was ready
            continue
    raise RunError(f"workers: {workers} processes could not be started")


def _started(workers: int) -> SpecCluster:
    nanny = {
        "cls": Nanny,
        "options": HOST | {"nthreads": 1, "worker_class": LocalWorker, "silence_logs": logging.CRITICAL},
    }
    return SpecCluster(
        workers=dict.fromkeys(range(workers), nanny),
        scheduler={"cls": LocalScheduler, "options": HOST | {"dashboard": False}},
        silence_logs=logging.CRITICAL,  # type: ignore[arg-type]
    )
