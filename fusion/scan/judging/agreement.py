"""Whether single frames see what the finished model says they should: doubled and displaced surfaces show here.

The residuals of a fit say little of a wrong model: what does not fit takes no part in them. Here every pixel of a frame
is asked: does it see the surface where the model has it, something before it, or through it to what is behind?
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.turntable.motion import Motion
from fusion.turntable.pairs.edges import CLEAR
from fusion.volume.prepared import Prepared
from fusion.volume.volume import Raycast, Volume

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
FRAMES = 16  # evenly from the scan: more say nothing new
STEEPEST = np.deg2rad(70)  # a surface seen flatter says little of its depth
RIM = 2  # [px] beside steps and holes of either image, where a camera mixes or matches both sides
STEP = 0.02  # [m] from one surface to another, within the rim's width: above the noise of any camera nearby
TOLERANCE = 3.0  # standard deviations of what noise and voxel let expect
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
    surface, seen = frame.surface, volume.raycast(frame.surface.camera, T)
    assert surface.incidence is not None
    off = frame.depth - seen.depth
    facing = _facing(seen)
    spread = np.hypot(surface.sigma, volume.settings.voxel / 2)
    limit = TOLERANCE * spread / np.maximum(facing, np.cos(STEEPEST))
    on_object = _turning(surface.points, T, motion)
    calm = ~(_rim(frame.depth) | _rim(seen.depth))
    shown = calm & np.isfinite(off) & (facing > np.cos(STEEPEST)) & _turning(seen.points, T, motion)
    missing = calm & on_object & ~np.isfinite(seen.depth) & (surface.incidence < STEEPEST)
    count = max(1, int((shown | missing).sum()))
    return _Shares(
        float((shown & on_object & (off < -limit)).sum() / count),
        float((shown & (off > limit)).sum() / count),
        float(missing.sum() / count),
        _tiles(np.where(shown & (np.abs(off) < volume.settings.truncation), off * facing, np.nan)),
    )


def _turning(points: NDArray[np.float32], T: Array, motion: Motion) -> Mask:
    """(h, w) bool: points (h, w, 3) seen by a camera at T (4, 4) above the plate, within what turns."""
    at = pose.transform(T, points.astype(float))
    floor = motion.bottom if motion.plate is None else motion.plate + CLEAR
    inside = np.hypot(at[..., 0], at[..., 1]) < motion.radius
    return np.asarray(inside & (at[..., 2] > floor) & (at[..., 2] < motion.top))


def _facing(seen: Raycast) -> Array:
    """(h, w) cosine between the model's normal and the way back to the camera."""
    along = np.einsum("vuk,vuk->vu", seen.normals, seen.points)
    return np.asarray(-along / np.linalg.norm(seen.points, axis=-1))


def _rim(depth: NDArray[np.float32]) -> Mask:
    """(h, w) pixels beside a step or a hole of a depth image [m]."""
    around = np.ones((2 * RIM + 1, 2 * RIM + 1), np.uint8)
    filled = np.nan_to_num(depth)
    return np.asarray(cv2.dilate(filled, around) - cv2.erode(filled, around) > STEP)


def _tiles(off: Array) -> Array:
    """Means (t,) over tiles of an image (h, w) with NaN; tiles of which less than half is known are left out."""
    h, w = (n // TILE * TILE for n in off.shape)
    tiles = off[:h, :w].reshape(h // TILE, TILE, w // TILE, TILE).swapaxes(1, 2).reshape(-1, TILE * TILE)
    known = np.isfinite(tiles)
    full = known.sum(axis=1) > TILE * TILE / 2
    return np.asarray(np.where(known, tiles, 0.0)[full].sum(axis=1) / known[full].sum(axis=1))
