"""Colours of the texels: what is coarse is the mean of all good views, what is fine comes from the best.

Exposure and light are taken out of each view first. So what light is left leaves no seam, and print is not smeared by
poses that are off by a pixel (Allene, Pons and Keriven, Seamless image-based texture atlases using multi-band blending,
ICPR 2008).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fusion.coloring.images import bilinear
from fusion.coloring.surface import RayMesh
from fusion.errors import MeshError
from fusion.geometry.pose import Array, inverse, transform
from fusion.mesh.mesh import Mesh
from fusion.texture.lighting.exposure import SampledView
from fusion.texture.lighting.levels import Levels, levels_of
from fusion.texture.lighting.light import Facings, Lighting
from fusion.texture.settled import settled, without_common
from fusion.texture.views import Views

SAMPLES = 10_000  # points at which views are compared
# power of the weights of what is fine. Left-out images want all views (1, or 2: the same), hard choices lose: 0.1 dB by
# 4, 0.3 by 8 (tools/reproduce/scans/texture_held_out.py, a simulated and a real scan)
BEST = 2.0
ROUNDS = 2  # of settling the cameras, each on what the last one has made


@dataclass(frozen=True)
class Painted:
    """Colours of points."""

    colors: NDArray[np.float32]  # (k, 3) [counts]; no meaning where no view shows a point
    seen: NDArray[np.bool_]  # (k,) shown by a view
    images: int  # how many were used
    gain: NDArray[np.float32]  # (views, 3) by which factor each image was made brighter; 1 where it could not be read
    views: Views  # the images, their cameras settled
    lights: list[Lighting]  # before each of their cameras


class ColorMean:
    """Weighted means of colours at points, added up view by view."""

    def __init__(self, points: int) -> None:
        self.weight = np.zeros((points, 1), np.float32)
        self._sum = np.zeros((points, 3), np.float32)

    def add(self, index: NDArray[np.int64], weight: NDArray[np.float32], colors: NDArray[np.float32]) -> None:
        """Colours (k, 3) of points `index` (k,), each once, with weights (k,)."""
        self.weight[index, 0] += weight
        self._sum[index] += weight[:, None] * colors

    def value(self) -> NDArray[np.float32]:
        """(points, 3); 0 where there is none."""
        return np.asarray(self._sum / np.maximum(self.weight, 1e-30), np.float32)


def painted(points: Mesh, mesh: Mesh, views: Views) -> Painted:
    """Colours of points (k) with normals on a mesh, from views of it."""
    some = _some(mesh)
    sampled = RayMesh(mesh, some)
    levels, numbers, fine = _compared(sampled, views)
    stated = views.T_world_color
    for _ in range(ROUNDS):
        views, fine = _settled(sampled, some, views, stated, levels, numbers, fine)
    _, nearest = cKDTree(some.vertices).query(points.vertices)
    surface, count = RayMesh(mesh, points), len(points.vertices)
    low, high = ColorMean(count), ColorMean(count)
    for shot in views.shots(surface, "texture"):
        at, shown = numbers[shot.number], shot.shows(surface)
        good = shown.weight * levels.trust[at, nearest[shown.index]]
        coarse, print_ = shot.at(shown.pixels)
        even = levels.even(at, Facings.of(surface, shown.index, shot.T_world_color))
        low.add(shown.index, good, coarse * even)
        high.add(shown.index, (good * levels.sharp[at] ** 2) ** BEST, print_ * even)
    gain = np.ones((len(views.frames), 3), np.float32)
    gain[list(numbers)] = levels.gain[list(numbers.values())]
    colors = np.clip(low.value() + high.value(), 0, 255)
    return Painted(colors, low.weight[:, 0] > 0, len(numbers), gain, views, levels.lights)


def _some(mesh: Mesh) -> Mesh:
    """Some vertices of a mesh, as points."""
    count = len(mesh.vertices)
    rows = np.sort(np.random.default_rng(0).permutation(count)[:SAMPLES])
    return Mesh(mesh.vertices[rows], normals=np.asarray(mesh.normals)[rows])


def _compared(surface: RayMesh, views: Views) -> tuple[Levels, dict[int, int], NDArray[np.float32]]:
    """How views compare, the row of each that could be read, and the fine colours of the points."""
    looks: list[SampledView] = []
    numbers: dict[int, int] = {}
    fine = ColorMean(surface.vertices.shape[1])
    for shot in views.shots(surface, "exposure"):
        shown = shot.shows(surface)
        low, high = shot.at(shown.pixels)
        numbers[shot.number] = len(looks)
        facing = Facings.of(surface, shown.index, shot.T_world_color)
        source = views.recordings[shot.number]
        looks.append(SampledView(source, shown.index, facing, shown.weight, low, np.abs(high).mean(axis=1)))
        fine.add(shown.index, shown.weight, high)
    if not any(len(look.index) for look in looks):
        do = "see its unit, and whether it stands where the recordings say"
        raise MeshError("no image shows the mesh", "mesh", f"{len(looks)} images of something else", do=do)
    return levels_of(looks, surface.vertices.shape[1]), numbers, fine.value()


def _settled(
    surface: RayMesh,
    some: Mesh,
    views: Views,
    stated: Array,
    levels: Levels,
    numbers: dict[int, int],
    fine: NDArray[np.float32],
) -> tuple[Views, NDArray[np.float32]]:
    """Views whose cameras fit the fine colours of sample points, and what these are then."""
    poses, mean = views.T_world_color.copy(), ColorMean(len(some.vertices))
    for shot in views.shots(surface, "settling"):
        number, shown = shot.number, shot.shows(surface)
        points = some.vertices[shown.index]
        even = levels.even(numbers[number], Facings.of(surface, shown.index, shot.T_world_color))
        high, print_ = shot.bands.high, fine[shown.index] / even
        poses[number] = settled(shot.source.camera, high, stated[number], poses[number], points, print_)
        pixels = shot.source.camera.project(transform(inverse(poses[number]), points))
        mean.add(shown.index, shown.weight, bilinear(high, pixels) * even)
    return replace(views, T_world_color=without_common(poses, stated)), mean.value()
