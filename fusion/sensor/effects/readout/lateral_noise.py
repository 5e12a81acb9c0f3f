"""Lateral noise: the edge of a thing jitters sideways, so edge pixels jump between the surfaces on both sides."""

from dataclasses import dataclass
from functools import cache, cached_property
from math import erfc, sqrt
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.edges.neighbours import steps_along, stride_along
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Edges, Image, View

# a neighbour this much (share of the depth) nearer or farther is another surface; 85 deg of tilt at fx = 585 px
JUMP = 0.02
REACH = 8.0  # [px] farther from an edge nothing jitters


@dataclass(frozen=True)
class LateralNoise(Effect):
    """Every point of an edge is displaced by a normal jitter of its own, across the edge, anew in each frame.

    A pixel shows the other surface while the jitter exceeds its distance to the edge. Pixels beside one edge
    point share its jitter. Without `View.edges`, edges are taken half a pixel beside the pixels next to a jump.
    """

    name: ClassVar[str] = "lateral_noise"
    key: ClassVar[str] = "N4"
    formula: ClassVar[str] = "z_measured = z + jump while e < sigma n, e = distance to the edge, n ~ N(0, 1)"
    variables: ClassVar[tuple[str, ...]] = ("edge", "depth")
    not_corrected: ClassVar[str] = "one image does not tell on which side of an edge a jittering pixel belongs"

    sigma_px: Value = parameter(
        "px", (0, 10), "jitter of an edge", "Nguyen, Izadi, Lovell 2012: 0.8 px", "pixels", typical=0.6
    )
    sigma: Value = parameter(
        "m", (0, 0.1), "jitter of an edge", "Fankhauser 2015, equations 2, 3 and 5", "length", typical=0.0005
    )

    def bias(self, depth: Image, view: View) -> Image:
        near = self._near(depth, view)
        return _spread_out(near, near.share * near.jump, depth)

    def noise(self, depth: Image, view: View) -> Image:
        near = self._near(depth, view)
        return _spread_out(near, near.noise, depth)

    def spread(self, sigma: Image, depth: Image, view: View) -> Image:
        near = self._near(depth, view)
        out = sigma + 0 * depth
        # edges are few: sums over the whole image would take as long as finding them
        out.flat[near.where] = np.sqrt(out.flat[near.where] ** 2 + near.noise**2)
        return out

    def sampled(self, depth: Image, view: View, rng: np.random.Generator) -> Image:
        near = self._near(depth, view)
        flipped = _flipped(near, rng)
        if self.where:
            return depth + self.change(depth, view) + _spread_out(near, (flipped - near.share) * near.jump, depth)
        # the share of the frames that a pixel flips in is in the mean and, as much less, in the draw
        out = depth.copy()
        flat = out.reshape(-1)
        flat[near.where[flipped]] += near.jump[flipped]
        return out

    def _near(self, depth: Image, view: View) -> "_Near":
        """The pixels that a jitter can reach."""
        if not (np.any(self.sigma_px) or np.any(self.sigma)):
            nothing = np.zeros(0, depth.dtype)
            return _Near(np.zeros(0, np.intp), nothing, nothing, nothing, np.zeros(0, np.intp))
        if view.edges is None:
            where, other = _jumps(depth)
            distance, edge_pixel = np.full(len(where), 0.5, depth.dtype), where
        else:
            where = np.flatnonzero((view.edges.distance < REACH) & np.isfinite(depth))
            distance = view.edges.distance.ravel()[where].astype(depth.dtype)
            edge_pixel = _edge_pixel(where, distance, view.edges)
            other = np.nan_to_num(view.edges.jump.ravel()[where], posinf=0, neginf=0).astype(depth.dtype)
        # the edge is that of the nearer surface
        at = np.maximum(depth.ravel()[where] + np.minimum(other, 0), 1e-3)
        in_pixels = _at(self.sigma, where, depth) * (view.camera.fx / at)
        spread = np.maximum(np.hypot(_at(self.sigma_px, where, depth), in_pixels), 1e-9)
        return _Near(where, distance, other, spread, edge_pixel)


@dataclass(frozen=True)
class _Near:
    """Pixels (n,) beside an edge: flat index, distance [px], depth across minus own [m], jitter [px], and flat index of
    the pixel that holds the edge point."""

    where: NDArray[np.intp]
    distance: Image
    jump: Image
    spread: Image
    edge_pixel: NDArray[np.intp]

    @cached_property
    def share(self) -> Image:
        """(n,) of the frames that show the other side."""
        return normal_share(self.distance / self.spread).astype(self.distance.dtype)

    @property
    def noise(self) -> Image:
        """(n,) standard deviation of the depth [m]."""
        return np.abs(self.jump) * np.sqrt(self.share * (1 - self.share))


