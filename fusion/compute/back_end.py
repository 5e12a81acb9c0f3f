"""What compiles kernels and runs them: Taichi, or Quadrants where FUSION_KERNELS names it; one for a process."""

from threading import RLock

from fusion.compute.choice import quadrants

if quadrants():
    from fusion.compute.back_ends.quadrants_copy import KEPT, KNOWN, NAME, compiled, func, init, reading, ti
else:
    from fusion.compute.back_ends.taichi_copy import KEPT, KNOWN, NAME, compiled, func, init, reading, ti

__all__ = ["KEPT", "KNOWN", "NAME", "PROCESSORS", "compiled", "func", "init", "reading", "ti", "turn"]

# it reads one kernel at a time: which one is kept for the whole process, and Python changes threads meanwhile
turn = RLock()

PROCESSORS = (ti.x64, ti.arm64)  # not a card, with memory of its own
