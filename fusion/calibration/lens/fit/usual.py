"""Whether a camera is like others: pixels are square, and a lens looks through the middle of its picture.

A board that bends, or is tilted to one side only, leaves a camera that fits its pictures and is none.
"""

import numpy as np

from fusion.calibration.lens.fit.solve import LensSolution
from fusion.geometry.pose import Array
from fusion.recording.checks.intrinsics import OFF_CENTRE

SQUARE = 0.01  # by which sides of pixels differ at most (guess)
SURE = 4.0  # standard deviations, which boards that contradict each other understate


def unusual(solution: LensSolution, covariance: Array, size: tuple[int, int]) -> list[str]:
    """A sentence for each way in which a camera is unlike others and its views are sure of it.

    Args:
        solution: of the views.
        covariance: (k, k) of its parameters.
        size: (width, height) of the pictures [px].
    """
    fx, fy, *middle = solution.parameters[:4]
    std = np.sqrt(np.diag(covariance))
    slope = np.array([1 / fx, -1 / fy])
    ratio, sigma = float(np.log(fx / fy)), float(np.sqrt(slope @ covariance[:2, :2] @ slope))
    found = []
    if abs(ratio) > max(SQUARE, SURE * sigma):
        found.append(f"fx and fy differ by {abs(ratio):.1%} (+- {sigma:.1%}) and pixels are square")
    for name, at, sigma, side in zip(("cx", "cy"), middle, std[2:4], size, strict=True):
        off = at - (side - 1) / 2
        if abs(off) > max(OFF_CENTRE * side, SURE * sigma):
            found.append(f"{name} is {abs(off):.0f} px (+- {sigma:.0f}) from the middle of the picture")
    do = "hold the board flat and still and tilt it to all sides, unless the pictures were stretched or cut"
    return [f"the camera is like no other: {', '.join(found)}: {do}"] if found else []
