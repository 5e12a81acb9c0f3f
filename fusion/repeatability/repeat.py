"""Several scans of one object: how well they repeat."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import MeshError
from fusion.files.json_values import json_values
from fusion.mesh.alignment.units import LARGE, size
from fusion.mesh.comparison.statistics import SIGMA
from fusion.mesh.mesh import Mesh
from fusion.progress import stage
from fusion.quantity import DIAMETER, SPACING
from fusion.repeatability.alike import AgainstOthers, DifferingPlace, against_others, differing_place
from fusion.repeatability.features import Features, StatedArtefact, features_of
from fusion.repeatability.numbers import (
    Repeatability,
    Reproducibility,
    repeatability,
    reproducibility,
)
from fusion.repeatability.spread import ScanSpread, spread_of
from fusion.repeatability.together import Together, lay_together

Array = NDArray[np.float64]
LIKE = 3.0  # times as large as another scan of the object, where that shows a part of it (guess)


@dataclass(frozen=True)
class RepeatSettings:
    """How scans are compared with each other.

    Attributes:
        conditions: how many of the scans, in their order, belong to each condition (another day, camera, operator);
            empty: all to one.
        diameter, spacing: of a calibrated artefact's spheres [m], where they are known.
        names: of the scans; empty: numbers.
    """

    conditions: tuple[int, ...] = ()
    diameter: float | None = None
    spacing: float | None = None
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        DIAMETER.check(self.diameter)
        SPACING.check(self.spacing)


@dataclass(frozen=True)
class ScanOffset:
    """One scan about the mean surface."""

    # name, alignment: of the scan, and how well it was laid on the others
    name: str
    alignment: str
    # mean_m, rms_m: None where it shows nothing of the surface
    mean_m: float | None
    rms_m: float | None
    # missing_share: of the surface, that it does not show
    missing_share: float
    # off_others_m, others_apart_m: rms to another scan, and of the others to each other (medians); None of two scans
    off_others_m: float | None
    others_apart_m: float | None
    T_common_scan: Array  # (4, 4) into the common frame


@dataclass(frozen=True)
class Repeat:
    """n scans of one object about their mean.

    Attributes:
        names: of the scans.
        together: where each lies in the common frame.
        spread: the mean surface and the offsets of each scan.
        repeatability: under one condition; reproducibility: over several, None where there is one.
        features: planes and spheres.
        others: each scan against the others, None where there are less than three.
        place: where they differ far more than elsewhere.
        sigma: median of what the scans themselves claim [m], without what calibration shares; None where they do not.
    """

    names: tuple[str, ...]
    together: Together
    spread: ScanSpread
    repeatability: Repeatability
    reproducibility: Reproducibility | None
    features: Features = field(default_factory=Features)
    others: tuple[AgainstOthers | None, ...] = ()
    place: DifferingPlace | None = None
    sigma: float | None = None

    @property
    def mean(self) -> Mesh:
        """The mean surface, with the scalars "spread" [m] and "scans"."""
        return self.spread.mean

    def offsets(self) -> list[ScanOffset]:
        """How each scan lies about the mean surface."""
        rows = []
        beside = self.others or (None,) * len(self.names)
        for name, T, column, status, one in zip(
            self.names, self.together.poses, self.spread.offsets.T, self.together.status, beside, strict=True
        ):
            known = column[np.isfinite(column)]
            mean, rms = (float(known.mean()), float(np.sqrt(np.mean(known**2)))) if len(known) else (None, None)
            missing = float(1 - len(known) / max(len(column), 1))
            off, apart = (None, None) if one is None else (one.off, one.apart)
            status = "poor" if one is not None and one.lost else status
            rows.append(ScanOffset(name, status, mean, rms, missing, off, apart, T))
        return rows

    def to_dict(self) -> dict[str, Any]:
        """`repeat.json`."""
        known = self.reproducibility
        claimed = None if self.sigma is None else {
            "median_m": self.sigma, "spread_over_sigma": self.repeatability.s / self.sigma
        }  # fmt: skip
        content = {
            "format": "fusion-repeat/1",
            "scans": self.offsets(),
            "repeatability": self.repeatability.values(),
            "reproducibility": None if known is None else known.values(),
            "differing_place": self.place,
            "vdi_2634": [quantity.figures() for quantity in self.features.quantities],
            "sigma": claimed,
        }
        return dict(json_values(content))

    def __repr__(self) -> str:
        said = f"s_r {1e3 * self.repeatability.s:.2f} mm"
        return f"<Repeat: {len(self.names)} scans, {said}, {len(self.features.found)} planes and spheres>"


def repeat(scans: Sequence[Mesh], settings: RepeatSettings | None = None) -> Repeat:
    """Lay scans of one object on each other, none as the reference, and tell how they spread.

    Raises:
        MeshError: fewer than two scans, one without a surface, one given twice, sizes that no object has both of,
            conditions that do not add up.

    >>> ball = fusion.read_mesh("ball.ply")
    >>> found = fusion.repeat([ball, fusion.Mesh(ball.vertices + 0.001, ball.faces)])
    >>> found
    <Repeat: 2 scans, s_r 0.00 mm, 1 planes and spheres>
    """
    settings = settings or RepeatSettings()
    meshes = list(scans)
    if len(meshes) < 2:
        raise MeshError("too few scans to repeat", "scans", len(meshes), "two or more of one object")
    condition = _conditions(settings, len(meshes))
    names = settings.names or tuple(f"scan {k}" for k in range(1, len(meshes) + 1))
    _check_scans(meshes, names)
    together = lay_together(meshes)
    with stage("measuring"):
        spread = spread_of(meshes, together)
        found = repeatability(spread.offsets, condition)
        if not np.isfinite(found.s):
            raise MeshError("the scans have no surface in common", "scans", "no place that two show", "one object")
        others = against_others(spread.at, spread.offsets, condition)
        stated = StatedArtefact(settings.diameter, settings.spacing)
        features = (
            Features()  # what does not lie on each other has no forms
            if "poor" in together.status or any(one is not None and one.lost for one in others)
            else features_of(spread.mean, meshes, together.poses, found.s, stated)
        )
        place = differing_place(spread.at.points, spread.offsets)
    across = reproducibility(spread.offsets, condition)
    return Repeat(names, together, spread, found, across, features, tuple(others), place, _claimed(meshes))


def _check_scans(meshes: list[Mesh], names: tuple[str, ...]) -> None:
    """That no scan is there twice, and that all may show one object in metres."""
    for k, mesh in enumerate(meshes):
        for name, other in zip(names, meshes[:k], strict=False):
            if np.array_equal(mesh.vertices, other.vertices) and np.array_equal(mesh.faces, other.faces):
                found = f"each vertex where {name} has it"
                raise MeshError("a scan is given twice", names[k], found, "scans of their own", "leave it out")
    sizes = [size(mesh) for mesh in meshes]
    least, most = int(np.argmin(sizes)), int(np.argmax(sizes))
    if not sizes[most] < min(LIKE * sizes[least], LARGE):
        found = f"{sizes[most]:.4g} m from end to end, {names[least]} {sizes[least]:.4g} m"
        raise MeshError("scans of other sizes", names[most], found, "one object, in metres", "see the unit of each")


def _conditions(settings: RepeatSettings, count: int) -> NDArray[np.intp]:
    sizes = settings.conditions or (count,)
    if sum(sizes) != count or min(sizes) < 1:
        found = " + ".join(map(str, sizes))
        raise MeshError("the conditions do not add up", "conditions", found, f"numbers of scans, together {count}")
    return np.repeat(np.arange(len(sizes)), sizes)


def _claimed(meshes: list[Mesh]) -> float | None:
    claims = [mesh.scalars[SIGMA] for mesh in meshes if SIGMA in mesh.scalars]
    known = np.concatenate(claims) if len(claims) == len(meshes) else np.zeros(0)
    known = known[np.isfinite(known)]
    middle = float(np.median(known)) if len(known) else 0.0
    return middle if middle > 0 else None
