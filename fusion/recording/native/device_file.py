"""`device.json`: what a device told of itself and how it was set."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fusion.errors import RecordingError
from fusion.files.inside import part
from fusion.files.json_file import read_json

NAME = "device.json"
OWN = ("source", "serial", "firmware")


def read_settings(folder: Path, notes: list[str]) -> dict[str, str]:
    """How the device of a native folder was set, words by name; a file that cannot be used is told in `notes`."""
    path = part(folder, NAME, RecordingError)
    if path is None:
        return {}
    try:
        content = read_json(path, RecordingError, "the device file")
    except RecordingError as problem:  # no frame needs it
        notes.append(f"{NAME} is left out: {problem}")
        return {}
    return settings_in(content)


def settings_in(content: Mapping[str, Any]) -> dict[str, str]:
    """How the device was set, words by name, as a device file's content says it."""
    listed = content.get("settings", {})
    told = {name: content[name] for name in OWN if name in content} | (listed if isinstance(listed, dict) else {})
    plain = {name: str(value) for name, value in told.items() if isinstance(value, str | int | float)}
    return {name: value for name, value in plain.items() if value}


def write_device(folder: Path, settings: Mapping[str, str], **more: Any) -> None:
    """Write the file into a folder that is being made."""
    (folder / NAME).write_text(device_text(settings, **more), encoding="utf-8")


def device_text(settings: Mapping[str, str], **more: Any) -> str:
    """The content of the file."""
    return json.dumps({**more, "settings": dict(settings)}, indent=1) + "\n"
