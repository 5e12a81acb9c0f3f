"""A flat wall of patches with different reflectances."""

import numpy as np

from fusion.errors import SceneError
from fusion.mesh.mesh import Mesh
from fusion.simulation.scene.course import standing
from fusion.simulation.scene.scene import Part, Scene, StatedPoses
from fusion.simulation.scenes.panel import SURVEY_M, SURVEY_RAD, WARM_S, before

MOST = 100  # patches along a side


def patches(
    distance_m: tuple[float, ...] = (1.0,),
    tilt_deg: tuple[float, ...] = (0.0,),
    reflectance: tuple[float, ...] = (0.05, 0.1, 0.2, 0.4, 0.6, 0.85),
    patch_m: float = 0.12,
    columns: int = 16,
    rows: int = 12,
    frames: int = 10,
) -> Scene:
    """a flat wall of squares with different reflectances, each of them at many places"""
    if not (1 <= columns <= MOST and 1 <= rows <= MOST and 1e-3 <= patch_m <= 10):
        raise SceneError("the patches cannot be laid out", found=f"{columns} x {rows} of {patch_m} m")
    placements = [(d, t) for t in tilt_deg for d in distance_m]
    course = standing([before(d, t) for d, t in placements], frames, start_s=WARM_S)
    return Scene(
        name="patches",
        parts=(_grid(np.asarray(reflectance, float), patch_m, columns, rows),),
        course=course,
        poses=StatedPoses("surveyed", SURVEY_M, SURVEY_RAD),
        ambient_lux=300.0,
        telemetry={"distance_m": np.repeat([float(d) for d, _ in placements], frames)},
    )


def _grid(reflectance: np.ndarray, side: float, columns: int, rows: int) -> Part:
    """Every square has corners of its own, so that its edges are sharp."""
    if not len(reflectance) or not ((reflectance >= 0) & (reflectance <= 1)).all():
        raise SceneError("a reflectance cannot be used", found=reflectance.tolist(), expected="0 to 1")
    j, i = (grid.ravel() for grid in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    corner = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    y = (i[:, None] + corner[:, 0] - columns / 2) * side
    z = (j[:, None] + corner[:, 1] - rows / 2) * side
    vertices = np.stack([np.zeros_like(y), y, z], axis=-1).reshape(-1, 3)
    first = 4 * np.arange(len(i))[:, None]
    faces = (first[..., None] + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3).astype(np.int32)
    # neighbours differ, in a row and in a column
    n = len(reflectance)
    value = np.repeat(reflectance[(i + max(1, n // 2 - 1) * j) % n], 4)
    colors = np.repeat(np.rint(255 * value)[:, None], 3, axis=1).astype(np.uint8)
    return Part(Mesh(vertices, faces, colors=colors, scalars={"reflectance": value.astype(np.float32)}))
