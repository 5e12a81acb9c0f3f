"""A turntable that turns as commanded, with the errors that real ones have."""

from dataclasses import dataclass, field, replace

import numpy as np

from fusion.errors import FusionError
from fusion.geometry.pose import Array, about_axis, inverse
from fusion.quantity import Quantity

# what is no turntable any more (guesses)
STEP = Quantity("turn between frames", "degrees_per_frame", "deg", 0.0, 3600.0, signed=True)
UNEVEN = Quantity("unevenness of the steps", "uneven_sd_deg", "deg", 0.0, 90.0)
SLIP = Quantity("slip", "slip_deg", "deg", 0.0, 360.0, signed=True)
WOBBLE = Quantity("wobble", "wobble_deg", "deg", 0.0, 45.0)
PHASE = Quantity("phase of the wobble", "wobble_phase_deg", "deg", 0.0, 3600.0, signed=True)


@dataclass(frozen=True)
class TurntableErrors:
    """How the table differs from what it reports."""

    uneven_sd_deg: float = 0.0  # standard deviation of each step [deg]; steps add up
    slip_frame: int | None = None  # first frame after a slip; None for no slip
    slip_deg: float = 0.0  # how far the object slips, in the direction of turning [deg]
    wobble_deg: float = 0.0  # amplitude of the rocking of the axis, once a turn [deg]
    wobble_phase_deg: float = 0.0  # turn angle at which the axis passes its mean position [deg]

    def __post_init__(self) -> None:
        UNEVEN.check(self.uneven_sd_deg)
        SLIP.check(self.slip_deg)
        WOBBLE.check(self.wobble_deg)
        PHASE.check(self.wobble_phase_deg)


@dataclass(frozen=True)
class Turntable:
    """An axis in the world and equal steps about it."""

    axis_point: tuple[float, float, float] = (0.0, 0.0, 0.0)  # a point of the axis [m]
    axis_direction: tuple[float, float, float] = (0.0, 0.0, 1.0)  # out of the plate; need not be a unit vector
    degrees_per_frame: float = 6.0  # right-handed about the direction; negative turns the other way
    frames: int = 60  # number of frames, the first at angle 0
    errors: TurntableErrors = field(default_factory=TurntableErrors)  # what the table does not report

    def __post_init__(self) -> None:
        if self.frames < 1:
            raise FusionError("a turntable recording needs frames", found=self.frames, expected="1 or more")
        STEP.check(self.degrees_per_frame)
        slip = self.errors.slip_frame
        if slip is not None and not 0 <= slip < self.frames:
            expected = f"0 to {self.frames - 1}, the last frame"
            raise FusionError("the table slips in a frame that is not there", "slip_frame", slip, expected)
        if not np.any(self.axis_direction) or not np.isfinite([*self.axis_point, *self.axis_direction]).all():
            raise FusionError("the turntable's axis has no direction", found=self.axis_direction, expected="3 numbers")

    def nominal(self) -> "Turntable":
        """The table that does what it reports."""
        return replace(self, errors=TurntableErrors())

    def commanded_deg(self) -> Array:
        """(frames,) angles that the table reports [deg]."""
        return self.degrees_per_frame * np.arange(self.frames, dtype=np.float64)

    def true_deg(self, rng: np.random.Generator) -> Array:
        """(frames,) angles by which the object has turned [deg]; 0 at the first frame."""
        errors = self.errors
        steps = errors.uneven_sd_deg * rng.standard_normal(self.frames)
        steps[:1] = 0.0
        if errors.slip_frame is not None and 0 < errors.slip_frame < self.frames:
            steps[errors.slip_frame] += errors.slip_deg * np.sign(self.degrees_per_frame)
        return self.commanded_deg() + np.cumsum(steps)

    def T_world_object(self, turned_deg: Array) -> Array:
        """(n, 4, 4) poses of the object at true angles (n,) [deg]; the world frame at frame 0, but for wobble."""
        return np.array([self._pose(angle) for angle in np.deg2rad(turned_deg)]).reshape(-1, 4, 4)

    def T_object_camera(self, T_world_camera: Array, turned_deg: Array) -> Array:
        """(n, 4, 4) poses of a camera that stands still, seen from the turning object."""
        return inverse(self.T_world_object(turned_deg)) @ T_world_camera

    def _pose(self, angle: float) -> Array:
        turn = about_axis(self.axis_point, self.axis_direction, angle)
        if not self.errors.wobble_deg:
            return turn
        axis = np.asarray(self.axis_direction, float)
        across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        rocking = np.deg2rad(self.errors.wobble_deg) * np.sin(angle + np.deg2rad(self.errors.wobble_phase_deg))
        return about_axis(self.axis_point, across, rocking) @ turn
