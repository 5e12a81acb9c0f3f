"""What a depth camera shows at which distance: the tables of docs/first_scan.md.

python -m tools.documentation.what_to_expect            writes the table of single pixels, from the sensor presets
python -m tools.documentation.what_to_expect --check    writes nothing; exit status 1 when that table is out of date
python -m tools.documentation.what_to_expect --scans    scans the demo's owl with every preset, minutes; prints
"""

import argparse
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

import fusion
from fusion.files.output.publish import atomic_file
from fusion.recording.cameras.presets import DEVICES
from fusion.sensor.presets import PRESETS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "first_scan.md"
START, END = "<!-- noise over distance: start -->\n", "<!-- noise over distance: end -->\n"
DISTANCES = (0.5, 0.7, 1.0, 1.5, 2.0, 3.0)  # [m]
SCANNED = (0.6, 1.0)  # [m]
FRAMES, TURNS = 44, 1.1  # 9 degrees a frame
CAMERAS = {
    "kinect-v1": fusion.find_camera("kinect-v1"),
    "kinect-v2-indoors": fusion.find_camera("kinect-v2"),
    "kinect-v2-sunlight": fusion.find_camera("kinect-v2"),
    **{name: fusion.find_camera(name) for name in PRESETS if name in DEVICES and name != "kinect-v1"},
}


def noise(name: str, distance: float) -> float:
    """Standard deviation [m] of one pixel in the middle, of one image of a light wall seen frontally."""
    camera = CAMERAS[name]
    wall = np.full(camera.shape, distance)
    sigma = fusion.read_sensor(name).sigma(wall, np.zeros(camera.shape), camera)
    return float(sigma[camera.height // 2, camera.width // 2])


def table() -> str:
    """Noise and size of a pixel over the distance, as Markdown."""
    rows = ["| sensor | " + " | ".join(f"{z:g} m" for z in DISTANCES) + " |", "|---" * (len(DISTANCES) + 1) + "|"]
    for name, camera in CAMERAS.items():
        cells = [f"{1e3 * noise(name, z):.1f} / {1e3 * z / camera.fx:.1f}" for z in DISTANCES]
        rows.append(f"| `{name}` | " + " | ".join(cells) + " |")
    return "\n".join(rows) + "\n"


def scans() -> Iterator[str]:
    """A line for each sensor and distance: rms [mm] of the owl's scan to the truth."""
    for distance in SCANNED:
        for name, camera in CAMERAS.items():
            if name.endswith("sunlight"):  # nobody scans in it
                continue
            try:
                yield f"{name} {distance} m: {_scan(name, camera, distance)}"
            except fusion.FusionError as error:
                yield f"{name} {distance} m: {error}"


def _scan(name: str, camera: fusion.Camera, distance: float) -> str:
    sensor = fusion.read_sensor(name)
    scene = fusion.built_in("turntable", {"frames": FRAMES, "turns": TURNS, "distance_m": distance})
    simulation = fusion.simulate(replace(scene, camera=camera), sensor, seed=1)
    with tempfile.TemporaryDirectory() as folder:
        fusion.write_simulation(folder, simulation)
        scan = fusion.scan_turntable(fusion.open_recording(folder), fusion.ScanSettings(sensor=sensor, color=False))
    found = fusion.compare(scan.mesh, simulation.truth_mesh)
    scale = fusion.compare(scan.mesh, simulation.truth_mesh, fusion.CompareSettings(scale=True)).scale
    within = found.accuracy.within["0.002"]
    return f"{1e3 * found.accuracy.rms:.2f} mm rms, {within:.1%} within 2 mm, size {1e2 * (1 / scale - 1):+.2f} %"


def written() -> str:
    """The page with the table of today."""
    before, start, rest = PAGE.read_text(encoding="utf-8").partition(START)
    _, end, after = rest.partition(END)
    return before + start + table() + end + after


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing, tell whether the table is out of date")
    parser.add_argument("--scans", action="store_true", help="scan the owl with every preset")
    options = parser.parse_args()
    if options.scans:
        for line in scans():
            print(line, flush=True)
        return 0
    page = written()
    if options.check:
        return int(page != PAGE.read_text(encoding="utf-8"))
    with atomic_file(PAGE) as partial:
        partial.write_text(page, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
