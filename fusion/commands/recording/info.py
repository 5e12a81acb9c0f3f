"""`fusion info`: what is in a recording, and what looks wrong with it."""

import argparse
import math
from datetime import UTC, datetime
from pathlib import Path

from fusion.commands.options.results import add_topic
from fusion.files.json_values import json_text

SINCE_1970 = (1e9, 4e9)  # [s] September 2001 to 2096: no device's own clock runs that long
SHOWN = 24  # settings on the terminal
EXAMPLE = "fusion info my_scan --json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    parser.add_argument("recording", type=Path, metavar="REC", help="folder or file of the recording")
    parser.add_argument(
        "--camera", metavar="FILE", help="camera.json, a preset's name or fx,fy,cx,cy, instead of the recording's own"
    )
    add_topic(parser)
    parser.add_argument(
        "--quick", action="store_true", help="leave out the check of the focal length that a turntable recording allows"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> int:
    """Print what is in the recording; 1 when something in it cannot be used."""
    from fusion.recording.looking.inspect import CHECKS, inspect
    from fusion.recording.open import open_recording

    recording = open_recording(options.recording, options.camera, options.topic)
    if options.quick:
        checks = CHECKS
    else:  # the turntable's check stands in a room further down
        from fusion.scan.judging.focal_doctor import check_focal_length

        checks = (*CHECKS, check_focal_length)
    findings = inspect(recording, checks)
    if options.json:
        print(json_text(findings.to_dict()))
    else:
        print("\n".join(_lines(findings.to_dict())))
    return int(findings.severity == "error")


def _lines(content: dict) -> list[str]:
    camera, rate = content["camera"], content["frames_per_second"]
    frames = f"{content['frames']} frames of {camera['width']} x {camera['height']}"
    lines = [
        f"{content['path']}: {content['format']}, {frames}, {content['duration_s']:.2f} s"
        + (f", {rate:.2f} frames a second" if rate else ""),
        f"camera: {_lens(camera)}, {_unit(content)}, {camera['sensor'] or 'sensor not named'}, {camera['principle']}",
        *_color_camera(camera),
        *_clock(content["clock_s"]),
        f"colour frames: {content['color_frames']}, IR frames: {content['ir_frames']}, "
        f"stated poses: {content['poses']}, telemetry: {', '.join(content['telemetry']) or 'none'}",
    ]
    if content["settings"]:
        lines.append(f"settings: {_settings(content['settings'])}")
    if content["depth_range_m"]:
        low, high = content["depth_range_m"]
        valid = content.get("valid_share")
        share = "" if valid is None else f", {100 * valid:.1f} % of the pixels valid"
        lines.append(f"depth: {low:.3f} to {high:.3f} m (1st to 99th percentile){share}")
    for finding in content["findings"]:
        do = f" -> {finding['do']}" if finding["do"] else ""
        lines.append(f"{finding['severity']:>7}  {finding['check']}: {finding['seen']}{do}")
    return lines


def _lens(camera: dict) -> str:
    four = f"fx {camera['fx']:.2f} fy {camera['fy']:.2f} cx {camera['cx']:.2f} cy {camera['cy']:.2f} px"
    bent = sum(value != 0 for value in camera["distortion"])
    return f"{four}, lens of {bent} values" if bent else four


def _unit(content: dict) -> str:
    """What a number of the stored depth means."""
    scale = content["camera"]["depth_scale"]
    return f"{1000 / scale:g} mm a count" if content["depth_stored"] == "counts" else "depth stored in metres"


def _color_camera(camera: dict) -> list[str]:
    """The camera of colours that are not in the depth's pixels."""
    seen = camera.get("color")
    if seen is None:
        return []
    apart = 1000 * math.dist((0, 0, 0), [row[3] for row in seen["T_color_depth"][:3]])
    return [f"colour camera: {seen['width']} x {seen['height']}, {_lens(seen)}, {apart:.1f} mm from the depth camera"]


def _clock(ends: list[float] | None) -> list[str]:
    """First and last stamp; with the date where they count from 1970, as computers do."""
    if ends is None:
        return []
    told = f"clock: {ends[0]:.3f} to {ends[1]:.3f} s"
    if not SINCE_1970[0] < ends[0] < SINCE_1970[1]:
        return [told]
    return [f"{told} ({datetime.fromtimestamp(ends[0], UTC):%Y-%m-%d %H:%M:%S} UTC)"]


def _settings(told: dict[str, str]) -> str:
    """As many as a person reads."""
    words = [f"{name} {value}" for name, value in told.items() if value]
    more = len(words) - SHOWN
    return ", ".join(words[:SHOWN]) + (f" and {more} more (--json)" if more > 0 else "")
