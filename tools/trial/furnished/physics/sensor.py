"""The numbers of a sensor that all cases have, and those of an effect that is concealed."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypedDict

import numpy as np

from tools.trial.furnished.physics.lens import StatedCamera
from tools.trial.furnished.physics.poses import Array

C = 299792458.0


@dataclass
class SensorNumbers:
    """A number of 0 says that the sensor has no such thing. Planting an effect may change it.

    Attributes:
        flight: whether it measures time of flight; otherwise it triangulates.
        kind: "itof", "zone", "sl" or "stereo".
        range_max: [m] to which several frequencies are unfolded.
        taps: samples of a period, 3 or 4.
        falloff: power of the cosine of the lamp's light.
        counts: amplitude of white at 1 m.
        shot: variance of a tap over the level of light, in electrons.
        frequencies: [Hz].
        electrons: of a count.
        ambient: electrons of a tap without the lamp.
        fill: share of its area over which a pixel collects; `parts` x `parts` rays for it.
        step_m: [m] to which depth is rounded.
        dropout: threshold and width [counts] below which pixels go missing.
        baseline: [m] of the projector or second camera, along x.
        pixel_metres: focal length times baseline [px m].
        step_px, sigma_px: [px] rounding and noise of the disparity.
        correlation_px: [px] 1/e length of the noise's autocorrelation; `spread`: what smoothing leaves of white noise.
        speckle: standard deviation and 1/e length [px] of noise that stands still.
        window: [px] by which near surfaces widen.
    """

    flight: bool
    kind: str
    range_max: float = 7.5
    taps: int = 4
    falloff: float = 0.0
    counts: float = 0.0
    shot: float = 0.0
    frequencies: list[float] = field(default_factory=list)
    electrons: float = 0.0
    ambient: float = 0.0
    fill: float = 0.0
    parts: int = 4
    step_m: float = 0.0
    dropout: tuple[float, float] | None = None
    baseline: float = 0.0
    pixel_metres: float = 0.0
    step_px: float = 0.0
    sigma_px: float = 0.0
    correlation_px: float = 0.0
    spread: float = 1.0
    speckle: tuple[float, float] | None = None
    window: int = 0

    def range_sigma(self, counts: Array, ambient: float | None = None) -> Array:
        """[m] noise of the range of one frame, by its amplitude."""
        squares = sum(f * f for f in self.frequencies)
        metres = C / 4 / np.pi / np.sqrt(squares)
        light = self.electrons * np.maximum(counts, 1e-3)
        level = self.shot * light + (self.ambient if ambient is None else ambient)
        return np.asarray(metres * np.sqrt(2 / self.taps * level / light**2))


class Effects(TypedDict, total=False):
    """What is concealed, a key each; absent keys are not there. [m] unless said otherwise."""

    # of the light and the raw samples of time of flight
    bounces: float  # share of the light by way of a second surface
    stray: tuple[float, float]  # share, width [px]
    fill: float  # share of its area over which a pixel collects
    crosstalk: float  # share that goes to the neighbours
    defocus: float  # [px]
    ghost: float  # share mirrored at the image's middle
    lamp_at: float  # x of the lamp
    penetration: float  # path at 1 / cosine of 2
    inside: tuple[list[int], float]  # parts, path in them
    harmonics: dict[int, float]  # order, size over that of the fundamental
    ambient: float  # [electrons]
    tap_delay: float  # [s] from tap to tap
    folds: bool  # one frequency, not unfolded
    # of the range
    offset: float
    amplitude: tuple[float, float, float]  # size, power, amplitude of reference [counts]
    gain: tuple[float, float]  # threshold [counts], step below it
    delays: tuple[float, float]  # [m/px] along u and v
    square: float  # [1/m] (range - 1.2 m)^2
    warming: float  # [m/K]
    ripple: tuple[float, float]  # size, [Hz]
    sectors: tuple[float, int]  # size, order over the azimuth
    # of the disparity [px]
    disparity_offset: float
    disparity_map: Array  # (h, w)
    disparity_tilt: tuple[float, float]  # [rad] roll, pitch
    locking: tuple[float, float]  # size, period
    bands: Array  # (w,)
    warming_px: float  # [px/K]
    turning: float  # [1/K] a projector that turns with temperature
    slope: float  # times the slope of the disparity along u
    speckle: tuple[float, float]  # standard deviation, 1/e length
    sigma_px: float
    step_px: float
    jitter: float  # of each pixel's ray
    window: int
    # of the depth
    scale: float
    jump: tuple[int, float]  # from which recording on, size
    pattern: Array  # (h, w)
    noise_square: float  # [1/m] noise over depth^2
    noise_tilt: float
    memory: float  # share of the frame before
    dropout: tuple[float, float]  # threshold, width [counts]
    saturation: float  # [counts]
    step_m: float
    # of rays, poses and clocks
    glass: tuple[float, float]  # thickness, index
    camera: StatedCamera  # the true one
    line_delay: float  # [s]
    clock: float  # [s]
    drift: Array  # (6,) [m, rad] a frame


def any_of(effects: Effects, names: Sequence[str]) -> bool:
    return any(name in effects for name in names)
