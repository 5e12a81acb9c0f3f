"""`evaluation.json`: the findings as plain numbers, SI units, null where something is not known."""

import numpy as np
from numpy.typing import NDArray

from fusion.evaluation.content import (
    AmbientNumbers,
    BiasNumbers,
    CameraName,
    ChannelNumbers,
    DepthNumbers,
    DriftNumbers,
    EvaluationNumbers,
    NearNumbers,
    NoiseNumbers,
    PixelNumbers,
    ShareNumbers,
    Spread,
    StepNumbers,
    StretchNumbers,
)
from fusion.evaluation.quantization import Quantization
from fusion.evaluation.still.drift import Drift
from fusion.evaluation.still.shares import Shares
from fusion.evaluation.stretch_look import StretchLook
from fusion.evaluation.summary import Evaluation, summary

FORMAT = "fusion-evaluation/1"
Image = NDArray[np.floating]


def numbers(found: Evaluation) -> EvaluationNumbers:
    """All findings as numbers; NaN where something is not known."""
    camera, ambient = found.camera, found.ambient
    return EvaluationNumbers(
        format=FORMAT,
        summary=summary(found),
        camera=CameraName(camera.sensor, camera.serial, camera.principle, camera.width, camera.height),
        stretches=tuple(map(_stretch, found.looks)),
        shares={name: _shares(shares) for name, shares in found.shares.items()},
        shortest_distance=tuple(
            NearNumbers(near.surface, near.distance, near.interval, near.distances, near.valid) for near in found.near
        ),
        quantization=_steps(found.quantization),
        ambient=None
        if ambient is None
        else AmbientNumbers(ambient.lux, (ambient.low, ambient.high), ambient.points, ambient.law, ambient.sentence),
        notes=tuple(text for _, text in found.notes),
    )


def _stretch(look: StretchLook) -> StretchNumbers:
    still = look.still
    colors = () if still.color is None else enumerate(("red", "green", "blue"))
    return StretchNumbers(
        name=look.name,
        frames=still.frames,
        frames_unreadable=len(still.failures),
        duration_s=float(still.time[-1]),
        frames_disturbed=np.asarray(still.disturbed, int),
        moving_share=float(still.moving.mean()),
        surface=look.surface.kind,
        distance_m=look.surface.distance,
        depth=DepthNumbers(
            mean_m=_middle(still.depth.mean),
            std_m=_spread(still.depth.std),
            std_robust_m=_spread(still.robust),
            common_std_m=look.common,
            valid_share=float(still.depth.valid.mean()),
        ),
        ir=None if still.ir is None else _channel(still.ir.mean, still.ir.std),
        color=None
        if still.color is None
        else {name: _channel(still.color.mean[..., c], still.color.std[..., c]) for c, name in colors},
        pixel=_pixel(look),
        bias=_bias(look),
        noise=_noise(look),
        shares={"valid": look.valid, "no_data": look.missing, "outliers": look.outliers},
        quantization=_steps(look.quantization),
        drift=_drift(look.drift),
    )


def _pixel(look: StretchLook) -> PixelNumbers:
    v, u = look.still.pixel
    known = look.still.series[np.isfinite(look.still.series)]
    mean = float(known.mean()) if len(known) else float("nan")
    std = float(known.std(ddof=1)) if len(known) > 1 else float("nan")
    return PixelNumbers(u, v, len(known), mean, std, float(look.still.robust[v, u]))


def _bias(look: StretchLook) -> BiasNumbers | None:
    bias = look.bias
    if bias is None:
        return None
    return BiasNumbers(bias.truth or None, bias.offset, bias.offset_std, bias.corrected, bias.spread, bias.rms)


def _noise(look: StretchLook) -> NoiseNumbers | None:
    noise = look.noise
    if noise is None:
        return None
    along = (noise.axial, noise.axial_std, look.expected_sigma)
    return NoiseNumbers(noise.depth, noise.tilt, noise.frames, *along, noise.lateral[0], noise.lateral[1])


def _shares(shares: Shares) -> ShareNumbers:
    unit = {"depth": "m", "incidence": "rad", "brightness": "count"}[shares.variable]
    parts = (shares.valid, shares.missing, shares.outliers)
    return ShareNumbers(unit, shares.low, shares.high, *parts, np.asarray(shares.values, int), shares.sigma)


def _steps(found: Quantization | None) -> StepNumbers | None:
    if found is None:
        return None
    exponent = (found.exponent, found.exponent_std)
    return StepNumbers(found.law, found.value, found.interval, *exponent, found.unit, found.depth, found.step)


def _drift(drift: Drift) -> DriftNumbers:
    wait = drift.wait_min
    return DriftNumbers(
        verdict=drift.verdict,
        text=drift.text,
        slope_m_per_s=drift.slope,
        slope_interval_90=drift.slope_interval,
        change_ten_minutes_m=drift.change,
        change_interval_90_m=drift.change_interval,
        time_constant_s=drift.constant,
        wait_s=None if wait is None else 60 * wait[0],
        wait_interval_90_s=None if wait is None else (60 * wait[1], 60 * wait[2]),
    )


def _channel(mean: Image, std: Image) -> ChannelNumbers:
    return ChannelNumbers(_middle(mean), _spread(std))


def _middle(image: Image) -> float | None:
    known = image[np.isfinite(image)]
    return float(np.median(known)) if known.size else None


def _spread(image: Image) -> Spread | None:
    known = image[np.isfinite(image)]
    if not known.size:
        return None
    low, middle, high = np.quantile(known, [0.1, 0.5, 0.9]).tolist()
    return Spread(middle, low, high)
