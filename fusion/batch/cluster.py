"""Workers: of this machine, or of a scheduler that runs already."""

import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread
from typing import Any

from fusion.errors import FusionError
from fusion.files.extra import extra

CONNECT_S = 10  # to reach a scheduler
KILLED = 5  # times that a job's worker may die before that counts as the job's fault
LOOK_S = 1.0  # between two looks at how many workers there are
MISSED_S = 30.0  # without enough of them until others are started: a killed one comes back within some seconds


@contextmanager
def client_of(workers: int, scheduler: str | None, what: str = "fusion batch") -> Iterator[Any]:
    """A Dask client, with its cluster for as long as the block runs.

    Args:
        workers: processes of one job each, on this machine.
        scheduler: address of another one ("tcp://host:8786"), whose workers are used instead.

    Raises:
        FusionError: dask is not installed, or nobody answers.
    """
    distributed = extra("distributed", "batch", what, "")
    dask = extra("dask", "batch", what, "")
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # a killed worker is no news: its job runs elsewhere
    quiet = {"distributed.scheduler.allowed-failures": KILLED, "distributed.admin.large-graph-warning-threshold": "1GB"}
    with dask.config.set(quiet):
        if scheduler is None:
            with (
                distributed.LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    memory_limit=0,  # jobs have their own
                    dashboard_address="127.0.0.1:0",  # a free port; no page there
                    scheduler_kwargs={"dashboard": False},
                    silence_logs=logging.CRITICAL,
                ) as cluster,
                distributed.Client(cluster) as client,
                _kept_up(cluster, workers),
            ):
                yield client
            return
        try:
            client = distributed.Client(scheduler, timeout=CONNECT_S)
        except (OSError, TimeoutError, ValueError) as error:
            do = "start one: dask scheduler, and dask worker ADDRESS on each machine"
            raise FusionError("no scheduler answers", "--scheduler", scheduler, "tcp://HOST:PORT", do) from error
        with client:
            yield client


@contextmanager
def _kept_up(cluster: Any, workers: int) -> Iterator[None]:
    """Others take the place of workers that do not come back.

    Dask begins a killed worker anew, but not one that is killed while it is just beginning; without any all would wait.
    """
    done = Event()

    def watch() -> None:
        enough = time.monotonic()
        while not done.wait(LOOK_S):
            missing = workers - len(cluster.scheduler.workers)
            if missing <= 0:
                enough = time.monotonic()
            elif time.monotonic() - enough > MISSED_S:
                cluster.scale(len(cluster.worker_spec) + missing)
                enough = time.monotonic()

    thread = Thread(target=watch, name="fusion-workers", daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()
