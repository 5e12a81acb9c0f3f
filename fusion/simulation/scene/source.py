"""A scene file that is being read: its content, and what the files and poses that it names become."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import Struct

from fusion.errors import SceneError
from fusion.files.content import Content
from fusion.files.inside import inside
from fusion.geometry.pose import Array, from_tum, is_rigid
from fusion.recording.native.scene_file import LookAt, Posed
from fusion.simulation.scene.course import looking_at
from fusion.simulation.scene.fields import SceneFile


@dataclass(frozen=True)
class SceneSource:
    """A scene file.

    Attributes:
        content: as it stands.
        given: the same, as its type.
        notes: what was left out, for people; appended to.
    """

    content: Content
    given: SceneFile
    notes: list[str]

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
