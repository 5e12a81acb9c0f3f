# mypy: ignore-errors
"""All frames of a turntable against one model: what the rays that meet one cell of its surface say together.

Each ray's equation (`fusion.turntable.model.meeting`) has unknowns of all frames, x: the axis and errors of depth, then
one angle per frame; and one of its cell, o: how far the surface there lies from where the model has it. With w the
weights, J the derivatives and r the residuals of a cell's rays, o = -sum w (J x + r) / sum w is put in ("Schur
complement", Triggs et al. 2000, Bundle Adjustment - A Modern Synthesis, section 6.1):

    H = sum w J J^T - (sum w J) (sum w J)^T / sum w,    g = sum w J (r - sum w r / sum w)
"""

import numpy as np

from fusion.compute.language import F32_2, F64, F64_2, I32, func, kernel, ti
from fusion.turntable.model.cells import CUT
from fusion.turntable.model.meeting import ANGLE, HEIGHT, RESIDUAL, SHARED, SIGMA, SPOILT


def normal_equations(rows, frame, first, offset, n, how):
    """H (s + n, s + n) and g (s + n,), as `fusion.turntable.model.cells.normal_equations`."""
    unknowns = rows.shape[1] - SHARED + n
    H, g, sums = np.zeros((unknowns, unknowns)), np.zeros(unknowns), np.zeros(unknowns)
    eliminate(rows, frame, first, offset, np.array(how, float), H, g, sums)
    return H, g


@func
def weight(rows: ti.template(), row: ti.i32, offset: ti.f64, how: ti.template()):
    """Tukey's biweight over the variance [1/m^2] of a row; 0 where it takes no part."""
    sigma, taken = how[0] * rows[row, SIGMA], True
    if how[1] > 0:  # only what tells where the axis is
        sigma *= rows[row, SPOILT]
        taken = rows[row, HEIGHT] >= how[2]
    t = (rows[row, RESIDUAL] - offset) / (CUT * sigma)
    return ti.select(taken and 1 - t * t > 0.03, ((1 - t * t) / sigma) ** 2, ti.cast(0.0, ti.f64))


@func
def derivative(rows: ti.template(), row: ti.i32, a: ti.i32, shared: ti.i32):
    """Of the residual in unknown a, of those that all frames share or, beyond them, in the frame's own angle."""
    column = ti.select(a < shared, SHARED + a, ANGLE)
    return ti.cast(rows[row, column], ti.f64)


@kernel
def eliminate(rows: F32_2, frame: I32, first: I32, offset: F64, how: F64, H: F64_2, g: F64, sums: F64):
    """Adds up H and g, cell after cell, as sums in another order are other numbers. `how`: scale of sigma, whether
    steady, lowest height [m]; `sums` is for sum w J."""
    ti.loop_config(serialize=True)
    for cell in range(offset.shape[0]):
        shared, total, mean = rows.shape[1] - SHARED, ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64)
        for row in range(first[cell], first[cell + 1]):
            w = weight(rows, row, offset[cell], how)
            total += w
            mean += w * rows[row, RESIDUAL]
        if total > 0:
            for a in range(sums.shape[0]):
                sums[a] = 0.0
            for row in range(first[cell], first[cell + 1]):
                w = weight(rows, row, offset[cell], how)
                for m in range(shared + 1):
                    a = ti.select(m < shared, m, shared + frame[row])
                    by_a = derivative(rows, row, m, shared)
                    sums[a] += w * by_a
                    g[a] += w * by_a * (rows[row, RESIDUAL] - mean / total)
                    for k in range(shared + 1):
                        b = ti.select(k < shared, k, shared + frame[row])
                        H[a, b] += w * by_a * derivative(rows, row, k, shared)
            for a in range(sums.shape[0]):
                if sums[a] != 0:
                    for b in range(sums.shape[0]):
                        H[a, b] -= sums[a] * sums[b] / total
