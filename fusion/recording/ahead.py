"""Frames read, or worked on, beside the work on those before them: decoding images leaves Python's lock alone, and so
does NumPy where arrays are large."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Read = TypeVar("Read")
READERS = 2  # threads; as many frames wait in memory


def ahead(read: Callable[[int], Read], indices: Iterable[int]) -> Iterator[Callable[[], Read]]:
    """For each index, in order, a function that gives what was read, or raises what reading raised."""
    pool = ThreadPoolExecutor(READERS)
    under_way = deque[Callable[[], Read]]()
    try:
        for index in indices:
            under_way.append(pool.submit(read, index).result)
            if len(under_way) > READERS:
                yield under_way.popleft()
        yield from under_way
    finally:
        pool.shutdown(cancel_futures=True)
