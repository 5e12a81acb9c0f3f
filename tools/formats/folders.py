"""Folders of images, written from their authors' descriptions with OpenCV's and numpy's writers."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tools.formats.take import Array, Take


def image(file: Path, pixels: NDArray[Any]) -> None:
    """A PNG or JPEG; colours come as RGB."""
    file.parent.mkdir(parents=True, exist_ok=True)
    turned = np.ascontiguousarray(pixels[..., ::-1]) if pixels.ndim == 3 else pixels
    if not cv2.imwrite(str(file), turned):
        raise OSError(f"{file}: not written")


def quaternion(T: Array) -> Array:
    """x, y, z, w of a pose."""
    return np.asarray(Rotation.from_matrix(T[:3, :3]).as_quat())


def tum(take: Take, path: Path, counts_per_m: float = 5000.0) -> Path:
    """TUM RGB-D (Sturm et al. 2012, the benchmark's page on file formats): no camera, 5000 counts per metre."""
    for kind, pixels in (("depth", take.counts(1 / counts_per_m)), ("rgb", take.color)):
        if pixels is None:
            continue
        names = [f"{kind}/{stamp:.6f}.png" for stamp in take.stamps]
        for name, one in zip(names, pixels, strict=True):
            image(path / name, one)
        lines = [f"{stamp:.6f} {name}" for stamp, name in zip(take.stamps, names, strict=True)]
        (path / f"{kind}.txt").write_text("\n".join(["# timestamp filename", *lines, ""]), encoding="utf-8")
    if take.poses is not None:
        rows = [
            " ".join(f"{v:.9f}" for v in [stamp, *T[:3, 3], *quaternion(T)])
            for stamp, T in zip(take.stamps, take.poses, strict=True)
        ]
        (path / "groundtruth.txt").write_text("\n".join(["# timestamp tx ty tz qx qy qz qw", *rows, ""]))
    return path


def native(take: Take, path: Path, **said: object) -> Path:
    """The program's own folder (docs/formats.md): TUM's with a camera.json."""
    tum(take, path, 1 / take.unit)
    lens = take.lens
    told: dict[str, Any] = {
        "width": lens.width,
        "height": lens.height,
        "fx": lens.fx,
        "fy": lens.fy,
        "cx": lens.cx,
        "cy": lens.cy,
    }
    told |= {"distortion": list(lens.bend), "depth_scale": 1 / take.unit} | said
    (path / "camera.json").write_text(json.dumps(told), encoding="utf-8")
    return path


def seven_scenes(take: Take, path: Path) -> Path:
    """Microsoft's 7-Scenes: millimetres, 65535 where there is none, 4 x 4 camera to world."""
    assert take.color is not None and take.poses is not None
    for i, counts in enumerate(take.counts(0.001)):
        image(path / f"frame-{i:06d}.depth.png", np.where(counts > 0, counts, 65535).astype(np.uint16))
        image(path / f"frame-{i:06d}.color.png", take.color[i])
        np.savetxt(path / f"frame-{i:06d}.pose.txt", take.poses[i], fmt="%.9e")
    return path


def bop(take: Take, path: Path) -> Path:
    """BOP's scene (bop_toolkit, docs/bop_datasets_format.md): 0.1 mm a count here, poses from the world in mm."""
    assert take.color is not None and take.poses is not None
    told = {}
    for i, counts in enumerate(take.counts(0.0001)):
        image(path / "depth" / f"{i:06d}.png", counts)
        image(path / "rgb" / f"{i:06d}.png", take.color[i])
        back = np.linalg.inv(take.poses[i])
        held = {"cam_K": take.lens.matrix.ravel().tolist(), "depth_scale": 0.1}
        told[str(i)] = held | {"cam_R_w2c": back[:3, :3].ravel().tolist(), "cam_t_w2c": (1000 * back[:3, 3]).tolist()}
    (path / "scene_camera.json").write_text(json.dumps(told), encoding="utf-8")
    return path


def open3d(take: Take, path: Path) -> Path:
    """Open3D's folder by Open3D's own writers; names hold microseconds as Redwood's do."""
    import open3d

    o3d: Any = open3d

    assert take.color is not None and take.poses is not None
    for kind in ("depth", "color"):
        (path / kind).mkdir(parents=True, exist_ok=True)
    lens = take.lens
    camera = o3d.camera.PinholeCameraIntrinsic(lens.width, lens.height, *lens.four)
    o3d.io.write_pinhole_camera_intrinsic(str(path / "intrinsic.json"), camera)
    way = []
    for i, counts in enumerate(take.counts(0.001)):
        name = f"{i + 1:07d}-{round(take.stamps[i] * 1e6):012d}"
        o3d.io.write_image(str(path / "depth" / f"{name}.png"), o3d.geometry.Image(counts))
        o3d.io.write_image(str(path / "color" / f"{name}.png"), o3d.geometry.Image(take.color[i].copy()))
        one = o3d.camera.PinholeCameraParameters()
        one.intrinsic, one.extrinsic = camera, np.linalg.inv(take.poses[i])
        way.append(one)
    held = o3d.camera.PinholeCameraTrajectory()
    held.parameters = way
    o3d.io.write_pinhole_camera_trajectory(str(path / "trajectory.log"), held)
    return path


def plain(take: Take, path: Path) -> Path:
    """Bare 16-bit PNG images of millimetres."""
    for i, counts in enumerate(take.counts(0.001)):
        image(path / f"{i}.png", counts)
    return path


def arrays(take: Take, path: Path) -> Path:
    """Bare NPY arrays of metres."""
    path.mkdir(parents=True)
    for i, z in enumerate(take.depth):
        np.save(path / f"depth{i}.npy", z.astype(np.float32))
    return path


def nerfstudio(take: Take, path: Path) -> Path:
    """transforms.json (docs.nerf.studio, data conventions): OpenGL's axes, pixels from the image's corner, mm.

    `applied_transform` is as ns-process-data writes it: the stated poses are it times those of the recording.
    """
    assert take.color is not None and take.poses is not None
    lens, applied = take.lens, np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
    frames = []
    for i, counts in enumerate(take.counts(0.001)):
        image(path / "depth" / f"frame_{i + 1:05d}.png", counts)
        image(path / "images" / f"frame_{i + 1:05d}.png", take.color[i])
        stated = applied @ take.poses[i] @ np.diag([1.0, -1, -1, 1])
        names = {"file_path": f"images/frame_{i + 1:05d}.png", "depth_file_path": f"depth/frame_{i + 1:05d}.png"}
        frames.append(names | {"transform_matrix": stated.tolist()})
    told = {"camera_model": "OPENCV", "w": lens.width, "h": lens.height, "fl_x": lens.fx, "fl_y": lens.fy}
    told |= {"cx": lens.cx + 0.5, "cy": lens.cy + 0.5, "k1": 0.0, "k2": 0.0, "p1": 0.0, "p2": 0.0}
    told |= {"applied_transform": applied[:3].tolist(), "frames": frames}
    (path / "transforms.json").write_text(json.dumps(told), encoding="utf-8")
    return path
