"""OpenCV's lens, forth and back, as far as it is one: its radial polynomial turns round somewhere, and what lies beyond
would come back into the image.

With r the distance of x/z, y/z from the axis and q = r^2, a = x radial + 2 p1 x y + p2 (q + 2 x^2) and alike for b,
where radial = (1 + k1 q + k2 q^2 + k3 q^3) / (1 + k4 q + k5 q^2 + k6 q^3) (OpenCV, calib3d).
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array

STEEPEST = np.radians(89.0)  # from the axis: depth along z says nothing beyond
SAMPLES = 20_000
ROUNDS = 12  # of Newton's method: it doubles the digits, and the table gives the first four
CLOSE = 1e-12  # of a ray: beyond what single precision holds
MISSED = 1e-4  # of the focal length: a pixel whose ray leads elsewhere has none (0.05 px where that is 500 px)

Distortion = tuple[float, ...]


@lru_cache(maxsize=64)
def growing(distortion: Distortion) -> tuple[Array, Array]:
    """Distances r (n,) from the axis up to where the radial part grows, and what the lens makes of them (n,)."""
    r = np.tan(np.linspace(0.0, STEEPEST, SAMPLES))
    with np.errstate(all="ignore"):
        bent = r * radial(r * r, distortion)
        turned = np.flatnonzero(~(np.diff(bent) > 0))
    end = int(turned[0]) + 1 if len(turned) else SAMPLES
    return r[:end], bent[:end]


def beyond(x: Array, y: Array, distortion: Distortion) -> NDArray[np.bool_]:
    """(n,) True for x/z, y/z that no pixel can show, though the formula may bring them back into the image."""
    r, _ = growing(distortion)
    return np.asarray(x * x + y * y > r[-1] ** 2)


def straightened(a: Array, b: Array, distortion: Distortion) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Rays x/z, y/z (n,) of bent ones, and True (n,) for those that have none: they are given the last one that has.

    Args:
        a, b: (n,) of pixels: (u - cx) / fx, (v - cy) / fy.
    """
    r, bent = growing(distortion)
    far = np.hypot(a, b)
    ratio = np.interp(far, bent, r) / np.maximum(far, 1e-300)
    x, y = first = np.where(far > 0, a * ratio, a), np.where(far > 0, b * ratio, b)
    for _ in range(ROUNDS):
        off_a, off_b, jacobian = _off(x, y, a, b, distortion)
        aa, ab, bb = jacobian
        det = aa * bb - ab * ab
        with np.errstate(all="ignore"):
            step_x, step_y = (bb * off_a - ab * off_b) / det, (aa * off_b - ab * off_a) / det
            known = np.hypot(step_x, step_y) < r[-1]  # elsewhere the derivative vanishes
        x, y = x - np.where(known, step_x, 0), y - np.where(known, step_y, 0)
        out = np.maximum(np.hypot(x, y) / r[-1], 1.0)
        x, y = x / out, y / out
        if np.max(np.hypot(step_x, step_y)[known & (out == 1)], initial=0.0) < CLOSE:
            break
    off_a, off_b, _ = _off(x, y, a, b, distortion)
    missed = ~(np.hypot(off_a, off_b) < MISSED)  # there the search ends anywhere
    return np.where(missed, first[0], x), np.where(missed, first[1], y), missed


def radial(q: Array, distortion: Distortion) -> Array:
    """How much longer a lens makes the distance from the axis, by its square (n,); not finite at a pole."""
    k1, k2, _, _, k3, k4, k5, k6 = distortion
    return np.asarray((1 + q * (k1 + q * (k2 + q * k3))) / (1 + q * (k4 + q * (k5 + q * k6))))


def _off(x: Array, y: Array, a: Array, b: Array, distortion: Distortion) -> tuple[Array, Array, tuple[Array, ...]]:
    """How far bent rays lie from (a, b), and the derivatives aa, ab = ba, bb."""
    k1, k2, p1, p2, k3, k4, k5, k6 = distortion
    q = x * x + y * y
    over, under = 1 + q * (k1 + q * (k2 + q * k3)), 1 + q * (k4 + q * (k5 + q * k6))
    radial = over / under
    slope = ((k1 + q * (2 * k2 + q * 3 * k3)) - radial * (k4 + q * (2 * k5 + q * 3 * k6))) / under  # by q
    off_a = x * radial + 2 * p1 * x * y + p2 * (q + 2 * x * x) - a
    off_b = y * radial + p1 * (q + 2 * y * y) + 2 * p2 * x * y - b
    aa = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x
    bb = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x
    return off_a, off_b, (aa, 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y, bb)
