"""Scene: everything a simulated recording is made from, but for the sensor and the seed."""

from dataclasses import dataclass, field
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.lens.boards.board import Board
from fusion.errors import SceneError
from fusion.geometry.camera import Camera
from fusion.mesh.mesh import Mesh
from fusion.recording.native.camera_file import are_focal
from fusion.recording.native.scene_file import Source
from fusion.simulation.rendering.paint import Paint
from fusion.simulation.scene.course import SimulatedCourse

SOURCES: tuple[str, ...] = get_args(Source)
BRIGHTEST = 1e6  # [lux] ten times the sun
STEEPEST = 100.0  # of a ray, x / z: 89.4 degrees from the axis
TRANSLUCENT = "translucent"  # scalar of a mesh: 1 where light enters the surface, 0 where it does not
MOST_PIXELS = 20_000_000  # of a frame: beyond that, rendering takes gigabytes


@dataclass(frozen=True)
class Part:
    """A surface."""

    mesh: Mesh  # world frame (that of frame 0 where it turns) [m]; its colours are what a colour camera sees
    reflectance: float | None = None  # in the infrared, one for all; None: the grey of the colours over 255
    turns: bool = False  # it stands on the turntable
    scanned: bool = True  # it belongs to what a scan should give

    def __post_init__(self) -> None:
        if self.reflectance is not None and not 0 <= self.reflectance <= 1:
            raise SceneError("a reflectance cannot be used", found=self.reflectance, expected="0 to 1")


@dataclass(frozen=True)
class StatedPoses:
    """How well the poses in the recording are known."""

    source: str = "surveyed"  # "surveyed", "tracked" or "nominal" (as the turntable reports)
    # sigma_m, sigma_rad: standard deviation per axis of one error that all poses of the recording share
    sigma_m: float = 0.0
    sigma_rad: float = 0.0

    def __post_init__(self) -> None:
        if self.source not in SOURCES:
            raise SceneError('"source" of the poses cannot be used', found=self.source, expected=" or ".join(SOURCES))
        if not (0 <= self.sigma_m < 10 and 0 <= self.sigma_rad < 1):
            raise SceneError("the poses' sigma cannot be used", found=f"{self.sigma_m} m, {self.sigma_rad} rad")


@dataclass(frozen=True)
class Scene:
    """What stands where, and how it is looked at."""

    name: str  # for people
    parts: tuple[Part, ...]  # surfaces
    course: SimulatedCourse  # where the camera stands at each frame, and how the table turns
    camera: Camera | None = None  # as it is stated; None: the usual one of the sensor
    paints: tuple[Paint, ...] = ()  # fine patterns on flat surfaces
    # how the recording states the poses; None: not at all
    poses: StatedPoses | None = field(default_factory=StatedPoses)
    ambient_lux: float = 0.0  # light that is not the sensor's own
    # further columns of `telemetry.csv`, each (frames,)
    telemetry: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    color: bool = False  # colour images are made
    infrared: bool = False  # infrared images are made even by a sensor that does not give them along with depth
    board: Board | None = None  # where the scene is for calibration
    # edge_lost, edge_mixed: shares of the pixels at depth edges that have no value, and that have a value between both
    # surfaces, beside what the sensor's effects do
    edge_lost: float = 0.0
    edge_mixed: float = 0.0

    def __post_init__(self) -> None:
        if not any(len(part.mesh.faces) for part in self.parts):
            raise SceneError("the scene is empty", self.name, "no triangle", "a mesh with faces")
        if not (np.isfinite(self.ambient_lux) and 0 <= self.ambient_lux <= BRIGHTEST):
            raise SceneError('"ambient_lux" cannot be used', self.name, self.ambient_lux, f"0 to {BRIGHTEST:g}")
        for name, column in self.telemetry.items():
            if len(column) != len(self.course):
                raise SceneError(f"the telemetry {name} does not fit", self.name, len(column), f"{len(self.course)}")
        if self.camera is not None:
            _check_camera(self.camera, self.name)


def _check_camera(camera: Camera, where: str) -> None:
    """A camera that can be computed with: its numbers are those of a camera."""
    if camera.width * camera.height > MOST_PIXELS:
        found = f"{camera.width} x {camera.height}"
        raise SceneError("the camera has too many pixels", where, found, f"up to {MOST_PIXELS:,}")
    centre = max(abs(camera.cx), abs(camera.cy))
    if centre > 1e6 or not are_focal(camera.fx, camera.fy):
        found = f"fx {camera.fx:g}, fy {camera.fy:g}, cx {camera.cx:g}, cy {camera.cy:g}"
        raise SceneError("the camera's intrinsics cannot be used", where, found, "pixels")
    with np.errstate(all="ignore"):
        rays = camera.rays() if max(map(abs, camera.distortion)) < 1e4 else np.array(np.inf)
    if not np.abs(rays).max() < STEEPEST:
        raise SceneError("the camera's distortion cannot be used", where, camera.distortion, "OpenCV's values")
