"""Lenses that files state in other forms, as OpenCV's rational one and back: one form for the whole program.

With the angle t of a ray to the axis, r = tan t its x/z, y/z distance and q = r^2:
    fisheye (Kannala, Brandt 2006; OpenCV's `fisheye`): bent distance t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8)
    polynomial (nerfstudio's OPENCV): r (1 + k1 q + k2 q^2 + k3 q^3 + k4 q^4)
    rational (OpenCV): r (1 + k1 q + k2 q^2 + k3 q^3) / (1 + k4 q + k5 q^2 + k6 q^3)
A quotient of cubics follows the others to 1e-6 of the focal length up to 60 degrees from the axis, to 1e-5 up to 70.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from fusion.geometry.camera import Camera
from fusion.geometry.lens import STEEPEST, radial
from fusion.geometry.pose import Array

SAMPLES = 400
ROUNDS = 30  # of weighting: the linear fit then comes to the nearest quotient
KEPT_PX = 0.02  # a tenth of what the place of a pixel is held to

Radial = Callable[[Array], Array]  # r -> bent distance


def fisheye(k: Sequence[float]) -> Radial:
    """Kannala's and Brandt's lens with OpenCV's four values."""

    def bent(r: Array) -> Array:
        t = np.arctan(r)
        q = t * t
        return np.asarray(t * (1 + q * (k[0] + q * (k[1] + q * (k[2] + q * k[3])))))

    return bent


def polynomial(k: Sequence[float]) -> Radial:
    """Four radial terms."""

    def bent(r: Array) -> Array:
        q = r * r
        return np.asarray(r * (1 + q * (k[0] + q * (k[1] + q * (k[2] + q * k[3])))))

    return bent


def rational(camera: Camera) -> Radial:
    """The radial part of a camera's own lens."""
    return lambda r: np.asarray(r * radial(r * r, camera.distortion))


def with_lens(camera: Camera, lens: Radial, tangential: tuple[float, float] = (0.0, 0.0)) -> tuple[Camera, float]:
    """The camera with this lens in OpenCV's rational form.

    Args:
        camera: its own lens is not looked at.
        lens: radial part.
        tangential: p1, p2.

    Returns:
        the camera, and how far it leaves the lens, at most [px].

    Raises:
        ValueError: the lens folds back, or sees beyond 89 degrees, within the image; or no quotient is within 0.02 px.
    """
    r = _distances(lens, _corner(camera))
    y = lens(r)
    q = r * r
    # y = r num / den, made linear: r num - y (den - 1) = y - r. The weight 1 / den makes its misfit that of y
    A = np.stack([r * q, r * q**2, r * q**3, -y * q, -y * q**2, -y * q**3], axis=1)
    weight, found = np.ones(len(r)), np.zeros(6)
    for _ in range(ROUNDS):
        rows = A * weight[:, None]
        unit = 1 / np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
        found = np.linalg.lstsq(rows * unit, (y - r) * weight, rcond=1e-15)[0] * unit
        weight = 1 / np.maximum(np.abs(1 + q * (found[3] + q * (found[4] + q * found[5]))), 1e-9)
    k1, k2, k3, k4, k5, k6 = (float(value) for value in found)
    made = replace(camera, distortion=(k1, k2, *tangential, k3, k4, k5, k6))
    gap = float(np.max(np.abs(rational(made)(r) - y))) * max(camera.fx, camera.fy)
    if not gap <= KEPT_PX:
        raise ValueError(f"a lens that OpenCV's rational form misses by {gap:.2g} px")
    return made, gap


def to_polynomial(camera: Camera) -> tuple[float, ...]:
    """The three radial terms that come nearest to a camera's lens. Raises ValueError as `with_lens`."""
    r, lens = _seen(camera)
    return _terms(r, lens - r)


def to_fisheye(camera: Camera) -> tuple[float, ...]:
    """Kannala's and Brandt's four values that come nearest to the radial part of a camera's lens. Raises ValueError."""
    r, lens = _seen(camera)
    t = np.arctan(r)
    return _terms(t, lens - t, terms=4)


def _terms(x: Array, rest: Array, terms: int = 3) -> tuple[float, ...]:
    """Factors of x^3, x^5, ... that make `rest`."""
    A = x[:, None] ** np.arange(3, 3 + 2 * terms, 2)
    unit = 1 / np.linalg.norm(A, axis=0)
    return tuple(float(value) for value in np.linalg.lstsq(A * unit, rest, rcond=None)[0] * unit)


def _seen(camera: Camera) -> tuple[Array, Array]:
    """Distances from the axis over the image, and what the camera's lens makes of them."""
    lens = rational(camera)
    r = _distances(lens, _corner(camera))
    return r, lens(r)


def _corner(camera: Camera) -> float:
    """The bent distance of the image's corner that is farthest from the axis."""
    x = max(abs(camera.cx + 0.5), abs(camera.width - 0.5 - camera.cx)) / camera.fx
    y = max(abs(camera.cy + 0.5), abs(camera.height - 0.5 - camera.cy)) / camera.fy
    return float(np.hypot(x, y))


def _distances(lens: Radial, corner: float) -> Array:
    """Distances r from the axis to the corner, closer together at both ends. Raises ValueError."""
    with np.errstate(all="ignore"):
        r = np.tan(np.linspace(0, STEEPEST, 20_000))
        bent = lens(r)
        falls = ~(np.diff(bent) > 0)
    end = int(np.argmax(falls)) if falls.any() else len(r) - 1
    if not bent[end] >= corner:
        seen = f"{np.degrees(np.arctan(r[end])):.0f} degrees from the axis"
        raise ValueError(f"a lens that does not reach the image's corners, {seen}")
    widest = np.interp(corner, bent[: end + 1], np.arctan(r[: end + 1]))
    return np.asarray(np.tan(widest * np.sin(np.linspace(0.5 / SAMPLES, np.pi / 2, SAMPLES))))
