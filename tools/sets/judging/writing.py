"""Writes recordings (TUM layout with a camera beside it) and trajectories."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


class Recording:
    """A recording that grows frame by frame; `done` writes the lists, camera and telemetry."""

    def __init__(self, folder: Path, camera: dict[str, Any]) -> None:
        self.folder, self.camera = folder, camera
        self.lists: dict[str, list[str]] = {}
        self.log: list[dict[str, float]] = []

    def depth(self, time: float, metres: Array) -> None:
        """(h, w) [m], 0 where there is none."""
        counts = np.clip(np.rint(np.nan_to_num(metres) * self.camera["depth_scale"]), 0, 65534)
        self._picture("depth", time, counts.astype(np.uint16), "png")

    def ir(self, time: float, counts: Array) -> None:
        self._picture("ir", time, np.clip(np.rint(counts), 0, 65535).astype(np.uint16), "png")

    def rgb(self, time: float, colours: NDArray[np.uint8]) -> None:
        """(h, w, 3), red first."""
        self._picture("rgb", time, np.ascontiguousarray(colours[..., ::-1]), "jpg")

    def done(self, **log: Array) -> None:
        """`log`: columns of telemetry.csv, one value per depth frame."""
        for kind, lines in self.lists.items():
            (self.folder / f"{kind}.txt").write_text("\n".join(["# timestamp filename", *lines, ""]), encoding="utf-8")
        (self.folder / "camera.json").write_text(json.dumps(self.camera, indent=1), encoding="utf-8")
        if log:
            times = [line.split()[0] for line in self.lists["depth"]]
            rows = [
                ",".join([time, *(f"{x:.4f}" for x in row)]) for time, *row in zip(times, *log.values(), strict=True)
            ]
            text = "\n".join([",".join(["timestamp", *log]), *rows, ""])
            (self.folder / "telemetry.csv").write_text(text, encoding="utf-8")

    def _picture(self, kind: str, time: float, image: NDArray[Any], ending: str) -> None:
        (self.folder / kind).mkdir(parents=True, exist_ok=True)
        name = f"{kind}/{time:.6f}.{ending}"
        if not cv2.imwrite(str(self.folder / name), image):
            raise OSError(f"{self.folder / name}: not written")
        self.lists.setdefault(kind, []).append(f"{time:.6f} {name}")


def trajectory(file: Path, times: NDArray[Any], poses: Array) -> None:
    """TUM trajectory of poses (n, 4, 4), camera to world."""
    lines = []
    for time, T in zip(times, poses, strict=True):
        numbers = [*T[:3, 3], *Rotation.from_matrix(T[:3, :3]).as_quat()]
        lines.append(" ".join([f"{time:.6f}", *(f"{x:.9f}" for x in numbers)]))
    file.write_text("\n".join([*lines, ""]), encoding="utf-8")


def plain(x: Any) -> Any:
    """Arrays as lists, rounded: for JSON."""
    return np.round(x, 9).tolist() if isinstance(x, np.ndarray) else x
