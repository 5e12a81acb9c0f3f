"""`fusion simulate --ideal`: perfect depth of any simulator becomes what a sensor would have made of it."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.errors import FusionError
from fusion.files.json_values import json_text

if TYPE_CHECKING:
    from fusion.recording.recording import Recording
    from fusion.simulation.ideal.recording import Further


def add_ideal_arguments(parser: argparse.ArgumentParser) -> None:
    """The options for other simulators' recordings."""
    group = parser.add_argument_group("perfect depth of another simulator, instead of a scene")
    add = group.add_argument
    add("--ideal", type=Path, metavar="REC", help="a recording of any format, without errors")
    normals = "folder with an image of normals for each frame, in the camera frame; default: from the depth"
    add("--normals", type=Path, metavar="FOLDER", help=normals)
    segments = "folder with an image of labels for each frame: finds weak edges, and what --reflectance tells of each"
    add("--segmentation", type=Path, metavar="FOLDER", help=segments)
    light = (
        "how much infrared comes back: a number from 0 to 1, a folder with images, a JSON file of labels "
        '{"1": 0.5}, or the word ir (IR images of an ideal sensor tell it); default: not known'
    )
    add("--reflectance", metavar="R", help=light)
    between = "folder with depth n times as fine along {}, one image a frame: tells where within pixels edges run"
    add("--rows", type=Path, metavar="FOLDER", help=between.format("rows; with --columns"))
    add("--columns", type=Path, metavar="FOLDER", help=between.format("columns; with --rows"))
    lit = "folder with a shadow pass for each frame: the share of each pixel that the sensor's projector reaches"
    add("--lit", type=Path, metavar="FOLDER", help=lit)


def run_ideal(options: argparse.Namespace) -> None:
    """Sense and write the recording."""
    from fusion.recording.open import open_recording
    from fusion.sensor.files.sensor_file import read_sensor
    from fusion.simulation.ideal.passes import passes_of
    from fusion.simulation.ideal.recording import fill_sensed

    if options.sensor is None:
        do = "name a sensor.json or a preset (fusion sensor list)"
        raise FusionError("perfect depth stays as it is without a sensor", "--ideal", "no --sensor", do=do)
    if options.set:
        raise FusionError("settings are for built-in scenes", "--set", options.set[0], do="leave them out with --ideal")
    if options.passes is not None:
        raise FusionError("passes are made of a scene", "--passes", options.ideal, do="leave them out with --ideal")
    sensor = read_sensor(options.sensor)
    recording = open_recording(options.ideal, options.camera)
    further, beside = _further(options, recording), passes_of(recording, sensor)
    if beside is not None:
        further = further.beside(beside)
    with options.claim.folder() as partial:
        unknown = fill_sensed(partial, recording, sensor, options.seed, further)
    if not options.quiet:
        there = "" if beside is None else f"the passes beside the recording are used: {', '.join(beside.held)}"
        notes = (there, *recording.warnings, *sensor.warnings, *unknown)
        sys.stderr.writelines(f"note: {text}\n" for text in notes if text)
    numbers = {"output": str(options.output), "ideal": str(options.ideal), "sensor": sensor.name, "seed": options.seed}
    if options.json:
        print(json_text({**numbers, "frames": len(recording), "not_known": unknown}))
    else:
        print(f"{options.output}: {len(recording)} frames of {options.ideal}, as {sensor.name} sees them")


def _further(options: argparse.Namespace, recording: "Recording") -> "Further":
    from dataclasses import replace

    from fusion.simulation.ideal.channels import channel

    if (options.rows is None) != (options.columns is None):
        found = "--rows" if options.columns is None else "--columns"
        raise FusionError("rows and columns belong together", "--ideal", f"{found} alone", "both or none")
    rows, columns, lit = (
        None if (folder := getattr(options, name)) is None else channel(folder, name, len(recording))
        for name in ("rows", "columns", "lit")
    )
    return replace(_surfaces(options, recording), rows=rows, columns=columns, lit=lit)


def _surfaces(options: argparse.Namespace, recording: "Recording") -> "Further":
    """Normals, labels and reflectance, as far as they are given."""
    from fusion.simulation.ideal.channels import channel, read_table
    from fusion.simulation.ideal.recording import Further

    frames = len(recording)
    normals = None if options.normals is None else channel(options.normals, "normals", frames)
    labels = None if options.segmentation is None else channel(options.segmentation, "segmentation", frames)
    said = options.reflectance
    if said is None:
        return Further(normals, labels)
    if said == "ir":
        return Further(normals, labels, from_ir=True)
    if Path(said).is_dir():
        return Further(normals, labels, channel(Path(said), "reflectance", frames))
    if said.endswith(".json"):
        if labels is None:
            raise FusionError("a table of labels needs labels", "--reflectance", said, do="give --segmentation FOLDER")
        return Further(normals, labels, table=read_table(Path(said)))
    try:
        value = float(said)
    except ValueError:
        value = -1.0
    if not 0 <= value <= 1:
        expected = "a number from 0 to 1, a folder, a JSON file or ir"
        raise FusionError("the reflectance cannot be used", "--reflectance", said, expected)
    return Further(normals, labels, value)
