# mypy: ignore-errors
"""Normal equations of all frames against a model whose surface is unknown too, cell by cell, on Taichi.

Each cell of the surface has one offset along its normal. It is eliminated where the cell's equations stand together,
so only what all frames share (s: the axis and errors of depth) and the angles (n) remain. Sums go from cell to cell in
a fixed order: the same scan gives the same result.
"""

from typing import NamedTuple

import numpy as np

from fusion.compute.choice import either
from fusion.compute.language import F32_2, F64, F64_2, F64_3, I32, I32_2, func, kernel, ti
from fusion.compute.shares import SPLIT
from fusion.turntable.model.meeting import ANGLE, HEIGHT, RESIDUAL, SHARED, SIGMA, SPOILT

PARTS = 16  # of the cells, side by side
CUT = 3.5  # robust standard deviations at which a pixel stops to count


class Counting(NamedTuple):
    """How rows count: the scale of their sigma, whether only what is steady does, from which height on [m]."""

    scale: ti.f64
    steady: ti.i32
    lowest: ti.f64


class CellSums(NamedTuple):
    """For each part to work with: unknowns that a cell touches, and its sums for them (parts, s + n)."""

    members: I32_2
    sums: F64_2


@func
def _weight(row: ti.template(), rows: ti.template(), offset: ti.f64, scale: ti.f64, steady: ti.i32, lowest: ti.f64):
    """Robust weight [1/m^2] of a row (see `meeting`) about its cell's offset; 0 where it takes no part."""
    sigma = scale * rows[row, SIGMA]
    taken = True
    if steady == 1:
        sigma *= rows[row, SPOILT]
        taken = rows[row, HEIGHT] >= lowest
    t = (rows[row, RESIDUAL] - offset) / (CUT * sigma)
    left = 1.0 - t * t
    return ti.select(taken and left > 0.03, left * left / (sigma * sigma), ti.cast(0.0, ti.f64))


@kernel
def settle(rows: F32_2, first: I32, offset: F64, scale: ti.f64, steady: ti.i32, lowest: ti.f64):
    """Move each cell's offset [m] to the weighted mean of its equations."""
    for cell in range(offset.shape[0]):
        total, sum_ = ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64)
        for row in range(first[cell], first[cell + 1]):
            w = _weight(row, rows, offset[cell], scale, steady, lowest)
            total += w
            sum_ += w * rows[row, RESIDUAL]
        offset[cell] = sum_ / ti.max(total, 1e-12)


@kernel
def assemble(
    rows: F32_2, frame: I32, first: I32, offset: F64, how: Counting,
    H: F64_3,  # (parts, s + n, s + n) zeros, out: the lower triangles
    g: F64_2,  # (parts, s + n) zeros, out
    cells: CellSums,
):  # fmt: skip
    """Add up what the cells of each part say of what is shared and of the angles."""
    members, sums = ti.static((cells.members, cells.sums))
    for number in range(H.shape[0] * SPLIT):
        if number % SPLIT == 0:
            part = number // SPLIT
            count, shared = offset.shape[0], rows.shape[1] - SHARED
            for cell in range(count * part // H.shape[0], count * (part + 1) // H.shape[0]):
                total, mean = ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64)
                for row in range(first[cell], first[cell + 1]):
                    w = _weight(row, rows, offset[cell], how.scale, how.steady, how.lowest)
                    total += w
                    mean += w * rows[row, RESIDUAL]
                if total > 0.0:
                    mean /= total
                    seen = shared  # unknowns that the cell touches: those of all frames, then its frames'
                    for a in range(shared):
                        members[part, a] = a
                        sums[part, a] = 0.0
                    for row in range(first[cell], first[cell + 1]):
                        w = _weight(row, rows, offset[cell], how.scale, how.steady, how.lowest)
                        if w > 0.0:
                            own = shared + frame[row]
                            if members[part, seen - 1] != own:
                                members[part, seen] = own
                                sums[part, seen] = 0.0
                                seen += 1
                            by_angle = ti.cast(rows[row, ANGLE], ti.f64)
                            rest = w * (rows[row, RESIDUAL] - mean)
                            sums[part, seen - 1] = sums[part, seen - 1] + w * by_angle
                            H[part, own, own] = H[part, own, own] + w * by_angle * by_angle
                            g[part, own] = g[part, own] + rest * by_angle
                            for a in range(shared):
                                by_shared = w * rows[row, SHARED + a]
                                sums[part, a] = sums[part, a] + by_shared
                                g[part, a] = g[part, a] + rest * rows[row, SHARED + a]
                                H[part, own, a] = H[part, own, a] + by_shared * by_angle
                                for b in range(a + 1):
                                    H[part, a, b] = H[part, a, b] + by_shared * rows[row, SHARED + b]
                    for k in range(seen):
                        a, share = members[part, k], sums[part, k] / total
                        for j in range(k + 1):
                            b = members[part, j]
                            H[part, a, b] = H[part, a, b] - share * sums[part, j]


@either
def normal_equations(rows, frame, first, offset, n, how):
    """Normal matrix (s + n, s + n) and vector (s + n,); the cells' offsets (k,) are eliminated.

    Args:
        rows, frame, first: the equations, see `Equations`.
        offset: (k,) [m] about which the robust weights are taken.
        n: number of frames.
        how: scale, steady and lowest as in `settle`.
    """
    unknowns = rows.shape[1] - SHARED + n
    H = np.zeros((PARTS, unknowns, unknowns))
    g, members, sums = (
        np.zeros((PARTS, unknowns)),
        np.zeros((PARTS, unknowns), np.int32),
        np.zeros((PARTS, unknowns)),
    )
    assemble(rows, frame, first, offset, Counting(*how), H, g, CellSums(members, sums))
    lower = H.sum(axis=0)
    return lower + np.tril(lower, -1).T, g.sum(axis=0)
