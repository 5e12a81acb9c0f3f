"""The pipeline for a turntable: find what turns, close the loop, integrate, clean."""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.coloring.color_mesh import Colored, color_mesh
from fusion.geometry.camera import Camera
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_kept
from fusion.progress import each, stage
from fusion.recording.images.masks import open_masks
from fusion.recording.recording import Recording
from fusion.results.color_light import color_lights
from fusion.results.light import Light
from fusion.scan.finding.attempt import Attempt, attempt, settle_camera
from fusion.scan.finding.frames import load
from fusion.scan.finding.object import choose_volume, clean, typical_noise
from fusion.scan.finding.poses import constrained, track_freely, wobble
from fusion.scan.finding.relieved import relieved
from fusion.scan.finding.seen import looked_through, seen_by_any
from fusion.scan.judging.agreement import agreement
from fusion.scan.judging.doctor import ask_doctor, notes_of
from fusion.scan.judging.evidence import Evidence
from fusion.scan.judging.missed import closing_gaps, confirmed
from fusion.scan.judging.print_agreement import print_agreement
from fusion.scan.judging.sure import MadeWith, scan_sigma
from fusion.scan.result import Scan
from fusion.scan.settings import ScanSettings
from fusion.sensor.correction.corrected_recording import corrected_recording
from fusion.sensor.correction.summary import CorrectionSummary
from fusion.sensor.presets import default_sensor
from fusion.sensor.sensor import Sensor
from fusion.turntable.circle import fit_circle, onto_circle
from fusion.turntable.focal import FocalCheck
from fusion.turntable.jumps import find_jump
from fusion.turntable.steps import judge_steps
from fusion.turntable.views import Region
from fusion.volume.prepared import fuse
from fusion.volume.volume import Volume

Array = NDArray[np.float64]


@dataclass(frozen=True)
class _Begun:
    """What is known beside the motion: sensor and what its correction did, the camera as stated, what the scan
    says of its focal length, and what the doctor said of the recording."""

    sensor: Sensor
    told: CorrectionSummary
    stated: Camera
    focal: FocalCheck
    asked: list[Light]


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
    settings = settings or ScanSettings()
    sensor = settings.sensor or default_sensor(recording.camera)
    with stage("looking"):
        asked = ask_doctor(recording, settings)
    recording, told = corrected_recording(recording, sensor)
    stated = recording.camera
    found, focal = settle_camera(attempt(recording, sensor, settings), sensor, settings)
    return _finish(found, settings, _Begun(sensor, told, stated, focal, asked))


