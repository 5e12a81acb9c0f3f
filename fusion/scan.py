"""The pipeline for a turntable: find what turns, close the loop, integrate, clean; a recording becomes a mesh."""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from fusion.errors import FusionError, RecordingError, TrackingError
from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.geometry.depth import PointMap
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.cleanup import fill_small_holes, largest_part
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_kept
from fusion.reconstruct import Prepared, fuse, prepare
from fusion.recording.recording import Recording
from fusion.sensor.presets import default_sensor
from fusion.sensor.sensor import Sensor
from fusion.tracking.icp import IcpSettings, align
from fusion.turntable.circle import Circle, fit_circle, onto_circle
from fusion.turntable.motion import Motion, estimate_motion
from fusion.turntable.moving import find_moving
from fusion.turntable.plate import above_plate
from fusion.turntable.steps import Steps, closing_pair, judge_steps
from fusion.turntable.views import Region, View, crop, view
from fusion.volume.forecast import choose_truncation, choose_voxel
from fusion.volume.volume import Volume, VolumeSettings

Array = NDArray[np.float64]
LOOKED_AT = 30  # frames that show what turns
WRONG_FOCAL = 0.01  # relative error of the focal length that is worth a warning
CLEAR_OF_PLATE = 0.004  # [m] the plate is cut away up to here
TRACKING = IcpSettings(strides=(4, 2, 2), reaches=(0.02, 0.012, 0.008), iterations=(6, 5, 4), min_inlier_share=0.3)


@dataclass(frozen=True)
class ScanSettings:
    """What a turntable scan may be told.

    Attributes:
        sensor: corrects the depth and weighs it; None takes what the camera's principle suggests.
        box: two corners (3,), (3,) [m] in the camera's frame around the turning object; None finds it.
        step: turn between frames [rad] of either sign; None takes the table's log, or finds it.
        use_log: False ignores the table's log.
        strength: "axis" (one axis, one angle per frame) or "circle" (Pagliari: only centres are moved).
        refine_camera: take out the error of the focal length that the scan itself shows.
        keep_plate: leave the plate in the mesh.
        voxel, truncation: [m]; None chooses them from distance, focal length and noise.
        color: fuse colour where the recording has it.
        fill_holes: close holes up to this perimeter [m].
    """

    sensor: Sensor | None = None
    box: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    step: float | None = None
    use_log: bool = True
    strength: str = "axis"
    refine_camera: bool = False
    keep_plate: bool = False
    voxel: float | None = None
    truncation: float | None = None
    color: bool = True
    fill_holes: float = 0.03


@dataclass(frozen=True)
class Scan:
    """A scanned object; its frame has the origin on the axis at the plate, z up along the axis.

    Attributes:
        mesh: the object; mesh_raw: from the poses before the post-pass.
        trajectory, trajectory_raw: (n) `T_object_camera`, NaN for rejected frames.
        motion, steps: what the table did.
        circle: fitted to the raw centres.
        closure, closure_raw: closing gap after and before, (angle [rad], distance [m]), None when the turn is not full.
        residual, inlier_share: (n,) [m], [1].
        wobble: rms tilt of the freely tracked poses against the axis [rad].
        camera: used for the result (refined when asked for).
        settings: what was asked for and chosen, plain values.
        warnings: ("ok", "warning" or "bad", sentence).
    """

    mesh: Mesh
    mesh_raw: Mesh
    trajectory: Trajectory
    trajectory_raw: Trajectory
    motion: Motion
    steps: Steps
    circle: Circle
    closure: tuple[float, float] | None
    closure_raw: tuple[float, float] | None
    residual: Array
    inlier_share: Array
    wobble: float
    camera: Camera
    settings: dict[str, Any]
    warnings: tuple[tuple[str, str], ...]

    def turntable(self) -> dict[str, Any]:
        """The content of `turntable.json` (CONTRACT)."""

        def gap(value: tuple[float, float] | None) -> dict[str, float | None]:
            return {"angle_rad": None, "distance": None} if value is None else dict(
                zip(("angle_rad", "distance"), value, strict=True)
            )  # fmt: skip

        axis = self.motion.axis
        return {
            "axis_point": axis.point.tolist(),
            "axis_direction": axis.direction.tolist(),
            "radius": float(axis.distance(np.zeros((1, 3)))[0][0]),
            "angles_rad": [None if np.isnan(a) else float(a) for a in self.motion.angles],
            "angles_std_rad": [None if np.isnan(a) else float(a) for a in self.motion.angle_std],
            "direction": self.steps.direction,
            "radial_rms": self.circle.radial_rms,
            "axial_rms": self.circle.axial_rms,
            "closure": gap(self.closure),
            "closure_raw": gap(self.closure_raw),
            "wobble_rad": self.wobble,
            "step_mean_rad": self.steps.mean,
            "step_std_rad": self.steps.std,
            "rejected_frames": sorted(self.motion.rejected),
            "rejected_reasons": {str(k): v for k, v in sorted(self.motion.rejected.items())},
            "slips": [{"frame": s.frame, "angle_rad": s.angle} for s in self.steps.slips],
            "focal_length_check": {
                "relative": float(np.expm1(self.motion.focal_check.values[0])),
                "fx": float(self.camera.fx * np.exp(self.motion.focal_check.values[0])),
            },
        }


