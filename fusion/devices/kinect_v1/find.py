"""Which Kinects are plugged in, and which camera, motor and audio device belong together."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from fusion.errors import DeviceError
from fusion.files.extra import extra

VENDOR = 0x045E
CAMERAS = {0x02AE: "Kinect for Xbox 360", 0x02BF: "Kinect for Windows"}
MOTOR, AUDIO = 0x02B0, (0x02AD, 0x02BE, 0x02C3, 0x02BB)
WITH_MOTOR = 0x010B  # release number of a 1414's camera, the only one with a motor device of its own
WINDOWS = 0x02BF
NONE = {"", "0" * 16}  # serial numbers that are none


@dataclass(frozen=True)
class Parts:
    """The devices of one Kinect, as pyusb gives them; None where there is none."""

    # camera, motor, audio: of pyusb
    camera: Any
    motor: Any = None
    audio: Any = None
    serial: str = ""  # of the camera, or where it has none of the audio device; "" where neither tells one
    readable: bool = True  # this user may open the camera

    @property
    def name(self) -> str:
        """`Kinect for Xbox 360 (1414)`."""
        product = CAMERAS[self.camera.idProduct]
        if self.camera.idProduct == WINDOWS:
            return f"{product} (1517)"
        return f"{product} ({'1414' if self.camera.bcdDevice == WITH_MOTOR else '1473'})"


def usb_module() -> Any:
    """pyusb. Raises DeviceError where it is not installed."""
    return extra("usb.core", "kinect", "a Kinect", "", DeviceError)


def kinects(devices: Iterable[Any] | None = None) -> list[Parts]:
    """Every Kinect v1 that is plugged in.

    Raises:
        DeviceError: pyusb or libusb are not installed.
    """
    seen = list(all_devices() if devices is None else devices)
    mine = [device for device in seen if device.idVendor == VENDOR]
    cameras = [device for device in mine if device.idProduct in CAMERAS]
    return [_parts(camera, cameras, mine) for camera in cameras]


def all_devices() -> list[Any]:
    """Every USB device that libusb tells of. Raises DeviceError."""
    usb = usb_module()
    try:
        return list(usb.find(find_all=True))
    except usb.NoBackendError as error:
        do = "install it (Debian, Ubuntu: apt-get install libusb-1.0-0)"
        raise DeviceError("USB needs the library libusb-1.0", found="it is not installed", do=do) from error


def find_kinect(serial: str = "", devices: Iterable[Any] | None = None) -> Parts:
    """The Kinect with this serial number; the only one where none is given. Raises DeviceError."""
    found = kinects(devices)
    wanted = [parts for parts in found if serial in ("", parts.serial)]
    if len(wanted) == 1:
        if not wanted[0].readable:
            do = "fusion doctor --udev prints the rule that allows it, and where to put it"
            raise DeviceError("the Kinect may not be opened by you", f"USB {where(wanted[0].camera)}", do=do)
        return wanted[0]
    if not found:
        do = "plug it in, with its power supply; fusion doctor lists what there is"
        raise DeviceError("no Kinect v1 is plugged in", "USB", "none", "045e:02ae or 045e:02bf", do)
    names = ", ".join(parts.serial or "one without a serial number" for parts in found)
    if not wanted:
        raise DeviceError("no Kinect has this serial number", f"kinect-v1:{serial}", names)
    raise DeviceError("several Kinects are plugged in", "kinect-v1", names, "one of them", "name it: kinect-v1:SERIAL")


def where(device: Any) -> str:
    """`bus 1, address 5`."""
    return f"bus {device.bus}, address {device.address}"


def _parts(camera: Any, cameras: list[Any], devices: list[Any]) -> Parts:
    motor = _beside(camera, cameras, [d for d in devices if d.idProduct == MOTOR])
    audio = _beside(camera, cameras, [d for d in devices if d.idProduct in AUDIO])
    own, readable = _serial(camera)
    if own in NONE and audio is not None:
        own = _serial(audio)[0]
    return Parts(camera, motor, audio, "" if own in NONE else own, readable)


def _beside(camera: Any, cameras: list[Any], candidates: list[Any]) -> Any:
    """The one at the same hub; else the only one on the bus, and then the only one at all, if there is one camera."""
    hub = _hub(camera)
    same = [one for one in candidates if hub is not None and _hub(one) == hub]
    bus = [one for one in candidates if one.bus == camera.bus]
    alone = [one for one in cameras if one.bus == camera.bus] == [camera]
    for found in (same, bus if alone else [], candidates if len(cameras) == 1 else []):
        if len(found) == 1:
            return found[0]
    return None


def _hub(device: Any) -> tuple[int, tuple[int, ...]] | None:
    """Bus and ports down to the hub that a device hangs at; None where the system does not tell."""
    ports = device.port_numbers
    return (device.bus, tuple(ports[:-1])) if ports else None


def _serial(device: Any) -> tuple[str, bool]:
    """The serial number that a device tells, and whether it may be asked at all."""
    core = usb_module()
    if not device.iSerialNumber:
        return "", True
    try:
        return str(device.serial_number or ""), True
    except (core.USBError, ValueError) as error:  # pyusb: "The device has no langid (permission issue, ...)"
        return "", not (isinstance(error, ValueError) or getattr(error, "errno", 0) == 13)
