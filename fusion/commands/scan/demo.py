"""`fusion demo`: the whole main job on an object that the program makes itself."""

import argparse
from dataclasses import replace

from fusion.commands.options.numbers import whole_number
from fusion.commands.options.results import add_output, made
from fusion.commands.terminal.screen import took
from fusion.files.json_values import json_text
from fusion.progress import seconds, stage
from fusion.quantity import FRAMES, SEED

EXAMPLE = "fusion demo -o demo"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add_output(parser, "folder for everything (default: demo)", default="demo")
    add("--frames", type=whole_number(FRAMES), default=72, help="frames to simulate (default: 72)")
    add(
        "--seed",
        type=whole_number(SEED),
        default=0,
        help="of the simulated noise; the same seed gives the same bits",
    )
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Simulate, correct, track, integrate, close the loop, integrate again, export, compare."""
    from fusion.commands.scan import turntable
    from fusion.mesh.comparison.compare import CompareSettings, compare, write_comparison
    from fusion.mesh.files import read_mesh, write_mesh
    from fusion.recording.open import open_recording
    from fusion.scan.pipeline import scan_turntable
    from fusion.scan.settings import ScanSettings
    from fusion.sensor.files.sensor_file import read_sensor
    from fusion.simulation.demo.demo import fill_demo_recording

    out = options.output
    with options.claim.folder() as partial:
        (partial / "simulated").mkdir()
        recording = open_recording(fill_demo_recording(partial / "simulated", options.seed, options.frames))
        scan = scan_turntable(recording, ScanSettings(sensor=read_sensor(partial / "simulated" / "sensor.json")))
        truth = read_mesh(partial / "simulated" / "truth.ply")
        with stage("comparing"):
            comparison = compare(scan.mesh, truth, CompareSettings(scale=True, near=True))
        write_mesh(partial / "truth.ply", truth)
        write_comparison(partial, comparison)
        # told under the name that it will have
        recording = replace(recording, path=out / "simulated" / "recording")
        turntable.fill(partial, recording, scan, comparison, page=options.report)
    numbers = turntable.summary(scan)
    numbers |= {"distance_rms_m": comparison.accuracy.rms, "scale": comparison.scale}
    numbers |= {"seconds": seconds(), "output": str(out)}
    if options.json:
        print(json_text(numbers))
        return
    found = f"{numbers['distance_rms_m'] * 1e3:.2f} mm rms, scale {comparison.scale:.5f}"
    shown = turntable.lines(scan)
    last = [f"truth     {found}", *made(options, "report"), f"took      {took(numbers['seconds'])}"]
    print("\n".join([*shown[:4], *last]))
