"""What a mesh is as a body: size, volume, holes, parts."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array
from fusion.mesh.cleanup import parts
from fusion.mesh.holes import Hole, holes
from fusion.mesh.mesh import Mesh

CRUMB = 0.05  # of the whole surface: a smaller part of it is a fragment, a larger one a thing of its own (guess)
OPEN = 0.1  # share of the surface missing elsewhere than at the bottom from which there is no volume (guess)


@dataclass(frozen=True)
class MeshShape:
    """A mesh in numbers."""

    # vertices, triangles: how many
    vertices: int
    triangles: int
    # width, depth and height of the smallest upright box around it [m], the longer side first; it does not depend on
    # how the mesh is turned about the upright direction
    size: tuple[float, float, float]
    area: float  # of the surface [m^2]
    # enclosed [m^3] once every hole is closed by a fan of triangles (the open bottom nearly flat); None where too much
    # is missing for it to mean anything
    volume: float | None
    holes: tuple[Hole, ...]  # the longest border first
    fragments: int  # connected parts
    largest_share: float  # share of the surface in the largest part
    crumb_share: float = 0.0  # share of the surface in parts that hold less than `CRUMB` of it each

    @property
    def bottom_open(self) -> bool:
        """True when the surface is open where it stood."""
        return any(hole.where == "bottom" for hole in self.holes)

    @property
    def other_holes(self) -> tuple[Hole, ...]:
        """The holes that are not at the bottom."""
        return tuple(hole for hole in self.holes if hole.where != "bottom")

    @property
    def open_share(self) -> float:
        """Share of the closed surface that is missing, the open bottom not counted; 1 without any surface."""
        missing = sum(hole.area for hole in self.other_holes)
        return missing / (missing + self.area) if self.area > 0 else 1.0

    def openings(self) -> str:
        """In words: "closed", "bottom open, 3 holes"."""
        if not self.triangles:
            return "no surface"
        count = len(self.other_holes)
        said = ["bottom open"] if self.bottom_open else []
        said += [f"{count:,} hole{'' if count == 1 else 's'}"] if count else []
        return ", ".join(said) or "closed"


def shape_of(mesh: Mesh, up: Array) -> MeshShape:
    """Measure a mesh that stands upright along `up` (3,); what is not finite is left out."""
    up = np.asarray(up, float) / np.linalg.norm(up)
    finite = np.asarray(np.isfinite(mesh.vertices).all(axis=1))
    points = mesh.vertices[finite]
    faces = mesh.faces if finite.all() else mesh.faces[finite[mesh.faces].all(axis=1)]
    if not len(faces):
        return MeshShape(len(mesh.vertices), 0, upright_size(points, up), 0.0, None, (), 0, 0.0)
    middle = points.mean(axis=0)  # near the origin the differences of volumes stay exact
    body = Mesh(np.nan_to_num(mesh.vertices - middle), faces)
    part, areas = parts(body)
    total = float(areas.sum())
    found = MeshShape(
        vertices=len(mesh.vertices),
        triangles=len(mesh.faces),
        size=upright_size(points, up),
        area=total,
        volume=None,
        holes=holes(body, up),
        fragments=len(np.unique(part[faces[:, 0]])),
        largest_share=float(areas.max()) / total if total > 0 else 0.0,
        crumb_share=float(areas[areas < CRUMB * total].sum()) / total if total > 0 else 0.0,
    )
    return _with_volume(found, body)


def _with_volume(found: MeshShape, body: Mesh) -> MeshShape:
    a, b, c = (body.vertices[corner] for corner in body.faces.T)
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6 + sum(hole.volume for hole in found.holes)
    return replace(found, volume=volume) if volume > 0 and found.open_share <= OPEN else found


def upright_size(points: NDArray[np.float64], up: Array) -> tuple[float, float, float]:
    """Width, depth and height [m] of the smallest box around points (n, 3) that stands upright along `up` (3,)."""
    import cv2

    if not len(points):
        return (0.0, 0.0, 0.0)
    helper = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    helper /= np.linalg.norm(helper)
    across = np.stack([points @ helper, points @ np.cross(up, helper)], axis=1)
    across = (across - across.mean(axis=0)).astype(np.float32)
    _, sides, _ = cv2.minAreaRect(across)
    return (max(sides), min(sides), float(np.ptp(points @ up)))
