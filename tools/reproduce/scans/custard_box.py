"""Scans the printed box that was turned by hand before a wall, and measures what its own faces say.

    python -m tools.reproduce.scans.custard_box               no hint at all
    python -m tools.reproduce.scans.custard_box --no-color    by shape alone
    python -m tools.reproduce.scans.custard_box --picture box.png

The turn of every frame is known from planes fitted to the upright faces of the box in that frame alone, in a crop that
is stated here and of which the scan uses nothing: one face or two are seen, a quarter of a turn apart, so the turn is
known up to quarters, and steps are below 45 degrees. Filters of the camera bend faces that are seen together by 2 to 4
degrees, so a single frame's turn is known to about 1.5 degrees.
"""

import argparse
import json
import os
import time
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.errors import FusionError
from fusion.mesh.mesh import Mesh
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording
from fusion.scan.pipeline import scan_turntable
from fusion.scan.settings import ScanSettings
from tools.reproduce.scans.kleenex_turntable import box_figures, draw, find_sides

Array = NDArray[np.float64]
COLUMNS, FARTHEST, HEIGHTS = (200, 470), 0.48, (0.02, 0.18)  # [px], [m], [m] above the table: the box in all frames
TABLE = np.s_[440:480, 480:640]  # pixels that show nothing but the table where they are nearer than the wall
NEAR = 0.002  # [m] off a face
LEAST_SHARE = 0.12  # of a frame's points on a face
BOX = (66.0, 112.0)  # [mm] its sides as the widest of them show in single frames
REACH = {"total_deg": (-369.0, 4.0), "off_faces_max_deg": 3.0, "plane_rms_mm": 1.5, "neighbours_deg": (90.0, 1.5)}


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=Path(os.environ.get("FUSION_SHARED", "../shared")))
    parser.add_argument("--no-color", action="store_true", help="by shape alone")
    parser.add_argument("--picture", type=Path, help="draw the mesh and the planes")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    try:
        recording = open_recording(options.shared / "data" / "custard_box")
        begin = time.monotonic()
        scan = scan_turntable(recording, ScanSettings(color=not options.no_color))
        seconds = time.monotonic() - begin
        sides = find_sides(scan.mesh)
        found = figures(scan.motion.angles, face_turns(recording), scan.mesh) | box_figures(scan.mesh, sides)
        if options.picture:
            draw(scan.mesh, sides, options.picture)
    except FusionError as error:
        raise SystemExit(f"error: {error}") from None
    found |= {"seconds": round(seconds, 1), "warnings": list(scan.judgement.warnings), "reached": reached(found)}
    print(json.dumps(found) if options.json else "\n".join(f"{key:22} {value}" for key, value in found.items()))


def figures(angles: Array, faces: Array, mesh: Mesh) -> dict[str, Any]:
    """What the angles (n,) [rad] are beside those of the faces (n,) [rad], up to a constant."""
    known = np.isfinite(angles)
    sign = np.sign(np.nansum(np.diff(angles[known]))) * np.sign(faces[-1] - faces[0])
    off = np.degrees(sign * angles - faces)
    off -= (np.nanmax(off) + np.nanmin(off)) / 2
    return {
        "frames_used": f"{int(known.sum())} of {len(angles)}",
        "total_deg": float(np.degrees(sign * (angles[known][-1] - angles[known][0]))),
        "total_by_faces_deg": float(np.degrees(faces[known][-1] - faces[known][0])),
        "steps_deg": np.round(np.degrees(sign * np.diff(angles)), 1).tolist(),
        "steps_by_faces_deg": np.round(np.degrees(np.diff(faces)), 1).tolist(),
        "off_faces_max_deg": float(np.nanmax(np.abs(off))),
        "off_faces_rms_deg": float(np.nanstd(off)),
        "vertices": len(mesh.vertices),
    }


def reached(found: dict[str, Any]) -> dict[str, bool]:
    """Which of the asked figures hold."""
    total, corners = REACH["total_deg"], REACH["neighbours_deg"]
    assert isinstance(total, tuple) and isinstance(corners, tuple)
    return {
        "total": abs(found["total_deg"] - total[0]) <= total[1],
        "every frame": found["off_faces_max_deg"] <= REACH["off_faces_max_deg"],
        "sides": max(found["plane_rms_mm"]) <= REACH["plane_rms_mm"] and max(found["area_off_the_plane"]) < 0.02,
        "corners": max(abs(a - corners[0]) for a in found["neighbours_deg"]) <= corners[1],
        "the box alone": all(abs(w - own) < 8 for w, own in zip(sorted(found["widths_mm"]), BOX, strict=True)),
    }


def face_turns(recording: Recording) -> Array:
    """The turn of every frame (n,) [rad] by its faces alone, 0 at the first; right-handed about the upward normal."""
    points = np.stack([recording.camera.points(frame.depth) for frame in recording]).astype(float)
    table = points[:, *TABLE].reshape(-1, 3)
    table = table[(table[:, 2] < 0.5) & np.isfinite(table[:, 2])][::50]
    foot = np.median(table, axis=0)
    for _ in range(5):
        up = np.linalg.svd(table - foot, full_matrices=False)[2][2]
        table = table[np.abs((table - foot) @ up) < 3 * NEAR]
        foot = table.mean(axis=0)
    up *= -np.sign(up[1])
    across = np.cross(up, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    flat = np.stack([across, np.cross(up, across)], axis=1)
    turns = [_turn((frame - foot) @ flat, _on_box(frame, foot, up)) for frame in points]
    return np.asarray(np.unwrap(np.array(turns) - turns[0], period=np.pi / 2))


def _on_box(frame: Array, foot: Array, up: Array) -> NDArray[np.bool_]:
    height, columns = (frame - foot) @ up, np.arange(frame.shape[1])
    with np.errstate(invalid="ignore"):
        inside = (frame[..., 2] < FARTHEST) & (height > HEIGHTS[0]) & (height < HEIGHTS[1])
    inside &= (columns > COLUMNS[0]) & (columns < COLUMNS[1])
    return np.asarray(cv2.erode(inside.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0)


def _turn(flat: Array, inside: NDArray[np.bool_]) -> float:
    """Direction of the face normals [rad], modulo quarters: of one face, or of two by their numbers of points."""
    left = flat[inside]
    random, total, counts = np.random.default_rng(0), 0j, len(left)
    for _ in range(2):
        if len(left) <= LEAST_SHARE * counts:
            break
        best = np.zeros(len(left), bool)
        for _ in range(200):
            a, b = left[random.integers(len(left), size=2)]
            if (length := float(np.hypot(*(b - a)))) > 0.01:
                on = np.abs((left - a) @ [a[1] - b[1], b[0] - a[0]]) < NEAR * length
                best = on if on.sum() > best.sum() else best
        if best.sum() < LEAST_SHARE * counts:
            break
        for _ in range(5):
            middle = left[best].mean(axis=0)
            normal = np.linalg.eigh(np.cov((left[best] - middle).T))[1][:, 0]
            best = np.abs((left - middle) @ normal) < NEAR
        total += best.sum() * np.exp(4j * np.arctan2(normal[1], normal[0]))  # quarters fall together
        left = left[np.abs((left - middle) @ normal) > 2 * NEAR]
    return float(np.angle(total)) / 4


if __name__ == "__main__":
    main()
