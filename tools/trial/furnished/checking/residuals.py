"""What a case's images leave beside the mesh: noise as told, poses as told, and the change that the answer expects."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import maximum_filter

from tools.trial.furnished.checking.reading import Array, Parameters, ReadCase, ReadFrame, ReadRecording

BEYOND = 5  # standard deviations, above which a residual is no noise


@dataclass
class Gathered:
    """Of all groups of frames that share a pose; lists of one number each unless said otherwise.

    Attributes:
        mean, square, beyond: of residuals over their noise, poses fitted.
        temporal: variance of pixels over frames, over that told.
        pose, pose_expected: squares of fitted errors of poses over those told, and what is to be expected.
        valid: shares of pixels that have a depth.
        slope, weight: of the change measured along the expected one, poses fitted beside it, and its weight.
        raw: sums of products of expected change with residual, and with itself; poses not fitted.
        large: (n,) measured over expected change, where this is well above the noise.
    """

    mean: list[float] = field(default_factory=list)
    square: list[float] = field(default_factory=list)
    beyond: list[float] = field(default_factory=list)
    temporal: list[float] = field(default_factory=list)
    pose: list[float] = field(default_factory=list)
    pose_expected: list[float] = field(default_factory=list)
    valid: list[float] = field(default_factory=list)
    slope: list[float] = field(default_factory=list)
    weight: list[float] = field(default_factory=list)
    raw: list[tuple[float, float]] = field(default_factory=list)
    large: list[Array] = field(default_factory=list)


def gathered(case: ReadCase, shifts: dict[str, Array] | None) -> Gathered:
    """`shifts`: (frames or 1, h, w) [m] expected change by recording, s0, s1, ..., None where nothing is concealed."""
    out = Gathered()
    lengths = (case.told.get(name, {}).get("correlation_px", 0) for name in ("axial_noise", "speckle_noise"))
    alike = max(1.0, np.sqrt(np.pi) * max(lengths))  # root of how many pixels share their noise
    for recording in case.recordings:
        shift = None if shifts is None else shifts[f"s{int(recording.name[4:])}"]
        moving = len({tuple(frame.T.ravel()) for frame in recording.frames}) > 1
        groups = [[frame] for frame in recording.frames] if moving else [recording.frames]
        first = 0
        for group in groups:
            expected = None if shift is None else _of(shift, first, len(group))
            _gather(out, case.told, recording, group, expected, float(alike))
            first += len(group)
    return out


def _of(shift: Array, first: int, frames: int) -> Array:
    return shift[0] if len(shift) == 1 else np.asarray(np.mean(shift[first : first + frames], 0))


def _gather(
    out: Gathered,
    told: Parameters,
    recording: ReadRecording,
    group: Sequence[ReadFrame],
    change: Array | None,
    alike: float,
) -> None:
    first, depths = group[0], np.array([frame.z for frame in group])
    lit = None if first.ir is None else np.mean([frame.ir for frame in group if frame.ir is not None], 0)
    sigma, still = _sigma(told, recording, first, lit)
    residual = np.nanmean(depths, 0) - first.expected if len(group) > 1 else depths[0] - first.expected
    away = ~_edges(first.expected)
    seen = np.isfinite(first.expected) & away
    out.valid.append((np.isfinite(depths) & seen).sum() / max(1, seen.sum() * len(group)))
    slope = (first.normal * recording.direction).sum(-1)
    good = np.isfinite(depths).all(0) & np.isfinite(residual) & away & np.isfinite(sigma)
    good &= np.abs(slope) / recording.stretch > 0.2
    if change is not None:
        large = (np.abs(change) > np.maximum(8 * sigma, 0.015)) & np.isfinite(residual) & np.isfinite(change)
        out.large.append(residual[large] / change[large])
    if good.sum() < (20 if depths.shape[2] > 8 else 9):
        return
    if len(group) > 1:
        out.temporal.append(float((np.nanvar(depths, axis=0, ddof=1)[good] / sigma[good] ** 2).mean()))
    turned = first.expected[..., None] * np.cross(recording.direction, first.normal)
    by_pose = -np.concatenate([first.normal, turned], -1) / slope[..., None]
    weight = 1 / np.sqrt(sigma**2 / len(group) + still**2)[good]
    scaled, columns = residual[good] * weight, by_pose[good] * weight[:, None]
    _fit_pose(out, scaled, columns, recording.pose_sigma, alike)
    if change is not None:
        known = np.isfinite(change[good]) & (np.abs(residual[good]) < 0.5)
        wanted = (np.nan_to_num(change[good]) * weight)[known]
        out.raw.append((float(wanted @ scaled[known]), float(wanted @ wanted)))
        if ((np.nan_to_num(change[good]) * weight) ** 2).sum() > 25:
            _fit_change(out, scaled[known], wanted, columns[known], recording.pose_sigma)


def _fit_pose(out: Gathered, scaled: Array, columns: Array, pose_sigma: Array, alike: float) -> None:
    """Fits the pose's error, with four times the errors told as its prior."""
    prior = np.diag(1 / pose_sigma / 4)
    stacked = np.r_[columns / alike, prior]
    error = np.linalg.lstsq(stacked, np.r_[scaled / alike, np.zeros(6)], rcond=None)[0]
    left = scaled - columns @ error
    core = np.abs(left) < BEYOND
    out.beyond.append(float((np.abs(left) > BEYOND).mean()))
    out.square.append(float((left[core] ** 2).mean()))
    out.mean.append(float(left[core].mean()))
    out.pose.append(float(np.mean((error / pose_sigma) ** 2)))
    normal = columns.T @ columns / alike**2
    inverse = np.linalg.inv(normal + np.diag(1 / pose_sigma**2 / 16))
    spread = inverse @ (normal + normal @ np.diag(pose_sigma**2) @ normal) @ inverse
    out.pose_expected.append(float(np.mean(np.diag(spread) / pose_sigma**2)))


