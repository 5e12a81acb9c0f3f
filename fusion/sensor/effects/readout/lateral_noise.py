"""Lateral noise: the edge of a thing jitters sideways, so edge pixels jump between the surfaces on both sides."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import ndtr

from fusion.sensor.effect import Effect, normal
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Edges, Image, View

# a neighbour this much (share of the depth) nearer or farther is another surface; 85 deg of tilt at fx = 585 px
JUMP = 0.02


@dataclass(frozen=True)
class LateralNoise(Effect):
    """Every point of an edge is displaced by a normal jitter of its own, across the edge, anew in each frame.

    A pixel shows the other surface while the jitter exceeds its distance to the edge. Pixels beside one edge
    point share its jitter. Without `View.edges`, edges are taken half a pixel beside the pixels next to a jump.
    """

    name: ClassVar[str] = "lateral_noise"
    key: ClassVar[str] = "N4"
    formula: ClassVar[str] = "z_measured = z + jump while e < sigma n,  e = distance to the edge, n ~ N(0, 1)"
    variables: ClassVar[tuple[str, ...]] = ("edge", "depth")
    not_undone: ClassVar[str] = "one image does not tell on which side of an edge a jittering pixel belongs"

    sigma_px: Value = parameter(
        "px", (0, 10), "jitter of an edge", "Nguyen, Izadi, Lovell 2012: 0.8 px", "pixels", typical=0.6
    )
    sigma: Value = parameter(
        "m", (0, 0.1), "jitter of an edge", "Fankhauser 2015, equations 2, 3 and 5", "length", typical=0.0005
    )

    def bias(self, depth: Image, view: View) -> Image:
        other, p = self._chance(depth, view)
        return p * other

    def noise(self, depth: Image, view: View) -> Image:
        other, p = self._chance(depth, view)
        return np.abs(other) * np.sqrt(p * (1 - p))

    def draw(self, depth: Image, view: View, rng: np.random.Generator) -> Image:
        other, p = self._chance(depth, view)
        jitter = normal(rng, depth)
        if view.edges is None:
            flipped = jitter * self._spread(depth, other, view) > 0.5
        else:
            # positive moves the edge towards the background, so that its pixels show the foreground
            shared = jitter[_edge_pixel(view.edges)] * np.where(other < 0, 1, -1)
            flipped = shared * self._spread(depth, other, view) > view.edges.distance
        return (flipped - p) * other

    def _chance(self, depth: Image, view: View) -> tuple[Image, Image]:
        """Depth across the edge minus the own (h, w) [m], and the share (h, w) of frames that show it."""
        if view.edges is None:
            other, distance = jump(depth), np.asarray(0.5, depth.dtype)
        else:
            other = np.nan_to_num(view.edges.jump, posinf=0, neginf=0).astype(depth.dtype)
            distance = np.nan_to_num(view.edges.distance, nan=np.inf, posinf=np.inf).astype(depth.dtype)
        p = ndtr(-distance / np.maximum(self._spread(depth, other, view), 1e-9)).astype(depth.dtype)
        return np.where(np.isfinite(depth), other, np.nan), p

    def _spread(self, depth: Image, other: Image, view: View) -> Image:
        """Jitter (h, w) [px]; the edge is that of the nearer surface."""
        in_pixels = np.asarray(self.sigma, depth.dtype) * (view.camera.fx / (depth + np.minimum(other, 0)))
        return np.nan_to_num(np.hypot(np.asarray(self.sigma_px, depth.dtype), in_pixels))


def _edge_pixel(edges: Edges) -> tuple[np.ndarray, np.ndarray]:
    """Row and column (h, w) of the pixel that holds the nearest edge point; the own where no edge is near."""
    height, width = edges.distance.shape
    e = np.where(np.isfinite(edges.distance), edges.distance, 0)
    direction = np.nan_to_num(edges.direction, posinf=0, neginf=0)
    v = np.rint(np.arange(height)[:, None] + e * np.sin(direction)).astype(np.intp)
    u = np.rint(np.arange(width)[None, :] + e * np.cos(direction)).astype(np.intp)
    return np.clip(v, 0, height - 1), np.clip(u, 0, width - 1)


def jump(depth: Image) -> Image:
    """Depth (h, w) [m] of the four neighbours' most different one minus the pixel's own; 0 away from edges."""
    best = np.zeros_like(depth)
    for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
        other = np.roll(depth, step, axis)
        border = (0 if step == 1 else -1,)
        other[border if axis == 0 else (slice(None), *border)] = np.nan
        difference = other - depth
        take = (np.abs(difference) > np.abs(best)) & (np.abs(difference) > JUMP * depth)
        best = np.where(take, difference, best)
    return np.where(np.isfinite(depth), best, np.nan).astype(depth.dtype)
