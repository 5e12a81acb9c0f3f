"""A Kinect v1 as a source: depth from the device's own calibration, raw values, colours or infrared."""

import errno
import queue
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from threading import Event
from types import TracebackType
from typing import Self

import numpy as np

from fusion.devices.kinect_v1.commands import Commands
from fusion.devices.kinect_v1.find import find_kinect, usb_module
from fusion.devices.kinect_v1.motor import Motor
from fusion.devices.kinect_v1.pixels import color, infrared, raw_depth
from fusion.devices.kinect_v1.registration import color_camera
from fusion.devices.kinect_v1.streaming import RATE, Arrived, DeviceClock, Streaming
from fusion.devices.kinect_v1.tables import read_tables, read_zero_plane
from fusion.devices.source import Description, SourceFrame
from fusion.errors import DeviceError
from fusion.files.json_values import json_values
from fusion.geometry.camera import Camera
from fusion.progress import note

LOOK = 0.1  # [s] between two looks for trouble while no frame comes
SILENCE = 2.0  # [s] without a frame after which the streams are started anew: a start takes up to one (guess)
RETURN = 15.0  # [s] for a camera that was unplugged to come back (guess: a person's hands)
CENTRE = "the depth camera's centre is nominal, its focal length follows from the device's reference plane"
STARTS = 3  # in a row that bring no frame, before it is given up
SENTENCES = {
    errno.ENODEV: ("the camera was unplugged", "plug it in again"),
    errno.ENOENT: ("the camera was unplugged", "plug it in again"),
    errno.EACCES: (
        "the Kinect may not be opened by you",
        "fusion doctor --udev prints the rule that allows it, and where to put it",
    ),
    errno.EBUSY: ("the Kinect is in use by another program", "close that program"),
    errno.ETIMEDOUT: ("the camera does not answer", "unplug it and plug it in again"),
    errno.EPIPE: ("the camera refused a command", "unplug it and plug it in again"),
}


class Kinect:
    """A Kinect v1.

    Args:
        serial: which one; "" takes the only one.
        with_infrared: infrared pictures instead of colours, which the camera sends one at a time.
        camera: intrinsics that replace the device's nominal ones.

    A stream that stalls is started anew, and a camera that was unplugged is waited for; how many frames that cost
    stands in the next frame's `missed`.

    Raises:
        DeviceError: there is none, or it cannot be opened.
    """

    def __init__(self, serial: str = "", with_infrared: bool = False, camera: Camera | None = None) -> None:
        self._infrared, self._serial = with_infrared, serial
        self._stopped = Event()
        self._streaming: Streaming | None = None
        self._open()
        self._serial = serial or self.parts.serial
        with told_usb():
            plane = read_zero_plane(self._commands)
            self.tables = read_tables(self._commands, plane)
        self._metres = plane.metres()
        own, about = color_camera(plane.camera(self.parts.serial), plane, self.tables.registration, self.tables.padding)
        self.camera = camera or own
        self._notes = () if camera is not None else (CENTRE, about)
        self._clock, self._begun, self._index = DeviceClock(), np.nan, 0

    @property
    def motor(self) -> Motor:
        """Tilt, LED, accelerometer. Raises DeviceError where they do not answer."""
        return Motor(self.parts)

    def describe(self) -> Description:
        """The camera, and the tables that it told."""
        return Description(
            name="kinect-v1",
            camera=self.camera,
            serial=self.parts.serial,
            firmware=f"{self.parts.camera.bcdDevice:#06x}",
            rate=RATE,
            color=not self._infrared,
            ir=self._infrared,
            raw="disparity of 11 bits, 2047: none",
            tables=json_values(self.tables),
            notes=self._notes,
        )

    def counts(self) -> dict[str, dict[str, int]]:
        """What happened to the packets of each stream since it was last started."""
        if self._streaming is None:
            return {}
        return {one.format.name: asdict(one.counts) for one in (self._streaming.depth, self._streaming.video)}

    def start(self) -> None:
        """Let frames come."""
        self._stopped.clear()
        if self._streaming is None:
            with told_usb():
                self._streaming = Streaming(self.parts, self._infrared)

    def frames(self) -> Iterator[SourceFrame]:
        """Each frame as it comes."""
        last, starts = time.monotonic(), 0
        while not self._stopped.is_set():
            try:
                arrived = self._taken()
            except queue.Empty:
                trouble = "" if self._streaming is None else self._streaming.trouble
                if not trouble and time.monotonic() - last < SILENCE:
                    continue
                starts += 1
                if starts > STARTS:
                    do = "unplug it, also from its power supply, and plug it in again"
                    raise DeviceError("the camera sends no frames", self._where(), trouble, do=do) from None
                self._again(trouble or "the camera sends no frames")
                last = time.monotonic()
                continue
            last, starts = time.monotonic(), 0
            yield self._frame(arrived)

    def stop(self) -> None:
        """No more frames; the camera is let go."""
        self._stopped.set()
        streaming, self._streaming = self._streaming, None
        if streaming is not None:
            streaming.close()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.stop()

    def _taken(self) -> Arrived:
        streaming = self._streaming
        if streaming is None:
            raise queue.Empty
        return streaming.arrived.get(timeout=LOOK)

    def _open(self) -> None:
        self.parts = find_kinect(self._serial)
        self._commands = Commands(self.parts.camera)

    def _where(self) -> str:
        return f"Kinect v1 {self.parts.serial}".strip()

    def _again(self, trouble: str) -> None:
        """Open the camera and start its streams as soon as it is there. Raises DeviceError where it stays away."""
        begin = time.monotonic()
        if self._streaming is not None:
            self._streaming.close()
        while not self._stopped.is_set():
            try:
                self._open()
                with told_usb():
                    self._streaming = Streaming(self.parts, self._infrared)
                break
            except DeviceError as error:
                self._streaming = None
                if time.monotonic() - begin > RETURN:
                    do = f"plug it in again; it was waited for {RETURN:g} s"
                    raise DeviceError(trouble, self._where(), str(error), do=do) from error
                self._stopped.wait(2 * LOOK)
        if self._stopped.is_set():  # meanwhile, by another thread
            self.stop()
            return
        self._clock.restart()
        note(f"{trouble}; started anew after {time.monotonic() - begin:.1f} s")

    def _frame(self, arrived: Arrived) -> SourceFrame:
        device, missed = self._clock.at(arrived.depth.ticks, arrived.host)
        if not np.isfinite(self._begun):
            self._begun = arrived.host - device
        raw, picture = raw_depth(arrived.depth), arrived.picture
        frame = SourceFrame(
            self._index,
            self._begun + device,
            self._metres[raw],
            device_time=device,
            host_time=arrived.host,
            raw=raw,
            log={"lost_bytes": float(sum(end - begin for begin, end in arrived.depth.holes))},
            missed=missed,
        )
        self._index += 1
        if picture is None:
            return frame
        return replace(frame, ir=infrared(picture)) if self._infrared else replace(frame, color_apart=color(picture))


@contextmanager
def told_usb() -> Iterator[None]:
    """Errors of pyusb in the block become DeviceErrors."""
    try:
        yield
    except usb_module().USBError as error:
        what, do = SENTENCES.get(error.errno or 0, ("USB failed", "unplug it and plug it in again"))
        raise DeviceError(what, "Kinect v1", error.strerror or str(error), do=do) from error
