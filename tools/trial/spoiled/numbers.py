"""Spoils of the sensor's file and of its numbers: no noise law, coarse rounding that no noise dithers."""

from dataclasses import replace
from typing import Any

import numpy as np

from tools.trial.spoiled.case import Case, Rng, Spoiled, Told, with_recordings
from tools.trial.spoiled.folder import Array, counted

BASELINE = 0.075  # [m] of the structured-light cameras of both generators, where the file names none
CALMED = 0.2  # of the noise is left


def noise_unsaid(case: Case, rng: Rng) -> Spoiled:
    """`axial_noise` is not in sensor.json: the likeliest first use."""
    sensor = dict(_file(case))
    sensor["effects"] = [entry for entry in sensor["effects"] if entry["effect"] != "axial_noise"]
    told = Told(r"noise (law|model|of the sensor|is not|is missing)|axial noise")
    return Spoiled(replace(case, sensor=sensor), "no axial_noise", told, ("axial_noise",))


def rounded_undithered(case: Case, rng: Rng) -> Spoiled:
    """Noise calmed to a fifth, then depth rounded to 4 to 12 mm (disparity to 1/4 to 1/2 px), as sensor.json says.

    Nothing is missing. The steps lie where the TRUE pose puts them, and the stated one is off by its usual error.
    """
    flight = _file(case).get("principle") == "itof"
    step = float(rng.choice([0.004, 0.006, 0.008, 0.012] if flight else [0.25, 0.5]))
    changed = {}
    for i, taken in enumerate(case.recordings):
        long = taken.times[-1] - taken.times[0] > 5.0
        depth = taken.depth if long else calmed(taken.depth)
        if flight:
            depth = np.round(depth / step) * step
        else:
            fb = taken.camera["fx"] * BASELINE
            depth = counted(fb / (np.maximum(np.round(fb / depth / step), 1) * step), taken.camera)
        changed[i] = replace(taken, depth=depth)
    sensor = _rounding(_file(case), {"step": (step, "m")} if flight else {"step_px": (step, "px")})
    text = f"step {1000 * step:.0f} mm" if flight else f"step {step:.2f} px"
    return Spoiled(replace(with_recordings(case, changed), sensor=sensor), text, Told("round|quanti"))


def calmed(depth: Array) -> Array:
    """(n, h, w) frames pulled to their mean."""
    valid = np.isfinite(depth)
    with np.errstate(invalid="ignore"):
        mean = np.where(valid, depth, 0.0).sum(axis=0) / valid.sum(axis=0)
    return np.asarray(mean + CALMED * (depth - mean))


def _rounding(sensor: dict[str, Any], steps: dict[str, tuple[float, str]]) -> dict[str, Any]:
    """The model with this rounding, and with the noise that is left."""
    effects = []
    for entry in sensor["effects"]:
        parameters = dict(entry["parameters"])
        if entry["effect"] == "depth_quantization":
            parameters = {name: {"value": x, "unit": unit, "std": 0} for name, (x, unit) in steps.items()}
        if entry["effect"] == "axial_noise":
            for name in parameters.keys() - {"ir_reference", "correlation_px"}:
                told = parameters[name]
                parameters[name] = {**told, "value": CALMED * told["value"], "std": CALMED * told["std"]}
        effects.append({**entry, "parameters": parameters})
    return {**sensor, "effects": effects}


def _file(case: Case) -> dict[str, Any]:
    if isinstance(case.sensor, str):
        raise ValueError(f"{case.sensor} is a preset: this spoil writes into a sensor.json")
    return case.sensor
