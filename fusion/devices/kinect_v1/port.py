"""The camera's isochronous streams: many transfers under way at once, kept going by a thread of their own.

pyusb reads one transfer after the other: the packets between two are lost, and with six lost packets a frame. So the
streams go by libusb1, and commands while they run by the same handle: who reaps what is complete is then always one and
the same, and packets keep their order.
"""

import threading
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any

from fusion.errors import DeviceError
from fusion.files.extra import extra

VIDEO, DEPTH = 0x81, 0x82  # endpoints
# 96 ms under way on each stream: a busy machine lets a program wait that long; libfreenect has a third of it, and notes
# that Linux takes 1000 packets
TRANSFERS, PACKETS, PACKET_BYTES = 48, 16, 1920
AT_A_TIME = 0.1  # [s] that the thread waits for events before it looks whether it is to end
MOST_ERRORS = 200  # transfers in a row that fail before the stream is given up: some 0.4 s
ENDING = 2.0  # [s] for transfers to be cancelled (guess)
_STUCK: list["Port"] = []  # kept, so that nobody tries to tidy them up
Feed = Callable[[Iterable[tuple[int, Any]]], None]


class Port:
    """The open camera; `trouble` is a sentence once no packets come any more.

    Args:
        alternate: setting of interface 0 that has the endpoints.

    Raises:
        DeviceError: it cannot be opened, or another program has it.
    """

    def __init__(self, bus: int, address: int, alternate: int = 0) -> None:
        self.trouble, self._errors, self._closing = "", 0, False
        self._usb = extra("usb1", "kinect", "a Kinect", "", DeviceError)
        self._context = self._usb.USBContext()
        self._transfers: list[Any] = []
        try:
            self._handle = self._opened(bus, address)
            with suppress(self._usb.USBError):  # where there is no driver of the kernel
                self._handle.setAutoDetachKernelDriver(True)
            self._handle.claimInterface(0)
            if alternate:
                self._handle.setInterfaceAltSetting(0, alternate)
        except self._usb.USBError as error:
            self._context.close()
            raise self._told(error, f"bus {bus}, address {address}") from error
        except DeviceError:
            self._context.close()
            raise
        self._thread = threading.Thread(target=self._run, name="fusion-kinect", daemon=True)
        self._thread.start()

    def listen(self, endpoint: int, feed: Feed) -> None:
        """Let the packets of an endpoint, each with its status, go to `feed`, which runs in the port's thread."""

        def arrived(transfer: Any) -> None:
            self._arrived(transfer, feed)

        with suppress(self._usb.USBError):  # what a camera that stopped in the middle left behind
            self._handle.clearHalt(endpoint)
        for _ in range(TRANSFERS):
            transfer = self._handle.getTransfer(iso_packets=PACKETS)
            transfer.setIsochronous(endpoint, PACKETS * PACKET_BYTES, callback=arrived)
            self._transfers.append(transfer)
            try:
                transfer.submit()
            except self._usb.USBError as error:
                raise self._told(error, f"endpoint {endpoint:#x}") from error

    def ctrl_transfer(
        self, kind: int, request: int, value: int = 0, index: int = 0, data: Any = None, timeout: int | None = None
    ) -> Any:
        """A control transfer, in pyusb's form: bytes in, or how many went out. Raises DeviceError."""
        try:
            if kind & 0x80:
                return bytes(self._handle.controlRead(kind, request, value, index, data, timeout or 1000))
            return self._handle.controlWrite(kind, request, value, index, data or b"", timeout or 1000)
        except self._usb.USBError as error:
            raise self._told(error, f"endpoint 0, request {request:#x}") from error

    def close(self) -> None:
        """Cancel what is under way, wait for it, and let the device go; may be called more than once.

        Where the system does not answer, as it may when a device goes away in the middle of a call, it is left to
        itself after a while: libusb has no limit of its own.
        """
        if self._closing:
            return
        self._closing = True
        ending = threading.Thread(target=self._end, name="fusion-kinect-end", daemon=True)
        ending.start()
        ending.join(2 * ENDING)
        if ending.is_alive():
            _STUCK.append(self)

    def _end(self) -> None:
        self._thread.join()
        with suppress(self._usb.USBError):  # a device that is gone
            self._handle.releaseInterface(0)
        with suppress(self._usb.USBError):
            self._handle.close()
        self._context.close()

    def _opened(self, bus: int, address: int) -> Any:
        for device in self._context.getDeviceIterator(skip_on_error=True):
            if (device.getBusNumber(), device.getDeviceAddress()) == (bus, address):
                return device.open()
        raise DeviceError("the camera is gone", f"bus {bus}, address {address}", do="plug it in again")

    def _arrived(self, transfer: Any, feed: Feed) -> None:
        usb, status = self._usb, transfer.getStatus()
        if status == usb.TRANSFER_COMPLETED:
            self._errors = 0
            feed(transfer.iterISO())
        elif status == usb.TRANSFER_NO_DEVICE:
            self.trouble = "the camera was unplugged"
        elif status != usb.TRANSFER_CANCELLED:
            self._errors += 1
            if status == usb.TRANSFER_STALL or self._errors > MOST_ERRORS:
                self.trouble = "the camera's stream stalled"
        if self._closing or self.trouble or status == usb.TRANSFER_CANCELLED:
            return
        try:
            transfer.submit()
        except usb.USBErrorNoDevice:
            self.trouble = "the camera was unplugged"
        except usb.USBError as error:
            self.trouble = f"the camera's stream broke off ({error})"

    def _run(self) -> None:
        """Handle events until closed; then cancel what is under way, and handle events until it is back."""
        usb = self._usb
        while not self._closing:
            self._handle_events()
        for transfer in self._transfers:
            with suppress(usb.USBError, ValueError):  # is back already
                transfer.cancel()
        for _ in range(int(ENDING / AT_A_TIME)):
            if not any(transfer.isSubmitted() for transfer in self._transfers):
                break
            self._handle_events()
        for transfer in self._transfers:
            with suppress(usb.USBError, ValueError):
                transfer.close()

    def _handle_events(self) -> None:
        try:
            self._context.handleEventsTimeout(AT_A_TIME)
        except self._usb.USBErrorInterrupted:
            return
        except self._usb.USBError as error:
            self.trouble = self.trouble or f"USB failed ({error})"
            threading.Event().wait(AT_A_TIME)

    def _told(self, error: Exception, where: str) -> DeviceError:
        usb = self._usb
        if isinstance(error, usb.USBErrorAccess):
            do = "fusion doctor --udev prints the rule that allows it, and where to put it"
            return DeviceError("the Kinect may not be opened by you", where, do=do)
        if isinstance(error, usb.USBErrorBusy):
            return DeviceError("the Kinect is in use by another program", where, do="close that program")
        if isinstance(error, usb.USBErrorNoDevice | usb.USBErrorNotFound):
            return DeviceError("the camera is gone", where, do="plug it in again")
        if isinstance(error, usb.USBErrorNoMem):
            do = "use another USB port: a Kinect needs most of what a USB 2 controller has"
            return DeviceError("USB has no room for the camera's streams", where, do=do)
        return DeviceError("the Kinect cannot be used", where, str(error), do="unplug it and plug it in again")
