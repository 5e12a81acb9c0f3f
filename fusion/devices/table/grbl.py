"""A table behind a controller that speaks GRBL 1.1 over a serial port, one of its axes counting degrees as millimetres.

Written from Grbl's own description of its interface (gnea/grbl, doc/markdown: interface, jogging, realtime_cmds): a
line is answered by `ok` or `error:N`; `?` by `<State|MPos:x,y,z|...>`; `ALARM:N` may come at any time. Moves are jogs,
which leave the controller's own modes alone and may be cancelled. The table stands where the controller reports it.
"""

import re
import threading
import time
from collections.abc import Callable
from typing import Any

from fusion.errors import DeviceError
from fusion.files.extra import extra

BAUD = 115200  # of Grbl since 0.9
AXES = "XYZABC"
RATE = 600.0  # [deg/min] 36 s a turn, so that nothing slides on the plate (guess); the controller has its own limits
BOOT = 2.5  # [s] until an Arduino that opening the port has reset greets (its loader waits up to 2)
ANSWER = 2.0  # [s] for an answer: Grbl gives one at once, but where its buffer is full
STILL = 4.0  # [s] without any motion after which it will not come (guess)
LOOK = 0.05  # [s] between two questions; Grbl's description asks for no more than 5 to 10 a second while it streams
NEAR = 1.0  # [deg] from the goal that is still there: about half a step of a motor without a gear
CANCEL = b"\x85"
SILENT = "look whether it is the right port, and whether the table has power"
GREETING = re.compile("grbl", re.IGNORECASE)  # `Grbl 1.1h ['$' for help]`, and those of its descendants
STATUS = re.compile(r"<(\w+)(?::\d+)?\|([MW])Pos:([-+.\d,]+)")


class _SilentError(DeviceError):
    """No answer came."""


