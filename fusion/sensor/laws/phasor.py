"""The light in a time-of-flight pixel as a phasor: its length is the amplitude, its angle grows with the range.

Light that joins on its way adds as phasors, whatever brings it: another surface, a neighbour, the lens.
The amplitude is that of the IR image, which holds what has joined: an error of the second order in its share.
"""

import numpy as np

from fusion.sensor.view import Image, View


def turn(view: View) -> float:
    """Phase per metre of range [rad/m]: 4 pi f / c."""
    return 2.0 * float(np.pi) / view.wavelength


def two_paths(own: Image | float, other: Image, longer: Image, view: View) -> tuple[Image, Image]:
    """What light of two paths looks like: own + other e^(i turn longer).

    Args:
        own, other: amplitudes of the two, in the same unit.
        longer: range of the other path minus that of the own one [m].

    Returns:
        The change of the range against the own path [m], and the amplitude of both together.
    """
    angle = turn(view) * longer
    across, along = other * np.sin(angle), own + other * np.cos(angle)
    return np.arctan2(across, along) / turn(view), np.sqrt(across**2 + along**2)


def phasor(amplitude: Image, depth: Image, view: View) -> tuple[Image, Image]:
    """Real and imaginary part (h, w) of the light of a depth image; 0 where amplitude or depth is missing."""
    angle = turn(view) * np.nan_to_num(depth) * view.stretch
    lit = np.where(np.isfinite(depth), np.nan_to_num(np.asarray(amplitude, depth.dtype)), 0.0).astype(depth.dtype)
    return lit * np.cos(angle), lit * np.sin(angle)


def brightness(light: tuple[Image, Image]) -> Image:
    """Amplitude (h, w) of a phasor."""
    return np.sqrt(light[0] ** 2 + light[1] ** 2)


def shift(before: tuple[Image, Image], after: tuple[Image, Image], view: View) -> Image:
    """Change of depth (h, w) [m] when the phasor turns from `before` to `after`; 0 where there was no light."""
    along = after[0] * before[0] + after[1] * before[1]
    across = after[1] * before[0] - after[0] * before[1]
    return np.arctan2(across, along) / (turn(view) * view.stretch)
