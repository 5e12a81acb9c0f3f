"""`sensor.json`: a sensor model as a file."""

import io
import json
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SensorError
from fusion.files.content import Content
from fusion.files.json_file import read_json, shown
from fusion.files.json_values import json_values
from fusion.files.output.publish import atomic_file
from fusion.files.reading import read_bytes
from fusion.files.schema import one_of
from fusion.geometry.camera import Principle
from fusion.sensor.catalogue import IMPLEMENTED
from fusion.sensor.depth_errors import DepthErrors
from fusion.sensor.effect import Effect
from fusion.sensor.files.entries import GivenEffect, Stds, given_effects
from fusion.sensor.files.raw_values import Raw, numbers
from fusion.sensor.files.sensor_fields import FORMAT, DepthErrorFields, RangeFields, SensorFields
from fusion.sensor.parameter import Parameter, parameters, settings
from fusion.sensor.presets import PRESETS, preset
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import BASELINE_M
from fusion.sensor.working_range import ANY, WorkingRange

LONGEST_INLINE = 1000  # more numbers than a person would read: they go into a file of their own


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
    content = _content(path)
    given = given_effects(content)
    computed = {one.name: one.effect() for one in given if one.name in IMPLEMENTED}
    kept = [one for one in given if one.name not in computed]
    fields = content.as_type(SensorFields)
    std: Stds = {}
    warnings = []
    for one in given:
        if one.name in computed:
            std |= one.stds(computed[one.name])
            warnings += one.missing()
    return Sensor(
        name=str(fields.name or path.stem),
        principle=fields.principle or Principle.UNKNOWN,
        effects=tuple(computed.values()),
        sensor=str(fields.sensor or ""),
        serial=str(fields.serial or ""),
        baseline=_baseline(fields, given, content),
        frequencies=tuple(fields.modulation_hz or ()),
        works=_works(fields.range),
        std=std,
        sources={one.name: str(one.entry.source) for one in given if one.entry.source},
        fitted=frozenset(one.name for one in given if one.entry.fitted),
        depth_errors=_depth_errors(fields.depth_errors, content),
        kept=tuple(content.value["effects"][one.place] for one in kept),
        left_out=tuple(f"{one.name}: known by name, but not computed by this version" for one in kept),
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
    if (works := sensor.works) != ANY:
        farthest = works.farthest if np.isfinite(works.farthest) else None
        content["range"] = {"nearest_m": works.nearest, "farthest_m": farthest, "source": works.source}
    content["effects"] = [*entries, *sensor.kept]
    if (left := sensor.depth_errors) is not None:
        grid = {"v_px": left.v.tolist(), "u_px": left.u.tolist(), "depth_m": left.depth.tolist()}
        stored = store_map(path.parent, f"{path.stem}_depth_errors", left.fields.astype(np.float32))
        content["depth_errors"] = grid | {"values_m": stored}
    with atomic_file(path) as partial:
        partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


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
    return out | ({"where": json_values([bound.entry() for bound in effect.where])} if effect.where else {})


def _stored(effect: Effect, about: Parameter, path: Path) -> Any:
    """A number, list or small table as it is; for a map the name of a new `.npy` file."""
    value = getattr(effect, about.name)
    if not isinstance(value, np.ndarray):
        return value
    if about.kind in ("list", "table") and value.size <= LONGEST_INLINE:
        return value.tolist()
    return store_map(path.parent, f"{path.stem}_{effect.name}_{about.name}", value)


def _content(path: Path) -> Content:
    try:
        return Content(read_json(path, SensorError, "the sensor file"), path, "the sensor", SensorError)
    except SensorError as error:
        if not isinstance(error.__cause__, FileNotFoundError):
            raise
        known = "a sensor.json or " + one_of(PRESETS, path)
        raise SensorError("the sensor file is not there", path, expected=known, do="check --sensor") from error


def _works(given: RangeFields | None) -> WorkingRange:
    if given is None:
        return ANY
    farthest = np.inf if given.farthest_m is None else given.farthest_m
    return WorkingRange(given.nearest_m, farthest, str(given.source or ""))


def _depth_errors(given: DepthErrorFields | None, content: Content) -> DepthErrors | None:
    if given is None:
        return None
    raw = Raw(given.values_m, content, ("depth_errors", "values_m"))
    values, grid = numbers(raw), [np.array(nodes) for nodes in (given.v_px, given.u_px, given.depth_m)]
    expected = tuple(len(nodes) for nodes in grid)
    if values.ndim != 4 or values.shape[1:] != expected:
        raise raw.wrong(f"shape {values.shape}", f"errors by the grid, (errors, {', '.join(map(str, expected))})")
    for name, nodes in zip(("v_px", "u_px", "depth_m"), grid, strict=True):
        if not (np.diff(nodes) > 0).all():
            raise content.wrong(SensorFields, "depth_errors", name, expected="increasing numbers")
    return DepthErrors(grid[0], grid[1], grid[2], values)


def _baseline(fields: SensorFields, given: list[GivenEffect], content: Content) -> float:
    """Place of the projector on the camera's x axis [m]: the file's own, else projector_shadow's, else the Kinect's."""
    value: Any = fields.baseline_m
    for one in given:
        if value is None and one.name == "projector_shadow" and "baseline" in one.given:
            value = one.given["baseline"].value
    if value is None:
        return BASELINE_M
    if not isinstance(value, float) or not 0.001 < abs(value) < 10:
        must = "0.001 to 10 metres, negative to the left"
        raise content.wrong(SensorFields, "baseline_m", found=shown(value), expected=must)
    return value


def store_map(folder: Path, name: str, value: NDArray) -> str:
    """Write a map under a name that nothing else has yet, so that every file that names an older one stays right.

    Returns:
        The name: `NAME.npy`, or `NAME_2.npy` and so on where another map has that.
    """
    memory = io.BytesIO()  # np.save itself would not tell why it could not write
    np.save(memory, value)
    for number in count(1):
        path = folder / (f"{name}.npy" if number == 1 else f"{name}_{number}.npy")
        if not path.exists():
            with atomic_file(path) as partial:
                partial.write_bytes(memory.getvalue())
        elif not path.is_file() or read_bytes(path) != memory.getvalue():
            continue
        return path.name
    raise AssertionError("numbers end")
