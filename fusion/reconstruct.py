"""The pipeline for a moving camera: correct, track, integrate; a recording becomes a mesh."""

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.coloring.color_mesh import Colored, color_mesh
from fusion.errors import RecordingError, TrackingError, VolumeError
from fusion.geometry.depth import PointMap
from fusion.geometry.pose import Array
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import shape_of
from fusion.progress import each, stage
from fusion.quantity import MAX_DEPTH, check_volume
from fusion.recording.checks.stillness import check_camera_moves
from fusion.recording.doctor import quick_look, refuse_if_certain
from fusion.recording.recording import Recording
from fusion.results.facts import ScanFacts, median_of, rms_of
from fusion.sensor.corrected_recording import corrected_recording
from fusion.sensor.moments import moments_of
from fusion.sensor.presets import default_sensor
from fusion.sensor.sensor import Sensor
from fusion.sensor.told import Told
from fusion.tracking.tracker import Tracked, Tracker, TrackerSettings
from fusion.volume.forecast import choose_truncation, choose_voxel, forecast_bytes
from fusion.volume.prepared import Prepared, fuse, fusible, prepare
from fusion.volume.volume import Volume, VolumeSettings
from fusion.volume.voxel_check import voxel_check

PROBES = 5  # frames looked at before the start, to choose voxels and to forecast the memory
FOREGROUND = 0.25  # quantile of the depth that stands for an object's distance (guess)
MODEL_WIDTH = 400  # the model is seen at half resolution from images wider than this: noise is finer than it [px]


@dataclass(frozen=True)
class ReconstructSettings:
    """What a reconstruction may be told.

    Attributes:
        sensor: corrects the depth and weighs it; None takes what the camera's principle suggests.
        poses: `T_world_camera` by time stamp, used as they are; None tracks the frames.
        voxel, truncation: [m]; None chooses them from distance, focal length and noise.
        room: voxels for a room instead of an object, where they are chosen.
        max_depth: depth beyond is not used [m].
        box: two corners (3,), (3,) [m] in the world (the first camera's frame unless poses are given).
        color: colour the mesh where the recording has colour images.
        max_bytes: limit of the volume's memory.
        min_placed: share of the frames below which the whole has failed.
        tracker: how frames are placed.
        force: go on where the recording's doctor is certain that the result will be wrong.
    """

    sensor: Sensor | None = None
    poses: Trajectory | None = None
    voxel: float | None = None
    truncation: float | None = None
    room: bool = False
    max_depth: float | None = None
    box: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    color: bool = True
    max_bytes: int = 4 << 30
    min_placed: float = 0.5
    tracker: TrackerSettings = field(default_factory=TrackerSettings)
    force: bool = False

    def __post_init__(self) -> None:
        check_volume(self.voxel, self.truncation, self.box)
        MAX_DEPTH.check(self.max_depth)


@dataclass(frozen=True)
class Reconstruction:
    """A mesh and the evidence for it; n is the number of frames of the recording.

    Attributes:
        mesh: in the world, which is the first placed camera's frame unless poses were given.
        trajectory: (n) `T_world_camera`, NaN for rejected frames.
        residual, inlier_share: (n,) of the alignment [m], [1]; NaN where a frame was not aligned.
        information: (n, 6, 6) as in `IcpResult`.
        unconstrained: frame to the directions that its surface does not fix.
        rejected: frame to reason.
        settings: what was asked for and chosen, plain values.
        warnings: ("warning" or "bad", sentence).
        volume: what was fused.
    """

    mesh: Mesh
    trajectory: Trajectory
    residual: NDArray[np.float64]
    inlier_share: NDArray[np.float64]
    information: NDArray[np.float64]
    unconstrained: dict[int, tuple[str, ...]]
    rejected: dict[int, str]
    settings: dict[str, Any]
    warnings: tuple[tuple[str, str], ...]
    volume: Volume

    @cached_property
    def facts(self) -> ScanFacts:
        """Every number that terminal, page and JSON tell; up is where the first camera has it."""
        return ScanFacts(
            shape=shape_of(self.mesh, np.array([0.0, -1.0, 0.0])),
            frames=len(self.trajectory),
            placed=int(self.trajectory.valid.sum()),
            residual=rms_of(self.residual),
            inlier_share=median_of(self.inlier_share),
        )


