"""How far a mesh stands from a reference: aligned, then signed distances in both directions, per area of surface."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fusion.errors import MeshError
from fusion.files.json_values import json_text, json_values
from fusion.mesh.alignment.align import Alignment, align_meshes
from fusion.mesh.alignment.coarse import NEAR
from fusion.mesh.alignment.similarity import Array, Similarity
from fusion.mesh.alignment.units import in_metres, size
from fusion.mesh.comparison.cloud_facing import cloud_facing
from fusion.mesh.comparison.completeness import UNSEEN_M, completeness_of
from fusion.mesh.comparison.distances import MeshSurface, Surface, surface_of
from fusion.mesh.comparison.mirrored import mirrored_note
from fusion.mesh.comparison.notes import freedom_note, itself_note, scale_note
from fusion.mesh.comparison.statistics import (
    OVER,
    SIGMA,
    DistanceStatistics,
    Knowable,
    fscore,
    histogram,
    knowable,
    over_sigma,
)
from fusion.mesh.comparison.surface_samples import sample_surface, vertex_normals
from fusion.mesh.files import write_mesh
from fusion.mesh.mesh import Mesh
from fusion.progress import stage

_SEED = 1  # of the samples on the mesh


@dataclass(frozen=True, eq=False)
class CompareSettings:
    """What to compare.

    Attributes:
        align: find the pose first; else both stand in one frame already.
        scale: find one scale as well (needs `align`).
        near: both stand in one frame but for small errors: only where the mesh does not fit so is its pose looked for.
        max_distance: the mesh further away than this [m] is left out of the accuracy, e.g. the table around an object.
        seen: (n, 3) points of the reference, in its own frame and unit, that the camera saw; the completeness is
            about these only.
        samples: points on each surface.
        unit: of the reference, "m", "cm", "mm" or "inch"; None: told from the sizes.
    """

    align: bool = True
    scale: bool = False
    near: bool = False
    max_distance: float | None = None
    seen: Array | None = None
    samples: int = 200_000
    unit: str | None = None


@dataclass(frozen=True, eq=False)
class Comparison:
    """A mesh against its reference; lengths in metres.

    Attributes:
        alignment: pose, scale and how well they are known.
        accuracy: of the mesh's surface to the reference, positive outside of it.
        completeness: of the reference's surface to the mesh, positive outside of the mesh; without what was never seen.
        completeness_all: the same with everything.
        unseen_share: 0-1, of the reference's surface that `completeness` leaves out.
        left_out_share: 0-1, of the mesh's surface that `max_distance` leaves out of `accuracy`.
        fscore: by limit [m].
        histogram: counts and edges [m] of the signed distances behind `accuracy`.
        mesh: in the reference's frame, with scalars["signed_distance"] [m] and colours that show it; where it carries
            "sigma" [m], with "deviation_over_sigma" too.
        reference: in metres.
        notes: what was recognised or left out, in sentences.
    """

    alignment: Alignment
    accuracy: DistanceStatistics
    completeness: DistanceStatistics
    completeness_all: DistanceStatistics
    unseen_share: float
    left_out_share: float
    fscore: dict[str, float]
    histogram: dict[str, list[float]]
    mesh: Mesh
    reference: Mesh
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        found, back = self.accuracy, self.completeness
        first = f"{1e3 * found.rms:.2f} mm rms, mean {1e3 * found.mean_signed:+.2f} mm, scale {self.scale:.4f}"
        shares = f"{found.within['0.002']:.1%} of the mesh and {back.within['0.002']:.1%} of the reference"
        return f"<Comparison: {first} ({self.alignment.status});\n {shares} within 2 mm>"

    @property
    def knowable(self) -> Knowable | None:
        """What of the deviations the scan's own uncertainty explains; None where the mesh carries no sigma."""
        return knowable(self.mesh)

    @property
    def scale(self) -> float:
        """What the mesh is multiplied with; 1 unless it was asked for."""
        return self.alignment.scale

    @property
    def scale_interval(self) -> tuple[float, float] | None:
        """95 % interval of the scale."""
        return self.alignment.scale_interval

    @property
    def T_reference_mesh(self) -> Array:
        """(4, 4) of rotation and translation."""
        return self.alignment.T_reference_mesh

    def to_dict(self) -> dict[str, Any]:
        """`comparison.json`; numbers that do not exist are None."""
        content: dict[str, Any] = {
            "scale": self.scale,
            "scale_interval": self.scale_interval,
            "T_reference_mesh": self.T_reference_mesh,
            "alignment": self.alignment.status,
            "inlier_share": self.alignment.inlier_share,
        }
        names = ("accuracy", "completeness", "completeness_all", "unseen_share", "left_out_share", "fscore")
        content |= {name: getattr(self, name) for name in names}
        known = self.knowable
        content["sigma"] = None if known is None else known.values()
        return dict(json_values(content | {"histogram": self.histogram, "notes": self.notes}))


