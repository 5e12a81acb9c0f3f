"""The surface that a still stretch should see: the scene's mesh, a flat target or wall, or a stated distance."""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.walls.plane import WallPlane, find_wall
from fusion.calibration.noise.target import FlatTarget, find_target
from fusion.calibration.shared_noise import centre_of
from fusion.calibration.stretches import Stretch
from fusion.errors import FusionError, SceneError
from fusion.evaluation.still.statistics import StretchSample
from fusion.geometry.camera import Camera
from fusion.geometry.robust import MAD_TO_STD
from fusion.mesh.files import read_mesh
from fusion.mesh.mesh import Mesh
from fusion.recording.native.scene_file import scene_mesh, stated_scene
from fusion.sensor.correction.estimate import normals_of
from fusion.sensor.view import incidence_of

FLAT = 0.01  # share of the depth: a piece that leaves its plane by more is no plane
WALL = 0.03  # share of the depth: nearer to the plane than this it is the plane, with the sensor's errors
CLOSE = 15  # [px] holes in a wall that belong to it
Image = NDArray[np.floating]


@dataclass(frozen=True)
class ExpectedSurface:
    """What should be seen."""

    kind: str  # "scene", "plane", "distance" or "unknown"; with the last, `depth` is what is usually measured
    depth: Image  # (h, w) along every pixel's ray [m], NaN where nothing is known
    incidence: Image  # (h, w) between ray and normal [rad], NaN where not known
    region: NDArray[np.bool_]  # (h, w) pixels in which values are expected and counted
    target: FlatTarget | None = None  # the flat target, where it is one that stands free or fills the view
    plane_distance: float = float("nan")  # of the fitted plane on the optical axis [m]; NaN without one
    stated: float = float("nan")  # distance on the optical axis as it was measured otherwise [m]; NaN when it was not

    @property
    def distance(self) -> float:
        """As stated; else the median depth of the region [m]."""
        if np.isfinite(self.stated):
            return self.stated
        depth = self.depth[self.region & np.isfinite(self.depth)]
        return float(np.median(depth)) if depth.size else float("nan")


def surface_of(sample: StretchSample, camera: Camera) -> ExpectedSurface:
    """The best known surface of a stretch. FusionError: no frame has depth and nothing is stated."""
    stated = sample.stretch.telemetry("distance_m")
    if np.isfinite(stated) and not stated > 0:
        raise FusionError("the stated distance is not usable", sample.stretch.name, f"{stated:g} m", "above 0 m")
    usual = sample.reference.depth.astype(float)
    truth = scene_depth(sample.stretch, camera)
    if truth is not None and np.isfinite(truth).any():
        return _scene(truth, camera, stated, usual)
    for find in (_target, _wall):
        try:
            return find(usual, camera, stated)
        except FusionError:
            continue
    if np.isfinite(stated):
        region = np.zeros(camera.shape, bool)
        region[centre_of(camera.shape)] = True
        return _plane(WallPlane(stated, 0.0, 0.0), camera, region, "distance", None, stated)
    if not np.isfinite(usual).any():
        raise FusionError(
            "no frame has a depth",
            sample.stretch.name,
            "only missing values",
            "a surface in range, or its distance_m in telemetry.csv",
        )
    smooth = np.asarray(cv2.GaussianBlur(usual, (5, 5), 0), float)
    incidence = incidence_of(normals_of(smooth, camera), camera)
    return ExpectedSurface("unknown", usual, incidence, np.ones(camera.shape, bool), stated=stated)


def _scene(truth: Image, camera: Camera, stated: float, usual: Image) -> ExpectedSurface:
    with np.errstate(invalid="ignore"):
        incidence = incidence_of(normals_of(truth, camera), camera)
    try:
        target = _target(usual, camera, stated).target
    except FusionError:
        target = None
    # a pixel whose neighbour is elsewhere sees both
    region = np.isfinite(truth) & np.isfinite(incidence)
    return ExpectedSurface("scene", truth, incidence, region, target, stated=stated)


