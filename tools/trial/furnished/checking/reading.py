"""Reads a case back: images, poses, what the mesh lets expect. OpenCV's lens, Open3D's rays."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import open3d as o3d
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[Any]
Parameters = dict[str, dict[str, float]]
RAYS = 6  # across a pixel that collects over its area
FLAT = 0.12  # relative spread of the ranges in a pixel, above which their mean says nothing


@dataclass
class ReadFrame:
    """Attributes:
    T: (4, 4) pose as stated.
    z: (h, w) [m] as recorded, NaN where nothing is.
    expected: (h, w) [m] of the mesh from the stated pose.
    normal: (h, w, 3) of it, in the camera's frame.
    ir: (h, w) [counts] or None.
    """

    T: Array
    z: Array
    expected: Array
    normal: Array
    ir: Array | None


@dataclass(frozen=True)
class ReadRecording:
    """`direction`: (h, w, 3) with z = 1. `pose_sigma`: (6,) [m, rad]."""

    name: str
    camera: dict[str, Any]
    pose_sigma: Array
    direction: Array
    frames: list[ReadFrame]

    @property
    def stretch(self) -> Array:
        """(h, w) range over z."""
        return np.asarray(np.linalg.norm(self.direction, axis=-1))


@dataclass(frozen=True)
class ReadCase:
    """`told`: values of the parameters of each effect in sensor.json."""

    told: Parameters
    recordings: list[ReadRecording]


@dataclass(frozen=True)
class Mesh:
    scene: Any
    grey: Array  # (triangles,) 0 to 1

    def cast(self, T: Array, direction: Array) -> tuple[Array, Array, Array]:
        """(h, w) [m] depth, (h, w, 3) normal in the camera's frame, (h, w) grey of what is met."""
        ray = direction @ T[:3, :3].T
        origin = np.broadcast_to(T[:3, 3], ray.shape)
        both = np.concatenate([origin, ray], -1).astype(np.float32)
        answer = self.scene.cast_rays(o3d.core.Tensor.from_numpy(both))
        z = answer["t_hit"].numpy().astype(float)
        z[~np.isfinite(z)] = np.nan
        face = answer["primitive_ids"].numpy().astype(np.int64)
        face[~np.isfinite(z)] = 0
        normal = answer["primitive_normals"].numpy().astype(float) @ T[:3, :3]
        return z, normal, self.grey[face]


def read_case(folder: Path) -> ReadCase:
    sensor = json.loads((folder / "sensor.json").read_text(encoding="utf-8"))
    told = {one["effect"]: {k: v["value"] for k, v in one["parameters"].items()} for one in sensor["effects"]}
    return ReadCase(told, [_recording(path, told) for path in sorted(folder.glob("rec_*"))])


def _recording(folder: Path, told: Parameters) -> ReadRecording:
    camera, scene = (json.loads((folder / f"{name}.json").read_text(encoding="utf-8")) for name in ("camera", "scene"))
    mesh, poses = _mesh(folder / scene["mesh"]), _poses(folder / "groundtruth.txt")
    direction, frames = rays(camera), list[ReadFrame]()
    for time, name in _rows(folder / "depth.txt"):
        nearest = min(poses, key=lambda other: abs(other - float(time)))
        if abs(nearest - float(time)) > 1e-6:
            raise ValueError(f"{folder}: no pose at {time}")
        counts, T = _image(folder / name), poses[nearest]
        z = np.where((counts == 0) | (counts == 65535), np.nan, counts / camera["depth_scale"])
        lit = folder / "ir" / f"{time}.png"
        ir = _image(lit) if lit.exists() else None
        if frames and np.array_equal(frames[-1].T, T):
            expected, normal = frames[-1].expected, frames[-1].normal
        else:
            expected, normal, _ = mesh.cast(T, direction)
        frames.append(ReadFrame(T, z, expected, normal, ir))
    sigma = np.r_[[scene["poses"]["sigma_m"]] * 3, [scene["poses"]["sigma_rad"]] * 3]
    fill = told.get("mixed_pixels", {}).get("fill", 0)
    if fill:
        _over_areas(frames, mesh, camera, fill, told["illumination_vignetting"]["exponent"])
    return ReadRecording(folder.name, camera, sigma, direction, frames)