def compare(mesh: Mesh, reference: Mesh, settings: CompareSettings | None = None) -> Comparison:
    """Compare a mesh or point cloud with a reference mesh or point cloud; the same input gives the same numbers.

    Raises:
        MeshError: a surface without area, too few points, bad settings, nothing of the mesh near the reference.

    >>> ball = fusion.read_mesh("ball.ply")
    >>> larger = fusion.Mesh(1.02 * ball.vertices, ball.faces)
    >>> found = fusion.compare(larger, ball, fusion.CompareSettings(align=False, samples=2000))
    >>> print(f"{1e3 * found.accuracy.mean_signed:.1f} mm outside")
    1.0 mm outside
    """
    settings = settings or CompareSettings()
    _check(settings)
    mesh, reference, factors, notes = in_metres(mesh, reference, settings.unit)
    notes += itself_note(mesh, reference)
    surfaces = surface_of(mesh), surface_of(reference)
    if isinstance(surfaces[1], MeshSurface):
        reference = surfaces[1].wound.applied(reference)
        notes += surfaces[1].wound.notes()
    seen = None if settings.seen is None else np.asarray(settings.seen, np.float64) * factors[1]
    alignment = Alignment(np.eye(4), status="not asked")
    if settings.align:
        with stage("aligning"):
            alignment = align_meshes(mesh, reference, settings.scale, surfaces, seen, near=settings.near)
    if alignment.status == "poor":
        sizes = f"{size(mesh):.3g} m and {size(reference):.3g} m from end to end"
        do = "" if settings.unit else " Unless these are metres, name the reference's unit with --unit."
        told = f"No pose was found in which the mesh fits the reference ({sizes}); the distances mean nothing."
        notes.append(told + do)
    if settings.scale and not settings.align:
        notes.append("The scale was not looked for, as nothing was aligned.")
    pose = alignment.similarity()
    with stage("measuring"):
        looks = cloud_facing(mesh, reference, surfaces, pose)
        reference, surfaces = looks.reference, (surfaces[0], looks.surface)
        notes += looks.notes
        there, left_out = _accuracy(mesh, surfaces[1], pose, settings, notes)
    accuracy = DistanceStatistics.of(there)
    mirror: list[str] = []
    if settings.align and not left_out and not (settings.near and alignment.status == "kept"):
        with stage("aligning"):
            mirror = mirrored_note(mesh, reference, surfaces[1], pose, accuracy.rms)
    notes += mirror or freedom_note(alignment) + scale_note(alignment)  # of a mirror image distances mean nothing
    with stage("measuring"):
        # three times the scan's own error, by what lies near the reference: a table around the object is no error
        close = np.abs(there)[np.abs(there) <= NEAR * size(reference)]
        error = 3 * float(np.percentile(close, 95)) if len(close) else 0.0
        back = completeness_of(reference, surfaces, pose, settings.samples, error, seen)
    notes += back.notes
    completeness = DistanceStatistics.of(back.distances[~back.unseen])
    return Comparison(
        alignment=alignment,
        accuracy=accuracy,
        completeness=completeness,
        completeness_all=DistanceStatistics.of(back.distances),
        unseen_share=float(back.unseen.mean()),
        left_out_share=left_out,
        fscore=fscore(accuracy, completeness),
        histogram=histogram(there),
        mesh=_with_distances(mesh, surfaces[1], pose),
        reference=reference,
        notes=tuple(notes),
    )


