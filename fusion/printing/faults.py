"""What a printer would stumble over: thin walls, a surface that passes through itself, and no solid at all."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import FusionError
from fusion.files.extra import extra
from fusion.mesh.comparison.surface_samples import sample_surface
from fusion.mesh.mesh import Mesh

SAMPLES = 20_000  # points at which the walls are measured
THIN = 0.8e-3  # [m] two lines of a nozzle of 0.4 mm, as most filament printers have (guess)
ENDS = 1e-3  # share of an edge at its ends that no crossing is looked for: there its own faces are
INWARDS = 1e-6  # [m] where rays into the wall begin


@dataclass(frozen=True)
class Faults:
    """What was found."""

    thin: float
    thin_share: float  # share of the surface whose wall is thinner than `thin` [m]
    thinnest: float  # the thinnest place [m]; inf where no wall was met
    crossing: int  # how many triangles another part of the surface passes through
    solid: bool | None  # whether manifold3d takes it for a valid solid; None where it is not installed
    why: str  # its word where it does not, or why it was not asked
    volume: float  # enclosed [m^3]


def faults_of(mesh: Mesh, thin: float = THIN) -> Faults:
    """Look for them in a closed mesh."""
    scene = _scene(mesh)
    walls = _walls(mesh, scene)
    solid, why = is_solid(mesh)
    known = walls[np.isfinite(walls)]
    a, b, c = (mesh.vertices[mesh.faces[:, k]] - mesh.vertices.mean(axis=0) for k in range(3))
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
    thinnest = float(known.min()) if len(known) else float("inf")
    return Faults(thin, float(np.mean(walls < thin)), thinnest, len(_crossing(mesh, scene)), solid, why, volume)


def thin_share(mesh: Mesh, thin: float) -> float:
    """Share of a surface, open or closed, that another surface lies behind within a distance [m]."""
    return float(np.mean(_walls(mesh, _scene(mesh)) < thin)) if len(mesh.faces) else 0.0


def is_solid(mesh: Mesh) -> tuple[bool | None, str]:
    """Whether manifold3d, which slicers use, takes a mesh for a valid solid, and its word."""
    try:
        manifold: Any = extra("manifold3d", "print", "the check that a mesh is a solid", "mesh")
    except FusionError as problem:
        return None, str(problem)
    made = manifold.Manifold(manifold.Mesh(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)))
    word = str(made.status()).rpartition(".")[2]
    if word != "NoError":
        return False, word
    return (True, "a valid solid") if made.volume() > 0 else (False, "inside out, or without a volume")


def _scene(mesh: Mesh) -> Any:
    import open3d

    o3d: Any = open3d
    scene = o3d.t.geometry.RaycastingScene()
    middle = mesh.vertices.mean(axis=0)  # single precision is exact enough about it
    scene.add_triangles(
        o3d.core.Tensor((mesh.vertices - middle).astype(np.float32)), o3d.core.Tensor(mesh.faces.astype(np.uint32))
    )
    return scene


def _walls(mesh: Mesh, scene: Any) -> NDArray[np.float64]:
    """How thick the wall is at points even per area (n,) [m], straight in; inf where nothing is behind."""
    import open3d

    o3d: Any = open3d
    samples = sample_surface(mesh, SAMPLES)
    assert samples.normals is not None
    at = samples.points - mesh.vertices.mean(axis=0) - INWARDS * samples.normals
    rays = np.hstack([at, -samples.normals]).astype(np.float32)
    return np.asarray(scene.cast_rays(o3d.core.Tensor(rays))["t_hit"].numpy(), float) + INWARDS


def _crossing(mesh: Mesh, scene: Any) -> NDArray[np.int64]:
    """Triangles that an edge of another passes through; two triangles meet only so, unless they lie in one plane."""
    import open3d

    o3d: Any = open3d
    edges = np.unique(np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    start, end = (mesh.vertices[edges[:, k]] - mesh.vertices.mean(axis=0) for k in (0, 1))
    found = scene.list_intersections(o3d.core.Tensor(np.hstack([start, end - start]).astype(np.float32)))
    ray, triangle, t = (found[name].numpy() for name in ("ray_ids", "primitive_ids", "t_hit"))
    inside = (t > ENDS) & (t < 1 - ENDS)
    corners, own = mesh.faces[triangle], edges[ray]
    apart = ~(corners[:, :, None] == own[:, None, :]).any(axis=(1, 2))
    return np.unique(triangle[inside & apart])
