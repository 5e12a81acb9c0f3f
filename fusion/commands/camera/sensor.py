"""`fusion sensor`: a sensor model as a table or a page, for other simulators, or beside another one."""

import argparse
import shutil
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fusion.commands.camera.sensor_export import run_compare, run_export
from fusion.commands.camera.sensor_page import run_check, run_page
from fusion.commands.camera.sensor_units import run_units
from fusion.errors import FusionError
from fusion.files.json_values import json_text

if TYPE_CHECKING:
    from fusion.sensor.words.description import DescribedParameter, SensorDescription

EXAMPLE = "fusion sensor show kinect-v1"
NARROWEST, WIDEST = 80, 120
FURTHER = {"check": run_check, "page": run_page, "units": run_units}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    actions = "show one model, list those known by name, export one for another simulator, compare two, check whether "
    actions += "one says all that others need, make its page (Markdown) in a folder, or compare units of one camera"
    add("action", choices=("show", "list", "export", "compare", "check", "page", "units"), help=actions)
    units = (
        "units: a CSV file with columns sensor, unit, date (2026-11-26), or a folder with a sensor.json (camera.json, "
        "evaluation.json) in each folder, dates in their names"
    )
    add("sensor", nargs="?", metavar="S", help=f"sensor.json or a preset's name; {units}")
    add("other", nargs="?", metavar="B", help="compare: another sensor, or a recording in which nothing moves")
    add("--to", metavar="NAME", help="export: isaac, mujoco, gazebo, blenderproc or habitat")
    add(
        "--camera",
        metavar="FILE",
        help="export, compare, page: camera.json or a preset's name; default: the sensor's usual one",
    )
    add("-o", "--output", type=Path, metavar="OUT", help="export: the file; compare, page, units: a folder")
    add("--overwrite", action="store_true", help="replace an earlier result in OUT")
    add("--json", action="store_true", help="print one JSON object")


def check(options: argparse.Namespace) -> None:
    """What OUT is depends on the action. Raises FusionError where there is none."""
    options.folder = options.action in ("compare", "page", "units")
    if options.output is not None and options.action in ("show", "list", "check"):
        do = "leave it out"
        raise FusionError("nothing is written", "-o", options.output, "export, compare, page or units", do)
    if options.output is None and options.action == "page":
        raise FusionError("no folder for the page", "-o", "nothing", "a folder", "pass -o FOLDER")


def run(options: argparse.Namespace) -> int | None:
    """Print the model or the names; export, compare, check, make a page."""
    if options.action == "list":
        _list(options.json)
        return None
    if options.sensor is None:
        do = "see fusion sensor list"
        raise FusionError(
            "no sensor given", f"fusion sensor {options.action}", expected="a sensor.json or a preset's name", do=do
        )
    if options.action == "export":
        run_export(options)
        return None
    if options.action == "compare":
        run_compare(options)
        return None
    if options.action in FURTHER:
        return FURTHER[options.action](options)
    from fusion.sensor.files.sensor_file import read_sensor
    from fusion.sensor.words.description import description

    content = description(read_sensor(options.sensor))
    print(json_text(content) if options.json else "\n".join(table(content)))
    return None


def _list(as_json: bool) -> None:
    from fusion.sensor.presets import PRESETS, preset

    models = [preset(name) for name in PRESETS]
    if as_json:
        rows = {m.name: {"principle": m.principle, "sensor": m.sensor, "effects": len(m.effects)} for m in models}
        print(json_text(rows))
        return
    width = max(len(model.name) for model in models)
    for model in models:
        effects = f"{len(model.effects)} effect" + ("s" if len(model.effects) != 1 else "")
        print(f"{model.name:<{width}}  {model.principle:<16}  {effects:>10}  {model.sensor}")


def table(content: "SensorDescription", width: int | None = None) -> list[str]:
    """The lines of a model, 80 to 120 characters wide."""
    width = width or min(WIDEST, max(NARROWEST, shutil.get_terminal_size((100, 24)).columns))
    named = [content.sensor, content.serial and f"serial {content.serial}"]
    if content.principle.triangulates:
        named.append(f"baseline {abs(content.baseline_m):g} m")
    lines = [f"{content.name}: " + ", ".join(filter(None, [content.principle, *named]))]
    if content.gives_values:
        lines += textwrap.wrap(f"gives values: {content.gives_values}", width, subsequent_indent="  ")
    lines += ["", f"{'effect, parameter':<22}{'value':>13} {'std':>9}  {'unit':<6} meaning"]
    for effect in content.effects:
        lines.append(effect.effect)
        for name, row in effect.parameters.items():
            lines += _row(name, row, width)
        lines += _wrapped("source", effect.source or "not stated", width)
        if effect.not_corrected:
            lines += _wrapped("not corrected", effect.not_corrected, width)
    if not content.effects:
        lines.append("no effects: an ideal sensor")
    else:
        lines += ["", "std: how well the value is known (standard deviation); - where nobody says"]
    # what the effects above say already is not said again
    more = [text for text in content.left_out if ": not corrected (" not in text]
    for title, texts in (("left out", more), ("warning", content.warnings)):
        for text in texts:
            lines += textwrap.wrap(f"{title}: {text}", width, subsequent_indent=" " * (len(title) + 2))
    return lines


def _row(name: str, row: "DescribedParameter", width: int) -> list[str]:
    """`  name value std unit meaning`; a value that is too long for its column goes into lines of its own."""
    value, std = _number(row.value), _std(row.std)
    head = f"  {name:<20}"
    long = len(value) > 13 or len(std) > 9
    head += f"{'below' if long else value:>13} {'' if long else std:>9}  {row.unit:<6} "
    lines = textwrap.wrap(row.meaning, max(width - len(head), 20)) or [""]
    shown = [head + lines[0], *(" " * len(head) + line for line in lines[1:])]
    if long:
        text = value + ("" if std in ("exact", "-") else f" (std {std})")
        shown += textwrap.wrap(text, width, initial_indent=" " * 6, subsequent_indent=" " * 6)
    return [line.rstrip() for line in shown]


def _wrapped(title: str, text: str, width: int) -> list[str]:
    indent = " " * (len(title) + 4)
    return textwrap.wrap(f"  {title}: {text}", width, subsequent_indent=indent)


def _number(value: Any) -> str:
    from fusion.sensor.words.description import MapSummary

    if isinstance(value, MapSummary):
        shape = " x ".join(map(str, value.shape))
        return f"{shape} values, mean {value.mean:.4g}, rms {value.rms:.4g}"
    if isinstance(value, list):
        return ", ".join(_number(one) if not isinstance(one, list) else f"[{_number(one)}]" for one in value)
    return value if isinstance(value, str) else f"{value:.5g}"


def _std(std: Any) -> str:
    """How well a value is known: a number, exact, or - where nobody says."""
    if std is None:
        return "-"
    return ", ".join(map(_std, std)) if isinstance(std, list) else f"{std:.3g}" if std else "exact"
