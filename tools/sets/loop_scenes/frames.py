"""A recording as the judge reads it: files, stamps and a pinhole."""

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.sets.loop_scenes.place.prints import Array

FR1 = {"fx": 517.3, "fy": 516.5, "cx": 318.6, "cy": 255.3, "depth_scale": 5000}  # as the TUM benchmark states it


@dataclass(frozen=True)
class Frames:
    """Stamps (n,) [s], depth files, camera matrix (3, 3) [px], counts per metre."""

    times: Array
    files: tuple[Path, ...]
    K: Array
    scale: float

    def counts(self, k: int) -> NDArray[np.uint16]:
        """(h, w) as the file holds them."""
        image = cv2.imread(str(self.files[k]), cv2.IMREAD_UNCHANGED)
        if image is None:
            raise OSError(f"{self.files[k]}: no picture")
        return np.asarray(image, np.uint16)

    def with_depth(self) -> NDArray[np.bool_]:
        """(n,) frames in which anything is seen."""
        return np.array([bool(self.counts(k).any()) for k in range(len(self.files))])

    def points(self, k: int) -> Array:
        """(n, 3) [m] of a frame, in its camera; some of them."""
        z = self.counts(k)[::8, ::8] / self.scale
        v, u = (8 * i for i in np.mgrid[: z.shape[0], : z.shape[1]])
        seen = z > 0
        x, y = (u - self.K[0, 2]) / self.K[0, 0], (v - self.K[1, 2]) / self.K[1, 1]
        return np.stack([x[seen] * z[seen], y[seen] * z[seen], z[seen]], axis=1)


def read(folder: Path) -> Frames:
    """A recording's folder; without camera.json it is TUM's first Kinect."""
    camera = dict(FR1)
    if (folder / "camera.json").is_file():
        camera = json.loads((folder / "camera.json").read_text(encoding="utf-8"))
    K = np.array([[camera["fx"], 0, camera["cx"]], [0, camera["fy"], camera["cy"]], [0, 0, 1]], float)
    lines = [line.split() for line in (folder / "depth.txt").read_text(encoding="utf-8").splitlines()]
    lines = [line for line in lines if line and not line[0].startswith("#")]
    times = np.array([line[0] for line in lines], float)
    return Frames(times, tuple(folder / line[1] for line in lines), K, float(camera["depth_scale"]))
