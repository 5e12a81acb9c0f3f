"""What pyusb raises, told in a sentence."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager

from fusion.devices.kinect_v1.find import usb_module
from fusion.errors import DeviceError

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


@contextmanager
def told_usb() -> Iterator[None]:
    """Errors of pyusb in the block become DeviceErrors."""
    try:
        yield
    except usb_module().USBError as error:
        what, do = SENTENCES.get(error.errno or 0, ("USB failed", "unplug it and plug it in again"))
        raise DeviceError(what, "Kinect v1", error.strerror or str(error), do=do) from error
