"""The types of `evaluation.json`: the findings as numbers, SI units, NaN (null in the file) where nothing is known."""

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from fusion.geometry.camera import Principle

Array = NDArray[Any]


@dataclass(frozen=True)
class Spread:
    """Median, 10th and 90th percentile over a map."""

    median: float
    p10: float
    p90: float


@dataclass(frozen=True)
class ChannelNumbers:
    """Of infrared or one colour: median of the pixels' means, and their standard deviations."""

    mean: float | None
    std: Spread | None


@dataclass(frozen=True)
class DepthNumbers:
    """Of the depth over the image."""

    mean_m: float | None
    std_m: Spread | None
    std_robust_m: Spread | None
    common_std_m: float
    valid_share: float


@dataclass(frozen=True)
class PixelNumbers:
    """One pixel over time."""

    u: int
    v: int
    values: int
    mean_m: float
    std_m: float
    std_robust_m: float


@dataclass(frozen=True)
class BiasNumbers:
    """Against a known distance, and against a plane."""

    truth: str | None
    offset_m: float
    offset_std_m: float
    offset_corrected_m: float
    spread_m: float
    residual_rms_m: float


@dataclass(frozen=True)
class NoiseNumbers:
    """Along the ray and across it."""

    depth_m: float
    tilt_rad: float
    frames: int
    axial_m: float
    axial_std_m: float
    axial_expected_m: float
    lateral_left_m: float
    lateral_right_m: float


@dataclass(frozen=True)
class ShareNumbers:
    """Shares of all values, and the noise, in bins of one variable."""

    unit: str
    low: Array
    high: Array
    valid: Array
    no_data: Array
    outliers: Array
    values: Array
    std_m: Array


@dataclass(frozen=True)
class StepNumbers:
    """The steps in which depths are stored."""

    law: str
    step_m: float
    interval_90_m: tuple[float, float]
    exponent: float
    exponent_std: float
    file_unit_m: float
    depth_m: Array
    steps_m: Array


@dataclass(frozen=True)
class AmbientNumbers:
    """The light of the room, as the noise tells it."""

    lux: float
    interval_90_lux: tuple[float, float]
    places: int
    law: str
    text: str


@dataclass(frozen=True)
class DriftNumbers:
    """Whether the sensor is warm."""

    verdict: str
    text: str
    slope_m_per_s: float
    slope_interval_90: tuple[float, float]
    change_ten_minutes_m: float
    change_interval_90_m: tuple[float, float]
    time_constant_s: float
    wait_s: float | None
    wait_interval_90_s: tuple[float, float] | None


@dataclass(frozen=True)
class NearNumbers:
    """The shortest distance at which a surface is seen."""

    surface: str
    distance_m: float
    interval_m: tuple[float, float]
    distances_m: tuple[float, ...]
    valid: tuple[float, ...]


@dataclass(frozen=True)
class StretchNumbers:
    """One still stretch of a recording."""

    name: str
    frames: int
    frames_unreadable: int
    duration_s: float
    frames_disturbed: Array
    moving_share: float
    surface: str
    distance_m: float
    depth: DepthNumbers
    ir: ChannelNumbers | None
    color: dict[str, ChannelNumbers] | None
    pixel: PixelNumbers
    bias: BiasNumbers | None
    noise: NoiseNumbers | None
    shares: dict[str, float]
    quantization: StepNumbers | None
    drift: DriftNumbers


@dataclass(frozen=True)
class CameraName:
    """Which camera it was."""

    sensor: str
    serial: str
    principle: Principle
    width: int
    height: int


@dataclass(frozen=True)
class EvaluationNumbers:
    """The content of `evaluation.json`; docs/evaluation.md tells the keys."""

    format: str
    summary: str
    camera: CameraName
    stretches: tuple[StretchNumbers, ...]
    shares: dict[str, ShareNumbers]
    shortest_distance: tuple[NearNumbers, ...]
    quantization: StepNumbers | None
    ambient: AmbientNumbers | None
    notes: tuple[str, ...]
