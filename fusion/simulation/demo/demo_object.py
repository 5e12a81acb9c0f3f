"""The demo's object: an owl on two books, one wing raised, made from one implicit function."""

from copy import deepcopy
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fusion.mesh.mesh import Mesh

Points = NDArray[np.float64]  # (n, 3) [m], z up, the object stands on z = 0

VOXEL = 0.002  # [m] gives some 70 000 triangles
COARSE = 4  # voxels between the points of a first look
LOW, HIGH = np.array([-0.085, -0.085, -0.006]), np.array([0.103, 0.103, 0.238])

HEAD = np.array([0.004, 0.0, 0.178])
# the head looks to its side
GAZE = Rotation.from_euler("z", 24, degrees=True)

BROWN, CREAM, SAND = (138, 98, 66), (233, 214, 180), (190, 150, 104)
TEAL, RED, PAPER = (44, 122, 124), (178, 58, 52), (240, 234, 218)
ORANGE, BLACK, WHITE = (232, 146, 42), (28, 26, 30), (250, 250, 246)


def demo_object() -> Mesh:
    """The watertight owl (about 22 cm tall) with normals and vertex colours; always the same, and the caller's own."""
    return deepcopy(_owl())


@cache
def _owl() -> Mesh:
    import open3d as o3d

    surface = o3d.t.geometry.TriangleMesh.create_isosurfaces(o3d.core.Tensor.from_numpy(_grid()), [0.0])
    vertices = LOW + VOXEL * surface.vertex.positions.numpy().astype(float)
    faces = surface.triangle.indices.numpy().astype(np.int32)[:, ::-1]  # outwards is where the function grows
    return Mesh(vertices, np.ascontiguousarray(faces), _normals(vertices, faces), painted(vertices))


def figure(p: Points) -> NDArray[np.float64]:
    """(n,) about the signed distance [m] to the owl, positive outside."""
    owl = _smooth_union(_body(p), _head(p), 0.014)
    owl = _smooth_union(owl, _wings(p), 0.006)
    owl = _smooth_union(owl, _feet(p), 0.004)
    return np.minimum(owl, _books(p))


def painted(p: Points) -> NDArray[np.uint8]:
    """(n, 3) colour of points on the surface."""
    color = np.tile(np.array(BROWN, float), (len(p), 1))
    # barred feathers on the wings and the back, dots on a light chest
    bars = np.sin(p[:, 2] * 520 + 3 * np.sin(p[:, 1] * 140)) > 0.35
    color[bars] = SAND
    chest = (p[:, 0] > 0.024) & (np.abs(p[:, 1]) < 0.034) & (p[:, 2] < 0.15)
    color[chest] = CREAM
    dots = (np.sin(p[:, 1] * 420) * np.sin(p[:, 2] * 420 + np.floor(p[:, 1] * 134)) > 0.55) & chest
    color[dots] = BROWN
    wings = _wings(p) < 0.0012
    color[wings] = np.where(bars[wings, None], SAND, (104, 72, 50))
    face = GAZE.inv().apply(p - HEAD)
    for side in (-1, 1):
        away = np.hypot(face[:, 1] - side * 0.0155, face[:, 2] - 0.006)
        front = face[:, 0] > 0.012
        color[front & (away < 0.0155)] = CREAM
        color[front & (away < 0.0115)] = ORANGE
        color[front & (away < 0.0068)] = BLACK
        color[front & (np.hypot(face[:, 1] - side * 0.0155 - 0.003, face[:, 2] - 0.009) < 0.0022)] = WHITE
    color[_beak(p) < 0.001] = ORANGE
    color[_feet(p) < 0.001] = ORANGE
    _paint_books(p, color)
    return color.astype(np.uint8)


def _grid() -> NDArray[np.float32]:
    """`figure` on the grid (z, y, x); exact near the surface, elsewhere the value of a point nearby."""
    counts = np.ceil((HIGH - LOW) / (COARSE * VOXEL)).astype(int)
    x, y, z = (low + COARSE * VOXEL * (np.arange(n) + 0.5) for low, n in zip(LOW, counts, strict=True))
    zz, yy, xx = np.meshgrid(z, y, x, indexing="ij")
    values = figure(np.column_stack([xx.ravel(), yy.ravel(), zz.ravel()])).reshape(zz.shape)
    for axis in range(3):
        values = np.repeat(values, COARSE, axis)
    # a coarse point is up to 7 mm away; three times that for a function that is no exact distance
    near = np.argwhere(np.abs(values) < 0.02)
    values[tuple(near.T)] = figure(LOW + VOXEL * near[:, ::-1])
    return values.astype(np.float32)


def _body(p: Points) -> Points:
    body = _ellipsoid(p, (0.0, 0.0, 0.108), (0.041, 0.044, 0.062))
    tail = _rounded_box(_turned(p, (-0.042, 0.006, 0.068), "y", 32), (0.006, 0.02, 0.032), 0.004)
    body = _smooth_union(body, tail, 0.012)
    # rows of feathers, only as deep as a millimetre
    return body + 0.0009 * np.sin(p[:, 2] * 420) * np.sin(np.arctan2(p[:, 1], p[:, 0]) * 14)


def _head(p: Points) -> Points:
    q = GAZE.inv().apply(p - HEAD)
    head = _ellipsoid(q, (0, 0, 0), (0.033, 0.037, 0.03))
    for side in (-1, 1):
        tuft = _capsule(q, (0.004, side * 0.02, 0.018), (0.0, side * 0.031, 0.043), 0.009, 0.0025)
        head = _smooth_union(head, tuft, 0.007)
        # a shallow dish around each eye, and the eye in it
        head = np.maximum(head, -_ellipsoid(q, (0.039, side * 0.0155, 0.006), (0.011, 0.015, 0.015)))
        head = np.minimum(head, _ellipsoid(q, (0.0225, side * 0.0155, 0.006), (0.0085, 0.0095, 0.0095)))
    return _smooth_union(head, _beak(p), 0.002)