def normal_share(distance: Image) -> Image:
    """Share of a normal jitter beyond a distance (n,) [standard deviations], to 1e-6."""
    return np.asarray(np.interp(distance, *_normal_shares()))


@cache
def _normal_shares() -> tuple[Image, Image]:
    """Distances, and the shares beyond. A table, as scipy's import would be a tenth of the time to a first frame."""
    distance = np.linspace(-6, 6, 6001)
    beyond = np.array([0.5 * erfc(x / sqrt(2)) for x in distance])
    distance.flags.writeable = beyond.flags.writeable = False
    return distance, beyond


def _flipped(near: _Near, rng: np.random.Generator) -> NDArray[np.bool_]:
    """(n,) the pixels that show the other side when every edge point is displaced by a jitter of its own."""
    # positive moves the edge towards the background, so that its pixels show the foreground
    shared = _jitter(near.edge_pixel, rng).astype(near.jump.dtype)
    return np.asarray(np.where(near.jump < 0, shared, -shared) * near.spread > near.distance)


def _jitter(pixels: NDArray[np.intp], rng: np.random.Generator) -> NDArray[np.float64]:
    """Standard normal numbers (n,), each by its pixel, whatever others are asked for: edges are few, and a number for
    each pixel of the image would be most of the work (SplitMix64: Steele, Lea, Flood 2014; Box, Muller 1958).
    """
    bits = (pixels.astype(np.uint64) + rng.integers(2**63, dtype=np.uint64)) * np.uint64(0x9E3779B97F4A7C15)
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        bits = (bits ^ (bits >> np.uint64(shift))) * np.uint64(factor)
    bits ^= bits >> np.uint64(31)
    radius = np.sqrt(-2 * np.log(((bits >> np.uint64(32)) + 0.5) / 2**32))
    return np.asarray(radius * np.cos(2 * np.pi / 2**32 * (bits & np.uint64(2**32 - 1))))


def _edge_pixel(where: NDArray[np.intp], distance: Image, edges: Edges) -> NDArray[np.intp]:
    """Flat index (n,) of the pixel that holds the nearest edge point."""
    height, width = edges.distance.shape
    direction = np.nan_to_num(edges.direction.ravel()[where], posinf=0, neginf=0)
    v = np.rint(where // width + distance * np.sin(direction)).astype(np.intp)
    u = np.rint(where % width + distance * np.cos(direction)).astype(np.intp)
    return np.clip(v, 0, height - 1) * width + np.clip(u, 0, width - 1)


def _spread_out(near: _Near, values: Image, depth: Image) -> Image:
    """Values (n,) as an image (h, w), 0 elsewhere, NaN where there is no depth."""
    out = np.zeros(depth.shape, depth.dtype)
    out.flat[near.where] = values
    return out + 0 * depth


def _at(value: Value, where: NDArray[np.intp], depth: Image) -> Image:
    """A parameter at some pixels, whether it is a number or a map."""
    return np.asarray(value, depth.dtype) if np.ndim(value) == 0 else np.asarray(value, depth.dtype).ravel()[where]


def jump(depth: Image) -> Image:
    """Depth (h, w) [m] of the four neighbours' most different one minus the pixel's own; 0 away from edges."""
    out = np.where(np.isfinite(depth), np.zeros((), depth.dtype), np.nan)
    where, change = _jumps(depth)
    out.flat[where] = change
    return out


def _jumps(depth: Image) -> tuple[NDArray[np.intp], Image]:
    """Flat indices (n,) of the pixels next to an edge, and the depth (n,) [m] that `jump` has there."""
    depth = np.ascontiguousarray(depth)
    z, best = depth.reshape(-1), np.zeros(depth.size, depth.dtype)
    for axis in (0, 1):
        first = steps_along(depth, axis, JUMP)
        second = first + stride_along(depth, axis)
        change = z[second] - z[first]
        for own, other in ((second, -change), (first, change)):
            take = (np.abs(other) > np.abs(best[own])) & (np.abs(other) > JUMP * z[own])
            best[own[take]] = other[take]
    where = np.flatnonzero(best != 0)
    return where, best[where]
