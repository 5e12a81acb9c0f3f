"""Scans the open turntable challenges and compares with their truth.

    python tools/turntable_challenge.py                    both cases, true camera
    python tools/turntable_challenge.py --camera nominal --refine-camera

Per case: time, angle errors against the true angles up to one constant, the slip, the focal length the scan asks for,
and the distances of the mesh to the true object, beside those of a mesh that the same volume makes of the same depth
with the TRUE poses. The truth is read here only, never by the code under test.
"""

import argparse
import json
import os
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.mesh.files import read_mesh
from fusion.mesh.mesh import Mesh
from fusion.recording.camera_file import camera_from_dict, camera_to_dict
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording
from fusion.recording.trajectory_file import read_trajectory
from fusion.scan.pipeline import mesh_at, scan_turntable
from fusion.scan.settings import ScanSettings
from fusion.sensor.file import read_sensor

CASES = ("turntable_v1_statue", "turntable_v2_bricks")


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=Path(os.environ.get("FUSION_SHARED", "../shared")))
    parser.add_argument("--case", choices=CASES, action="append", help="default: both")
    parser.add_argument("--camera", choices=("true", "nominal"), default="true")
    parser.add_argument("--refine-camera", action="store_true")
    parser.add_argument("--unknown-angles", action="store_true", help="do not use the table's log")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    results = [measure(options.shared / "challenges", case, options) for case in options.case or CASES]
    if options.json:
        print(json.dumps(results, indent=1))
        return
    for result in results:
        print("\n".join(f"{name:<28} {value}" for name, value in result.items()), end="\n\n")


def measure(challenges: Path, case: str, options: argparse.Namespace) -> dict[str, Any]:
    """All figures of one case."""
    truth_folder = challenges / "turntable_truth" / case
    truth = json.loads((truth_folder / "truth.json").read_text())
    recording = open_recording(challenges / "turntable" / case / "scan")
    if options.camera == "true":
        recording = _with_camera(recording, truth["camera"])
    settings = ScanSettings(
        sensor=read_sensor(challenges / "turntable" / case / "sensor.json"),
        refine_camera=options.refine_camera,
        use_log=not options.unknown_angles,
    )
    begin = time.monotonic()
    scan = scan_turntable(recording, settings)
    seconds = time.monotonic() - begin
    T_table_camera = read_trajectory(truth_folder / "poses.txt").poses
    T_table_object = T_table_camera[0] @ pose.inverse(scan.trajectory.poses[0])
    posed = mesh_at(recording, settings, scan, pose.inverse(T_table_object) @ T_table_camera)
    reference = read_mesh(truth_folder / "truth.ply")
    ours = _distances(scan.mesh, reference, T_table_object)
    with_truth = _distances(posed, reference, T_table_object)
    error = angle_errors(scan.motion.angles, np.array(truth["angles_rad"]))
    fx = float(recording.camera.fx * np.exp(0 if options.refine_camera else scan.motion.focal_check.values[0]))
    fx = scan.camera.fx if options.refine_camera else fx
    return {
        "case": f"{case}, {options.camera} camera{', refined' if options.refine_camera else ''}",
        "seconds": round(seconds, 1),
        "frames placed": f"{int(scan.trajectory.valid.sum())} of {len(recording)}",
        "angle error largest / rms": f"{np.nanmax(np.abs(error)):.3f} / {np.nanstd(error):.3f} deg",
        "slip true": f"frame {truth['slip']['frame']}, {np.rad2deg(truth['slip']['angle_rad']):+.2f} deg",
        "slip found": ", ".join(f"frame {s.frame}, {np.rad2deg(s.angle):+.2f} deg" for s in scan.steps.slips) or "none",
        "fx used, asked for, true": f"{recording.camera.fx:.2f}, {fx:.2f} ({fx / truth['camera']['fx'] - 1:+.2%}), "
        f"{truth['camera']['fx']:.2f} px",
        "distance std": f"{ours['std'] * 1e3:.3f} mm; with true poses {with_truth['std'] * 1e3:.3f} mm; "
        f"ratio {ours['std'] / with_truth['std']:.3f}",
        "distances": _line(ours),
        "distances, true poses": _line(with_truth),
        "closing gap": f"{_gap(scan.closure_raw)} before, {_gap(scan.closure)} after",
    }


def _with_camera(recording: Recording, fields: dict[str, Any]) -> Recording:
    from dataclasses import replace

    known = camera_to_dict(recording.camera)
    camera: Camera = camera_from_dict(known | fields, "truth.json")
    return replace(open_recording(recording.path, camera), camera=camera)


def angle_errors(angles: NDArray[np.float64], true: NDArray[np.float64]) -> NDArray[np.float64]:
    """Errors (n,) [deg] up to the one constant that makes the largest smallest."""
    known = angles[np.isfinite(angles)]
    # the truth is told in the table's frame, whose axis may point the other way
    true = np.sign(known[-1]) * np.abs(true - true[0])
    error = np.rad2deg(angles - true)
    return error - (np.nanmax(error) + np.nanmin(error)) / 2


def _distances(mesh: Mesh, reference: Mesh, T_reference_mesh: NDArray[np.float64]) -> dict[str, float]:
    """Signed distances after a rigid alignment that starts from the known pose."""
    import open3d as o3d

    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(reference.vertices.astype(np.float32)),
        o3d.core.Tensor.from_numpy(reference.faces.astype(np.uint32)),
    )
    few = np.random.default_rng(0).permutation(len(mesh.vertices))[:60_000]
    points = pose.transform(T_reference_mesh, mesh.vertices[few])
    for reach in [0.02] * 10 + [0.01] * 15:  # point to plane, each point to its nearest triangle
        answer = scene.compute_closest_points(o3d.core.Tensor.from_numpy(points.astype(np.float32)))
        nearest = answer["points"].numpy().astype(float)
        normal = answer["primitive_normals"].numpy().astype(float)
        near = np.linalg.norm(points - nearest, axis=1) < reach
        p, n = points[near], normal[near]
        J = np.hstack([np.cross(p, n), n])
        residual = np.einsum("ij,ij->i", n, p - nearest[near])
        points = pose.transform(pose.exp(np.linalg.lstsq(J, -residual, rcond=None)[0]), points)
    d = scene.compute_signed_distance(o3d.core.Tensor.from_numpy(points.astype(np.float32))).numpy().astype(float)
    shares = {f"within {t} mm": float((np.abs(d) < t / 1e3).mean()) for t in (1, 2, 5)}
    return {"mean": float(d.mean()), "std": float(d.std()), "rms": float(np.sqrt((d**2).mean())), **shares}


def _line(numbers: dict[str, float]) -> str:
    lengths = ", ".join(f"{k} {v * 1e3:.3f} mm" for k, v in numbers.items() if not k.startswith("within"))
    return lengths + ", " + ", ".join(f"{k} {v:.1%}" for k, v in numbers.items() if k.startswith("within"))


def _gap(gap: tuple[float, float] | None) -> str:
    return "unknown" if gap is None else f"{gap[1] * 1e3:.2f} mm, {np.rad2deg(gap[0]):.2f} deg"


if __name__ == "__main__":
    main()
