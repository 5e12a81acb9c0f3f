"""What the camera may get wrong, as seen by a rigid thing that turns about one axis.

A wrong focal length stretches the object across the line of sight but not along it; a depth error that varies with
distance stretches it along. Either makes the object change its shape while it turns, which a rigid object cannot.
A common scale changes nothing and stays unknown. The parameters are small changes of every point:

    focal            log(f / f0): the point moves by (-X, -Y, 0) per unit
    cx, cy           principal point [px]
    offset           depth + offset [m]
    radial           depth + radial * rho^2 [m], rho^2 = x^2 + y^2 of the ray, times (z / z0)^2 for triangulation
    tilt_u, tilt_v   depth + tilt_u * x + tilt_v * y [m] of the ray, times the same: by a lamp beside the lens, delays
                     over the chip; walls at a free tilt cannot show it
    stretch          depth + stretch * s [m], s = -1..1 over the object's range of distance; only beside a focal length
                     that is known, as the two do nearly the same
    bend2 ... bend6  depth + bend * P_k(s), Legendre polynomials of that distance [m]
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.depth import PointMap
from fusion.turntable.views import ObjectView

Array = NDArray[np.float64]

LENS = ("focal", "cx", "cy")
DEPTH = ("offset", "radial", "tilt_u", "tilt_v", "stretch", "bend2", "bend3", "bend4", "bend5", "bend6")
NAMES = LENS + DEPTH
# how wrong a nominal camera may be, one standard deviation (guess): 3 %, 4 px, 10 mm, 50 mm, 20 mm, 3 mm each
PRIOR = np.array([0.03, 4.0, 4.0, 0.010, 0.05, 0.02, 0.02, 0.003, 0.003, 0.003, 0.003, 0.003, 0.003])
_FIRST = len(LENS)  # of depth
LEAST_PRIOR = 1e-9  # [m] of an error that is held at 0
LENS_MODEL = 0.0005  # of the focal length: what a calibrated lens still does that no model of it holds (guess)
CORNER = 0.2  # rho^2 near the corners of a usual image: where a radial error is as large as the others


@dataclass(frozen=True)
class SelfCheck:
    """Small errors of camera and depth, to be added to what the camera file says."""

    values: Array  # (13,) in the order of NAMES
    # near, far: range of distance over which the polynomials are laid [m]
    near: float
    far: float
    triangulation: bool = False  # True where radial depth errors grow with the square of distance
    # (13,) how wrong each may be before the scan is seen, one standard deviation
    prior: Array = field(default_factory=PRIOR.copy)

    def only(self, *names: str) -> "SelfCheck":
        """These errors alone, the others taken as nuisance: zero."""
        return replace(self, values=self.values * np.isin(NAMES, names))

    def depth_alone(self) -> "SelfCheck":
        """The errors of depth, with the camera as stated."""
        return self.only(*DEPTH)

    def open_for(self, names: Collection[str]) -> "SelfCheck":
        """With these errors open, and the others held at what they are."""
        return replace(self, prior=np.where(np.isin(NAMES, list(names)), self.prior, 0.0))

    @property
    def wrong_depth(self) -> bool:
        """Whether it changes the depth."""
        return bool(self.values[_FIRST:].any())

    def depth_errors(self) -> dict[str, float]:
        """What is to be added to the depth [m], by name, and the distances of s = -1 and 1; empty where nothing is."""
        if not self.wrong_depth:
            return {}
        named = {name: float(value) for name, value in zip(NAMES, self.values, strict=True)}
        return {"near": self.near, "far": self.far} | {name: named[name] for name in DEPTH}

    @property
    def open(self) -> NDArray[np.bool_]:
        """(10,) errors of depth that may be anything but 0."""
        return np.asarray(self.prior[_FIRST:] > 0)

    @property
    def information(self) -> Array:
        """(10,) 1 / variance of the errors of depth before the scan is seen."""
        return np.asarray(1 / np.maximum(self.prior[_FIRST:], LEAST_PRIOR) ** 2)

    @property
    def span(self) -> NDArray[np.float32]:
        """(4,) as kernels want it: near, far [m], 1 for triangulation, 1 with errors of depth."""
        return np.array([self.near, self.far, self.triangulation, self.wrong_depth], np.float32)

    def moved(self, step: Array) -> "SelfCheck":
        """With steps (10,) of the errors of depth, or none."""
        return self if len(step) == 0 else replace(self, values=self.values + np.append(np.zeros(_FIRST), step))

    def points(self, points: NDArray[np.float32]) -> NDArray[np.float32]:
        """Points (n, 3) along their rays, with the errors of depth taken out."""
        if not self.wrong_depth:
            return points
        share = (self.depth_terms(points.astype(float)) @ self.values[_FIRST:]) / points[:, 2]
        return np.asarray(points * (1 + share[:, None]), np.float32)

    def depth_terms(self, points: Array) -> Array:
        """Depth errors (n, 10) at points (n, 3) per unit, in the order of NAMES."""
        z = points[:, 2]
        s = np.clip((2 * z - self.near - self.far) / (self.far - self.near), -1, 1)
        x, y = points[:, 0] / z, points[:, 1] / z
        growing = (2 * z / (self.near + self.far)) ** 2 if self.triangulation else np.ones_like(z)
        legendre = [np.ones_like(s), s]
        for k in range(1, 6):  # Bonnet's recursion
            legendre.append(((2 * k + 1) * s * legendre[k] - k * legendre[k - 1]) / (k + 1))
        return np.column_stack([legendre[0], *((x**2 + y**2, x, y) * growing), *legendre[1:]])

    def depth_change(self, points: Array) -> Array:
        """What the depth errors add at points (n, 3) in the camera's frame [m]."""
        return np.asarray(self.depth_terms(points) @ self.values[_FIRST:])

    def camera(self, camera: Camera) -> Camera:
        """The camera with the errors of focal length and principal point taken out."""
        scale = float(np.exp(self.values[0]))
        return replace(
            camera,
            fx=camera.fx * scale,
            fy=camera.fy * scale,
            cx=camera.cx + float(self.values[1]),
            cy=camera.cy + float(self.values[2]),
        )

    def view(self, nominal: ObjectView) -> ObjectView:
        """A view as it looks with the errors taken out (normals are kept: the change is second order)."""
        camera = self.camera(nominal.map.camera)

        old_camera = nominal.map.camera

        def corrected(points: NDArray[np.float32]) -> NDArray[np.float32]:
            flat = points.reshape(-1, 3).astype(float)
            z = flat[:, 2] + self.depth_terms(flat) @ self.values[_FIRST:]
            x = (flat[:, 0] / flat[:, 2] * old_camera.fx - self.values[1]) / camera.fx * z
            y = (flat[:, 1] / flat[:, 2] * old_camera.fy - self.values[2]) / camera.fy * z
            return np.asarray(np.column_stack([x, y, z]).reshape(points.shape), np.float32)

        old = nominal.map
        new = PointMap(camera, corrected(old.points), old.normals, old.sigma)
        return ObjectView(new, corrected(nominal.points), nominal.normals, nominal.sigma)


