"""Scene: everything a simulated recording is made from."""

from dataclasses import dataclass

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.mesh.mesh import Mesh
from fusion.sensor.sensor import Sensor
from fusion.simulation.turntable import Turntable


@dataclass(frozen=True)
class Scene:
    """A turntable in front of a camera that stands still.

    Attributes:
        camera: true intrinsics.
        sensor: what the camera does to the true depth.
        T_world_camera: (4, 4).
        turntable: how the moving meshes turn, in the world frame.
        moving: what turns, in the world frame at frame 0.
        still: what does not, in the world frame.
        frame_s: time between two frames [s].
        edge_lost, edge_mixed: shares of the pixels at depth edges that have no value, and that have a value
            between both surfaces.
    """

    camera: Camera
    sensor: Sensor
    T_world_camera: Array
    turntable: Turntable
    moving: tuple[Mesh, ...]
    still: tuple[Mesh, ...] = ()
    frame_s: float = 0.5
    edge_lost: float = 0.4  # guess: the software of most sensors throws doubtful edge pixels away
    edge_mixed: float = 0.1  # guess
