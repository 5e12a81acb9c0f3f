"""The pixels at which the terms of a law are computed: laws are smooth, so some in each tile stand for all."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.walls.tiles import TileGrid
from fusion.calibration.depth.walls.wall import Wall
from fusion.geometry.camera import Camera, Principle
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import stretch

PER_TILE = 5  # samples across a tile: the shortest wave turns by less than a tenth between two of them
Array = NDArray[np.floating]


@dataclass(frozen=True)
class WallSamples:
    """Pixels (n,) of one wall, as far as terms ask for them."""

    depth: Array  # true depth [m]
    seen: Array  # depth of the plane through what was measured [m]
    stretch: Array  # length of the ray per metre of depth
    # u, v: from the principal point [px]
    u: Array
    v: Array
    ir: Array | None  # amplitude [count], or None
    focal_baseline: float  # disparity times depth [px m]
    reach: float  # half of the image's diagonal [px]: where the radial terms are 1
    time_of_flight: bool  # True when the sensor measures along the ray
    label: NDArray[np.intp]  # tile of each
    gloss: Array | None = None  # change of the range per unit of mirrored light [m], or None

    @property
    def along_ray(self) -> Array:
        """(n,) depth per metre of an error of length."""
        return 1.0 / self.stretch if self.time_of_flight else np.ones(len(self.stretch))

    @property
    def distance(self) -> Array:
        """(n,) what a curve runs over [m]: the range for time of flight, else the depth."""
        return self.depth * self.stretch if self.time_of_flight else self.depth

    def tile_means(self, values: Array) -> Array:
        """(t,) means over the samples of each tile."""
        return np.bincount(self.label, values) / np.bincount(self.label)


def samples_of(wall: Wall, camera: Camera, sensor: Sensor, tiles: TileGrid) -> WallSamples:
    """Samples of a wall: a grid of pixels, and all of them in tiles that the grid misses."""
    step = max(1, tiles.side // PER_TILE)
    on_grid = np.zeros(camera.shape, bool)
    on_grid[step // 2 :: step, step // 2 :: step] = True
    taken = on_grid & (tiles.label >= 0)
    missed = np.bincount(tiles.label[taken], minlength=len(tiles.count)) == 0
    taken |= (tiles.label >= 0) & missed[tiles.label]
    v, u = np.nonzero(taken)
    return WallSamples(
        wall.true_plane.depth(camera)[taken],
        wall.plane.depth(camera)[taken],
        stretch(camera).astype(float)[taken],
        u - camera.cx,
        v - camera.cy,
        None if wall.ir is None else np.nan_to_num(wall.ir[taken]),
        camera.fx * abs(sensor.baseline),
        reach(camera),
        sensor.principle == Principle.TIME_OF_FLIGHT,
        tiles.label[taken],
        None if wall.gloss is None else wall.gloss[taken],
    )


def samples_on_axis(depth: Array, camera: Camera, sensor: Sensor, light: float) -> WallSamples:
    """Depths (n,) [m] on the optical axis, where a wall sends back `light` / range^2 counts (0: no IR)."""
    zero = np.zeros(len(depth))
    return _samples((zero, zero), depth, zero + 1, camera, sensor, light)


def samples_at(pixels: NDArray[np.intp], depth: Array, camera: Camera, sensor: Sensor, light: float) -> WallSamples:
    """Depths (n,) [m] at columns and rows (2, n) of the image, of such walls."""
    u, v = pixels
    along = stretch(camera).astype(float)[v, u]
    return _samples((u - camera.cx, v - camera.cy), depth, along, camera, sensor, light)


def _samples(
    place: tuple[Array, Array], depth: Array, along: Array, camera: Camera, sensor: Sensor, light: float
) -> WallSamples:
    ir = light / (depth * along) ** 2 if light > 0 else None
    baseline = camera.fx * abs(sensor.baseline)
    flight = sensor.principle == Principle.TIME_OF_FLIGHT
    return WallSamples(depth, depth, along, *place, ir, baseline, reach(camera), flight, np.arange(len(depth)))


def reach(camera: Camera) -> float:
    """Half of the image's diagonal [px]."""
    return 0.5 * float(np.hypot(*camera.shape))
