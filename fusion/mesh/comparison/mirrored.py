"""Whether a mesh that does not fit its reference is its mirror image: some programs swap left and right."""

from dataclasses import replace

import numpy as np

from fusion.mesh.alignment.align import align_meshes
from fusion.mesh.alignment.units import size
from fusion.mesh.comparison.distances import Surface, surface_of
from fusion.mesh.comparison.surface_samples import sample_surface
from fusion.mesh.mesh import Mesh

BAD = 0.01  # rms distance over the mesh's size: below, nobody asks what is wrong (guess)
BETTER = 3.0  # times nearer, mirrored: shapes that are nearly their own mirror image gain less (guess)
SAMPLES = 20_000


def mirrored_note(mesh: Mesh, reference: Mesh, surface: Surface, rms: float) -> list[str]:
    """A sentence if the mirror image fits far better, else none.

    Args:
        mesh, reference: in metres.
        rms: distance of the aligned mesh [m].
    """
    if rms <= BAD * size(mesh):
        return []
    other = mirrored(mesh)
    pose = align_meshes(other, reference, surfaces=(surface_of(other), surface)).similarity()
    away = surface.closest(pose.apply(sample_surface(other, SAMPLES).points)).distances
    left = float(np.sqrt(np.mean(away**2)))
    if BETTER * left > rms:
        return []
    return [
        f"The mesh's mirror image fits the reference {rms / left:.0f} times better ({1e3 * left:.2f} mm rms): are the "
        f"recording's images mirrored, left for right?"
    ]


def mirrored(mesh: Mesh) -> Mesh:
    """The mirror image, x for -x."""
    flip = np.array([-1, 1, 1])
    normals = None if mesh.normals is None else np.asarray(mesh.normals * flip, np.float32)
    return replace(mesh, vertices=mesh.vertices * flip, faces=mesh.faces[:, ::-1], normals=normals)
