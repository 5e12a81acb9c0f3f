"""Maps of a calibration as effects of a sensor model."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from fusion.calibration.depth.maps.surface import MapStack
from fusion.geometry.camera import Camera
from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.effects.triangulation.disparity_distortion import DisparityDistortion
from fusion.sensor.laws.table import interpolated
from fusion.sensor.sensor import Sensor


def with_surface(sensor: Sensor, camera: Camera, stack: MapStack) -> Sensor:
    """The sensor with a map (one distance) or a stack added; a radial table that it has goes into the stack's."""
    triangulating = sensor.principle.triangulates
    if len(stack.distance) == 1:
        pixels = np.asarray(_full(stack, camera), float)
        there = sensor.effect("disparity_distortion" if triangulating else "fixed_pattern")
        if there is not None:
            pixels = pixels + np.asarray(there.map)  # type: ignore[attr-defined]
        effect: Effect = DisparityDistortion(map=pixels) if triangulating else FixedPattern(map=pixels)
        return _with(sensor, effect, "map", stack.std)
    values = np.asarray(np.moveaxis(stack.maps, 0, -1), float)  # (v, u, depth)
    old = sensor.effect("tabulated")
    if isinstance(old, Tabulated):
        values = values + _radial(old, camera, stack, triangulating)[..., None].astype(float)
    grid = tuple(tuple(map(float, axis)) for axis in (stack.v, stack.u, stack.distance))
    names = ("v", "u", "depth")
    table = Tabulated(names, grid, values_px=values) if triangulating else Tabulated(names, grid, values)
    kept = {key: std for key, std in sensor.std.items() if key[0] != "tabulated"}
    return _with(replace(sensor, std=kept), table, "values_px" if triangulating else "values", stack.std)


def _with(sensor: Sensor, effect: Effect, parameter: str, std: float) -> Sensor:
    """The sensor with a fitted effect in place of its own."""
    found = sensor.having(effect)
    known = found.std | ({(effect.name, parameter): std} if std > 0 else {})
    return replace(found, fitted=found.fitted | {effect.name}, std=known)


def _full(stack: MapStack, camera: Camera) -> NDArray[np.floating]:
    """(h, w) the first map read at every pixel."""
    v = np.interp(np.arange(camera.height), stack.v, np.arange(len(stack.v)))
    u = np.interp(np.arange(camera.width), stack.u, np.arange(len(stack.u)))
    return map_coordinates(stack.maps[0], np.meshgrid(v, u, indexing="ij"), order=1, mode="nearest")


def _radial(table: Tabulated, camera: Camera, stack: MapStack, triangulating: bool) -> NDArray[np.floating]:
    """(rows, columns) a table over the radius, read at the middle of each tile."""
    if table.variables != ("radius",):
        raise ValueError(f"a table over {table.variables} cannot go into a stack")
    radius = np.hypot(stack.v[:, None] - camera.cy, stack.u[None, :] - camera.cx)
    return interpolated(np.asarray(table.values_px if triangulating else table.values), table.grid, [radius])
