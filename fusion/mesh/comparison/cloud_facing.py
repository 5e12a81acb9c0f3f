"""Whether the normals of a reference that is a point cloud look outwards, beside a mesh that lies on it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.alignment.coarse import NEAR
from fusion.mesh.alignment.similarity import Similarity
from fusion.mesh.alignment.units import size
from fusion.mesh.comparison.distances import CloudSurface, MeshSurface, Surface, surface_of
from fusion.mesh.comparison.enclosed import directions
from fusion.mesh.comparison.surface_samples import sample_surface
from fusion.mesh.mesh import Mesh

_SAMPLES, _FEWEST = 20_000, 100  # on the mesh; and near the cloud at least, to be asked
_SOME = 0.1  # of the mesh, where the normals look against the cloud's: rims and noise do less (guess)
_MOST = 0.9  # of what is asked: all but for noise and rims (guess)
_WAYS = 120  # in which the cloud's farthest point is asked which way it looks
_UNSURE = (
    "where the reference has its outside, and so the bias, is uncertain; give a reference without normals, or one "
    "whose normals all look outwards."
)


@dataclass(frozen=True, eq=False)
class CloudFacing:
    """A reference whose normals look outwards as far as that can be told.

    Attributes:
        reference: so; the very one that was given where nothing was to be done.
        surface: of it.
        notes: what was done or is in doubt, in sentences.
    """

    reference: Mesh
    surface: Surface
    notes: tuple[str, ...] = ()


def cloud_facing(mesh: Mesh, reference: Mesh, surfaces: tuple[Surface, Surface], pose: Similarity) -> CloudFacing:
    """Turn the normals of a cloud where all look against a mesh that is known to look outwards, or inwards themselves.

    A cloud alone does not tell: one of a room rightly looks inwards, and so does a mesh of it.

    Args:
        mesh, reference: in metres.
        surfaces: of both.
        pose: of the mesh on the reference.
    """
    own, cloud = surfaces
    samples = sample_surface(mesh, _SAMPLES)
    if not isinstance(cloud, CloudSurface) or not cloud.known_normals or samples.normals is None:
        return CloudFacing(reference, cloud)
    found = cloud.closest(pose.apply(samples.points))
    near = ~found.on_border & (np.abs(found.distances) < NEAR * size(reference))
    if near.sum() < _FEWEST:
        return CloudFacing(reference, cloud)
    known = isinstance(own, MeshSurface) and own.wound.solid
    normals = own.closest(samples.points).normals if known else samples.normals
    against = float((np.einsum("ij,ij->i", normals @ pose.rotation.T, found.normals)[near] < 0).mean())
    if against < _SOME:
        return CloudFacing(reference, cloud)
    if against < _MOST:
        said = f"On {against:.0%} of the mesh the reference's normals look the other way than the mesh: {_UNSURE}"
        return CloudFacing(reference, cloud, (said,))
    looks = _outwards(cloud)
    if not known and looks > 1 - _MOST:
        mesh_is_wrong = looks > _MOST
        said = f"The reference's normals look the other way than the mesh: {_UNSURE}"
        return CloudFacing(reference, cloud, () if mesh_is_wrong else (said,))
    assert reference.normals is not None
    reference = replace(reference, normals=-reference.normals)
    return CloudFacing(reference, surface_of(reference), ("The reference's normals pointed inwards: turned.",))


def _outwards(cloud: CloudSurface) -> float:
    """Share of directions in which the farthest point looks that way: all of a body's do, half of a plane's."""
    ways: NDArray[np.float64] = directions(_WAYS)
    farthest = np.array([int(np.argmax(cloud.points @ way)) for way in ways])
    return float((np.einsum("ij,ij->i", cloud.normals[farthest], ways) > 0).mean())
