"""`evaluation.json`: the findings as plain numbers, SI units, null where something is not known."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.ambient import AmbientEstimate
from fusion.evaluation.evaluate import Evaluation, StretchLook
from fusion.evaluation.quantization import Quantization
from fusion.evaluation.still.drift import Drift
from fusion.evaluation.still.shares import Shares
from fusion.evaluation.summary import summary

FORMAT = "fusion-evaluation/1"


def numbers(found: Evaluation) -> dict[str, Any]:
    """The content of `evaluation.json`; docs/evaluation.md tells the keys."""
    return {
        "format": FORMAT,
        "summary": summary(found),
        "camera": {
            "sensor": found.camera.sensor,
            "serial": found.camera.serial,
            "principle": found.camera.principle,
            "width": found.camera.width,
            "height": found.camera.height,
        },
        "stretches": [_look(look) for look in found.looks],
        "shares": {name: _shares(shares) for name, shares in found.shares.items()},
        "shortest_distance": [
            {
                "surface": near.surface,
                "distance_m": _number(near.distance),
                "interval_m": _numbers(near.interval),
                "distances_m": _numbers(near.distances),
                "valid": _numbers(near.valid),
            }
            for near in found.near
        ],
        "quantization": _quantization(found.quantization),
        "ambient": _ambient(found.ambient),
        "notes": [text for _, text in found.notes],
    }


def _look(look: StretchLook) -> dict[str, Any]:
    still = look.still
    return {
        "name": look.name,
        "frames": still.frames,
        "frames_unreadable": len(still.failures),
        "duration_s": _number(still.time[-1]),
        "frames_disturbed": [int(i) for i in still.disturbed],
        "moving_share": _number(still.moving.mean()),
        "surface": look.surface.kind,
        "distance_m": _number(look.surface.distance),
        "depth": {
            "mean_m": _middle(still.depth.mean),
            "std_m": _spread(still.depth.std),
            "std_robust_m": _spread(still.robust),
            "common_std_m": _number(look.common),
            "valid_share": _number(still.depth.valid.mean()),
        },
        "ir": None if still.ir is None else {"mean": _middle(still.ir.mean), "std": _spread(still.ir.std)},
        "color": None
        if still.color is None
        else {
            name: {"mean": _middle(still.color.mean[..., c]), "std": _spread(still.color.std[..., c])}
            for c, name in enumerate(("red", "green", "blue"))
        },
        "pixel": _pixel(look),
        "bias": _bias(look),
        "noise": _noise(look),
        "shares": {"valid": _number(look.valid), "no_data": _number(look.missing), "outliers": _number(look.outliers)},
        "quantization": _quantization(look.quantization),
        "drift": _drift(look.drift),
    }


def _pixel(look: StretchLook) -> dict[str, Any]:
    v, u = look.still.pixel
    known = look.still.series[np.isfinite(look.still.series)]
    return {
        "u": u,
        "v": v,
        "values": len(known),
        "mean_m": _number(known.mean()) if len(known) else None,
        "std_m": _number(known.std(ddof=1)) if len(known) > 1 else None,
        "std_robust_m": _number(look.still.robust[v, u]),
    }


def _bias(look: StretchLook) -> dict[str, Any] | None:
    bias = look.bias
    if bias is None:
        return None
    return {
        "truth": bias.truth or None,
        "offset_m": _number(bias.offset),
        "offset_std_m": _number(bias.offset_std),
        "offset_corrected_m": _number(bias.corrected),
        "spread_m": _number(bias.spread),
        "residual_rms_m": _number(bias.rms),
    }


def _noise(look: StretchLook) -> dict[str, Any] | None:
    noise = look.noise
    if noise is None:
        return None
    return {
        "depth_m": noise.depth,
        "tilt_rad": noise.tilt,
        "frames": noise.frames,
        "axial_m": _number(noise.axial),
        "axial_std_m": _number(noise.axial_std),
        "axial_expected_m": _number(look.expected_sigma),
        "lateral_left_m": _number(noise.lateral[0]),
        "lateral_right_m": _number(noise.lateral[1]),
    }


def _shares(shares: Shares) -> dict[str, Any]:
    names = {"valid": shares.valid, "no_data": shares.missing, "outliers": shares.outliers}
    unit = {"depth": "m", "incidence": "rad", "brightness": "count"}[shares.variable]
    return {
        "unit": unit,
        "low": _numbers(shares.low),
        "high": _numbers(shares.high),
        **{name: _numbers(values) for name, values in names.items()},
        "values": [int(n) for n in shares.values],
        "std_m": _numbers(shares.sigma),
    }


def _quantization(found: Quantization | None) -> dict[str, Any] | None:
    if found is None:
        return None
    return {
        "law": found.law,
        "step_m": _number(found.value),
        "interval_90_m": _numbers(found.interval),
        "exponent": _number(found.exponent),
        "exponent_std": _number(found.exponent_std),
        "file_unit_m": found.unit,
        "depth_m": _numbers(found.depth),
        "steps_m": _numbers(found.step),
    }


def _ambient(found: AmbientEstimate | None) -> dict[str, Any] | None:
    if found is None:
        return None
    return {
        "lux": _number(found.lux),
        "interval_90_lux": _numbers((found.low, found.high)),
        "places": found.points,
        "law": found.law,
        "text": found.sentence,
    }


def _drift(drift: Drift) -> dict[str, Any]:
    wait = drift.wait_min
    return {
        "verdict": drift.verdict,
        "text": drift.text,
        "slope_m_per_s": _number(drift.slope),
        "slope_interval_90": _numbers(drift.slope_interval),
        "change_ten_minutes_m": _number(drift.change),
        "change_interval_90_m": _numbers(drift.change_interval),
        "time_constant_s": _number(drift.constant),
        "wait_s": None if wait is None else 60 * wait[0],
        "wait_interval_90_s": None if wait is None else [60 * wait[1], 60 * wait[2]],
    }


def _middle(image: NDArray[np.floating]) -> float | None:
    known = image[np.isfinite(image)]
    return _number(np.median(known)) if known.size else None


def _spread(image: NDArray[np.floating]) -> dict[str, float | None] | None:
    """Median, 10th and 90th percentile of a map."""
    known = image[np.isfinite(image)]
    if not known.size:
        return None
    low, middle, high = np.quantile(known, [0.1, 0.5, 0.9])
    return {"median": _number(middle), "p10": _number(low), "p90": _number(high)}


def _number(value: Any) -> float | None:
    return float(value) if math.isfinite(value) else None


def _numbers(values: Any) -> list[float | None]:
    return [_number(value) for value in values]
