"""Poses of a target: each still part of a recording becomes one, with its noise freed from what is known already."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.repeats import whole_step, without_rounding
from fusion.calibration.noise.still import still_parts
from fusion.calibration.noise.target_noise import TargetNoise, measure_target
from fusion.errors import FusionError, RecordingError
from fusion.geometry.camera import Camera
from fusion.progress import each
from fusion.recording.native.scene_file import stated_scene
from fusion.recording.readable import moving_notes, readable, unread_text
from fusion.recording.recording import Recording
from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View, stretch

FITTED = ("axial_noise", "lateral_noise")  # what this calibration finds itself
IR_FRAMES = 10  # frames whose infrared images are read: the mean amplitude is known well soon


@dataclass(frozen=True)
class Pose:
    """A target that stood still."""

    name: str  # of the recording, with the frames when it has several poses
    seen: TargetNoise  # as it was measured
    depth: float  # of the target's middle [m], known errors taken out
    tilt: float  # of the target there [rad]
    # axial, axial_std: noise [m] without the rounding and without the noise that the sensor model knows; NaN without
    # values
    axial: float
    axial_std: float
    step: float = 0.0  # of the rounding [m]
    ir: float = float("nan")  # amplitude at the middle [count], NaN when there is no infrared image
    stretch: float = 1.0  # length of the middle's ray per metre of depth [1]
    lux: float = float("nan")  # light that the recording states, NaN when it does not
    shadowed: tuple[bool, bool] = (False, False)  # whether the left and the right edge lie beside a shadow


def read_poses(recordings: Sequence[Recording], camera: Camera, known: Sensor) -> tuple[list[Pose], list[str]]:
    """The poses of all recordings, and in words what was left out.

    Args:
        known: what is known of the sensor; its depth errors are undone before a target's distance and tilt are read.
    Raises:
        FusionError: not one pose shows a target.
    """
    poses: list[Pose] = []
    lost: list[FusionError] = []
    notes: list[str] = []
    for recording in each(recordings, "measuring"):
        try:
            parts = still_parts(recording)
            if not parts:
                raise RecordingError(
                    "the target never stands still", recording.path, expected="10 or more still frames at each pose"
                )
        except FusionError as error:
            lost.append(error)
            continue
        notes += [f"{recording.path.name}: {text}" for _, text in moving_notes([recording], sum(map(len, parts)))]
        for part in parts:
            name = recording.path.name
            name = name if len(parts) == 1 else f"{name} {part.start}-{part.stop - 1}"
            unread: dict[int, str] = {}
            try:
                poses.append(_pose(recording, part, name, camera, known, unread))
            except FusionError as error:
                lost.append(FusionError(error.what, name, error.found, error.expected, error.do))
            else:
                notes += [f"{name}: {text}"] if (text := _swaying(poses[-1].seen)) else []
            notes += [f"{name}: {unread_text(unread)}"] if unread else []
    if not poses:
        if lost:
            raise lost[0]
        raise FusionError("no recording of a target", found=0, expected="a flat target at several distances and tilts")
    return poses, [*(f"left out: {error}" for error in lost), *notes]


def pose_of(
    seen: TargetNoise, name: str, camera: Camera, known: Sensor, told: tuple[float, float] = (float("nan"),) * 2
) -> Pose:
    """A pose from its measurement; `told`: amplitude at the middle [count] and light [lux], NaN when not known."""
    v, u = seen.pixel
    ir, lux = told
    view = _view(seen, camera, ir)
    step = seen.step
    rounding = known.effect("depth_quantization")
    if isinstance(rounding, DepthQuantization):
        assert view.depth is not None
        level = np.broadcast_to(rounding.noise(view.depth, known.seen(view)), view.depth.shape)[0, 0]
        step = max(float(level) * 12**0.5, seen.step)
    count = 1.0 / camera.depth_scale
    step = whole_step(step, count) if seen.step > 0 else step
    z = seen.depth
    # how far the plane rises over the patch, of which the phase of the rounding is averaged
    columns = seen.middle[1] if seen.middle else np.zeros(1)
    wide = float(np.ptp(columns) + 1)
    span = z / camera.fx * float(np.tan(min(seen.tilt, 1.5))) * wide
    sigma, deviation = without_rounding(seen.axial, seen.axial_std, step, span, wide)
    other = _known_noise(known, view, seen.pixel)
    if other > 0:
        below = max(sigma**2 - other**2, 0.0) ** 0.5
        deviation = sigma * deviation / max(below, deviation) if sigma > 0 else deviation
        sigma = below
    return Pose(name, seen, z, seen.tilt, sigma, deviation, step, ir, float(stretch(camera)[v, u]), lux,
                _shadowed(seen, known, camera))  # fmt: skip


def _pose(recording: Recording, part: range, name: str, camera: Camera, known: Sensor, unread: dict[int, str]) -> Pose:
    """Measure one part of a recording; see `readable` for `unread`."""
    frames = _Depths(recording, part, unread)
    clean = replace(known, effects=tuple(e for e in known.effects if e.name not in FITTED), left_out=())
    ir = _mean_ir(recording, part)

    def correct(mean: NDArray[np.floating]) -> NDArray[np.floating]:
        return clean.correct(mean, View(camera, mean, ir=None if ir is None else np.nan_to_num(ir)))

    seen = measure_target(frames, camera, correct=correct if clean.effects else None)
    amplitude = float("nan") if ir is None else float(np.nanmean(ir[seen.middle]))
    light = recording.telemetry_at_frames("ambient_lux")
    lux = float(np.mean(light[part.start : part.stop])) if light is not None else _stated_lux(recording)
    return pose_of(seen, name, camera, known, (amplitude, lux))


def _swaying(seen: TargetNoise) -> str:
    """What is said of a camera or target that moved, or of frames that jump as a whole; else nothing."""
    if seen.shared is None or not seen.shared.told:
        return ""
    away = f", as the depth drifts by {seen.shared.slope * seen.shared.frames * 1e3:+.1f} mm" * seen.shared.steady
    text = f"{seen.shared.text('the target')}{away}: a rig that moves does that"
    return f"{text}, and the laws are without it; record a still scene"


class _Depths:
    """The depth images of a part, read anew at each walk; unreadable frames are left out."""

    def __init__(self, recording: Recording, part: range, unread: dict[int, str]) -> None:
        self.recording, self.part, self.unread = recording, part, unread

    def __iter__(self) -> Iterator[NDArray[np.floating]]:
        return (frame.depth for frame in readable(self.recording, self.part, self.unread))


def _mean_ir(recording: Recording, part: range) -> NDArray[np.floating] | None:
    """(h, w) mean amplitude of some frames [count]; None without infrared images of the depth's size."""
    some = part[:: max(len(part) // IR_FRAMES, 1)]
    images = [frame.ir for frame in readable(recording, some, {}) if frame.ir is not None]
    if not images or images[0].shape != recording.camera.shape:
        return None
    return np.asarray(np.mean(images, axis=0))


def _stated_lux(recording: Recording) -> float:
    value = stated_scene(recording).ambient_lux
    return float("nan") if value is None else value


def _view(seen: TargetNoise, camera: Camera, ir: float) -> View:
    """What one pixel, the target's middle, looks at."""
    v, u = seen.pixel
    pixel = replace(camera, width=1, height=1, cx=camera.cx - u, cy=camera.cy - v)
    depth, tilt = np.full((1, 1), seen.depth), np.full((1, 1), seen.tilt)
    light = None if not np.isfinite(ir) else np.full((1, 1), ir)
    return View(pixel, depth, tilt, ir=light)


def _known_noise(known: Sensor, view: View, pixel: tuple[int, int]) -> float:
    """Noise [m] of the model's other effects there."""
    others = tuple(
        _at(e, pixel)
        for e in known.effects
        if e.name not in (*FITTED, "depth_quantization") and e.changes("noise") and not e.frozen
    )
    if not others:
        return 0.0
    assert view.depth is not None
    rest = replace(known, effects=others, left_out=())
    with np.errstate(all="ignore"):
        sigma = float(rest.repeated(view.depth, view)[1][0, 0])
    return sigma if np.isfinite(sigma) else 0.0


def _at(effect: Effect, pixel: tuple[int, int]) -> Effect:
    """An effect with the numbers of one pixel in place of maps."""
    maps: dict[str, Any] = {
        name: float(np.asarray(getattr(effect, name))[pixel])
        for name, about in parameters(effect).items()
        if about.kind in ("number", "map") and np.ndim(getattr(effect, name)) == 2
    }
    return replace(effect, **maps) if maps else effect


def _shadowed(seen: TargetNoise, known: Sensor, camera: Camera) -> tuple[bool, bool]:
    """Which edges lie beside a shadow: for triangulation those away from the projector, else those beside no depth.

    A target with nothing behind it has no depth on both sides, and no shadow.
    """
    left, right = seen.nothing_behind
    if known.principle.or_else(camera.principle).triangulates:
        return (known.baseline > 0, known.baseline < 0)
    return (left and not right, right and not left)