def rays(camera: dict[str, Any], du: float = 0.0, dv: float = 0.0) -> Array:
    """(h, w, 3) with z = 1 through pixels shifted by (du, dv)."""
    w, h = camera["width"], camera["height"]
    K = np.array([[camera["fx"], 0, camera["cx"]], [0, camera["fy"], camera["cy"]], [0, 0, 1.0]])
    distortion = np.array(camera["distortion"])
    u, v = np.meshgrid(np.arange(w, dtype=float), np.arange(h, dtype=float))
    pixels = np.stack([u + du, v + dv], -1).reshape(-1, 1, 2)
    flat = cv2.undistortPoints(pixels, K, distortion).reshape(-1, 2)
    for _ in range(60):  # OpenCV inverts coarsely and projects exactly
        points = np.c_[flat, np.ones(len(flat))].reshape(-1, 1, 3)
        again, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), K, distortion)
        flat = flat + (pixels.reshape(-1, 2) - again.reshape(-1, 2)) / [camera["fx"], camera["fy"]]
    return np.concatenate([flat, np.ones((len(flat), 1))], 1).reshape(h, w, 3)


def _over_areas(frames: Sequence[ReadFrame], mesh: Mesh, camera: dict[str, Any], fill: float, falloff: float) -> None:
    """Puts the mean range by light in place of that of the pixel's centre; NaN where a pixel spans a jump."""
    shifts = ((np.arange(RAYS) + 0.5) / RAYS - 0.5) * np.sqrt(fill)
    areas = [rays(camera, du, dv) for du in shifts for dv in shifts]
    middle = np.linalg.norm(rays(camera), axis=-1)
    last: ReadFrame | None = None
    for frame in frames:
        if last is not None and np.array_equal(last.T, frame.T):
            frame.expected = last.expected
            continue
        total, weights = np.zeros(middle.shape), np.zeros(middle.shape)
        low, high = np.full(middle.shape, np.inf), np.zeros(middle.shape)
        for direction in areas:
            z, normal, grey = mesh.cast(frame.T, direction)
            stretch = np.linalg.norm(direction, axis=-1)
            reach = z * stretch
            light = grey * np.abs((normal * direction).sum(-1)) / stretch / stretch**falloff / reach**2
            total, weights = total + light * reach, weights + light
            low, high = np.minimum(low, reach), np.maximum(high, reach)
        frame.expected = np.where(high - low < FLAT * low, total / weights / middle, np.nan)
        last = frame


def _mesh(file: Path) -> Mesh:
    read = o3d.io.read_triangle_mesh(file)
    scene = o3d.t.geometry.RaycastingScene(nthreads=2)
    scene.add_triangles(o3d.t.geometry.TriangleMesh.from_legacy(read))
    return Mesh(scene, np.asarray(read.vertex_colors)[:, 0][np.asarray(read.triangles)[:, 0]])


def _poses(file: Path) -> dict[float, Array]:
    out = {}
    for time, *numbers in _rows(file):
        T = np.eye(4)
        T[:3, 3] = np.array(numbers[:3], float)
        T[:3, :3] = Rotation.from_quat(np.array(numbers[3:], float)).as_matrix()
        out[float(time)] = T
    return out


def _rows(file: Path) -> list[list[str]]:
    lines = file.read_text(encoding="utf-8").splitlines()
    return [line.split() for line in lines if line.strip() and line[0] != "#"]


def _image(file: Path) -> Array:
    image = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise ValueError(f"{file}: no image")
    return image
