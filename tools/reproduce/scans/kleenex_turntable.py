"""Scans the real box on its turntable and measures what can be known without a reference.

    python -m tools.reproduce.scans.kleenex_turntable          no option: the scan corrects the nominal camera by itself
    python -m tools.reproduce.scans.kleenex_turntable --no-refine           the camera as stated
    python -m tools.reproduce.scans.kleenex_turntable --picture box.png     and a picture of the mesh

The box has four flat sides at right angles, opposite ones parallel; the turn of every frame is known from stickers in
the colour images (kleenex_markers.py), of which the scan uses nothing. Sides are told apart by the direction of their
normals about the axis, at heights of 15 to 95 mm above the plate (clear of plate and rounded top).
"""

import argparse
import json
import os
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.errors import FusionError
from fusion.mesh.comparison.surface_samples import face_areas, face_normals
from fusion.mesh.mesh import Mesh
from fusion.recording.open import open_recording
from fusion.scan.pipeline import scan_turntable
from fusion.scan.settings import ScanSettings
from tools.reproduce.scans.kleenex_markers import find_stickers, fit, load

Array = NDArray[np.float64]
HEIGHTS = (0.015, 0.095)  # [m] above the plate
UPRIGHT = 0.25  # largest vertical part of a side's normal
WITHIN = np.deg2rad(20)  # of a normal about the side's direction
FAR = 0.004  # [m] surface farther off the plane is a second wall


class Side(NamedTuple):
    """One side of the box: plane, area that belongs to it, share of its area kept by the fit and near its plane."""

    normal: Array
    centre: Array
    rms: float
    kept: float
    far: float
    points: Array


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=Path(os.environ.get("FUSION_SHARED", "../shared")))
    parser.add_argument("--no-refine", action="store_true", help="use the camera as stated")
    parser.add_argument("--picture", type=Path, help="draw the mesh and the planes")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    try:
        found, mesh, sides = measure(options.shared / "data" / "kleenex_turntable", not options.no_refine)
        if options.picture:
            draw(mesh, sides, options.picture)
    except FusionError as error:
        raise SystemExit(f"error: {error}") from None
    print(json.dumps(found) if options.json else "\n".join(f"{key:27} {value}" for key, value in found.items()))


def measure(folder: Path, refine: bool) -> tuple[dict[str, Any], Mesh, list[Side]]:
    """All figures, the mesh and its four sides."""
    images, camera = load(folder)
    stickers = fit(find_stickers(images), camera)["x"][13:]
    recording = open_recording(folder)
    begin = time.monotonic()
    scan = scan_turntable(recording, ScanSettings(refine_camera=None if refine else False))
    seconds = time.monotonic() - begin
    angles = scan.motion.angles
    step = np.degrees(np.diff(angles[np.isfinite(angles)]))
    found = {
        "seconds": round(seconds, 1),
        "frames": len(recording),
        "frames_used": int(scan.trajectory.valid.sum()),
        "mean_step_deg": float(step.mean()),
        "step_std_deg": float(step.std(ddof=1)),
        "total_deg": float(np.degrees(np.nanmax(angles) - np.nanmin(angles))),
        **against(angles, stickers),
        "fx_px": scan.camera.fx,
        "focal_length_check": scan.evidence.focal.relative,
        "warnings": list(scan.judgement.warnings),
    }
    sides = find_sides(scan.mesh)
    return found | box_figures(scan.mesh, sides), scan.mesh, sides


def against(angles: Array, stickers: Array) -> dict[str, float]:
    """Differences from the stickers' angles (n,) [rad], up to the constant that makes the largest smallest."""
    known = np.isfinite(angles)
    sign = np.sign(angles[known][-1] * stickers[known][-1])
    off = np.degrees(angles[known] - sign * stickers[known])
    off -= (off.max() + off.min()) / 2
    return {"off_stickers_max_deg": float(np.abs(off).max()), "off_stickers_rms_deg": float(off.std())}


def find_sides(mesh: Mesh) -> list[Side]:
    """The four sides in the order of their directions about the axis.

    Raises:
        FusionError: no upright surface, or too little on one side.
    """
    centre, normal, area = mesh.vertices[mesh.faces].mean(axis=1), face_normals(mesh), face_areas(mesh)
    low, high = HEIGHTS
    take = (np.abs(normal[:, 2]) < UPRIGHT) & (centre[:, 2] > low) & (centre[:, 2] < high) & (area > 0)
    centre, normal, area = centre[take], normal[take], area[take]
    azimuth = np.arctan2(normal[:, 1], normal[:, 0])
    # the direction in which all four quarters together have most surface
    count, borders = np.histogram(azimuth % (np.pi / 2), 36, (0, np.pi / 2), weights=area)
    if not count.any():
        raise FusionError("the mesh has no upright side", found=f"{len(mesh.faces)} triangles", expected="a box")
    first = borders[int(np.argmax(count))] + np.pi / 144
    sides = []
    for quarter in range(4):
        direction = first + quarter * np.pi / 2
        near = np.abs((azimuth - direction + np.pi) % (2 * np.pi) - np.pi) < WITHIN
        if near.sum() < 100:
            raise FusionError("a side of the box is missing", found=f"{near.sum()} triangles", expected="100 or more")
        outwards = np.array([np.cos(direction), np.sin(direction), 0])
        sides.append(_side(centre[near], area[near], outwards))
    return sides


