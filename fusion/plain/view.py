# mypy: ignore-errors
"""How a camera sees a point: a pose, and OpenCV's lens with rational and tangential distortion."""

import numpy as np

from fusion.compute.cards.memory import read_only
from fusion.compute.language import func, ti


def numbers(T, *more):
    """Rows of a pose (4, 4), then other numbers, as kernels take them: (12 + m,) float32."""
    return read_only(np.concatenate([np.ravel(T[:3]), *map(np.ravel, more)]).astype(np.float32))


@func
def turned(T: ti.template(), d: ti.template()):
    """A direction (3,) by the rotation of a pose in the first 12 of some numbers."""
    return ti.Vector([T[4 * r] * d[0] + T[4 * r + 1] * d[1] + T[4 * r + 2] * d[2] for r in ti.static(range(3))])


@func
def moved(T: ti.template(), p: ti.template()):
    """A point (3,) [m] by that pose."""
    return turned(T, p) + ti.Vector([T[3], T[7], T[11]])


@func
def pixel(p: ti.template(), c: ti.template(), first: ti.template()):
    """Where (u, v) [px] a camera sees a point (3,) [m] in front of it.

    c holds fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6 from its entry `first` on.
    https://docs.opencv.org/4.x/d9/d0c/group__calib3d.html, "Detailed Description".
    """
    fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6 = [c[first + n] for n in ti.static(range(12))]
    x, y = p[0] / p[2], p[1] / p[2]
    r2 = x * x + y * y
    radial = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (1 + k4 * r2 + k5 * r2**2 + k6 * r2**3)
    a = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    b = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return fx * a + cx, fy * b + cy