def scan_turntable(recording: Recording, settings: ScanSettings | None = None) -> Scan:
    """Scan an object on a turntable before a camera that stands still.

    Raises:
        RecordingError: too few readable frames.
        TrackingError: nothing turns, or not about one axis.
        VolumeError: the voxel settings make no sense or do not fit into memory.
    """
    settings = settings or ScanSettings()
    if settings.strength not in ("axis", "circle"):
        raise FusionError("unknown strength of the post-pass", "--strength", settings.strength, "axis or circle")
    sensor = settings.sensor or default_sensor(recording.camera)
    camera = recording.camera
    region = _region(recording, sensor, settings)
    frames, broken = _load(recording, sensor, region)
    commanded = _commanded(recording, settings)
    motion = _motion(frames, camera, region, commanded)
    refined = None
    if settings.refine_camera:
        refined = replace(motion.focal_check, values=np.concatenate([motion.focal_check.values[:3], np.zeros(7)]))
        camera = refined.camera(camera)
        recording = replace(recording, camera=camera)
        region = _region(recording, sensor, settings)
        frames, broken = _load(recording, sensor, region, camera)
        motion = _motion(frames, camera, region, commanded)
    motion = replace(motion, rejected={**motion.rejected, **broken})
    return _finish(recording, settings, sensor, (frames, region, motion, commanded))


def _region(recording: Recording, sensor: Sensor, settings: ScanSettings) -> Region:
    if settings.box is not None:
        low, high = np.sort(np.array(settings.box, float), axis=0)
        return Region(low, high)
    if len(recording) < 3:
        raise RecordingError("too few frames for a turntable", recording.path, len(recording), "3 or more")
    depths = []
    for index in np.unique(np.linspace(0, len(recording) - 1, LOOKED_AT).round().astype(int)):
        try:
            depths.append(recording[int(index)].depth)
        except RecordingError:  # told when all frames are loaded
            continue
    if len(depths) < 3:
        raise RecordingError("too few frames can be read", recording.path, len(depths), "3 or more")
    camera = recording.camera
    moving = find_moving(np.stack(depths), camera, lambda z: np.asarray(sensor.sigma(z, None, camera), np.float32))
    return Region(moving.low, moving.high).grown(0.015)


def _load(
    recording: Recording, sensor: Sensor, region: Region, camera: Camera | None = None
) -> tuple[list[Prepared | None], dict[int, str]]:
    """All frames, corrected and cut to the window that shows the object; unreadable ones with the reason."""
    camera = camera or recording.camera
    window = region.window(camera)
    frames: list[Prepared | None] = []
    broken = {}
    for index in tqdm(range(len(recording)), desc="loading", unit="frame", disable=None):
        try:
            frame = recording[index]
        except RecordingError as error:
            frames.append(None)
            broken[index] = str(error)
            continue
        cut = replace(
            frame,
            depth=np.ascontiguousarray(frame.depth[window]),
            color=None if frame.color is None else np.ascontiguousarray(frame.color[window]),
            ir=None if frame.ir is None else np.ascontiguousarray(frame.ir[window]),
        )
        frames.append(prepare(cut, crop(camera, window), sensor))
    return frames, broken


def _commanded(recording: Recording, settings: ScanSettings) -> Array | None:
    """Table angles [rad] as told, or None."""
    if settings.step is not None:
        return np.arange(len(recording)) * settings.step
    if not settings.use_log:
        return None
    logged = recording.telemetry_at_frames("turntable_deg")
    if logged is None or np.ptp(logged) < 1.0:
        return None
    return np.asarray(np.unwrap(np.deg2rad(logged)))


def _motion(frames: list[Prepared | None], camera: Camera, region: Region, commanded: Array | None) -> Motion:
    views = [view(f.surface, region) if f is not None else _nothing(frames) for f in frames]
    return estimate_motion(views, region, commanded)


