"""Options that the reconstructing commands share."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number
from fusion.commands.options.results import add_output, add_topic
from fusion.compute.choice import DEVICES
from fusion.quantity import CORNER, TRUNCATION, VOXEL, Corners

if TYPE_CHECKING:
    from fusion.geometry.camera import Camera
    from fusion.sensor.sensor import Sensor

FIRST_CAMERA = "the first camera's frame (x right, y down, z forward)"


def add_common(parser: argparse.ArgumentParser, frame: str = FIRST_CAMERA) -> None:
    """Recording, output, sensor, camera, box and voxels; `frame` says where the box stands."""
    add = parser.add_argument
    add("recording", type=Path, metavar="REC", help="folder or file of the recording")
    add_output(parser, "folder for mesh.ply, trajectory.txt, ...")
    add("--sensor", metavar="S", help="sensor.json or a preset's name: corrects the depth and weighs it")
    add("--camera", metavar="C", help="camera.json, a preset's name or fx,fy,cx,cy, instead of the recording's own")
    add_topic(parser)
    add("--voxel", type=number(VOXEL), metavar="M", help="edge of a voxel [m]; default: from distance and focal length")
    add(
        "--truncation",
        type=number(TRUNCATION),
        metavar="M",
        help="half band around the surface [m]; default: from the noise",
    )
    add(
        "--box",
        type=number(CORNER),
        nargs=6,
        metavar=("X0", "Y0", "Z0", "X1", "Y1", "Z1"),
        help=f"keep only this box: its low and its high corner [m] in {frame}",
    )
    add("--no-color", action="store_true", help="leave the colours out, of the tracking too")
    add("--force", action="store_true", help="go on where the doctor says no, or with a sensor model of another camera")
    add("--device", choices=DEVICES, help="where the kernels run: auto is a card if one passes; FUSION_DEVICE, or cpu")
    add("--json", action="store_true", help="print one JSON object")


def shown_sensor(options: argparse.Namespace, camera: "Camera") -> "Sensor | None":
    """The model of `--sensor`; SensorError when it belongs to another camera and `--force` is not given."""
    from fusion.sensor.correction.unit import refuse_other_unit
    from fusion.sensor.files.sensor_file import read_sensor

    if options.sensor is None:
        return None
    sensor = read_sensor(options.sensor)
    refuse_other_unit(sensor, camera, options.force)
    return sensor


def shown_box(values: list[float] | None) -> Corners | None:
    """Two corners of `--box`."""
    return None if values is None else ((values[0], values[1], values[2]), (values[3], values[4], values[5]))


def shown_name(path: Path) -> str:
    """A recording's name for a title: the folder's, with the one above it where that alone says nothing."""
    path = path.resolve()
    general = path.name.lower() in ("scan", "recording", "rec", "depth", "data")
    return f"{path.parent.name}/{path.name}" if general and path.parent.name else path.name
