"""What each scan says of an object's planes and spheres, in the terms of VDI/VDE 2634."""

from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fusion.geometry import pose
from fusion.mesh.comparison.surface_samples import sample_surface, smooth_normals
from fusion.mesh.mesh import Mesh
from fusion.repeatability.find_forms import ALIKE, FoundForm, find_forms
from fusion.repeatability.forms import Form, Plane, Sphere, form_error, refit

Array = NDArray[np.float64]
FINDING, MEASURING = 12_000, 60_000  # points on a surface
# of the spread, and [m], half a count of most files: how far a point may lie off a form that is looked for (guess)
WIDTH, LEAST = 4.0, 5e-4
REACH = 2.0  # times that: points of a scan that belong to a form
FEWEST = 50  # points through which a form is laid


@dataclass(frozen=True)
class QuantityFigures:
    """A repeated quantity as `repeat.json` holds it, each number in `unit`."""

    name: str
    term: str
    unit: str
    values: Array
    mean: float
    std: float
    error: float | None


@dataclass(frozen=True)
class RepeatedQuantity:
    """A quantity as each scan has it."""

    name: str  # what it is, such as "plane 1" or "sphere 1 to 2"
    term: str  # in VDI/VDE 2634's words
    values: Array  # (n,) [m] or [rad] by the term; NaN where a scan does not show it
    error: float | None = None  # of the mean against a stated value [m], None where none was stated

    @property
    def mean(self) -> float:
        """Over the scans."""
        return float(np.nanmean(self.values)) if np.isfinite(self.values).any() else float("nan")

    @property
    def std(self) -> float:
        """Repeatability standard deviation over the scans; NaN with fewer than two."""
        known = self.values[np.isfinite(self.values)]
        return float(np.std(known, ddof=1)) if len(known) > 1 else float("nan")

    def figures(self) -> QuantityFigures:
        """In numbers."""
        unit = "rad" if self.term == ANGLE else "m"
        return QuantityFigures(self.name, self.term, unit, self.values, self.mean, self.std, self.error)


FORM, SIZE, SPACING, FLATNESS, ANGLE = (
    "probing error form", "diameter", "sphere spacing", "flatness", "angle between planes",
)  # fmt: skip


@dataclass(frozen=True)
class StatedArtefact:
    """What a calibrated artefact is known to have [m]; None where nothing is stated."""

    diameter: float | None = None
    spacing: float | None = None


@dataclass(frozen=True)
class Features:
    """Planes and spheres of the mean surface, and what the scans say of them."""

    found: list[FoundForm] = field(default_factory=list)
    quantities: list[RepeatedQuantity] = field(default_factory=list)


def features_of(mean: Mesh, scans: list[Mesh], poses: Array, spread: float, stated: StatedArtefact) -> Features:
    """Find forms on the mean surface, and lay each through what every scan has there."""
    samples = sample_surface(mean, FINDING)
    normals = smooth_normals(samples)
    if normals is None:
        return Features()
    width = max(WIDTH * spread, LEAST) if np.isfinite(spread) else LEAST
    found = find_forms(samples.points, normals, width)
    forms: list[list[tuple[Form, Array] | None]] = []
    for k, (scan, T) in enumerate(zip(scans, poses, strict=True)):
        points = sample_surface(scan, MEASURING, seed=k)
        assert points.normals is not None
        placed = pose.transform(T, points.points), points.normals @ T[:3, :3].T
        forms.append([_laid(one, samples.points, placed, REACH * width) for one in found])
    return Features(found, _quantities(found, forms, stated))


def _laid(one: FoundForm, at: Array, scan: tuple[Array, Array], reach: float) -> tuple[Form, Array] | None:
    """A form through the points of a scan beside its members, with these; None where the scan shows too little."""
    points, normals = scan
    near = np.abs(one.form.away(points)) < reach
    near &= np.einsum("ij,ij->i", one.form.facing(points), normals) > ALIKE / 2
    points = points[near]
    if len(points) < FEWEST:
        return None
    tree = cKDTree(at[one.members])
    spacing = float(np.median(tree.query(at[one.members], k=2)[0][:, 1]))
    points = points[tree.query(points, workers=-1)[0] < np.hypot(2 * spacing, reach)]
    return (refit(one.form, points), points) if len(points) >= FEWEST else None


def _quantities(
    found: list[FoundForm], forms: list[list[tuple[Form, Array] | None]], stated: StatedArtefact
) -> list[RepeatedQuantity]:
    spheres = [k for k, one in enumerate(found) if isinstance(one.form, Sphere)]
    planes = [k for k, one in enumerate(found) if isinstance(one.form, Plane)]

    def each(k: int, what: Any) -> Array:
        column = [row[k] for row in forms]
        return np.array([np.nan if one is None else what(one[0], one[1]) for one in column])

    def pairs(a: int, b: int, what: Any) -> Array:
        both = [(row[a], row[b]) for row in forms]
        return np.array([np.nan if x is None or y is None else what(x[0], y[0]) for x, y in both])

    out = []
    for number, k in enumerate(spheres, start=1):
        out.append(RepeatedQuantity(f"sphere {number}", FORM, each(k, form_error)))
        size = each(k, lambda form, _: 2 * form.radius)
        out.append(RepeatedQuantity(f"sphere {number}", SIZE, size, _beside(size, stated.diameter)))
    for (i, a), (j, b) in combinations(enumerate(spheres, start=1), 2):
        apart = pairs(a, b, lambda x, y: float(np.linalg.norm(x.centre - y.centre)))
        out.append(RepeatedQuantity(f"sphere {i} to {j}", SPACING, apart, _beside(apart, stated.spacing)))
    for number, k in enumerate(planes, start=1):
        out.append(RepeatedQuantity(f"plane {number}", FLATNESS, each(k, form_error)))
    for (i, a), (j, b) in combinations(enumerate(planes[:4], start=1), 2):
        out.append(RepeatedQuantity(f"plane {i} to {j}", ANGLE, pairs(a, b, _angle)))
    return out


def _angle(x: Plane, y: Plane) -> float:
    return float(np.arccos(np.clip(x.normal @ y.normal, -1, 1)))


def _beside(values: Array, stated: float | None) -> float | None:
    known = values[np.isfinite(values)]
    return None if stated is None or not len(known) else float(known.mean() - stated)
