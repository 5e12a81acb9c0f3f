"""Do the stated poses fit the depth: the right way round, along the axes that are meant, in the same unit?"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fusion.errors import RecordingError
from fusion.geometry.conventions import CONVENTIONS
from fusion.geometry.pose import Array, angle, inverse, transform
from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample

# relative depth difference up to which a warped pixel agrees: poses of motion capture are off by 1 to 2 cm
TOLERANCE = 0.03
POINTS = 2000
# of what both frames of a pair see, least share that agrees with right poses: 0.97 in a simulated room, 0.88 with
# motion capture, 0.71 with a small owl that turns; the rest is hidden by nearer things, or an edge. 6 degrees off: 0.6
FITTING = 0.65
# [deg] and with a direction off by so much: a hand turns the camera by 1 rad/s, and stamps belong together up to 0.02 s
ASIDE = 1.0
# a doubt needs this much more agreement than the poses as stated
BETTER = 0.15
# factors between the scales in use; 1000: poses in millimetres
FACTORS = (1.0, 0.1, 0.2, 0.5, 2.0, 5.0, 10.0, 1000.0)
BETWEEN = np.geomspace(0.67, 1.5, 17)  # in steps of 5 %: what is known of a scale that nobody tells
ALIKE = 0.05  # of two agreements: which is the better is not known
STATED = "opencv"
# frames to look ahead for one seen from elsewhere
REACH = 200


@dataclass(frozen=True)
class Warped:
    """Points of one frame that meet a surface seen by another."""

    z: Array  # (n,) their depth there [m]
    # v, u: (n,) their pixels there
    v: NDArray[np.intp]
    u: NDArray[np.intp]
    measured: Array  # (n,) the depth seen there [m]
    left: int  # how many points leave the image

    @property
    def score(self) -> float:
        """Share that agrees, for comparing hypotheses.

        Points that leave the image count half against one: else one that moves all but a few out would win.
        """
        agreed = (np.abs(self.measured - self.z) < TOLERANCE * self.z).sum()
        return float(agreed / max(1.0, len(self.z) + 0.5 * self.left))

    def beside(self, low: NDArray[np.float32], high: NDArray[np.float32]) -> int:
        """How many agree with a depth between the least and the largest (h, w) [m] that are seen around a pixel."""
        near, far = low[self.v, self.u], high[self.v, self.u]
        return int(((near < (1 + TOLERANCE) * self.z) & (far > (1 - TOLERANCE) * self.z)).sum())


@dataclass(frozen=True)
class PosedPair:
    """Points (n, 3) [m] of one depth image, another image (h, w) [m], and the stated poses of both."""

    points_i: Array
    pose_i: Array
    depth_j: NDArray[np.float32]
    pose_j: Array


def check_poses(sample: Sample) -> list[Finding]:
    """Poses that fit the depth better by another convention, or when the depth has another scale."""
    poses = sample.recording.poses
    if poses is None:
        return []
    at_frames = poses.at(sample.recording.timestamps)
    missing = int((~at_frames.valid).sum())
    if missing == len(at_frames):
        do = "put the stamps of the poses on the clock of the depth frames"
        return [
            Finding("poses", "error", "no pose stated (groundtruth.txt or --poses) lies within 0.02 s of a frame", do)
        ]
    pairs = _pairs(sample, at_frames.poses)
    seen = f"stated for {len(at_frames) - missing} of {len(at_frames)} frames"
    if not pairs:
        return [Finding("poses", "ok", f"{seen}; too little motion to judge them")]
    stated = float(np.mean([_warped(sample, pair, STATED, 1.0).score for pair in pairs]))
    if stated > 1 - BETTER:  # nothing can agree by so much more
        return [_fitting(seen, sample, pairs)]
    table = {
        (name, factor): float(np.mean([_warped(sample, pair, name, factor).score for pair in pairs]))
        for name in CONVENTIONS
        for factor in FACTORS
    }
    # of doubts that explain it about as well, the one that changes least
    close = [key for key in table if table[key] > max(table.values()) - ALIKE]
    best = min(close, key=lambda key: ((key[0] != STATED) + (key[1] != 1), -table[key]))
    between = _scale_between(sample, pairs, max(stated, table[best] - BETTER))
    if between or table[best] < 0.3 or table[best] < stated + BETTER:
        return [_fitting(seen, sample, pairs), *between]
    return _doubts(sample, *best, stated, table[best])


def _fitting(seen: str, sample: Sample, pairs: list[PosedPair]) -> Finding:
    """How well poses fit of which no better reading is known."""
    warped = [_warped(sample, pair, STATED, 1.0) for pair in pairs]
    agreed = [w.beside(*_around(sample, pair.depth_j)) for w, pair in zip(warped, pairs, strict=True)]
    share = sum(agreed) / max(1, sum(len(w.z) for w in warped))
    within = f"{100 * TOLERANCE:.0f} % of the depth and {ASIDE:g} degree"
    told = f"{seen}; {100 * share:.0f} % of what two frames both see agrees within {within}"
    if share >= FITTING:
        return Finding("poses", "ok", told)
    do = (
        f"poses, camera and depth that belong together reach {100 * FITTING:.0f} %: look for a depth scale or a focal "
        "length that is a few percent off, and for poses on another clock; `fusion reconstruct` needs none"
    )
    return Finding("poses", "warning", told, do)


def _scale_between(sample: Sample, pairs: list[PosedPair], least: float) -> list[Finding]:
    """A scale that is none of those in use and with which the depth of two frames agrees far better than by `least`."""

    def agreed(factor: float) -> float:
        return float(np.mean([_warped(sample, pair, STATED, factor).score for pair in pairs]))

    shares = [agreed(factor) for factor in BETWEEN]
    if max(shares) < least + BETTER:
        return []
    # pixels agree over some percent of scale: the middle of these
    factor = float(np.exp(np.mean(np.log(BETWEEN[np.array(shares) > max(shares) - ALIKE]))))
    scale = sample.recording.camera.depth_scale
    seen = f"with the stated poses the depth of two frames agrees by {100 * agreed(1.0):.0f} %, "
    seen += (
        f"by {100 * agreed(factor):.0f} % with depth_scale {float(f'{scale / factor:.2g}'):g} or about for {scale:g}"
    )
    do = "pass --camera with the right depth_scale, or check the focal length and the unit of the poses"
    return [Finding("depth", "warning", seen, do)]


def _doubts(sample: Sample, name: str, factor: float, stated: float, agreed: float) -> list[Finding]:
    seen = f"with them as stated the depth of two frames agrees by {100 * stated:.0f} %, by {100 * agreed:.0f} % "
    findings = []
    if name != STATED:
        found = CONVENTIONS[name]
        do = f"they look like {found.meant}: `fusion convert` and `fusion reconstruct --poses` read them so with "
        findings.append(Finding("poses", "error", seen + f"{found.seen}", f"{do}--pose-convention {name}"))
    if factor == 1000:
        do = "the poses look like millimetres: write them in metres"
        findings.append(Finding("poses", "error", seen + "with poses / 1000", do))
    elif factor != 1:
        scale = sample.recording.camera.depth_scale
        do = f"pass --camera with depth_scale {scale / factor:g}"
        findings.append(Finding("depth", "error", seen + f"with depth_scale {scale / factor:g} for {scale:g}", do))
    return findings


def _pairs(sample: Sample, poses: Array) -> list[PosedPair]:
    """Pairs of frames whose poses differ clearly, but not too much to see the same."""
    pairs = []
    placed = np.asarray(np.isfinite(poses).all(axis=(1, 2)))
    for i, image in sample.depths.items():
        if not np.isfinite(image).any():
            continue
        later = np.flatnonzero(placed[i + 1 : i + 1 + REACH]) + i + 1
        j = _partner(poses, i, later, float(np.nanmedian(image))) if placed[i] else None
        depth = None if j is None else _depth(sample, j)
        if j is not None and depth is not None:
            pairs.append(PosedPair(_points(sample, image), poses[i], depth, poses[j]))
    return pairs


def _partner(poses: Array, i: int, later: NDArray[np.intp], median: float) -> int | None:
    """The frame with the largest motion that still sees the same; None when nothing moved clearly."""
    relative = [inverse(poses[i]) @ poses[j] for j in later]
    turns = np.array([angle(T) for T in relative])
    shifts = np.array([np.linalg.norm(T[:3, 3]) for T in relative])
    clear = ((turns > 0.1) | (shifts > 0.05)) & (turns < 0.4)
    if not clear.any():
        return None
    near = clear & (shifts < 0.3 * median)
    # all far: poses in another unit or another direction; the first is then the nearest in truth
    best = np.argmax(np.where(near, turns + shifts / median, 0)) if near.any() else np.argmax(clear)
    return int(later[best])


def _depth(sample: Sample, index: int) -> NDArray[np.float32] | None:
    if index in sample.depths:
        return sample.depths[index]
    try:
        return sample.recording[index].depth[:: sample.stride, :: sample.stride]
    except RecordingError:  # told by the check of the files
        return None


def _points(sample: Sample, depth: NDArray[np.float32]) -> Array:
    """(n, 3) points of a depth image (h, w) [m], as many as tell."""
    points = np.dstack([sample.rays * depth[..., None], depth])[np.isfinite(depth)]
    return points[:: max(1, len(points) // POINTS)].astype(float)


def _warped(sample: Sample, pair: PosedPair, convention: str, factor: float) -> Warped:
    """Does the first frame's surface lie where the other sees it, with these poses?"""
    pose_i, pose_j = map(CONVENTIONS[convention].read, (pair.pose_i, pair.pose_j))
    T_j_i = inverse(pose_j) @ pose_i
    points, other = transform(T_j_i, pair.points_i * factor), pair.depth_j * factor
    front = points[points[:, 2] > 1e-3]
    # beyond half a right angle from the axis the lens model is not to be trusted
    front = front[np.abs(front[:, :2] / front[:, 2:]).max(axis=1, initial=0.0) < 2]
    v, u = np.rint(sample.recording.camera.project(front)[:, ::-1] / sample.stride).astype(int).T
    inside = (v >= 0) & (v < other.shape[0]) & (u >= 0) & (u < other.shape[1])
    v, u, z = v[inside], u[inside], front[inside, 2]
    met = np.isfinite(other[v, u])
    return Warped(z[met], v[met], u[met], other[v, u][met].astype(float), int(len(points) - inside.sum()))


def _around(sample: Sample, depth: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Least and largest depth (h, w) [m] that is seen up to ASIDE from each pixel."""
    side = 2 * round(np.deg2rad(ASIDE) * sample.recording.camera.fx / sample.stride) + 1
    known = np.isfinite(depth)
    low = ndimage.minimum_filter(np.where(known, depth, np.inf), side)
    return low, ndimage.maximum_filter(np.where(known, depth, -np.inf), side)
