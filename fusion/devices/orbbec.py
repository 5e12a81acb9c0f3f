"""Orbbec cameras as a source, by the maker's library (SDK 2). Nobody has tried this with a camera yet.

It is written from the library's published names alone. Who has a camera: `fusion doctor --try orbbec` tells how far it
gets, and a line about that is welcome.
"""

import time
from collections.abc import Iterator
from dataclasses import replace
from threading import Event
from types import TracebackType
from typing import Any, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.devices.source import Description, SourceFrame
from fusion.errors import DeviceError
from fusion.files.extra import extra
from fusion.geometry.camera import Camera, Principle
from fusion.recording.cameras.lens import made_camera
from fusion.recording.formats.bags.orbbec import PRINCIPLES

UNTRIED = (
    "nobody has tried Orbbec cameras with this program yet: look at unit, size and colours before you rely on them"
)
WAIT_MS = 200
SILENCE = 5.0  # [s] (guess, as for RealSense)


class Orbbec:
    """An Orbbec camera.

    Args:
        camera: intrinsics that replace the device's own.

    Raises:
        DeviceError: the device cannot be opened, or infrared is wanted.
    """

    def __init__(self, device: Any, with_infrared: bool = False, camera: Camera | None = None) -> None:
        self._sdk = _library()
        if with_infrared:
            raise DeviceError("infrared of Orbbec cameras is not read", "orbbec", "--ir", do="leave it out")
        try:
            self._info, self._pipeline = device.get_device_info(), self._sdk.Pipeline(device)
            self._profiles = {"depth": self._default(self._sdk.OBSensorType.DEPTH_SENSOR)}
            self._profiles["color"] = self._default(self._sdk.OBSensorType.COLOR_SENSOR)
        except self._sdk.OBError as error:
            raise self._refused("cannot be opened", error) from error
        self.camera = camera or self._camera()
        self._stopped, self._running = Event(), False
        self._begun, self._last, self._index = np.nan, -1, 0

    def describe(self) -> Description:
        """The camera as the device tells of it."""
        return Description(
            name="orbbec",
            camera=self.camera,
            serial=str(self._info.get_serial_number()),
            firmware=str(self._info.get_firmware_version()),
            rate=float(self._profiles["depth"].get_fps()),
            color=True,
            notes=(UNTRIED,),
        )

    def start(self) -> None:
        """Start both streams. Raises DeviceError."""
        self._stopped.clear()
        config = self._sdk.Config()
        for profile in self._profiles.values():
            config.enable_stream(profile)
        config.set_frame_aggregate_output_mode(self._sdk.OBFrameAggregateOutputMode.ANY_SITUATION)
        try:
            self._pipeline.start(config)
        except self._sdk.OBError as error:
            raise self._refused("does not start", error) from error
        self._running = True

    def frames(self) -> Iterator[SourceFrame]:
        """Each depth frame, with the colours that came with it."""
        last = time.monotonic()
        while not self._stopped.is_set():
            together = self._pipeline.wait_for_frames(WAIT_MS)
            depth = None if together is None else together.get_depth_frame()
            if depth is not None:
                last = time.monotonic()
                yield self._made(depth, together.get_color_frame())
            elif time.monotonic() - last > SILENCE:
                raise self._refused("sends no frames", f"none for {SILENCE:g} s")

    def stop(self) -> None:
        """Stop the streams."""
        self._stopped.set()
        if self._running:
            self._running = False
            self._pipeline.stop()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.stop()

    def _default(self, sensor: Any) -> Any:
        return self._pipeline.get_stream_profile_list(sensor).get_default_video_stream_profile()

    def _made(self, depth: Any, color: Any) -> SourceFrame:
        shape = (depth.get_height(), depth.get_width())
        counts = np.frombuffer(depth.get_data(), np.uint16).reshape(shape)
        # the SDK's scale is millimetres per count
        metres = counts.astype(np.float32) * np.float32(depth.get_depth_scale() / 1000)
        metres[counts == 0] = np.nan
        device, host = depth.get_timestamp_us() / 1e6, depth.get_system_timestamp_us() / 1e6 or time.time()
        if np.isnan(self._begun):
            self._begun = host - device
        number = depth.get_index()
        frame = SourceFrame(
            self._index,
            self._begun + device,
            metres,
            device_time=device,
            host_time=host,
            color_apart=None if color is None else self._rgb(color),
            missed=max(0, number - self._last - 1) if self._index else 0,
        )
        self._index, self._last = self._index + 1, number
        return frame

    def _rgb(self, color: Any) -> NDArray[np.uint8] | None:
        """(h, w, 3) of a colour frame; None in a form that is not known."""
        data, form = np.frombuffer(color.get_data(), np.uint8), color.get_format()
        shape, forms = (color.get_height(), color.get_width()), self._sdk.OBFormat
        if form == forms.MJPG:
            decoded = cv2.imdecode(data, cv2.IMREAD_COLOR)
            return None if decoded is None else np.ascontiguousarray(decoded[..., ::-1])
        if form in (forms.RGB, forms.BGR):
            image = data.reshape(*shape, 3)
            return image.copy() if form == forms.RGB else np.ascontiguousarray(image[..., ::-1])
        if form in (forms.YUYV, forms.UYVY):
            code = cv2.COLOR_YUV2RGB_YUYV if form == forms.YUYV else cv2.COLOR_YUV2RGB_UYVY
            return np.asarray(cv2.cvtColor(data.reshape(*shape, 2), code), np.uint8)
        return None

    def _camera(self) -> Camera:
        depth, color = self._profiles["depth"], self._profiles["color"]
        name, place, T = str(self._info.get_name()), depth.get_extrinsic_to(color), np.eye(4)
        T[:3, :3] = np.asarray(place.rot, float).reshape(3, 3)
        T[:3, 3] = np.asarray(place.transform, float).ravel() / 1000  # the SDK's are millimetres
        return replace(
            _lens(depth),
            # counts of a quarter of a millimetre hold each step of the SDK's scales, up to 16 m
            depth_scale=4000.0,
            principle=next((principle for word, principle in PRINCIPLES.items() if word in name), Principle.UNKNOWN),
            sensor=name,
            serial=str(self._info.get_serial_number()),
            color=_lens(color),
            T_color_depth=T,
        )

    def _refused(self, what: str, found: object) -> DeviceError:
        return DeviceError(f"the Orbbec camera {what}", "orbbec", found, do="unplug it and plug it in again")


