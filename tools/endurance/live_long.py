"""A long live scan: a recording of one turn played round and round; what is lost, and how much memory it takes.

    python -m tools.endurance.live_long REC [--minutes 30] [--rate 10] [--port N]

REC shows one whole turn, so that its first frame follows its last one. Recorder and view run as in `fusion live`, the
page too where a port is given. Prints a line each half minute; ends with status 1 where a frame is missing in the
recording or memory grew by more than a tenth after the first fifth. Nothing is kept; a frame of 160 x 120 takes 80 kB
of disk meanwhile.
"""

import argparse
import os
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from fusion.devices.record import RecordSettings
from fusion.devices.replay import Replay
from fusion.devices.source import Description, SourceFrame
from fusion.files.output.publish import output_folder
from fusion.live.feed import Feed
from fusion.live.page import page
from fusion.live.session import record_live
from fusion.live.watch import Watch
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording
from fusion.recording.writing.write import MEMBERS

EVERY = 30.0  # [s] between two lines
GROWN = 0.1  # share that memory may grow after the first fifth


class Round(Replay):
    """A recording round and round, `rate` frames a second, `count` in all."""

    def __init__(self, recording: Recording, rate: float, count: int) -> None:
        super().__init__(recording)
        self.rate, self.count = rate, count

    def describe(self) -> Description:
        return replace(super().describe(), rate=self.rate, length=self.count)

    def frames(self) -> Iterator[SourceFrame]:
        begin, first, held = time.monotonic(), float(self.recording.timestamps[0]), list(self.recording)
        for index in range(self.count):
            due = index / self.rate
            if self._stopped.wait(max(0.0, begin + due - time.monotonic())):
                return
            frame = replace(held[index % len(held)], index=index, timestamp=first + due)
            yield SourceFrame(**vars(frame), device_time=due, host_time=time.time())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=Path)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--rate", type=float, default=10.0, help="frames a second")
    parser.add_argument("--port", type=int, help="of a page that is served meanwhile")
    chosen = parser.parse_args()
    count = int(60 * chosen.minutes * chosen.rate)
    memory: list[float] = []

    def shown(feed: Feed, watch: Watch) -> AbstractContextManager[None]:
        threading.Thread(target=_tell, args=(watch, memory), daemon=True).start()
        return nullcontext() if chosen.port is None else page(chosen.port, feed, watch)

    with tempfile.TemporaryDirectory() as folder, Round(open_recording(chosen.recording), chosen.rate, count) as source:
        path, used, begin = Path(folder) / "recorded", time.process_time(), time.monotonic()
        place = partial(output_folder, path, replaces=MEMBERS)
        done, watch = record_live(source, path, place, RecordSettings(), shown)
        took, used = time.monotonic() - begin, time.process_time() - used
        kept, stamps = len(open_recording(path)), open_recording(path).timestamps
    gaps = int((np.diff(stamps) > 1.5 / chosen.rate).sum())
    grown = max(memory[len(memory) // 5 :]) / memory[len(memory) // 5] - 1
    print(f"recording: {kept} of {count} frames, {gaps} gaps, {done.missed} lost, {done.fullest} of {done.room} waited")
    print(f"view: {watch.tracked} placed, {watch.untracked} not, {watch.feed.dropped} too late; {watch.error or ''}")
    print(f"{took / 60:.1f} minutes, {used / took:.2f} cores; memory grew by {100 * grown:.1f} % after the first fifth")
    return int(kept != count or gaps > 0 or grown > GROWN or watch.error is not None)


def _tell(watch: Watch, memory: list[float]) -> None:
    begin = time.monotonic()
    while True:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        memory.append(pages * os.sysconf("SC_PAGE_SIZE") / 2**20)
        print(f"{time.monotonic() - begin:6.0f} s  {memory[-1]:6.0f} MB  {watch.state.line()}", flush=True)
        time.sleep(EVERY)


if __name__ == "__main__":
    raise SystemExit(main())
