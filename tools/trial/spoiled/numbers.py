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
    Frames of a series drift and cannot be pulled to their mean: where there is one, all keep their noise. Depths are
    spread over their own steps first: rounded twice, every other edge would be off by half a step of the finer.
    """
    sensor = _file(case)
    flight = sensor.get("principle") == "itof"
    step = float(rng.choice([0.004, 0.006, 0.008, 0.012] if flight else [0.25, 0.5]))
    finer, changed = _own_step(sensor, flight), {}
    left = 1.0 if any(taken.times[-1] - taken.times[0] > 5.0 for taken in case.recordings) else CALMED
    for i, taken in enumerate(case.recordings):
        unit = 1.0 if flight else taken.camera["fx"] * BASELINE
        seen = taken.depth if flight else unit / taken.depth
        seen = calmed(seen + finer * rng.uniform(-0.5, 0.5, seen.shape), left)
        seen = np.round(seen / step) * step
        changed[i] = replace(taken, depth=seen if flight else counted(unit / np.maximum(seen, step), taken.camera))
    sensor = _rounding(sensor, {"step": (step, "m")} if flight else {"step_px": (step, "px")}, left, finer)
    text = f"step {1000 * step:.0f} mm" if flight else f"step {step:.2f} px"
    return Spoiled(replace(with_recordings(case, changed), sensor=sensor), text, Told("round|quanti"))


def _own_step(sensor: dict[str, Any], flight: bool) -> float:
    """Step [m], or [px] of disparity, to which the depths of a case are rounded already; 0 for none."""
    own = [entry["parameters"] for entry in sensor["effects"] if entry["effect"] == "depth_quantization"]
    return float(own[0].get("step" if flight else "step_px", {"value": 0.0})["value"]) if own else 0.0


def calmed(depth: Array, left: float) -> Array:
    """(n, h, w) frames pulled to their mean, so that a share of their noise is left."""
    valid = np.isfinite(depth)
    with np.errstate(invalid="ignore"):
        mean = np.where(valid, depth, 0.0).sum(axis=0) / valid.sum(axis=0)
    return np.asarray(mean + left * (depth - mean))


def _rounding(sensor: dict[str, Any], steps: dict[str, tuple[float, str]], left: float, finer: float) -> dict[str, Any]:
    """The model with this rounding, and with the noise that is left of its own, of the finer steps, which the depths
    have been rounded to, and of their having been spread over these.
    """
    effects = []
    for entry in sensor["effects"]:
        parameters = dict(entry["parameters"])
        if entry["effect"] == "depth_quantization":
            parameters = {name: {"value": x, "unit": unit, "std": 0} for name, (x, unit) in steps.items()}
        if entry["effect"] == "axial_noise":
            for name in parameters.keys() - {"ir_reference", "correlation_px"}:
                told = parameters[name]
                more = (2 * finer**2 / 12) ** 0.5 if name == "sigma_px" else 0.0
                size = float(np.hypot(told["value"], more))
                parameters[name] = {**told, "value": left * size, "std": left * told["std"]}
        effects.append({**entry, "parameters": parameters})
    return {**sensor, "effects": effects}


def _file(case: Case) -> dict[str, Any]:
    if isinstance(case.sensor, str):
        raise ValueError(f"{case.sensor} is a preset: this spoil writes into a sensor.json")
    return case.sensor
