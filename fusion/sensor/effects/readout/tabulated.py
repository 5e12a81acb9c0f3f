"""Tabulated: an error that is measured but has no name yet, as a table over what it was seen to depend on."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SensorError
from fusion.sensor.effect import Effect
from fusion.sensor.laws.disparity import depth_change
from fusion.sensor.laws.layers import Layers, layers_of
from fusion.sensor.laws.table import interpolated
from fusion.sensor.parameter import Value, parameter, setting
from fusion.sensor.view import Image, View
from fusion.sensor.where import VARIABLES

MOST = 6  # variables: every one doubles the work
STEEPEST = 0.5  # m of error per m, or px per px: beyond, the fixed point of the correction may not settle


@dataclass(frozen=True)
class Tabulated(Effect):
    """The value of a table, interpolated linearly, is added to the length (itof: along the ray) or to the disparity.

    Another table over the same variables holds which share of the values is missing. Outside its grid a table is held.
    Where a variable is not known, nothing changes.
    """

    name: ClassVar[str] = "tabulated"
    formula: ClassVar[str] = "length or disparity + table(variables); P(missing) = table(variables)"

    variables: tuple[str, ...] = setting("words", "what the table depends on, " + ", ".join(VARIABLES))  # type: ignore[misc]
    grid: tuple[tuple[float, ...], ...] = setting("numbers", "increasing values of each variable")
    values: Value = parameter("m", (-1, 1), "error of the length", "measured", "m", typical=0.01, kind="table")
    values_px: Value = parameter(
        "px", (-2, 2), "error of the disparity", "measured", "px", typical=0.1, kind="table", label="values"
    )
    missing: Value = parameter("1", (0, 1), "share of missing values", "measured", typical=0.05, kind="table")

    def __post_init__(self) -> None:
        super().__post_init__()
        unknown = [name for name in self.variables if name not in VARIABLES]
        if unknown or len(self.variables) > MOST:
            raise SensorError(
                "a table cannot depend on these variables",
                found=", ".join(self.variables)[:60],
                expected=f"at most {MOST} of " + ", ".join(VARIABLES),
            )
        if len(self.grid) != len(self.variables) or any(np.any(np.diff(nodes) <= 0) for nodes in self.grid):
            expected = f"{len(self.variables)} lists of increasing numbers, one per variable"
            raise SensorError("the grid of a table is wrong", found=f"{len(self.grid)} lists", expected=expected)
        shape = tuple(len(nodes) for nodes in self.grid)
        for values in (self.values, self.values_px, self.missing):
            if np.shape(values) not in ((), shape):
                raise SensorError("a table does not fit its grid", found=np.shape(values), expected=shape)

    def bias(self, depth: Image, view: View) -> Image:
        change: Image = np.zeros((), depth.dtype)
        at = [VARIABLES[name](depth, view) for name in self.variables]
        if any(x is None for x in at):
            return change
        if np.any(self.values):
            change = self._at(np.asarray(self.values), at, depth) * view.along_ray
        if np.any(self.values_px):
            change = change + depth_change(depth, self._at(np.asarray(self.values_px), at, depth), view)
        return change

    def dropout(self, depth: Image, view: View) -> Image:
        at = [VARIABLES[name](depth, view) for name in self.variables]
        if not np.any(self.missing) or any(x is None for x in at):
            return np.zeros((), depth.dtype)
        return self._at(np.asarray(self.missing), at, depth)

    def why_not_corrected(self) -> str:
        for own, table in (({"depth", "range"}, self.values), ({"disparity"}, self.values_px)):
            for axis, (name, nodes) in enumerate(zip(self.variables, self.grid, strict=True)):
                if name in own and np.ndim(table) and len(nodes) > 1:
                    rise = np.moveaxis(np.diff(table, axis=axis), axis, -1) / np.diff(nodes)
                    if np.max(np.abs(rise)) >= STEEPEST:
                        return f"the table is steeper along {name} than can be undone"
        return ""

    def corrected(self, measured: Image, view: View) -> Image | None:
        """Of a stack over the depth: straight pieces have a solution each, of a length or of a disparity."""
        lengths, pixels = np.asarray(self.values), np.asarray(self.values_px)
        if self.where or self.variables != ("v", "u", "depth") or np.any(lengths) == np.any(pixels):
            return None
        if np.any(pixels):
            per_pixel = measured.dtype.type(1 / view.focal_baseline)

            def solution(base: Image, rise: Image, z: Image, pixel: NDArray[np.intp]) -> Image:
                # 1 / z = 1 / x + (base + rise x) / (fx b), of two roots the one next to z
                half = (1 / z - base * per_pixel) / 2
                return np.asarray(1 / (half + np.sqrt(half * half - rise * per_pixel)))

            return self._layers(pixels, measured).solved(measured, solution)
        share = np.broadcast_to(np.asarray(view.along_ray, measured.dtype), measured.shape).reshape(-1)

        def straight(base: Image, rise: Image, z: Image, pixel: NDArray[np.intp]) -> Image:
            c = share if len(pixel) == len(share) else share[pixel]
            return np.asarray(z - c * (base + rise * z) / (1 + c * rise))

        return self._layers(lengths, measured).solved(measured, straight)

    def _layers(self, table: NDArray[np.floating], depth: Image) -> Layers:
        grid = tuple(map(tuple, self.grid))
        return layers_of(np.ascontiguousarray(table, float).tobytes(), table.shape, grid, depth.shape)

    def _at(self, table: NDArray[np.floating], at: list[Any], depth: Image) -> Image:
        if self.variables[:2] == ("v", "u") and table.ndim == 3 and np.shape(at[2]) == depth.shape:
            return np.nan_to_num(self._layers(table, depth).at(np.asarray(at[2]))).astype(depth.dtype, copy=False)
        value = interpolated(table, self.grid, at) if table.ndim else table
        return np.nan_to_num(value).astype(depth.dtype)
