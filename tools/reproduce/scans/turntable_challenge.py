"""Scans the open turntable challenges and compares with their truth.

    python -m tools.reproduce.scans.turntable_challenge    all cases, true camera
    python -m tools.reproduce.scans.turntable_challenge --camera nominal --refine-camera
    python -m tools.reproduce.scans.turntable_challenge --poses true --voxel 0.003 --correction true
    python -m tools.reproduce.scans.turntable_challenge --camera CALIBRATED.json --correction SENSOR.json

Correction: `raw` is the case's noise model alone; `true` undoes what truth.json holds; a file is a calibrated one.
With `--poses true` nothing is tracked: the figures are those of depth and volume alone.

Per case: time, angle errors against the true angles up to one constant, the slip, the focal length the scan asks for,
and the distances of the mesh to the true object, beside those of a mesh that the same volume makes of the same depth
with the TRUE poses. The truth is read here only, never by the code under test.
"""

import argparse
import json
import os
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.mesh.cleanup import large_parts
from fusion.mesh.files import read_mesh
from fusion.mesh.mesh import Mesh
from fusion.recording.images.masks import open_masks
from fusion.recording.native.camera_file import camera_content, camera_of, camera_to_dict
from fusion.recording.native.trajectory_file import read_trajectory
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording
from fusion.results.facts import Gap
from fusion.scan.cleaning.clean import clean
from fusion.scan.cleaning.off_plate import clear_of_rounding, fitted_plate, off_plate
from fusion.scan.finding.frames import load
from fusion.scan.finding.object import choose_volume
from fusion.scan.finding.relieved import relieved
from fusion.scan.pipeline import scan_turntable
from fusion.scan.result import Scan
from fusion.scan.settings import ScanSettings
from fusion.sensor.correction.corrected_recording import corrected_recording
from fusion.sensor.files.sensor_file import read_sensor
from fusion.sensor.presets import default_sensor
from fusion.sensor.sensor import Sensor
from fusion.turntable.views import Region
from fusion.volume.forecast import choose_truncation
from fusion.volume.prepared import fuse, fused, prepare
from fusion.volume.volume import Volume, VolumeSettings
from tools.reproduce.scans.challenge_truth import true_sensor

CASES = ("turntable_v1_statue", "turntable_v2_bricks", "turntable_v2_statue")


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=Path(os.environ.get("FUSION_SHARED", "../shared")))
    parser.add_argument("--case", choices=CASES, action="append", help="default: all")
    parser.add_argument("--camera", default="true", help="true, nominal, or a camera.json")
    parser.add_argument("--correction", default="raw", help="raw, true, or a sensor.json")
    parser.add_argument("--poses", choices=("own", "true"), default="own")
    parser.add_argument("--voxel", type=float, help="[m]; default: as the scan chooses")
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
    stated = open_recording(challenges / "turntable" / case / "scan")
    recording = stated
    if options.camera == "true":
        recording = _with_camera(recording, truth["camera"])
    elif options.camera != "nominal":
        recording = open_recording(recording.path, options.camera)
    sensor = read_sensor(challenges / "turntable" / case / "sensor.json")
    if options.correction == "true":
        sensor = true_sensor(sensor, truth, stated.camera, recording.camera)
    elif options.correction != "raw":
        sensor = read_sensor(options.correction)
    begin = time.monotonic()
    found = (with_true_poses if options.poses == "true" else with_own_poses)(
        (recording, sensor), (truth_folder, truth), options
    )
    case = f"{case}, camera {options.camera}{', refined' if options.refine_camera else ''}"
    return {"case": f"{case}, correction {options.correction}", "seconds": round(time.monotonic() - begin, 1)} | found


def with_true_poses(
    given: tuple[Recording, Sensor], truth: tuple[Path, dict[str, Any]], options: argparse.Namespace
) -> dict[str, Any]:
    """Depth and volume alone: every frame integrated where it truly was taken."""
    recording, told = corrected_recording(*given)
    poses = read_trajectory(truth[0] / "poses.txt").poses
    reference = read_mesh(truth[0] / "truth.ply")
    low, high = reference.vertices.min(axis=0) - 0.03, reference.vertices.max(axis=0) + 0.03
    frames = [prepare(frame, recording.camera, given[1]) for frame in recording]
    voxel = options.voxel or 0.003
    sigma = float(np.nanmedian(frames[0].surface.sigma))
    volume = Volume(VolumeSettings(voxel, choose_truncation(voxel, sigma), False, (tuple(low), tuple(high))))
    for frame, T in zip(frames, poses, strict=True):
        fuse(volume, frame, T)
    mesh = volume.surface()
    plate = fitted_plate(mesh, voxel, float(np.ptp(reference.vertices, axis=0).max()) / 2)
    mesh, _ = large_parts(off_plate(mesh, clear_of_rounding(mesh, plate, voxel))[0], 1.0)
    return {
        "corrected": told.line,
        "left": "; ".join((*told.left, *told.doubtful)),
        "truncation": f"{volume.settings.truncation * 1e3:.1f} mm",
        "distances, true poses": _line(_distances(mesh, truth[0], np.eye(4))),
    }


