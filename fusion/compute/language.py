"""What files with kernels are written in: the back end's language, the marks of a kernel and of a function that kernels
call, and the types of arrays by what they hold and the number of their dimensions."""

from fusion.compute.back_end import func, ti
from fusion.compute.launch import kernel

__all__ = ["func", "kernel", "ti"]

U8_2 = ti.types.ndarray(ti.u8, 2)
U8_3 = ti.types.ndarray(ti.u8, 3)
I32 = ti.types.ndarray(ti.i32, 1)
I32_2 = ti.types.ndarray(ti.i32, 2)
I64 = ti.types.ndarray(ti.i64, 1)
I64_2 = ti.types.ndarray(ti.i64, 2)
F32 = ti.types.ndarray(ti.f32, 1)
F32_2 = ti.types.ndarray(ti.f32, 2)
F32_3 = ti.types.ndarray(ti.f32, 3)
F64 = ti.types.ndarray(ti.f64, 1)
F64_2 = ti.types.ndarray(ti.f64, 2)
F64_3 = ti.types.ndarray(ti.f64, 3)
