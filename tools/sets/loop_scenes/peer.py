"""Open3D's frame-to-model tracking on the frames of a recording, in a process of its own.

    python -m loop_scenes.peer RECORDING OUT VOXEL FARTHEST

As its example `dense_slam.py` does it, geometry alone. A frame that it cannot track (it raises an error) stays where
the one before was, and is not integrated.
"""

import importlib
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from tools.sets.judging.writing import trajectory
from tools.sets.loop_scenes.frames import read

OUTLIER = 0.07  # [m], its default
BAND = 8.0  # voxels of truncation, its default
NEAREST = 0.1  # [m], its default
BLOCKS = 20000  # to begin with; its hash map grows


def main() -> None:
    """Writes OUT/trajectory.txt, OUT/mesh.ply and OUT/peer.json."""
    recording, output, voxel, farthest = Path(sys.argv[1]), Path(sys.argv[2]), float(sys.argv[3]), float(sys.argv[4])
    o3d: Any = importlib.import_module("open3d")  # its type stubs reject what it takes
    core, slam = o3d.core, o3d.t.pipelines.slam
    o3d.utility.set_verbosity_level(o3d.utility.VerbosityLevel.Error)
    frames, cpu = read(recording), core.Device("CPU:0")
    height, width = frames.counts(0).shape
    K = core.Tensor(frames.K)
    model: Any = slam.Model(voxel, 16, BLOCKS, core.Tensor(np.eye(4)), cpu)
    now, seen = slam.Frame(height, width, K, cpu), slam.Frame(height, width, K, cpu)
    now.set_data_from_image("color", o3d.t.geometry.Image(np.zeros((height, width, 3), np.uint8)))
    method = o3d.t.pipelines.odometry.Method.PointToPlane
    T, poses, failed, begin = np.eye(4), [], [], time.monotonic()
    for k in range(len(frames.files)):
        counts = frames.counts(k)
        now.set_data_from_image("depth", o3d.t.geometry.Image(counts))
        try:
            if k:
                found = model.track_frame_to_model(now, seen, frames.scale, farthest, OUTLIER, method)
                T = T @ found.transformation.numpy()
        except RuntimeError:
            failed.append(k)
        else:
            model.update_frame_pose(k, core.Tensor(T))
            model.integrate(now, frames.scale, farthest, BAND)
            model.synthesize_model_frame(seen, frames.scale, NEAREST, farthest, BAND, False)
        poses.append(T)
    seconds = time.monotonic() - begin
    output.mkdir(parents=True, exist_ok=True)
    trajectory(output / "trajectory.txt", frames.times, np.stack(poses))
    o3d.io.write_triangle_mesh(str(output / "mesh.ply"), model.extract_trianglemesh(3.0, -1).to_legacy())
    told = {"seconds": seconds, "failed": failed, "voxel_m": voxel, "farthest_m": farthest}
    (output / "peer.json").write_text(json.dumps(told, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
