"""Writes docs/cameras/, the gallery: a page for each preset, and for each model that others have measured.

python -m tools.documentation.cameras            all pages and pictures
python -m tools.documentation.cameras --text     without the pictures
python -m tools.documentation.cameras --check    writes nothing; tells which texts are out of date, exit status 1

A contributed model is a `sensor.json` in docs/cameras/contributed/, under the name of its camera. It is refused where
`fusion sensor check` finds that something is missing that others need.
"""

import argparse
import sys
from pathlib import Path

from fusion.files.output.publish import atomic_file
from fusion.report.evaluations.camera_page import camera_page, camera_picture
from fusion.sensor.files.contributed import shortcomings
from fusion.sensor.files.sensor_file import read_sensor
from fusion.sensor.presets import PRESETS, preset
from fusion.sensor.sensor import Sensor
from fusion.simulation.exporting.loss import usual_camera

PROJECT = Path(__file__).resolve().parents[2]
PAGES = Path("docs/cameras")
CONTRIBUTED = PAGES / "contributed"
HEAD = """# Cameras

What the sensor models say of each camera, made from the models alone: mean error and spread over depth, every number
with its standard deviation and its source, and what is not known. The presets come from papers and data sheets; a model
that was measured is better, and one's own best of all ([calibration](../calibration.md)).
"""
TAIL = """
To add a camera that you have measured: `fusion sensor check sensor.json` says what others need and is missing, and
`fusion sensor page sensor.json -o FOLDER` makes its page. Put the file into `contributed/` and run
`python -m tools.documentation.cameras`.
"""


def models() -> dict[str, Sensor]:
    """Presets and contributed models, by the name of their page. Raises SystemExit where one is not complete."""
    found = {name: preset(name) for name in PRESETS}
    for path in sorted((PROJECT / CONTRIBUTED).glob("*.json")):
        sensor = read_sensor(path)
        if missing := shortcomings(sensor):
            raise SystemExit(f"{CONTRIBUTED / path.name} is not complete: {missing[0]}")
        found[path.stem] = sensor
    return found


def texts(sensors: dict[str, Sensor]) -> dict[Path, str]:
    """Every text that is made, by its path in the project."""
    made = {PAGES / f"{n}.md": camera_page(sensor, usual_camera(sensor), f"{n}.svg") for n, sensor in sensors.items()}
    rows = [f"| [{name}]({name}.md) | {one.sensor} | {one.principle} | {_open(one)} |" for name, one in sensors.items()]
    table = ["| model | camera | principle | numbers without a deviation or source |", "|---|---|---|---|", *rows]
    return {**made, PAGES / "README.md": HEAD + "\n" + "\n".join(table) + "\n" + TAIL}


def _open(sensor: Sensor) -> str:
    return str(len(shortcomings(sensor)) or "none")


def out_of_date(made: dict[Path, str]) -> list[str]:
    """What differs from the files of the project, one line each."""
    found = []
    for path, content in made.items():
        file = PROJECT / path
        if not file.exists() or file.read_text(encoding="utf-8") != content:
            found.append(f"{path} is {'out of date' if file.exists() else 'missing'}")
        if path.name != "README.md" and not file.with_suffix(".svg").exists():
            found.append(f"{path.with_suffix('.svg')} is missing")
    names = {path.stem for path in made}
    there = sorted(path for path in (PROJECT / PAGES).glob("*.*") if path.stem not in names)
    return found + [f"{PAGES / path.name} belongs to no model" for path in there]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--text", action="store_true", help="leave the pictures as they are")
    parser.add_argument("--check", action="store_true", help="write nothing, tell what is out of date")
    options = parser.parse_args()
    sensors = models()
    made = texts(sensors)
    if options.check:
        found = out_of_date(made)
        print("\n".join([*found, "run: python -m tools.documentation.cameras"] if found else ["up to date"]))
        return bool(found)
    (PROJECT / CONTRIBUTED).mkdir(parents=True, exist_ok=True)
    for path, content in made.items():
        with atomic_file(PROJECT / path) as partial:
            partial.write_text(content, encoding="utf-8")
    for name, sensor in sensors.items() if not options.text else ():
        with atomic_file(PROJECT / PAGES / f"{name}.svg") as partial:
            partial.write_text(camera_picture(sensor, usual_camera(sensor)), encoding="utf-8")
    print(f"{len(sensors)} cameras in {PAGES}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
