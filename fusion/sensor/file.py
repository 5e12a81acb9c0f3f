"""`sensor.json`: a sensor model as a file."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fusion.errors import SensorError
from fusion.output import atomic_file
from fusion.sensor.catalogue import IMPLEMENTED
from fusion.sensor.effect import Effect
from fusion.sensor.entries import checked_entry, effect_of, is_fitted, missing_parameters, stds_of, where_of
from fusion.sensor.parameter import Parameter, parameters, settings
from fusion.sensor.presets import PRESETS, preset
from fusion.sensor.raw_values import shown
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import BASELINE_M

FORMAT = "fusion-sensor/1"
LONGEST_INLINE = 1000  # more numbers than a person would read: they go into a file of their own
PRINCIPLES = ("structured_light", "itof", "active_stereo", "unknown")


def read_sensor(path_or_preset: str | Path) -> Sensor:
    """A sensor from a `sensor.json` or a preset's name; raises SensorError.

    Effects known by name only are kept and listed in `left_out`; missing parameters are neutral, with a warning.

    >>> sensor, camera = fusion.read_sensor("kinect-v1"), fusion.find_camera("kinect-v1")
    >>> sigma = sensor.sigma(np.full(camera.shape, 1.5), None, camera)  # of every pixel of a wall, seen frontally
    >>> print(f"{1e3 * np.median(sigma):.1f} mm")
    5.2 mm
    """
    name, path = str(path_or_preset), Path(path_or_preset)
    if name in PRESETS or not (path.suffix or path.exists()):
        return preset(name)
    content = _load(path)
    effects: list[Effect] = []
    kept, warnings = [], []
    std: dict[tuple[str, str], float | tuple[float, ...]] = {}
    sources: dict[str, str] = {}
    fitted = set()
    for entry in content["effects"]:
        effect, given = checked_entry(entry, path)
        if effect in sources:
            raise SensorError(f"{effect} is given twice", path, do="keep one of the two")
        sources[effect] = str(entry.get("source") or "")
        if is_fitted(entry, path):
            fitted.add(effect)
        if effect in IMPLEMENTED:
            effects.append(replace(effect_of(effect, given, path), where=where_of(entry, path)))
            std |= stds_of(effects[-1], given, path)
            warnings += missing_parameters(effect, given)
        else:
            kept.append(entry)
    return Sensor(
        name=str(content.get("name") or path.stem),
        principle=content["principle"],
        effects=tuple(effects),
        sensor=str(content.get("sensor") or ""),
        serial=str(content.get("serial") or ""),
        baseline=_baseline(content, path),
        frequencies=_frequencies(content, path),
        std=std,
        sources={effect: source for effect, source in sources.items() if source},
        fitted=frozenset(fitted),
        kept=tuple(kept),
        left_out=tuple(f"{e['effect']}: known by name, but not computed by this version" for e in kept),
        warnings=tuple(warnings),
    )


def write_sensor(path: str | Path, sensor: Sensor) -> None:
    """Write a sensor as `sensor.json`; maps become `.npy` files beside it, named after file, effect and parameter.

    Raises SensorError where one effect holds two parameters that share a name in files.

    >>> fusion.write_sensor("sensor.json", fusion.read_sensor("kinect-v1"))
    """
    path = Path(path)
    entries: list[dict[str, Any]] = [_entry(effect, sensor, path) for effect in sensor.effects]
    content: dict[str, Any] = {"format": FORMAT, "name": sensor.name, "principle": sensor.principle}
    content |= {key: value for key in ("sensor", "serial") if (value := getattr(sensor, key))}
    content["baseline_m"] = sensor.baseline
    if sensor.frequencies:
        content["modulation_hz"] = list(sensor.frequencies)
    content["effects"] = [*entries, *sensor.kept]
    with atomic_file(path) as partial:
        partial.write_text(json.dumps(content, indent=1) + "\n")


def _entry(effect: Effect, sensor: Sensor, path: Path) -> dict[str, Any]:
    """An effect as it stands in the file; parameters at their neutral value are written too."""
    written: dict[str, Any] = {n: {"value": value} for n in settings(effect) if (value := getattr(effect, n))}
    known = list(parameters(effect).values())
    changed = [p for p in known if np.ndim(value := getattr(effect, p.name)) or value != p.neutral]
    used = {p.group for p in changed}
    for label in dict.fromkeys(p.label for p in known):
        meant = [p for p in changed if p.label == label]
        if len(meant) > 1:
            raise SensorError(f"{effect.name} holds {label} in two units", path, do="a file holds one: leave one out")
        about = (meant or [p for p in known if p.label == label])[0]
        if about.group and about.group not in used:
            continue
        written[label] = {"value": _stored(effect, about, path), "unit": about.unit}
        if (effect.name, about.name) in sensor.std:
            written[label]["std"] = sensor.std[effect.name, about.name]
    out: dict[str, Any] = {"effect": effect.name, "parameters": written}
    out["source"] = sensor.sources.get(effect.name, "")
    if effect.name in sensor.fitted:
        out["fitted"] = True
    return out | ({"where": [bound.entry() for bound in effect.where]} if effect.where else {})


def _stored(effect: Effect, about: Parameter, path: Path) -> Any:
    """A number, list or small table as it is; for a map the name of a new `.npy` file."""
    value = getattr(effect, about.name)
    if not isinstance(value, np.ndarray):
        return value
    if about.kind in ("list", "table") and value.size <= LONGEST_INLINE:
        return value.tolist()
    stored = f"{path.stem}_{effect.name}_{about.name}.npy"
    with atomic_file(path.parent / stored) as partial:
        np.save(partial, value)
    return stored


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object; a key that stands twice is an error, since nobody knows which one is meant."""
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        raise ValueError(f"the key {next(key for key in keys if keys.count(key) > 1)!r} twice")
    return found


