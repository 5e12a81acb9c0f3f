"""`scene.json` of a recording: what was in front of the camera, and how well it is known."""

from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct, field

from fusion.errors import RecordingError
from fusion.files.content import Content, FileName, Metres, Name, Point, Whole
from fusion.files.inside import inside
from fusion.files.json_file import json_in
from fusion.files.reading import read_text
from fusion.recording.recording import Recording

MOST_FRAMES = 100_000  # an hour at 30 frames a second; more is a slip of the pen

Source = Literal["surveyed", "tracked", "nominal"]
SigmaM = Annotated[float, Meta(ge=0, lt=10, description="standard deviation per axis of one common error [m]")]
SigmaRad = Annotated[float, Meta(ge=0, lt=10, description="standard deviation per axis of one common error [rad]")]
Share = Annotated[float, Meta(ge=0, le=1)]
Lux = Annotated[float, Meta(ge=0, le=1e6, description="light that is not the sensor's own [lux]")]
Seconds = Annotated[float, Meta(ge=1e-6, le=1e6, description="[s]")]
Degrees = Annotated[float, Meta(ge=-3600, le=3600, description="[deg]")]
Vector = Annotated[tuple[Metres, Metres, Metres], Meta(description="three numbers")]


class LookAt(Struct, frozen=True, kw_only=True):
    """A camera that looks at a point, upright in a world with z up."""

    eye: Point
    target: Point
    roll_deg: Degrees | None = None


Pose = Annotated[
    list[Metres | list[Metres]] | LookAt | None,
    Meta(description="a rigid 4x4 matrix [m], tx ty tz qx qy qz qw, or eye and target; below 1e7"),
]


class Posed(Struct, frozen=True, kw_only=True):
    """What may hold the camera's pose, under one of three names; camera to world."""

    T_world_camera: Pose = None
    camera_pose: Pose = None
    pose: Pose = None


class Timed(Posed, frozen=True, kw_only=True):
    """Frames in time."""

    frames: Annotated[Whole, Meta(ge=1, le=MOST_FRAMES)] | None = None
    frame_s: Seconds | None = None
    start_s: Annotated[float, Meta(ge=-1e9, le=1e9, description="since the sensor was switched on [s]")] | None = None
    continuous: Annotated[bool, Meta(description="things move while a frame is taken")] | None = None


class TableErrors(Struct, frozen=True, kw_only=True):
    """What a turntable does not report."""

    uneven_sd_deg: Degrees | None = None
    slip_frame: Annotated[Whole, Meta(ge=0, le=1e9)] | None = None
    slip_deg: Degrees | None = None
    wobble_deg: Degrees | None = None
    wobble_phase_deg: Degrees | None = None


class TableFields(Timed, frozen=True, kw_only=True):
    """A turntable before a camera that stands still."""

    axis_point: Point | None = None
    axis_direction: Vector | None = None
    degrees_per_frame: Degrees | None = None
    errors: TableErrors | None = None


class CourseFields(Timed, frozen=True, kw_only=True):
    """A camera that stands still, perhaps before a turntable."""

    turntable: TableFields | None = None


class Poses(Struct, frozen=True, kw_only=True):
    """How well the poses are known."""

    source: Source | None = None
    sigma_m: SigmaM | None = None
    sigma_rad: SigmaRad | None = None
    from_: Annotated[Literal["images"], Meta(description="found in images of this camera")] | None = field(
        name="from", default=None
    )


class SceneFields(Posed, frozen=True, kw_only=True):
    """A scene as a recording states it: `scene.json`."""

    name: Name = None
    mesh: FileName | None = None
    reflectance: Annotated[Share, Meta(description="of all surfaces, in the infrared")] | None = None
    poses: Poses | Literal["none"] | None = None
    ambient_lux: Lux | None = None
    mesh_from: Annotated[Literal["reconstruction"], Meta(description="made of this sensor's frames")] | None = None
    mesh_sigma_m: Annotated[float, Meta(ge=0, lt=10, description="how far the mesh may be off [m]")] | None = None
    trajectory: Annotated[str, Meta(description="a TUM file")] | CourseFields | None = None

    @property
    def stated_poses(self) -> Poses:
        """How well the poses are known; nothing stated where they are not said."""
        return self.poses if isinstance(self.poses, Poses) else Poses()


def read_scene_fields(path: Path) -> dict[str, Any]:
    """The content of a `scene.json` that fits what a recording may state. Raises RecordingError."""
    return scene_in(read_text(path, RecordingError, "the scene file"), path)


def scene_in(text: str, path: Path) -> dict[str, Any]:
    """The same of a text that stands in another file; `path` names it. Raises RecordingError."""
    content = Content(json_in(text, path, RecordingError, "the scene"), path, "the scene", RecordingError)
    content.as_type(SceneFields)
    return dict(content.value)


def scene_content(recording: Recording) -> Content:
    """The scene that a recording states, and how it is named in messages."""
    return Content(recording.scene, Path(recording.path) / "scene.json", "the scene", RecordingError)


def stated_scene(recording: Recording) -> SceneFields:
    """The scene that a recording states; empty where it states none. Raises RecordingError."""
    return scene_content(recording).as_type(SceneFields)


def scene_mesh(recording: Recording) -> Path | None:
    """The mesh that a recording's scene names, inside its folder; None where it names none. Raises RecordingError."""
    name = stated_scene(recording).mesh
    folder = Path(recording.path)
    return None if name is None else inside(folder, name, RecordingError, folder / "scene.json")
