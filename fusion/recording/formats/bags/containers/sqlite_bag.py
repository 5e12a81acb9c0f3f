"""Bags of ROS 2 in SQLite files: its recorder's until 2023, and RealSense's since 2026. Tables `topics`, `messages`."""

import sqlite3
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.limits import check_size
from fusion.files.reading import beginning
from fusion.recording.formats.bags.containers.packed import ZSTD, unpack_message
from fusion.recording.formats.bags.containers.store import MOST_MESSAGES, Store, Topic, cut, falls, short_type
from fusion.recording.formats.not_read import SQLITE, tables

SERIALIZED = ("", "cdr")


def recognises(path: Path) -> bool:
    """True for an SQLite file with the tables of a bag."""
    return beginning(path, len(SQLITE)) == SQLITE and {"topics", "messages"} <= tables(path)


def read(path: Path) -> Store:
    """The topics of a bag. Raises RecordingError."""
    source = _Base(path)
    with source.asked() as base:
        rows = base.execute("SELECT id, name, type, serialization_format FROM topics LIMIT 10000").fetchall()
        (count,) = base.execute("SELECT COUNT(*) FROM messages").fetchone()
        if count > MOST_MESSAGES:
            raise RecordingError("the bag has too many messages", path, count, f"at most {MOST_MESSAGES}")
        index = np.array(base.execute("SELECT topic_id, timestamp, id FROM messages").fetchall() or [(0, 0, 0)])
    if index.dtype != np.int64:
        raise cut(path, "messages without a number or a stamp")
    topics, definitions = {}, _definitions(source)
    for number, name, kind, form in rows:
        mine = index[index[:, 0] == number] if count else index[:0]
        mine = mine[np.argsort(mine[:, 1], kind="stable")]
        # what is not CDR is no message that is read here
        if len(mine) and str(form) in SERIALIZED:
            read_one = partial(_message, source, mine[:, 2].copy())
            stamps, kind = mine[:, 1].copy(), short_type(str(kind))
            topics[str(name)] = Topic(
                str(name), kind, stamps, read_one, definitions.get(kind, ""), steps_back=falls(stamps, mine[:, 2])
            )
    return Store(path, topics)


def _definitions(source: "_Base") -> dict[str, str]:
    """Text of each type's definition, which newer bags hold."""
    if "message_definitions" not in tables(source.path):
        return {}
    query = "SELECT topic_type, encoded_message_definition, encoding FROM message_definitions LIMIT 10000"
    try:
        with source.asked() as base:
            return {short_type(str(kind)): str(text) for kind, text, how in base.execute(query) if how == "ros2msg"}
    except RecordingError:  # the built-in ones serve
        return {}


def _message(source: "_Base", rows: NDArray[np.int64], index: int, most: int = -1) -> bytes:
    path = source.path
    with source.asked() as base:
        try:
            with base.blobopen("messages", "data", int(rows[index]), readonly=True) as blob:
                check_size(len(blob), path, RecordingError, "a message")
                data = blob.read(most)
                if data.startswith(ZSTD):
                    data = data if most < 0 else data + blob.read()
        except ValueError as problem:
            raise cut(path, f"message {index}: {problem}") from problem
    if data.startswith(ZSTD):
        data = unpack_message(data, path)
    return data if most < 0 else data[:most]


class _Base:
    """The file, open to be read until nobody holds it, by one thread at a time."""

    def __init__(self, path: Path) -> None:
        self.path, self._lock = path, Lock()
        # what a recorder that was stopped left beside it (a log of its last writes) is read too
        log = path.with_name(path.name + "-wal")
        how = "mode=ro" if log.is_file() and not log.is_symlink() else "mode=ro&immutable=1"
        try:
            self._base = sqlite3.connect(f"{path.resolve().as_uri()}?{how}", uri=True, check_same_thread=False)
            weakref.finalize(self, self._base.close)
            self._base.execute("PRAGMA trusted_schema = OFF")
        except sqlite3.Error as problem:
            raise cut(path, str(problem)) from problem

    @contextmanager
    def asked(self) -> Iterator[sqlite3.Connection]:
        """The connection; what goes wrong with it becomes a RecordingError."""
        try:
            with self._lock:
                yield self._base
        except (sqlite3.Error, OverflowError) as problem:
            raise cut(self.path, str(problem)) from problem
