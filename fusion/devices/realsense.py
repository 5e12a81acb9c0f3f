"""Intel RealSense as a source, by the maker's library: any `rs.device`, also one that is made up or played back."""

import time
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
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
from fusion.recording.formats.bags.realsense import PRINCIPLES

RATE = 30
WIDTHS = (848, 640, 1280, 480)  # of depth, the best first: Intel's advice for the D400s is 848 x 480
ROOM = 60  # frames of either kind that wait: a second of both
WAIT_MS = 200
SILENCE = 5.0  # [s] without a frame before the camera is given up: streams start within two (guess)
KEPT = 3  # colour images among which the nearest is taken


class RealSense:
    """A RealSense.

    Args:
        with_infrared: the left infrared picture too, which is in the depth's pixels.
        camera: intrinsics that replace the device's own.

    Raises:
        DeviceError: the device has no depth stream.
    """

    def __init__(self, device: Any, with_infrared: bool = False, camera: Camera | None = None) -> None:
        self._rs = extra("pyrealsense2", "realsense", "a RealSense", "", DeviceError)
        self._device, self._sensors = device, device.query_sensors()
        self._stopped, self._queue = Event(), self._rs.frame_queue(ROOM, True)
        self._open: list[Any] = []
        self._profiles = self._chosen(with_infrared)
        if "depth" not in self._profiles:
            raise DeviceError("the camera has no depth stream", self._info("name") or "RealSense")
        self._unit = self._depth_unit()
        own = self._camera()
        # counts are the device's: only lengths and lens may be said otherwise
        self.camera = own if camera is None else replace(camera, depth_scale=own.depth_scale)
        self._colors: deque[tuple[float, NDArray[np.uint8]]] = deque(maxlen=KEPT)
        self._infrared: dict[int, NDArray[np.uint16]] = {}
        self._begun, self._last = np.nan, -1
        self._index = 0

    def describe(self) -> Description:
        """The camera as the device tells of it."""
        return Description(
            name="realsense",
            camera=self.camera,
            serial=self._info("serial_number"),
            firmware=self._info("firmware_version"),
            rate=float(self._profiles["depth"][1].fps()),
            color="color" in self._profiles,
            ir="ir" in self._profiles,
            settings=self._settings(),
        )

    def start(self) -> None:
        """Open each sensor with its streams. Raises DeviceError."""
        self._stopped.clear()
        by_sensor: dict[int, list[Any]] = {}
        for number, profile in self._profiles.values():
            by_sensor.setdefault(number, []).append(profile)
        try:
            for number, profiles in by_sensor.items():
                sensor = self._sensors[number]
                sensor.open(profiles)
                self._open.append(sensor)
                sensor.start(self._queue)
        except RuntimeError as error:
            self.stop()
            do = "close other programs that use it, and plug it in again"
            raise DeviceError("the RealSense does not start", self._info("name"), error, do=do) from error

    def frames(self) -> Iterator[SourceFrame]:
        """Each depth frame, once the colour image that belongs to it is there, or the next depth frame is."""
        waiting, last = None, time.monotonic()
        while not self._stopped.is_set():
            there, frame = self._queue.try_wait_for_frame(WAIT_MS)
            if not there:
                if waiting is not None:
                    yield self._made(waiting)
                    waiting = None
                if self._ended(time.monotonic() - last):
                    return
                continue
            last = time.monotonic()
            kind = frame.get_profile().stream_type()
            if kind == self._rs.stream.depth:
                if waiting is not None:
                    yield self._made(waiting)
                waiting = frame
                continue
            if kind == self._rs.stream.infrared:
                self._keep_infrared(frame)
            else:
                self._colors.append((frame.get_timestamp(), _rgb(frame, self._rs)))
            if waiting is not None and self._complete(waiting):
                yield self._made(waiting)
                waiting = None

    def stop(self) -> None:
        """Close what was opened."""
        self._stopped.set()
        while self._open:
            sensor = self._open.pop()
            try:
                sensor.stop()
                sensor.close()
            except RuntimeError:  # the device is gone, or never started
                continue

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.stop()

    def _ended(self, silent: float) -> bool:
        """True at the end of what is played back. Raises DeviceError where a device is gone or silent."""
        if self._device.is_playback():
            return self._device.as_playback().current_status() == self._rs.playback_status.stopped
        if not self._device.is_connected():
            raise DeviceError("the camera was unplugged", self._info("name"), do="plug it in again")
        if silent > SILENCE:
            do = "unplug it and plug it in again, into a USB 3 port"
            raise DeviceError("the camera sends no frames", self._info("name"), f"none for {SILENCE:g} s", do=do)
        return False

    def _complete(self, depth: Any) -> bool:
        """True once every picture that belongs to a depth frame can be known."""
        color = "color" not in self._profiles or any(stamp >= depth.get_timestamp() for stamp, _ in self._colors)
        return color and ("ir" not in self._profiles or depth.get_frame_number() in self._infrared)

    def _made(self, depth: Any) -> SourceFrame:
        counts = np.asanyarray(depth.get_data()).copy()
        stamp, number = depth.get_timestamp(), depth.get_frame_number()
        metres = counts.astype(np.float32) * np.float32(self._unit)
        metres[counts == 0] = np.nan
        host = self._told(depth, "time_of_arrival", 1e-3)
        host = time.time() if np.isnan(host) else host
        if np.isnan(self._begun):
            self._begun = host - stamp / 1000
        near = [one for one in self._colors if abs(one[0] - stamp) < 1500 / RATE]
        color = min(near, key=lambda one: abs(one[0] - stamp))[1] if near else None
        frame = SourceFrame(
            self._index,
            self._begun + stamp / 1000,
            metres,
            ir=self._infrared.pop(number, None),
            device_time=stamp / 1000,
            host_time=host,
            color_apart=color,
            log={"shutter_s": self._told(depth, "actual_exposure", 1e-6)},
            missed=max(0, number - self._last - 1) if self._index else 0,
        )
        self._index, self._last = self._index + 1, number
        return frame

    def _keep_infrared(self, frame: Any) -> None:
        self._infrared[frame.get_frame_number()] = np.asanyarray(frame.get_data()).astype(np.uint16)
        for number in sorted(self._infrared)[:-KEPT]:
            del self._infrared[number]

    def _told(self, frame: Any, name: str, unit: float) -> float:
        """A number that came with a frame, NaN where none did."""
        value = getattr(self._rs.frame_metadata_value, name)
        return frame.get_frame_metadata(value) * unit if frame.supports_frame_metadata(value) else np.nan

    def _info(self, name: str) -> str:
        what = getattr(self._rs.camera_info, name)
        return str(self._device.get_info(what)) if self._device.supports(what) else ""

    def _depth_unit(self) -> float:
        """Metres per count."""
        sensor, option = self._sensors[self._profiles["depth"][0]], self._rs.option.depth_units
        if sensor.supports(option):
            return float(sensor.get_option(option))
        return float(sensor.as_depth_sensor().get_depth_scale()) if sensor.is_depth_sensor() else 0.001

    def _chosen(self, with_infrared: bool) -> dict[str, tuple[int, Any]]:
        """By kind, the number of its sensor and the profile that is opened."""
        rs = self._rs
        forms = {
            "depth": (rs.stream.depth, (rs.format.z16,)),
            "color": (rs.stream.color, (rs.format.rgb8, rs.format.bgr8, rs.format.yuyv)),
            "ir": (rs.stream.infrared, (rs.format.y8, rs.format.y16)),
        }
        chosen: dict[str, tuple[int, Any]] = {}
        for kind, (stream, formats) in forms.items():
            if kind == "ir" and not with_infrared:
                continue
            size = None if kind == "color" or "depth" not in chosen else _size(chosen["depth"][1])
            found = [
                (number, profile.as_video_stream_profile())
                for number, sensor in enumerate(self._sensors)
                for profile in sensor.get_stream_profiles()
                if profile.stream_type() == stream and profile.format() in formats
            ]
            fitting = [one for one in found if size in (None, _size(one[1]))]
            if fitting:
                chosen[kind] = min(fitting, key=lambda one: _rank(one[1], formats, kind))
        return chosen

    def _settings(self) -> dict[str, str]:
        """The options of the depth sensor by name."""
        sensor = self._sensors[self._profiles["depth"][0]]
        found = {}
        for option in sensor.get_supported_options():
            with suppress(RuntimeError):  # some can only be set
                found[str(option).rpartition(".")[2].replace("_", " ")] = f"{sensor.get_option(option):.6g}"
        return found

    def _camera(self) -> Camera:
        depth, name = self._profiles["depth"][1], self._info("name")
        principle = next((p for model, p in PRINCIPLES.items() if model in name), Principle.ACTIVE_STEREO)
        camera = replace(
            _lens(depth),
            # stored in single precision, which holds seven digits
            depth_scale=float(f"{1 / self._unit:.6g}"),
            principle=principle,
            sensor=name.replace("Intel ", ""),
            serial=self._info("serial_number"),
        )
        if "color" not in self._profiles:
            return camera
        place = depth.get_extrinsics_to(self._profiles["color"][1])
        T = np.eye(4)
        T[:3, :3] = np.array(place.rotation).reshape(3, 3, order="F")
        T[:3, 3] = place.translation
        return replace(camera, color=_lens(self._profiles["color"][1]), T_color_depth=T)


