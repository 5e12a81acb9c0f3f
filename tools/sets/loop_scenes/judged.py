"""One scene: run both programs on the recording, measure against the truth, rule."""

import json
import os
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tools.sets.judging.command import fusion
from tools.sets.loop_scenes import course, frames, words
from tools.sets.loop_scenes.course import Course, OffCourse
from tools.sets.loop_scenes.place.prints import Array
from tools.sets.loop_scenes.surface import Off, off

PROJECT = Path(__file__).resolve().parents[3]
RATIO = 0.7  # asked of the trajectory's error beside Open3D's
PLACED = 0.95  # of the frames with depth: leaving frames out is no way to a small error (guess)
DOUBLED = {
    False: 0.03,
    True: 0.01,
}  # [m] a surface farther off than that is a second one: of a room (asked), of a thing
TWICE = 0.05  # share of the mesh that may be (guess: thin things and far corners are never all right)
GROSS = {False: 0.25, True: 0.05}  # [m] of one camera's place (guess: a tenth of what it looks at)
# voxel and farthest depth [m] of Open3D: a room as in its examples and tools/reproduce/scans/tum_trajectory.py; before
# a thing the better of these two over 100 frames of seed 1
PEER = {False: (3.0 / 512, 4.0), True: (0.003, 1.5)}
FR1 = "rpy"


@dataclass(frozen=True)
class Truth:
    """Attributes:
    course: true poses at the frames' stamps.
    mesh: the true mesh, or None.
    returns: the end sees what the start saw; None: not known.
    middle, reach: [m] of a scanned thing; None and infinite for a room.
    """

    course: Course
    mesh: Path | None
    returns: bool | None
    middle: Array | None = None
    reach: float = float("inf")


@dataclass(frozen=True)
class Side:
    """What one program made of it; `wrong` where it ended without a course."""

    off: OffCourse | None
    mesh: Off | None
    seconds: float


@dataclass(frozen=True)
class Judged:
    """A scene; `misses`: what was asked and is not so, `alarms`: what the program warned of."""

    name: str
    frames: int
    with_depth: int
    placed: int
    own: Side
    peer: Side | None
    ratio: float
    misses: tuple[str, ...]
    alarms: tuple[str, ...]


def judged(name: str, recording: Path, truth: Truth, output: Path, only_fusion: bool) -> Judged:
    """Runs into `output`, which is made anew."""
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True)
    seen, thing = frames.read(recording), truth.middle is not None
    camera = [] if (recording / "camera.json").is_file() else ["--camera", "tum-fr1"]
    ran = fusion("reconstruct", recording, "-o", output / "fusion", *camera)
    (output / "terminal.txt").write_text(ran.terminal, encoding="utf-8")
    found = course.read(output / "fusion" / "trajectory.txt").at(seen.times)
    own = side(found, truth, seen, output / "fusion" / "mesh.ply", ran.seconds)
    peer, ratio = None, float("nan")
    if not only_fusion:
        seconds = followed(recording, output / "open3d", *PEER[thing])
        theirs = course.read(output / "open3d" / "trajectory.txt").at(seen.times)
        same = theirs.at(found.times) if len(found.times) > 2 else theirs  # over the frames that ours has placed
        peer = side(same, truth, seen, output / "open3d" / "mesh.ply", seconds)
        if own.off and peer.off:
            ratio = own.off.ate / peer.off.ate
    there = seen.with_depth()
    told = words.read(output / "fusion", ran)
    limit = DOUBLED[thing]
    facts = words.Facts(
        len(seen.times), len(found.times), int((~there).sum()), own.off.gap if own.off else None, limit,
        own.off.worst if own.off else float("inf"), GROSS[thing], truth.returns,
    )  # fmt: skip
    placed = len(found.at(seen.times[there]).times)
    misses = [
        *asked(own, ratio, peer is not None, placed / there.sum(), limit, truth),
        *words.disagreements(told, facts),
    ]
    return Judged(
        name, len(seen.times), int(there.sum()), len(found.times), own, peer, ratio, tuple(misses), told.alarms
    )


def asked(own: Side, ratio: float, beside: bool, placed: float, limit: float, truth: Truth) -> list[str]:
    """What was asked of course and mesh, and is not so."""
    if own.off is None:
        return ["no course"]
    out = []
    closes = truth.returns is not False
    if beside and closes and not ratio <= RATIO:
        out.append(f"error {ratio:.2f} times Open3D's, asked {RATIO}")
    if placed < PLACED:
        out.append(f"{placed:.0%} of the frames with depth placed, asked {PLACED:.0%}")
    if truth.returns and own.off.gap > limit:
        out.append(f"loop open by {1e3 * own.off.gap:.0f} mm, asked {1e3 * limit:.0f}")
    if truth.mesh and truth.returns and not (own.mesh and own.mesh.beyond <= TWICE):
        share = own.mesh.beyond if own.mesh else float("nan")
        out.append(f"{share:.1%} of the mesh off by more than {1e3 * limit:.0f} mm, asked {TWICE:.0%}")
    return out


def side(found: Course, truth: Truth, seen: frames.Frames, mesh: Path, seconds: float) -> Side:
    """Course and mesh against the truth; `found` holds frames of the recording alone."""
    true = truth.course.at(found.times)
    found = found.at(true.times)
    if len(found.times) < 3:
        return Side(None, None, seconds)
    last = int(np.abs(seen.times - found.times[-1]).argmin())
    apart = course.off_course(found, true, seen.points(last))
    limit = DOUBLED[truth.middle is not None]
    there = off(mesh, truth.mesh, apart.T_truth_found, limit, truth.middle, truth.reach) if truth.mesh else None
    return Side(apart, there, seconds)


def followed(recording: Path, output: Path, voxel: float, farthest: float) -> float:
    """Open3D's tracking; seconds of it alone."""
    command = [sys.executable, "-m", "tools.sets.loop_scenes.peer", *map(str, (recording, output, voxel, farthest))]
    begin = time.monotonic()
    where = os.environ | {"PYTHONPATH": os.pathsep.join([str(PROJECT), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=where)
    if done.returncode:
        print(f"Open3D ended with status {done.returncode}: {done.stderr.strip()[-300:]}", file=sys.stderr)
        return time.monotonic() - begin
    return float(json.loads((output / "peer.json").read_text(encoding="utf-8"))["seconds"])


def truth_of(folder: Path) -> Truth:
    """Of a made scene."""
    told: dict[str, Any] = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    middle = None if told["middle"] is None else np.array(told["middle"], float)
    reach = float("inf") if told["reach"] is None else float(told["reach"])
    return Truth(course.read(folder / "poses.txt"), folder / "mesh.ply", bool(told["returns"]), middle, reach)


def truth_of_fr1(recording: Path) -> Truth:
    """Motion capture at the stamps of the depth frames."""
    captured = course.read(recording / "groundtruth.txt")
    return Truth(captured.between(frames.read(recording).times), None, None)
