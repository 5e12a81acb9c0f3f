"""Triangulation: how structured light and active stereo turn a disparity into a distance."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset

TRIANGULATION: tuple[type[Effect], ...] = (DisparityOffset,)
