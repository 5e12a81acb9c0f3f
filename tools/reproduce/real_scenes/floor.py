"""A Kinect v2 under the ceiling: the floor is a plane, at a distance that nobody measured."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.lens.boards.pictures import read_picture
from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.presets import PRESETS
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording
from tools.reproduce.real_scenes.scene import flat_mesh, write_scene

UNIT_M = 4.5 / 65535  # inferred by the recording's notes
RATE = 30.0  # [1/s]
OFF_M = 0.25  # [m] from the floor: a person
PLACE = (0.05, 0.02)  # [m], [rad] the floor's pose comes from the recording itself
FLAT_M = 0.003  # [m] guess
HALF_M = 4.0  # [m] the floor goes on beyond the image


def write_floor(source: Path, folder: Path) -> list[Path]:
    """The floor without the person who walks on it, as one recording."""
    camera = PRESETS["kinect-v2"][0]
    paths = sorted(source.glob("image*.png"))
    stack = [read_picture(path).astype(np.float32) * np.float32(UNIT_M) for path in paths]
    middle = np.median(np.stack([np.where(image > 0, image, np.nan) for image in stack[::6]]), axis=0)
    T_camera_floor = _floor(middle, camera)
    normal, distance = T_camera_floor[:3, 2], float(T_camera_floor[:3, 2] @ T_camera_floor[:3, 3])
    plane = distance / (np.dstack([camera.rays(), np.ones(camera.shape)]) @ normal)
    frames = (
        Frame(i, i / RATE, np.where(np.abs(depth - plane) < OFF_M, depth, np.float32(np.nan)))
        for i, depth in enumerate(stack)
    )
    stamps = np.arange(len(stack)) / RATE
    poses = np.repeat(np.linalg.inv(T_camera_floor)[None], len(stack), axis=0)
    write_recording(folder / "floor", camera, frames, Trajectory(stamps, poses))
    write_scene(folder / "floor", flat_mesh((-HALF_M, HALF_M), (-HALF_M, HALF_M)), ("nominal", *PLACE), FLAT_M)
    return [folder / "floor"]


def _floor(depth: NDArray[np.floating], camera: Camera) -> NDArray[np.float64]:
    """T_camera_floor (4, 4): z away from the camera, the origin where the axis meets the floor."""
    points = camera.points(depth)[60:-60:4, 60:-60:4].reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    for _ in range(4):
        # along a ray a plane is linear in 1 / z
        law = np.linalg.lstsq(points / points[:, 2:], 1 / points[:, 2], rcond=None)[0]
        points = points[np.abs(points @ law - 1) * points[:, 2] < 0.1]
    normal = law / np.linalg.norm(law)
    x = np.cross([0.0, 1.0, 0.0], normal)
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(normal, x), normal])
    T[:3, 3] = [0, 0, 1 / law[2]]
    return T