def _mesh_at(recording: Recording, settings: ScanSettings, scan: Scan, T_object_camera: Array) -> Mesh:
    """The object from the same frames and volume as a scan, but with other poses (n, 4, 4) in its object frame."""
    sensor = settings.sensor or default_sensor(recording.camera)
    recording = replace(corrected_recording(recording, sensor)[0], camera=scan.camera)
    region = Region(np.array(scan.settings.region.low), np.array(scan.settings.region.high))
    masks = None if settings.mask is None else open_masks(settings.mask, recording)
    frames = relieved(load(recording, sensor, region, masks)[0], scan.motion.taken_out)
    volume = fused(choose_volume(settings, scan.camera, frames, region, scan.motion), frames, T_object_camera)
    return clean(volume.surface(), settings, scan.motion, volume.settings.voxel).mesh


def with_own_poses(
    given: tuple[Recording, Sensor], truth_of: tuple[Path, dict[str, Any]], options: argparse.Namespace
) -> dict[str, Any]:
    """The whole scan, and the same frames with the true poses."""
    (recording, sensor), (truth_folder, truth) = given, truth_of
    settings = ScanSettings(
        sensor=sensor,
        refine_camera=options.refine_camera,
        use_log=not options.unknown_angles,
        voxel=options.voxel,
    )
    scan = scan_turntable(recording, settings)
    T_table_camera = read_trajectory(truth_folder / "poses.txt").poses
    T_table_object = T_table_camera[0] @ pose.inverse(scan.trajectory.poses[0])
    posed = _mesh_at(recording, settings, scan, pose.inverse(T_table_object) @ T_table_camera)
    ours = _distances(scan.mesh, truth_folder, T_table_object)
    with_truth = _distances(posed, truth_folder, T_table_object)
    error = angle_errors(scan.motion.angles, np.array(truth["angles_rad"]))
    fx = float(recording.camera.fx * np.exp(0 if options.refine_camera else scan.motion.focal_check.values[0]))
    fx = scan.camera.fx if options.refine_camera else fx
    return {
        "corrected": scan.settings.correction.text,
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
    known = camera_to_dict(recording.camera)
    camera: Camera = camera_of(camera_content(known | fields, "truth.json"))
    return replace(open_recording(recording.path, camera), camera=camera)


def angle_errors(angles: NDArray[np.float64], true: NDArray[np.float64]) -> NDArray[np.float64]:
    """Errors (n,) [deg] up to the one constant that makes the largest smallest."""
    known = angles[np.isfinite(angles)]
    # the truth is told in the table's frame, whose axis may point the other way
    true = np.sign(known[-1]) * np.abs(true - true[0])
    error = np.rad2deg(angles - true)
    return error - (np.nanmax(error) + np.nanmin(error)) / 2


def _distances(mesh: Mesh, truth_folder: Path, T_reference_mesh: NDArray[np.float64]) -> dict[str, float]:
    """Signed distances after a rigid alignment that starts from the known pose; scale that would fit best, coverage."""
    scene = _scene(read_mesh(truth_folder / "truth.ply"))
    few = np.random.default_rng(0).permutation(len(mesh.vertices))[:60_000]
    vertices = mesh.vertices[few].astype(float)
    T, points, scale = T_reference_mesh, pose.transform(T_reference_mesh, vertices), 1.0
    for step, reach in enumerate([0.02] * 10 + [0.01] * 25):  # point to plane, each point to its nearest triangle
        freed = step >= 25  # the scale joins
        answer = scene.compute_closest_points(_tensor(points))
        nearest, normal = (answer[k].numpy().astype(float) for k in ("points", "primitive_normals"))
        near = np.linalg.norm(points - nearest, axis=1) < reach
        p, n = points[near], normal[near]
        J = np.hstack([np.cross(p, n), n, np.einsum("ij,ij->i", n, p)[:, None]])[:, : 7 if freed else 6]
        residual = np.einsum("ij,ij->i", n, p - nearest[near])
        x = np.linalg.lstsq(J, -residual, rcond=None)[0]
        points = pose.transform(pose.exp(x[:6]), points)
        if freed:
            points, scale = points * (1 + x[6]), scale * (1 + x[6])
        else:
            T = pose.exp(x[:6]) @ T
    d = scene.compute_signed_distance(_tensor(pose.transform(T, vertices))).numpy().astype(float)
    numbers = {f"within {t} mm": float((np.abs(d) < t / 1e3).mean()) for t in (1, 2, 5)}
    visible = pose.transform(pose.inverse(T), np.load(truth_folder / "visible.npz")["points"].astype(float))
    missed = _scene(mesh).compute_distance(_tensor(visible)).numpy()
    numbers |= {f"seen within {t} mm": float((missed < t / 1e3).mean()) for t in (2, 5)}
    return numbers | {"mean": d.mean(), "std": d.std(), "rms": np.sqrt((d**2).mean()), "scale when freed": scale}


def _tensor(points: NDArray) -> Any:
    import open3d as o3d

    return o3d.core.Tensor.from_numpy(points.astype(np.float32))


def _scene(mesh: Mesh) -> Any:
    import open3d as o3d

    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(_tensor(mesh.vertices), o3d.core.Tensor.from_numpy(mesh.faces.astype(np.uint32)))
    return scene


def _line(numbers: dict[str, float]) -> str:
    lengths = ", ".join(f"{k} {numbers[k] * 1e3:.3f} mm" for k in ("mean", "std", "rms"))
    within = ", ".join(f"{k} {v:.1%}" for k, v in numbers.items() if "within" in k)
    return f"{lengths}, scale {numbers['scale when freed']:.4f}, {within}"


def _gap(gap: Gap | None) -> str:
    return "unknown" if gap is None else f"{gap.distance * 1e3:.2f} mm, {np.rad2deg(gap.angle):.2f} deg"


if __name__ == "__main__":
    main()
