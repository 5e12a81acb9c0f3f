"""Debian's libfreenect, a driver that shares no code with this project, against the emulated Kinect of the tests.

    python -m tools.endurance.freenect_check [--seconds 8]
    (apt-get install libfreenect-bin umockdev gir1.2-umockdev-1.0)

`freenect-camtest` streams depth and colour: all frames of both must come in order, without a word of lost packets.
`fakenect-record` writes a dump, which is read here again: every depth and colour image must be the drawn one. So the
emulator, which judges this project's driver, is itself judged by foreign code. Ends with 1 where something differs.
"""

import argparse
import itertools
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

TESTS = Path(__file__).resolve().parents[2] / "tests" / "devices"
sys.path[:0] = [str(TESTS), str(TESTS / "emulator")]

import drawn  # noqa: E402
import emulated  # noqa: E402

STAMP, TICKS = 4_200_000_000, 2_000_000  # of the emulator's frames, see its stream.py
STRAY = re.compile(r"lost|sync|invalid|expected|drop|fail|error", re.IGNORECASE)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=8.0, help="how long each program streams")
    seconds = parser.parse_args().seconds
    why = emulated.missing() or ("" if shutil.which("freenect-camtest") else "apt-get install libfreenect-bin")
    if why:
        raise SystemExit(f"not run: {why}")
    return max(_camtest(seconds), _record(seconds))


def _told(command: list[str], seconds: float) -> str:
    """What a program says within so many seconds against an emulator of its own; it is then asked to stop."""
    with emulated.kinect() as environment:
        process = subprocess.Popen(
            ["stdbuf", "-oL", *command], env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
        try:
            return process.communicate(timeout=seconds)[0]
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGINT)
        try:
            return process.communicate(timeout=10)[0]
        except subprocess.TimeoutExpired:
            process.kill()
            return process.communicate()[0]


def _camtest(seconds: float) -> int:
    text = _told(["freenect-camtest"], seconds)
    bad = 0
    for kind in ("depth", "video"):
        stamps = [int(stamp) for stamp in re.findall(rf"Received {kind} frame at (\d+)", text)]
        steps = [(b - a) % 2**32 for a, b in itertools.pairwise(stamps)]
        skipped = sum(step != TICKS for step in steps)
        print(f"freenect-camtest: {len(stamps)} {kind} frames, {skipped} not the next one")
        bad += skipped + (len(stamps) < 2)
    words = [line for line in text.splitlines() if STRAY.search(line)]
    print(f"freenect-camtest: {len(words)} lines of trouble", *words[:5], sep="\n    ")
    return int(bool(bad or words))


def _record(seconds: float) -> int:
    with tempfile.TemporaryDirectory() as folder:
        text = _told(["fakenect-record", f"{folder}/dump"], seconds)
        depths, same = 0, 0
        rows = np.array([[drawn.depth(u, y) for u in range(drawn.WIDTH)] for y in range(480)], np.uint16)
        for path in sorted(Path(folder, "dump").glob("d-*.pgm")):
            data = path.read_bytes()
            if len(data) < 2 * rows.size:  # the one that was being written when it was stopped
                continue
            number = (int(path.stem.rpartition("-")[2]) - STAMP) % 2**32 // TICKS
            values = np.frombuffer(data[-2 * rows.size :], "<u2").reshape(rows.shape)
            depths += 1
            same += np.array_equal(values, np.roll(rows, -number, axis=0))
    print(f"fakenect-record: {depths} depth images, {same} of them the drawn ones")
    if not depths:
        print(*text.splitlines()[-8:], sep="\n    ")
    return int(depths == 0 or same != depths)


if __name__ == "__main__":
    raise SystemExit(main())
