"""The pipeline for a moving camera: correct, track, integrate; a recording becomes a mesh."""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from fusion.coloring.color_mesh import Colored, color_mesh
from fusion.errors import TrackingError, VolumeError
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.cleanup import without_crumbs
from fusion.mesh.mesh import Mesh
from fusion.progress import stage
from fusion.reconstruction.changed import Changed
from fusion.reconstruction.course import Straightened, straighten
from fusion.reconstruction.focal_length import focal_of
from fusion.reconstruction.planning import Plan, object_after_all, plan
from fusion.reconstruction.result import Reconstruction
from fusion.reconstruction.settings import ReconstructSettings
from fusion.reconstruction.sure import FusedWith, walk_sigma
from fusion.reconstruction.walk import Walk, WalkedFrames, fused, fused_again, track
from fusion.reconstruction.walked_round import StandingView
from fusion.recording.checks.poses import check_poses
from fusion.recording.checks.stillness import check_camera_moves
from fusion.recording.looking.doctor import fit_to_scan, quick_look, refuse_if_certain
from fusion.recording.recording import Recording
from fusion.results.choices import LensUsed, ReconstructionChoices
from fusion.results.color_light import color_lights, colors_apart
from fusion.results.course import off_course
from fusion.results.light import Light, note
from fusion.sensor.correction.corrected_recording import corrected_recording
from fusion.sensor.correction.summary import CorrectionSummary
from fusion.sensor.presets import default_sensor
from fusion.sensor.sensor import Sensor
from fusion.tracking.tracker import Tracked
from fusion.volume.volume import Volume
from fusion.volume.voxel_check import voxel_check

RESOLVED = 0.1  # of a voxel: a motion of the poses that what is fused shows
CRUMB = 4.0  # truncations: a part smaller than twice the band in which noise is fused may be noise alone


def reconstruct(recording: Recording, settings: ReconstructSettings | None = None) -> Reconstruction:
    """Correct, track and fuse all frames of a recording.

    Raises:
        RecordingError: no frame, or none that can be read or shows a surface; or the doctor is certain that the result
            will be wrong, and `settings.force` is not set.
        TrackingError: fewer frames were placed than `settings.min_placed` asks for.
        VolumeError: the voxel settings make no sense or do not fit into memory.

    >>> result = fusion.reconstruct(fusion.open_recording("my_room"))
    >>> result.settings.kind, round(result.settings.voxel_m, 3)
    ('room', 0.019)
    >>> fusion.write_mesh("room.ply", result.mesh)
    """
    settings = settings or ReconstructSettings()
    sensor = settings.sensor or default_sensor(recording.camera)
    if not settings.color:
        recording = recording.without_color()
    with stage("looking"):
        recording, asked = _ask_doctor(recording, settings)
    recording, told = corrected_recording(recording, sensor)
    with stage("planning"):
        chosen = plan(recording, settings, sensor)
    frames = WalkedFrames(recording, sensor, settings.max_depth)
    tracked = track(frames, settings, chosen)
    volume, chosen, results = tracked.volume, tracked.plan, tracked.results
    band = chosen.volume.truncation  # of the model that frames were held against; an object may be fused in a finer one
    straight = Straightened(results)
    if settings.poses is None:
        with stage("loops"):
            least = RESOLVED * chosen.volume.voxel
            straight = straighten(results, tracked.pieces, recording.timestamps, tracked.keyframes, least)
        volume, chosen, results = settled(frames, settings, tracked, straight)
    _check_enough(results, recording, settings)
    with stage("mesh"):
        mesh = without_crumbs(volume.surface(), CRUMB * chosen.volume.truncation)
    if not len(mesh.faces):
        raise VolumeError("nothing was fused", recording.path, "no surface", do="check --box and --max-depth")
    said = [*asked, *chosen.warnings, *(("warning", text) for text in recording.warnings)]
    notes = [note("Recording", *one) for one in said] + [note("Correction", "warning", x) for x in told.doubtful]
    poses = np.stack([r.T_world_camera for r in results])
    notes += [] if straight.colors_missed is None else [colors_apart(straight.colors_missed)]
    focal = focal_of(tracked.keyframes, poses) if straight.colors_missed is None else None
    light = None if focal is None else focal.light(recording.camera)
    notes += [] if light is None else [light]
    with stage("sigma"):
        errors = None if straight.network is None else straight.network.errors(poses)
        changed = Changed(volume, poses)
        sure = walk_sigma(mesh, frames, poses, errors, FusedWith(settings.sensor, volume.settings, focal), changed)
    light = changed.light()
    notes += [] if light is None else [light]
    made = _Made(sure.onto(mesh), volume, chosen, band, straight, sensor, told, notes)
    return replace(_result(recording, settings, results, made), sure=sure)


