"""A calibrated model belongs to one unit: units of one kind differ by centimetres."""

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
