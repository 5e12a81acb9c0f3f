"""Scenes in the layout of the BOP benchmark: `scene_camera.json`, `depth/000000.png`, `rgb/` or `gray/`."""

from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct

from fusion.errors import RecordingError
from fusion.files.content import Content
from fusion.files.inside import all_inside, inside
from fusion.files.json_file import read_json
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse, is_rigid, pose
from fusion.geometry.trajectory import Trajectory
from fusion.recording.images.frame_files import FrameFiles
from fusion.recording.images.load_frame import load_frame
from fusion.recording.images.read import image_size
from fusion.recording.native.camera_file import are_focal
from fusion.recording.recording import Recording

# image numbers carry no time
FRAMES_PER_SECOND = 30.0

Number = Annotated[float, Meta(gt=-1e10, lt=1e10)]  # lengths are millimetres
MATRIX = "9 numbers, the camera matrix row by row [px], focal lengths from 0.01 to 1e6"
Nine = tuple[Number, Number, Number, Number, Number, Number, Number, Number, Number]


class BopCamera(Struct, frozen=True, kw_only=True):
    """The camera of one image in `scene_camera.json`."""

    cam_K: Annotated[Nine, Meta(description=MATRIX)] | None = None
    depth_scale: Annotated[float, Meta(ge=1e-4, le=1e6, description="millimetres per count")] = 1.0
    cam_R_w2c: Annotated[Nine, Meta(description="9 numbers, a rotation row by row")] | None = None
    cam_t_w2c: Annotated[tuple[Number, Number, Number], Meta(description="3 numbers [mm], world to camera")] | None = (
        None
    )


Entries = dict[str, BopCamera]


def recognises(folder: Path) -> bool:
    """True for a folder with BOP's list of cameras."""
    return (folder / "scene_camera.json").is_file()


def read(folder: Path, camera: Camera | None) -> Recording:
    """The recording in a BOP scene folder. Raises RecordingError."""
    path = inside(folder, "scene_camera.json", RecordingError)
    content = Content(read_json(path, RecordingError), path, "the scene", RecordingError)
    entries = _entries(content)
    depth = _names(folder, "depth", list(entries))
    numbers = [number for number in entries if number in depth]
    if not numbers:
        raise RecordingError("the scene is empty", path, "no frame with a depth image", "depth/000000.png and so on")
    color = _names(folder, "rgb", numbers) or _names(folder, "gray", numbers)
    files = FrameFiles(
        folder=folder,
        depth=[depth[number] for number in numbers],
        color=[color.get(number) for number in numbers] if color else [],
    )
    used = {number: entries[number] for number in numbers}
    stamps = np.array(numbers) / FRAMES_PER_SECOND
    warnings: list[str] = []
    if camera is None:
        size = image_size(folder / files.depth[0])
        camera, warnings = _camera(used, size, content)
    return Recording(
        path=folder,
        format="bop",
        camera=camera,
        timestamps=stamps,
        load=partial(load_frame, files, camera, stamps),
        poses=_poses(used, stamps, content),
        warnings=tuple(warnings),
        files=files,
    )


def _entries(content: Content) -> dict[int, BopCamera]:
    entries = {}
    for name, entry in content.as_type(Entries).items():
        if not name.isascii() or not name.isdigit() or len(name) > 9:
            raise content.wrong(Entries, name, found="that name", expected="the number of an image")
        entries[int(name)] = entry
    return {number: entries[number] for number in sorted(entries)}


def _names(folder: Path, kind: str, numbers: list[int]) -> dict[int, str]:
    """File name by image number, of those that are there."""
    if not (folder / kind).is_dir():
        return {}
    there = {entry.stem: entry.name for entry in (folder / kind).iterdir()}
    names = {number: f"{kind}/{there[f'{number:06d}']}" for number in numbers if f"{number:06d}" in there}
    all_inside(folder, names.values(), RecordingError)
    return names


def _camera(entries: dict[int, BopCamera], size: tuple[int, int], content: Content) -> tuple[Camera, list[str]]:
    for number, entry in entries.items():
        if entry.cam_K is None or not are_focal(entry.cam_K[0], entry.cam_K[4]):
            raise content.wrong(Entries, str(number), "cam_K")
    matrices = np.array([entry.cam_K for entry in entries.values()])
    scales = np.array([entry.depth_scale for entry in entries.values()])
    if np.ptp(scales) > 1e-9 * scales[0]:
        other = list(entries)[int(np.abs(scales - scales[0]).argmax())]
        raise content.wrong(Entries, str(other), "depth_scale", expected=f"that of the first image, {scales[0]:g}")
    fx, _, cx, _, fy, cy, *_ = matrices[0]
    spread = np.abs(matrices - matrices[0]).max()
    # 0.5 px: below it one camera serves all images
    warnings = [f"cam_K differs by up to {spread:.1f} px between images; that of the first is used"] * int(spread > 0.5)
    # depth_scale turns a count into millimetres
    return Camera(*size, fx, fy, cx, cy, depth_scale=1000.0 / scales[0]), warnings


def _poses(entries: dict[int, BopCamera], stamps: Array, content: Content) -> Trajectory | None:
    """Poses where they are stated: BOP gives world to camera, millimetres."""
    poses = np.full((len(entries), 4, 4), np.nan)
    for T_world_camera, (number, entry) in zip(poses, entries.items(), strict=True):
        if entry.cam_R_w2c is not None and entry.cam_t_w2c is not None:
            T_camera_world = pose(np.reshape(entry.cam_R_w2c, (3, 3)), np.array(entry.cam_t_w2c) / 1000)
            # 0.01: rotations are written with few decimals
            if not is_rigid(T_camera_world, 0.01):
                raise content.wrong(Entries, str(number), "cam_R_w2c")
            T_world_camera[:] = inverse(T_camera_world)
    return Trajectory(stamps, poses) if np.isfinite(poses).any() else None
