"""Who runs many blocks of cases: threads of this process, other processes of this machine, or a Dask cluster of the user.

Processes end when the process that started them ends, for any reason.
"""

import os
import pickle
import signal
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from itertools import islice
from multiprocessing import get_context
from multiprocessing.connection import Connection
from queue import Empty, SimpleQueue
from threading import Event, Thread
from typing import Any

from pendpin.errors import InputError, Interrupted, RunError
from pendpin.ground.libraries import TICK, is_there, optional
from pendpin.runs.checkpoint import versions

AHEAD = 3  # blocks given out for each worker, which bounds the memory
DEATHS = 100  # of workers, until a block is given up
PATIENCE = 60  # s without a block, or for its result, until it is asked whether workers are left
EXTRA = "xarray zarr cloudpickle dask distributed"  # the libraries of a sweep

Results = Generator[tuple[int, Any], None, None]  # of blocks as they are completed, each with the index of its span
Span = tuple[int, int]  # the first case of a block, and the one behind its last


def cores() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run_all(
    results: Results,
    spans: Sequence[Span],
    count: int,
    put: Callable[[int, Any], None],
    progress: Callable[[int], None],
    cases: str,
    so_far: Callable[[str], Any],
) -> None:
    """Put the result of each block as it comes; `progress` is called with the number of finished cases, of `count`.

    Raises Interrupted after Ctrl-C, RunError where a worker is lost, with the result `so_far` for this reason as `partial`.
    """
    done = count - sum(end - begin for begin, end in spans)
    try:
        progress(done)
        for place, result in results:
            put(place, result)
            done += spans[place][1] - spans[place][0]
            progress(done)
    except (KeyboardInterrupt, Interrupted):
        reason = "stopped by the user"
        raise Interrupted(f"{reason} after {done} of {count} {cases}", so_far(reason)) from None
    except RunError as error:
        raise RunError(str(error), so_far(str(error))) from None
    finally:
        results.close()  # ends what still runs


def end_if_stopped(stopped: Event, t: float = 0.0) -> None:
    """Raise Interrupted once `stopped` is set: a progress callback of the runs in a block."""
    if stopped.is_set():
        raise Interrupted("stopped by the user")


def in_threads(run: Callable[[int, int, Event], Any], spans: Sequence[Span], workers: int) -> Results:
    """The results of blocks from threads of this process; closing the iterator sets the event, and begins no more."""
    pool, stopped = ThreadPoolExecutor(workers), Event()
    try:
        places = {pool.submit(run, *span, stopped): place for place, span in enumerate(spans)}
        for done in _as_completed(list(places)):
            yield places.pop(done), done.result()  # popped, so that a result that was read takes no memory
    finally:
        stopped.set()
        pool.shutdown(cancel_futures=True)


def in_processes(run: Callable[[int, int], Any], spans: Sequence[Span], workers: int) -> Results:
    """The same from processes, to which `run` is sent once; closing the iterator ends them. RunError where one dies."""
    packer = optional("cloudpickle", "work in processes", EXTRA) if is_there("cloudpickle") else pickle
    packed = packer.dumps(run)  # by cloudpickle functions of a script too
    context = get_context("spawn")  # heyoka and BLAS have threads, which a fork does not survive
    listening, open_end = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(workers, context, _begin_process, (listening, packed))
    try:
        blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # Ctrl-C is for this process alone
        try:
            places = {pool.submit(_run_span, *span): place for place, span in enumerate(spans)}
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        for done in _as_completed(list(places)):
            yield places.pop(done), done.result()
        pool.shutdown()
    except BrokenProcessPool:
        remedy = 'in a script put the call under `if __name__ == "__main__":`; if memory ran out, take fewer workers'
        raise RunError(f"a worker process has ended unexpectedly; {remedy}") from None
    finally:
        open_end.close()  # ends the running processes
        pool.shutdown(cancel_futures=True)


def _as_completed(futures: list[Future[Any]]) -> Iterator[Future[Any]]:
    """As that of concurrent.futures, which a signal does not always wake (libraries.TICK)."""
    completed = SimpleQueue[Future[Any]]()
    for future in futures:
        future.add_done_callback(completed.put)
    count = len(futures)
    futures.clear()  # so that a result that was read takes no memory
    while count:
        with suppress(Empty):
            done = completed.get(timeout=TICK)
            count -= 1
            yield done


_run: Any = None  # of a process: packed until its first span


def _begin_process(link: Connection, packed: bytes) -> None:
    """Keep what is run, and end this process when the other end of the link is closed, also by the end of its process."""
    global _run
    _run = packed

    def wait() -> None:
        with suppress(EOFError, OSError):
            link.recv_bytes()
        os._exit(1)

    Thread(target=wait, daemon=True).start()


def _run_span(begin: int, end: int) -> Any:
    global _run
    _run = pickle.loads(_run) if isinstance(_run, bytes) else _run
    return _run(begin, end)


# --- a Dask cluster --------------------------------------------------------------------------------------------------


def run_on_cluster(
    run: Callable[..., Any], make: Callable[..., Any], given: Sequence[Any], spans: Sequence[Span], address: str
) -> Results:
    """The results of run(make(*given), begin, end) from a Dask cluster; `make` is called once, lost blocks are run again."""
    with _remote_cluster(address) as client:
        from distributed import wait as wait_for_one

        shared, left = client.submit(make, *given, pure=False), iter(enumerate(spans))
        places: dict[str, int] = {}

        def submit(count: int) -> set[Any]:
            futures = set()
            for place, span in islice(left, count):
                future = client.submit(run, shared, *span, pure=False, retries=DEATHS)
                places[future.key] = place
                futures.add(future)
            return futures

        running = submit(AHEAD * max(1, len(client.scheduler_info()["workers"])))
        while running:
            try:
                now: Any = wait_for_one(running, timeout=PATIENCE, return_when="FIRST_COMPLETED")
                future = next(iter(now.done))
                block = future.result(PATIENCE)  # which may have been lost with its worker, and is then run again
            except TimeoutError:
                if not client.scheduler_info()["workers"]:
                    raise RunError("every worker of the cluster is lost; the same command resumes the sweep") from None
                continue
            except Exception as error:
                raise RunError(f"a worker of the cluster failed: {type(error).__name__}: {error}") from None
            yield places.pop(future.key), block
            running = running - {future} | submit(1)


@contextmanager
def _remote_cluster(address: str) -> Iterator[Any]:
    """A client of a cluster that runs already. Raises InputError where none answers, or workers have other libraries."""
    dask, distributed = (optional(name, "a sweep on a cluster", EXTRA) for name in ("dask", "distributed"))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of versions that matter to nobody; ours are checked below
            client = distributed.Client(address, timeout=10)  # s
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(f"dask: no cluster answers at {address}: {error}") from None
    with dask.config.set({"distributed.scheduler.allowed-failures": DEATHS}), client:
        if not client.scheduler_info()["workers"]:
            raise InputError(f"dask: the cluster at {address} has no workers; start one: dask worker {address}")
        ours = versions()
        try:
            by_worker = client.run(versions)
        except Exception as error:
            raise InputError(f"dask: a worker cannot run pendpin: {error}; install it there as here") from None
        for worker, theirs in by_worker.items():
            for name, version in ours.items():
                if theirs.get(name) != version:
                    there = f"has {name} {theirs.get(name) or 'not at all'}, and this process {version}"
                    raise InputError(f"dask: the worker {worker} {there}: install the same versions")
        yield client
