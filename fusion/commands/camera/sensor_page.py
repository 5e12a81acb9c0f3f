"""`fusion sensor check` and `fusion sensor page`: a measured model for others, and its page in a gallery."""

import argparse
import re

from fusion.files.json_values import json_text


def run_check(options: argparse.Namespace) -> int:
    """Print what a model does not say; 1 where it is something."""
    from fusion.sensor.files.contributed import shortcomings
    from fusion.sensor.files.sensor_file import read_sensor

    sensor = read_sensor(options.sensor)
    found = shortcomings(sensor)
    if options.json:
        print(json_text({"name": sensor.name, "complete": not found, "missing": found}))
    else:
        told = [*found, f"{sensor.name}: {len(found)} things are missing that others need"]
        print("\n".join(told if found else [f"{sensor.name}: complete"]))
    return int(bool(found))


def run_page(options: argparse.Namespace) -> int:
    """Write the page and its picture."""
    from fusion.recording.cameras.presets import find_camera
    from fusion.report.evaluations.camera_page import camera_page, camera_picture
    from fusion.sensor.files.sensor_file import read_sensor
    from fusion.simulation.exporting.loss import usual_camera

    sensor = read_sensor(options.sensor)
    camera = usual_camera(sensor) if options.camera is None else find_camera(options.camera)
    name = re.sub(r"[^A-Za-z0-9_.-]+", "_", sensor.name) or "camera"
    with options.claim.folder() as partial:
        (partial / f"{name}.md").write_text(camera_page(sensor, camera, f"{name}.svg"), encoding="utf-8")
        (partial / f"{name}.svg").write_text(camera_picture(sensor, camera), encoding="utf-8")
    told = {"page": str(options.output / f"{name}.md"), "picture": str(options.output / f"{name}.svg")}
    print(json_text(told) if options.json else f"page      {told['page']}")
    return 0
