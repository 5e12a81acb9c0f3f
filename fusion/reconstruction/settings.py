"""What a reconstruction may be told."""

from dataclasses import dataclass, field

from fusion.geometry.trajectory import Trajectory
from fusion.quantity import MAX_DEPTH, check_volume
from fusion.sensor.sensor import Sensor
from fusion.tracking.tracker import TrackerSettings


@dataclass(frozen=True)
class ReconstructSettings:
    """What a reconstruction may be told.

    Attributes:
        sensor: corrects the depth and weighs it; None takes what the camera's principle suggests.
        poses: `T_world_camera` by time stamp, used as they are; None tracks the frames.
        voxel, truncation: [m]; None chooses them from distance, focal length and noise.
        room: voxels for a room (True) or an object (False), where they are chosen; None: as the frames show.
        max_depth: depth beyond is not used [m].
        box: two corners (3,), (3,) [m] in the world (the first camera's frame unless poses are given).
        color: use the recording's colour images: they hold the camera where shape does not, and colour the mesh.
        max_bytes: limit of the volume's memory.
        min_placed: share of the frames below which the whole has failed.
        tracker: how frames are placed.
        force: go on where the recording's doctor is certain that the result will be wrong.
    """

    sensor: Sensor | None = None
    poses: Trajectory | None = None
    voxel: float | None = None
    truncation: float | None = None
    room: bool | None = None
    max_depth: float | None = None
    box: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    color: bool = True
    max_bytes: int = 4 << 30
    min_placed: float = 0.5
    tracker: TrackerSettings = field(default_factory=TrackerSettings)
    force: bool = False

    def __post_init__(self) -> None:
        check_volume(self.voxel, self.truncation, self.box)
        MAX_DEPTH.check(self.max_depth)
