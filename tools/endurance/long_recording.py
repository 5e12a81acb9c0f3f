"""A long recording from a source that is played back over and over: memory, waiting frames, frames lost.

    python -m tools.endurance.long_recording REC OUT --minutes 30 [--speed 4] [--color jpeg]

Prints a line every ten seconds and one JSON object in the end; status 1 when a frame is missing or memory grew by more
than a tenth after the first minute (a tenth of the run for shorter ones). OUT takes what the frames take: 30 minutes of
640 x 480 with colours tens of gigabytes; `--drop` removes images once they were written.
"""

import argparse
import json
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from fusion.devices.record import RecordSettings, record_source
from fusion.devices.replay import Replay
from fusion.devices.source import SourceFrame
from fusion.recording.open import open_recording

RATE = 30.0


class Endless(Replay):
    """A recording's frames over and over, 30 a second of its own clock, for so many seconds of it."""

    seconds = 0.0

    def frames(self) -> Iterator[SourceFrame]:
        begin, total = time.monotonic(), round(self.seconds * RATE)
        for number in range(total):
            if self._stopped.is_set():
                return
            if self.speed is not None:
                self._stopped.wait(max(0.0, begin + number / RATE / self.speed - time.monotonic()))
            stamp = number / RATE
            frame = self._frame(number % len(self.recording), {}, 0)
            yield replace(frame, index=number, timestamp=stamp, device_time=stamp, host_time=time.time())


def resident() -> float:
    """Memory of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * 4096 / 1e6


def main() -> int:
    """Record, watch, judge."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--speed", type=float, default=None, help="times real time (default: as fast as can be)")
    parser.add_argument("--color", choices=("png", "jpeg"), default="jpeg")
    parser.add_argument("--drop", action="store_true", help="remove images that were written a while ago")
    options = parser.parse_args()
    source = Endless(open_recording(options.recording), options.speed)
    source.seconds = 60 * options.minutes
    watched: list[tuple[float, float]] = []
    done = threading.Event()

    def watch() -> None:
        begin = time.monotonic()
        while not done.wait(0.5):
            watched.append((time.monotonic() - begin, resident()))
            if options.drop:
                for folder in ("depth", "rgb", "ir", "raw"):
                    for path in sorted((options.output / folder).glob("*"))[:-100]:
                        path.unlink()
            if len(watched) % 20 == 0:
                print(f"{watched[-1][0]:6.0f} s  {watched[-1][1]:7.1f} MB", flush=True)

    thread = threading.Thread(target=watch)
    thread.start()
    with source:
        made = record_source(source, options.output, RecordSettings(color=options.color))
    done.set()
    thread.join()
    warm = min(60.0, watched[-1][0] / 10)
    memory = np.array([size for at, size in watched if at >= warm])
    grown = float(memory[-len(memory) // 5 :].mean() / memory[: max(1, len(memory) // 5)].mean() - 1)
    lines = (options.output / "depth.txt").read_text(encoding="utf-8").splitlines()
    listed = sum(not line.startswith("#") for line in lines)
    missing = round(source.seconds * RATE) - listed
    told = {"frames": made.frames, "listed": listed, "missing": missing, "waited_at_most": [made.fullest, made.room]}
    told |= {
        "wall_s": round(watched[-1][0], 1),
        "memory_mb": [round(float(memory.min()), 1), round(float(memory.max()), 1)],
    }
    print(json.dumps(told | {"memory_grown": round(grown, 4)}, indent=1))
    return int(missing != 0 or grown > 0.1)


if __name__ == "__main__":
    sys.exit(main())