def _side(points: Array, area: Array, outwards: Array) -> Side:
    """Plane by least squares over area, without what lies off it by more than 4 mm or three standard deviations."""
    kept = np.ones(len(points), bool)
    for _ in range(10):
        weight = area[kept] / area[kept].sum()
        middle = weight @ points[kept]
        arm = points[kept] - middle
        normal = np.linalg.eigh((arm * weight[:, None]).T @ arm)[1][:, 0]
        normal *= np.sign(normal @ outwards)
        off = (points - middle) @ normal
        spread = float(np.sqrt(weight @ off[kept] ** 2))
        kept = np.abs(off) < max(FAR, 3 * spread)
    # the side's own extent, so that a rounded edge beyond it is no second wall
    across = np.cross([0.0, 0.0, 1.0], normal)
    along = (points - middle) @ across
    left, right = np.percentile(along[kept], [2, 98])
    inside = (along > left) & (along < right)
    far = float(area[inside & (np.abs(off) > FAR)].sum() / area[inside].sum())
    rms = float(np.sqrt((area[kept] @ off[kept] ** 2) / area[kept].sum()))
    return Side(normal, middle, rms, float(area[kept].sum() / area.sum()), far, points)


def box_figures(mesh: Mesh, sides: list[Side]) -> dict[str, Any]:
    """What the four planes say, and what else is in the mesh."""
    import trimesh

    def degrees(a: Array, b: Array) -> float:
        return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))

    body = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    return {
        "plane_rms_mm": [round(s.rms * 1e3, 2) for s in sides],
        "plane_area_kept": [round(s.kept, 3) for s in sides],
        "area_off_the_plane": [round(s.far, 4) for s in sides],
        "neighbours_deg": [round(degrees(sides[k].normal, sides[(k + 1) % 4].normal), 2) for k in range(4)],
        "opposite_deg": [round(degrees(sides[k].normal, -sides[k + 2].normal), 2) for k in range(2)],
        "tilt_deg": [round(float(np.degrees(np.arcsin(s.normal[2]))), 2) for s in sides],
        "widths_mm": [
            round(float((sides[k].centre - sides[k + 2].centre) @ (sides[k].normal - sides[k + 2].normal)) * 500, 1)
            for k in range(2)
        ],
        "size_mm": np.round(np.ptp(mesh.vertices, axis=0) * 1e3, 1).tolist(),
        "parts": int(body.body_count),
        "triangles": len(mesh.faces),
    }


def draw(mesh: Mesh, sides: list[Side], path: Path) -> None:
    """From above with the planes, and two views from the side, colour as scanned."""
    import matplotlib.pyplot as plt

    few = np.random.default_rng(0).permutation(len(mesh.vertices))[:40_000]
    points = mesh.vertices[few] * 1e3
    color = "0.5" if mesh.colors is None else mesh.colors[few] / 255
    figure, panels = plt.subplots(1, 3, figsize=(15, 5), layout="constrained")
    low, high = np.array(HEIGHTS) * 1e3
    level = (points[:, 2] > low) & (points[:, 2] < high)
    panels[0].scatter(points[level, 0], points[level, 1], s=0.5, c="0.4")
    for side in sides:
        across = np.cross([0.0, 0.0, 1.0], side.normal)[:2] * 75
        line = side.centre[:2] * 1e3 + np.outer([-1, 1], across)
        panels[0].plot(*line.T, lw=0.8, label=f"rms {side.rms * 1e3:.2f} mm")
    panels[0].legend(fontsize="small", loc="center")
    panels[0].set(title=f"walls between {low:.0f} and {high:.0f} mm, from above", xlabel="x [mm]", ylabel="y [mm]")
    for panel, (a, b, sign) in zip(panels[1:], ((1, 0, 1), (0, 1, -1)), strict=True):
        order = np.argsort(sign * points[:, b])  # the nearest is drawn last
        shown = color if isinstance(color, str) else color[order]
        panel.scatter(points[order, a], points[order, 2], s=1, c=shown)
        panel.set(title=f"from {'+' if sign > 0 else '-'}{'xy'[b]}", xlabel=f"{'xy'[a]} [mm]", ylabel="z [mm]")
    for panel in panels:
        panel.set_aspect("equal")
    try:
        figure.savefig(path, dpi=120)
    except OSError as error:
        raise FusionError("the picture could not be written", path, error, do="state a file in a folder") from error
    plt.close(figure)


if __name__ == "__main__":
    main()
