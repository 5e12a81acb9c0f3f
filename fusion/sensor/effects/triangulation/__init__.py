"""Triangulation: how structured light and active stereo turn a disparity into a distance."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects.triangulation.disparity_distortion import DisparityDistortion
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.effects.triangulation.edge_fattening import EdgeFattening
from fusion.sensor.effects.triangulation.pixel_locking import PixelLocking
from fusion.sensor.effects.triangulation.projector_thermal_drift import ProjectorThermalDrift
from fusion.sensor.effects.triangulation.speckle_noise import SpeckleNoise
from fusion.sensor.effects.triangulation.vertical_banding import VerticalBanding

# the pattern, how it is matched, and what the chip then does to the disparity
TRIANGULATION: tuple[type[Effect], ...] = (
    EdgeFattening,
    ProjectorThermalDrift,
    DisparityOffset,
    DisparityDistortion,
    SpeckleNoise,
    PixelLocking,
    VerticalBanding,
)
