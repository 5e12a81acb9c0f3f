"""A scene as a sensor would have recorded it; the same seed, the same bits."""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera, Principle
from fusion.geometry.pose import Array, exp, inverse, transform
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.recording.ahead import ahead
from fusion.recording.cameras.presets import PRESETS
from fusion.recording.recording import Frame
from fusion.sensor.effects.readout.lateral_noise import jump
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View
from fusion.simulation.rendering.exposure import Exposures, whole_mesh
from fusion.simulation.rendering.light_level import infrared, with_light_level
from fusion.simulation.scene.scene import Scene

# every use of randomness has its own stream, so that none shifts another
TABLE, FRAME, INFRARED, POSES, PLACEMENT, SHAKE = range(6)
# the camera of a scene that names none, by the sensor's principle
USUAL_CAMERA = {Principle.TIME_OF_FLIGHT: "kinect-v2", Principle.STRUCTURED_LIGHT: "kinect-v1"}


@dataclass(frozen=True)
class Simulation:
    """A simulated recording and its truth.

    Attributes:
        scene, sensor: what it was made from.
        seed: of every random number in it.
        camera: as stated in the recording.
        truth: true pose of the camera at every frame, in the world; before a turntable in the turning object's frame,
            which is the world at frame 0.
        stated: the same as the recording states it, or None.
        turned_deg: (n,) true angles of the table [deg].
        telemetry: columns of `telemetry.csv`, with "timestamp".
    """

    scene: Scene
    sensor: Sensor
    seed: int
    camera: Camera
    truth: Trajectory
    stated: Trajectory | None
    turned_deg: Array
    telemetry: dict[str, NDArray[np.float64]]

    def __repr__(self) -> str:
        size = f"{len(self)} frames of {self.camera.width} x {self.camera.height}"
        return f"<Simulation of {self.scene.name}: {size}, as {self.sensor.name} sees it, seed {self.seed}>"

    def __len__(self) -> int:
        return len(self.truth)

    @property
    def timestamps(self) -> NDArray[np.float64]:
        return self.truth.timestamps

    @property
    def mesh(self) -> Mesh:
        """What the poses refer to: before a turntable all that turns, else everything; with reflectance."""
        with_table = self.scene.course.turntable is not None
        return whole_mesh([part for part in self.scene.parts if part.turns or not with_table])

    @property
    def truth_mesh(self) -> Mesh:
        """What a scan of it should give, in the same frame."""
        with_table = self.scene.course.turntable is not None
        return whole_mesh([p for p in self.scene.parts if p.scanned and (p.turns or not with_table)])

    def frames(self) -> Iterator[Frame]:
        """The frames in their order, those to come rendered meanwhile."""
        exposures = Exposures(self.scene, self.sensor, self.camera, self.turned_deg)

        def rendered(index: int) -> View:
            shake = np.random.default_rng([self.seed, SHAKE, index])
            return exposures.view(index, self.moment(index), shake)

        previous: Image | None = None
        for index, seen in enumerate(ahead(rendered, range(len(self)))):
            view = seen()
            frame = self._frame(index, replace(view, moment=replace(view.moment, previous=previous)))
            previous = frame.depth
            yield frame

    @cached_property
    def placements(self) -> list[int]:
        """(n) how often the scene was set up anew before each frame."""
        moves = [not np.array_equal(before, after) for before, after in pairwise(self.truth.poses)]
        return np.cumsum([0, *moves]).tolist()

    def moment(self, index: int) -> Moment:
        """The conditions of a frame but for what the one before it showed."""
        course, table = self.scene.course, self.scene.course.turntable
        time, T_camera_world = float(course.timestamps[index]), inverse(course.T_world_camera[index])
        moment = Moment(
            time=time,
            temperature=float(self.telemetry.get("temperature_c", np.full(len(self), np.nan))[index]),
            ambient=float(self.telemetry.get("ambient_lux", np.full(len(self), self.scene.ambient_lux))[index]),
            unit=unit_seed(self.sensor, self.camera),
            placement=int(np.random.SeedSequence([self.seed, PLACEMENT, self.placements[index]]).generate_state(1)[0]),
        )
        if table is None:
            return moment
        direction = np.asarray(table.axis_direction, float)
        return replace(
            moment,
            table_angle=float(np.deg2rad(table.commanded_deg()[index])),
            axis_point=transform(T_camera_world, np.asarray(table.axis_point, float)),
            axis_direction=T_camera_world[:3, :3] @ (direction / np.linalg.norm(direction)),
        )

    def _frame(self, index: int, view: View) -> Frame:
        # generators of its own per frame: the bits do not depend on which frames are asked for
        rng = np.random.default_rng([self.seed, FRAME, index])
        view = replace(view, ir=self.sensor.amplitude(view))
        depth = measured(view, self.sensor, (self.scene.edge_lost, self.scene.edge_mixed), rng)
        ir = None
        # a structured-light sensor sees its pattern or, the projector covered, the scene: not both at once
        if self.scene.infrared or self.sensor.principle != Principle.STRUCTURED_LIGHT:
            ir = infrared(view, self.sensor, np.random.default_rng([self.seed, INFRARED, index]))
        return Frame(index, float(self.timestamps[index]), depth, lit(view) if self.scene.color else None, ir)


