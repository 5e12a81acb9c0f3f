"""The rig: what is seen stands elsewhere, or moves while it is seen."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects.rig.motion_blur import MotionBlur
from fusion.sensor.effects.rig.pose_jitter import PoseJitter
from fusion.sensor.effects.rig.rolling_shutter import RollingShutter
from fusion.sensor.effects.rig.timestamp_offset import TimestampOffset
from fusion.sensor.effects.rig.turntable_eccentricity import TurntableEccentricity
from fusion.sensor.effects.rig.turntable_encoder_error import TurntableEncoderError
from fusion.sensor.effects.rig.turntable_wobble import TurntableWobble

RIG: tuple[type[Effect], ...] = (
    TurntableEncoderError,
    TurntableEccentricity,
    TurntableWobble,
    PoseJitter,
    TimestampOffset,
    RollingShutter,
    MotionBlur,
)
