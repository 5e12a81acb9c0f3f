"""What the camera may get wrong, as seen by a rigid thing that turns about one axis.

A wrong focal length stretches the object across the line of sight but not along it; a depth error that varies with
distance stretches it along. Either makes the object change its shape while it turns, which a rigid object cannot.
A common scale changes nothing and stays unknown. The parameters are small changes of every point:

    focal            log(f / f0): the point moves by (-X, -Y, 0) per unit
    cx, cy           principal point [px]
    offset           depth + offset [m]
    radial           depth + radial * rho^2 [m], rho^2 = x^2 + y^2 of the ray, times (z / z0)^2 for triangulation
    bend2 ... bend6  depth + bend * P_k(s), Legendre polynomials of the distance over the object's range, s = -1..1 [m]
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.depth import PointMap
from fusion.turntable.views import View

Array = NDArray[np.float64]

NAMES = ("focal", "cx", "cy", "offset", "radial", "bend2", "bend3", "bend4", "bend5", "bend6")
# how wrong a nominal camera may be, one standard deviation (guess): 3 %, 4 px, 10 mm, 50 mm, 3 mm each
PRIOR = np.array([0.03, 4.0, 4.0, 0.010, 0.05, 0.003, 0.003, 0.003, 0.003, 0.003])
LENS_MODEL = 0.0005  # of the focal length: what a calibrated lens still does that no model of it holds (guess)
CORNER = 0.2  # rho^2 near the corners of a usual image: where a radial error is as large as the others


@dataclass(frozen=True)
class SelfCheck:
    """Small errors of camera and depth, to be added to what the camera file says.

    Attributes:
        values: (10,) in the order of NAMES.
        near, far: range of distance over which the polynomials are laid [m].
        triangulation: True where radial depth errors grow with the square of distance.
        prior: (10,) how wrong each may be before the scan is seen, one standard deviation.
    """

    values: Array
    near: float
    far: float
    triangulation: bool = False
    prior: Array = field(default_factory=PRIOR.copy)

    def only(self, *names: str) -> "SelfCheck":
        """These errors alone, the others taken as nuisance: zero."""
        return replace(self, values=self.values * np.isin(NAMES, names))

    def _depth_terms(self, points: Array) -> Array:
        """Depth errors (n, 7) at points (n, 3) per unit of offset, radial, bend2 to bend6."""
        z = points[:, 2]
        s = np.clip((2 * z - self.near - self.far) / (self.far - self.near), -1, 1)
        rho2 = (points[:, 0] ** 2 + points[:, 1] ** 2) / z**2
        if self.triangulation:
            rho2 = rho2 * (2 * z / (self.near + self.far)) ** 2
        legendre = [np.ones_like(s), s]
        for k in range(1, 6):  # Bonnet's recursion
            legendre.append(((2 * k + 1) * s * legendre[k] - k * legendre[k - 1]) / (k + 1))
        return np.column_stack([legendre[0], rho2, *legendre[2:]])

    def depth_change(self, points: Array) -> Array:
        """What the depth errors add at points (n, 3) in the camera's frame [m]."""
        return np.asarray(self._depth_terms(points) @ self.values[3:])

    def depth(self, depth: NDArray[np.float32], camera: Camera) -> NDArray[np.float32]:
        """A depth image (h, w) [m] with the depth errors taken out."""
        points = camera.points(depth).reshape(-1, 3).astype(float)
        known = np.isfinite(points[:, 2])
        out = depth.copy().reshape(-1)
        out[known] += (self._depth_terms(points[known]) @ self.values[3:]).astype(np.float32)
        return out.reshape(depth.shape)

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

    def view(self, nominal: View) -> View:
        """A view as it looks with the errors taken out (normals are kept: the change is second order)."""
        camera = self.camera(nominal.map.camera)

        old_camera = nominal.map.camera

        def corrected(points: NDArray[np.float32]) -> NDArray[np.float32]:
            flat = points.reshape(-1, 3).astype(float)
            z = flat[:, 2] + self._depth_terms(flat) @ self.values[3:]
            x = (flat[:, 0] / flat[:, 2] * old_camera.fx - self.values[1]) / camera.fx * z
            y = (flat[:, 1] / flat[:, 2] * old_camera.fy - self.values[2]) / camera.fy * z
            return np.asarray(np.column_stack([x, y, z]).reshape(points.shape), np.float32)

        old = nominal.map
        new = PointMap(camera, corrected(old.points), old.normals, old.sigma)
        return View(new, corrected(nominal.points), nominal.normals, nominal.sigma)


def prior_of(camera: Camera, depth_std: float | None) -> Array:
    """How wrong camera and depth may be (10,): as their calibration says, else as nominal ones usually are.

    Args:
        camera: its `std` tells what a calibration knows of it.
        depth_std: of a depth that was calibrated [m], over distance and image; None for one that was not.
    """
    prior = PRIOR.copy()
    if "fx" in camera.std:
        prior[0] = min(prior[0], float(np.hypot(camera.std["fx"] / camera.fx, LENS_MODEL)))
    for k, name in ((1, "cx"), (2, "cy")):
        prior[k] = min(prior[k], max(camera.std.get(name, np.inf), LENS_MODEL * camera.fx))
    if depth_std is not None:
        prior[3:] = np.minimum(prior[3:], [depth_std, depth_std / CORNER] + 5 * [depth_std])
    return prior
