"""How well the depth of a scan can tell its angles at best: the Cramer-Rao bound of its pixels.

A pixel p of frame i measures, to first order,

    z = z_true + dz/da_i (a_i - true) + dz/dx x + sum_j g_j(z, q) b_j + c_k / |n . ray| + noise

with the frame's angle a_i, the axis x (two tilts, two shifts, shared by all frames), the errors b_j of depth that stand
still in the image, as drawn and then told by the walls (`information.py`; of time of flight the delays that are linear
in x and y too, as drawn, for walls at free tilts do not show them), and what is not known of the surface: an offset c_k
of each cell along its normal, which is eliminated. Derivatives are differences of the ray-traced truth. Noise: time of
flight's own of each pixel; structured light's by the dots within the pixel (a window holds each dot once, so windows
that overlap do not tell more), what stands still of it included. Rounding, fixed pattern, and what edges and windows
mix cost more, and surfaces seen at less than `GRAZING` or beside a jump take no part: nobody does better by depth
alone. The log of the table tells nothing here: it is off by a degree.

    bound = sqrt(mean diagonal of P C P),     C the inverse of the information about all angles, P takes off their mean.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from tools.sets.fresh.dots import DOTS, Dots
from tools.sets.fresh.information import posterior, terms
from tools.sets.fresh.unit import Turning, Unit
from tools.sets.fresh.views import OBJECT

Array = NDArray[np.float64]

STEP = 1e-3  # [rad], and [m] of the axis: differences are far above rounding and below a pixel
GRAZING = 0.2  # cosine
JUMP = 0.02  # [m] between neighbours: more is an edge
CELL = 1.5  # footprints of a pixel along the edge of a cell whose offset is unknown (guess)
TILTED = np.array([0.003, 0.002]) / np.sqrt(3)  # [m] std of the delays along x and y, as drawn


def angle_std(unit: Unit) -> float:
    """Root mean square [deg] of the errors of all angles after their best constant, at best."""
    flight = not isinstance(unit.device, Dots)
    n, far = len(unit.turning.true), float(np.linalg.norm(unit.table.T[:3, 3]))
    prior = posterior(unit.walls, flight)
    if flight:
        prior = np.block([[prior, np.zeros((len(prior), 2))], [np.zeros((2, len(prior))), np.diag(TILTED**2)]])
    shared = 4 + len(prior)
    H, edge, across = np.zeros((n + shared, n + shared)), CELL * far / unit.device.lens.fx, []
    for i in range(n):
        J, weight, place = _frame(unit, i, flight)
        at = np.r_[i, np.arange(n, n + shared)]
        H[np.ix_(at, at)] += J[:, :-1].T @ (weight[:, None] * J[:, :-1])
        across.append((np.floor(place / edge).astype(int), weight, J, i))
    cells = np.unique(np.concatenate([c for c, *_ in across]), axis=0, return_inverse=True)[1].ravel()
    H -= _by_cells(cells, across, n, shared)
    H[n + 4 :, n + 4 :] += np.linalg.inv(prior)
    size = np.sqrt(np.maximum(np.diag(H), 1e-30))
    covariance = (np.linalg.pinv(H / np.outer(size, size), rcond=1e-10, hermitian=True) / np.outer(size, size))[:n, :n]
    free = np.eye(n) - 1 / n
    return float(np.rad2deg(np.sqrt(np.trace(free @ covariance @ free) / n)))


def _by_cells(cells: NDArray[np.int_], across: list[tuple[Array, Array, Array, int]], n: int, shared: int) -> Array:
    """What the unknown offsets of the cells take from the information."""
    B, total, begin = np.zeros((int(cells.max()) + 1, shared)), np.zeros(int(cells.max()) + 1), 0
    own: list[list[Array]] = [[], [], []]
    for _, weight, J, i in across:
        k = cells[begin : begin + len(weight)]
        begin += len(weight)
        both = weight * J[:, -1]
        total += np.bincount(k, both * J[:, -1], len(total))
        for j in range(shared):
            B[:, j] += np.bincount(k, both * J[:, 1 + j], len(total))
        mine = np.bincount(k, both * J[:, 0], len(total))
        some = np.flatnonzero(np.bincount(k, minlength=len(total)))
        for part, x in zip(own, (mine[some], some, np.full(len(some), i)), strict=True):
            part.append(x)
    size = 1 / np.sqrt(np.maximum(total, 1e-30))
    value, row, column = map(np.concatenate, own)
    angles = csr_array((value * size[row], (row, column)), shape=(len(total), n))
    B *= size[:, None]
    mixed = angles.T @ B
    return np.asarray(np.block([[(angles.T @ angles).toarray(), mixed], [mixed.T, B.T @ B]]))


def _frame(unit: Unit, i: int, flight: bool) -> tuple[Array, Array, Array]:
    """Derivatives (m, 1 + shared + 1) of the depth of m pixels, the information of each, where they lie (m, 3)."""
    rays = unit.device.lens.rays()
    T = unit.poses()[i]
    view = unit.table.at(T).look(rays)
    taken, seen = (view.part == OBJECT) & (view.cosine > GRAZING), np.where(np.isfinite(view.z), view.z, 99.0)
    for axis, way in ((0, 1), (0, -1), (1, 1), (1, -1)):
        taken &= np.abs(np.roll(seen, way, axis) - seen) < JUMP
    ray, z, cosine = rays[taken], view.z[taken], view.cosine[taken]
    stretch = np.linalg.norm(ray, axis=1)
    steps = [
        (np.nan_to_num(unit.table.item.hit(_turned(unit.turning, i, s) @ unit.table.T, ray)[0], posinf=9.0) - z) / STEP
        for s in range(5)
    ]
    held = np.abs(steps).max(axis=0) * STEP < JUMP  # over an edge a difference is no derivative
    q = np.sum(ray[:, :2] ** 2, axis=1)
    still = [terms(z, q, flight)[0], *([ray[:, :2]] if flight else [])]
    J = np.column_stack([*steps, *still, 1 / (cosine * stretch)])
    place = (z[:, None] * ray) @ T[:3, :3].T + T[:3, 3]
    return J[held], _information(unit, z, cosine, view.reflectance[taken], stretch)[held], place[held]


def _information(unit: Unit, z: Array, cosine: Array, reflectance: Array, stretch: Array) -> Array:
    """1 / variance [1/m^2] of the depth of pixels."""
    device = unit.device
    if isinstance(device, Dots):
        per_metre = 2 * device.lens.fx * device.baseline / z**2  # full px
        return np.asarray(4 * DOTS * per_metre**2 / (device.noise**2 + device.speckle**2))
    counts = device.counts * reflectance * cosine * stretch**-device.profile / (z * stretch) ** 2
    return np.asarray((stretch / device.range_std(counts)) ** 2)


def _turned(turning: Turning, i: int, s: int) -> Array:
    """(4, 4) camera's first place to that of frame i in the object, with step s of the angle or of the axis."""
    change = np.eye(5)[s] * STEP
    angle, point = np.array([0.0, turning.true[i] - turning.true[0] + change[0]]), [*change[3:], 0.0]
    way = turning.direction + np.append(change[1:3], 0.0)
    moved = Turning(angle, angle, turning.point + point, way / np.linalg.norm(way), -1)
    return np.asarray(np.linalg.inv(moved.pose(1)))
