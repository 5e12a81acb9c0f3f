"""View: what every pixel looked at, as far as sensor effects ask for it."""

from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera, Principle, crop
from fusion.sensor.moment import Moment

Image = NDArray[np.floating]

# Kinect v1: Pagliari 2014 states about 7.4 cm, github ankurhanda/simkinect uses 0.075
BASELINE_M = 0.075
# Kinect v2: libfreenect2 tables, from memory
MODULATIONS_HZ = (80e6, 16e6, 120e6)
MODULATION_HZ = 80e6
LIGHT_SPEED = 299_792_458.0  # [m/s]


@dataclass(frozen=True)
class Edges:
    """The nearest depth edge of every pixel, as far as a few pixels away.

    Where nothing is on one of its sides, jump and light are 0, although there is an edge. The jump is the one at the
    edge itself: a slope between edge and pixel is not in it.
    """

    distance: Image  # (h, w) to the edge [px], below a pixel where it is known that well; inf where none is near
    direction: Image  # (h, w) where the edge lies [rad]: 0 to the right (+u), pi/2 below (+v); 0 where none is near
    # (h, w) depth across the edge minus the own depth [m]: positive for the foreground; 0 where none is near
    jump: Image
    light: Image  # (h, w) amplitude across the edge over the own amplitude [1]; 1 where none is near


@dataclass(frozen=True)
class Indirect:
    """Light that reached a pixel by one bounce off another surface."""

    ratio: Image  # (h, w) its amplitude over that of the direct light [1]
    path: Image  # (h, w) how much longer its way is than the direct one, there and back, over two [m]


@dataclass(frozen=True)
class View:
    """What the pixels of one frame looked at: from the renderer (truth), or estimated from a measurement.

    A field that is None is not known; an effect that needs it then changes nothing.

    Attributes:
        camera: the depth camera.
        depth: (h, w) planar z [m] of the surface, NaN where there is none.
        incidence: (h, w) angle between ray and surface normal [rad], 0 frontal.
        normals: (h, w, 3) unit normals in the camera frame, towards the camera.
        ir: (h, w) amplitude [count].
        color: (h, w, 3) uint8 RGB.
        baseline: place of the projector on the camera's x axis [m], for triangulating sensors; negative to the left.
        reflectance: (h, w) in the infrared [1].
        translucent: (h, w) 1 where light enters the material, 0 where it does not, NaN where nobody said.
        edges: the nearest depth edges.
        lit: (h, w) share of the pixel that the projector or lamp reaches [1].
        indirect: light that came by another surface.
        velocity: (h, w, 3) of the surface in the camera frame [m/s].
        turning: (h, w) True where the surface stands on the turntable.
        moment: time, temperature and the like.
        principle: of the sensor; the camera's where unknown.
        modulation: frequency of a time-of-flight sensor [Hz] at which effects of one phase are computed.
        frequencies: all its modulations [Hz]; empty when it has that one only.
        done: names of effects that the image holds already, because the renderer moved rays or surfaces.
        noisier: (h, w) factor on the noise that the camera itself gives each pixel, 1 where it is sure.
        placed_by_images: the pose of the surface was found in images of this camera, by the stated rays.
        bent: (h, w) [m] by how much what a pixel sees leaves a plane (rms), inf across an edge: of few pixels that is
            a large part of the scene, and depth the mean of it.
    """

    camera: Camera
    depth: Image | None = None
    incidence: Image | None = None
    normals: Image | None = None
    ir: NDArray | None = None
    color: NDArray[np.uint8] | None = None
    baseline: float = BASELINE_M
    reflectance: Image | None = None
    translucent: Image | None = None
    edges: Edges | None = None
    lit: Image | None = None
    indirect: Indirect | None = None
    velocity: Image | None = None
    turning: NDArray[np.bool_] | None = None
    moment: Moment = field(default_factory=Moment)
    principle: Principle = Principle.UNKNOWN
    modulation: float = MODULATION_HZ
    frequencies: tuple[float, ...] = ()
    done: frozenset[str] = frozenset()
    placed_by_images: bool = False
    noisier: Image | None = None
    bent: Image | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "principle", Principle(self.principle))

    def cut(self, window: tuple[slice, slice]) -> "View":
        """What a window (rows, columns) of the image shows."""

        def part(value: Any) -> Any:
            if isinstance(value, (Edges, Indirect)):
                return replace(value, **{own.name: part(getattr(value, own.name)) for own in fields(value)})
            inside = isinstance(value, np.ndarray) and value.shape[:2] == self.camera.shape
            return np.ascontiguousarray(value[window]) if inside else value

        images = {own.name: part(getattr(self, own.name)) for own in fields(self) if own.name != "camera"}
        return replace(self, camera=crop(self.camera, window), **images)

    @property
    def focal_baseline(self) -> float:
        """Disparity times depth [px m]."""
        return self.camera.fx * abs(self.baseline)

    @property
    def time_of_flight(self) -> bool:
        """True when the sensor measures along the ray, so that errors of length are radial."""
        return self.principle.or_else(self.camera.principle) == Principle.TIME_OF_FLIGHT

    @property
    def stretch(self) -> NDArray[np.float32]:
        """(h, w) length of the ray per metre of depth [1]: radial distance = stretch * z."""
        return stretch(self.camera)

    @property
    def along_ray(self) -> NDArray[np.float32] | float:
        """(h, w) or 1: depth per metre of an error of length: 1 / stretch where the sensor measures along the ray."""
        return 1.0 / self.stretch if self.time_of_flight else 1.0

    @property
    def wavelength(self) -> float:
        """Radial distance in which the phase turns once [m]: c / (2 f)."""
        return LIGHT_SPEED / (2.0 * self.modulation)

    @property
    def u(self) -> NDArray[np.float32]:
        """(1, w) column of a pixel [px]."""
        return np.arange(self.camera.width, dtype=np.float32)[None, :]

    @property
    def v(self) -> NDArray[np.float32]:
        """(h, 1) row of a pixel [px]."""
        return np.arange(self.camera.height, dtype=np.float32)[:, None]

    @property
    def radius(self) -> NDArray[np.float32]:
        """(h, w) distance to the principal point [px]."""
        return np.hypot(self.u - np.float32(self.camera.cx), self.v - np.float32(self.camera.cy))


@lru_cache(maxsize=16)
def stretch(camera: Camera) -> NDArray[np.float32]:
    """(h, w) length of a camera's rays per metre of depth [1]; cached, read only."""
    x, y = camera.rays()[..., 0], camera.rays()[..., 1]
    length = np.sqrt(x * x + y * y + 1.0)
    length.flags.writeable = False
    return length


def incidence_of(normals: Image, camera: Camera) -> Image:
    """Angle (h, w) [rad] between the pixels' rays and the normals (h, w, 3) in the camera frame."""
    rays = camera.rays()
    along = normals[..., 0] * rays[..., 0] + normals[..., 1] * rays[..., 1] + normals[..., 2]
    return np.arccos(np.clip(np.abs(along) / stretch(camera), 0.0, 1.0))
