"""A made-up scan for the report's tests: a bumpy sphere on a turntable that slipped once."""

import numpy as np
import trimesh

from fusion.geometry.pose import about_axis
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.report.scans.scan import ScanReport
from fusion.results.table_motion import ClosingGap, SlipFound, TableMotion

# camera frame: y down, the axis stands 0.7 m in front and points up, leaning back a little
POINT, UP = np.array([0.0, 0.1, 0.7]), np.array([0.0, -0.94, -0.342])


def bumpy_sphere(subdivisions: int = 4, holed: bool = True) -> Mesh:
    """A sphere of 0.1 m with bumps, coloured by height, with a hole at its bottom and signed distances."""
    ball = trimesh.creation.icosphere(subdivisions, 0.1)
    v = np.array(ball.vertices)
    bump = 1 + 0.08 * np.sin(9 * v[:, 0] / 0.1) * np.sin(7 * v[:, 1] / 0.1) * np.cos(8 * v[:, 2] / 0.1)
    v = v * bump[:, None]
    faces = np.array(ball.faces)
    if holed:
        faces = faces[(v[faces] @ UP).mean(axis=1) > -0.075]
    share = np.clip((v @ UP + 0.1) / 0.2, 0, 1)[:, None]
    colors = (share * [230, 160, 40] + (1 - share) * [40, 90, 160]).astype(np.uint8)
    distance = 0.001 * np.sin(12 * v[:, 0] / 0.1) + 0.0004
    centre = POINT + 0.03 * UP
    return Mesh(v + centre, faces.astype(np.int32), None, colors, {"signed_distance": distance.astype(np.float32)})


def made_up_scan(frames: int = 25, seed: int = 3) -> ScanReport:
    """Everything a scan report can hold."""
    rng = np.random.default_rng(seed)
    steps = np.full(frames, 14.4) + rng.normal(0, 0.2, frames)
    steps[0] = 0
    if frames > 15:
        steps[15] = 9.0
    turned = np.radians(np.cumsum(steps))
    # the camera of frame i stands, in the object's frame, turned back by how far the object has turned
    poses = np.stack([about_axis(POINT, UP, -a) for a in turned])
    raw = poses.copy()
    for i, a in enumerate(turned):  # the plate rocks by 0.3 deg twice a turn
        raw[i] = raw[i] @ about_axis(POINT, [0.0, -0.342, 0.94], 0.005 * np.sin(2 * a))
    raw[:, :3, 3] += np.cumsum(rng.normal(0, 0.0015, (frames, 3)), axis=0)
    angles = turned.copy()
    residual, inliers = rng.uniform(0.0012, 0.002, frames), rng.uniform(0.85, 0.97, frames)
    rejected = {7: "too few inliers (12 %)", 19: "jump of 31 deg"} if frames > 19 else {}
    for frame in rejected:
        poses[frame] = raw[frame] = residual[frame] = np.nan
        inliers[frame], angles[frame] = 0.12, np.nan
    mesh = bumpy_sphere()
    centre = mesh.vertices.mean(axis=0)
    slips = (SlipFound(15, -0.094),) if frames > 15 else ()
    across = (np.zeros(3) - POINT) - ((np.zeros(3) - POINT) @ UP) * UP
    return ScanReport(
        mesh=mesh,
        title="Scan of a bumpy sphere",
        subtitle="25 frames, made up",
        trajectory_raw=Trajectory(np.arange(frames) / 2.0, raw),
        trajectory=Trajectory(np.arange(frames) / 2.0, poses),
        turntable=TableMotion(
            axis_point=POINT, axis_direction=UP, radius=float(np.linalg.norm(across)), angles_rad=angles,
            radial_rms=0.0041, axial_rms=0.0032, closure=ClosingGap(0.004, 0.0021), rejected_frames=tuple(rejected),
            slips=slips, closure_raw=ClosingGap(0.031, 0.0094), told_rad=np.radians(14.4 * np.arange(frames)),
            angles_std_rad=np.where(np.isfinite(angles), 0.002, np.nan),
        ),
        residual=residual,
        inlier_share=inliers,
        rejected=rejected,
        times_seen=np.clip(np.round(8 + 90 * (mesh.vertices - centre) @ UP), 0, None),
        mesh_raw=Mesh(mesh.vertices + rng.normal(0, 0.0012, mesh.vertices.shape), mesh.faces),
        settings={"voxel_m": 0.002, "volume": {"truncation_m": 0.008, "color": True}, "poses": None},
        warnings=[("warning", "The camera's focal length is nominal; --refine-camera would find it.")],
        fingerprint={"frames": frames, "sha256": "0f" * 32},
        command="fusion turntable sphere -o out --voxel 0.002",
    )  # fmt: skip


def made_up_comparison() -> dict:
    """The fields of comparison.json."""
    block = {"mean_signed": 0.0004, "mean": 0.0007, "rms": 0.0009, "std": 0.0008, "median": 0.0006, "p95": 0.0016,
             "max": 0.0041, "within": {"0.001": 0.71, "0.002": 0.97, "0.005": 1.0}}  # fmt: skip
    far = block | {"rms": 0.0015, "within": {"0.001": 0.6, "0.002": 0.85, "0.005": 0.93}}
    return {"scale": 1.0, "T_reference_mesh": np.eye(4).tolist(), "accuracy": block, "completeness": far,
            "fscore": {"0.001": 0.65, "0.002": 0.9, "0.005": 0.96}}  # fmt: skip