def reconstruct(recording: Recording, settings: ReconstructSettings | None = None) -> Reconstruction:
    """Correct, track and fuse all frames of a recording.

    Raises:
        RecordingError: no frame, or none that can be read or shows a surface; or the doctor is certain that the result
            will be wrong, and `settings.force` is not set.
        TrackingError: fewer frames were placed than `settings.min_placed` asks for.
        VolumeError: the voxel settings make no sense or do not fit into memory.
    """
    settings = settings or ReconstructSettings()
    sensor = settings.sensor or default_sensor(recording.camera)
    with stage("looking"):
        asked = _ask_doctor(recording, settings)
    recording, told = corrected_recording(recording, sensor)
    moments = moments_of(recording)
    with stage("planning"):
        volume_settings, notes = plan(recording, settings, sensor)
    notes = asked + notes + told.notes
    volume = Volume(volume_settings)
    placed = _Placer(recording, settings, volume)
    results: list[Tracked] = []
    for index in each(range(len(recording)), "tracking"):
        try:
            frame = prepare(recording[index], recording.camera, sensor, moments[index], settings.max_depth)
        except RecordingError as error:  # one broken file is no reason to lose the others
            results.append(placed.skip(str(error)))
            continue
        results.append(placed(index, frame))
        if results[-1].ok:
            fuse(volume, frame, results[-1].T_world_camera)
    _check_enough(results, recording, settings)
    with stage("mesh"):
        mesh = volume.surface()
    if not len(mesh.faces):
        raise VolumeError("nothing was fused", recording.path, "no surface", do="check --box and --max-depth")
    notes += _judge(results)
    return _result(recording, results, mesh, volume, (settings, sensor, notes, told))


def _ask_doctor(recording: Recording, settings: ReconstructSettings) -> list[tuple[str, str]]:
    # with given poses nothing is tracked, and in a box only what is in it
    free = settings.poses is None and settings.box is None
    checks = (voxel_check(settings.voxel), *((check_camera_moves,) if free else ()))
    return refuse_if_certain(quick_look(recording, checks, settings.max_depth), recording, settings.force)


def plan(
    recording: Recording, settings: ReconstructSettings, sensor: Sensor
) -> tuple[VolumeSettings, list[tuple[str, str]]]:
    """Voxel and truncation that suit a recording, with warnings; what one view takes must fit into memory."""
    probes = _probe(recording, settings, sensor)
    # an object stands in the foreground: what lies far behind must not choose its voxels
    share = 0.5 if settings.room else FOREGROUND
    distance = float(np.median([np.nanquantile(p.depth, share) for p in probes]))
    sigma = float(np.median([np.nanquantile(p.surface.sigma, share) for p in probes]))
    voxel = settings.voxel or choose_voxel(distance, recording.camera, settings.room)  # 0 is refused in the settings
    truncation = settings.truncation or choose_truncation(voxel, sigma)
    chosen = VolumeSettings(voxel, truncation, bounds=settings.box, max_bytes=settings.max_bytes)
    notes = [("warning", text) for text in (*recording.warnings, *sensor.warnings)]
    if settings.box is None:
        usable = [np.where(fusible(p, truncation), p.depth, np.nan) for p in probes]
        needed = max(forecast_bytes(chosen, depth, recording.camera) for depth in usable)
        if needed > settings.max_bytes:
            fits = voxel * np.sqrt(needed / settings.max_bytes)
            raise VolumeError(
                "the volume will not fit into its memory",
                recording.path,
                f"{needed / 2**20:.0f} MiB for one view with voxels of {voxel * 1e3:g} mm",
                f"at most {settings.max_bytes / 2**20:.0f} MiB",
                f"pass --voxel {np.ceil(fits * 4000) / 4000:g} or more, --room, --box or --max-depth",
            )
        if needed > settings.max_bytes / 4:
            text = f"one view alone takes {needed / 2**20:.0f} MiB of {settings.max_bytes / 2**20:.0f} MiB"
            notes.append(("warning", f"memory: {text}; --room, --box or --max-depth need less"))
    return chosen, notes


