"""What a turntable scan may be told."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fusion.errors import FusionError
from fusion.quantity import HOLES, REFLECTANCE, STEP, check_volume
from fusion.sensor.sensor import Sensor


@dataclass(frozen=True)
class ScanSettings:
    """What a turntable scan may be told.

    Attributes:
        sensor: corrects the depth and weighs it; None takes what the camera's principle suggests.
        box: two corners (3,), (3,) [m] around the turning object, the low one first, in the first camera's frame (x
            right, y down, z forward); None finds it.
        mask: a PNG for all frames or a folder with one per depth frame, nonzero on the object; None uses all pixels.
        step: turn between frames [rad] of either sign; None takes the table's log, or finds it.
        use_log: False ignores the table's log.
        strength: "axis" (one axis, one angle per frame) or "circle" (Pagliari: only centres are moved).
        refine_camera: take out the error of the focal length that the scan itself shows; None does it where the camera
            is only nominal (it has no std) and the scan contradicts it.
        keep_plate: leave the plate in the mesh.
        plate_reflectance: share of the light that the plate reflects: what that light does to time of flight is taken
            out of the surface; None only says how much it may be.
        voxel, truncation: [m]; None chooses them from distance, focal length and noise.
        color: colour the mesh where the recording has colour images.
        force: go on where the recording's doctor is certain that the result will be wrong.
        fill_holes: close holes up to this perimeter [m].
    """

    sensor: Sensor | None = None
    box: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    mask: Path | None = None
    step: float | None = None
    use_log: bool = True
    strength: str = "axis"
    refine_camera: bool | None = None
    keep_plate: bool = False
    plate_reflectance: float | None = None
    voxel: float | None = None
    truncation: float | None = None
    color: bool = True
    force: bool = False
    fill_holes: float = 0.03

    def __post_init__(self) -> None:
        check_volume(self.voxel, self.truncation, self.box)
        HOLES.check(self.fill_holes)
        REFLECTANCE.check(self.plate_reflectance)
        STEP.check(None if self.step is None else float(np.rad2deg(self.step)))
        if self.strength not in ("axis", "circle"):
            raise FusionError("unknown strength of the post-pass", "--strength", self.strength, "axis or circle")
