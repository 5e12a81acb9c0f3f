"""How often one goes back to a file while one follows a recording through `fusion.scan_turntable`.

Functions of fusion/scan and fusion/turntable are listed in the order in which a small scan first calls them, as a
reader would open them. Each file that is opened again after others is one return. Methods do not count: they are those
of an object that the reader has in hand.

python -m tools.reproduce.followed
python -m tools.reproduce.followed --list      the files in that order
"""

import argparse
import itertools
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from types import CodeType, FrameType
from typing import Any

from fusion.geometry.camera import Camera, Principle
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording
from fusion.recording.writing.write import write_recording
from fusion.scan.pipeline import scan_turntable
from fusion.scan.result import Scan
from fusion.scan.settings import ScanSettings
from fusion.sensor.presets import preset
from fusion.sensor.sensor import Sensor
from fusion.simulation.demo.demo import demo_scene
from fusion.simulation.scene.course import turning
from fusion.simulation.scene.turntable import Turntable
from fusion.simulation.simulate import simulate

FUSION = Path(__file__).resolve().parents[2] / "fusion"
CAMERA = Camera(
    160, 120, 156.0, 156.8, 80.2, 59.3, depth_scale=5000.0, principle=Principle.TIME_OF_FLIGHT, sensor="small"
)
FRAMES = 25
SETTINGS = ScanSettings(sensor=preset("kinect-v2-indoors"), voxel=0.005, truncation=0.018, color=False, use_log=False)


def small_recording(folder: Path) -> Recording:
    """The demo's object on a full turn in steps of 15 degrees, 160 x 120 pixels, without noise."""
    scene = demo_scene(FRAMES)
    course = turning(Turntable(degrees_per_frame=15.0, frames=FRAMES), scene.course.T_world_camera[0])
    simulation = simulate(replace(scene, camera=CAMERA, course=course), Sensor())
    frames = (replace(frame, color=None, ir=None) for frame in simulation.frames())
    write_recording(folder, CAMERA, frames, telemetry=simulation.telemetry)
    return open_recording(folder)


def followed(recording: Recording, settings: ScanSettings) -> tuple[Scan, list[str]]:
    """The scan, and the files of the scan and the turntable in the order in which one follows it through them."""
    seen: set[CodeType] = set()
    order: list[str] = []

    def call(frame: FrameType, event: str, _: Any) -> None:
        code = frame.f_code
        if event == "call" and code not in seen:
            seen.add(code)
            path = Path(code.co_filename)
            own = path.is_relative_to(FUSION / "scan") or path.is_relative_to(FUSION / "turntable")
            if own and code.co_qualname.isidentifier():
                order.append(path.relative_to(FUSION).as_posix())

    sys.setprofile(call)
    try:
        scan = scan_turntable(recording, settings)
    finally:
        sys.setprofile(None)
    return scan, [path for path, _ in itertools.groupby(order)]


def returns(files: Sequence[str]) -> int:
    """How many of these opened a file that had been open before."""
    return len(files) - len(set(files))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="the files in the order in which they are opened")
    options = parser.parse_args()
    with TemporaryDirectory() as folder:
        _, files = followed(small_recording(Path(folder) / "recording"), SETTINGS)
    if options.list:
        print("\n".join(files))
    print(f"{len(set(files))} files, opened {len(files)} times: {returns(files)} returns")
    return 0


if __name__ == "__main__":
    sys.exit(main())
