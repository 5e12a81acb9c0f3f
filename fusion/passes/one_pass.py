"""A pass: one turntable scan of the object, with the frames that it was made of."""

from dataclasses import dataclass, replace
from functools import cached_property
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
from fusion.scan.finding.object import typical_noise
from fusion.scan.finding.relieved import relieved
from fusion.scan.result import Scan
from fusion.scan.settings import ScanSettings
from fusion.sensor.correction.corrected_recording import corrected_recording
from fusion.sensor.presets import default_sensor
from fusion.sensor.sensor import Sensor
from fusion.turntable.selfcheck import SelfCheck
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pass:
    """One scan of the object; its frame has z up along the table's axis, the plate at z = 0.

    Attributes:
        name: for messages.
        recording: with corrected depth and the camera that was used.
        frames: cut to the window of the object, errors of depth taken out; None where one cannot be read.
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
    """What a scan says of itself that is needed to load its frames again.

    Attributes:
        trajectory: (n) `T_object_camera` of every frame of the recording.
        mesh: with normals.
        settings: as in `settings.json`.
        table: as in `turntable.json`.
        taken_out: errors of depth that the scan itself showed.
    """

    trajectory: Trajectory
    mesh: Mesh
    settings: dict[str, Any]
    table: dict[str, Any]
    taken_out: SelfCheck


def pass_of_scan(recording: Recording, scan: Scan, settings: ScanSettings) -> Pass:
    """The pass that a scan of a recording is."""
    made = Made(scan.trajectory, scan.mesh, scan.settings, json_values(scan.turntable()), scan.motion.taken_out)
    sensor = settings.sensor or default_sensor(recording.camera)
    return pass_of(recording, sensor, made)


def pass_of(recording: Recording, sensor: Sensor, made: Made) -> Pass:
    """The pass of a recording as a scan of it was made: the same sensor model, camera, window and errors of depth.

    Raises:
        RecordingError: masks that were used are not there any more.
    """
    told, chosen = corrected_recording(recording, sensor)[0], made.settings
    camera = replace(told.camera, **{k: v for k, v in chosen["camera"].items() if k in ("fx", "fy", "cx", "cy")})
    told = replace(told, camera=camera)
    region = Region(np.array(chosen["region"]["low"], float), np.array(chosen["region"]["high"], float))
    masks = None if chosen["mask"] is None else open_masks(chosen["mask"], told)
    frames = relieved(load(told, sensor, region, masks)[0], made.taken_out)
    return Pass(
        name=recording.path.name,
        recording=told,
        frames=frames,
        trajectory=made.trajectory,
        mesh=made.mesh,
        voxel=float(chosen["voxel_m"]),
        truncation=float(chosen["truncation_m"]),
        noise=typical_noise(frames, region),
        sensor=sensor.name,
        table=made.table,
    )
