"""Frames read, or worked on, beside the work on those before them: decoding images leaves Python's lock alone, and so
does NumPy where arrays are large."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Read = TypeVar("Read")
READERS = 2  # threads; as many frames wait in memory


def ahead(read: Callable[[Item], Read], items: Iterable[Item]) -> Iterator[Callable[[], Read]]:
    """For each item, as an index, in order, a function that gives what was read of it, or raises what that raised."""
    pool = ThreadPoolExecutor(READERS)
    under_way = deque[Callable[[], Read]]()
    try:
        for item in items:
            under_way.append(pool.submit(read, item).result)
            if len(under_way) > READERS:
                yield under_way.popleft()
        yield from under_way
    finally:
        pool.shutdown(cancel_futures=True)


def side_by_side(work: Callable[[Item], Read], items: Iterable[Item]) -> list[Read]:
    """What is made of each item, in their order, two of them at a time; raises what the work on the first raised."""
    return [made() for made in ahead(work, items)]
