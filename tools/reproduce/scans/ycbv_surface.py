"""How far the fused surface of three real objects lies from their scanner meshes.

    python -m tools.reproduce.scans.ycbv_surface [--border 0] [--json]

Ten frames of YCB-Video sequence 0000 (Asus Xtion, essentially one view) are tracked and fused with default settings.
The fused points seen inside an object's label in the first frame, and no deeper than its depth there, are its observed
surface. They are aligned rigidly to the object's mesh from the annotated pose; printed are the distances that remain.
`--border` leaves out pixels beside a label's border, where object and background mix.
"""

import argparse
import json
import os
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import exp, inverse, pose, transform
from fusion.geometry.robust import robust_std, tukey
from fusion.mesh.comparison.distances import Surface, surface_of
from fusion.mesh.files import read_mesh
from fusion.reconstruction.pipeline import reconstruct
from fusion.reconstruction.result import Reconstruction
from fusion.reconstruction.settings import ReconstructSettings
from fusion.recording.open import open_recording

Array = NDArray[np.float64]
CLOSE = 0.003  # [m]
BEHIND = 0.02  # [m] fused surface this far from the depth of its pixel is hidden by the object, or hides it


@dataclass(frozen=True)
class Annotated:
    """An object in the first frame: its name, its pixels (h, w), its pose (4, 4) and its mesh."""

    name: str
    mask: NDArray[np.bool_]
    T_camera_object: Array
    surface: Surface


def shared() -> Path:
    """The folder with the real recordings."""
    return Path(os.environ.get("FUSION_SHARED") or Path(__file__).resolve().parents[3] / "../shared")


def annotated(folder: Path, border: int) -> list[Annotated]:
    """The objects of the first frame."""
    first = json.loads((folder / "poses.json").read_text())[0]
    label = cv2.imread(str(folder / f"label/{first['frame']}.png"), cv2.IMREAD_UNCHANGED)
    assert label is not None
    kernel = np.ones((2 * border + 1, 2 * border + 1), np.uint8)
    found = []
    for entry in first["objects"]:
        mask = cv2.erode((label == entry["class_id"]).astype(np.uint8), kernel) > 0
        T = np.vstack([entry["T_camera_object_3x4"], [0, 0, 0, 1]])
        mesh = read_mesh(folder / f"mesh/{entry['name']}.ply")
        found.append(Annotated(entry["name"], mask, T, surface_of(mesh)))
    return found


def observed(result: Reconstruction, camera: Camera, depth: NDArray[np.float32], thing: Annotated) -> Array:
    """Fused points (n, 3) of an object in the first camera's frame [m]."""
    points = transform(inverse(result.trajectory.poses[0]), result.mesh.vertices)
    points = points[points[:, 2] > 0.1]
    u, v = np.rint(camera.project(points)).astype(int).T
    inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    points, u, v = points[inside], u[inside], v[inside]
    seen = thing.mask[v, u] & (np.abs(points[:, 2] - depth[v, u]) < BEHIND)
    return points[seen]


def aligned(points: Array, thing: Annotated, passes: int = 30) -> Array:
    """The points (n, 3) moved rigidly onto the mesh (point to plane, Tukey), in the mesh's frame."""
    moved = transform(inverse(thing.T_camera_object), points)
    for _ in range(passes):
        closest = thing.surface.closest(moved)
        residual = np.einsum("ij,ij->i", moved - closest.points, closest.normals)
        scale = max(robust_std(residual), 1e-4)
        weight = tukey(residual / scale)
        centre = moved.mean(axis=0)
        J = np.hstack([np.cross(moved - centre, closest.normals), closest.normals])
        step = -np.linalg.solve((J * weight[:, None]).T @ J + 1e-9 * np.eye(6), J.T @ (weight * residual))
        shift = pose(np.eye(3), centre)
        moved = transform(shift @ exp(step) @ inverse(shift), moved)
        if np.abs(step).max() < 1e-6:
            break
    return moved


def run(folder: Path, border: int = 0) -> dict[str, dict[str, float]]:
    """Per object and for all: points, median absolute distance [m], share within 3 mm, before and after alignment."""
    recording = open_recording(folder)
    result = reconstruct(recording, ReconstructSettings(color=False))
    depth = recording[0].depth
    table, before_all, after_all = {}, [], []
    for thing in annotated(folder, border):
        points = observed(result, recording.camera, depth, thing)
        before = np.abs(thing.surface.closest(transform(inverse(thing.T_camera_object), points)).distances)
        after = np.abs(thing.surface.closest(aligned(points, thing)).distances)
        table[thing.name] = _numbers(before, after)
        before_all.append(before)
        after_all.append(after)
    table["all"] = _numbers(np.concatenate(before_all), np.concatenate(after_all))
    return table


def _numbers(before: Array, after: Array) -> dict[str, float]:
    return {
        "points": len(after),
        "median_m": float(np.median(after)),
        "within_3mm": float((after < CLOSE).mean()),
        "median_at_annotated_pose_m": float(np.median(before)),
        "within_3mm_at_annotated_pose": float((before < CLOSE).mean()),
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--border", type=int, default=0, help="pixels left out beside a label's border")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    table = run(shared() / "data/ycbv_0000", options.border)
    if options.json:
        print(json.dumps(table, indent=1))
    else:
        for name, row in table.items():
            print(
                f"{name:<16} {row['points']:6.0f} points, median {row['median_m'] * 1e3:.2f} mm, "
                f"{row['within_3mm']:.1%} within 3 mm (at the annotated pose "
                f"{row['median_at_annotated_pose_m'] * 1e3:.2f} mm, {row['within_3mm_at_annotated_pose']:.1%})"
            )
