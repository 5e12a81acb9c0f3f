"""A pass: one turntable scan of the object, with the frames that it was made of."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.files.json_values import json_values
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.passes.poses.outlook import Outlook
from fusion.recording.images.masks import open_masks
from fusion.recording.recording import Recording
from fusion.scan.finding.frames import load
from fusion.scan.finding.object import MARGIN, typical_noise
from fusion.scan.finding.relieved import relieved
from fusion.scan.result import Scan
from fusion.scan.settings import ScanSettings
from fusion.sensor.correction.corrected_recording import corrected_recording
from fusion.sensor.presets import default_sensor
from fusion.sensor.sensor import Sensor
from fusion.turntable.selfcheck import SelfCheck
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared, fused
from fusion.volume.unmixed import matching_window, unmixed
from fusion.volume.volume import VolumeSettings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pass:
    """One scan of the object; its frame has z up along the table's axis, the plate at z = 0.

    Attributes:
        name: for messages.
        recording: with corrected depth and the camera that was used.
        frames: cut to the window of the object, errors of depth and what is mixed sideways (`volume/unmixed.py`) taken
            out; None where one cannot be read.
        trajectory: (n) `T_object_camera`, NaN for frames that take no part.
        mesh: the object alone, with normals.
        voxel, truncation: that the mesh was made with [m].
        noise: standard deviation of the depth on the object [m].
        sensor: name of the model that corrected and rated the depth.
        table: the content of its `turntable.json`.
    """

    name: str
    recording: Recording
    frames: list[Prepared | None]
    trajectory: Trajectory
    mesh: Mesh
    voxel: float
    truncation: float
    noise: float
    sensor: str
    table: dict[str, Any]

    @property
    def near(self) -> float:
        """Distance [m] within which surfaces of two passes are one: they differ by what depth errors leave (guess)."""
        return max(2.0 * self.voxel, 2.5 * self.noise)

    @property
    def plate(self) -> bool:
        """Whether it stood on a plate that was seen, at z = 0: nothing of the object is below."""
        return bool(self.table.get("plate_seen", False))

    @property
    def hidden(self) -> float:
        """So far above its foot the mesh was carried down and not seen [m]."""
        return float(self.table.get("hidden_m", 0.0))

    @cached_property
    def outlook(self) -> Outlook:
        """What its frames looked through."""
        return Outlook.of(self.frames, self.trajectory.poses, self.near)


@dataclass(frozen=True)
class Made:
    """What a scan says of itself that is needed to load its frames again."""

    trajectory: Trajectory  # (n) `T_object_camera` of every frame of the recording
    mesh: Mesh  # with normals
    # focal, centre: fx, fy and cx, cy of the camera that was used [px]
    focal: tuple[float, float]
    centre: tuple[float, float]
    region: Region  # where the object was found
    mask: Path | None  # a PNG or a folder of them; None: none was used
    # voxel, truncation: [m]
    voxel: float
    truncation: float
    table: dict[str, Any]  # as in `turntable.json`
    taken_out: SelfCheck  # errors of depth that the scan itself showed


def pass_of_scan(recording: Recording, scan: Scan, settings: ScanSettings) -> Pass:
    """The pass that a scan of a recording is."""
    used, found = scan.settings, scan.settings.region
    made = Made(
        trajectory=scan.trajectory,
        mesh=scan.mesh,
        focal=(used.camera.fx, used.camera.fy),
        centre=(used.camera.cx, used.camera.cy),
        region=Region(np.array(found.low), np.array(found.high)),
        mask=used.mask,
        voxel=used.voxel_m,
        truncation=used.truncation_m,
        table=json_values(scan.turntable()),
        taken_out=scan.motion.taken_out,
    )
    sensor = settings.sensor or default_sensor(recording.camera)
    return pass_of(recording, sensor, made)


def pass_of(recording: Recording, sensor: Sensor, made: Made) -> Pass:
    """The pass of a recording as a scan of it was made: the same sensor model, camera, window and errors of depth.

    Raises:
        RecordingError: masks that were used are not there any more.
    """
    told = corrected_recording(recording, sensor)[0]
    (fx, fy), (cx, cy) = made.focal, made.centre
    told = replace(told, camera=replace(told.camera, fx=fx, fy=fy, cx=cx, cy=cy))
    masks = None if made.mask is None else open_masks(made.mask, told)
    frames = relieved(load(told, sensor, made.region, masks)[0], made.taken_out)
    low, high = made.mesh.vertices.min(axis=0) - MARGIN, made.mesh.vertices.max(axis=0) + MARGIN
    around = VolumeSettings(made.voxel, made.truncation, bounds=(corner(low), corner(high)))
    poses = made.trajectory.poses
    frames = unmixed(frames, fused(around, frames, poses, "model"), poses, matching_window(sensor, told.camera.fx))
    return Pass(
        name=recording.path.name,
        recording=told,
        frames=frames,
        trajectory=made.trajectory,
        mesh=made.mesh,
        voxel=made.voxel,
        truncation=made.truncation,
        noise=typical_noise(frames, made.region),
        sensor=sensor.name,
        table=made.table,
    )


def corner(point: Array) -> tuple[float, float, float]:
    """Of a box."""
    x, y, z = point.tolist()
    return x, y, z