def open_realsense(serial: str = "", with_infrared: bool = False, camera: Camera | None = None) -> RealSense:
    """The RealSense with this serial number, or the only one. Raises DeviceError."""
    rs = extra("pyrealsense2", "realsense", "a RealSense", "", DeviceError)
    devices = list(rs.context().query_devices())
    serials = [one.get_info(rs.camera_info.serial_number) for one in devices]
    wanted = [one for one, number in zip(devices, serials, strict=True) if serial in ("", number)]
    if len(wanted) == 1:
        return RealSense(wanted[0], with_infrared, camera)
    expected = f"one with the serial number {serial}" if serial else "one; name it: realsense:SERIAL"
    do = "" if devices else "plug it in; fusion doctor lists what there is"
    raise DeviceError("there is no such RealSense", "USB", ", ".join(serials) or "none", expected, do)


def _size(profile: Any) -> tuple[int, int]:
    return profile.width(), profile.height()


def _rank(profile: Any, formats: tuple, kind: str) -> tuple:
    """The lower the better: the rate, the size, the format, the first of two infrared cameras."""
    width = profile.width()
    good = WIDTHS.index(width) if kind == "depth" and width in WIDTHS else len(WIDTHS)
    return abs(profile.fps() - RATE), good, abs(width - 640), formats.index(profile.format()), profile.stream_index()


def _lens(profile: Any) -> Camera:
    lens = profile.get_intrinsics()
    model = str(lens.model).rpartition(".")[2]
    lengths = (lens.fx, lens.fy, lens.ppx, lens.ppy)
    return made_camera(lens.width, lens.height, lengths, model, np.array(lens.coeffs), "RealSense")


def _rgb(frame: Any, rs: Any) -> NDArray[np.uint8]:
    """(h, w, 3) of a colour frame."""
    data, form = np.asanyarray(frame.get_data()), frame.get_profile().format()
    if form == rs.format.yuyv:
        pairs = np.ascontiguousarray(data).view(np.uint8).reshape(*data.shape[:2], 2)
        return np.asarray(cv2.cvtColor(pairs, cv2.COLOR_YUV2RGB_YUYV), np.uint8)
    return np.ascontiguousarray(data[..., ::-1]) if form == rs.format.bgr8 else data.copy()
