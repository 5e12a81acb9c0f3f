"""Phase: how a time-of-flight sensor turns light into a distance."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects.phase.amplitude_error import AmplitudeError
from fusion.sensor.effects.phase.column_delay import ColumnDelay
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.phase.emitter_parallax import EmitterParallax
from fusion.sensor.effects.phase.mixed_pixels import MixedPixels
from fusion.sensor.effects.phase.motion_artifact import MotionArtifact
from fusion.sensor.effects.phase.phase_wrapping import PhaseWrapping
from fusion.sensor.effects.phase.pixel_crosstalk import PixelCrosstalk
from fusion.sensor.effects.phase.sensor_interference import SensorInterference

# the way of the light, what a pixel collects of it, what its phase becomes, and how often it has turned
PHASE: tuple[type[Effect], ...] = (
    EmitterParallax,
    MixedPixels,
    PixelCrosstalk,
    SensorInterference,
    MotionArtifact,
    CyclicError,
    AmplitudeError,
    ColumnDelay,
    PhaseWrapping,
)