def open_orbbec(serial: str = "", with_infrared: bool = False, camera: Camera | None = None) -> Orbbec:
    """The Orbbec camera with this serial number, or the only one. Raises DeviceError."""
    devices = _library().Context().query_devices()
    serials = [str(devices.get_device_serial_number_by_index(i)) for i in range(devices.get_count())]
    wanted = [i for i, number in enumerate(serials) if serial in ("", number)]
    if len(wanted) == 1:
        return Orbbec(devices.get_device_by_index(wanted[0]), with_infrared, camera)
    expected = f"one with the serial number {serial}" if serial else "one; name it: orbbec:SERIAL"
    do = "" if serials else "plug it in; fusion doctor lists what there is"
    raise DeviceError("there is no such Orbbec camera", "USB", ", ".join(serials) or "none", expected, do)


def _library() -> Any:
    return extra("pyorbbecsdk", "orbbec", "an Orbbec camera", "", DeviceError)


def _lens(profile: Any) -> Camera:
    lens, bent = profile.get_intrinsic(), profile.get_distortion()
    d = np.array([getattr(bent, name) for name in ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")], float)
    lengths = (lens.fx, lens.fy, lens.cx, lens.cy)
    return made_camera(lens.width, lens.height, lengths, "rational_polynomial", d, "orbbec")
