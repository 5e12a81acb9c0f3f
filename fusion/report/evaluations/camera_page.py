"""One page of a gallery: a measured camera as Markdown with a picture, from its sensor model alone."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fusion.geometry.camera import Camera, Principle
from fusion.report.kit.palette import BLUE, new_figure, styled, to_svg
from fusion.sensor.files.contributed import shortcomings
from fusion.sensor.sensor import Sensor
from fusion.sensor.words.description import DescribedParameter, MapSummary, SensorDescription, description
from fusion.simulation.exporting.loss import stated
from fusion.simulation.exporting.target import StatedWall

COMMAND = "fusion sensor page"
WALL = "White walls, square to the camera, over the whole image"


KINDS = {
    Principle.STRUCTURED_LIGHT: "structured light",
    Principle.TIME_OF_FLIGHT: "time of flight",
    Principle.ACTIVE_STEREO: "active stereo",
    Principle.UNKNOWN: "of an unknown principle",
}


def camera_page(sensor: Sensor, camera: Camera, picture: str) -> str:
    """The text, beside a picture of that file name."""
    content = description(sensor)
    missing = shortcomings(sensor)
    if not content.gives_values:
        missing = ["range: between which depths it gives values", *missing]
    known = "## What is not known" + "\n\n" + "\n".join(f"- {text}" for text in missing) if missing else ""
    parts = [
        f"# {sensor.sensor or sensor.name}",
        f"Model `{sensor.name}`: {_kind(sensor)}. Computed for images of {camera.width} x {camera.height} pixels.",
        f"Gives values: {content.gives_values}." if content.gives_values else "",
        f"![mean error and spread over depth]({picture})",
        _over_depth(stated(sensor, camera)),
        f"{WALL}: the mean error, the spread of repeated frames, and pixels without a value.",
        "## Numbers",
        _numbers(content),
        known,
        _list("## What the model leaves out", content.left_out),
        f"Made by `{COMMAND}` from the model alone; the laws: [all effects](../effects/README.md).",
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def camera_picture(sensor: Sensor, camera: Camera) -> str:
    """Mean error and spread over depth, as SVG."""
    found = stated(sensor, camera)
    with styled():
        figure = new_figure(9.0, 3.0)
        for ax, values, name in zip(
            figure.subplots(1, 2), (found.mean_bias, found.rms_sigma), ("mean error", "spread"), strict=True
        ):
            ax.plot(found.depths, 1e3 * values, marker="o", color=BLUE, markersize=4)
            ax.set_xlabel("depth [m]")
            ax.set_ylabel(f"{name} [mm]")
        return to_svg(figure, "camera").replace("<svg", '<svg style="background:white"', 1)


def _kind(sensor: Sensor) -> str:
    base = sensor.principle.triangulates
    return KINDS[sensor.principle] + (f", baseline {1e3 * abs(sensor.baseline):.3g} mm" if base else "")


def _over_depth(found: StatedWall) -> str:
    rows = [
        [f"{depth:g}", _mm(bias), _mm(sigma), f"{100 * missing:.1f}"]
        for depth, bias, sigma, missing in zip(
            found.depths, found.mean_bias, found.rms_sigma, np.isnan(found.bias).mean(axis=1), strict=True
        )
    ]
    return _table(["depth [m]", "mean error [mm]", "spread [mm]", "missing [%]"], rows)


def _numbers(content: SensorDescription) -> str:
    rows = []
    for effect in content.effects:
        source = effect.source or "not stated"
        for name, row in effect.parameters.items():
            law = f"[{effect.effect}](../effects/{effect.effect}.md)"
            rows.append([law, name, _value(row.value), _std(row), row.unit, source])
            source = "the same"
    return _table(["effect", "parameter", "value", "std", "unit", "source"], rows)


def _value(value: Any) -> str:
    if isinstance(value, MapSummary):
        return f"map {' x '.join(map(str, value.shape))}, rms {value.rms:.3g}"
    return (
        ", ".join(map(_value, value))
        if isinstance(value, list)
        else f"{value:.5g}"
        if isinstance(value, float)
        else str(value)
    )


def _std(row: DescribedParameter) -> str:
    std = row.std
    return "" if not row.unit else "not stated" if std is None else "exact" if std == 0 else _value(std)


def _mm(value: float) -> str:
    return "-" if not np.isfinite(value) else f"{1e3 * value + 0.0:.2f}".replace("-0.00", "0.00")


def _list(title: str, texts: Sequence[str]) -> str:
    return "\n\n".join([title, "\n".join(f"- {text}" for text in texts)]) if texts else ""


def _table(head: list[str], rows: list[list[str]]) -> str:
    cells = [head, ["---"] * len(head), *([cell.replace("|", "/") for cell in row] for row in rows)]
    return "\n".join("| " + " | ".join(row) + " |" for row in cells)
