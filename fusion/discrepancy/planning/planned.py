"""Planned: what recordings of the menu would show a sensor, as tiles without a measurement."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.tile_covariance import TileCovariance, covariance_of
from fusion.discrepancy.observe.frame_block import FrameBlock, wanted_channels
from fusion.discrepancy.observe.observations import Observations, observe
from fusion.discrepancy.observe.scene.stage import KnownScene
from fusion.discrepancy.planning.menu import Choice, Setup
from fusion.geometry.camera import Camera, Principle
from fusion.geometry.pose import Array
from fusion.sensor.effect import Effect
from fusion.sensor.moment import Moment
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View
from fusion.simulation.rendering.exposure import whole_mesh
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.scene import Scene

FRAMES = 10
MOST_TILES = 700  # how clearly something would show is asked, and not where
SMALL_PX = 160  # width of images in which it is asked whether anything changes at all
NOTHING = 1e-8  # [m], [px] what the rays' arithmetic in single precision makes of no change


@dataclass(frozen=True)
class Standing:
    """What a recording will know of its scene: as the recordings at hand do."""

    place: int
    sigma_m: float
    sigma_rad: float
    mesh_sigma_m: float
    shape: str = "planned"


@dataclass(frozen=True)
class Planned:
    """A choice of the menu as this sensor would see it."""

    choice: Choice
    observations: Observations

    @cached_property
    def covariance(self) -> TileCovariance:
        return covariance_of(self.observations)

    def columns(self, effects: Sequence[Effect]) -> NDArray[np.float64]:
        """(n, k) what each effect changes; 0 where its law has no value."""
        with np.errstate(all="ignore"):
            return np.nan_to_num(self.observations.columns(effects), posinf=0, neginf=0)

    def changes_with(self, effects: Sequence[Effect]) -> bool:
        """True where any of these effects changes anything."""
        return bool(np.abs(self.columns(effects)).max(initial=0.0) > NOTHING)


@dataclass
class MenuViews:
    """What stands before a camera in scenes of the menu, each seen once from each pose."""

    camera: Camera
    sensor: Sensor
    _casters: dict[int, tuple[Scene, RayCaster]] = field(default_factory=dict)
    _seen: dict[tuple[int, bytes], View] = field(default_factory=dict)

    def small(self) -> "MenuViews":
        """The same scenes in small images, without what the sensor has of each pixel; itself where its images are."""
        if self.camera.width <= SMALL_PX:
            return self
        height = max(round(self.camera.height * SMALL_PX / self.camera.width), 1)
        smooth = tuple(effect for effect in self.sensor.effects if not _of_each_pixel(effect))
        return MenuViews(self.camera.resized(SMALL_PX, height), replace(self.sensor, effects=smooth))

    def of(self, scene: Scene, pose: Array) -> View:
        """As the effects of the sensor may ask of it; a scene that is made anew is another one."""
        if id(scene) not in self._casters:
            self._casters[id(scene)] = scene, RayCaster(whole_mesh(list(scene.parts)))
        key = id(scene), pose.tobytes()
        if key not in self._seen:
            baseline = self.sensor.baseline if self.sensor.principle.triangulates else None
            indirect = self.sensor.principle == Principle.TIME_OF_FLIGHT and len(scene.parts) > 1
            channels = replace(wanted_channels(baseline, indirect), motion=False)
            self._seen[key] = self._casters[id(scene)][1].view(self.camera, pose, channels)
        return self._seen[key]


def _of_each_pixel(effect: Effect) -> bool:
    return any(about.kind == "map" for about in parameters(effect).values())


def planned(choice: Choice, like: Sequence[FrameBlock], views: MenuViews) -> Planned | None:
    """The choice seen by a sensor with the camera and the care of the blocks at hand; None where nothing is seen."""
    sensor = views.sensor
    blocks = [_block_of(setup, like, views) for setup in choice.setups()]
    observations = observe(sensor, blocks, MOST_TILES)
    return Planned(choice, observations) if len(observations.residual) > 20 else None


def _block_of(setup: Setup, like: Sequence[FrameBlock], views: MenuViews) -> FrameBlock:
    camera, sensor, view = views.camera, views.sensor, views.of(setup.scene, setup.pose)
    known = np.isfinite(like[0].view.moment.temperature)
    celsius = setup.celsius if known else float("nan")
    view = replace(view, moment=Moment(time=setup.time, temperature=celsius, ambient=setup.scene.ambient_lux))
    if sensor.principle == Principle.TIME_OF_FLIGHT:
        amplitude = sensor.seen(view).ir
        view = replace(view, ir=None if amplitude is None else amplitude * setup.light)
    assert view.depth is not None
    zero, full = np.zeros(camera.shape), np.full(camera.shape, FRAMES, np.int32)
    stage: Any = Standing(
        setup.place,
        float(np.median([block.stage.sigma_m for block in like])),
        float(np.median([block.stage.sigma_rad for block in like])),
        float(np.median([block.stage.mesh_sigma_m or 0.0 for block in like])),
    )
    return FrameBlock(cast(KnownScene, stage), tuple(range(FRAMES)), view, view.depth, zero, full, setup.pose)