def write_comparison(folder: Path, comparison: Comparison, more: Mapping[str, object] | None = None) -> None:
    """Write `comparison.json` (with more keys) and `distance.ply` (`scalar_signed_distance` [m]) into a folder."""
    text = json_text(comparison.to_dict() | dict(more or {})) + "\n"
    (Path(folder) / "comparison.json").write_text(text, encoding="utf-8")
    write_mesh(Path(folder) / "distance.ply", comparison.mesh)


def _check(settings: CompareSettings) -> None:
    limit, seen = settings.max_distance, settings.seen
    if limit is not None and not (np.isfinite(limit) and limit > 0):
        raise MeshError("bad largest distance", "max_distance", limit, "metres, above 0")
    if settings.samples < 100:
        raise MeshError("too few samples", "samples", settings.samples, "100 or more")
    if seen is not None:
        shape = np.shape(seen)
        if len(shape) != 2 or shape[1] != 3 or not shape[0] or not np.isfinite(seen).all():
            raise MeshError("bad seen points", "seen", f"an array {shape}", "finite points (n, 3)")


def _accuracy(
    mesh: Mesh, reference: Surface, pose: Similarity, settings: CompareSettings, notes: list[str]
) -> tuple[Array, float]:
    """Signed distances of the mesh's surface that counts [m], and the share that does not."""
    samples = sample_surface(mesh, settings.samples, _SEED)
    normals = None if samples.normals is None else samples.normals @ pose.rotation.T
    found = reference.closest(pose.apply(samples.points), normals)
    distances, limit = found.distances, settings.max_distance
    if limit is None:
        far = float(np.mean(np.abs(distances) > 0.1 * size(mesh)))
        beyond = float(np.mean(found.on_border & (np.abs(distances) > UNSEEN_M)))
        if beyond > 0.02:
            notes.append(
                f"{beyond:.1%} of the mesh lies beyond where the reference ends, which is not closed: neither error "
                f"nor outside or inside, but in the accuracy and the bias; --max-distance {UNSEEN_M:g} leaves it out."
            )
        elif far > 0.02:
            notes.append(f"{far:.1%} of the mesh lies far from the reference; --max-distance leaves it out.")
        return distances, 0.0
    near = np.abs(distances) <= limit
    if not near.any():
        nearest = f"the nearest {np.abs(distances).min():.4g} m away"
        raise MeshError("nothing of the mesh is near the reference", "max_distance", nearest, f"within {limit:g} m")
    share = float(np.mean(~near))
    if share:
        notes.append(f"{share:.1%} of the mesh lies more than {limit:g} m away and was left out of the accuracy.")
    return distances[near], share


def _with_distances(mesh: Mesh, reference: Surface, pose: Similarity) -> Mesh:
    vertices = pose.apply(mesh.vertices)
    normals = mesh.normals if mesh.normals is not None else vertex_normals(mesh) if len(mesh.faces) else None
    normals = None if normals is None else normals.astype(np.float64) @ pose.rotation.T
    distances = reference.closest(vertices, normals).distances
    over = over_sigma(mesh, distances, pose.scale)
    scaled = {} if over is None else {SIGMA: pose.scale * mesh.scalars[SIGMA], OVER: over}
    return Mesh(
        vertices=vertices,
        faces=mesh.faces,
        normals=None if normals is None else normals.astype(np.float32),
        colors=_colors(distances),
        scalars=mesh.scalars | {"signed_distance": distances.astype(np.float32)} | scaled,
    )


def _colors(distances: Array) -> Any:
    """Red outside, blue inside, strongest where 5 % lie further away (n, 3) uint8."""
    from matplotlib import colormaps

    half = max(float(np.percentile(np.abs(distances), 95)), 1e-6)
    return colormaps["RdBu_r"](np.clip(distances / half, -1, 1) * 0.5 + 0.5, bytes=True)[:, :3]