def _target(usual: Image, camera: Camera, stated: float) -> ExpectedSurface:
    target = find_target(usual, camera)
    depth = target.plane_depth(camera)
    rest = np.abs(usual - depth)[target.inside]
    if not MAD_TO_STD * float(np.nanmedian(rest / depth[target.inside])) < FLAT:
        raise FusionError("the target is not flat")
    # n . p = d with p = z (x, y, 1) is 1 / z = (n_z / d) (1 + x n_x / n_z + y n_y / n_z)
    n = target.normal
    plane = WallPlane(float(target.distance / n[2]), float(n[0] / n[2]), float(n[1] / n[2]))
    region = np.zeros(camera.shape, bool)
    region[target.inside] = True
    return _plane(plane, camera, region, "plane", target, stated)


def _wall(usual: Image, camera: Camera, stated: float) -> ExpectedSurface:
    plane, mask = find_wall(usual, camera)
    closed = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((CLOSE, CLOSE), np.uint8))
    return _plane(plane, camera, closed > 0, "plane", None, stated)


def _plane(
    plane: WallPlane, camera: Camera, region: NDArray, kind: str, target: FlatTarget | None, stated: float
) -> ExpectedSurface:
    normal = -np.array([plane.a, plane.b, 1.0]) / np.sqrt(plane.a**2 + plane.b**2 + 1)
    incidence = incidence_of(np.broadcast_to(normal.astype(np.float32), (*camera.shape, 3)), camera)
    distance = float("nan") if kind == "distance" else plane.distance
    return ExpectedSurface(kind, plane.depth(camera), incidence, region, target, distance, stated)


def expected_depth(surface: ExpectedSurface, usual: Image) -> Image:
    """(h, w) what a single value is judged against [m]: what is usual where that is the surface, with its errors."""
    with np.errstate(invalid="ignore"):
        near = np.abs(usual - surface.depth) <= WALL * surface.depth
    return np.where(near, usual, surface.depth)


def scene_depth(stretch: Stretch, camera: Camera) -> NDArray[np.floating] | None:
    """(h, w) depth [m] of the stated mesh from the stretch's pose, NaN beside it; None when none is stated.

    A pose that was tracked with the same depth holds its errors, so only surveyed ones count as truth.

    Raises:
        SceneError, MeshError: the mesh cannot be read.
    """
    recording = stretch.recording
    path, source = scene_mesh(recording), stated_scene(recording).stated_poses.source
    if path is None or source != "surveyed" or recording.poses is None or not len(recording.poses):
        return None
    if not path.is_file():
        raise SceneError("the mesh of the scene does not exist", path, "nothing", "a mesh", 'correct "mesh"')
    T = _pose(stretch)
    return None if T is None else _cast(read_mesh(path), camera, T)


def _pose(stretch: Stretch) -> NDArray[np.floating] | None:
    """(4, 4) pose of the camera at the middle of the stretch, from the nearest stated one."""
    poses = stretch.recording.poses
    assert poses is not None
    now = stretch.recording.timestamps[sum(stretch.frames) // 2]
    valid = np.flatnonzero(poses.valid)
    if not len(valid):
        return None
    return np.asarray(poses.poses[valid[np.abs(poses.timestamps[valid] - now).argmin()]], float)


def _cast(mesh: Mesh, camera: Camera, T_world_camera: NDArray[np.floating]) -> NDArray[np.floating]:
    import open3d as o3d

    tensor: Any = o3d.core.Tensor  # its stubs know no arrays

    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        tensor(np.ascontiguousarray(mesh.vertices, np.float32)),
        tensor(np.ascontiguousarray(mesh.faces, np.uint32)),
    )
    directions = np.dstack([camera.rays(), np.ones(camera.shape, np.float32)]) @ T_world_camera[:3, :3].T
    starts = np.broadcast_to(T_world_camera[:3, 3], directions.shape)
    rays = np.concatenate([starts, directions], axis=2).astype(np.float32)
    # the ray (x, y, 1) is one metre deep, so its length counts depth
    depth = scene.cast_rays(tensor(rays))["t_hit"].numpy().astype(float)
    return np.asarray(np.where(np.isfinite(depth), depth, np.nan))
