"""What is plugged in and what is installed; whether a camera gives what it should."""

import importlib.metadata
import itertools
import os
import platform
import re
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fusion import __version__
from fusion.devices.kinect_v1.find import AUDIO, CAMERAS, MOTOR, VENDOR, all_devices
from fusion.devices.source import Source
from fusion.errors import DeviceError
from fusion.files.extra import DISTRIBUTION, version_of
from fusion.progress import stage

RULES = Path(__file__).with_name("60-fusion-cameras.rules")
INTEL, ORBBEC = 0x8086, 0x2BC5
# vendor, product (None: any): what it is, and the slowest bus [Mbit/s] that carries its images
KNOWN: dict[tuple[int, int | None], tuple[str, float]] = {
    **{(VENDOR, product): (f"{name}: camera", 480.0) for product, name in CAMERAS.items()},
    (VENDOR, MOTOR): ("Kinect v1: motor", 0.0),
    **{(VENDOR, product): ("Kinect v1: microphones", 0.0) for product in AUDIO},
    **{(VENDOR, product): ("Kinect v2: cannot be read yet", 5000.0) for product in (0x02D8, 0x02C4, 0x02D9)},
    (VENDOR, 0x097C): ("Azure Kinect: record with its own program, and open the .mkv", 5000.0),
    (INTEL, None): ("Intel RealSense", 0.0),
    (ORBBEC, None): ("Orbbec", 0.0),
}
REALSENSE = range(0x0A00, 0x0C00)  # Intel makes other things too: mice, hubs, radios
SPEEDS = {1: 1.5, 2: 12.0, 3: 480.0, 4: 5000.0, 5: 10_000.0}  # of pyusb, in Mbit/s


@dataclass(frozen=True)
class Plugged:
    """A depth camera, or a part of one, on USB."""

    name: str  # what it is; place: where it is; speed: of its bus [Mbit/s], 0 where the system does not tell
    vendor: int
    product: int
    place: str
    speed: float
    may_open: bool | None  # by this user; None where that cannot be told
    wrong: tuple[str, ...] = ()  # what stands in its way, one sentence each


@dataclass(frozen=True)
class DeviceFindings:
    """What `fusion doctor` tells."""

    versions: dict[str, str]  # of this program, Python and the system
    extras: dict[str, tuple[dict[str, str], bool]]  # name: (its packages with their versions or "", all are there)
    usb: str  # "" or why nothing can be said of USB
    devices: int  # how many there are on USB
    plugged: list[Plugged] = field(default_factory=list)  # those that are depth cameras


@dataclass(frozen=True)
class Tested:
    """What a source gave while it was looked at."""

    # source, serial, seconds, frames, missed, rate: rate in frames a second
    source: str
    serial: str
    seconds: float
    frames: int
    missed: int
    rate: float
    device_rate: float  # seconds of the device's clock in a second of this machine's, 1 where they agree
    latest: float  # longest wait [s] between two frames
    packets: dict[str, dict[str, int]]  # by stream what happened to its packets, where the source counts them
    notes: tuple[str, ...]  # of the source


def look(devices: Iterable[Any] | None = None) -> DeviceFindings:
    """Look at what there is; `devices` of pyusb, None: all there are."""
    versions = {"fusion": __version__, "python": platform.python_version(), "system": platform.platform()}
    usb = ""
    try:
        seen = list(all_devices() if devices is None else devices)
    except DeviceError as error:
        seen, usb = [], str(error)
    known = [one for one in seen if _known(one) is not None]
    products = {device.idProduct for device in known if device.idVendor == VENDOR}
    plugged = [_plugged(device, products) for device in known]
    return DeviceFindings(versions, installed_extras(), usb, len(seen), plugged)


def installed_extras() -> dict[str, tuple[dict[str, str], bool]]:
    """Of each extra of the package its packages with their versions, "" for one that is not there."""
    try:
        needed = importlib.metadata.requires(DISTRIBUTION) or []
    except importlib.metadata.PackageNotFoundError:  # run from a folder that was never installed
        return {}
    found: dict[str, dict[str, str]] = {}
    for line in needed:
        name, extra = re.match(r"[\w.-]+", line), re.search(r"""extra == ["']([\w-]+)["']""", line)
        if name and extra and name[0] != DISTRIBUTION and extra[1] not in ("dev", "fuzz", "all"):
            found.setdefault(extra[1], {})[name[0]] = version_of(name[0])
    return {extra: (packages, all(packages.values())) for extra, packages in sorted(found.items())}


def looked_at(source: Source, seconds: float) -> Tested:
    """Take the frames of a started source for a while. Raises DeviceError, as the source does."""
    about, missed = source.describe(), 0
    stamps: list[float] = []
    device: list[float] = []
    begin = time.monotonic()
    with stage(f"looking at {about.name}", round(seconds)) as step:
        for frame in source.frames():
            now = time.monotonic() - begin
            for _ in range(int(now) - int(stamps[-1] if stamps else 0)):
                step()
            missed += frame.missed
            stamps.append(now)
            device.append(frame.device_time)
            if now >= seconds:
                break
    gaps = [b - a for a, b in itertools.pairwise(stamps)]
    span = stamps[-1] - stamps[0] if stamps else 0.0
    counts = getattr(source, "counts", dict)
    return Tested(
        source=about.name,
        serial=about.serial,
        seconds=stamps[-1] if stamps else 0.0,
        frames=len(stamps),
        missed=missed,
        rate=len(gaps) / span if span > 0 else 0.0,
        device_rate=(device[-1] - device[0]) / span if span > 0 else 0.0,
        latest=max(gaps, default=0.0),
        packets=counts(),
        notes=about.notes,
    )


def _known(device: Any) -> tuple[str, float] | None:
    if device.idVendor == INTEL and device.idProduct not in REALSENSE:
        return None
    return KNOWN.get((device.idVendor, device.idProduct)) or KNOWN.get((device.idVendor, None))


def _plugged(device: Any, products: set[int]) -> Plugged:
    name, slowest = _known(device) or ("", 0.0)
    speed = SPEEDS.get(getattr(device, "speed", None) or 0, 0.0)
    node = Path(f"/dev/bus/usb/{device.bus:03d}/{device.address:03d}")
    may_open = os.access(node, os.R_OK | os.W_OK) if node.exists() else None
    wrong = []
    if may_open is False:
        wrong.append("you may not open it: fusion doctor --udev prints the rule that allows it, and where to put it")
    if 0 < speed < slowest:
        port = "USB 3" if slowest > 480 else "USB 2"
        wrong.append(
            f"its bus carries {speed:g} Mbit/s: plug it into a {port} port, without an old hub or cable between"
        )
    if device.idVendor == VENDOR and device.idProduct in (MOTOR, *AUDIO) and not products & set(CAMERAS):
        wrong.append("its camera is not there: plug in the Kinect's own power supply")
    if device.idVendor == VENDOR and device.idProduct in CAMERAS and Path("/sys/module/gspca_kinect").exists():
        wrong.append("the kernel's driver gspca_kinect may hold it; it is set aside when the camera is opened")
    place = f"bus {device.bus}, address {device.address}"
    return Plugged(name, device.idVendor, device.idProduct, place, speed, may_open, tuple(wrong))
