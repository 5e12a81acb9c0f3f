"""Memory that serves again, in the hands of one call at a time.

Fresh memory would cost more than filling it. Kept as a cache keeps things, it would be handed to every call that asks
for the same: two threads would write to one image. Here it is taken out, so nobody else can get it, and put back when
its user is done. What two calls want at the same time is made twice.
"""

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Thing = TypeVar("Thing")


class Spare(Generic[Key, Thing]):
    """Things that were made for a key, such as a camera, and are not in use now."""

    def __init__(self, make: Callable[[Key], Thing], most: int) -> None:
        """Of what lies here unused, `most` things are kept, those that were used last."""
        self._make = make
        self._most = most
        self._unused: list[tuple[Key, Thing]] = []
        self._lock = Lock()

    @contextmanager
    def taken(self, key: Key) -> Iterator[Thing]:
        """A thing of that key, the block's alone; after an error it is not used again, as it may be half written."""
        thing = self._take(key)
        if thing is None:
            thing = self._make(key)
        yield thing
        with self._lock:
            self._unused.append((key, thing))
            del self._unused[: -self._most]

    def _take(self, key: Key) -> Thing | None:
        with self._lock:
            for n in reversed(range(len(self._unused))):
                if self._unused[n][0] == key:
                    return self._unused.pop(n)[1]
        return None

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        """A copy begins without spare memory, and with a lock of its own."""
        return type(self), (self._make, self._most)
