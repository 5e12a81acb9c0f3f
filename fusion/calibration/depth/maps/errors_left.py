"""What a calibration leaves of errors of depth over image and distance, by all that it knows of itself."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from fusion.calibration.depth.laws.fitted import FitSetting
from fusion.calibration.depth.laws.terms import LawTerm, length, pixels
from fusion.calibration.depth.maps.curve import light_of, span
from fusion.calibration.depth.maps.left_out import Laws, law_errors
from fusion.calibration.depth.maps.surface import MapStack
from fusion.calibration.depth.walls.samples import samples_at
from fusion.calibration.depth.walls.wall import Wall
from fusion.sensor.depth_errors import DepthErrors

ROWS, COLUMNS = 7, 9  # of the grid: laws are of the fourth order over the image at most
STEP = 0.02  # [m] of depth, a tenth of the shortest wave that matters
FEWEST, MOST = 16, 100  # depths of the grid
BEYOND = 1.25  # factor by which the grid goes on beyond the nearest and farthest wall
DROPPED = 1e-4  # share of the variance that may be lost with the smallest of errors that are many
Array = NDArray[np.floating]


def errors_left(
    walls: list[Wall],
    laws: Laws,
    unseen: list[LawTerm],
    stack: MapStack | None,
    setting: FitSetting,
) -> DepthErrors:
    """Five causes together: the law's numbers by their covariance, in which the walls' scatter is; straight terms that
    it leaves out, of usual size as far as the walls allow; that another law may hold, by how far the others lie from
    it, each by its weight; what the walls cannot show over the image, of its usual size; and the map, by how walls
    differ from it.

    Args:
        walls: as read.
        laws: the law in use and others.
        unseen: terms that the walls cannot show.
        stack: what is left per pixel, or None.
        setting: camera and known sensor.
    """
    camera, known = setting.camera, setting.known
    near, far = span(walls)
    depth = np.linspace(near / BEYOND, far * BEYOND, int(np.clip((far - near) / STEP, FEWEST, MOST)))
    v, u = (np.linspace(0, n - 1, k).round() for n, k in ((camera.height, ROWS), (camera.width, COLUMNS)))
    V, U, Z = (grid.ravel() for grid in np.meshgrid(v, u, depth, indexing="ij"))
    at = samples_at(np.array([U, V], np.intp), Z, camera, known, light_of(walls))
    of_numbers, apart = law_errors(laws, at)
    usual = [term.typical * term.change(at) for term in unseen if term.shape]
    unit = (pixels if known.principle.triangulates else length)(lambda samples: np.ones(len(samples.depth)))(at)
    of_map = [] if stack is None else [unit * _read(error, stack, (V, U)) for error in stack.errors]
    fields = np.vstack([of_numbers.T, *usual, *_largest([*apart.T, *of_map])])
    shape = (-1, len(v), len(u), len(depth))
    return DepthErrors(v, u, depth, np.asarray(fields, float).reshape(shape))


def _read(error: Array, stack: MapStack, place: tuple[Array, Array]) -> Array:
    """(n,) an error (rows, columns) of a map at rows and columns [px]."""
    at = [np.interp(x, nodes, np.arange(len(nodes))) for x, nodes in zip(place, (stack.v, stack.u), strict=True)]
    return np.asarray(map_coordinates(error, at, order=1, mode="nearest"))


def _largest(errors: list[Array]) -> Array:
    """(r, n) as few independent errors as make these, (n,) each."""
    if not errors:
        return np.zeros((0, 0))
    _, size, kept = np.linalg.svd(np.array(errors), full_matrices=False)
    rest = np.cumsum(size[::-1] ** 2)[::-1]
    return np.asarray(size[:, None] * kept)[rest > DROPPED * rest[0]]
