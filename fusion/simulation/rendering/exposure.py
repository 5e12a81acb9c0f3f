"""What the camera truly looks at, frame by frame: parts posed, the rig's errors applied, patterns painted."""

from dataclasses import replace

import numpy as np

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, exp, inverse
from fusion.mesh.mesh import Mesh
from fusion.sensor.effects.rig.pose_jitter import PoseJitter
from fusion.sensor.laws.moving import CameraEffect, RigEffect
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View
from fusion.simulation.rendering.casting import Body, CastBodies, directions
from fusion.simulation.rendering.indirect import Bounce
from fusion.simulation.rendering.motion import twist_between
from fusion.simulation.rendering.paint import Paint, painted
from fusion.simulation.rendering.render import Channels, RayCaster, view_of
from fusion.simulation.scene.course import SimulatedCourse, neighbours
from fusion.simulation.scene.scene import TRANSLUCENT, Part, Scene
from fusion.simulation.scene.shapes import joined

USUAL_REFLECTANCE = 180 / 255  # of a mesh that says nothing: the grey in which it is drawn


class Exposures:
    """The scene as one sensor sees it; keeps the last view, for a scene that stands still."""

    def __init__(self, scene: Scene, sensor: Sensor, camera: Camera, turned_deg: Array) -> None:
        """`camera` is the stated one; `turned_deg` (n,) are the true angles of the table."""
        self._scene, self._sensor, self._stated = scene, sensor, camera
        self._true = sensor.true_camera(camera)
        self._turning = _caster([part for part in scene.parts if part.turns])
        self._still = _caster([part for part in scene.parts if not part.turns])
        table = scene.course.turntable
        n = len(scene.course)
        self._T_world_object = np.tile(np.eye(4), (n, 1, 1)) if table is None else table.T_world_object(turned_deg)
        self._rig = [effect for effect in sensor.effects if isinstance(effect, RigEffect)]
        self._shaky = [effect for effect in sensor.effects if isinstance(effect, PoseJitter)]
        exact = CameraEffect | RigEffect | PoseJitter
        self._done = frozenset(effect.name for effect in sensor.effects if isinstance(effect, exact))
        self._last: tuple[bytes, View] | None = None

    def view(self, index: int, moment: Moment, rng: np.random.Generator) -> View:
        """The true view of a frame with the stated camera, whose depth is what an otherwise ideal sensor gives.

        `rng` draws how the camera shakes, where the sensor's model says that it does.
        """
        course = self._scene.course
        T_world_camera, T_world_object = self._placed(index, moment)
        for shaky in self._shaky:  # what is seen moves: the same as the camera the other way
            T_world_camera = T_world_camera @ inverse(exp(shaky.shake(rng)))
        twists = self._twists(course, index)
        key = b"".join(np.ascontiguousarray(a).tobytes() for a in (T_world_camera, T_world_object, *twists))
        last = self._last  # another thread may be at another frame
        if last is None or last[0] != key:
            bodies = self._bodies(T_world_object, twists[0])

            def on_all(view: View) -> View:
                for paint in self._scene.paints:
                    T_paint = T_world_object @ paint.T_world_picture if paint.turns else paint.T_world_picture
                    view = with_paint(view, paint, inverse(T_paint) @ T_world_camera)
                return view

            view = view_of(bodies, self._true, T_world_camera, self._channels(), twists[1], on_all)
            self._last = last = (key, self._as_stated(view))
        return replace(last[1], moment=moment)

    def depth(self, index: int, moment: Moment, camera: Camera) -> Image:
        """True planar z (h, w) [m] of another camera that stands where this one does; NaN where there is nothing."""
        T_world_camera, T_world_object = self._placed(index, moment)
        stage = CastBodies(self._bodies(T_world_object), T_world_camera)
        depth = stage.first(directions(camera)).t.reshape(camera.shape)
        depth[np.isinf(depth)] = np.nan
        return depth

    def _bodies(self, T_world_object: Array, twist: Array | None = None) -> list[Body]:
        """What stands still, and what turns."""
        bodies = [] if self._still is None else [Body(self._still)]
        if self._turning is not None:
            on_table = self._scene.course.turntable is not None
            bodies.append(Body(self._turning, T_world_object, twist, turning=on_table))
        return bodies

    def _placed(self, index: int, moment: Moment) -> tuple[Array, Array]:
        """Camera and turning parts (4, 4) in the world, with what the rig does wrong."""
        T_world_camera = self._scene.course.T_world_camera[index]
        T_world_object = self._T_world_object[index]
        for effect in self._rig:
            motion = effect.motion(moment)
            if motion is None:
                continue
            if self._scene.course.turntable is None:
                T_world_camera = T_world_camera @ inverse(exp(motion))
            else:
                moved = T_world_camera @ exp(motion) @ inverse(T_world_camera)
                T_world_object = moved @ T_world_object
        return T_world_camera, T_world_object

    def _twists(self, course: SimulatedCourse, index: int) -> tuple[Array, Array]:
        """(6,) of the turning parts and of the camera, in the world frame [rad/s, m/s]; 0 where they stop."""
        around = neighbours(course, index)
        if around is None:
            return np.zeros(6), np.zeros(6)
        before, after, seconds = around
        pairs = (self._T_world_object, course.T_world_camera)
        table, camera = (twist_between(poses[before], poses[after], seconds) for poses in pairs)
        return table, camera

    def _channels(self) -> Channels:
        """No more than the sensor's effects ask for."""
        shadow = self._sensor.effect("projector_shadow")
        # a shadow is found by rays to the projector, not by edges
        others = [effect for effect in self._sensor.effects if effect is not shadow]
        asked = {variable for effect in others for variable in effect.variables}
        return Channels(
            edges="edge" in asked,
            lit=None if shadow is None else float(np.mean(getattr(shadow, "baseline", 0.0))),
            indirect=None if self._sensor.effect("multipath") is None else Bounce(),
            motion=self._scene.course.turntable is not None or self._scene.course.continuous,
            area=True,
        )

    def _as_stated(self, view: View) -> View:
        """The view as the recording holds it: a time-of-flight sensor turns range into depth by the stated rays."""
        sensor = self._sensor
        principle = sensor.principle.or_else(self._stated.principle)
        view = replace(view, baseline=sensor.baseline, principle=principle, done=self._done)
        if self._true is self._stated or view.depth is None:
            return view
        stated = replace(view, camera=self._stated)
        if not view.time_of_flight:
            return stated
        return replace(stated, depth=(view.depth * (view.stretch / stated.stretch)).astype(view.depth.dtype))