def _fit_change(out: Gathered, scaled: Array, wanted: Array, columns: Array, pose_sigma: Array) -> None:
    """How much of the expected change is there, beside an error of the pose."""
    both = np.c_[wanted, columns]
    inverse = np.linalg.pinv(both.T @ both + np.diag(np.r_[1e-9, 1 / pose_sigma**2 / 4]))
    out.slope.append(float((inverse @ (both.T @ scaled))[0]))
    out.weight.append(1 / max(float(inverse[0, 0]), 1e-12))


def _sigma(told: Parameters, recording: ReadRecording, frame: ReadFrame, lit: Array | None) -> tuple[Array, Array]:
    """(h, w) [m] noise of one frame as told, rounding included; (h, w) [m] noise that stands still."""
    noise, steps = told.get("axial_noise", {}), told.get("depth_quantization", {})
    rounding = 1 / recording.camera["depth_scale"] ** 2 / 12
    if "step" in steps:
        rounding = max(rounding, steps["step"] ** 2 / 12)
    if "shot" in noise:
        assert lit is not None
        weak = noise["ir_reference"] / np.maximum(lit, 1)
        square = (noise["shot"] ** 2 * weak + noise["floor"] ** 2 * weak**2) / recording.stretch**2
        return np.sqrt(square + rounding), np.zeros(square.shape)
    metres = frame.expected**2 / (recording.camera["fx"] * abs(told["projector_shadow"]["baseline"]))
    square = metres**2 * (noise["sigma_px"] ** 2 + steps.get("step_px", 0) ** 2 / 12)
    return np.sqrt(square + rounding), metres * told.get("speckle_noise", {}).get("sigma_px", 0)


def _edges(z: Array) -> Array:
    """(h, w) whether depth jumps within a few pixels; fewer in small images."""
    width = z.shape[1]
    radius = 3 if width > 32 else 1 if width > 8 else 0
    wide = np.pad(np.nan_to_num(z), 1, mode="reflect", reflect_type="odd")
    middle = wide[1:-1, 1:-1]
    across = np.abs(wide[1:-1, :-2] - 2 * middle + wide[1:-1, 2:])
    down = np.abs(wide[:-2, 1:-1] - 2 * middle + wide[2:, 1:-1])
    jumps = np.maximum(across, down) > 0.015 * middle
    return np.asarray(maximum_filter(jumps.astype(np.uint8), 2 * radius + 1) > 0)
