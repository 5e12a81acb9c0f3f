"""Readout: what happens to a distance on its way into the file, in any sensor; rounding last."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.effects.readout.lateral_noise import LateralNoise

READOUT: tuple[type[Effect], ...] = (LateralNoise, DepthScale, DepthOffset, AxialNoise, DepthQuantization)