def with_paint(view: View, paint: Paint, T_picture_camera: Array) -> View:
    """The view with a pattern on the surfaces that carry it."""
    if view.depth is None:
        return view
    mask, grey = painted(paint, view.depth, view.camera, T_picture_camera)
    if not mask.any():
        return view
    if view.reflectance is not None:
        reflectance = view.reflectance.copy()
        reflectance[mask] = paint.black + (paint.white - paint.black) * grey
        view = replace(view, reflectance=reflectance)
    if view.color is not None:
        color = view.color.copy()
        color[mask] = np.round(255 * grey)[:, None].astype(np.uint8)
        view = replace(view, color=color)
    return view


def whole_mesh(parts: list[Part]) -> Mesh:
    """Parts as one mesh with `scalars["reflectance"]`, and `scalars["translucent"]` where some part has it."""
    meshes = [part.mesh for part in parts]
    if any(TRANSLUCENT in mesh.scalars for mesh in meshes):  # of the others it is not known
        unsaid = [{TRANSLUCENT: np.full(len(mesh.vertices), np.nan, np.float32)} for mesh in meshes]
        meshes = [replace(mesh, scalars=no | mesh.scalars) for mesh, no in zip(meshes, unsaid, strict=True)]
    mesh = joined(meshes)
    kept = {name: values for name, values in mesh.scalars.items() if name == TRANSLUCENT}
    grey = np.concatenate([part_reflectance(part) for part in parts]) if parts else np.zeros(0, np.float32)
    return replace(mesh, scalars=kept | {"reflectance": grey})


def part_reflectance(part: Part) -> np.ndarray:
    """(vertices,) in the infrared: the part's one, that of its mesh, or the grey of its colours."""
    n = len(part.mesh.vertices)
    if part.reflectance is not None:
        return np.full(n, part.reflectance, np.float32)
    if "reflectance" in part.mesh.scalars:
        return part.mesh.scalars["reflectance"].astype(np.float32)
    if part.mesh.colors is not None:
        return (part.mesh.colors.mean(axis=1) / 255.0).astype(np.float32)
    return np.full(n, USUAL_REFLECTANCE, np.float32)


def _caster(parts: list[Part]) -> RayCaster | None:
    return RayCaster(whole_mesh(parts)) if parts else None
