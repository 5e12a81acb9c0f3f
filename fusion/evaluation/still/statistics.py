"""Statistics of one still stretch: its frames pass by once, and the memory does not depend on their number."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.series import PixelSeries
from fusion.calibration.shared_noise import centre_of
from fusion.calibration.stretches import Stretch
from fusion.errors import FusionError, RecordingError
from fusion.evaluation.still.reference import Reference, reference_of
from fusion.evaluation.still.robust import RobustSpread
from fusion.progress import stage
from fusion.recording.looking.sample import spread
from fusion.recording.recording import Frame

KEPT = 32  # frames in memory, for the reference
READERS = 2  # images are decoded outside Python's lock
DISTURBED = 0.005  # share of the image that moves: more is a disturbed frame

Image = NDArray[np.floating]


@dataclass(frozen=True)
class StretchSample:
    """Some frames of a stretch, evenly spread, and what they usually see."""

    stretch: Stretch
    frames: dict[int, Frame]
    reference: Reference
    limit: NDArray[np.float32]

    def quiet(self) -> list[NDArray[np.float32]]:
        """Depth images (h, w) [m] of the sample, NaN where something moves."""
        out = []
        for frame in self.frames.values():
            moving = self.reference.moving(frame.depth, self.limit)
            out.append(np.where(moving, np.float32(np.nan), frame.depth))
        return out


@dataclass(frozen=True)
class Still:
    """What the n frames of a stretch say about every pixel and about the centre."""

    # depth, ir, color: statistics per pixel [m], [count], [count] (h, w, 3); None where nothing was recorded
    depth: PixelSeries
    ir: PixelSeries | None
    color: PixelSeries | None
    robust: NDArray[np.floating]  # (h, w) 1.4826 times the median absolute deviation of the depth [m]
    outliers: NDArray[np.int32]  # (h, w) frames whose depth is far from what is expected there, moving things left out
    moved: NDArray[np.int32]  # (h, w) frames in which something moves there
    time: NDArray[np.floating]  # (n,) since the first frame [s]
    centre: NDArray[np.floating]  # (n,) mean depth of the centre less the reference [m], NaN where it has none
    moving: NDArray[np.floating]  # (n,) share of the image that moves
    pixel: tuple[int, int]  # (v, u) of the single series
    series: NDArray[np.floating]  # (n,) depth of that pixel [m]
    levels: NDArray[np.int64]  # (65536,) how often each depth occurs in the frames of the sample, as counts of the file
    failures: dict[int, str] = field(default_factory=dict)  # frames that could not be read

    @property
    def frames(self) -> int:
        """Frames that could be read."""
        return len(self.time)

    @property
    def disturbed(self) -> NDArray[np.intp]:
        """Frames in which something moves, by their number among those read."""
        return np.flatnonzero(self.moving > DISTURBED)


def sample_of(stretch: Stretch) -> StretchSample:
    """Load the sample of a stretch. RecordingError when no frame can be read."""
    indices = [stretch.frames[0] + i for i in spread(len(stretch), KEPT)]
    with ThreadPoolExecutor(READERS) as pool:
        found = list(pool.map(partial(_load, stretch), indices))
    # one broken file is no reason to lose the others
    frames = {i: frame for i, frame in zip(indices, found, strict=True) if isinstance(frame, Frame)}
    if not frames:
        raise next(error for error in found if isinstance(error, RecordingError))
    reference = reference_of([frame.depth for frame in frames.values()])
    return StretchSample(stretch, frames, reference, reference.limit())


def _load(stretch: Stretch, index: int) -> Frame | RecordingError:
    try:
        return stretch.recording[index]
    except RecordingError as error:
        return error


def measure_still(sample: StretchSample, expected: Image, pixel: tuple[int, int]) -> Still:
    """Let all frames of a stretch pass by.

    Args:
        expected: (h, w) depth of the surface [m]; outliers are counted where it is known.
        pixel: (v, u) whose series is kept.
    Raises:
        FusionError: the pixel is not in the image.
    """
    camera = sample.stretch.recording.camera
    if not (0 <= pixel[0] < camera.height and 0 <= pixel[1] < camera.width):
        size = f"0 to {camera.width - 1} and 0 to {camera.height - 1}"
        raise FusionError("the pixel is not in the image", "--pixel", f"{pixel[1]} {pixel[0]}", f"u, v in {size}")
    adding = _Adding(sample, np.asarray(expected, np.float32), pixel)
    for frame in _frames(sample, adding.failures):
        adding.add(frame)
    return adding.done()


class _Adding:
    """The running sums of a stretch."""

    def __init__(self, sample: StretchSample, expected: NDArray[np.float32], pixel: tuple[int, int]) -> None:
        camera = sample.stretch.recording.camera
        self.sample, self.expected, self.pixel = sample, expected, pixel
        self.scale = camera.depth_scale
        self.centre = centre_of(camera.shape)
        self.depth = PixelSeries(camera.shape)
        self.spread = RobustSpread(sample.reference)
        self.ir: PixelSeries | None = None
        self.color: PixelSeries | None = None
        self.outliers, self.moved = np.zeros(camera.shape, np.int32), np.zeros(camera.shape, np.int32)
        self.levels = np.zeros(65536, np.int64)
        self.rows: list[tuple[float, float, float, float]] = []
        self.failures: dict[int, str] = {}

    def add(self, frame: Frame) -> None:
        """One more frame."""
        moving = self.sample.reference.moving(frame.depth, self.sample.limit)
        depth = frame.depth
        if moving.any():
            depth = np.where(moving, np.float32(np.nan), depth)
            self.moved += moving
        self.spread.add(depth)
        with np.errstate(invalid="ignore"):
            outliers = np.abs(depth - self.expected) > self.sample.limit
        good = depth
        if outliers.any():
            good = np.where(outliers, np.float32(np.nan), depth)
            self.outliers += outliers
        self.depth.add(good)
        self._light(frame, moving)
        if frame.index in self.sample.frames:
            counts = np.rint(np.nan_to_num(frame.depth) * np.float32(self.scale))
            self.levels += np.bincount(np.minimum(counts, 65535).astype(np.uint16).ravel(), minlength=65536)
        off = good[self.centre] - self.sample.reference.depth[self.centre]
        off = off[np.isfinite(off)]
        v, u = self.pixel
        self.rows.append(
            (frame.timestamp, float(off.mean()) if off.size else np.nan, float(moving.mean()), float(depth[v, u]))
        )

    def _light(self, frame: Frame, moving: NDArray[np.bool_]) -> None:
        if frame.ir is not None:
            self.ir = self.ir or PixelSeries(frame.ir.shape)
            # zero is what cameras write where they have no value
            self.ir.add(_without(frame.ir, moving | (frame.ir == 0)))
        if frame.color is not None:
            self.color = self.color or PixelSeries(frame.color.shape)
            red, green, blue = (frame.color[..., c] for c in range(3))
            self.color.add(_without(frame.color, moving | ((red | green | blue) == 0)))

    def done(self) -> Still:
        """The statistics."""
        time, centre, moving, series = np.array(self.rows, float).reshape(-1, 4).T
        return Still(
            self.depth,
            self.ir,
            self.color,
            self.spread.std,
            self.outliers,
            self.moved,
            time - time[0],
            centre,
            moving,
            self.pixel,
            series,
            self.levels,
            self.failures,
        )


def _without(image: NDArray, unusable: NDArray[np.bool_]) -> NDArray[np.float32]:
    """The image with NaN where it cannot be used."""
    out = image.astype(np.float32)
    if unusable.any():
        out[unusable] = np.nan
    return out


def _frames(sample: StretchSample, failures: dict[int, str]) -> Iterator[Frame]:
    """All frames in order, read some ahead; those of the sample are not read again."""
    stretch = sample.stretch

    def load(index: int) -> Frame | RecordingError:
        return sample.frames.get(index) or _load(stretch, index)

    indices = iter(range(*stretch.frames))
    with ThreadPoolExecutor(READERS) as pool, stage(stretch.name, len(stretch)) as step:
        ahead = [(i, pool.submit(load, i)) for i in islice(indices, 2 * READERS)]
        while ahead:
            index, future = ahead.pop(0)
            ahead += [(i, pool.submit(load, i)) for i in islice(indices, 1)]
            found = future.result()
            step()
            if isinstance(found, RecordingError):
                failures[index] = str(found)
            else:
                yield found
