"""`fusion simulate`: a recording as a sensor would have made it; the same seed, the same bits."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import whole_number
from fusion.commands.recording.simulate_ideal import add_ideal_arguments, run_ideal
from fusion.errors import FusionError
from fusion.files.json_values import json_text
from fusion.quantity import FINER, SEED

if TYPE_CHECKING:
    from fusion.simulation.scene.scene import Scene

EXAMPLE = "fusion simulate wall --set distance_m=0.8,1.2 -o rec --sensor kinect-v1 --seed 1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("scene", nargs="?", metavar="SCENE", help="scene.json, a recording's folder, or a name that --list prints")
    add("-o", "--output", type=Path, metavar="REC", help="folder of the new recording")
    add("--overwrite", action="store_true", help="replace an earlier simulation in REC")
    add("--sensor", metavar="S", help="sensor.json or a preset's name; default: one without any error")
    add("--seed", type=whole_number(SEED), default=0, help="of every random number (default: 0)")
    add("--camera", metavar="FILE", help="camera.json or a preset's name, instead of the scene's or recording's own")
    add_ideal_arguments(parser)
    passes = (
        "what stood before the sensor, into REC/truth/passes for --ideal: perfect depth, normals, reflectance, what "
        "its projector lights; N: depth N times as fine along rows and columns too (64: as the simulator sees edges)"
    )
    add("--passes", type=whole_number(FINER), nargs="?", const=1, metavar="N", help=passes)
    add("--set", action="append", default=[], metavar="NAME=VALUE", help="a setting of a built-in scene; repeatable")
    parser.set_defaults(folder=True)
    add("--list", action="store_true", help="print the built-in scenes; with SCENE its settings")
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> int | None:
    """Simulate and write the recording."""
    if options.list:
        _list(options.scene, options.json)
        return None
    if (options.scene is None) == (options.ideal is None) or options.output is None:
        sys.stderr.write("fusion simulate: a scene (or --ideal) and -o REC are needed (see --list and --help)\n")
        return 2
    if options.ideal is not None:
        run_ideal(options)
        return None
    from fusion.sensor.files.sensor_file import read_sensor
    from fusion.sensor.sensor import Sensor
    from fusion.simulation.ideal.passes import write_passes
    from fusion.simulation.simulate import simulate
    from fusion.simulation.write import fill_simulation

    sensor = Sensor() if options.sensor is None else read_sensor(options.sensor)
    simulation = simulate(_scene(options), sensor, options.seed)
    total = len(simulation)
    with options.claim.folder() as partial:
        missed = fill_simulation(partial, simulation)
        if options.passes is not None:
            write_passes(partial, simulation, options.passes)
    sensor = simulation.sensor
    if not options.quiet:
        notes = (*missed, *sensor.warnings, *(text for text in sensor.left_out if "not computed" in text))
        sys.stderr.writelines(f"note: {text}\n" for text in notes)
    numbers: dict[str, object] = {"output": str(options.output), "scene": simulation.scene.name, "sensor": sensor.name}
    numbers |= {"seed": options.seed, "frames": total}
    if options.json:
        print(json_text(numbers))
    else:
        print(f"{options.output}: {total} frames of {simulation.scene.name}, as {sensor.name} sees it")
    return None


def _scene(options: argparse.Namespace) -> "Scene":
    """The scene with its settings, and with another camera where one is given."""
    from dataclasses import replace

    from fusion.recording.cameras.presets import find_camera
    from fusion.simulation.scene.scene_file import read_scene
    from fusion.simulation.scenes import SCENES, built_in

    settings = {}
    for text in options.set:
        name, separator, value = text.partition("=")
        if not separator:
            raise FusionError("a setting cannot be read", "--set", text, "NAME=VALUE")
        settings[name.strip()] = value.strip()
    path = Path(options.scene)
    if options.scene in SCENES or not (path.exists() or path.suffix):
        scene = built_in(options.scene, settings)
    elif settings:
        raise FusionError("settings are for built-in scenes", "--set", path, do="change the scene file instead")
    else:
        notes: list[str] = []
        scene = read_scene(path, notes)
        if not options.quiet:
            sys.stderr.writelines(f"note: {note}\n" for note in notes)
    return scene if options.camera is None else replace(scene, camera=find_camera(options.camera))


def _list(name: str | None, as_json: bool) -> None:
    """Every scene in one line; of one scene its settings too."""
    from fusion.simulation.scenes import SCENES, about, settings_of

    if name is not None and name not in SCENES:
        raise FusionError("no such scene", "--list", name, "one of " + ", ".join(SCENES))
    names = list(SCENES) if name is None else [name]
    if as_json:
        print(json_text({name: {"about": about(name), "settings": settings_of(name)} for name in names}))
        return
    width = max(map(len, names))
    for each in names:
        print(f"{each:<{width}}  {about(each)}")
    if name is None:
        print("\nfusion simulate SCENE --list prints the settings of one of them")
        return
    for key, value in settings_of(name).items():
        print(f"  --set {key}={_shown(value)}")


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return ",".join(f"{part:g}" for part in value)
    return f"{value:g}" if isinstance(value, float) else str(value)
