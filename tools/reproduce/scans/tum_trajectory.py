"""Trajectory error on real frames with motion capture, beside Open3D's two pipelines in the same run.

    python -m tools.reproduce.scans.tum_trajectory [--frames 120] [--json]

120 frames of TUM RGB-D freiburg1_rpy. Every trajectory is aligned rigidly (SE(3), as evo does) to the motion capture,
at the time stamps of the depth frames; printed is the rms distance of the camera centres, by the code that
`fusion reconstruct` tells it with. Open3D runs with settings under which it does well on these frames: 5.8 mm
voxels (3 m / 512), depth up to 4 m, its default outlier distance of 7 cm.
"""

import argparse
import importlib
import json
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.trajectory import Trajectory
from fusion.reconstruction.pipeline import reconstruct
from fusion.reconstruction.result import Reconstruction
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording
from fusion.results.course import off_course

Array = NDArray[np.float64]
VOXEL = 3.0 / 512  # [m], what Open3D's examples use
FARTHEST = 4.0  # [m]
OUTLIER = 0.07  # [m]


def shared() -> Path:
    """The folder with the real recordings."""
    return Path(os.environ.get("FUSION_SHARED") or Path(__file__).resolve().parents[3] / "../shared")


def ours(recording: Recording) -> Reconstruction:
    """Frame-to-model tracking, every setting as by default: that this is a room is found by itself."""
    return reconstruct(recording)


def first(recording: Recording, frames: int) -> Recording:
    """The first frames of a recording."""
    return replace(recording, timestamps=recording.timestamps[:frames])


def open3d_model(recording: Recording, frames: int) -> Array:
    """Poses (n, 4, 4) of Open3D's dense frame-to-model pipeline."""
    o3d: Any = importlib.import_module("open3d")  # its type stubs reject what it takes
    o3d.utility.set_verbosity_level(o3d.utility.VerbosityLevel.Error)
    cpu, slam = o3d.core.Device("CPU:0"), o3d.t.pipelines.slam
    height, width = recording.camera.shape
    K = o3d.core.Tensor(recording.camera.matrix)
    model = slam.Model(VOXEL, 16, 20000, o3d.core.Tensor(np.eye(4)), cpu)
    now, seen = slam.Frame(height, width, K, cpu), slam.Frame(height, width, K, cpu)
    now.set_data_from_image("color", o3d.t.geometry.Image(np.zeros((height, width, 3), np.uint8)))
    T, poses, scale = np.eye(4), [], recording.camera.depth_scale
    point_to_plane = o3d.t.pipelines.odometry.Method.PointToPlane
    for index in range(frames):
        now.set_data_from_image("depth", o3d.t.geometry.Image(counts(recording, index)))
        if index:
            step = model.track_frame_to_model(now, seen, scale, FARTHEST, OUTLIER, point_to_plane)
            T = T @ step.transformation.numpy()
        model.update_frame_pose(index, o3d.core.Tensor(T))
        model.integrate(now, scale, FARTHEST, 8.0)
        model.synthesize_model_frame(seen, scale, 0.1, FARTHEST, 8.0, False)
        poses.append(T)
    return np.stack(poses)


def open3d_odometry(recording: Recording, frames: int) -> Array:
    """Poses (n, 4, 4) of Open3D's frame-to-frame odometry."""
    o3d: Any = importlib.import_module("open3d")
    odometry = o3d.t.pipelines.odometry
    K, start = o3d.core.Tensor(recording.camera.matrix), o3d.core.Tensor(np.eye(4))
    steps = [odometry.OdometryConvergenceCriteria(20)] * 3
    loss, scale = odometry.OdometryLossParams(OUTLIER), recording.camera.depth_scale
    black = o3d.t.geometry.Image(np.zeros((*recording.camera.shape, 3), np.uint8))

    def image(index: int) -> object:
        return o3d.t.geometry.RGBDImage(black, o3d.t.geometry.Image(counts(recording, index)))

    poses, before = [np.eye(4)], image(0)
    for index in range(1, frames):
        now = image(index)
        found = odometry.rgbd_odometry_multi_scale(
            now, before, K, start, scale, FARTHEST, steps, odometry.Method.PointToPlane, loss
        )
        poses.append(poses[-1] @ found.transformation.numpy())
        before = now
    return np.stack(poses)


def counts(recording: Recording, index: int) -> NDArray[np.uint16]:
    """Depth (h, w) as it stands in the file, 0 where missing."""
    return np.nan_to_num(np.rint(recording[index].depth * recording.camera.depth_scale)).astype(np.uint16)


def run(folder: Path, frames: int, only_ours: bool = False) -> dict[str, dict[str, float]]:
    """Error [m], frames without a pose, and time [s/frame] of each pipeline; of ours triangles and processor time."""
    whole = open_recording(folder, "tum-fr1")
    recording = first(whole, min(frames, len(whole)))
    start, busy = time.perf_counter(), time.process_time()
    made = ours(recording)
    seconds, busy = time.perf_counter() - start, time.process_time() - busy
    table = {"fusion": row(made.trajectory.poses, recording, seconds)}
    table["fusion"] |= {"triangles": len(made.mesh.faces), "processor_s": busy}
    others: dict[str, Callable[[Recording, int], Array]] = {
        "Open3D frame to model": open3d_model,
        "Open3D odometry": open3d_odometry,
    }
    for name, pipeline in {} if only_ours else others.items():
        start = time.perf_counter()
        poses = pipeline(recording, len(recording))
        table[name] = row(poses, recording, time.perf_counter() - start)
    return table


def row(poses: Array, recording: Recording, seconds: float) -> dict[str, float]:
    """What one pipeline reached."""
    found = off_course(Trajectory(recording.timestamps, poses), recording)
    assert found is not None
    lost = int(np.isnan(poses).any(axis=(1, 2)).sum())
    return {"ate_rms_m": found.error.rmse, "lost": lost, "s_per_frame": seconds / len(recording)}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    table = run(shared() / "data/tum_fr1_rpy", options.frames)
    if options.json:
        print(json.dumps(table, indent=1))
    else:
        for name, reached in table.items():
            print(
                f"{name:<22} ATE {reached['ate_rms_m'] * 100:5.2f} cm rms, {reached['lost']:.0f} frames lost, "
                f"{reached['s_per_frame']:.2f} s a frame"
                + (f", {reached['processor_s']:.1f} s of processor time" if "processor_s" in reached else "")
            )
