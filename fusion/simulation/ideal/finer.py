"""Perfect depth between the pixels: where an edge runs, to a part of a pixel, as far as images can tell it.

Images n times as fine along rows, and along columns, have n - 1 values more between two pixels; a renderer makes
them with a camera of n fx (or n fy). With 64 edges are where the own simulator bisects them to.
"""

import numpy as np

from fusion.sensor.edges.nearest import REACH_PX, Indices
from fusion.sensor.view import Edges, Image, View
from fusion.simulation.ideal.frame import IdealFrame
from fusion.simulation.rendering.edges import JUMP, Between, edges_between


def edges_within(view: View, flat: Image, frame: IdealFrame, reach: float = REACH_PX) -> Edges:
    """The nearest edge of every pixel of the view of a checked frame that has rows and columns.

    Args:
        view: with depth, incidence and, where it is known, reflectance.
        flat: (h, w, 3) normals, towards the camera.
        reach: farther edges are none [px].
    """
    with np.errstate(all="ignore"):
        return edges_between(view, flat, _between(frame, view.camera.width), reach)


def _between(frame: IdealFrame, width: int) -> Between:
    """Depth between neighbours: along the surface of the value before or after."""
    assert frame.rows is not None and frame.columns is not None
    rows, columns = 1 / frame.rows, 1 / frame.columns
    finer = rows.shape[1] // width

    def sampled(first: Indices, second: Indices, share: Image, ray: Image) -> Image:
        v, u = np.divmod(first, width)
        step = np.minimum((share * finer).astype(np.intp), finer - 1)
        part, step = (share * finer - step).astype(np.float32), step + finer // 2
        right = second == first + 1
        found = np.empty(len(first), np.float32)
        found[right] = _along(rows, v[right], (u * finer + step)[right], part[right])
        found[~right] = _along(columns.T, u[~right], (v * finer + step)[~right], part[~right])
        return found

    return sampled


def _along(inverse: Image, line: Indices, at: Indices, part: Image) -> Image:
    """Depth (n,) [m] a `part` of the way from the values `at` (n,) of lines (n,) to the next ones.

    Where neither side's slope leads to the other value, an edge runs between: half way, as far as is known.
    """
    own, other = inverse[line, at], inverse[line, at + 1]
    step = other - own
    before = own - inverse[line, np.maximum(at - 1, 0)]
    after = inverse[line, np.minimum(at + 2, inverse.shape[1] - 1)] - other
    # a slope that leads over an edge itself is none
    before, after = (np.where(np.abs(slope) < np.abs(step), slope, 0) for slope in (before, after))
    smooth = np.fmin(np.abs(step - before), np.abs(step - after)) <= JUMP * np.fmax(own, other)
    torn = np.where(part < 0.5, own + part * before, other - (1 - part) * after)
    return np.asarray(1 / np.where(smooth, own + part * step, torn), np.float32)