def _beak(p: Points) -> Points:
    q = GAZE.inv().apply(p - HEAD)
    return _capsule(q, (0.028, 0, 0.0), (0.041, 0, -0.014), 0.006, 0.0015)


def _wings(p: Points) -> Points:
    folded = _ellipsoid(_turned(p, (-0.006, -0.041, 0.106), "x", -8), (0, 0, 0), (0.026, 0.009, 0.05))
    # the other wing waves
    raised = _ellipsoid(_turned(p, (-0.002, 0.058, 0.142), "x", -52), (0, 0, 0), (0.021, 0.0085, 0.043))
    return np.minimum(folded, raised) + 0.0008 * np.sin(p[:, 0] * 500 + p[:, 2] * 160)


def _feet(p: Points) -> Points:
    toes = [
        _capsule(p, (0.018, side * 0.018, 0.054), (0.044, side * (0.018 + spread), 0.0475), 0.006, 0.004)
        for side in (-1, 1)
        for spread in (-0.008, 0.008)
    ]
    return np.min(toes, axis=0)


def _books(p: Points) -> Points:
    lower = _rounded_box(_turned(p, (0.006, 0.0, 0.0125), "z", 8), (0.072, 0.056, 0.0125), 0.0015)
    upper = _rounded_box(_turned(p, (0.0, 0.004, 0.0345), "z", -19), (0.06, 0.045, 0.0095), 0.0015)
    # pages stand back from the cover on three sides
    pages_low = _rounded_box(_turned(p, (0.011, 0.0, 0.0125), "z", 8), (0.072, 0.06, 0.0085), 0.001)
    keep_low = _rounded_box(_turned(p, (0.003, 0.0, 0.0125), "z", 8), (0.066, 0.052, 0.0125), 0.001)
    lower = np.maximum(lower, -np.maximum(pages_low, -keep_low))
    pages_up = _rounded_box(_turned(p, (0.005, 0.004, 0.0345), "z", -19), (0.06, 0.049, 0.006), 0.001)
    keep_up = _rounded_box(_turned(p, (-0.003, 0.004, 0.0345), "z", -19), (0.055, 0.041, 0.0095), 0.001)
    return np.minimum(lower, np.maximum(upper, -np.maximum(pages_up, -keep_up)))


def _paint_books(p: Points, color: Points) -> None:
    for centre, degrees, half, cover in (
        ((0.006, 0.0, 0.0125), 8, (0.072, 0.056, 0.0125), TEAL),
        ((0.0, 0.004, 0.0345), -19, (0.06, 0.045, 0.0095), RED),
    ):
        q = _turned(p, centre, "z", degrees)
        inside = _rounded_box(q, half, 0.0) < 0.0012
        inside &= _feet(p) > 0.001
        color[inside] = cover
        back = q[:, 0] < -half[0] + 0.007
        spine = inside & (q[:, 0] < -half[0] + 0.004)
        color[spine & (np.abs(np.abs(q[:, 1]) - 0.6 * half[1]) < 0.004)] = ORANGE
        edge = np.minimum(half[0] - q[:, 0], half[1] - np.abs(q[:, 1]))
        color[inside & ~back & (edge > 0.0016) & (np.abs(q[:, 2]) < half[2] - 0.0022)] = PAPER
        ring = np.minimum(edge, half[0] + q[:, 0])
        color[inside & (np.abs(ring - 0.008) < 0.0012) & (q[:, 2] > half[2] - 0.002)] = ORANGE


def _normals(vertices: Points, faces: NDArray[np.int32]) -> NDArray[np.float32]:
    """(n, 3) mean of the normals of the faces around each vertex, weighted with their areas."""
    corners = vertices[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(total, faces[:, corner], across)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return (total / np.maximum(length, 1e-300)).astype(np.float32)


def _turned(p: Points, centre: tuple[float, float, float], axis: str, degrees: float) -> Points:
    """Points in the frame of a part that was turned about its centre."""
    return Rotation.from_euler(axis, degrees, degrees=True).inv().apply(p - np.array(centre))


def _ellipsoid(p: Points, centre: tuple[float, float, float], half: tuple[float, float, float]) -> Points:
    q = (p - np.array(centre)) / np.array(half)
    radius = np.linalg.norm(q, axis=1)
    slope = np.linalg.norm(q / np.array(half), axis=1)
    return radius * (radius - 1.0) / np.maximum(slope, 1e-9)


def _rounded_box(q: Points, half: tuple[float, float, float], round_m: float) -> Points:
    d = np.abs(q) - (np.array(half) - round_m)
    return np.linalg.norm(np.maximum(d, 0), axis=1) + np.minimum(d.max(axis=1), 0) - round_m


def _capsule(p: Points, a: tuple[float, ...], b: tuple[float, ...], radius_a: float, radius_b: float) -> Points:
    """A stick from a to b whose radius changes from one end to the other."""
    start, along = np.array(a), np.array(b) - np.array(a)
    t = np.clip((p - start) @ along / (along @ along), 0, 1)
    return np.linalg.norm(p - start - t[:, None] * along, axis=1) - (radius_a + t * (radius_b - radius_a))


def _smooth_union(a: Points, b: Points, width: float) -> Points:
    h = np.clip(0.5 + 0.5 * (b - a) / width, 0, 1)
    return b + (a - b) * h - width * h * (1 - h)
