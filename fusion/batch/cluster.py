"""Workers: of this machine, or of a scheduler that runs already."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from fusion.errors import FusionError
from fusion.files.extra import extra

CONNECT_S = 10  # to reach a scheduler
KILLED = 5  # times that a job's worker may die before that counts as the job's fault


@contextmanager
def client_of(workers: int, scheduler: str | None, what: str = "fusion batch") -> Iterator[Any]:
    """A Dask client, with its cluster for as long as the block runs.

    Args:
        workers: processes of one job each, on this machine.
        scheduler: address of another one ("tcp://host:8786"), whose workers are used instead.
        what: needs them, as a message has it.

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
