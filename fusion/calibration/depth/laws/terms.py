"""Terms: what one number of a depth law does to the depth of a wall, per unit of that number."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.walls.gloss import FRESNEL
from fusion.calibration.depth.walls.samples import WallSamples

# [m] usual height of the wiggling (Fankhauser 2015: 6 mm), and of a curve about its straight line: both generous
WAVE, CURVE = 0.01, 0.03
BOARD = "board"  # stands for an effect where a number is the board's, not the sensor's
DARKEST = 1e4  # reference over amplitude is held here, as the effect does
Array = NDArray[np.floating]
Law = Callable[[WallSamples], Array]


@dataclass(frozen=True)
class LawTerm:
    """One number of a law."""

    key: str  # its name among the terms, such as "offset" or "sin 0.625000"
    # effect, parameter: where it goes in a sensor file; `BOARD`: nowhere
    effect: str
    parameter: str
    unit: str  # of the number
    change: Law  # change of the depth (n,) [m] per unit, at samples (n,)
    typical: float  # a size at which it would be plainly visible
    shape: bool = False  # True when it is 0 at the middle of the image: no part of the one curve over distance
    # standard deviation of the number over all sensors, where it keeps laws of many terms from running away; inf where
    # the walls alone decide
    highest: float = float("inf")

    @property
    def prior(self) -> float:
        """1 / variance of the number before any wall is seen."""
        return 1 / self.highest**2


def length(law: Law) -> Law:
    """A change of the length that the sensor measures: along the ray for time of flight."""
    return lambda at: law(at) * at.along_ray


def pixels(law: Law) -> Law:
    """A change of the disparity: 1 / z' = 1 / z + shift / (fx b) makes z' - z = -z z' shift / (fx b), exactly."""
    return lambda at: -at.depth * at.seen * law(at) / at.focal_baseline


def radial(power: int) -> Law:
    """(r / reach)^power about the principal point."""
    return lambda at: (np.hypot(at.u, at.v) / at.reach) ** power


def hat(nodes: tuple[float, ...], which: int) -> Law:
    """1 at a node, 0 at the others, linear between; held outside."""
    values = np.eye(len(nodes))[which]
    return lambda at: np.interp(at.distance, nodes, values)


def wave(period: float, function: Callable[[Array], Array]) -> Law:
    """A sine or cosine of the range."""
    return lambda at: function(2 * np.pi / period * at.depth * at.stretch)


def common_terms() -> list[LawTerm]:
    """Offset and scale, which every sensor can have."""
    return [
        LawTerm("offset", "depth_offset", "offset", "m", length(_flat), 0.005),
        LawTerm("scale", "depth_scale", "scale", "1", lambda at: at.depth, 0.005),
    ]


def triangulation_terms() -> list[LawTerm]:
    """Of sensors that measure a disparity."""
    return [
        LawTerm("disparity", "disparity_offset", "offset", "px", pixels(_flat), 0.1),
        *(LawTerm(f"radius^{n}", "tabulated", "values_px", "px", pixels(radial(n)), 0.1, True) for n in (2, 4)),
        LawTerm("tilt u", "disparity_distortion", "map", "px", pixels(lambda at: at.u / at.reach), 0.1, True),
        LawTerm("tilt v", "disparity_distortion", "map", "px", pixels(lambda at: at.v / at.reach), 0.1, True),
    ]


def radial_terms() -> list[LawTerm]:
    """An error of length that grows towards the image's corners."""
    return [LawTerm(f"radius^{n}", "tabulated", "values", "m", length(radial(n)), 0.005, True) for n in (2, 4)]


def flight_terms(ir_reference: float | None) -> list[LawTerm]:
    """Of time-of-flight sensors: delays over the chip, and the amplitude where IR tells it."""
    terms = [
        *radial_terms(),
        LawTerm("delay u", "column_delay", "slope", "m/px", length(lambda at: at.u), 3e-5, True),
        LawTerm("delay v", "column_delay", "slope_v", "m/px", length(lambda at: at.v), 3e-5, True),
    ]
    if ir_reference is not None:
        dark = _dark(ir_reference)
        terms += [
            LawTerm("amplitude", "amplitude_error", "coefficient", "m", length(dark), 0.002),
            LawTerm("amplitude^2", "amplitude_error", "coefficient", "m", length(lambda at: dark(at) ** 2), 0.002),
            LawTerm("amplitude log", "tabulated", "values", "m", length(_logarithm(dark)), 0.002),
        ]
    return terms


def gloss_term() -> LawTerm:
    """What the board mirrors into the camera."""
    return LawTerm("gloss", BOARD, "gloss", "1", length(_gloss), FRESNEL, True)


def wave_terms(periods: tuple[float, ...]) -> list[LawTerm]:
    """Sine and cosine of the range for each period [m]."""
    return [
        LawTerm(
            sine(period) if function is np.sin else f"cos {period:.6f}",
            "cyclic_error",
            "amplitude",
            "m",
            length(wave(period, function)),
            0.005,
            highest=WAVE,
        )
        for period in periods
        for function in (np.sin, np.cos)
    ]


def sine(period: float) -> str:
    """Name of the sine of a period [m]."""
    return f"sin {period:.6f}"


def curve_terms(nodes: tuple[float, ...]) -> list[LawTerm]:
    """A curve of straight pieces over the distance."""
    return [
        LawTerm(f"curve {i}", "tabulated", "values", "m", length(hat(nodes, i)), 0.005, highest=CURVE)
        for i in range(len(nodes))
    ]


def _flat(at: WallSamples) -> Array:
    return np.ones(len(at.depth))


def _gloss(at: WallSamples) -> Array:
    return np.zeros(len(at.depth)) if at.gloss is None else at.gloss


def _dark(reference: float) -> Law:
    def law(at: WallSamples) -> Array:
        ir = np.zeros(len(at.depth)) if at.ir is None else at.ir
        return np.where(ir > 0, np.minimum(reference / np.where(ir > 0, ir, 1.0), DARKEST), 0.0)

    return law


def _logarithm(dark: Law) -> Law:
    """Of the darkness; 0 where the amplitude is not known."""

    def law(at: WallSamples) -> Array:
        values = dark(at)
        return np.log(np.where(values > 0, values, 1.0))

    return law
