"""How a live scan keeps up: a recording replayed at 30 frames a second; frames tracked, lost and late, and the delay.

    python tools/live_rate.py REC [--rate 30]

Prints one line of figures for the view and the recording; nothing is kept. CPU time is of this process.
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from fusion.devices.record import RecordSettings
from fusion.devices.replay import Replay
from fusion.files.publish import output_folder
from fusion.live.session import record_live
from fusion.recording.open import open_recording
from fusion.recording.write import MEMBERS


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=Path)
    parser.add_argument("--rate", type=float, default=30.0, help="frames a second")
    chosen = parser.parse_args()
    recording = open_recording(chosen.recording)
    step = float(np.median(np.diff(recording.timestamps)))
    with tempfile.TemporaryDirectory() as folder, Replay(recording, chosen.rate * step) as source:
        path, begin, used = Path(folder) / "recorded", time.monotonic(), time.process_time()
        done, watch = record_live(source, path, lambda: output_folder(path, replaces=MEMBERS), RecordSettings())
        took, used = time.monotonic() - begin, time.process_time() - used
        kept = len(open_recording(path))
    state, late = watch.state, np.array(watch.behind or [np.nan])
    print(f"recording: {kept} of {len(recording)} frames, {done.missed} lost, at {done.frames / took:.1f} a second")
    placed, lost = watch.tracked, watch.untracked
    print(f"view: {placed} placed, {lost} not, {state.dropped} too late; {used / took:.2f} cores")
    middle = np.median(late[len(late) // 4 :])
    print(f"behind: {1e3 * np.median(late):.0f} ms median, {1e3 * middle:.0f} ms once the object was found")
    return int(kept != len(recording) or lost > 0 or watch.error is not None)


if __name__ == "__main__":
    raise SystemExit(main())
