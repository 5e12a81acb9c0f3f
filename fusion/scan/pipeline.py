"""The pipeline for a turntable: find what turns, place the frames, make the object, judge it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh
from fusion.recording.images.masks import open_masks
from fusion.recording.recording import Recording
from fusion.scan.cleaning.clean import clean
from fusion.scan.finding.frames import load
from fusion.scan.finding.object import choose_volume
from fusion.scan.finding.relieved import relieved
from fusion.scan.judging.judged import judged
from fusion.scan.making import make
from fusion.scan.motion import find_motion_and_camera
from fusion.scan.opening import open_scan
from fusion.scan.placing import place
from fusion.scan.result import Scan
from fusion.scan.settings import ScanSettings
from fusion.sensor.correction.corrected_recording import corrected_recording
from fusion.sensor.presets import default_sensor
from fusion.turntable.views import Region
from fusion.volume.prepared import fused

Array = NDArray[np.float64]


def scan_turntable(recording: Recording, settings: ScanSettings | None = None) -> Scan:
    """Scan an object on a turntable before a camera that stands still.

    Raises:
        RecordingError: too few readable frames.
        TrackingError: nothing turns, or not about one axis.
        VolumeError: the voxel settings make no sense or do not fit into memory.

    >>> scan = fusion.scan_turntable(fusion.open_recording("my_scan"), fusion.ScanSettings(voxel=0.004))
    >>> round(abs(np.rad2deg(scan.steps.mean)))
    15
    >>> fusion.write_mesh("cup.ply", scan.mesh)
    """
    opened = open_scan(recording, settings or ScanSettings())
    found = find_motion_and_camera(opened)
    placed = place(found)
    made = make(placed)
    return judged(made)


def mesh_at(recording: Recording, settings: ScanSettings, scan: Scan, T_object_camera: Array) -> Mesh:
    """The object from the same frames and volume as a scan, but with other poses (n, 4, 4) in its object frame."""
    sensor = settings.sensor or default_sensor(recording.camera)
    recording = replace(corrected_recording(recording, sensor)[0], camera=scan.camera)
    region = Region(np.array(scan.settings["region"]["low"]), np.array(scan.settings["region"]["high"]))
    masks = None if settings.mask is None else open_masks(settings.mask, recording)
    frames = relieved(load(recording, sensor, region, masks)[0], scan.motion.taken_out)
    volume = fused(choose_volume(settings, scan.camera, frames, region, scan.motion), frames, T_object_camera)
    return clean(volume.surface(), settings, scan.motion, volume.settings.voxel).mesh
