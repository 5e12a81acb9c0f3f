"""Another mesh of a scan to lay the picture on, closed or cut: it has to lie where the scan lies."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fusion.errors import MeshError
from fusion.mesh.alignment.align import align_meshes
from fusion.mesh.alignment.similarity import Similarity
from fusion.mesh.alignment.units import size
from fusion.mesh.comparison.distances import surface_of
from fusion.mesh.comparison.surface_samples import sample_surface
from fusion.mesh.files import read_mesh
from fusion.mesh.formats.conventions import from_file
from fusion.mesh.mesh import Mesh

SAMPLES = 20_000  # points that tell how far two surfaces lie apart, each way
LIES_ON = 0.01  # of the scan's size: closing, smoothing and thinning out move what was seen by far less (guess)
PLACED = 0.001  # of the scan's size: what is off by no more is seen in no image (guess)
BETTER = 0.5  # of how far it is off, that is left elsewhere: it was moved, as nothing else is undone so (guess)


def read_other(file: Path, scan: Mesh) -> Mesh:
    """A mesh file of a scan's object, in the scan's world [m]: STL is millimetres, GLB has y up.

    Raises:
        MeshError: no mesh, or one that lies elsewhere than the scan's.
    """
    mesh = from_file(read_mesh(file), file.suffix.lower())
    if not len(mesh.faces):
        raise MeshError("a texture needs triangles", file, f"{len(mesh.vertices)} points", "a mesh")
    distances = apart(scan, mesh)
    limit, away = LIES_ON * size(scan), float(np.median(distances))
    if not away <= limit:
        raise MeshError(
            "the mesh does not lie on the scan",
            file,
            f"{size(mesh):.4g} m from end to end, {1e3 * away:.3g} mm off (median)",
            f"the scan's object in its place, {size(scan):.4g} m, within {1e3 * limit:.2g} mm",
            "see its unit (STL: mm, others: m), whether it was moved: fusion convert --watertight stands it on z = 0",
        )
    elsewhere = _where(scan, mesh, _rms(distances))
    if elsewhere is not None:
        turned = np.rad2deg(Rotation.from_matrix(elsewhere.rotation).magnitude())
        middle = mesh.vertices.mean(axis=0)
        moved = float(np.linalg.norm(elsewhere.apply(middle[None])[0] - middle))
        raise MeshError(
            "the mesh does not lie on the scan",
            file,
            f"it lies on it when it is turned by {turned:.2f} deg and moved by {1e3 * moved:.2f} mm",
            "the scan's object in its place",
            "undo what moved it",
        )
    return mesh


def _where(scan: Mesh, mesh: Mesh, off: float) -> Similarity | None:
    """The motion after which a mesh, `off` [m] (rms), lies far better on the scan; None where it stands as it can."""
    if off < PLACED * size(scan):
        return None
    pose = align_meshes(mesh, scan, near=True).similarity()
    there = Mesh(pose.apply(mesh.vertices), mesh.faces)
    return pose if _rms(apart(scan, there)) < BETTER * off else None


def _rms(distances: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(distances**2)))


def apart(scan: Mesh, mesh: Mesh) -> NDArray[np.float64]:
    """Distances (n,) [m] of points of one surface from the other, from the one that is all on the other.

    A closed mesh has a bottom that the scan lacks, a cut one lacks what the scan has: neither is off by that.
    """
    there, back = (
        np.abs(surface_of(whole).closest(sample_surface(part, SAMPLES).points).distances)
        for whole, part in ((mesh, scan), (scan, mesh))
    )
    return there if np.median(there) <= np.median(back) else back
