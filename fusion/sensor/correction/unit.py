"""A calibrated model belongs to one unit, as units of one kind differ by centimetres; how well it knows the depth."""

import numpy as np

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.presets import PRESETS
from fusion.sensor.sensor import Sensor


def refuse_other_unit(sensor: Sensor, camera: Camera, force: bool = False) -> None:
    """SensorError when a model is bound to another sensor or serial number than the camera's, unless forced.

    A name that is not stated on both sides is not compared; a preset is of no unit.
    """
    if force or (sensor.name in PRESETS and not sensor.serial):
        return
    for field in ("serial", "sensor"):
        bound, own = getattr(sensor, field), getattr(camera, field)
        if bound and own and bound != own:
            raise SensorError(
                f"the sensor model is of another camera ({field})",
                sensor.name,
                bound,
                own,
                "calibrate this camera, or pass --force",
            )


# [m] of files without errors: no calibration is taken for better or worse (guess): laws err by 0.7 mm there
LEAST, MOST = 1e-3, 3e-3
PARAMETERS = ("offset", "amplitude", "coefficient", "map", "values", "values_px", "scale")


def depth_std(sensor: Sensor, camera: Camera, distance: float) -> float | None:
    """Standard deviation of what a calibrated correction leaves over [m]; None where no depth law was fitted.

    Of files that do not say how the numbers of a law hold each other the squares are added, which is too careful.
    """
    if sensor.depth_errors is not None:
        return float(np.linalg.norm(sensor.depth_errors.at(camera.cx, camera.cy, distance)))
    per_pixel = distance**2 / max(camera.fx * abs(sensor.baseline), 1e-9)
    sizes = []
    for (effect, parameter), std in sensor.std.items():
        if effect in sensor.fitted and parameter in PARAMETERS:
            unit = distance if parameter == "scale" else 1.0
            disparity = parameter == "values_px" or effect.startswith("disparity")
            sizes.append(float(np.median(np.abs(std))) * (per_pixel if disparity else unit))
    return float(np.clip(np.linalg.norm(sizes), LEAST, MOST)) if sensor.fitted else None


def tilt_std(sensor: Sensor, camera: Camera) -> tuple[float, float]:
    """Standard deviation of what a calibrated correction leaves of tilts over the rays' x and y [m per unit].

    inf where none was fitted: walls at free tilts do not show one. Boards do, as their corners place them.
    """
    if "column_delay" not in sensor.fitted:
        return np.inf, np.inf
    across, down = (float(np.max(sensor.std.get(("column_delay", name), np.inf))) for name in ("slope", "slope_v"))
    return camera.fx * across, camera.fy * down
