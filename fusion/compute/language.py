"""What files with kernels are written in: Taichi, and the marks of a kernel and of a function that kernels call."""

from fusion.compute.launch import kernel
from fusion.compute.taichi_copy import kernel_impl, ti

__all__ = ["func", "kernel", "ti"]

func = kernel_impl.func
