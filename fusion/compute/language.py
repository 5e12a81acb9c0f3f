"""What files with kernels are written in: the back end's language, and the marks of a kernel and of a function that
kernels call."""

from fusion.compute.back_end import func, ti
from fusion.compute.launch import kernel

__all__ = ["func", "kernel", "ti"]
