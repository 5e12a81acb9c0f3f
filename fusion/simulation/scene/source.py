"""A scene file that is being read: its content, and what the files and poses that it names become."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import Meta, Struct

from fusion.calibration.lens.boards.board import DrawnBoard
from fusion.errors import SceneError
from fusion.files.content import Content, FileName, Metres
from fusion.files.inside import inside
from fusion.geometry.pose import Array, from_tum, is_rigid
from fusion.recording.native.camera_file import CameraFile
from fusion.recording.native.scene_file import CourseFields, LookAt, Pose, Posed, SceneFields, Share
from fusion.simulation.scene.course import looking_at

Color = Annotated[float, Meta(ge=0, le=255)]
Rgb = Annotated[tuple[Color, Color, Color], Meta(description="red, green and blue, 0 to 255")]
Box = Annotated[
    list[Metres | list[Metres]], Meta(description="two corners, [[x, y, z], [x, y, z]], the lower first [m]")
]
Scale = Annotated[float, Meta(ge=1e-9, le=1e9, description="metres per unit of the mesh file")]


class PartFields(Struct, frozen=True, kw_only=True):
    """A surface: a mesh, a box or a calibration board."""

    mesh: FileName | None = None
    box: Box | None = None
    board: Annotated[str, Meta(description="the name of a board.json")] | DrawnBoard | None = None
    pose: Pose = None
    reflectance: Annotated[Share, Meta(description="in the infrared")] | None = None
    scale: Scale | None = None
    color: Rgb | None = None
    turns: Annotated[bool, Meta(description="it stands on the turntable")] | None = None
    scanned: Annotated[bool, Meta(description="it belongs to what a scan should give")] | None = None


class SceneFile(SceneFields, frozen=True, kw_only=True):
    """A scene to simulate, or the scene that a recording states: `scene.json`."""

    camera: Annotated[str, Meta(description="a camera.json or the name of a preset")] | CameraFile | None = None
    trajectory: (
        Annotated[str, Meta(description='a TUM file, {"turntable": {...}} or {"T_world_camera": ..., "frames": ...}')]
        | CourseFields
        | None
    ) = None
    parts: list[Annotated[str, Meta(description="a mesh file")] | PartFields] | None = None
    continuous: Annotated[bool, Meta(description="the camera moves while a frame is taken")] | None = None
    telemetry: Annotated[str, Meta(description="a CSV file of columns over time")] | None = None
    color: Annotated[bool, Meta(description="colour images are made")] | None = None
    infrared: Annotated[bool, Meta(description="infrared images are made")] | None = None


@dataclass(frozen=True)
class SceneSource:
    """A scene file."""

    content: Content  # as it stands
    given: SceneFile  # the same, as its type
    notes: list[str]  # what was left out, for people; appended to

    @property
    def folder(self) -> Path:
        """What names in the file are relative to."""
        return Path(str(self.content.where)).parent

    def path(self, name: str, *place: str | int) -> Path:
        """The file that stands at a place of the content; inside the scene's folder, as a scene is somebody else's."""
        path = inside(self.folder, name, SceneError, self.content.where)
        if path.is_dir():
            raise self.wrong(*place, expected="a file's name")
        return path

    def wrong(self, *place: str | int, found: str = "", expected: str = "") -> SceneError:
        """The error of something in the file."""
        error = self.content.wrong(SceneFile, *place, found=found, expected=expected)
        assert isinstance(error, SceneError)
        return error

    def required(self, fields: Struct, key: str, *place: str | int) -> float:
        """A number that must be there, of the fields at a place."""
        value = getattr(fields, key)
        if value is None:
            raise self.wrong(*place, key)
        return float(value)

    def first_pose(self, *places: tuple[Posed, tuple[str, ...]]) -> Array:
        """The camera's pose (4, 4) in the first fields that hold one; else the camera's frame is the world's."""
        for fields, place in places:
            for key in ("T_world_camera", "camera_pose", "pose"):
                if getattr(fields, key) is not None:
                    return self.pose(getattr(fields, key), *place, key)
        return np.eye(4)

    def pose(self, given: Any, *place: str | int) -> Array:
        """A pose (4, 4) in any of its forms; the identity where none is given."""
        if given is None:
            return np.eye(4)
        if isinstance(given, LookAt):
            return looking_at(np.array(given.eye), np.array(given.target), np.deg2rad(given.roll_deg or 0.0))
        try:
            numbers = np.array(given, float)
        except ValueError as problem:  # rows of different lengths
            raise self.wrong(*place) from problem
        if numbers.shape == (7,) and abs(np.linalg.norm(numbers[3:]) - 1) < 0.05:
            return from_tum(numbers)
        if not is_rigid(numbers):
            raise self.wrong(*place)
        return numbers
