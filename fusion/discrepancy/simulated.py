"""Simulated recordings in place of the prediction: matched frame by frame, and seen as views from their depth."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from fusion.calibration.series import PixelSeries
from fusion.errors import RecordingError
from fusion.recording.recording import Recording
from fusion.sensor.correction.estimate import estimated_view
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View, incidence_of

SMOOTH_PX = 7  # over which a simulated depth that has noise is smoothed before it gets normals
SAME_SHARE = 1e-3  # of the depth: frames whose parts agree so well show one scene from one pose
PARTS = 6  # of the image, in each direction
SAME_CAMERA = 0.02  # relative difference of focal lengths, beyond which it is another camera


@dataclass(frozen=True)
class GivenImages:
    """The images of a simulation for the frames of one block.

    The sensor model that goes with it counts as in the images: what is added to the model later changes them.
    """

    model: Sensor  # that sensor model
    offset: Image  # (h, w) [m] what the simulation predicts beyond the model's mean for the simulated depth
    doubt: Image  # (h, w) [m] standard deviation of the simulated mean: its own noise, averaged over its frames
    lost: Image  # (h, w) share of its frames without a value
    # (h, w) [m] standard deviation of a frame where the model has no noise; None where it has
    spread: Image | None = None


@dataclass(frozen=True)
class Match:
    """A recording and the simulation of it."""

    # recording, simulated: both
    recording: Recording
    simulated: Recording
    partner: NDArray[np.intp]  # (n,) frame of the simulation for every frame of the recording, -1 where there is none

    def depths(self, frames: Sequence[int]) -> list[Image]:
        """Simulated depth of some frames of the recording."""
        return [self.simulated[int(self.partner[i])].depth for i in frames]

    def same(self, one: int, other: int) -> bool:
        """True when the simulation shows one scene from one pose in two frames."""
        first, second = (np.asarray(depth, float) for depth in self.depths((one, other)))
        with np.errstate(all="ignore"):
            change = second / first - 1.0
        height, width = change.shape
        for rows in np.array_split(np.arange(height), PARTS):
            for columns in np.array_split(np.arange(width), PARTS):
                part = change[np.ix_(rows, columns)]
                known = part[np.isfinite(part)]
                # the mean of many noisy pixels, and not their scatter
                if len(known) > 20 and abs(float(np.median(known))) > SAME_SHARE + 3 * known.std() / len(known) ** 0.5:
                    return False
        return True


def matched(recordings: Sequence[Recording], simulated: Sequence[Recording]) -> list[Match]:
    """Recordings with their simulations, in the order given.

    Raises:
        RecordingError: their number, cameras or frames do not fit.
    """
    if len(recordings) != len(simulated):
        raise RecordingError(
            "every recording needs a simulated one",
            simulated[0].path if simulated else None,
            f"{len(simulated)} simulated, {len(recordings)} recorded",
            "as many of both, in the same order",
        )
    return [_matched(one, other) for one, other in zip(recordings, simulated, strict=True)]


def _matched(recording: Recording, simulated: Recording) -> Match:
    a, b = recording.camera, simulated.camera
    if a.shape != b.shape or abs(a.fx / b.fx - 1) > SAME_CAMERA or abs(a.fy / b.fy - 1) > SAME_CAMERA:
        raise RecordingError(
            "the simulation is not of the recording's camera",
            simulated.path,
            f"{b.width} x {b.height} px, fx {b.fx:.1f} px",
            f"{a.width} x {a.height} px, fx {a.fx:.1f} px",
            "simulate with the recording's camera.json",
        )
    if len(recording) == len(simulated):
        return Match(recording, simulated, np.arange(len(recording)))
    stamps, theirs = np.asarray(recording.timestamps, float), np.asarray(simulated.timestamps, float)
    nearest = np.abs(stamps[:, None] - theirs[None]).argmin(axis=1)
    gap = float(np.median(np.diff(np.unique(stamps)))) if len(stamps) > 1 else 0.02
    partner = np.where(np.abs(theirs[nearest] - stamps) <= 0.5 * gap, nearest, -1)
    if np.mean(partner >= 0) < 0.5:
        raise RecordingError(
            "the frames of the simulation do not fit those of the recording",
            simulated.path,
            f"{len(simulated)} frames, {int((partner >= 0).sum())} at a time stamp of the {len(recording)} recorded",
            "as many frames, or the same time stamps",
        )
    return Match(recording, simulated, partner)


def seen_in(match: Match, frames: Sequence[int], sensor: Sensor) -> tuple[View, GivenImages]:
    """What stood before the camera, and what is predicted, as the simulation has it."""
    series = PixelSeries(match.simulated.camera.shape)
    for depth in match.depths(frames):
        series.add(depth)
    depth = np.asarray(series.mean, np.float32)
    ir = match.simulated[int(match.partner[frames[0]])].ir
    projector = sensor.baseline if sensor.principle.triangulates else None
    amplitude = None if ir is None else np.asarray(ir, np.float32)
    view = estimated_view(depth, match.recording.camera, amplitude, projector=projector)
    single = np.nan_to_num(series.std)
    if np.any(single > 0) or len(frames) == 1:
        view = _smooth(view, depth)
    mean, sigma = sensor.repeated(depth, view)
    spread = None if np.nanmax(np.nan_to_num(sigma)) > 0 else single
    doubt = single / np.sqrt(np.maximum(series.count, 1))
    return view, GivenImages(sensor, depth - mean, doubt, 1.0 - series.valid, spread)


def _smooth(view: View, depth: Image) -> View:
    """The view with normals of a smoothed depth: noise would tilt them; on a plane the inverse depth is linear."""
    known = np.isfinite(depth)
    with np.errstate(all="ignore"):
        inverse = np.where(known, 1.0 / depth, 0.0).astype(float)
        near = uniform_filter(known.astype(float), SMOOTH_PX)
        smoothed = np.where(known, near / uniform_filter(inverse, SMOOTH_PX), np.nan).astype(np.float32)
        normals = estimated_view(smoothed, view.camera).normals
    assert normals is not None
    return replace(view, normals=normals, incidence=incidence_of(normals, view.camera))
