"""What do the frames show: an object or a room? Its distance chooses the voxels."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fusion.volume.prepared import Prepared

# [m] an object with its surroundings is smaller: a desk top seen from where one sits, and with the coarsest voxels of
# an object, 2 mm, a grid of 750 (guess; KinectFusion's was 512 over 3 m of a room)
ROOM = 1.5
MIDDLE = (10, 90)  # [%] of the points that say how large it is: a door to the next room does not
WIDTH = 160  # [px] shapes are looked at in images of about this width
FEWER = 3  # every so many pixels in both directions say what all would
JUMP = 0.06  # of the depth: between pixels of that width no surface up to 80 degrees from the front does that
SMALLEST = 0.02  # of the image: what stands free is at least that large (guess)
MOSTLY = 0.6  # of the frames show it so (guess)
ALIKE = 0.3  # by so much its distance may differ from frame to frame (guess)


@dataclass(frozen=True)
class Subject:
    """What is scanned."""

    room: bool  # True for a room, False for an object
    size: float  # largest side of what the frames show, in their own axes [m]
    distance: float  # median depth [m]
    sigma: float  # median noise there [m]
    # it stands free before its surroundings; the others' size, distance and noise are those of all that is seen
    free: bool

    @property
    def reason(self) -> str:
        """What it was judged by."""
        what = "what stands free in the foreground" if self.free else "what the frames show"
        return f"{what} is {self.size:.2f} m large, at {self.distance:.2f} m"


def subject_of(probes: Sequence[Prepared], room: bool | None = None) -> Subject:
    """Judge some frames of a recording.

    What stands free before the rest, away from the image's border and in most of the frames, is what is meant; else all
    that is seen is. It is a room when that is large.

    Args:
        room: what the user says it is; None judges.
    """
    known = [np.isfinite(p.depth) for p in probes]
    masks = [free_foreground(p.depth) for p in probes]
    found = [float(np.median(p.depth[mask])) for p, mask in zip(probes, masks, strict=True) if mask.any()]
    free = room is not True and len(found) >= MOSTLY * len(probes) and bool(np.ptp(found) < ALIKE * np.median(found))
    parts = masks if free else known
    step = FEWER if any(part[::FEWER, ::FEWER].any() for part in parts) else 1
    some = (slice(None, None, step), slice(None, None, step))
    shown = [
        (p.surface.points[some][part[some]], p.surface.sigma[some][part[some]])
        for p, part in zip(probes, parts, strict=True)
    ]
    points, sigma = (np.concatenate(values) for values in zip(*shown, strict=True))
    size = float(np.ptp(np.percentile(points, MIDDLE, axis=0), axis=0).max())
    large = size > ROOM if room is None else room
    return Subject(large, size, float(np.median(points[:, 2])), float(np.nanmedian(sigma)), free)


def free_foreground(depth: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Pixels (h, w) of the largest surface that ends inside the image and lies before what is around it.

    All False where there is none. A thing on a table is one surface with it and does not stand free.
    """
    step = max(1, depth.shape[1] // WIDTH)
    small = depth[::step, ::step]
    known = np.isfinite(small)
    filled = np.where(known, small, np.inf)
    near, far = ndimage.minimum_filter(filled, 3), ndimage.maximum_filter(np.where(known, small, 0), 3)
    labels, count = ndimage.label(known & (far - near < JUMP * filled))
    rim = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
    size = np.bincount(labels.ravel(), minlength=count + 1)
    size[rim] = 0
    size[0] = 0
    best = int(np.argmax(size))
    free = labels == best
    if size[best] < SMALLEST * small.size or not _in_front(small, known, free):
        return np.zeros(depth.shape, bool)
    return np.kron(free, np.ones((step, step), bool))[: depth.shape[0], : depth.shape[1]] & np.isfinite(depth)


def _in_front(depth: NDArray[np.floating], known: NDArray[np.bool_], part: NDArray[np.bool_]) -> bool:
    """True when what is seen around a part lies behind it, and little of all else nearer."""
    around = ndimage.binary_dilation(part, iterations=5) & ~ndimage.binary_dilation(part, iterations=2) & known
    behind = float((depth[around] > (1 + JUMP) * np.median(depth[part])).mean()) if around.any() else 1.0
    rest = known & ~part
    nearer = float((depth[rest] < np.median(depth[part])).mean()) if rest.any() else 0.0
    return behind > 0.7 and nearer < 0.1
