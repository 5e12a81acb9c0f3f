"""`fusion demo`: the whole main job on an object that the program makes itself."""

import argparse
import json
from pathlib import Path

from fusion.commands.screen import took
from fusion.progress import seconds, stage

EXAMPLE = "fusion demo -o demo"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("-o", "--output", type=Path, default=Path("demo"), metavar="OUT", help="folder for everything (default: demo)")
    add("--frames", type=int, default=72, help="frames to simulate (default: 72)")
    add("--seed", type=int, default=0, help="of the simulated noise; the same seed gives the same bits")
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Simulate, correct, track, integrate, close the loop, integrate again, export, compare."""
    from fusion.commands import turntable
    from fusion.errors import FusionError
    from fusion.mesh.compare import CompareSettings, compare, write_comparison
    from fusion.mesh.files import read_mesh, write_mesh
    from fusion.output import output_folder
    from fusion.recording.open import open_recording
    from fusion.scan.pipeline import scan_turntable
    from fusion.scan.settings import ScanSettings
    from fusion.sensor.file import read_sensor
    from fusion.simulation.demo import write_demo_recording

    out = options.output
    if out.exists() and not out.is_dir():
        raise FusionError("the output is not a folder", out, "a file", "a folder or a new name", "choose another -o")
    if options.frames < 12:
        raise FusionError("too few frames for a turn", "--frames", options.frames, "12 or more")
    recording = open_recording(write_demo_recording(out / "simulated", options.seed, options.frames))
    scan = scan_turntable(recording, ScanSettings(sensor=read_sensor(out / "simulated" / "sensor.json")))
    truth = read_mesh(out / "simulated" / "truth.ply")
    with stage("comparing"):
        comparison = compare(scan.mesh, truth, CompareSettings(scale=True))
    with output_folder(out) as partial:
        write_mesh(partial / "truth.ply", truth)
        write_comparison(partial, comparison)
    turntable.write(out, recording, scan, comparison)
    numbers = turntable.summary(scan)
    numbers |= {"distance_rms_m": comparison.accuracy["rms"], "scale": comparison.scale}
    numbers |= {"seconds": seconds(), "output": str(out)}
    if options.json:
        print(json.dumps(numbers, indent=1))
        return
    found = f"{numbers['distance_rms_m'] * 1e3:.2f} mm rms, scale {comparison.scale:.5f}"
    shown = turntable.lines(scan)
    last = [f"truth     {found}", f"report    {out / 'report.html'}", f"took      {took(numbers['seconds'])}"]
    print("\n".join([*shown[:3], *last]))
