"""Whether single frames see what the finished model says they should: doubled and displaced surfaces show here.

The residuals of a fit say little of a wrong model: what does not fit takes no part in them. Here every pixel of a frame
is asked: does it see the surface where the model has it, something before it, or through it to what is behind?
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.turntable.motion import Motion
from fusion.turntable.pairs.edges import CLEAR
from fusion.volume.beside import STEEPEST, beside
from fusion.volume.prepared import Prepared
from fusion.volume.volume import Volume

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
FRAMES = 16  # evenly from the scan: more say nothing new
TILE = 9  # [px] over which noise averages out


@dataclass(frozen=True)
class Agreement:
    """What the pixels of k frames say of the model; shares of the pixels that can say something."""

    frames: NDArray[np.intp]  # (k,) their indices
    before: Array  # (k,) seen before the model
    through: Array  # (k,) seen through the model: it stands where the frame looks past
    missing: Array  # (k,) seen on the object where the model has nothing
    # root mean square over tiles of a frame of how far it lies off the model, noise averaged out [m]; what is farther
    # off than the truncation is another surface, as of a hand
    bent: float

    @property
    def against(self) -> float:
        """Median over the frames of the share of pixels that contradict the model."""
        return float(np.median(self.before + self.through + self.missing)) if len(self.frames) else float("nan")

    def values(self) -> dict[str, float | None]:
        """Plain values for JSON, means over the frames but for `against`; None where no frame has a place."""
        if not len(self.frames):
            return dict.fromkeys(("against", "before", "through", "missing", "bent_m"))
        shares = {name: float(np.mean(getattr(self, name))) for name in ("before", "through", "missing")}
        return {"against": self.against, **shares, "bent_m": self.bent}


@dataclass(frozen=True)
class _Shares:
    """Of one frame: as in `Agreement`; the means of its tiles (t,) [m]."""

    before: float
    through: float
    missing: float
    tiles: Array


def agreement(volume: Volume, frames: list[Prepared | None], T_object_camera: Array, motion: Motion) -> Agreement:
    """Compare frames with the model that all of them made.

    Args:
        volume: the model, in the object's frame.
        frames: (n) cut to the object's window.
        T_object_camera: (n, 4, 4), NaN where a frame has no place.
        motion: says where what turns ends.
    """
    placed = [i for i, f in enumerate(frames) if f is not None and np.isfinite(T_object_camera[i]).all()]
    if not placed:
        none = np.empty(0)
        return Agreement(np.empty(0, int), none, none, none, float("nan"))
    some = np.array(placed)[np.unique(np.linspace(0, len(placed) - 1, FRAMES).round().astype(int))]
    found = [_shares(volume, frame, T_object_camera[i], motion) for i in some if (frame := frames[i])]
    tiles = np.concatenate([f.tiles for f in found])
    return Agreement(
        some,
        np.array([f.before for f in found]),
        np.array([f.through for f in found]),
        np.array([f.missing for f in found]),
        float(np.sqrt(np.mean(tiles**2))) if len(tiles) else float("nan"),
    )


def _shares(volume: Volume, frame: Prepared, T: Array, motion: Motion) -> _Shares:
    surface, found = frame.surface, beside(volume, frame, T)
    assert surface.incidence is not None
    off, limit, seen = found.off, found.limit, found.seen
    on_object = _turning(surface.points, T, motion)
    shown = found.shown & _turning(seen.points, T, motion)
    missing = found.calm & on_object & ~np.isfinite(seen.depth) & (surface.incidence < STEEPEST)
    count = max(1, int((shown | missing).sum()))
    return _Shares(
        float((shown & on_object & (off < -limit)).sum() / count),
        float((shown & (off > limit)).sum() / count),
        float(missing.sum() / count),
        _tiles(np.where(shown & (np.abs(off) < volume.settings.truncation), off * found.facing, np.nan)),
    )


def _turning(points: NDArray[np.float32], T: Array, motion: Motion) -> Mask:
    """(h, w) bool: points (h, w, 3) seen by a camera at T (4, 4) above the plate, within what turns."""
    at = pose.transform(T, points.astype(float))
    floor = motion.bottom if motion.plate is None else motion.plate + CLEAR
    inside = np.hypot(at[..., 0], at[..., 1]) < motion.radius
    return np.asarray(inside & (at[..., 2] > floor) & (at[..., 2] < motion.top))


def _tiles(off: Array) -> Array:
    """Means (t,) over tiles of an image (h, w) with NaN; tiles of which less than half is known are left out."""
    h, w = (n // TILE * TILE for n in off.shape)
    tiles = off[:h, :w].reshape(h // TILE, TILE, w // TILE, TILE).swapaxes(1, 2).reshape(-1, TILE * TILE)
    known = np.isfinite(tiles)
    full = known.sum(axis=1) > TILE * TILE / 2
    return np.asarray(np.where(known, tiles, 0.0)[full].sum(axis=1) / known[full].sum(axis=1))