def _ask_doctor(recording: Recording, settings: ReconstructSettings) -> tuple[Recording, list[tuple[str, str]]]:
    """What of the recording is used, and what looks wrong with it."""
    # with given poses nothing is tracked, but they may be inverted or in millimetres; in a box only what is in it
    checks = [voxel_check(settings.voxel)]
    if settings.poses is not None:
        checks.append(check_poses)
    elif settings.box is None:
        checks.append(check_camera_moves)
    posed = recording if settings.poses is None else replace(recording, poses=settings.poses)
    findings = quick_look(posed, tuple(checks), settings.max_depth)
    said = refuse_if_certain(findings, recording, settings.force)
    return fit_to_scan(recording, findings, settings.force), said


def _check_enough(results: list[Tracked], recording: Recording, settings: ReconstructSettings) -> None:
    lost = [r.status for r in results if not r.ok]
    placed = len(results) - len(lost)
    if placed == 0 or placed < settings.min_placed * len(results):
        raise TrackingError(
            "too few frames could be placed",
            recording.path,
            f"{placed} of {len(results)}; most often: {Counter(lost).most_common(1)[0][0]}",
            f"at least {settings.min_placed:.0%}",
            "move slower, keep more relief in view, or give --poses; `fusion info` checks the recording",
        )


@dataclass(frozen=True)
class _Made:
    """What was made of the tracked frames, and with what: see `Reconstruction`."""

    mesh: Mesh
    volume: Volume
    plan: Plan
    band: float
    straight: Straightened
    sensor: Sensor
    told: CorrectionSummary
    notes: list[Light]


def _result(recording: Recording, settings: ReconstructSettings, results: list[Tracked], made: _Made) -> Reconstruction:
    volume, chosen = made.volume, made.plan
    trajectory = Trajectory(recording.timestamps, np.stack([r.T_world_camera for r in results]))
    colored = color_mesh(made.mesh, recording, trajectory) if settings.color else Colored(made.mesh)
    told = ReconstructionChoices(
        **vars(colored.figures()),
        camera=LensUsed.of(recording.camera),
        correction=made.told.figures(),
        voxel_m=volume.settings.voxel,
        truncation_m=volume.settings.truncation,
        tracked_band_m=made.band,
        room=chosen.subject.room,
        kind=chosen.kind,
        kind_reason=chosen.reason,
        max_depth_m=settings.max_depth,
        box_m=chosen.volume.bounds,
        sensor=made.sensor.name,
        poses="tracked" if settings.poses is None else "given",
        volume_bytes=volume.bytes,
    )
    return Reconstruction(
        mesh=colored.mesh,
        trajectory=trajectory,
        residual=np.array([r.residual for r in results]),
        inlier_share=np.array([r.inlier_share for r in results]),
        information=np.stack([r.information for r in results]),
        unconstrained={i: r.unconstrained for i, r in enumerate(results) if r.ok and r.unconstrained},
        rejected={i: r.status for i, r in enumerate(results) if not r.ok},
        settings=told,
        volume=volume,
        notes=(*made.notes, *color_lights(colored)),
        footnotes=(*made.sensor.warnings, *made.told.left),
        off_course=off_course(trajectory, recording) if settings.poses is None else None,
        course=made.straight.course,
        known=made.straight.known,
    )


def settled(
    frames: WalkedFrames, settings: ReconstructSettings, walk: Walk, straight: Straightened
) -> tuple[Volume, Plan, list[Tracked]]:
    """The volume that suits the settled course, how it was fused, and the results of all frames.

    Raises:
        RecordingError: a frame that was read before cannot be read any more.
        VolumeError: the volume does not fit into its memory.
    """
    results, plan = straight.results, walk.plan
    found = [(results[frame.index], frame.surface) for frame in walk.keyframes]
    views = [StandingView(result.T_world_camera, surface) for result, surface in found if result.ok]
    finer = object_after_all(plan, frames.recording, settings, views)
    if finer is not None:
        try:
            return _fused(frames, straight, finer)
        except VolumeError as error:
            plan = replace(plan, reason=f"{plan.reason}; as an object: {error.what}")
    if straight.between is None:
        return walk.volume, plan, results
    return _fused(frames, straight, plan)


def _fused(frames: WalkedFrames, straight: Straightened, plan: Plan) -> tuple[Volume, Plan, list[Tracked]]:
    if straight.between is not None:
        volume, results = fused_again(frames, straight.results, plan, straight.between)
        return volume, plan, results
    placed = [i for i, result in enumerate(straight.results) if result.ok]
    return fused(frames, straight.results, plan, placed), plan, straight.results
