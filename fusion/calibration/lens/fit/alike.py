"""Whether one camera took all pictures: what each says by itself of focal length and principal point."""

from collections.abc import Sequence

import numpy as np

from fusion.calibration.lens.fit.solve import LensSolution, jacobian
from fusion.calibration.lens.views import BoardView
from fusion.geometry.pose import Array
from fusion.geometry.robust import robust_std

APART = 2.0  # times what noise makes; boards of one camera reach 1.6 (simulated), 1.0 (a real Kinect v2), two cameras 3
SURE = 4.0  # standard deviations of that over the views
MEDIAN = 1.17  # standard deviation of a median absolute deviation over itself, times the square root of the count


def unlike(views: Sequence[BoardView], solution: LensSolution, sigma_px: float) -> list[str]:
    """A sentence where the views' own cameras differ by more than noise makes them differ; else nothing.

    Args:
        views: that were used.
        solution: of these views.
        sigma_px: scatter of one coordinate of a corner.
    """
    own = np.array([_own(*at, solution.parameters) for at in zip(views, solution.poses, strict=True)])
    apart, information = own[:, 0], own[:, 1]
    noise = sigma_px / np.sqrt(np.maximum(information, 1e-300))
    limit = max(APART, 1 + SURE * MEDIAN / np.sqrt(len(views)))
    found = []
    for value, std, (name, unit) in zip(
        apart.T, noise.T, (("focal lengths", "%"), ("cx", " px"), ("cy", " px")), strict=True
    ):
        if robust_std(value / std) > limit:
            factor = 100 if unit == "%" else 1
            found.append(
                f"{name} by {factor * robust_std(value):.1f}{unit} (noise: {factor * np.median(std):.1f}{unit})"
            )
    if not found:
        return []
    do = "one camera with its focus fixed, no picture mirrored or cut, the board still in every picture"
    return [f"the pictures are not those of one camera: each by itself, they differ in {', '.join(found)}: take {do}"]


def _own(view: BoardView, pose: Array, parameters: Array) -> tuple[Array, Array]:
    """(3,) by how much a view's own focal length [share], cx and cy [px] differ, one at a time, and the information."""
    J, r = jacobian(view, pose, parameters)
    Q, _ = np.linalg.qr(J[:, -6:])
    camera = np.column_stack([J[:, :2] @ parameters[:2], J[:, 2:4]])
    camera, r = camera - Q @ (Q.T @ camera), r - Q @ (Q.T @ r)
    information = (camera**2).sum(axis=0)
    return -(camera.T @ r) / np.maximum(information, 1e-300), information
