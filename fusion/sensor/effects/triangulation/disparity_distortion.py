"""Disparity distortion: the stored pattern, or the rectification, is warped, so each pixel has its own offset."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import TRIANGULATING, Principle
from fusion.sensor.effect import Effect
from fusion.sensor.forms import Atom, Form
from fusion.sensor.laws.disparity import depth_change, disparity
from fusion.sensor.laws.fields import frozen_map
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

HERRERA = "Herrera et al. 2012 (form from memory); Raposo et al. 2013"
SMOOTH = 0.12  # share of the image's width over which the frozen warp is smooth: guess, after the plots of Teichman

ORDERS = 5  # of the polynomials that are tried: 0 to 4


@dataclass(frozen=True)
class DisparityDistortion(Effect):
    """d_measured = d + D(u, v) exp(-decay d); D is a frozen smooth field, a map, a polynomial, or their sum."""

    name: ClassVar[str] = "disparity_distortion"
    key: ClassVar[str] = "G6"
    formula: ClassVar[str] = "d_measured = d + D(u, v) exp(-decay d), d = fx b / z"
    variables: ClassVar[tuple[str, ...]] = ("u", "v", "depth")
    principles: ClassVar[tuple[Principle, ...]] = TRIANGULATING
    frozen: ClassVar[str] = "unit"

    rms: Value = parameter(
        "px",
        (0, 0.5),
        "size of a smooth warp that this unit has and keeps, over the image",
        "0.1 to 0.5 px, from memory",
        "rms",
        typical=0.15,
    )
    map: Value = parameter("px", (-1.5, 1.5), "warp of each pixel", HERRERA, "map", typical=0.1, kind="map")
    coefficients: Value = parameter(
        "px",
        (-0.5, 0.5),
        "of u^2, u v, v^2, u^3, u^2 v, u v^2, v^3, u^4, ... with u and v from -1 to 1 over the image",
        "polynomial without offset (disparity_offset) and tilt",
        "coefficients",
        typical=0.1,
        kind="list",
    )
    decay: Value = parameter(
        "1/px",
        (0, 1),
        "how fast the warp fades with the disparity",
        HERRERA,
        "decay",
        typical=0.01,
    )

    def bias(self, depth: Image, view: View) -> Image:
        shift = np.asarray(self.map, depth.dtype)
        if np.any(self.coefficients):
            shift = shift + _polynomial(np.atleast_1d(self.coefficients), view)
        if np.any(self.rms) and view.moment.unit is not None:
            field = frozen_map(depth.shape, SMOOTH * depth.shape[1], self.name, view.moment.unit)
            shift = shift + np.asarray(self.rms, depth.dtype) * field
        return depth_change(depth, shift * self._fade(depth, view), view)

    def noise(self, depth: Image, view: View) -> Image:
        spread = np.asarray(self.rms, depth.dtype) * self._fade(depth, view)
        return np.abs(depth_change(depth, spread, view)) if np.any(self.rms) else np.zeros((), depth.dtype)

    def _fade(self, depth: Image, view: View) -> Image | float:
        return np.exp(-np.asarray(self.decay, depth.dtype) * disparity(depth, view)) if np.any(self.decay) else 1.0

    @classmethod
    def own_forms(cls, shape: tuple[int, int]) -> list[Form]:
        """Any map, and polynomials up to the fourth order as one: a smooth warp, its mean and tilt included."""
        height, width = shape
        u, v = 2 * (np.arange(width) + 0.5) / width - 1, 2 * (np.arange(height)[:, None] + 0.5) / height - 1
        atoms = tuple({"map": 0.005 * u ** (n - k) * v**k} for n in range(ORDERS) for k in range(n + 1))
        smooth = [Form(cls, {"decay": decay}, atoms, join=_added) for decay in (0.0, 0.03, 0.1)]
        return [*smooth, Form(cls, {"decay": 0.0}, map="map")]


def _added(atoms: Sequence[Atom], weights: Sequence[float]) -> Atom:
    return {"map": sum(weight * np.asarray(atom["map"]) for atom, weight in zip(atoms, weights, strict=True))}


def _polynomial(coefficients: NDArray[np.floating], view: View) -> Image:
    """Sum (h, w) [px] of coefficients times u^(n-k) v^k, for n = 2, 3, ... and k = 0 to n."""
    height, width = view.camera.shape
    u, v = 2 * (view.u + 0.5) / width - 1, 2 * (view.v + 0.5) / height - 1
    total = np.zeros((height, width), np.float32)
    powers = ((n - k, k) for n in range(2, 2 + len(coefficients)) for k in range(n + 1))
    for factor, (along_u, along_v) in zip(coefficients, powers, strict=False):
        total += np.float32(factor) * u**along_u * v**along_v
    return total
