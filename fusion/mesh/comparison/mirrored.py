"""Whether a mesh that does not fit its reference is its mirror image: some programs swap left and right."""

from dataclasses import replace

import numpy as np

from fusion.mesh.alignment.align import align_meshes
from fusion.mesh.alignment.coarse import principal_axes
from fusion.mesh.alignment.fit import SurfaceFit
from fusion.mesh.alignment.similarity import Array, Similarity
from fusion.mesh.alignment.units import size
from fusion.mesh.comparison.distances import Surface, surface_of
from fusion.mesh.comparison.surface_samples import SurfaceSamples, sample_surface
from fusion.mesh.mesh import Mesh
from fusion.recording.ahead import side_by_side

BAD = 0.01  # rms distance over the mesh's size: above, the mirror image is sought in any pose (guess)
BETTER = 3.0  # times nearer, mirrored: shapes that are nearly their own mirror image gain less (guess)
EXACT = 1e-4  # of the size: nearer than this, both are one but for rounding
SAMPLES = 20_000
_FEW = 1000  # samples of poses near the one that was found
_FLIP = np.array([-1.0, 1.0, 1.0])


def mirrored_note(mesh: Mesh, reference: Mesh, surface: Surface, pose: Similarity, rms: float) -> list[str]:
    """A sentence if the mirror image fits far better, else none.

    Of a shape that is nearly symmetric it lies near the pose that was found, but for its plane of symmetry: those of
    its principal axes are tried. Of others, which do not fit at all, it is sought anywhere.

    Args:
        mesh, reference: in metres.
        surface: of the reference.
        pose: of the mesh on the reference.
        rms: distance of the aligned mesh [m].
    """
    if rms <= EXACT * size(mesh):
        return []
    other, fit = mirrored(mesh), SurfaceFit(surface, size(reference))
    few = sample_surface(other, _FEW)
    poses = side_by_side(lambda start: fit.run(few, start, False, rounds=20)[0], _reflected(few, pose))
    if rms > BAD * size(mesh):
        poses.append(align_meshes(other, reference, surfaces=(surface_of(other), surface)).similarity())
    samples = sample_surface(other, SAMPLES).points
    left = min(float(np.sqrt(np.mean(surface.closest(found.apply(samples)).distances ** 2))) for found in poses)
    if BETTER * left > rms:
        return []
    return [
        f"The mesh's mirror image fits the reference {rms / left:.0f} times better ({1e3 * left:.2f} mm rms): are the "
        f"recording's images mirrored, left for right?"
    ]


def _reflected(samples: SurfaceSamples, pose: Similarity) -> list[Similarity]:
    """Poses in which the mirror image lies as the mesh, reflected at one of its three principal planes."""
    here = pose.apply(samples.points * _FLIP)  # where the mesh itself lies
    middle = here.mean(axis=0)
    mirrors: list[Array] = [np.eye(3) - 2 * np.outer(axis, axis) for axis in principal_axes(here).T]
    return [
        Similarity(mirror @ pose.rotation * _FLIP, mirror @ (pose.shift - middle) + middle, pose.scale)
        for mirror in mirrors
    ]


def mirrored(mesh: Mesh) -> Mesh:
    """The mirror image, x for -x."""
    normals = None if mesh.normals is None else np.asarray(mesh.normals * _FLIP, np.float32)
    return replace(mesh, vertices=mesh.vertices * _FLIP, faces=mesh.faces[:, ::-1], normals=normals)
