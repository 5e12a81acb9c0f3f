"""A cardboard box on a turntable before a PrimeSense camera: scanned, then stated with a wrong table or camera."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import about_axis, inverse
from fusion.geometry.trajectory import Trajectory
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording
from fusion.scan.pipeline import scan_turntable
from fusion.scan.result import Scan
from fusion.scan.settings import ScanSettings
from tools.reproduce.real_scenes.scene import write_scene

APART_S = 2.0  # [s] between frames: the stamps of the recording are made up, and so is its speed
PLACE = (0.002, 0.005)  # [m], [rad] guess: axis and first frame as the scan found them
SPARE_M = 0.01  # [m] beyond the cylinder that the scan found around what turns


def write_box(source: Path, folder: Path, even: bool) -> list[Path]:
    """The recording with its own scan as mesh: the table as if it made equal steps of one turn, or the file's camera.

    Args:
        even: state equal steps and the focal length that the scan found; else its angles, and the stated camera.
    """
    recording = open_recording(source)
    scan = scan_turntable(recording, ScanSettings(refine_camera=True))
    n, found = len(recording), np.nan_to_num(scan.motion.angles)
    stated = np.sign(found[-1]) * 2 * np.pi * np.arange(n) / n if even else found
    first = scan.trajectory.poses[0]
    point = first[:3, :3] @ scan.motion.axis.point + first[:3, 3]
    axis = first[:3, :3] @ scan.motion.axis.direction
    poses = np.stack([inverse(about_axis(point, axis, angle)) @ first for angle in stated])
    stamps = np.asarray(APART_S * np.arange(n), float)
    # the object is found by the camera that the scan found, whichever is stated
    frames = (Frame(i, stamps[i], _of_object(recording[i].depth, scan)) for i in range(n))
    telemetry = {"timestamp": stamps, "turntable_deg": np.degrees(stated)}
    out = folder / "box"
    write_recording(out, scan.camera if even else recording.camera, frames, Trajectory(stamps, poses), telemetry)
    write_scene(out, scan.mesh, ("nominal", *PLACE), mesh_sigma_m=None)
    return [out]


def _of_object(depth: NDArray[np.floating], scan: Scan) -> NDArray[np.float32]:
    """Depth [m] of what turns above the plate, NaN elsewhere."""
    axis, motion = scan.motion.axis, scan.motion
    points = scan.camera.points(depth)
    height = (points - axis.point) @ axis.direction
    away = np.linalg.norm(points - axis.point - height[..., None] * axis.direction, axis=-1)
    with np.errstate(invalid="ignore"):
        kept = (away < motion.radius + SPARE_M) & (height > (motion.plate or motion.bottom)) & (height < motion.top)
    return np.where(kept, depth, np.nan).astype(np.float32)
