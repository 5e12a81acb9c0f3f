"""How a live scan keeps up: a recording replayed at 30 frames a second; frames tracked, lost and late, and the delay.

    python -m tools.endurance.live_rate REC [--rate 30] [--wall]

Without --wall the clock is fed: the view takes its frames one after the other, each step lasts as long as the processor
worked for it, and frames arrive by that clock. So others on the machine change nothing, and a second run is like the
first. What the recorder takes is measured apart: on two cores view and recorder have one each. Reading the files of REC
is left out, and looks for the object hold the view up there, which in `fusion live` they do not. With --wall all runs
as in `fusion live`, by the machine's own clock. Nothing is kept.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from fusion.compute.process import tune_process
from fusion.devices.growing import GrowingFolder
from fusion.devices.record import RecordSettings
from fusion.devices.replay import Replay
from fusion.devices.source import SourceFrame
from fusion.files.output.publish import output_folder
from fusion.live.feed import Feed
from fusion.live.session import record_live
from fusion.live.watch import Watch
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording
from fusion.recording.writing.write import MEMBERS


class Fed:
    """A clock that goes on by the processor's time while a step is taken, or by `pace` [s] for each; else when told."""

    def __init__(self, pace: float | None = None) -> None:
        self._at, self._since, self._pace = 0.0, float("nan"), pace

    def __call__(self) -> float:
        return self._at if np.isnan(self._since) else self._at + time.process_time() - self._since

    def step(self, work: Callable[[], None]) -> float:
        """Do something; how long it took [s]."""
        begin = self._at
        if self._pace is None:
            self._since = time.process_time()
        work()
        self._at, self._since = self() + (self._pace or 0.0), float("nan")
        return self._at - begin

    def until(self, moment: float) -> None:
        """Wait for a moment that may have gone by."""
        self._at = max(self._at, moment)


def fed(recording: Recording, rate: float, pace: float | None = None) -> tuple[Watch, list[float]]:
    """The view of a recording by a fed clock, and how long each of its steps took [s], or was said to (`pace`)."""
    source, clock = Replay(recording, None), Fed(pace)
    feed = Feed(source, clock=clock)
    watch, took, count = Watch(feed, Path()), [], 0
    frames = list(source.frames())

    def arrive() -> None:
        nonlocal count
        while count < len(frames) and count / rate <= clock():
            feed.offer(frames[count], count / rate)
            count += 1

    while count < len(frames) or feed.offered:
        if not feed.offered:
            clock.until(count / rate)
            arrive()
        frame, came = feed.offered.popleft()
        took.append(clock.step(lambda frame=frame, came=came: watch.see(frame, came)))  # type: ignore[misc]
        arrive()
    return watch, took


def written(frames: list[SourceFrame], source: Replay) -> float:
    """Processor time of the recorder for a frame [s]."""
    with tempfile.TemporaryDirectory() as folder:
        made, begin = GrowingFolder(Path(folder), source.describe()), time.process_time()
        for frame in frames:
            made.add(frame)
    return (time.process_time() - begin) / len(frames)


def by_fed_clock(recording: Recording, rate: float) -> int:
    """Run once to compile, once to measure."""
    fed(recording, rate)
    watch, took = fed(recording, rate)
    source = Replay(recording, None)
    recorder = written(list(source.frames())[:60], source)
    late, steps = np.array(watch.behind or [np.nan]), 1e3 * np.array(took)
    lost, dropped = watch.untracked + len(watch.waiting), watch.feed.dropped
    print(f"view: {watch.tracked} of {len(recording)} placed, {lost} not, {dropped} too late")
    print(
        f"a step of the view: {np.median(steps):.1f} ms of processor in the median, {np.mean(steps):.1f} in the mean, "
        f"{np.percentile(steps, 99):.0f} in 1 of 100, {steps.max():.0f} at most; the recorder {1e3 * recorder:.1f} ms"
    )
    print(f"behind: {1e3 * np.median(late):.0f} ms median, {1e3 * np.percentile(late, 95):.0f} ms in 1 of 20")
    return int(watch.tracked != len(recording) or np.median(late) > 0.15 or recorder > 1 / rate)


def by_wall_clock(recording: Recording, rate: float) -> int:
    """As `fusion live` does it."""
    step = float(np.median(np.diff(recording.timestamps)))
    with tempfile.TemporaryDirectory() as folder, Replay(recording, rate * step) as source:
        path, begin, used = Path(folder) / "recorded", time.monotonic(), time.process_time()
        done, watch = record_live(source, path, lambda: output_folder(path, replaces=MEMBERS), RecordSettings())
        took, used = time.monotonic() - begin, time.process_time() - used
        kept = len(open_recording(path))
    state, late = watch.state, np.array(watch.behind or [np.nan])
    print(f"recording: {kept} of {len(recording)} frames, {done.missed} lost, {took:.1f} s with getting ready")
    placed, lost = watch.tracked, watch.untracked
    print(f"view: {placed} placed, {lost} not, {state.dropped} too late; {used / took:.2f} cores")
    middle = np.median(late[len(late) // 4 :])
    print(f"behind: {1e3 * np.median(late):.0f} ms median, {1e3 * middle:.0f} ms once the object was found")
    late_or_lost = lost > 0 or state.dropped > 0 or not np.median(late) <= 0.15
    return int(kept != len(recording) or late_or_lost or watch.error is not None)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=Path)
    parser.add_argument("--rate", type=float, default=30.0, help="frames a second")
    parser.add_argument("--wall", action="store_true", help="by the machine's clock, recorder and all")
    chosen = parser.parse_args()
    tune_process()  # as `fusion live` is
    return (by_wall_clock if chosen.wall else by_fed_clock)(open_recording(chosen.recording), chosen.rate)


if __name__ == "__main__":
    raise SystemExit(main())
