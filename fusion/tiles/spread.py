"""Tiles on other processes: a piece depends on its tile alone, so it is the same wherever it is made."""

from collections.abc import Iterator
from typing import Any

from fusion.tiles.fusing import Outcome, TileJob, Way, done

AHEAD = 2  # jobs handed out for each worker, so that none waits


def spread(client: Any) -> Way:
    """Jobs done by the workers of a Dask client (`distributed.Client`); they see the same files."""
    import distributed

    def way(waiting: list[TileJob]) -> Iterator[tuple[TileJob, Outcome]]:
        under_way: dict[Any, TileJob] = {}
        while waiting or under_way:
            room = AHEAD * max(len(client.scheduler_info()["workers"]), 1)
            while waiting and len(under_way) < room:
                job = waiting.pop()
                under_way[client.submit(done, job, pure=False)] = job
            for future in distributed.wait(list(under_way), return_when="FIRST_COMPLETED").done:
                yield under_way.pop(future), future.result()

    return way
