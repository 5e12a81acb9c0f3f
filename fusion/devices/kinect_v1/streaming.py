"""One run of the camera's streams: registers that start and stop them, and frames as they arrive."""

import queue
import time
from collections import deque
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from fusion.devices.kinect_v1 import port as ports
from fusion.devices.kinect_v1.commands import Commands
from fusion.devices.kinect_v1.find import WINDOWS, Parts
from fusion.devices.kinect_v1.packets import BAYER, DEPTH_11, IR_10, Assembler, RawFrame
from fusion.errors import DeviceError

TICKS = 60e6  # a second; widely reported, the maker says nothing
RATE = 30.0  # frames a second
ROUND = 1 << 32
KNOWN = 3  # steps between frames whose middle is taken for the usual one
SHOWN = 15  # of the latest steps


class DeviceClock:
    """Turns ticks into seconds without jumps, and gaps into a number of frames."""

    def __init__(self) -> None:
        self._last: tuple[int, float] | None = None
        self._steps: deque[int] = deque(maxlen=SHOWN)
        self._anew = False
        self.seconds = 0.0

    def restart(self) -> None:
        """The next frame comes from a device that began anew: its clock says nothing of the time between."""
        self._anew = True

    def at(self, ticks: int, host: float) -> tuple[float, int]:
        """The device's time [s] of a frame that came at `host` [s], and how many frames are missing before it."""
        before, self._last = self._last, (ticks, host)
        if before is None:
            self.seconds = ticks / TICKS
            return self.seconds, 0
        if self._anew:
            self._anew = False
            gap = max(0.0, host - before[1])
            self.seconds += gap
            return self.seconds, max(0, round(gap * RATE) - 1)
        step = (ticks - before[0]) % ROUND
        self.seconds += step / TICKS
        usual = float(np.median(self._steps)) if len(self._steps) >= KNOWN else 0.0
        missing = max(0, round(step / usual) - 1) if usual > 0 else 0
        if not missing:
            self._steps.append(step)
        return self.seconds, missing


# register, value: in the order in which libfreenect writes them
DEPTH_ON = ((0x105, 0), (0x06, 0), (0x12, 3), (0x13, 1), (0x14, 30), (0x06, 2), (0x17, 0))
COLOR_ON = ((0x0C, 0), (0x0D, 1), (0x0E, 30), (0x05, 1), (0x47, 0))
IR_ON = ((0x19, 0), (0x1A, 1), (0x1B, 30), (0x105, 0), (0x05, 3), (0x48, 0))
OFF = ((0x06, 0), (0x05, 0))
ROOM = 30  # frames that wait for who takes them: a second, 13 MB
PICTURES = 2  # colour images that wait for their depth: of two streams either may be first


@dataclass(frozen=True)
class Arrived:
    """A depth frame, the picture nearest to it or None, and the time [s] since 1970 when it was complete."""

    depth: RawFrame
    picture: RawFrame | None
    host: float


class Streaming:
    """Depth, and colours or infrared, from now on until closed. Raises DeviceError where they do not start."""

    def __init__(self, parts: Parts, infrared: bool) -> None:
        self.arrived: queue.Queue[Arrived] = queue.Queue(ROOM)
        self.untaken = 0
        self._pictures: deque[RawFrame] = deque(maxlen=PICTURES)
        self.depth = Assembler(DEPTH_11, self._depth_came)
        self.video = Assembler(IR_10 if infrared else BAYER, self._picture_came)
        camera = parts.camera
        self._port = ports.Port(camera.bus, camera.address, int(camera.idProduct == WINDOWS))
        self._commands = Commands(self._port)
        try:
            for register, value in OFF:  # whatever another program left
                self._commands.set(register, value)
            # transfers first: packets that nobody waits for are lost
            self._port.listen(ports.DEPTH, self.depth.feed)
            self._port.listen(ports.VIDEO, self.video.feed)
            for register, value in (*DEPTH_ON, *(IR_ON if infrared else COLOR_ON)):
                self._commands.set(register, value)
        except BaseException:
            self.close()
            raise

    @property
    def trouble(self) -> str:
        """Why no packets come any more, "" while they do."""
        return self._port.trouble

    def close(self) -> None:
        """Stop the streams and let the camera go."""
        with suppress(DeviceError):  # a camera that is gone needs no stopping
            for register, value in OFF:
                if self._port.trouble:
                    break
                self._commands.set(register, value)
        self._port.close()

    def _depth_came(self, frame: RawFrame) -> None:
        try:
            self.arrived.put_nowait(Arrived(frame, self._picture_at(frame.ticks), time.time()))
        except queue.Full:
            self.untaken += 1

    def _picture_came(self, frame: RawFrame) -> None:
        self._pictures.append(frame)

    def _picture_at(self, ticks: int) -> RawFrame | None:
        """The waiting picture nearest by the device's clock; those before it wait no longer."""
        if not self._pictures:
            return None
        gaps = [min((one.ticks - ticks) % ROUND, (ticks - one.ticks) % ROUND) for one in self._pictures]
        for _ in range(gaps.index(min(gaps))):
            self._pictures.popleft()
        return self._pictures.popleft()
