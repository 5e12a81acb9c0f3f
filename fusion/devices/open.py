"""Opening a source by its name."""

import importlib
import os
from pathlib import Path

from fusion.devices.replay import Replay
from fusion.devices.source import Source
from fusion.errors import DeviceError
from fusion.geometry.camera import Camera
from fusion.quantity import REPLAY_SPEED
from fusion.recording.cameras.presets import find_camera
from fusion.recording.open import open_recording

KINDS = ("kinect-v1", "realsense", "orbbec", "replay:REC")
# each takes a serial number ("": any), whether infrared is wanted, and a camera instead of its own
CAMERAS = {
    "kinect-v1": "fusion.devices.kinect_v1.kinect:Kinect",
    "orbbec": "fusion.devices.orbbec:open_orbbec",
    "realsense": "fusion.devices.realsense:open_realsense",
}


def open_source(name: str, camera: Camera | Path | str | None = None, infrared: bool = False) -> Source:
    """A source by its name; the device is looked for, and opened, now.

    Args:
        name: `kinect-v1` is the only Kinect, `kinect-v1:SERIAL` one of several; so `realsense`, `orbbec`. `replay:REC`
            plays a recording of any format at its own rate, `replay:REC@4` four times faster, `replay:REC@max` as fast
            as it is taken.
        camera: intrinsics that replace the source's own, as `open_recording` takes them.
        infrared: infrared pictures instead of colours, of a camera that sends one at a time.

    Raises:
        DeviceError: there is no such source, or the device cannot be opened.
        RecordingError: REC cannot be.

    >>> with fusion.open_source("replay:my_scan@max") as source:
    ...     print(source.describe())
    ...     sum(1 for frame in source.frames())
    <Description: replay without a serial number, 160 x 120, 2 a second, color, ir>
    26
    """
    kind, _, rest = name.partition(":")
    if kind == "replay" and rest:
        path, speed = _speed(rest)
        return Replay(open_recording(path, camera), speed)
    if kind in CAMERAS:
        module, cls = CAMERAS[kind].split(":")
        return getattr(importlib.import_module(module), cls)(
            rest, infrared, None if camera is None else find_camera(camera)
        )
    do = f"to play a recording back: replay:{name}" if os.path.exists(name) else ""  # noqa: PTH110
    raise DeviceError("there is no such source", found=name, expected=" or ".join(KINDS), do=do)


def replayed(name: str) -> Path | None:
    """The recording that a source of this name plays back, or None."""
    kind, _, rest = name.partition(":")
    return Path(_speed(rest)[0]) if kind == "replay" and rest else None


def _speed(text: str) -> tuple[str, float | None]:
    """The recording's path, and how many times faster it is played; a name that exists is taken as it is."""
    path, at, speed = text.rpartition("@")
    if not at or os.path.exists(text):  # noqa: PTH110 - names that no file can have are no error here
        return text, 1.0
    if speed == "max":
        return path, None
    try:
        return path, REPLAY_SPEED.check(float(speed)) or 1.0
    except ValueError:
        return text, 1.0
