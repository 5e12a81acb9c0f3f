"""Two views at a time: how well a motion about and across the axis brings them together, by shape and by print."""

from dataclasses import dataclass, fields, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.compute.start import start
from fusion.turntable.axis import Axis
from fusion.turntable.pairs.edges import Edges, ViewStack

Array = NDArray[np.float64]
LEAST_COSINE = 0.6  # between the normals of a pair
TONE = 0.15  # spread of contrasts at a wrong place is about this and more, at the right place a third (guess)
HELD = 1e-6  # [rad] a turn that stays
_LOWER = np.array([[max(a, b) * (max(a, b) + 1) // 2 + min(a, b) for b in range(7)] for a in range(7)])


@dataclass(frozen=True)
class ViewPairLimits:
    """What makes a pair and how it counts."""

    reach: float  # largest distance of a pair [m], see `Stack.reach`
    scale: float = 0.0  # observed over declared spread of depth; 0 takes all within reach, below there are no equations
    tone: float = 0.0  # spread of the contrasts' differences; 0 leaves print out of the equations
    most: int = 600  # about so many points of a view


@dataclass(frozen=True)
class Twists:
    """What the points of m edges say of small motions after theirs, in [rotation about a centre (3), shift (3)], and of
    the focal length, log(f / stated).
    """

    # H, g: (m, 7, 7), (m, 7) normal equations of shape and print together
    H: Array
    g: Array
    # visible, pairs: (m,) points that the other view could have met, and that met something near
    visible: Array
    pairs: Array
    misfit: Array  # (m,) 0 (perfect) to 1, of the visible points
    alike: Array  # (m,) correlation of the print, -1 to 1; 0 where too few points or no print tell
    printed: Array  # (m,) number of points whose print was compared
    # scale, tone: (m,) observed over declared spread of depth, and mean difference of the contrasts
    scale: Array
    tone: Array

    def beside(self, other: "Twists") -> "Twists":
        """These edges and others."""
        return Twists(*(np.concatenate([getattr(self, f.name), getattr(other, f.name)]) for f in fields(self)))

    def first(self, m: int) -> "Twists":
        """The first m edges."""
        return Twists(*(getattr(self, f.name)[:m] for f in fields(self)))


def twists(
    seen: ViewStack, edges: Edges, poses: Array, centre: Array, limits: ViewPairLimits, focal: float = 0.0
) -> Twists:
    """The equations of m pairs of views at poses (m, 4, 4) (model from source), by a focal length log(f / stated)."""
    from fusion.compute.cards.memory import read_only  # starts Taichi
    from fusion.turntable.pairs.edge_pairs import PairedViews
    from fusion.turntable.pairs.edge_twists import COUNTS, MATRIX, WIDTH, twist_sums

    start()
    sums = np.zeros((len(edges), WIDTH))
    reach, most = seen.reach(limits.reach), max(limits.most, 1)
    how = [reach, LEAST_COSINE, seen.stride, limits.scale, limits.tone, most, np.exp(-focal)]
    tones = seen.tones if len(seen.tones) else np.zeros(1, np.float32)
    twist_sums(
        PairedViews(
            read_only(np.array(edges, np.int32).reshape(-1, 2)), read_only(np.ascontiguousarray(poses, np.float32)),
            seen.first, seen.points, seen.maps,
        ),
        read_only(tones), seen.images, read_only(seen.views[0].map.camera.parameters),
        read_only(np.asarray(centre, np.float32)), read_only(np.array(how, np.float32)),
        sums,
    )  # fmt: skip
    both = sums[:, :MATRIX] + sums[:, MATRIX : 2 * MATRIX]
    visible, pairs, far, odds, _, printed, product, own, other, off = sums[:, -COUNTS:].T
    misfit = (visible - pairs + far) / np.maximum(visible, 1)
    alike = product / np.sqrt(np.maximum(own * other, 1e-12))
    return Twists(
        both[:, _LOWER], both[:, 28:35], visible, pairs, np.where(visible > 0, misfit, 1.0),
        np.where(printed >= 40, alike, 0.0), printed, 1.25 * odds / np.maximum(pairs, 1), off / np.maximum(printed, 1),
    )  # fmt: skip


def register(
    seen: ViewStack,
    edges: Edges,
    axis: Axis,
    start: Array,
    passes: tuple[ViewPairLimits, ...],
    loose: float,
    iterations: int = 4,
    turn: float = 1.0,
) -> Array:
    """The motions (m, 4, 4) of m pairs brought together, each about the axis' direction and across it.

    Args:
        seen: the views.
        edges: m pairs, source and model.
        axis: about which.
        start: (m, 4, 4) motions to start from, model from source.
        passes: one after the other.
        loose: standard deviation of where the axis is [m]: a hand moves it from view to view.
        iterations: in each pass.
        turn: standard deviation of a step's turn [rad]; `HELD` leaves the turns as they are.
    """
    poses = np.array(start, float)
    J = np.zeros((6, 3))
    J[:3, 0] = axis.direction
    J[3:, 1:] = axis.across().T
    middle = axis.point
    for limits in passes:
        for _ in range(iterations):
            found = twists(seen, edges, poses, middle, limits)
            shift = (poses[:, :3, :3] @ middle + poses[:, :3, 3] - middle) @ axis.across().T
            H, g = J.T @ found.H[:, :6, :6] @ J, found.g[:, :6] @ J
            # neighbouring pixels say the same: a hundred of them count as one
            H, g = H / 100, g / 100
            H[:, 1, 1] += 1 / loose**2
            H[:, 2, 2] += 1 / loose**2
            g[:, 1:] += shift / loose**2
            H[:, 0, 0] += 1 / turn**2
            step = -np.linalg.solve(H, g[..., None])[..., 0]
            step *= np.minimum(1.0, 0.15 / np.maximum(np.abs(step[:, :1]), 1e-9))
            step[:, 1:] = np.clip(step[:, 1:], -limits.reach / 2, limits.reach / 2)
            poses = _after(axis, np.asarray(step, float)) @ poses
    return poses


@dataclass(frozen=True)
class Registered:
    """m pairs of views at motions (m, 4, 4), their turns (m,) [rad] about the axis, and what fits there."""

    poses: Array
    turns: Array
    at: Twists


def registered(seen: ViewStack, edges: Edges, axis: Axis, poses: Array, limits: ViewPairLimits) -> Registered:
    """What m pairs of views show at motions (m, 4, 4), without equations: they take a third of the time and more."""
    turn = np.einsum("mij,ij->m", poses[:, :3, :3], _skew(axis.direction)) / 2
    flat = np.einsum("mii->m", poses[:, :3, :3]) / 2 - 0.5
    at = twists(seen, edges, poses, axis.point, replace(limits, scale=-1.0))
    return Registered(poses, np.arctan2(turn, flat), at)


def _after(axis: Axis, step: Array) -> Array:
    """(m, 4, 4) turns about the axis and shifts across it, of steps (m, 3)."""
    T = axis.turns(step[:, 0])
    T[:, :3, 3] += step[:, 1:] @ axis.across()
    return T


def _skew(v: Array) -> Array:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def coarser(seen: ViewStack, sigma: float = 4.0) -> ViewStack:
    """The views with their print blurred (standard deviation in pixels), so that it guides from farther off."""
    if not len(seen.tones):
        return seen
    known = np.isfinite(seen.images)
    blurred = np.empty_like(seen.images)
    for out, image, mask in zip(blurred, seen.images, known, strict=True):
        weight = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), sigma)
        np.divide(cv2.GaussianBlur(np.nan_to_num(image), (0, 0), sigma), np.maximum(weight, 1e-6), out=out)
    blurred[~known] = np.nan
    tones = np.empty_like(seen.tones)
    for k, image in enumerate(blurred):
        own = slice(int(seen.first[k]), int(seen.first[k + 1]))
        u, v = np.rint(seen.views[0].map.camera.project(seen.points[own, :3].astype(float)) / seen.stride).astype(int).T
        h, w = image.shape
        tones[own] = image[np.clip(v, 0, h - 1), np.clip(u, 0, w - 1)]
    return replace(seen, tones=tones, images=blurred)