def _probe(recording: Recording, settings: ReconstructSettings, sensor: Sensor) -> list[Prepared]:
    """A few frames that show a surface, spread over the recording."""
    if not len(recording):
        raise RecordingError("the recording has no frames", recording.path)
    found, broken = [], None
    for index in np.unique(np.linspace(0, len(recording) - 1, PROBES).round().astype(int)):
        try:
            prepared = prepare(recording[int(index)], recording.camera, sensor, max_depth=settings.max_depth)
        except RecordingError as error:
            broken = error
            continue
        if np.isfinite(prepared.depth).any():
            found.append(prepared)
    if not found:
        if broken is not None:
            raise broken
        raise RecordingError(
            "no depth in the recording", recording.path, "only missing pixels",
            do="check the depth files, depth_scale and --max-depth",
        )  # fmt: skip
    return found


class _Placer:
    """Gives each frame its pose: the stated one, or a tracked one."""

    def __init__(self, recording: Recording, settings: ReconstructSettings, volume: Volume) -> None:
        self.poses = None if settings.poses is None else settings.poses.at(recording.timestamps).poses
        camera = recording.camera
        self.model_camera = camera.halved() if camera.width > MODEL_WIDTH else camera
        self.far = settings.max_depth or 20.0
        self.volume = volume
        self.tracker = Tracker(self._model, settings.tracker)

    def __call__(self, index: int, frame: Prepared) -> Tracked:
        if self.poses is None:
            if self.tracker.past and not self.volume.block_count:
                raise VolumeError("nothing of the first frame was fused", do="check --box and --max-depth")
            return self.tracker.place(frame.surface)
        T = self.poses[index]
        return Tracked(T) if np.isfinite(T).all() else self.skip("no pose is given for its time stamp")

    def skip(self, reason: str) -> Tracked:
        return self.tracker.skip(reason)

    def _model(self, T_world_camera: Array) -> PointMap:
        seen = self.volume.raycast(self.model_camera, T_world_camera, far=self.far)
        # the noise of the model is small against that of a frame: many frames made it
        return PointMap(self.model_camera, seen.points, seen.normals, np.zeros_like(seen.depth))


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


def _judge(results: list[Tracked]) -> list[tuple[str, str]]:
    notes = []
    lost = sum(not r.ok for r in results)
    if lost:
        notes.append(("warning", f"{lost} of {len(results)} frames are rejected"))
    weak = Counter(name for r in results if r.ok for name in r.unconstrained)
    for name, count in weak.most_common():
        if count > 0.1 * len(results):
            notes.append(("warning", f"{name} is not fixed by the surface in {count} of {len(results)} frames"))
    return notes


def _result(
    recording: Recording, results: list[Tracked], mesh: Mesh, volume: Volume,
    how: tuple[ReconstructSettings, Sensor, list[tuple[str, str]], Told],
) -> Reconstruction:  # fmt: skip
    settings, sensor, notes, told_of = how
    trajectory = Trajectory(recording.timestamps, np.stack([r.T_world_camera for r in results]))
    colored = color_mesh(mesh, recording, trajectory) if settings.color else Colored(mesh)
    told = {
        "camera": {k: getattr(recording.camera, k) for k in ("fx", "fy", "cx", "cy", "distortion")},
        "correction": told_of.values(),
        "voxel_m": volume.settings.voxel,
        "truncation_m": volume.settings.truncation,
        "room": settings.room,
        "max_depth_m": settings.max_depth,
        "box_m": settings.box,
        "sensor": sensor.name,
        "poses": "tracked" if settings.poses is None else "given",
        "volume_bytes": volume.bytes,
    } | colored.values()
    return Reconstruction(
        mesh=colored.mesh,
        trajectory=trajectory,
        residual=np.array([r.residual for r in results]),
        inlier_share=np.array([r.inlier_share for r in results]),
        information=np.stack([r.information for r in results]),
        unconstrained={i: r.unconstrained for i, r in enumerate(results) if r.ok and r.unconstrained},
        rejected={i: r.status for i, r in enumerate(results) if not r.ok},
        settings=told,
        warnings=tuple(notes),
        volume=volume,
    )
