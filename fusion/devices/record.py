"""Recording a source: one thread takes the frames, one writes them, and between them lies a queue of bounded size.

Nothing that was taken is dropped. Where the disk is too slow the queue fills and taking waits: a recording played back
is then played slower, a camera loses frames on its own side, which counts them (`SourceFrame.missed`); that is told.
"""

import contextvars
import queue
import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from fusion.devices.by_hand import ByHand, by_hand
from fusion.devices.growing import Color, GrowingFolder
from fusion.devices.source import Description, Source, SourceFrame
from fusion.devices.turn import TurnWatch
from fusion.errors import DeviceError, FusionError
from fusion.files.output.publish import output_folder
from fusion.files.output.refused import told
from fusion.progress import stage
from fusion.recording.writing.write import MEMBERS

QUEUE_BYTES = 128 << 20  # some 40 frames of a Kinect v1 with colours: more than a second in which a disk may be busy
SHOWN = 0.2  # [s] between two looks at how far it is


@dataclass(frozen=True)
class RecordSettings:
    """What is recorded of a source.

    Attributes:
        frames: end after so many, or None.
        turn: end when a table has turned once.
        every: of so many frames the first is recorded.
        color: as GrowingFolder takes it.
    """

    frames: int | None = None
    turn: bool = False
    every: int = 1
    color: Color = "png"


@dataclass(frozen=True)
class Recorded:
    """What became of it.

    Attributes:
        path: the recording.
        frames: in it.
        missed: lost on the wire, or because they were taken too late.
        seconds: from the first to the last frame, by the clock of the recording.
        fullest, room: most frames that waited to be written, and how many can.
        ended: "frames", "turn", "stopped" or "source": what ended it.
    """

    path: Path
    frames: int
    missed: int
    seconds: float
    fullest: int
    room: int
    ended: str


def record_source(source: Source, path: Path | str, settings: RecordSettings | None = None) -> Recorded:
    """Record a source as a native folder, until it ends, the settings say so or Ctrl-C is pressed.

    The folder appears with its first frame and is a whole recording from then on, also when this process is killed.
    Beside what every recording has: `raw/` as the device sent it, `telemetry.csv` with the clocks of device and
    machine, `device.json` with what the device told of itself.

    Raises:
        DeviceError: no frame came, or the device went away; what was recorded before stays.
        FusionError: the folder cannot be written.

    >>> with fusion.open_source("replay:my_scan@max") as source:
    ...     fusion.record_source(source, "again").frames
    26
    """
    path = Path(path)
    return fill_recorded(source, path, lambda: output_folder(path, replaces=MEMBERS), settings or RecordSettings())


def fill_recorded(
    source: Source, path: Path, place: Callable[[], AbstractContextManager[Path]], settings: RecordSettings
) -> Recorded:
    """The same; `place` gives the folder in which the first frame is written, then puts it at `path`."""
    tape = _Tape(source, source.describe(), settings)
    try:
        with told(path), by_hand() as hand:
            _run(tape, path, place, hand)
    except FusionError as error:
        if not tape.count:
            raise
        kept = f"the {tape.count} frames before are kept in {path}"
        raise type(error)(error.what, error.where, error.found, error.expected, f"{error.do}; {kept}") from error
    if tape.first is None:
        if tape.ended == "stopped":
            hand.pass_on()
        raise DeviceError("no frame came", tape.about.name, do="look at the camera with fusion doctor")
    seconds = tape.last - tape.first
    return Recorded(path, tape.count, tape.missed, seconds, tape.fullest, tape.room, tape.ended or "source")


def _run(tape: "_Tape", path: Path, place: Callable[[], AbstractContextManager[Path]], hand: ByHand) -> None:
    """From the first frame to the last one written; what went wrong in a thread is raised here."""
    try:
        tape.start(path, place)
        with stage("recording", tape.settings.frames or tape.about.length) as step:
            _show(tape, step, hand)
    finally:
        tape.end()
    if tape.error is not None:
        raise tape.error


def _show(tape: "_Tape", step: Callable[[], None], hand: ByHand) -> None:
    """Tell how far it is until it is over, or is to be."""
    shown, begin = 0, time.monotonic()
    while not tape.over.wait(SHOWN):
        if hand.asked:
            tape.ended = tape.ended or "stopped"
            return
        count = tape.count
        for _ in range(count - shown):
            step()
        shown, rate = count, count / (time.monotonic() - begin)
        lost = f", {tape.missed} lost" if tape.missed else ""
        with stage(f"{count} frames, {rate:.1f} a second, {tape.waiting.qsize()} of {tape.room} wait{lost}"):
            pass


class _Tape:
    """The two threads, and what they tell."""

    def __init__(self, source: Source, about: Description, settings: RecordSettings) -> None:
        self.source, self.about, self.settings = source, about, settings
        # depth, raw and infrared, and colours in their own size
        colored = about.camera.color or about.camera
        size = about.camera.width * about.camera.height * 8 + colored.width * colored.height * 3
        self.room = max(8, QUEUE_BYTES // size)
        self.waiting: queue.Queue[SourceFrame | None] = queue.Queue(self.room)
        self.over = threading.Event()
        self.error: Exception | None = None
        self.ended = ""
        self.count = self.missed = self.fullest = 0
        self.first: float | None = None
        self.last = 0.0
        self._threads: list[threading.Thread] = []

    def start(self, path: Path, place: Callable[[], AbstractContextManager[Path]]) -> None:
        for work in (self._take, lambda: self._write(path, place)):
            around = contextvars.copy_context()  # notes of the work reach who follows it
            thread = threading.Thread(target=around.run, args=(self._guarded, work), daemon=True)
            self._threads.append(thread)
            thread.start()

    def end(self) -> None:
        """Take no more, write what waits."""
        self.source.stop()
        for thread in self._threads:
            thread.join()

    def _guarded(self, work: Callable[[], None]) -> None:
        try:
            work()
        except Exception as error:
            self.error = self.error or error
            self.source.stop()

    def _take(self) -> None:
        watch, kept = TurnWatch() if self.settings.turn else None, 0
        try:
            for number, frame in enumerate(self.source.frames()):
                self.missed += frame.missed
                turned = watch is not None and watch.seen(frame)
                if number % self.settings.every == 0:
                    self._hand_over(frame)
                    kept += 1
                if turned or kept == self.settings.frames:
                    self.ended = "turn" if turned else "frames"
                    break
                if self.error is not None:
                    break
        finally:
            self._hand_over(None)

    def _hand_over(self, frame: SourceFrame | None) -> None:
        """Wait until there is room, unless nobody writes any more."""
        while self.error is None:
            try:
                self.waiting.put(frame, timeout=SHOWN)
                break
            except queue.Full:
                continue
        self.fullest = max(self.fullest, self.waiting.qsize())

    def _write(self, path: Path, place: Callable[[], AbstractContextManager[Path]]) -> None:
        folder: GrowingFolder | None = None
        try:
            while (frame := self.waiting.get()) is not None:
                if folder is None:
                    with place() as made:
                        folder = GrowingFolder(made, self.about, self.settings.color)
                        folder.add(frame)
                    folder.folder = path.resolve()
                    self.first = frame.timestamp
                else:
                    folder.add(frame)
                self.count, self.last = folder.count, frame.timestamp
        finally:
            self.over.set()
