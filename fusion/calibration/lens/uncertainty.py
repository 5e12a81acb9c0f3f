"""How well the camera says where a ray goes: what its covariance means in pixels, and in millimetres at a distance."""

from dataclasses import dataclass

import cv2
import numpy as np

from fusion.calibration.lens.fit.solve import matrix
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array

GRID = (16, 12)  # columns, rows


@dataclass(frozen=True)
class ProjectionUncertainty:
    """Standard deviation of the projection over the picture, in its worst direction.

    A turn of the whole camera is taken out: whoever fits poses or tracks never sees it.
    """

    pixels: Array  # (rows, columns, 2) where [px]
    sigma_px: Array  # (rows, columns) [px]
    sigma_m: Array  # (rows, columns) [m] across the ray at the working distance
    distance: float  # the working distance [m]

    def numbers(self) -> dict[str, float]:
        """Centre, rms and worst, in pixels and in millimetres."""
        middle = (self.sigma_px.shape[0] // 2, self.sigma_px.shape[1] // 2)
        out = {"distance_m": self.distance}
        for name, values in (("px", self.sigma_px), ("mm", self.sigma_m * 1000)):
            out[f"centre_{name}"] = float(values[middle])
            out[f"rms_{name}"] = float(np.sqrt((values**2).mean()))
            out[f"worst_{name}"] = float(np.max(values))
        return out


def projection_uncertainty(camera: Camera, covariance: Array, distance: float) -> ProjectionUncertainty:
    """The projection uncertainty of a camera.

    Args:
        covariance: (k, k) of its parameters in the order of RATIONAL, of which there are 9 or 12.
    """
    u, v = np.meshgrid(np.linspace(0, camera.width - 1, GRID[0]), np.linspace(0, camera.height - 1, GRID[1]))
    pixels = np.stack([u, v], axis=2)
    parameters = np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion])
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 1e-9)
    xy = cv2.undistortPoints(pixels.reshape(-1, 1, 2), matrix(parameters), parameters[4:], criteria=criteria)
    rays = np.hstack([np.asarray(xy, float).reshape(-1, 2), np.ones((u.size, 1))])
    _, J = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix(parameters), parameters[4:])
    turn, inner = J[:, :3], J[:, 6 : 6 + len(covariance)]
    inner = inner - turn @ np.linalg.lstsq(turn, inner, rcond=None)[0]
    inner = inner.reshape(-1, 2, len(covariance))
    spread = inner @ covariance @ inner.transpose(0, 2, 1)
    sigma = np.sqrt(np.maximum(np.linalg.eigvalsh(spread)[:, -1], 0)).reshape(u.shape)
    return ProjectionUncertainty(pixels, sigma, sigma * distance / np.sqrt(camera.fx * camera.fy), distance)
