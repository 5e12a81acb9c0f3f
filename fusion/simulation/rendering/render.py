"""A renderer of its own: what every pixel of a camera sees, exactly, along its distorted ray.

    caster = RayCaster(mesh)                                  # once per mesh
    view = caster.view(camera, T_world_camera)                # depth, incidence, normals, colour, reflectance
    view = caster.view(camera, T_world_camera, Channels(edges=True, lit=0.075, indirect=Bounce()))

Things that move against each other are bodies, and one picture:

    bodies = (Body(RayCaster(room)), Body(RayCaster(owl), T_world_owl, twist=twist_between(T0, T1, dt), turning=True))
    view = view_of(bodies, camera, T_world_camera, channels)
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from fusion.geometry.camera import Camera, crop
from fusion.geometry.pose import Array
from fusion.mesh.mesh import Mesh
from fusion.sensor.edges.nearest import REACH_PX
from fusion.sensor.view import View, incidence_of
from fusion.simulation.rendering.area import over_area
from fusion.simulation.rendering.casting import Body, CastBodies, Floats, Hits, PreparedMesh, directions
from fusion.simulation.rendering.edges import edges_of
from fusion.simulation.rendering.indirect import Bounce, LampLit, indirect_of
from fusion.simulation.rendering.motion import velocity_of
from fusion.simulation.rendering.shadow import lit_of

BEYOND_PX = int(REACH_PX) + 1  # of the image, in which edges are looked for


@dataclass(frozen=True)
class Channels:
    """What a view holds beside depth, incidence and normals."""

    color: bool = True  # colour, reflectance and how translucent surfaces are
    edges: bool = False  # nearest depth edges
    # where the projector or lamp stands: x [m] in the camera frame, negative to the left of the camera (Kinect v1:
    # 0.075), 0 at the camera; None leaves the channel out
    lit: float | None = None
    motion: bool = False  # velocity, and what stands on the turntable
    area: bool = False  # of an image of few pixels the mean over what each sees, as a sensor measures it
    # how light of one bounce is computed; None leaves the channel out. Needs the reflectance.
    indirect: Bounce | None = None


def render(mesh: Mesh, camera: Camera, T_world_camera: Array, channels: Channels | None = None) -> View:
    """What a camera sees of a mesh that stands in the world frame; for many views of one mesh, keep a RayCaster."""
    return RayCaster(mesh).view(camera, T_world_camera, channels)


class RayCaster(PreparedMesh):
    """A mesh prepared for many views."""

    def view(self, camera: Camera, T_mesh_camera: Array, channels: Channels | None = None) -> View:
        """What every pixel sees; NaN (black) where its ray meets nothing."""
        return view_of((Body(self),), camera, T_mesh_camera, channels)


def view_of(
    bodies: Sequence[Body],
    camera: Camera,
    T_world_camera: Array,
    channels: Channels | None = None,
    camera_twist: Array | None = None,
    paint: Callable[[View], View] | None = None,
) -> View:
    """What a camera sees of several bodies; NaN (black) where a ray meets nothing.

    Args:
        camera_twist: (6,) rotation [rad/s] and velocity at the world's origin [m/s] of the camera, in the world frame.
        paint: puts patterns on what is seen, before it gives its light across edges and to other surfaces.
    """
    channels = channels or Channels()
    bodies = [body for body in bodies if len(body.mesh.faces)]
    stage, color = CastBodies(bodies, T_world_camera), channels.color or channels.indirect is not None
    beyond = BEYOND_PX if channels.edges else 0  # an edge beside the image is one beside its pixels
    window = slice(beyond, beyond + camera.height), slice(beyond, beyond + camera.width)
    wide = crop(camera, (slice(-beyond, camera.height + beyond), slice(-beyond, camera.width + beyond)))
    hits = stage.first(directions(wide))
    view, flat = _seen(wide, stage, hits, color)
    if paint is not None:
        view = paint(view)
    if channels.edges:
        view = replace(view, edges=edges_of(view, flat, stage))
        view, flat = replace(view.cut(window), camera=camera), np.ascontiguousarray(flat[window])
    if channels.lit is not None:
        view = replace(view, baseline=channels.lit or view.baseline, lit=lit_of(view, flat, stage, channels.lit))
    if channels.indirect is not None:
        lamp = None
        if channels.indirect.beyond:
            cells = channels.indirect.lit(camera)
            lamp = LampLit(*_seen(cells, stage, stage.first(directions(cells)), color))
            lamp = lamp if paint is None else lamp._replace(view=paint(lamp.view))
        view = replace(view, indirect=indirect_of(view, flat, stage, channels.indirect, lamp))
    if channels.motion:
        turning = np.array([body.turning for body in bodies] + [False])[hits.body] & np.isfinite(hits.t)
        velocity = velocity_of(view, stage, hits.body.reshape(wide.shape)[window], camera_twist)
        view = replace(view, velocity=velocity, turning=turning.reshape(wide.shape)[window])
    return over_area(view, stage) if channels.area else view


def _seen(camera: Camera, stage: CastBodies, hits: Hits, color: bool) -> tuple[View, Floats]:
    """Depth, incidence, normals, colour and reflectance, and the normals (h, w, 3) of the faces."""
    # the directions have z = 1 in the camera frame, so the ray parameter is the planar depth
    seen = np.isfinite(hits.t)
    depth = np.where(seen, hits.t, np.float32(np.nan))
    every = bool(seen.all())
    some = hits if every else Hits(*(getattr(hits, entry.name)[seen] for entry in fields(Hits)))
    values, smooth = stage.values(some)
    towards = directions(camera) if every else directions(camera)[seen]
    image = (*camera.shape, 3)
    flat = _spread(_facing(some.normals, towards), seen, every).reshape(image)
    smooth = _facing(smooth, towards)
    normals = flat if smooth is some.normals else _spread(smooth, seen, every).reshape(image)
    depth = depth.reshape(camera.shape)
    view = View(camera, depth, incidence_of(normals, camera), normals)
    if color:
        rgb = np.zeros((len(seen), 3), np.uint8)
        rgb[slice(None) if every else seen] = (values[:, :3] + 0.5).astype(np.uint8)
        reflectance = _spread(values[:, 3], seen, every).reshape(camera.shape)
        view = replace(view, color=rgb.reshape(image), reflectance=reflectance)
        if values.shape[1] > 4:
            view = replace(view, translucent=_spread(values[:, 4], seen, every).reshape(camera.shape))
    return view, flat


def _facing(normals: Floats, directions: Floats) -> Floats:
    """Normals (n, 3) turned towards the camera: the inside of a surface is seen through a hole."""
    away = np.einsum("nk,nk->n", normals, directions) > 0
    normals[away] *= -1
    return normals


def _spread(values: Floats, seen: np.ndarray, every: bool) -> Floats:
    """Values of the rays that hit as values of all rays, NaN for the others."""
    if every:
        return values
    spread = np.full((len(seen), *values.shape[1:]), np.nan, np.float32)
    spread[seen] = values
    return spread