@dataclass(frozen=True)
class DepthKnown:
    """How well a calibrated depth is known, one standard deviation."""

    std: float  # over distance and image [m]
    # (2,) over the rays' x and y [m per unit]; inf where walls at free tilts were all that it was seen on
    tilt: tuple[float, float] = (np.inf, np.inf)
    # of points (n, 3), what each of r independent errors does to their depth (r, n) [m]; None where a calibration does
    # not say it
    errors: Callable[[Array], Array] | None = None

    def prior(self, points: Array, check: SelfCheck) -> Array:
        """(10,) of each error of depth, as they explain best what the depth of points (n, 3) may be wrong by.

        Each by itself: other laws that a calibration does not rule out tell how large errors may be, not how they go
        together, as the truth is none of them. Drawn along the way to such a law, the fit takes its tilts over with its
        stretch (angles 0.24 instead of 0.10 deg on unit 0 of seed 443, `tools.sets.fresh_units`).
        """
        if self.errors is None or len(points) == 0:
            left = np.hypot(self.tilt, self.std / np.sqrt(CORNER))
            return np.array([self.std, self.std / CORNER, *left] + 6 * [self.std])
        each = np.linalg.lstsq(check.depth_terms(points), self.errors(points).T, rcond=None)[0]
        return np.asarray(np.linalg.norm(each, axis=1))


def prior_of(camera: Camera, known: DepthKnown | None, points: Array, check: SelfCheck) -> Array:
    """How wrong camera and depth may be (13,): as their calibration says, else as nominal ones usually are.

    Args:
        camera: its `std` tells what a calibration knows of it.
        known: of a depth that was calibrated; None for one that was not.
        points: (n, 3) where the depth matters [m].
        check: the range of distance that its errors are laid over.
    """
    prior = PRIOR.copy()
    if "fx" in camera.std:
        prior[0] = min(prior[0], float(np.hypot(camera.std["fx"] / camera.fx, LENS_MODEL)))
    for k, name in ((1, "cx"), (2, "cy")):
        prior[k] = min(prior[k], max(camera.std.get(name, np.inf), LENS_MODEL * camera.fx))
    if known is not None:
        prior[_FIRST:] = np.clip(known.prior(points, check), LEAST_PRIOR, prior[_FIRST:])
    return prior


def no_errors(views: Sequence[ObjectView], known: DepthKnown | None = None) -> SelfCheck:
    """A camera and depth as stated, laid over the range of distance that the views show.

    Args:
        views: their camera tells how well it is known.
        known: how well their depth is known, see `prior_of`.
    """
    points = np.concatenate([v.points[::20] for v in views])
    near, far = np.percentile(points[:, 2], [1, 99]) if len(points) else (0.5, 1.0)
    camera = views[0].map.camera
    plain = SelfCheck(np.zeros(len(NAMES)), float(near), float(max(far, near + 0.01)), camera.principle.triangulates)
    return replace(plain, prior=prior_of(camera, known, points.astype(float), plain))
