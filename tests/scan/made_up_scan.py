"""A good scan without any recording: a box seen from all around; tests replace what they plant."""

from dataclasses import replace
from typing import Any

import numpy as np
import trimesh

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.results.choices import LensUsed, RegionFound, ScanChoices
from fusion.results.facts import Gap
from fusion.scan.judging.agreement import Agreement
from fusion.scan.judging.evidence import Evidence
from fusion.scan.result import Scan
from fusion.sensor.correction.summary import CorrectionFigures
from fusion.turntable.axis import Axis
from fusion.turntable.circle import Circle
from fusion.turntable.focal import FocalCheck
from fusion.turntable.motion import Motion
from fusion.turntable.selfcheck import NAMES, SelfCheck
from fusion.turntable.steps import judge_steps

CAMERA = Camera(640, 480, 580.0, 580.0, 319.5, 239.5)
COUNT = 36
CHOICES = ScanChoices(
    box=None, mask=None, step=None, use_log=True, strength="axis", refine_camera=None, keep_plate=False, force=False,
    fill_holes=0.03, sensor="none", sensor_assumed=True, correction=CorrectionFigures("nothing", {}, (), ()),
    camera=LensUsed.of(CAMERA), region=RegionFound((-0.1, -0.1, 0.6), (0.1, 0.1, 0.9)), voxel_m=0.001,
    truncation_m=0.004, volume_bytes=1, color=False, color_images=0, color_images_lost=0, uncolored_share=None,
    neutral_share=None,
)  # fmt: skip
AGREEING = Agreement(np.arange(4), np.zeros(4), np.zeros(4), np.zeros(4), 0.0002)


def good_scan() -> Scan:
    """36 frames in steps of 10 degrees, nothing wrong."""
    angles = np.deg2rad(10.0) * np.arange(COUNT)
    start = pose.pose(pose.rotation([-1.9, 0.0, 0.0]), [0.0, -0.8, 0.3])
    poses = np.stack([pose.about_axis([0, 0, 0], [0, 0, 1], -angle) @ start for angle in angles])
    trajectory = Trajectory(np.arange(COUNT) / 10, poses)
    box = trimesh.creation.box((0.1, 0.12, 0.2)).apply_translation((0, 0, 0.1))
    mesh = Mesh(np.asarray(box.vertices, float), np.asarray(box.faces, np.int32))
    check, small = SelfCheck(np.zeros(len(NAMES)), 0.6, 0.9), np.full(COUNT, 1e-3)
    motion = Motion(
        Axis(np.array([0.0, 0.1, 0.8]), np.array([0.0, -1.0, 0.0])), angles, small, small, np.full(COUNT, 0.9), {}, 0.0,
        0.1, 0.0, 0.2, check, check, check, 0.003,
    )  # fmt: skip
    return Scan(
        mesh=mesh, mesh_raw=mesh, trajectory=trajectory, trajectory_raw=trajectory, motion=motion,
        steps=judge_steps(angles, small), circle=Circle(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.8, 0.001, 0.001),
        closure=Gap(0.001, 0.0005, 0.5), closure_raw=Gap(0.004, 0.002, 2.0), residual=small,
        inlier_share=np.full(COUNT, 0.9), wobble=0.001, camera=CAMERA,
        settings=CHOICES,
        evidence=Evidence(CAMERA, FocalCheck(0.002, 0.003, 6.0, COUNT), False, None, 0.001, 1.0, AGREEING),
    )  # fmt: skip


def with_motion(scan: Scan, **changes: Any) -> Scan:
    """Another motion."""
    return replace(scan, motion=replace(scan.motion, **changes))


def with_evidence(scan: Scan, **changes: Any) -> Scan:
    """Other evidence."""
    return replace(scan, evidence=replace(scan.evidence, **changes))
