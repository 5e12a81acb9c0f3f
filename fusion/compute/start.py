"""The only place that starts the back end: one device, chosen once, silent, kernels cached."""

import contextlib
import ctypes
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

from fusion.compute import choice
from fusion.compute.back_end import PROCESSORS, init, ti, turn
from fusion.compute.cards.best_card import best_card
from fusion.compute.kept import kept_in
from fusion.compute.modules import said
from fusion.compute.process import own_process
from fusion.errors import FusionError
from fusion.progress import note

FEW = 4  # processor cores; with more, two threads that share one cost little
KINDS = {"cpu": ti.cpu, "cuda": ti.cuda, "vulkan": ti.vulkan}


def start() -> str:
    """Start the back end once for this process, on the device that the variable FUSION_DEVICE names, or the processor.

    With `auto` it is a card that passes a check of a few seconds, in a process of its own, else the processor.

    Returns:
        The name of the device.

    Raises:
        FusionError: there is no such device here.
    """
    with turn:  # the first of several threads; the others wait until all is there
        return _started()


@cache
def _started() -> str:
    name = os.environ.get("FUSION_DEVICE") or "cpu"
    if name == "auto":
        name = best_card() or "cpu"
        note(f"kernels run on: {name}")
    if name not in KINDS:
        raise FusionError("unknown device", "FUSION_DEVICE", name, ", ".join(choice.DEVICES))
    kept = kept_in()
    before = _threads()
    # a thread in which it starts takes numbers near 0 for 0 from then on, in numpy too: it gets one that ends
    with ThreadPoolExecutor(1) as aside:
        aside.submit(_init, KINDS[name], kept).result()
    config = ti.lang.impl.current_cfg()
    if own_process():
        _keep_memory()
        _spread(sorted(_threads() - before)[-config.cpu_max_num_threads :])
    running = config.arch
    if name != "cpu" and running != KINDS[name]:  # it takes the processor without a word
        raise FusionError("no such device here", "--device or FUSION_DEVICE", name, "cpu", "leave it out")
    if running not in PROCESSORS:
        from fusion.compute.cards.promises import broken_promise  # kernels: they need a device that has started

        if broken := broken_promise():
            where = "--device or FUSION_DEVICE"
            raise FusionError("this device computes wrong", where, f"{name}: {broken}", "cpu", "leave it out")
        choice.run_plain()
    return name


def _init(device: object, kept: Path | None) -> None:
    with said():  # it asks for a home, though it is told where to keep what it compiles
        init(
            arch=device,
            log_level=ti.ERROR,
            offline_cache=kept is not None,
            offline_cache_file_path=str(kept or "."),  # it asks for a path even so
            default_fp=ti.f32,
            default_ip=ti.i32,
            fast_math=False,
        )
    ti.lang.impl.get_runtime().materialize()  # what only the thread may do in which it was started


def keep_kernels() -> None:
    """Keep what was compiled anew, as the back end does in a process' end; no kernel runs after it."""
    if (program := ti.lang.impl.get_runtime().prog) is not None:
        program.finalize()


def _keep_memory() -> None:
    """Images come and go with every frame; glibc would give their memory back to the system and ask for it anew, and
    a page that is new costs many times what filling it does. Measured on a point map of 640 x 480 px: 1.1 of 2.4 ms."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError, AttributeError):  # another C library
            library = ctypes.CDLL(None)
            library.mallopt(-3, 16 << 20)  # M_MMAP_THRESHOLD: up to this size [bytes] memory comes from the heap,
            library.mallopt(-1, 256 << 20)  # M_TRIM_THRESHOLD: which keeps that much


def _threads() -> set[int]:
    """Of this process, where Linux tells them."""
    tasks = Path("/proc/self/task")
    return {int(task.name) for task in tasks.iterdir()} if tasks.exists() else set()


def _spread(workers: list[int]) -> None:
    """One of the threads that kernels run on, the back end's latest, to each core.

    The thread that wakes two of them keeps its own core busy meanwhile, so Linux often puts both on the other one: a
    kernel then takes as long as on one core, though the other is free.
    """
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        if len(workers) == len(cores) <= FEW:
            with contextlib.suppress(OSError):
                for worker, core in zip(workers, cores, strict=True):
                    os.sched_setaffinity(worker, {core})
