"""One recording to be made: what stands before the camera, from where, and when."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tools.trial.concealed.rays import Camera, Hits, Panel, cast, joined

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Shot:
    """Attributes:
    panels: the scene.
    T: (4, 4) where the camera really is.
    stated: (4, 4) where the poses file says that it is.
    times: (n,) of the frames [s since switch-on].
    temperatures: (n,) [degC].
    degrees: of the turntable, as commanded; None without a table.
    series: recording it belongs to, where several shots make one; their poses share one error.
    bands: (4, 4) each, where the camera really is while the rows are exposed, from the top; empty when all at once.
    sigma: how large the errors of its pose are stated to be, times the usual.
    lamp: how bright it is, times the usual.
    kept: what devices have computed of it.
    """

    camera: Camera
    panels: list[Panel]
    T: Array
    stated: Array
    times: Array
    temperatures: Array
    long: bool = False
    degrees: float | None = None
    series: int | None = None
    bands: tuple[Array, ...] = ()
    sigma: float = 1.0
    lamp: float = 1.0
    kept: dict[Any, Any] = field(default_factory=dict)

    @cached_property
    def hits(self) -> Hits:
        """At the pixel centres."""
        if not self.bands:
            return cast(self.panels, self.T, self.camera.rays())
        rows = np.array_split(self.camera.rays(), len(self.bands))
        return joined([cast(self.panels, T, part) for T, part in zip(self.bands, rows, strict=True)])

    @cached_property
    def sub(self) -> list[Hits]:
        """At four places of every pixel."""
        return [cast(self.panels, self.T, self.camera.rays(du, dv)) for du in (-0.25, 0.25) for dv in (-0.25, 0.25)]

    @cached_property
    def stretch(self) -> Array:
        """(h, w) range over depth."""
        return np.asarray(np.linalg.norm(self.camera.rays(), axis=-1))

    @cached_property
    def interior(self) -> NDArray[np.bool_]:
        """Pixels whose surroundings show one panel and one print only."""
        from scipy.ndimage import maximum_filter, minimum_filter

        code = self.hits.panel + 10.0 * np.round(self.hits.reflectance, 3)
        near = minimum_filter(self.hits.panel, 13) == maximum_filter(self.hits.panel, 13)
        return np.asarray(near & (minimum_filter(code, 5) == maximum_filter(code, 5)) & (self.hits.panel >= 0))


@dataclass(frozen=True)
class Place:
    """What a law may depend on, per pixel (h, w) or as numbers, for one moment of one shot."""

    shot: Shot
    frame: int
    amplitude: Array  # counts; ones for triangulation

    @property
    def z(self) -> Array:
        return self.shot.hits.z

    @property
    def r(self) -> Array:
        return self.shot.hits.z * self.shot.stretch

    @property
    def u(self) -> Array:
        return np.broadcast_to(np.arange(self.shot.camera.width, dtype=float), self.z.shape)

    @property
    def v(self) -> Array:
        return np.broadcast_to(np.arange(self.shot.camera.height, dtype=float)[:, None], self.z.shape)

    @property
    def x(self) -> Array:
        """-1 ... 1 across the image."""
        return (self.u - self.shot.camera.cx) / (0.5 * self.shot.camera.width)

    @property
    def y(self) -> Array:
        """-1 ... 1 down the image, in units of half its width."""
        return (self.v - self.shot.camera.cy) / (0.5 * self.shot.camera.width)

    @property
    def time(self) -> float:
        return float(self.shot.times[self.frame])

    @property
    def temperature(self) -> float:
        return float(self.shot.temperatures[self.frame])
