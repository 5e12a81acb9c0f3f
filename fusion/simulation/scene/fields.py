"""What a scene to simulate may hold beyond what a recording states of its scene, as types."""

from typing import Annotated

from msgspec import Meta, Struct

from fusion.calibration.lens.boards.board import DrawnBoard
from fusion.files.values import FileName, Metres
from fusion.recording.native.camera_file import CameraFile
from fusion.recording.native.scene_file import CourseFields, Pose, SceneFields, Share

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
