"""One file per sensor effect, and the order in which light meets them."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects.axial_noise import AxialNoise
from fusion.sensor.effects.depth_offset import DepthOffset
from fusion.sensor.effects.depth_quantization import DepthQuantization
from fusion.sensor.effects.depth_scale import DepthScale
from fusion.sensor.effects.disparity_offset import DisparityOffset
from fusion.sensor.effects.lateral_noise import LateralNoise

# light-path order: optics, triangulation or phase, electronics, rounding last
EFFECTS: tuple[type[Effect], ...] = (
    LateralNoise,
    DisparityOffset,
    DepthScale,
    DepthOffset,
    AxialNoise,
    DepthQuantization,
)
