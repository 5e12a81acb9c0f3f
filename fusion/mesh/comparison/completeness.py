"""How much of a reference a mesh shows: distances the other way, and what of the reference cannot have been seen."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.alignment.similarity import Array, Similarity
from fusion.mesh.comparison.distances import MeshSurface, Surface
from fusion.mesh.comparison.enclosed import enclosed
from fusion.mesh.comparison.surface_samples import sample_surface
from fusion.mesh.mesh import Mesh

# nearer than this the reference counts as seen, however good the scan; absolute: depth cameras leave rims open so wide,
# of objects as of rooms
UNSEEN_M = 0.010
_SEED = 2  # of the samples
_WORTH = 5e-4  # telling: less is 0.0 %


@dataclass(frozen=True, eq=False)
class Completeness:
    """The reference's surface against the mesh, n samples."""

    distances: Array  # (n,) [m], positive outside of the mesh
    unseen: NDArray[np.bool_]  # (n,) True where the scan cannot have seen it
    notes: tuple[str, ...]


def completeness_of(
    reference: Mesh,
    surfaces: tuple[Surface, Surface],
    pose: Similarity,
    samples: int,
    error: float,
    seen: Array | None = None,
) -> Completeness:
    """Distances of the reference to the mesh, and which of it was never seen.

    Never seen is what stands within the reference itself, and, where the mesh is not closed, what lies beyond its
    borders or looks the other way than the surface next to it (the back of a thin plate).

    Args:
        reference: in metres.
        surfaces: of mesh and reference.
        pose: of the mesh on the reference.
        samples: points on the reference.
        error: of the scan [m]: what is nearer is shown.
        seen: (n, 3) points [m] that were seen; nothing else is asked for, and all of them are counted.
    """
    points = sample_surface(reference if seen is None else Mesh(seen), samples, _SEED)
    normals = None if points.normals is None else points.normals @ pose.rotation
    found = surfaces[0].closest(pose.apply_inverse(points.points), normals)
    distances = found.distances * pose.scale
    unseen = np.zeros(len(distances), bool)
    if seen is not None:
        return Completeness(
            distances, unseen, (f"The completeness is over {len(unseen)} points that were named as seen.",)
        )
    notes, away = [], np.abs(distances) > error
    if isinstance(surfaces[1], MeshSurface):
        rows = np.flatnonzero(away)
        unseen[rows] = enclosed(surfaces[1], points.points[rows])
        if unseen.mean() > _WORTH:
            notes.append(
                f"{unseen.mean():.1%} of the reference stands within it (walls from inside, solids that overlap, "
                f"deep bores), where nothing can see it: left out of the completeness, not of completeness_all."
            )
    # a closed mesh claims to show everything; an open one may have far more missing than what lies right at its border
    if found.on_border.any():
        far = np.abs(distances) > max(UNSEEN_M, error)
        if normals is not None:
            far |= away & _behind(normals, found.normals, away)
        beyond = far & ~unseen
        unseen |= beyond
        if beyond.mean() > _WORTH:
            notes.append(
                f"{beyond.mean():.1%} of the reference lies far from the mesh or behind it, which is not closed: "
                f"counted as never seen and left out of the completeness; completeness_all holds everything."
            )
    return Completeness(distances, unseen, tuple(notes))


def _behind(here: Array, there: Array, away: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Where normals (n, 3) look apart; nowhere, if most of what lies on the mesh does: one is inside out."""
    apart = np.einsum("ij,ij->i", here, there) < 0
    return apart if apart[~away].sum() <= 0.5 * (~away).sum() else np.zeros_like(apart)