class Grbl:
    """A table at a port; the angle at which it stands when it is opened is 0.

    Args:
        port: such as `/dev/ttyUSB0` or `COM3`.
        axis: the one that turns; 1 mm of it is one degree ($100 to $102 of the controller).

    Raises:
        DeviceError: the port cannot be opened, nothing there speaks GRBL, or the table is not ready.
    """

    def __init__(self, port: str, axis: str = "X") -> None:
        serial = extra("serial", "table", "a turntable", port, DeviceError)
        self.port, self.axis, self._rest = port, axis, b""
        self._stopped = threading.Event()
        try:
            self._serial: Any = serial.Serial(port, BAUD, timeout=LOOK, write_timeout=ANSWER, exclusive=True)
        except (OSError, ValueError) as error:
            raise DeviceError("the table's port cannot be opened", port, _reason(error), do=_help(error)) from error
        try:
            self._greet()
            state, place = self._status()
            if state != "Idle":
                do = "move it by your own program once, look what holds it, and unlock it ($H or $X)"
                raise DeviceError("the table is not ready", port, f"state {state}", "state Idle", do)
            if "$13=1" in self._ask("$$"):
                raise DeviceError("the table reports in inches", port, "$13=1", "$13=0, 1 mm a degree", "set $13=0")
        except BaseException:
            self.close()
            raise
        self._begin = place

    def go(self, angle: float) -> float:
        """Turn to an angle [deg] and wait until it stands; where it stands. Raises DeviceError."""
        goal = self._begin + angle
        self._ask(f"$J={self._frame}G21{self.axis}{goal:.3f}F{RATE:g}")
        moved, last = time.monotonic(), float("nan")
        while not self._stopped.is_set():
            state, place = self._status()
            if state == "Alarm":
                self._alarm("state Alarm")
            if state == "Idle" and abs(place - goal) <= NEAR:
                return place - self._begin
            if place != last:
                moved, last = time.monotonic(), place
            elif time.monotonic() - moved > STILL:
                found = f"state {state} at {place - self._begin:.2f} deg"
                do = "look what holds it, and whether the axis is the right one: --table grbl:PORT:AXIS"
                raise DeviceError("the table does not get where it is sent", self.port, found, f"{angle:.2f} deg", do)
            self._stopped.wait(LOOK)
        self._write(CANCEL)
        return last - self._begin

    def stop(self) -> None:
        """Let `go` cancel its motion and return; from any thread."""
        self._stopped.set()

    def close(self) -> None:
        """Let the port go."""
        self._serial.close()

    def _greet(self) -> None:
        """Wait for the greeting after a reset; a controller that opening the port does not reset is asked."""
        heard: list[str] = []
        begin = time.monotonic()
        while time.monotonic() < begin + BOOT:
            line = self._line()
            if GREETING.match(line):
                return
            heard += [line] * bool(line)
        try:
            self._awaited(lambda line: bool(GREETING.match(line) or STATUS.match(line)), b"?", heard)
        except _SilentError as error:
            found = f"{heard[0][:40]!r}" if heard else "no answer"
            raise DeviceError("nothing there speaks GRBL", self.port, found, "Grbl 1.1", SILENT) from error

    def _status(self) -> tuple[str, float]:
        """State, and where the axis stands [mm or deg]."""
        told = STATUS.match(self._awaited(lambda line: line.startswith("<"), asked=b"?"))
        places = told[3].split(",") if told else []
        index = AXES.index(self.axis)
        if told is None or len(places) <= index:
            found = "no position" if told is None else f"{len(places)} axes"
            raise DeviceError("the table does not tell where it stands", self.port, found, f"axis {self.axis}")
        # a jog in the same frame as the report: of the machine, or where only that is reported ($10) of the work
        self._frame = "G53" if told[2] == "M" else "G90"
        return told[1], float(places[index])

    def _ask(self, line: str) -> list[str]:
        """Send a line and wait for its `ok`; what came before that."""
        self._write(line.encode("ascii") + b"\n")
        before: list[str] = []
        last = self._awaited(lambda one: one == "ok" or one.startswith("error:"), before=before)
        if last != "ok":
            what = "the table is locked: unlock it ($H or $X)" if last == "error:9" else "see Grbl's list of errors"
            raise DeviceError("the table refused a command", self.port, f"{last} to {line}", "ok", what)
        return before

    def _awaited(self, wanted: Callable[[str], bool], asked: bytes = b"", before: list[str] | None = None) -> str:
        """The next line of a kind; others go to `before`, an alarm is raised. A question may be overheard."""
        begin, again = time.monotonic(), 0.0
        while (now := time.monotonic()) < begin + ANSWER:
            if asked and now >= begin + again:
                self._write(asked)
                again += ANSWER / 4
            line = self._line()
            if wanted(line):
                return line
            if line.startswith("ALARM:"):
                self._alarm(line)
            if GREETING.match(line):
                raise DeviceError("the table was reset while it turned", self.port, line, do="look at its power")
            if line and before is not None:
                before.append(line)
        raise _SilentError("the table does not answer any more", self.port, f"nothing for {ANSWER:g} s", do=SILENT)

    def _alarm(self, found: str) -> None:
        do = "look what holds it, then unlock it ($H or $X) by your own program"
        raise DeviceError("the table is in alarm", self.port, found, "state Idle", do)

    def _line(self) -> str:
        """The next whole line, "" where none came for a while."""
        try:
            head, end, rest = self._rest.partition(b"\n")
            if not end:
                self._rest += self._serial.read(max(1, self._serial.in_waiting))
                head, end, rest = self._rest.partition(b"\n")
        except (OSError, TypeError) as error:  # TypeError: pyserial, where the port was closed by another thread
            raise self._gone(error) from error
        if not end:
            return ""
        self._rest = rest
        return head.decode("ascii", "replace").strip()

    def _write(self, data: bytes) -> None:
        try:
            self._serial.write(data)
        except OSError as error:
            raise self._gone(error) from error

    def _gone(self, error: Exception) -> DeviceError:
        return DeviceError("the table is gone", self.port, _reason(error), do="plug it in again")


def _reason(error: Exception) -> str:
    """In a few words: pyserial repeats itself."""
    told = re.search(r"\[Errno \d+\] ([^:\[\]]+?)(?:: '.*')?$", str(error))
    return told[1] if told else str(error)[:80]


def _help(error: Exception) -> str:
    if getattr(error, "errno", None) == 13:
        return "become a member of the group that owns it (Debian, Ubuntu: dialout), and log in anew"
    return "look which ports there are: python -m serial.tools.list_ports"
