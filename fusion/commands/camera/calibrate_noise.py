"""`fusion calibrate noise`: a flat target at several distances and tilts becomes noise and dropout laws."""

import argparse
import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fusion.commands.options.results import add_output, add_topic, made
from fusion.files.json_values import json_text
from fusion.progress import stage

if TYPE_CHECKING:
    from fusion.calibration.noise.calibration import NoiseCalibration
    from fusion.calibration.noise.laws.fit import NoiseFit

EXAMPLE = "fusion calibrate noise target_* --sensor calibrated/sensor.json -o noise"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("recordings", type=Path, nargs="+", metavar="REC", help="a still target each, or one after the other in one")
    add_output(parser, "folder for sensor.json and report.html")
    add("--camera", metavar="C", help="calibrated camera.json, a preset's name or fx,fy,cx,cy")
    add_topic(parser)
    add("--sensor", metavar="S", help="sensor.json or a preset's name: what is already known, depth errors above all")
    add("--force", action="store_true", help="take recordings or models of another camera")
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Calibrate and write sensor.json and report.html."""
    from fusion.calibration.noise.calibration import NoiseSettings, calibrate_noise
    from fusion.recording.open import open_recording, stated_camera
    from fusion.sensor.files.sensor_file import read_sensor

    settings = NoiseSettings(
        camera=stated_camera(options.camera, options.recordings[0], options.topic),
        sensor=None if options.sensor is None else read_sensor(options.sensor),
        force=options.force,
    )
    found = calibrate_noise([open_recording(path, topic=options.topic) for path in options.recordings], settings)
    told = {"camera": options.camera or "recordings'", "sensor": options.sensor or "none"}
    with options.claim.folder() as partial:
        fill(partial, found, told if options.report else None)
    numbers = summary(found)
    if options.json:
        print(json_text(numbers | {"output": str(options.output)}))
    else:
        print("\n".join([*_lines(numbers), *made(options, "sensor", "report")]))


def fill(folder: Path, found: "NoiseCalibration", settings: Mapping[str, object] | None) -> None:
    """sensor.json with its maps, and report.html with the settings if any, into a folder."""
    from fusion.report.calibrations.noise_calibration import noise_report
    from fusion.sensor.files.sensor_file import write_sensor

    write_sensor(folder / "sensor.json", found.sensor)
    if settings is not None:
        with stage("report"):
            noise_report(folder / "report.html", found, "fusion " + " ".join(sys.argv[1:]), settings)


def summary(found: "NoiseCalibration") -> dict[str, Any]:
    """The numbers that a caller wants first; lengths in metres."""
    from fusion.sensor.effects.readout.axial_noise import AxialNoise
    from fusion.sensor.effects.readout.lateral_noise import LateralNoise

    axial, lateral = found.axial, found.lateral
    numbers: dict[str, Any] = {
        "axial": _fit(axial.best, AxialNoise) | {"candidates": {fit.form.title: fit.score for fit in axial.fits}},
        "lateral": None
        if lateral is None
        else _fit(lateral.best, LateralNoise)
        | {
            "candidates": {fit.form.title: fit.score for fit in lateral.fits},
            "percentile_90_m": _number(lateral.percentile),
            "percentile_90_shadow_m": _number(lateral.percentile_shadow),
            "shadow": None if lateral.shadow is None else _fit(lateral.shadow, LateralNoise),
        },
        "dropout": None
        if found.dropout is None
        else dict(zip(("ir_threshold", "width"), found.dropout.numbers, strict=True)),
        "poses": [_pose(pose) for pose in found.poses],
        "not_seen": axial.visible.hidden,
        "kept": axial.kept,
        "notes": [text for _, text in found.notes],
    }
    return numbers


def _fit(fit: "NoiseFit", effect: Any) -> dict[str, Any]:
    from fusion.sensor.words.quantity import fitted

    wide = fit.half_width()
    return {
        "law": fit.form.title,
        "parameters": {
            name: {**fitted(effect, name, value, std), "interval_90": [value - wide * std, value + wide * std]}
            for name, value, std in zip(fit.form.names, fit.numbers, fit.std, strict=True)
        },
        "correlation": fit.correlation.tolist(),
        "rms": fit.rms,
        "heldout_error": _number(fit.score),
        "scatter_share": fit.scatter,
    }


def _pose(pose: Any) -> dict[str, Any]:
    seen = pose.seen
    return {
        "name": pose.name,
        "frames": seen.frames,
        "distance_m": pose.depth,
        "tilt_rad": pose.tilt,
        "axial_m": _number(pose.axial),
        "axial_std_m": _number(pose.axial_std),
        "lateral_m": [_number(x) for x in seen.lateral],
        "shadowed": list(pose.shadowed),
        "valid": seen.valid,
        "no_data": seen.no_data,
        "outliers": seen.outliers,
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _lines(numbers: dict[str, Any]) -> list[str]:
    axial, lateral = numbers["axial"], numbers["lateral"]
    lines = [f"axial     {axial['law']}, of {len(axial['candidates'])}; {axial['rms'] * 1e3:.3f} mm rms left over"]
    lines += _rows(axial["parameters"])
    if lateral is not None:
        lines.append(f"lateral   {lateral['law']}")
        lines += _rows(lateral["parameters"])
        for name, text in (
            ("percentile_90_m", "90 % of the edges below"),
            ("percentile_90_shadow_m", "beside a shadow"),
        ):
            lines += [f"  {text} {lateral[name] * 1e3:.2f} mm"] if lateral[name] is not None else []
    return [
        *lines,
        *(f"note      {text}" for text in numbers["notes"]),
    ]


def _rows(fitted_numbers: dict[str, Any]) -> list[str]:
    from fusion.sensor.words.quantity import shown

    known = {name: (p["value"], p["std"], p["unit"], p["determined"]) for name, p in fitted_numbers.items()}
    return [f"  {name:<15} {shown(*one)}" for name, one in known.items()]
