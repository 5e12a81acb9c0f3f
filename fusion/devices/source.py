"""A source of frames: a camera, or a recording played back. Whatever takes one cannot tell which of them it is."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.recording.recording import Frame


@dataclass(frozen=True)
class Description:
    """What a source is.

    Attributes:
        name: "kinect-v1", "realsense", "orbbec" or "replay".
        serial, firmware: as the device tells them, "" where it tells none.
        camera: of the depth frames; `camera.color` where colour is in pixels of its own, `depth_scale` the unit of
            what is recorded.
        rate: frames a second that are to be expected, 0 where nobody knows.
        length: number of frames of a source that ends by itself, or None.
        stepped: a frame comes of each place of a table, which goes on when the frame is taken.
        color, ir: frames hold such images, now and then at least.
        raw: what `SourceFrame.raw` holds, in a word or two; "" where there is none.
        tables: what the device tells of its own calibration, as plain JSON values; recorded as it is.
        settings: how the device is set, words by name.
        notes: what a person should know, one sentence each.
    """

    name: str
    camera: Camera
    serial: str = ""
    firmware: str = ""
    rate: float = 0.0
    length: int | None = None
    stepped: bool = False
    color: bool = False
    ir: bool = False
    raw: str = ""
    tables: Mapping[str, Any] = field(default_factory=dict)
    settings: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        told = [f"{self.camera.width} x {self.camera.height}"] + [f"{self.rate:.4g} a second"] * (self.rate > 0)
        told += ["color"] * self.color + ["ir"] * self.ir + [self.raw] * bool(self.raw)
        return f"<Description: {self.name} {self.serial or 'without a serial number'}, {', '.join(told)}>"


@dataclass(frozen=True, repr=False)
class SourceFrame(Frame):
    """A frame as a source hands it over; `timestamp` is that of the recording that would be made of it.

    Attributes:
        device_time: [s] of the device's own clock, from any moment on, without jumps; NaN where it has none.
        host_time: [s] since 1970, when this machine had the frame.
        raw: (height, width) uint16 as the device sent it, before any depth was made of it, or None.
        color_apart: (h, w, 3) uint8 RGB in the pixels of `camera.color`, or None.
        log: what the device told beside the images, by the names of `telemetry.csv`.
        missed: frames lost between the one before and this: on the wire, or because nobody took them in time.
    """

    device_time: float = np.nan
    host_time: float = np.nan
    raw: NDArray[np.uint16] | None = None
    color_apart: NDArray[np.uint8] | None = None
    log: Mapping[str, float] = field(default_factory=dict)
    missed: int = 0


class Source(Protocol):
    """Where frames come from. It is opened when it is made, and told what is wrong with it then."""

    def describe(self) -> Description:
        """What it is; may be asked at any time."""

    def start(self) -> None:
        """Let frames come; those before are not kept. Raises DeviceError."""

    def frames(self) -> Iterator[SourceFrame]:
        """The frames, in their order, each once, waiting for the next one; ends after `stop` or the last frame.

        Raises:
            DeviceError: the device is gone, or is silent. RecordingError: nothing of a recording can be read.
        """

    def stop(self) -> None:
        """Let no more frames come; may be called from another thread, and more than once."""

    def __enter__(self) -> Self:
        """Started."""

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Stopped, and the device let go."""
