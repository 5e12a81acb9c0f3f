"""A recording's folder, read into memory and written again: at the level of files, by numpy and OpenCV alone."""

import json
import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FULL = 65000.0  # counts that a 16-bit file is filled to; 65535 means missing
PLACES = 6  # decimals of a time stamp


@dataclass(frozen=True)
class Taken:
    """One recording.

    Attributes:
        times: (n,) [s] of the frames.
        depth: (n, h, w) planar z [m], NaN where missing.
        poses: (m, 8) rows of groundtruth.txt: time, place [m], quaternion with its scalar last.
        infrared: time and (h, w) counts of each image.
        log: lines of telemetry.csv, the header first.
        mesh: the file that scene.json names, as bytes.
    """

    name: str
    camera: dict[str, Any]
    scene: dict[str, Any]
    times: Array
    depth: Array
    poses: Array
    mesh: bytes
    infrared: list[tuple[float, Array]] = field(default_factory=list)
    log: list[str] = field(default_factory=list)

    def pose(self, frame: int) -> Array:
        """(4, 4) stated pose of a frame, camera to world: that of the nearest stamp."""
        row = self.poses[np.argmin(np.abs(self.poses[:, 0] - self.times[frame]))]
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = rotation_of(row[4:]), row[1:4]
        return T

    def rays(self) -> Array:
        """(h, w, 3) directions with z = 1 through the pixel centres, by the stated camera."""
        c = self.camera
        u, v = np.meshgrid(np.arange(c["width"], dtype=float), np.arange(c["height"], dtype=float))
        K = np.array([[c["fx"], 0, c["cx"]], [0, c["fy"], c["cy"]], [0, 0, 1.0]])
        pixels = np.stack([u, v], axis=-1).reshape(-1, 1, 2)
        flat = cv2.undistortPoints(pixels, K, np.array(c.get("distortion", [0.0] * 5), float))
        return np.concatenate([flat.reshape(*u.shape, 2), np.ones((*u.shape, 1))], axis=-1)


def rotation_of(q: Array) -> Array:
    """(3, 3) of a unit quaternion x, y, z, w."""
    x, y, z, w = q / np.linalg.norm(q)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + 2 * w * cross + 2 * cross @ cross)


def quaternion_of(R: Array) -> Array:
    """(4,) x, y, z, w: the eigenvector of the largest value of Bar-Itzhack's matrix, sound for every rotation."""
    K = np.empty((4, 4))
    K[:3, :3] = R + R.T - np.trace(R) * np.eye(3)
    K[:3, 3] = K[3, :3] = (R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1])
    K[3, 3] = np.trace(R)
    return np.asarray(np.linalg.eigh(K)[1][:, -1])


def read(folder: Path) -> Taken:
    """A folder in the native form."""
    camera, scene = (json.loads((folder / name).read_text(encoding="utf-8")) for name in ("camera.json", "scene.json"))
    stamps = _list(folder / "depth.txt")
    counts = np.array([_image(folder / name) for _, name in stamps], float)
    depth = np.where((counts > 0) & (counts < 65535), counts / camera["depth_scale"], np.nan)
    log = folder / "telemetry.csv"
    return Taken(
        name=folder.name, camera=camera, scene=scene, times=np.array([t for t, _ in stamps]), depth=depth,
        poses=np.atleast_2d(np.loadtxt(folder / "groundtruth.txt")), mesh=(folder / scene["mesh"]).read_bytes(),
        infrared=[(t, _image(folder / name)) for t, name in _list(folder / "ir.txt")],
        log=log.read_text(encoding="utf-8").splitlines() if log.is_file() else [],
    )  # fmt: skip


def write(taken: Taken, folder: Path) -> None:
    """The recording as a folder.

    Depth in whole counts stays in these counts. What was bent by parts of them is written as finely as 16 bits hold:
    rounded anew, it would be bent by other amounts. (Whole counts in a finer file would say that depth comes in steps.)
    """
    shutil.rmtree(folder, ignore_errors=True)
    for name in ("depth", "ir") if taken.infrared else ("depth",):
        (folder / name).mkdir(parents=True)
    scale = taken.camera["depth_scale"]
    if not np.allclose(taken.depth, counted(taken.depth, taken.camera), atol=1e-7, equal_nan=True):
        scale *= max(int(FULL / (np.nanmax(taken.depth) * scale)), 1)
    (folder / "camera.json").write_text(json.dumps({**taken.camera, "depth_scale": scale}), encoding="utf-8")
    (folder / "scene.json").write_text(json.dumps(taken.scene), encoding="utf-8")
    (folder / taken.scene["mesh"]).write_bytes(taken.mesh)
    _images(folder, "depth", [(t, z * scale) for t, z in zip(taken.times, taken.depth, strict=True)])
    if taken.infrared:
        _images(folder, "ir", taken.infrared)
    rows = [" ".join([f"{row[0]:.{PLACES}f}", *(f"{x:.8f}" for x in row[1:])]) for row in taken.poses]
    _text(folder / "groundtruth.txt", rows)
    if taken.log:
        _text(folder / "telemetry.csv", taken.log)


def counted(depth: Array, camera: dict[str, Any]) -> Array:
    """Depth [m] rounded to counts of the camera's files."""
    return np.asarray(np.round(depth * camera["depth_scale"]) / camera["depth_scale"])


def _images(folder: Path, kind: str, images: list[tuple[float, Array]]) -> None:
    names = [f"{kind}/{t:.{PLACES}f}.png" for t, _ in images]
    for name, (_, image) in zip(names, images, strict=True):
        counts = np.clip(np.round(np.nan_to_num(image)), 0, 65534).astype(np.uint16)
        cv2.imwrite(str(folder / name), counts)
    _text(folder / f"{kind}.txt", [f"{t:.{PLACES}f} {name}" for name, (t, _) in zip(names, images, strict=True)])


def _text(path: Path, lines: list[str]) -> None:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _list(path: Path) -> list[tuple[float, str]]:
    if not path.is_file():
        return []
    lines = (line.split() for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#"))
    return [(float(line[0]), line[1]) for line in lines if line]


def _image(path: Path) -> Array:
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise FileNotFoundError(path)
    return np.asarray(image, float)
