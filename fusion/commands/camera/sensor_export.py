"""`fusion sensor export` and `fusion sensor compare`: a model for other simulators, and two models side by side."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.errors import FusionError
from fusion.files.json_values import json_text

if TYPE_CHECKING:
    from fusion.geometry.camera import Camera
    from fusion.sensor.sensor import Sensor
    from fusion.simulation.exporting.compare import SensorComparison


def run_export(options: argparse.Namespace) -> None:
    """Write the model for another simulator, and print what is lost."""
    from fusion.sensor.files.sensor_file import read_sensor
    from fusion.simulation.exporting.export import export_sensor, table
    from fusion.simulation.exporting.targets import TARGETS

    if options.to is None or options.output is None:
        expected = f"--to {' | '.join(TARGETS)} and -o FILE"
        raise FusionError("it is not said where to", "fusion sensor export", expected=expected)
    sensor = read_sensor(options.sensor)
    made = export_sensor(sensor, options.to, _camera(options, sensor))
    with options.claim.file() as partial:
        partial.write_text(made.text, encoding="utf-8")
    loss = made.loss
    if options.json:
        numbers = {"output": str(options.output), "to": options.to, "parameters": made.parameters}
        numbers |= {"formula": made.target.formula, "source": made.target.source, "lost": list(loss.lost)}
        rows = {"depths": loss.depths, "rms": loss.rms, "without_export": loss.whole}
        rows |= {"own_bias": loss.own[:, 0], "own_sigma": loss.own[:, 1]}
        rows |= {"exported_bias": loss.exported[:, 0], "exported_sigma": loss.exported[:, 1]}
        numbers |= {name: _plain(values) for name, values in rows.items()}
        numbers |= {"effects": {name: _plain(values) for name, values in loss.effects.items()}}
        print(json_text(numbers))
        return
    given = ", ".join(f"{name} {value:.4g}" for name, value in made.parameters.items())
    print(f"{options.output}: {sensor.name} for {options.to}: {given}")
    print("\n".join([f"law       {made.target.formula}", f"source    {made.target.source}", "", *table(loss), ""]))
    for name, values in loss.effects.items():
        kept = "lost" if name in loss.lost else "kept as far as the law's form allows"
        sizes = ", ".join("-" if value != value else f"{1e3 * value:.2f}" for value in values)
        print(f"{name:<24} {kept}; alone {sizes} mm")
    if made.target.own:
        print(f"besides, {options.to} makes {made.target.own}")


def run_compare(options: argparse.Namespace) -> None:
    """Print the table of two sides, and write the page where one is asked for."""
    from fusion.recording.open import open_recording
    from fusion.sensor.files.sensor_file import read_sensor
    from fusion.simulation.exporting.compare import compare_recording, compare_sensors

    if options.other is None:
        expected = "two sensors, or a sensor and a recording"
        raise FusionError("there is nothing to compare with", "fusion sensor compare", expected=expected)
    one = read_sensor(options.sensor)
    place = Path(options.other)
    if place.exists() and (place.is_dir() or place.suffix != ".json"):
        recording = open_recording(place, options.camera)
        found, models, camera = compare_recording(one, recording), [one], recording.camera
    else:
        other = read_sensor(options.other)
        camera = _camera(options, one)
        found, models = compare_sensors(one, other, camera), [one, other]
    if options.output is not None:
        from fusion.report.comparisons.sensors import write_comparison_page

        with options.claim.folder() as partial:
            write_comparison_page(partial / "report.html", found, models, camera)
            (partial / "comparison.json").write_text(json_text(found) + "\n", encoding="utf-8")
    print(json_text(found) if options.json else "\n".join(_lines(found)))


def _camera(options: argparse.Namespace, sensor: "Sensor") -> "Camera":
    from fusion.recording.cameras.presets import find_camera
    from fusion.simulation.exporting.loss import usual_camera

    return usual_camera(sensor) if options.camera is None else find_camera(options.camera)


def _lines(found: "SensorComparison") -> list[str]:
    width = max(len(found.one.name), len(found.other.name), 26)
    lines = [f"{'':>6}  {found.one.name:<{width}}  {found.other.name:<{width}}"]
    part = f"{'mean':>8} {'spread':>8} {'missing':>8}"
    lines.append(f"{'[m]':>6}  {part:<{width}}  {part:<{width}}  apart [mm]")
    for row, depth in enumerate(found.depths):
        cells = []
        for side in (found.one, found.other):
            cell = f"{_mm(side.bias[row]):>8} {_mm(side.sigma[row]):>8} {100 * side.missing[row]:>6.1f} %"
            cells.append(f"{cell:<{width}}")
        lines.append(f"{depth:>6.2f}  {'  '.join(cells)}  {_mm(found.apart[row]):>8}".rstrip())
    for name, (a, b) in found.parameters.items():
        if a != b:
            lines.append(f"{name:<40} {_value(a):>12} {_value(b):>12}")
    return [*lines, *(f"note: {text}" for text in found.notes)]


def _mm(value: float) -> str:
    return "-" if value != value else f"{1e3 * value:.2f}"


def _value(value: float | None) -> str:
    return "-" if value is None else f"{value:.5g}"


def _plain(values: object) -> list[float | None]:
    import numpy as np

    return [float(value) if np.isfinite(value) else None for value in np.asarray(values, float)]