def _load(path: Path) -> dict[str, Any]:
    """The file's content with "effects" a list and "principle" a known word."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=_once)
    except FileNotFoundError as error:
        known = "a sensor.json or one of " + ", ".join(PRESETS)
        raise SensorError("the sensor file is not there", path, expected=known, do="check --sensor") from error
    except (OSError, ValueError, RecursionError) as error:
        raise SensorError("the sensor file cannot be read", path, str(error)[:200], "a JSON object") from error
    found = content.get("format") if isinstance(content, dict) else type(content).__name__
    if found != FORMAT:
        raise SensorError("this is no sensor file", path, f"format {shown(found)}", f'"format": "{FORMAT}"')
    if not isinstance(content.get("effects"), list):
        raise SensorError("the sensor file has no list of effects", path, do='add "effects": []')
    content["principle"] = content.get("principle") or "unknown"
    if content["principle"] not in PRINCIPLES:
        raise SensorError("unknown principle", path, shown(content["principle"]), "one of " + ", ".join(PRINCIPLES))
    return content


def _baseline(content: dict[str, Any], path: Path) -> float:
    """Place of the projector on the camera's x axis [m]: the file's own, else projector_shadow's, else the Kinect's."""
    value = content.get("baseline_m")
    for entry in content["effects"]:
        if value is None and entry["effect"] == "projector_shadow":
            value = entry.get("parameters", {}).get("baseline")
            value = value.get("value") if isinstance(value, dict) else value
    if value is None:
        return BASELINE_M
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.001 < abs(value) < 10:
        raise SensorError("the baseline cannot be used", path, shown(value), "0.001 to 10 metres, negative to the left")
    return float(value)


def _frequencies(content: dict[str, Any], path: Path) -> tuple[float, ...]:
    """Modulations [Hz] of a time-of-flight sensor, empty where the file does not say."""
    value = content.get("modulation_hz", [])
    good = isinstance(value, list) and all(isinstance(f, int | float) and not isinstance(f, bool) for f in value)
    if not good or not all(1e5 < f < 1e10 for f in value):
        raise SensorError("the modulation cannot be used", path, shown(value), '"modulation_hz": a list of Hz')
    return tuple(float(f) for f in value)
