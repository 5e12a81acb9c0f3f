"""A recording played back as a source: at its own rate, faster, or as fast as it is taken."""

import time
from collections.abc import Iterator
from threading import Event
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fusion.devices.source import Description, SourceFrame
from fusion.errors import RecordingError
from fusion.progress import note
from fusion.recording.recording import Recording


class Replay:
    """The frames of a recording, as if they came from a camera now.

    Args:
        speed: times its own rate; None hands over each frame as soon as it is asked for.

    A frame that cannot be read is left out and counted as missed. Who asks late gets late frames, but every one.
    """

    def __init__(self, recording: Recording, speed: float | None = 1.0) -> None:
        self.recording, self.speed = recording, speed
        self._stopped = Event()

    def describe(self) -> Description:
        """The recording's camera; the rate of its middle step."""
        recording = self.recording
        steps = np.diff(recording.timestamps)
        middle = float(np.median(steps)) if len(steps) else 0.0
        color, ir = recording.has_color, recording.has_ir
        return Description(
            name="replay",
            camera=recording.camera,
            serial=recording.camera.serial,
            rate=(self.speed or 1.0) / middle if middle > 0 else 0.0,
            length=len(recording),
            color=color is not None and bool(color.any()),
            ir=ir is not None and bool(ir.any()),
            notes=recording.warnings,
        )

    def start(self) -> None:
        """From the first frame on."""
        self._stopped.clear()

    def frames(self) -> Iterator[SourceFrame]:
        """Every frame, when it is due."""
        logs = {name: self.recording.telemetry_at_frames(name) for name in self.recording.telemetry}
        begin, missed, given = time.monotonic(), 0, 0
        for index in range(len(self.recording)):
            if self._stopped.is_set():
                return
            try:
                frame = self._frame(index, logs, missed)
            except RecordingError as error:
                note(f"frame {index} is left out: {error}")
                missed, last = missed + 1, error
                continue
            if self.speed is not None:
                due = begin + float(frame.timestamp - self.recording.timestamps[0]) / self.speed
                if self._stopped.wait(max(0.0, due - time.monotonic())):
                    return
            missed, given = 0, given + 1
            yield SourceFrame(**{**vars(frame), "host_time": time.time()})
        if missed and not given:
            raise last

    def stop(self) -> None:
        """No more frames."""
        self._stopped.set()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.stop()

    def _frame(self, index: int, logs: dict[str, NDArray | None], missed: int) -> SourceFrame:
        frame = self.recording[index]
        known = {name: values for name, values in logs.items() if values is not None and name != "timestamp"}
        log = {name: float(values[index]) for name, values in known.items()}
        apart = self.recording.color_apart(index) if self.recording.color_is_apart else None
        return SourceFrame(
            **vars(frame),
            device_time=log.pop("device_s", frame.timestamp),
            color_apart=apart,
            log={name: value for name, value in log.items() if name not in ("host_s", "missed")},
            missed=missed,
        )
