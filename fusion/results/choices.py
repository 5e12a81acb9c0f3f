"""What was asked for and what was chosen, as `settings.json` holds it: the fields are its keys."""

from dataclasses import dataclass
from pathlib import Path

from fusion.coloring.color_mesh import ColorFigures
from fusion.geometry.camera import Camera
from fusion.sensor.correction.summary import CorrectionFigures

Corner = tuple[float, float, float]


@dataclass(frozen=True)
class LensUsed:
    """The camera of a result [px]; `distortion` in OpenCV's order."""

    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...]

    @classmethod
    def of(cls, camera: Camera) -> "LensUsed":
        return cls(camera.fx, camera.fy, camera.cx, camera.cy, tuple(camera.distortion))


@dataclass(frozen=True)
class RegionFound:
    """Two corners (3,) [m] around the turning object, in the first camera's frame."""

    low: Corner
    high: Corner


@dataclass(frozen=True, kw_only=True)
class Choices(ColorFigures):
    """What every mesh was made with."""

    sensor: str  # name of the model
    correction: CorrectionFigures  # of the depth
    camera: LensUsed  # that was used
    # voxel_m, truncation_m: of the volume
    voxel_m: float
    truncation_m: float
    volume_bytes: int  # its memory


@dataclass(frozen=True, kw_only=True)
class ScanChoices(Choices):
    """Of a turntable scan."""

    # box, mask, step, use_log, strength, refine_camera, keep_plate, force, fill_holes: as asked, see `ScanSettings`
    box: tuple[Corner, Corner] | None
    mask: Path | None
    step: float | None
    use_log: bool
    strength: str
    refine_camera: bool | None
    keep_plate: bool
    force: bool
    fill_holes: float
    sensor_assumed: bool  # nobody named a sensor
    region: RegionFound  # where the object was found


@dataclass(frozen=True, kw_only=True)
class ReconstructionChoices(Choices):
    """Of a reconstruction."""

    tracked_band_m: float  # truncation of the volume that frames were placed against
    room: bool  # voxels for a room, not for an object
    # kind, kind_reason: the same in words, and why
    kind: str
    kind_reason: str
    # max_depth_m, box_m: as asked, or as the volume has them
    max_depth_m: float | None
    box_m: tuple[Corner, Corner] | None
    poses: str  # "tracked" or "given"