def simulate(scene: Scene, sensor: Sensor | None = None, seed: int = 0) -> Simulation:
    """Plan a recording: true angles and stated poses are drawn now, frames when they are asked for.

    Args:
        scene: what is seen, from where.
        sensor: sees it; None makes no errors.
        seed: of every random number; the same seed, the same bits.

    >>> wall = fusion.built_in("wall", {"distance_m": 1.2, "frames": 2})
    >>> made = fusion.simulate(wall, fusion.read_sensor("kinect-v2-indoors"), seed=1)
    >>> made
    <Simulation of wall: 2 frames of 512 x 424, as kinect-v2-indoors sees it, seed 1>
    >>> [round(float(np.nanmedian(frame.depth)), 1) for frame in made.frames()]
    [1.2, 1.2]
    """
    course, table = scene.course, scene.course.turntable
    n = len(course)
    sensor = with_light_level(sensor or Sensor())
    camera = stated_camera(scene, sensor)
    telemetry = {"timestamp": course.timestamps, **scene.telemetry}
    if table is None:
        turned, poses, nominal = np.zeros(n), course.T_world_camera, course.T_world_camera
    else:
        turned = table.true_deg(np.random.default_rng([seed, TABLE]))
        poses = inverse(table.T_world_object(turned)) @ course.T_world_camera
        nominal = inverse(table.nominal().T_world_object(table.commanded_deg())) @ course.T_world_camera
        telemetry["turntable_deg"] = table.commanded_deg()
    stated = None
    if scene.poses is not None:
        sigmas = np.repeat([scene.poses.sigma_rad, scene.poses.sigma_m], 3)
        error = exp(sigmas * np.random.default_rng([seed, POSES]).standard_normal(6))
        stated = Trajectory(course.timestamps, (nominal if scene.poses.source == "nominal" else poses) @ error)
    return Simulation(scene, sensor, seed, camera, Trajectory(course.timestamps, poses), stated, turned, telemetry)


def stated_camera(scene: Scene, sensor: Sensor) -> Camera:
    """The scene's camera, else the usual one of the sensor, with the sensor's principle and name."""
    camera = scene.camera or PRESETS[USUAL_CAMERA.get(sensor.principle, "primesense")][0]
    return replace(
        camera,
        principle=sensor.principle.or_else(camera.principle),
        sensor=(sensor.sensor or sensor.name) if scene.camera is None or not camera.sensor else camera.sensor,
        serial=sensor.serial or camera.serial,
    )


def unit_seed(sensor: Sensor, camera: Camera) -> int:
    """What is frozen into a unit is the same in all its recordings, whatever their seed."""
    return zlib.crc32(f"{sensor.sensor or sensor.name} {sensor.serial or camera.serial}".encode())


def measured(view: View, sensor: Sensor, edge_shares: tuple[float, float], rng: np.random.Generator) -> Image:
    """One measured depth (h, w) [m] of a true view: the sensor's effects, then lost and mixed edge pixels."""
    true = cast(Image, view.depth)
    lost, mixed = edge_shares
    if not lost and not mixed:
        return sensor.sample(true, view, None, rng).astype(np.float32)
    step = jump(true)
    edge = np.abs(np.nan_to_num(step)) > 0
    chance, share = rng.random(true.shape), rng.random(true.shape)
    depth = sensor.sample(true, view, None, rng)
    depth = np.where(edge & (chance >= 1 - mixed), true + share * step, depth)
    return np.where(edge & (chance < lost), np.nan, depth).astype(np.float32)


def lit(view: View) -> NDArray[np.uint8] | None:
    """Colour (h, w, 3) under a lamp at the camera: darker where the surface turns away."""
    if view.color is None or view.incidence is None:
        return view.color
    shade = 0.45 + 0.55 * np.cos(np.nan_to_num(view.incidence))
    return np.round(view.color * shade[..., None]).astype(np.uint8)
