"""Two calls at the same time, compared bit by bit with the same two one after the other."""

import dataclasses
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import Struct

SWITCH = 1e-4  # [s] between two switches of thread: fifty times as often as usual finds more in as many rounds
PATIENCE = 300  # [s] for both threads


def compared(
    first: Callable[[], Any],
    second: Callable[[], Any],
    rounds: int,
    expected: list[dict[str, Any]] | None = None,
) -> list[str]:
    """What differs, in words, when two calls are made `rounds` times at once; nothing when all is well.

    `expected`: what both gave alone (`flat`), where that is known from an earlier call.
    """
    calls = (first, second)
    if expected is None:
        expected = [flat(call()) for call in calls]
    found: list[list[str]] = [[], []]
    together = threading.Barrier(len(calls))

    def work(n: int) -> None:
        for k in range(rounds):
            together.wait(PATIENCE)
            try:
                found[n] += [f"round {k}, thread {n}: {d}" for d in differing(expected[n], flat(calls[n]()))]
            except Exception as error:
                found[n].append(f"round {k}, thread {n}: {type(error).__name__}: {error}")

    with switching_often():
        threads = [threading.Thread(target=work, args=(n,), daemon=True) for n in range(len(calls))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(PATIENCE)
            assert not thread.is_alive(), "a thread waits for ever"
    return found[0] + found[1]


@contextmanager
def switching_often() -> Iterator[None]:
    """While Python changes threads more often than it does by itself."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


def flat(value: Any, name: str = "result") -> dict[str, Any]:
    """All that a result holds, by where it stands: arrays as copies, files as their bytes, the rest as it prints."""
    found: dict[str, Any] = {}
    if isinstance(value, np.ndarray):
        found[name] = (value.dtype.str, value.shape, value.tobytes())
    elif isinstance(value, Path):
        for path in sorted(value.rglob("*")) if value.is_dir() else [value]:
            if path.is_file():
                found[f"{name}/{path.relative_to(value)}"] = path.read_bytes()
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        for field in dataclasses.fields(value):
            found |= flat(getattr(value, field.name), f"{name}.{field.name}")
    elif isinstance(value, Struct):
        for key in value.__struct_fields__:
            found |= flat(getattr(value, key), f"{name}.{key}")
    elif isinstance(value, dict):
        for key in value:
            found |= flat(value[key], f"{name}[{key!r}]")
    elif isinstance(value, (list, tuple)):
        found[name] = len(value)
        for n, item in enumerate(value):
            found |= flat(item, f"{name}[{n}]")
    elif isinstance(value, (str, bytes, bool, int, float, complex, np.generic, type(None))):
        found[name] = repr(value)
    elif hasattr(value, "__dict__"):
        found[name] = type(value).__name__
        for key in [key for key in vars(value) if not key.startswith("_")]:
            found |= flat(vars(value)[key], f"{name}.{key}")
    else:
        found[name] = type(value).__name__
    return found


def differing(expected: dict[str, Any], found: dict[str, Any]) -> list[str]:
    """Where two results are not the same, and how."""
    names = sorted(name for name in expected.keys() | found.keys() if expected.get(name) != found.get(name))
    return [f"{name} ({how(expected.get(name), found.get(name))})" for name in names]


def how(expected: Any, found: Any) -> str:
    """What a failure that comes once in months must tell at once: nothing there, another size, or other bytes."""
    if expected is None or found is None:
        return "missing" if found is None else "not expected"
    if isinstance(expected, tuple) and isinstance(found, tuple) and expected[:2] == found[:2]:  # arrays of one shape
        expected, found = expected[-1], found[-1]
    if not isinstance(expected, bytes) or not isinstance(found, bytes):
        return f"{str(expected)[:80]} became {str(found)[:80]}"
    places = [n for n, (a, b) in enumerate(zip(expected, found, strict=False)) if a != b]
    return f"{len(expected)} bytes became {len(found)}, {len(places)} differ, the first are {places[:5]}"


def rounds(usual: int) -> int:
    """How often a test repeats; FUSION_ROUNDS asks for another number."""
    return int(os.environ.get("FUSION_ROUNDS") or usual)