def _nothing(frames: list[Prepared | None]) -> View:
    first = next((f for f in frames if f is not None), None)
    if first is None:
        raise TrackingError("no frame of the recording can be read")
    none = np.zeros((0, 3), np.float32)
    return View(first.surface, none, none, np.zeros(0, np.float32))


def _finish(
    recording: Recording,
    settings: ScanSettings,
    sensor: Sensor,
    found: tuple[list[Prepared | None], Region, Motion, Array | None],
) -> Scan:
    """Volumes, trajectories, closure and warnings from a known motion."""
    frames, region, motion, commanded = found
    volume_settings = _volume_settings(settings, recording.camera, (frames, region, motion))
    corrected = _constrained(recording, motion)
    raw, residual, share, rough = _track_freely(frames, region, corrected, volume_settings)
    circle = fit_circle(raw.centres)
    if settings.strength == "circle":
        corrected, circle = onto_circle(raw, commanded)
    volume = Volume(volume_settings)
    for frame, T in zip(
        tqdm(frames, desc="integrating", unit="frame", disable=None), corrected.poses, strict=True
    ):  # fmt: skip
        if frame is not None and np.isfinite(T).all():
            fuse(volume, frame, T)
    steps = judge_steps(motion.angles, motion.angle_std, commanded)
    pair = closing_pair(motion.angles)
    direct = None if pair is None else _direct(frames, region, corrected, pair)
    gaps = [None if direct is None or pair is None else _gap(t, pair, direct, region) for t in (corrected, raw)]
    chosen: dict[str, Any] = {k: v for k, v in asdict(settings).items() if k not in ("sensor", "voxel", "truncation")}
    chosen |= {
        "sensor": sensor.name,
        "voxel_m": volume_settings.voxel,
        "truncation_m": volume_settings.truncation,
        "camera": {k: getattr(recording.camera, k) for k in ("fx", "fy", "cx", "cy", "distortion")},
        "region": {"low": region.low.tolist(), "high": region.high.tolist()},
        "volume_bytes": volume.bytes,
    }
    return Scan(
        _clean(volume.surface(), settings, motion), _clean(rough.surface(), settings, motion),
        corrected, raw, motion, steps, circle, gaps[0], gaps[1], residual, share, _wobble(raw, motion),
        recording.camera, chosen, _warnings(recording, sensor, settings, (motion, steps, raw)),
    )  # fmt: skip


def _volume_settings(
    settings: ScanSettings, camera: Camera, found: tuple[list[Prepared | None], Region, Motion]
) -> VolumeSettings:
    frames, region, motion = found
    shown = [f for f in frames if f is not None]
    inside = shown[0].surface.points[region.holds(shown[0].surface.points)]
    distance = float(np.median(inside[:, 2])) if len(inside) else float(np.linalg.norm(motion.axis.point))
    sigma = float(np.median([np.nanmedian(f.surface.sigma[region.holds(f.surface.points)]) for f in shown[:5]]))
    voxel = settings.voxel or choose_voxel(distance, camera)
    truncation = settings.truncation or choose_truncation(voxel, sigma)
    corners = np.stack(np.meshgrid(*zip(region.low, region.high, strict=True)), axis=-1).reshape(-1, 3)
    reach, height = motion.axis.distance(corners)
    # the box turns: what it can sweep is the cylinder around the axis, and no corner of it needs to be reached
    radius = float(np.percentile(reach, 60))
    bottom = float(height.min()) if motion.plate is None else motion.plate - 0.01
    low, high = (-radius, -radius, bottom), (radius, radius, float(height.max()) + 0.01)
    color = settings.color and any(f.frame.color is not None for f in shown)
    return VolumeSettings(voxel, truncation, color, (low, high))


def _constrained(recording: Recording, motion: Motion) -> Trajectory:
    """The camera in the object's frame: one axis, one angle per frame."""
    T_object_camera = motion.axis.object_frame()
    poses = np.full((len(recording), 4, 4), np.nan)
    for i, angle in enumerate(motion.angles):
        if np.isfinite(angle):
            poses[i] = T_object_camera @ motion.axis.turn(-float(angle))
    return Trajectory(recording.timestamps, poses)


def _track_freely(
    frames: list[Prepared | None], region: Region, start: Trajectory, volume_settings: VolumeSettings
) -> tuple[Trajectory, Array, Array, Volume]:
    """Every frame against the model so far, all six directions free; the joint fit only says where to look first."""
    poses = np.full_like(start.poses, np.nan)
    residual, share = np.full((2, len(frames)), np.nan)
    volume = Volume(volume_settings)
    last = -1
    for i, frame in enumerate(tqdm(frames, desc="tracking", unit="frame", disable=None)):
        if frame is None or not np.isfinite(start.poses[i]).all():
            continue
        T = start.poses[i]
        if last >= 0:
            T = poses[last] @ pose.inverse(start.poses[last]) @ start.poses[i]
            found = align(only(frame.surface, region), model(volume, frame.surface.camera, T), np.eye(4), TRACKING)
            residual[i], share[i] = found.residual, found.inlier_share
            if not found.ok:
                continue
            T = T @ found.T_model_source
        poses[i], last = T, i
        fuse(volume, frame, T)
    return Trajectory(start.timestamps, poses), residual, share, volume