def _finish(found: Attempt, settings: ScanSettings, begun: _Begun) -> Scan:
    """Volumes, trajectories and closure from a known motion."""
    recording, frames, region, motion, commanded = found.recording, found.frames, found.region, found.motion, found.told
    sensor, told, stated, focal = begun.sensor, begun.told, begun.stated, begun.focal
    volume_settings = choose_volume(settings, recording.camera, frames, region, motion)
    corrected = constrained(recording, motion)
    raw, residual, share, rough = track_freely(frames, region, corrected, volume_settings)
    circle = fit_circle(raw.centres)
    steps = judge_steps(motion.angles, motion.angle_std, commanded)
    if settings.strength == "circle":  # a log that misses a slip would put all later centres in the wrong place
        corrected, circle = onto_circle(raw, None if steps.slips else commanded)
    volume = Volume(volume_settings)
    for frame, T in zip(each(frames, "integrating"), corrected.poses, strict=True):
        if frame is not None and np.isfinite(T).all():
            fuse(volume, frame, T)
    with stage("mesh"):
        surface = volume.surface()
        if motion.shifts is not None:  # frames that a hand placed do not lie on each other as on one axis
            shown = seen_by_any(surface, frames, corrected.poses, volume_settings.truncation)
            surface = vertices_kept(surface, shown)
        passing = looked_through(surface, frames, corrected.poses, volume_settings.truncation)
        if 2 * passing.sum() < len(passing):  # else it is the motion that is wrong, and judged so
            surface = vertices_kept(surface, ~passing)
        cleaned, raw_cleaned = (clean(m, settings, motion, volume_settings.voxel) for m in (surface, rough.surface()))
        mesh = cleaned.mesh
    used = MadeWith(recording.camera, focal, sensor, settings.sensor, volume_settings)
    with stage("sigma"):
        sure = scan_sigma(mesh, frames, corrected.poses, used, motion)
    mesh = sure.onto(mesh)
    colored = color_mesh(mesh, recording, corrected) if settings.color else Colored(mesh)
    gaps = closing_gaps(frames, region, (corrected, raw), motion.angles)
    chosen = _chosen(settings, found, begun, volume) | colored.values()
    noise = typical_noise(frames, region)
    with stage("judging"):
        agreed = agreement(volume, frames, corrected.poses, motion)
        cut = region.cut(region.window(recording.camera))
        prints = print_agreement(frames, cut, corrected.poses, motion.angles)
    jump = find_jump(raw.poses, corrected.poses, mesh.vertices.mean(axis=0))
    return Scan(
        mesh=colored.mesh,
        mesh_raw=raw_cleaned.mesh,
        trajectory=corrected,
        trajectory_raw=raw,
        motion=motion,
        steps=steps,
        circle=circle,
        closure=gaps[0],
        closure_raw=gaps[1],
        residual=residual,
        inlier_share=share,
        wobble=wobble(raw, motion),
        camera=recording.camera,
        settings=chosen,
        told=commanded,
        sure=sure,
        evidence=Evidence(
            stated_camera=stated,
            focal=focal,
            refined=recording.camera != stated,
            jump=confirmed(jump, frames, region, corrected),
            noise=noise,
            kept_share=cleaned.kept,
            hidden=cleaned.hidden,
            agreement=agreed,
            print=prints,
            notes=(*begun.asked, *notes_of(recording, told, motion, raw), *color_lights(colored)),
            footnotes=(*sensor.warnings, *told.left),
        ),
    )


def _chosen(settings: ScanSettings, found: Attempt, begun: _Begun, volume: Volume) -> dict[str, Any]:
    """What was asked for and what was chosen, as plain values."""
    camera, region = found.recording.camera, found.region
    asked = {k: v for k, v in asdict(settings).items() if k not in ("sensor", "voxel", "truncation")}
    return asked | {
        "sensor": begun.sensor.name,
        "sensor_assumed": settings.sensor is None,
        "correction": begun.told.values(),
        "mask": None if settings.mask is None else str(settings.mask),
        "voxel_m": volume.settings.voxel,
        "truncation_m": volume.settings.truncation,
        "camera": {k: getattr(camera, k) for k in ("fx", "fy", "cx", "cy", "distortion")},
        "region": {"low": region.low.tolist(), "high": region.high.tolist()},
        "volume_bytes": volume.bytes,
    }


def mesh_at(recording: Recording, settings: ScanSettings, scan: Scan, T_object_camera: Array) -> Mesh:
    """The object from the same frames and volume as a scan, but with other poses (n, 4, 4) in its object frame."""
    sensor = settings.sensor or default_sensor(recording.camera)
    recording = replace(corrected_recording(recording, sensor)[0], camera=scan.camera)
    region = Region(np.array(scan.settings["region"]["low"]), np.array(scan.settings["region"]["high"]))
    masks = None if settings.mask is None else open_masks(settings.mask, recording)
    frames = relieved(load(recording, sensor, region, masks)[0], scan.motion.taken_out)
    volume = Volume(choose_volume(settings, scan.camera, frames, region, scan.motion))
    for frame, T in zip(frames, T_object_camera, strict=True):
        if frame is not None and np.isfinite(T).all():
            fuse(volume, frame, T)
    return clean(volume.surface(), settings, scan.motion, volume.settings.voxel).mesh
