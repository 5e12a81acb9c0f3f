"""Kills commands at random moments and counts the results that were lost.

    python -m tools.endurance.kills --kills 200

Each run writes to a new place, or over an earlier result (by turns), and gets SIGKILL, SIGTERM or SIGINT at a moment
that is drawn from its usual duration. Afterwards its output must be wholly what it was before or wholly new, and
nothing may lie beside it but what the next run sweeps away.
"""

import argparse
import hashlib
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from fusion.files.output.claim import MARK
from fusion.files.output.staging import sweep

START = "from fusion.commands.console import run; raise SystemExit(run())"
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
CAMERA = (
    '{"width": 160, "height": 120, "fx": 144, "fy": 144, "cx": 79.5, "cy": 59.5, "depth_scale": 5000,'
    ' "principle": "structured_light"}'
)
MADE = "simulate wall --set distance_m=0.8,1.2,1.6 --set frames=6 --camera camera.json --sensor kinect-v1 -o walls"
COMMANDS = {
    "simulate": "walls/scene.json --camera camera.json --sensor kinect-v1 -o OUT",
    "convert": "walls OUT",
    "evaluate": "walls -o OUT",
    "compare": "walls/scene.ply walls/scene.ply -o OUT --no-report",
    "reconstruct": "walls --poses stated --voxel 0.02 -o OUT --no-report",
}
State = dict[str, str]


@dataclass
class Tried:
    """One command: how long it takes, its result, and what became of its kills."""

    name: str
    seconds: float
    result: State
    repeatable: bool
    ends: Counter[str] = field(default_factory=Counter)
    lost: list[str] = field(default_factory=list)
    said: list[str] = field(default_factory=list)


def main() -> int:
    """Kill, judge, print; 1 when something was lost."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200, help="over all commands (default: 200)")
    parser.add_argument("--seed", type=int, default=0, help="of the moments and signals")
    options = parser.parse_args()
    rng = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "camera.json").write_text(CAMERA)
        _finish(_start(folder, MADE))
        tried = [_whole(folder, command) for command in COMMANDS]
        before = _state(folder / "walls")
        for number in range(options.kills):
            one = tried[number % len(tried)]
            _kill(folder, one, rng.choice(SIGNALS), rng.random(), over=bool(number // len(tried) % 2))
        if _state(folder / "walls") != before:
            tried[0].lost.append("the input was changed")
    _print(tried)
    return int(any(one.lost for one in tried))


def _start(folder: Path, words: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", START, *words.split()]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def _finish(process: subprocess.Popen[str]) -> None:
    said = process.communicate()[1]
    if process.returncode:
        raise SystemExit(said)


def _words(name: str) -> str:
    return f"{name} {COMMANDS[name].replace('OUT', f'{name}/out')} --overwrite --quiet"


def _whole(folder: Path, name: str) -> Tried:
    """Two runs to the end; the second, over the first, tells the time it takes."""
    _finish(_start(folder, _words(name)))
    first = _state(folder / name / "out")
    begin = time.perf_counter()
    _finish(_start(folder, _words(name)))
    seconds, second = time.perf_counter() - begin, _state(folder / name / "out")
    shutil.copytree(folder / name / "out", folder / name / "kept")
    for path in (folder / name / "kept").rglob("*"):
        if path.is_file() and path.name != MARK:
            path.write_bytes(path.read_bytes() + b"older")
    return Tried(name, seconds, second, first == second)


def _kill(folder: Path, one: Tried, number: signal.Signals, moment: float, over: bool) -> None:
    place = folder / one.name
    shutil.rmtree(place / "out", ignore_errors=True)
    if over:
        shutil.copytree(place / "kept", place / "out")
    before = _state(place / "out")
    process = _start(folder, _words(one.name))
    time.sleep(1.05 * moment * one.seconds)
    process.send_signal(number)
    said = process.communicate()[1]
    at = f"{one.name}, {number.name} after {1.05 * moment * one.seconds:.3f} s, {'over' if over else 'new'}"
    state = _state(place / "out")
    if state == before:
        one.ends["as before"] += 1
    elif state == one.result or (not one.repeatable and set(state) == set(one.result) and not _mixed(state, before)):
        one.ends["new"] += 1
    else:
        one.lost.append(at)
    left = sorted(path.name for path in place.iterdir() if path.name not in ("out", "kept"))
    one.ends["left a .partial"] += bool(left)
    sweep(place)
    if {path.name for path in place.iterdir()} - {"out", "kept"} or (left and number != signal.SIGKILL):
        one.lost.append(f"{at}: left {left}, status {process.returncode}, said {said.strip()[-300:]!r}")
    if number != signal.SIGKILL and said.count("\n") > 1:
        one.said.append(f"{at}: {said.strip().splitlines()[-1]}")


def _state(folder: Path) -> State:
    """Every file, byte by byte but for dates and durations; empty where there is no folder."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {os.fspath(path.relative_to(folder)): _digest(path.read_bytes()) for path in files}


def _digest(data: bytes) -> str:
    return hashlib.sha256(re.sub(rb'"seconds": \{[^}]*\}|on [\d-]+ [\d:]+ UTC', b"", data)).hexdigest()


def _mixed(state: State, before: State) -> bool:
    return any(state[name] == value for name, value in before.items() if name != MARK and name in state)


def _print(tried: list[Tried]) -> None:
    for one in tried:
        ends = ", ".join(f"{count} {what}" for what, count in sorted(one.ends.items()))
        same = "byte by byte" if one.repeatable else "by its files: two runs differ in some bytes"
        print(f"{one.name:<12} {one.seconds:.1f} s; {ends}; {len(one.lost)} lost (a new one judged {same})")
    for text in [text for one in tried for text in one.lost]:
        print(f"LOST         {text}")
    for text in [text for one in tried for text in one.said]:
        print(f"more than a line: {text}")
    kills = sum(one.ends["as before"] + one.ends["new"] for one in tried)
    print(f"{kills} kills, {sum(len(one.lost) for one in tried)} lost")


if __name__ == "__main__":
    raise SystemExit(main())
