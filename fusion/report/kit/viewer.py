"""An interactive 3D view of a mesh: the data packed small into the page, drawn by `viewer.js` beside this file."""

import base64
import json
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from fusion.files.json_values import json_values
from fusion.geometry.pose import Array
from fusion.mesh.drawing.sight import SightSide, sides
from fusion.mesh.mesh import Mesh
from fusion.report.kit.html import markup
from fusion.report.kit.page import Section
from fusion.report.kit.views import Scale, scale_colors

CLAY = (201, 206, 214)  # of a bare shape
STEPS = 65535  # of the longest side: places are kept as 16-bit numbers, 5 micrometres in 30 cm
TRIANGLES = 200_000  # more makes turning slow on small computers (guess); thinning takes half a second
POINTS = 60_000
MANY = 1.5  # times as many triangles as are shown (guess)
PACKED = 3  # zlib's level: 9 takes eight times as long for 0.3 to 0.7 % of the data


@dataclass(frozen=True)
class Layer:
    """One colouring of the mesh."""

    name: str  # what the button says
    colors: NDArray[np.uint8] | None = None  # (n, 3) uint8 RGB; None is plain clay
    scale: Scale | None = None  # what the colours stand for, shown as a bar; None for colours that are only colours


@dataclass(frozen=True)
class Path3D:
    """A line through space (n, 3) [m], with its name and colour "#rrggbb"; it passes over points of NaN."""

    name: str
    points: Array
    color: str


@dataclass(frozen=True)
class _ShownPath:
    color: str
    points: Array


@dataclass(frozen=True)
class _Shown:
    """What `viewer.js` reads: vertices are `low` + `step` * numbers in `data`, then faces, then colours per layer."""

    vertices: int
    triangles: int
    low: Array
    step: float
    layers: list[str]
    paths: list[_ShownPath]
    data: str
    up: Array
    front: Array


def value_layer(name: str, values: NDArray, scale: Scale) -> Layer:
    """Values (n,) as colours, with their scale."""
    return Layer(name, np.rint(scale_colors(values, scale) * 255).astype(np.uint8), scale)


def script() -> str:
    """The JavaScript that draws, for Page.script: put it on a page once."""
    return Path(__file__).with_name("viewer.js").read_text(encoding="utf-8")


def viewer(mesh: Mesh, layers: list[Layer], up: Array, front: Array, paths: tuple[Path3D, ...] = ()) -> Section:
    """The interactive view as a section; without content when the mesh is empty.

    Args:
        mesh: [m]; thinned out for display when it is large.
        layers: colourings of its vertices; the first is shown, buttons change it.
        up, front: (3,) directions in the mesh's frame; front points from the object to the eye.
    """
    if not np.isfinite(mesh.vertices).all(axis=1).any():
        return Section("Turn it yourself")
    small, nearest = thinned(mesh)
    layers = layers or [Layer("Shape")]
    about = _shown(small, layers, nearest, paths, sides(up, front)[0])
    count = f"{len(small.faces):,} triangles" if len(small.faces) else f"{len(small.vertices):,} points"
    thinner = len(small.faces) != len(mesh.faces) or not len(mesh.faces)
    lead = f"Drag to turn, scroll to zoom, right-drag to shift.{f' Shown with {count} for speed.' if thinner else ''}"
    # "<" would end the script early; JSON may write it as a number
    data = Markup(json.dumps(json_values(about), separators=(",", ":")).replace("<", "\\u003c"))
    html = markup("report/kit/viewer.html", layers=layers, paths=paths, ramp=_ramp, data=data)
    return Section("Turn it yourself", lead, html=html, screen_only=True)


def _shown(
    mesh: Mesh, layers: list[Layer], nearest: NDArray[np.int64], paths: tuple[Path3D, ...], eye: SightSide
) -> _Shown:
    """`nearest` (n,): the vertices of the layers' mesh that stand for those of `mesh`."""
    low = mesh.vertices.min(axis=0)
    step = max(float(np.ptp(mesh.vertices, axis=0).max()) / STEPS, 1e-12)
    clay = np.tile(np.array(CLAY, np.uint8), (len(nearest), 1))
    parts = [np.rint((mesh.vertices - low) / step).astype("<u2"), mesh.faces.astype("<u4")]
    parts += [clay if layer.colors is None else layer.colors[nearest] for layer in layers]
    packed = base64.b64encode(zlib.compress(b"".join(part.tobytes() for part in parts), PACKED)).decode()
    lines = [_ShownPath(p.color, np.round(p.points[np.isfinite(p.points).all(axis=1)], 4)) for p in paths]
    names = [layer.name for layer in layers]
    return _Shown(len(mesh.vertices), len(mesh.faces), low, step, names, lines, packed, eye.up, eye.towards)


def _ramp(scale: Scale) -> str:
    """Its colours, as CSS has them."""
    stops = np.rint(scale_colors(np.linspace(scale.low, scale.high, 9), scale) * 255).astype(int)
    return ", ".join(f"rgb({r},{g},{b})" for r, g, b in stops)


def thinned(mesh: Mesh, triangles: int = TRIANGLES) -> tuple[Mesh, NDArray[np.int64]]:
    """A lighter mesh for display, and for each of its vertices the nearest one (k,) of the full mesh."""
    from scipy.spatial import cKDTree

    finite = np.flatnonzero(np.isfinite(mesh.vertices).all(axis=1))
    if len(mesh.faces) == 0:
        keep = finite[:: max(1, -(-len(finite) // POINTS))]
        return Mesh(mesh.vertices[keep]), keep
    known = np.asarray(np.isfinite(mesh.vertices).all(axis=1))
    faces = mesh.faces[known[mesh.faces].all(axis=1)]
    vertices = mesh.vertices
    if len(faces) > triangles:
        vertices, faces = _decimated(np.nan_to_num(vertices), faces, triangles)
    used, inverse = np.unique(faces, return_inverse=True)
    vertices = vertices[used]
    _, nearest = cKDTree(mesh.vertices[finite]).query(vertices)
    return Mesh(vertices, inverse.reshape(-1, 3).astype(np.int32)), finite[nearest]


def _decimated(vertices: Array, faces: NDArray[np.int32], triangles: int) -> tuple[Array, NDArray[np.int32]]:
    """Fewer triangles: vertex clustering where they are many more, a tenth of the time, then quadric collapse, which
    keeps edges."""
    import open3d as o3d

    legacy = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(faces))
    legacy.remove_unreferenced_vertices()
    area = legacy.get_surface_area()
    if len(faces) > MANY * triangles and area > 0:
        # cells of edge e hold about 2 triangles per e^2 of surface, up to a tenth more
        legacy = legacy.simplify_vertex_clustering(float(np.sqrt(2.2 * area / triangles)))
    if len(legacy.triangles) > triangles:
        legacy = legacy.simplify_quadric_decimation(triangles)
    return np.asarray(legacy.vertices), np.asarray(legacy.triangles, np.int32)
