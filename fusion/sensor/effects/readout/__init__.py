"""Readout: what happens to a distance on its way into the file, in any sensor; rounding last."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.amplitude_dropout import AmplitudeDropout
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.effects.readout.saturation import Saturation
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.effects.readout.temperature_drift import TemperatureDrift
from fusion.sensor.effects.readout.temporal_filtering import TemporalFiltering

READOUT: tuple[type[Effect], ...] = (
    LateralNoise,
    FixedPattern,
    TemperatureDrift,
    DepthScale,
    DepthOffset,
    Tabulated,
    Saturation,
    AmplitudeDropout,
    AxialNoise,
    TemporalFiltering,
    DepthQuantization,
)
