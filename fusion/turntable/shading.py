"""What light makes of the brightness of a matt surface, by its normals alone."""

import numpy as np
from numpy.typing import NDArray

from fusion.turntable.tones import DARK, Image

FAR_OFF = 2.0  # standard deviations: print that is darker or brighter does not shift what light makes


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
    known = shown & np.isfinite(normals).all(axis=-1)
    if not known.any():
        return lit
    basis, seen = _harmonics(normals[known].astype(float)), gray[known].astype(float)
    left = seen - basis @ _fitted(basis, seen)
    usual = np.abs(left) <= FAR_OFF * np.sqrt(np.mean(left**2))
    lit[known] = np.maximum(basis @ _fitted(basis[usual], seen[usual]), DARK)
    return lit


def _fitted(basis: NDArray[np.float64], seen: NDArray[np.float64]) -> NDArray[np.float64]:
    """(9,) by the normal equations: planes show few normals, which leave some of them free."""
    return np.asarray(np.linalg.lstsq(basis.T @ basis, basis.T @ seen, rcond=1e-9)[0])


def _harmonics(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m, 9) real harmonics up to the second order, but for their factors, of normals (m, 3)."""
    x, y, z = normals.T
    return np.column_stack([np.ones_like(x), x, y, z, x * y, y * z, x * z, x * x - y * y, 3 * z * z - 1])