def model(volume: Volume, camera: Camera, T_object_camera: Array) -> PointMap:
    """What a camera should see of the volume."""
    seen = volume.raycast(camera, T_object_camera)
    return PointMap(camera, seen.points, seen.normals, np.where(np.isfinite(seen.depth), np.float32(5e-4), np.nan))


def only(surface: PointMap, region: Region) -> PointMap:
    """A surface of which only the region takes part in alignment."""
    return replace(surface, normals=np.where(region.holds(surface.points)[..., None], surface.normals, np.nan))


def _direct(
    frames: list[Prepared | None], region: Region, guess: Trajectory, pair: tuple[int, int]
) -> Array | None:
    """`T_i_j` of two frames about a turn apart, aligned directly, no model and no axis between them."""
    first, second = frames[pair[0]], frames[pair[1]]
    if first is None or second is None or not np.isfinite(guess.poses[list(pair)]).all():
        return None
    T = pose.inverse(guess.poses[pair[0]]) @ guess.poses[pair[1]]
    found = align(only(second.surface, region), first.surface, T, TRACKING)
    return found.T_model_source if found.ok else None


def _gap(
    trajectory: Trajectory, pair: tuple[int, int], T_direct: Array, region: Region
) -> tuple[float, float] | None:
    """How far a trajectory is from the direct alignment: angle [rad], and shift of the object's middle [m]."""
    i, j = trajectory.poses[pair[0]], trajectory.poses[pair[1]]
    if not (np.isfinite(i).all() and np.isfinite(j).all()):
        return None
    T = pose.inverse(i) @ j
    middle = (region.low + region.high) / 2
    shift = pose.transform(T, middle) - pose.transform(T_direct, middle)
    return pose.angle(pose.inverse(T_direct) @ T), float(np.linalg.norm(shift))


def _wobble(raw: Trajectory, motion: Motion) -> float:
    """Root mean square tilt of the object's axis over the freely tracked poses [rad]."""
    ups = np.einsum("nij,j->ni", raw.poses[raw.valid][:, :3, :3], motion.axis.direction)
    mean = ups.mean(axis=0)
    tilt = np.arccos(np.clip(ups @ (mean / np.linalg.norm(mean)), -1, 1))
    return float(np.sqrt(np.mean(tilt**2)))


def _clean(mesh: Mesh, settings: ScanSettings, motion: Motion) -> Mesh:
    """The object alone: no plate, no flying parts, no small holes."""
    if motion.plate is not None and not settings.keep_plate:
        normals = mesh.normals if mesh.normals is not None else np.zeros_like(mesh.vertices)
        mesh = vertices_kept(mesh, above_plate(mesh.vertices, normals, CLEAR_OF_PLATE))
    if not len(mesh.faces):
        raise TrackingError("nothing is left of the object", do="pass --keep-plate, or give --box")
    mesh = largest_part(mesh)
    return fill_small_holes(mesh, settings.fill_holes) if settings.fill_holes > 0 else mesh


def _warnings(
    recording: Recording, sensor: Sensor, settings: ScanSettings, found: tuple[Motion, Steps, Trajectory]
) -> tuple[tuple[str, str], ...]:
    motion, steps, raw = found
    out = [("warning", text) for text in (*recording.warnings, *sensor.warnings, *sensor.left_out, *steps.warnings)]
    focal = float(np.expm1(motion.focal_check.values[0]))
    if abs(focal) > WRONG_FOCAL:
        right = recording.camera.fx * (1 + focal)
        out.append(
            (
                "bad",
                f"the object keeps its shape only if the focal length is {focal:+.1%} off: fx {right:.1f} px instead of "
                f"{recording.camera.fx:.1f} px; calibrate the camera or pass --refine-camera",
            )
        )
    if motion.plate is None:
        out.append(("warning", "no plate was seen: nothing was cut off below the object"))
    lost = int((np.isfinite(motion.angles) & ~raw.valid).sum())
    if lost:
        out.append(("warning", f"{lost} frames could not be tracked freely and stand by the axis alone"))
    out += [("warning", f"frame {frame}: {reason}") for frame, reason in list(motion.rejected.items())[:10]]
    return tuple(out)
