"""What light makes of the brightness of a matt surface, by its normals alone, and what is left: what is printed."""

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.tones import DARK, Image, brightness, contrasts_of

SOME = 5000  # pixels that tell nine numbers
FAR_OFF = 2.0  # standard deviations: print that is darker or brighter does not shift what light makes


def print_of(color: NDArray[np.uint8], normals: NDArray[np.float32], shown: NDArray[np.bool_]) -> Image:
    """(h, w) contrast, see `tones.contrast`, without what light makes of the shape: that stands still as it turns.

    NaN off the surface, and all over where light makes most of the contrast: what a fit leaves of it is no print.

    Args:
        color: (h, w, 3) RGB.
        normals, shown: as of `shading`.
    """
    gray = brightness(color)
    lit = shading(gray, normals, shown)
    seen = shown & np.isfinite(lit)
    if not seen.any():
        return lit
    even = np.where(seen, gray / np.where(seen, lit, 1) * gray[seen].mean(), 0).astype(np.float32)
    with_light, print_ = contrasts_of([gray, even], seen)
    return print_ if np.nansum(print_**2) > np.nansum(with_light**2) / 2 else np.full_like(print_, np.nan)


def shading(gray: Image, normals: NDArray[np.float32], shown: NDArray[np.bool_]) -> Image:
    """Brightness (h, w) of a matt surface of one colour under the light of this image; NaN off the surface.

    Whatever lamps there are, as far as they stand off, nine spherical harmonics of the normal make 98 % of it
    (Basri and Jacobs 2003, Lambertian reflectance and linear subspaces).

    Args:
        gray: (h, w) brightness [counts].
        normals: (h, w, 3) in any frame that is the same all over the image.
        shown: (h, w) the surface.
    """
    lit = np.full(gray.shape, np.nan, np.float32)
    known = shown.copy()
    known[shown] = np.isfinite(normals[shown]).all(axis=-1)
    if not known.any():
        return lit
    facing, seen = normals[known], gray[known]
    some = slice(None, None, max(1, len(seen) // SOME))
    basis, asked = _harmonics(facing[some].astype(float)), seen[some].astype(float)
    left = asked - basis @ _fitted(basis, asked)
    usual = np.abs(left) <= FAR_OFF * np.sqrt(np.mean(left**2))
    lit[known] = np.maximum(_harmonics(facing) @ _fitted(basis[usual], asked[usual]).astype(np.float32), DARK)
    return lit


def _fitted(basis: NDArray[np.floating], seen: NDArray[np.float64]) -> NDArray[np.float64]:
    """(9,) by the normal equations: planes show few normals, which leave some of them free."""
    return np.asarray(np.linalg.lstsq(basis.T @ basis, basis.T @ seen, rcond=1e-9)[0])


def _harmonics(normals: NDArray[np.floating]) -> NDArray[np.floating]:
    """(m, 9) real harmonics up to the second order, but for their factors, of normals (m, 3)."""
    x, y, z = normals.T
    return np.column_stack([np.ones_like(x), x, y, z, x * y, y * z, x * z, x * x - y * y, 3 * z * z - 1])
