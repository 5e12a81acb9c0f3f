"""The planes and spheres that an object has: random candidates, the best one taken, and again with the rest.

RANSAC on points with normals (Schnabel, Wahl, Klein 2007): one point tells a plane, two tell a sphere.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from fusion.repeatability.forms import Form, Plane, Sphere, refit

Array = NDArray[np.float64]
CANDIDATES = 300  # of each kind in each round
ALIKE = np.cos(np.deg2rad(20))  # between the normals of form and surface (guess)
PLANE_SHARE, SPHERE_SHARE = 0.03, 0.01  # least share of the surface (guess)
# least mean square of the normals along any axis: a third on a whole ball, a fifth on a cap that is a quarter of it,
# next to nothing on the ring that a ball shares with the rod around it (guess)
ALL_ROUND = 0.1
COVERED = 0.25  # least share of a sphere's own surface: less tells its radius badly (guess)
MOST = 12  # forms of each kind
LARGEST = 0.5  # radius of a sphere over the object's size: larger ones are bent planes
SLIM = 0.05  # of a form's own size, how far a point may lie off it: a wider band takes any lump for a form (guess)
# least share of a form's points within half its band: those of a form gather about it, the band cuts a bent surface off
GATHERED = 0.9
RIM = 3.0  # mean distances of points that are left out along a form's border, where it bends away


@dataclass(frozen=True)
class FoundForm:
    """A form, and which of the points (n,) lie on it, its rim left out."""

    form: Form
    members: NDArray[np.intp]


def find_forms(points: Array, normals: Array, width: float) -> list[FoundForm]:
    """Spheres first, then planes, each kind by its size.

    Args:
        points, normals: (n, 3) even per area.
        width: [m] a point may lie off a form.
    """
    spacing = spacing_of(points)
    left, out = np.arange(len(points)), []
    rng = np.random.default_rng(0)
    for spheres, share in ((True, SPHERE_SHARE), (False, PLANE_SHARE)):
        for _ in range(MOST):
            if len(left) < max(share * len(points), 50):
                break
            best = _best(points[left], normals[left], spheres, (width, spacing), rng)
            if best is None or len(best.members) < share * len(points):
                break
            members = left[best.members]
            left = np.setdiff1d(left, members)
            inner = _inner(points, members, spacing)
            if len(inner) > len(members) / 3 and width < SLIM * np.linalg.norm(np.ptp(points[inner], axis=0)):
                out.append(FoundForm(refit(best.form, points[inner]), inner))
    return out


def _best(
    points: Array, normals: Array, spheres: bool, scale: tuple[float, float], rng: np.random.Generator
) -> FoundForm | None:
    width, spacing = scale
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    drawn = _spheres(points, normals, size, rng) if spheres else _planes(points, normals, rng)
    some = rng.permutation(len(points))[:4000]
    counts = [int(_on(form, points[some], normals[some], width).sum()) for form in drawn]
    for k in np.argsort(counts)[::-1][:5]:
        form, members = drawn[k], np.zeros(0, np.intp)
        for _ in range(3):
            members = one_piece(points, np.flatnonzero(_on(form, points, normals, width)), spacing)
            if len(members) < 30:
                break
            form = refit(form, points[members])
        if len(members) < 30 or (isinstance(form, Sphere) and not _full(form, points[members], spacing, size)):
            continue
        if np.mean(np.abs(form.away(points[members])) < width / 2) < GATHERED:
            continue
        return FoundForm(form, members)
    return None


def _planes(points: Array, normals: Array, rng: np.random.Generator) -> list[Form]:
    chosen = rng.choice(len(points), min(CANDIDATES, len(points)), replace=False)
    return [Plane(normals[k], float(normals[k] @ points[k])) for k in chosen]


def _spheres(points: Array, normals: Array, size: float, rng: np.random.Generator) -> list[Form]:
    """Of pairs of points: where their normals come nearest to meeting."""
    a, b = rng.choice(len(points), (2, CANDIDATES))
    out: list[Form] = []
    for p, q, n, m in zip(points[a], points[b], normals[a], normals[b], strict=True):
        across = np.cross(n, m)
        if across @ across < 0.03:  # nearly parallel normals meet nowhere near
            continue
        s, t, _ = np.linalg.solve(np.column_stack([-n, m, across]), q - p)
        centre = (p - s * n + q - t * m) / 2
        radius = float((abs(s) + abs(t)) / 2)
        if s * t > 0 and radius < LARGEST * size:
            out.append(Sphere(centre, radius, 1 if s > 0 else -1))
    return out


def _on(form: Form, points: Array, normals: Array, width: float) -> NDArray[np.bool_]:
    near = np.abs(form.away(points)) < width
    return np.asarray(near & (np.einsum("ij,ij->i", form.facing(points), normals) > ALIKE))


def _full(sphere: Sphere, points: Array, spacing: float, size: float) -> bool:
    """Whether enough of a sphere is there, in all directions: a ring of it may as well be a rod."""
    # of points at random, half the mean distance to the nearest is 1 / (4 sqrt(density))
    area = len(points) * 4 * spacing**2
    facing = sphere.facing(points)
    around = float(np.linalg.eigvalsh(facing.T @ facing / len(points))[0])
    covered = area > COVERED * 4 * np.pi * sphere.radius**2
    return bool(sphere.radius < LARGEST * size and covered and around > ALL_ROUND)


def spacing_of(points: Array) -> float:
    """Median distance [m] of points (n, 3) to their nearest ones."""
    return float(np.median(cKDTree(points).query(points, k=2)[0][:, 1])) if len(points) > 2 else 0.0


def one_piece(points: Array, members: NDArray[np.intp], spacing: float) -> NDArray[np.intp]:
    """The largest part of some points (n, 3), `members` of them, that hangs together."""
    if len(members) < 2:
        return members
    pairs = cKDTree(points[members]).query_pairs(4 * spacing, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), (len(members), len(members)))
    _, part = connected_components(graph, directed=False)
    return members[part == np.argmax(np.bincount(part))]


def _inner(points: Array, members: NDArray[np.intp], spacing: float) -> NDArray[np.intp]:
    """Members that are not near to what is no member."""
    others = np.setdiff1d(np.arange(len(points)), members)
    if not len(others):
        return members
    far, _ = cKDTree(points[others]).query(points[members], workers=-1)
    return members[far > RIM * spacing]
