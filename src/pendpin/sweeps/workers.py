"""Who runs a sweep's blocks: threads of this process, other processes of this machine, or a Dask cluster of the user."""

import pickle
import warnings
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache, partial
from itertools import islice
from threading import Event
from typing import Any

from pendpin.errors import InputError, RunError
from pendpin.ground.libraries import optional
from pendpin.runs.batches.pools import in_processes, in_threads
from pendpin.sweeps.cases import run_block, vectors_of
from pendpin.sweeps.task import EXTRA, Block, Task, versions

AHEAD = 3  # blocks given out for each worker, which bounds the memory
DEATHS = 100  # of workers, until a block is given up
CONNECTING = 10  # s
PATIENCE = 60  # s without a block, until it is asked whether workers are left

Span = tuple[int, int]  # the first case of a block, and the one behind its last
Results = Generator[
    tuple[int, Block], None, None
]  # of blocks in the order of completion, each with the index of its span


def run_in_threads(task: Task, spans: Sequence[Span], workers: int) -> Results:
    """The blocks' results from threads of this process. Close the iterator to stop."""
    vectors, stopped = vectors_of(task), Event()  # made here, for all threads
    if vectors:
        for series in vectors.series:
            series.stopped = stopped
    return in_threads(lambda span: run_block(task, *span, stopped), spans, workers, stopped.set)


def run_in_processes(task: Task, spans: Sequence[Span], workers: int) -> Results:
    """The blocks' results from processes of this machine. Raises RunError where one dies."""
    packed = optional("cloudpickle", "a sweep in processes", EXTRA).dumps(task)  # pickle refuses functions of a script
    return in_processes(partial(_run_packed, packed), spans, workers)


def _run_packed(packed: bytes, span: Span) -> Block:
    return run_block(_unpacked(packed), *span)


@lru_cache(1)
def _unpacked(packed: bytes) -> Task:
    """The task, unpacked once in a process, so that its equations are compiled once."""
    return pickle.loads(packed)


def run_on_cluster(task: Task, spans: Sequence[Span], client: Any) -> Results:
    """The blocks' results from the workers of a Dask cluster; a block of a lost worker is run again by another."""
    from distributed import wait as wait_for_one

    shared, left = client.submit(Task, task.scene, task.plan, task.measures, pure=False), iter(enumerate(spans))
    places: dict[str, int] = {}

    def submit(count: int) -> set[Any]:
        futures = set()
        for place, span in islice(left, count):
            future = client.submit(run_block, shared, *span, pure=False, retries=DEATHS)
            places[future.key] = place
            futures.add(future)
        return futures

    running = submit(AHEAD * max(1, len(client.scheduler_info()["workers"])))
    while running:
        try:
            now: Any = wait_for_one(running, timeout=PATIENCE, return_when="FIRST_COMPLETED")
        except TimeoutError:
            if not client.scheduler_info()["workers"]:
                raise RunError("every worker of the cluster is lost; the same command resumes the sweep") from None
            continue
        running -= now.done
        for future in now.done:
            try:
                block = future.result()
            except Exception as error:
                raise RunError(f"a worker of the cluster failed: {type(error).__name__}: {error}") from None
            yield places.pop(future.key), block
        running |= submit(len(now.done))


@contextmanager
def remote_cluster(address: str) -> Iterator[Any]:
    """A client of a cluster that runs already. Raises InputError where none answers, or workers have other libraries."""
    dask, distributed = (optional(name, "a sweep on a cluster", EXTRA) for name in ("dask", "distributed"))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of versions that matter to nobody; ours are checked below
            client = distributed.Client(address, timeout=CONNECTING)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(f"dask: no cluster answers at {address}: {error}") from None
    with dask.config.set({"distributed.scheduler.allowed-failures": DEATHS}), client:
        if not client.scheduler_info()["workers"]:
            raise InputError(f"dask: the cluster at {address} has no workers; start one: dask worker {address}")
        _check_versions(client)
        yield client


def _check_versions(client: Any) -> None:
    """Raises InputError for workers with other versions than here, or without pendpin: their bits may differ."""
    ours = versions()
    try:
        by_worker = client.run(versions)
    except Exception as error:
        raise InputError(f"dask: a worker cannot run pendpin: {error}; install it there as here") from None
    for worker, theirs in by_worker.items():
        for name, version in ours.items():
            if theirs.get(name) != version:
                raise InputError(
                    f"dask: the worker {worker} has {name} {theirs.get(name) or 'not at all'}, and this process {version}: "
                    "install the same versions"
                )
