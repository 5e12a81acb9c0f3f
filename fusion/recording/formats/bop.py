"""Scenes in the layout of the BOP benchmark: `scene_camera.json`, `depth/000000.png`, `rgb/` or `gray/`."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse, is_rigid, pose
from fusion.geometry.trajectory import Trajectory
from fusion.recording.frame_files import FrameFiles
from fusion.recording.images import image_size
from fusion.recording.load_frame import load_frame
from fusion.recording.recording import Recording
from fusion.recording.text_files import read_json

# image numbers carry no time
FRAMES_PER_SECOND = 30.0


def recognises(folder: Path) -> bool:
    """True for a folder with BOP's list of cameras."""
    return (folder / "scene_camera.json").is_file()


def read(folder: Path, camera: Camera | None) -> Recording:
    """The recording in a BOP scene folder. Raises RecordingError."""
    path = folder / "scene_camera.json"
    entries = _entries(path)
    depth = _names(folder, "depth", list(entries))
    numbers = [number for number in entries if number in depth]
    if not numbers:
        raise RecordingError("the scene is empty", folder, "no depth image", "depth/000000.png and so on")
    color = _names(folder, "rgb", numbers) or _names(folder, "gray", numbers)
    files = FrameFiles(
        folder=folder,
        depth=[depth[number] for number in numbers],
        color=[color.get(number) for number in numbers] if color else [],
    )
    stamps = np.array(numbers) / FRAMES_PER_SECOND
    warnings: list[str] = []
    if camera is None:
        size = image_size(folder / files.depth[0])
        camera, warnings = _camera([entries[number] for number in numbers], size, path)
    return Recording(
        path=folder,
        format="bop",
        camera=camera,
        timestamps=stamps,
        load=partial(load_frame, files, camera, stamps),
        poses=_poses([entries[number] for number in numbers], stamps, path),
        warnings=tuple(warnings),
        files=files,
    )


def _entries(path: Path) -> dict[int, dict[str, Any]]:
    content = read_json(path)
    entries = {}
    for name, entry in content.items():
        if not name.isascii() or not name.isdigit() or len(name) > 9 or not isinstance(entry, dict):
            raise RecordingError("an entry cannot be read", path, repr(name[:20]), '{"0": {"cam_K": [9], ...}, ...}')
        entries[int(name)] = entry
    return {number: entries[number] for number in sorted(entries)}


def _names(folder: Path, kind: str, numbers: list[int]) -> dict[int, str]:
    """File name by image number, of those that are there."""
    if not (folder / kind).is_dir():
        return {}
    there = {entry.stem: entry.name for entry in (folder / kind).iterdir()}
    return {number: f"{kind}/{there[f'{number:06d}']}" for number in numbers if f"{number:06d}" in there}


def _numbers(entry: dict[str, Any], name: str, length: int, path: Path) -> Array:
    try:
        values = np.array(entry.get(name), float).reshape(-1)
    except (TypeError, ValueError, OverflowError):
        values = np.zeros(0)
    if len(values) != length or not np.isfinite(values).all():
        raise RecordingError(f'"{name}" cannot be used', path, repr(entry.get(name))[:60], f"{length} finite numbers")
    return values


def _camera(entries: list[dict[str, Any]], size: tuple[int, int], path: Path) -> tuple[Camera, list[str]]:
    matrices = np.stack([_numbers(entry, "cam_K", 9, path) for entry in entries])
    scales = np.array([_numbers({"depth_scale": 1.0} | entry, "depth_scale", 1, path)[0] for entry in entries])
    if np.ptp(scales) > 1e-9 * abs(scales[0]) or scales[0] <= 0:
        raise RecordingError(
            '"depth_scale" cannot be used', path, f"{scales.min()} to {scales.max()}", "one value above 0"
        )
    fx, _, cx, _, fy, cy, *_ = matrices[0]
    if fx <= 0 or fy <= 0:
        raise RecordingError('"cam_K" cannot be used', path, f"fx {fx}, fy {fy}", "row by row, focal lengths above 0")
    spread = np.abs(matrices - matrices[0]).max()
    # 0.5 px: below it one camera serves all images
    warnings = [f"cam_K differs by up to {spread:.1f} px between images; that of the first is used"] * int(spread > 0.5)
    # depth_scale turns a count into millimetres
    return Camera(*size, fx, fy, cx, cy, depth_scale=1000.0 / scales[0]), warnings


def _poses(entries: list[dict[str, Any]], stamps: Array, path: Path) -> Trajectory | None:
    """Poses where they are stated: BOP gives world to camera, millimetres."""
    poses = np.full((len(entries), 4, 4), np.nan)
    for T_world_camera, entry in zip(poses, entries, strict=True):
        if "cam_R_w2c" in entry and "cam_t_w2c" in entry:
            R = _numbers(entry, "cam_R_w2c", 9, path).reshape(3, 3)
            T_camera_world = pose(R, _numbers(entry, "cam_t_w2c", 3, path) / 1000)
            # 0.01: rotations are written with few decimals
            if not is_rigid(T_camera_world, 0.01):
                raise RecordingError('"cam_R_w2c" is no rotation', path, np.round(R.reshape(-1), 3).tolist())
            T_world_camera[:] = inverse(T_camera_world)
    return Trajectory(stamps, poses) if np.isfinite(poses).any() else None
