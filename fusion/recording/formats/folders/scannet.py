"""Frames as ScanNet's SensReader exports them, and many scripts after it: `depth/0.png`, `color/0.jpg`, `pose/0.txt`
(4 x 4, camera to world), `intrinsic/intrinsic_depth.txt` and `intrinsic_color.txt`.

github.com/ScanNet/ScanNet, SensReader/python.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from fusion.errors import RecordingError
from fusion.files.inside import inside
from fusion.geometry.camera import Camera
from fusion.geometry.pose import inverse
from fusion.geometry.trajectory import Trajectory
from fusion.recording.formats import open3d_folder
from fusion.recording.formats.recorded.parts import no_stamps
from fusion.recording.formats.seven_scenes import camera_in, read_matrix
from fusion.recording.formats.tum import with_color_placed
from fusion.recording.images.frame_files import FrameFiles
from fusion.recording.images.load_frame import load_frame
from fusion.recording.images.read import image_size
from fusion.recording.recording import Recording

POSES = ("pose", "poses")
DEPTH, COLOR = "intrinsic_depth.txt", "intrinsic_color.txt"
PLACE = "extrinsic_color.txt"  # of the colour camera to the depth camera, nearly always none


def recognises(folder: Path) -> bool:
    """True for a folder with depth images and a pose file of one of them."""
    return bool(_poses(folder, open3d_folder.images_in(folder, "depth")))


def read(folder: Path, camera: Camera | None) -> Recording:
    """The recording in such a folder. Raises RecordingError."""
    depth = open3d_folder.images_in(folder, "depth")
    color = next(
        (found for name in open3d_folder.COLOR_FOLDERS if (found := open3d_folder.images_in(folder, name))), []
    )
    camera = camera or _camera(folder, depth, color) or open3d_folder.camera_in(folder, depth)
    stamps, warnings = no_stamps(len(depth))
    matched, told = open3d_folder.matching(depth, color)
    files, more = with_color_placed(FrameFiles(folder=folder, depth=depth, color=matched), camera)
    poses = np.full((len(depth), 4, 4), np.nan)
    for k, name in _poses(folder, depth).items():
        poses[k] = read_matrix(inside(folder, name, RecordingError))
    return Recording(
        path=folder,
        format="scannet",
        camera=camera,
        timestamps=stamps,
        load=partial(load_frame, files, camera, stamps),
        poses=Trajectory(stamps, poses) if np.isfinite(poses).any() else None,
        warnings=(*warnings, *told, *more),
        files=files,
    )


def _poses(folder: Path, depth: list[str]) -> dict[int, str]:
    """The pose file of each frame that has one, by the number in its name."""
    place = next((name for name in POSES if (folder / name).is_dir()), "")
    names = [f"{place}/{path.name}" for path in (folder / place).glob("*.txt")] if place and depth else []
    known = {open3d_folder.number_in(name): name for name in names}
    return {k: known[n] for k, name in enumerate(depth) if (n := open3d_folder.number_in(name)) in known}


def _camera(folder: Path, depth: list[str], color: list[str]) -> Camera | None:
    places = [place for place in (folder / "intrinsic", folder) if (place / DEPTH).is_file()]
    if not places:
        return None
    camera = camera_in(places[0] / DEPTH, image_size(folder / depth[0]))
    if not color or not (places[0] / COLOR).is_file():
        return camera
    T = read_matrix(places[0] / PLACE) if (places[0] / PLACE).is_file() else np.eye(4)
    beside = camera_in(places[0] / COLOR, image_size(folder / color[0]))
    over = camera.shape == beside.shape and np.allclose(camera.parameters, beside.parameters, rtol=1e-3)
    return camera if over and np.allclose(T, np.eye(4)) else replace(camera, color=beside, T_color_depth=inverse(T))
