"""What of the images stands still: did the camera move, or something before it?"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fusion.recording.looking.finding import Finding
from fusion.recording.looking.moved import STEP_M, STEP_RAD, wandered
from fusion.recording.looking.sample import Sample
from fusion.recording.recording import Recording

LEAST = 6  # frames that can tell what stands still
NOISE = 0.02  # of the depth: five standard deviations of a Kinect at 3 m, and less than an object's size nearby
OFTEN = 0.7  # share of the frames in which a pixel is known that is judged
PATCH = 4  # [px] edges flicker by a pixel or two; what moves is larger
STILL = 0.4  # least share of the pixels that see the same depth in all frames of a camera that stands still
MOVING = (0.015, 0.6)  # share of the pixels whose depth changes while something turns (guess)
BORDER = 0.1  # of the image's side: the rim that what turns on a table seldom reaches
SEEN = 0.1  # least share of the rim that is known, to judge by it
LOGGED = 30.0  # [deg] least turn in the table's log
CHANGING = 0.6  # least share of the rim that changes when the camera moves; people behind a table change 0.15 (guess)
MOST = 0.9  # of the whole image stands still when nothing moves, and changes when the camera moves (guess)


@dataclass(frozen=True)
class Stillness:
    """Shares of the pixels that are known in most frames."""

    still: float  # that see the same depth in all frames but one
    moving: float  # in patches that do not
    coming: float  # in patches that are known in some frames and missing in others, of those that are ever known
    border_known: float  # pixels of the image's rim that are known, of all of its rim
    border_moving: float  # that change much of the time, of these
    held: bool  # what stands still fixes the camera in every direction; a wall alone does not

    @property
    def nothing_moves(self) -> bool:
        """Neither the camera nor anything of a size that counts."""
        return self.still > MOST and max(self.moving, self.coming) < MOVING[0]

    @property
    def something_turns(self) -> bool:
        """Much stands still, and a part moves."""
        return self.still > STILL and MOVING[0] < self.moving < MOVING[1]

    @property
    def camera_moves(self) -> bool:
        """The whole image changes, its rim too."""
        return self.border_known > SEEN and self.border_moving > CHANGING and self.still < 1 - MOST

    @property
    def border_stands(self) -> bool:
        """The rim is seen and stays what it is."""
        return self.border_known > SEEN and self.border_moving < STILL


def stillness(sample: Sample) -> Stillness | None:
    """What of the images stands still; None where they are too few or show too little."""
    if len(sample.depths) < LEAST:
        return None
    depths = np.stack(list(sample.depths.values()))
    count = np.isfinite(depths).sum(axis=0)
    often = count >= OFTEN * len(depths)
    if not often.any():
        return None
    middle = np.full(often.shape, np.nan)
    middle[often] = np.nanmedian(depths[:, often].astype(float), axis=0)
    away = (np.abs(depths - middle) > NOISE * middle).sum(axis=0)
    moves = away >= 2
    # what comes and goes counts for some time of both: a sensor loses single pixels, and edges, now and then
    comes = (count > (1 - OFTEN) * len(depths)) & ~often
    border = _border(often.shape)
    seen = often & border
    # far surfaces are noisier than NOISE now and then; what moves is elsewhere most of the time
    changing = float((away[seen] > 0.3 * len(depths)).mean()) if seen.any() else 0.0
    steady = np.where(often & ~moves, middle, np.nan)
    return Stillness(
        still=float((~moves)[often].mean()),
        moving=_patches(moves) / often.sum(),
        coming=_patches(comes) / (count > 0).sum(),
        border_known=float(often[border].mean()),
        border_moving=changing,
        held=holds_the_camera(steady, sample.rays),
    )


def turns_by_its_log(recording: Recording) -> bool:
    """True when the telemetry holds the angle of a table that turns."""
    logged = recording.telemetry_at_frames("turntable_deg")
    return logged is not None and len(logged) > 2 and float(np.ptp(logged)) > LOGGED


def turns_before_a_still_camera(sample: Sample) -> bool:
    """True when much of the image stands still and a part of it moves: perhaps a turntable."""
    seen = stillness(sample)
    return seen is not None and seen.something_turns


def check_camera_moves(sample: Sample) -> list[Finding]:
    """For what takes every frame as a view of one rigid scene: something turns before a camera that stands still."""
    seen, logged = stillness(sample), turns_by_its_log(sample.recording)
    if seen is not None and seen.something_turns and seen.border_stands:
        said = f"({100 * seen.still:.0f} % of the image stand still, {100 * seen.moving:.0f} % move)"
        # by its own poses it may move too little to be seen at the rim of the image
        carried = any(way > step for way, step in zip(wandered(sample.recording), (STEP_M, STEP_RAD), strict=True))
        if logged or (seen.held and not carried):
            told = f"the camera stands still and something before it moves {said}"
            return [Finding("motion", "error", told, "use `fusion turntable` for an object that turns")]
        # a camera that slides along a wall sees the same
        told = f"the camera may stand still while something before it moves {said}"
        return [Finding("motion", "warning", told, "use `fusion turntable` if an object turns there")]
    if logged:
        told = "telemetry.csv holds the angle of a turntable"
        return [Finding("motion", "warning", told, "`fusion turntable` uses it and closes the loop")]
    if seen is not None and seen.nothing_moves:
        share = f"({100 * seen.still:.0f} % of the image stay as they are)"
        if not seen.held:
            told = f"the camera stood still, or slid along what looks the same everywhere {share}"
            return [Finding("motion", "warning", told, "keep things of several depths in view as it moves")]
        told = f"the camera stood still {share}: this is a single view"
        return [Finding("motion", "warning", told, "move the camera around what is to be scanned")]
    return []


def check_object_turns(sample: Sample) -> list[Finding]:
    """For what takes the camera as standing still: the whole image changes, or nothing does."""
    seen = stillness(sample)
    if seen is None:
        return []
    if seen.camera_moves:
        told = f"the camera moves: {100 * (1 - seen.still):.0f} % of the image change, its rim too"
        return [Finding("motion", "error", told, "use `fusion reconstruct`, or --box around the object if it turns")]
    if seen.nothing_moves and seen.moving == 0:
        told = f"nothing moves by its depth: {100 * seen.still:.0f} % of the image stay as they are in all frames"
        do = "record while the table turns; of a round thing in the middle of its plate only print tells"
        return [Finding("motion", "warning", told, do)]
    return []


def _patches(mask: NDArray[np.bool_]) -> float:
    """Pixels in patches of a mask."""
    return float(ndimage.binary_opening(mask, np.ones((PATCH, PATCH))).sum())


def _border(shape: tuple[int, ...]) -> NDArray[np.bool_]:
    height, width = shape
    rim = max(2, round(BORDER * min(shape)))
    border = np.ones((height, width), bool)
    border[rim:-rim, rim:-rim] = False
    return border


CELL = 8  # [px] depth is averaged over cells, or noise would tilt the normals
FLAT = 0.05  # of the depth: neighbouring cells that differ by more lie on two surfaces
ENOUGH = 50  # cells
# m along the normals per metre of motion: planes of real and simulated recordings reach 0.056 in the second weakest
# direction, a wall with a table before it 0.15
HELD = 0.1


def holds_the_camera(depth: NDArray[np.floating], rays: NDArray[np.floating]) -> bool:
    """True when at most one motion of the camera leaves all distances along the normals as they are.

    A single plane looks the same while the camera slides along it or turns about its normal; along the edge between
    table and wall only a straight slide is left, which nobody does while all else stays in its place.

    Args:
        depth: (h, w) [m], NaN where the surface is not asked.
        rays: (h, w, 2) x/z and y/z of its pixels.
    """
    points, normals = _facets(depth, rays)
    if len(points) < ENOUGH:
        return False
    arm = points - points.mean(axis=0)
    size = np.sqrt((arm**2).sum(axis=1).mean())
    rows = np.hstack([np.cross(arm, normals) / size, normals])
    return bool(np.sqrt(max(np.linalg.eigvalsh(rows.T @ rows / len(rows))[1], 0.0)) > HELD)


def _facets(depth: NDArray[np.floating], rays: NDArray[np.floating]) -> tuple[NDArray, NDArray]:
    """Points and unit normals (n, 3) of cells whose right and lower neighbours lie on the same surface."""
    height, width = (side // CELL for side in depth.shape)
    blocks = depth[: height * CELL, : width * CELL].reshape(height, CELL, width, CELL)
    mean = blocks.mean(axis=(1, 3), dtype=float)  # NaN where any pixel is
    ray = rays[: height * CELL, : width * CELL].reshape(height, CELL, width, CELL, 2).mean(axis=(1, 3))
    points = np.dstack([ray * mean[..., None], mean])
    across, down = points[:-1, 1:] - points[:-1, :-1], points[1:, :-1] - points[:-1, :-1]
    near = FLAT * mean[:-1, :-1]
    with np.errstate(invalid="ignore"):
        joined = (np.abs(across[..., 2]) < near) & (np.abs(down[..., 2]) < near)
    normals = np.cross(across[joined], down[joined])
    return points[:-1, :-1][joined], normals / np.linalg.norm(normals, axis=1, keepdims=True)
