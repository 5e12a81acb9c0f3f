"""`fusion doctor`: what is plugged in, installed, missing."""

import argparse
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number
from fusion.files.json_values import json_text
from fusion.quantity import LOOKED_AT

if TYPE_CHECKING:
    from fusion.devices.doctor import DeviceFindings, Tested

EXAMPLE = "fusion doctor --try kinect-v1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("--try", dest="source", metavar="SOURCE", help="take frames of a source, as fusion record names it, and count")
    add("--seconds", type=number(LOOKED_AT), default=5.0, metavar="S", help="how long, with --try (default: 5)")
    add("--udev", action="store_true", help="print the rule file that lets you open cameras, and where to put it")
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> int:
    """Print what there is; 1 where a source that was tried gave no frame."""
    from fusion.devices.doctor import RULES, look, looked_at
    from fusion.devices.open import open_source

    if options.udev:
        sys.stdout.write(RULES.read_text(encoding="utf-8"))
        return 0
    findings, tested = look(), None
    if not options.json:
        print("\n".join(_lines(findings)))
    if options.source is not None:
        with open_source(options.source) as source:
            tested = looked_at(source, options.seconds)
    if options.json:
        told = asdict(findings) | {"extras": {n: p | {"all": a} for n, (p, a) in findings.extras.items()}}
        print(json_text(told | {"tried": None if tested is None else asdict(tested)}))
    elif tested is not None:
        print("\n".join(_tested(tested)))
    return int(tested is not None and not tested.frames)


def _lines(found: "DeviceFindings") -> list[str]:
    lines = [", ".join(f"{name} {value}" for name, value in found.versions.items())]
    for name, (packages, complete) in found.extras.items():
        held = ", ".join(f"{package} {version or 'missing'}" for package, version in packages.items())
        do = "" if complete else f' -> pip install "fusion-scan[{name}]"'
        lines.append(f"extra {name:<10} {held}{do}")
    if found.usb:
        return [*lines, f"USB: {found.usb}"]
    lines.append(f"USB: {found.devices} devices, {len(found.plugged)} of them depth cameras or parts of one")
    for one in found.plugged:
        allowed = {True: "you may open it", False: "you may NOT open it", None: "whether you may open it is not known"}
        speed = f"{one.speed:g} Mbit/s" if one.speed else "speed not known"
        head = f"  {one.vendor:04x}:{one.product:04x} {one.name}"
        lines.append(f"{head}; {one.place}, {speed}, {allowed[one.may_open]}")
        lines += [f"    {text}" for text in one.wrong]
    return lines


def _tested(tested: "Tested") -> list[str]:
    lost = f"{tested.missed} lost" if tested.missed else "none lost"
    lines = [
        f"{tested.source} {tested.serial}".strip()
        + f": {tested.frames} frames in {tested.seconds:.1f} s, {tested.rate:.2f} a second, {lost}; "
        f"longest wait {1000 * tested.latest:.0f} ms; its clock runs {tested.device_rate:.5f} s a second"
    ]
    for name, counts in tested.packets.items():
        told = ", ".join(f"{value} {what}" for what, value in counts.items() if value or what in ("packets", "lost"))
        lines.append(f"  {name}: {told}")
    return [*lines, *(f"  note: {text}" for text in tested.notes)]
