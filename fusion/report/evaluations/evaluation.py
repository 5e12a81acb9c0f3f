"""The report of `fusion evaluate`: one sentence, then the figures of Fankhauser and Pagliari from own data."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fusion.evaluation.stretch_look import StretchLook
from fusion.evaluation.summary import Evaluation, summary
from fusion.report.evaluations.bench_curves import noise_figure, offset_figure, shares_figure, step_figure
from fusion.report.evaluations.evaluation_text import headline, step_sentence
from fusion.report.evaluations.pixel_maps import MOST, map_rows
from fusion.report.evaluations.still_series import drift_figure, pixel_figure
from fusion.report.kit.page import Figure, Number, Page, Section, write_page
from fusion.report.kit.tables import numbers_table
from fusion.results.light import Light, level

WARM = {"ready": "ok", "not warmed up": "bad"}
OFFSET_NOISES = (1.0, 5.0)  # an offset below the noise of one value is good, far above it a problem (guess)
SAME = 1e-5  # [m] a smaller correction is none
LEVEL = 1.645  # standard deviations of a 90 % interval


def evaluation_report(path: Path, found: Evaluation, command: str = "", settings: Mapping | None = None) -> None:
    """Write `report.html` of an evaluation."""
    camera = found.camera
    name = " ".join(filter(None, (camera.sensor, camera.serial))) or "unnamed camera"
    drift = found.longest.drift
    light = [] if found.ambient is None else [Light("ok", "Ambient light", _sentence(found.ambient.sentence))]
    page = Page(
        title="Sensor evaluation",
        subtitle=f"{name}; {camera.principle}, {camera.width} x {camera.height} px",
        summary=[
            Light("ok", "Found", _sentence(summary(found))),
            *_offset_light(found),
            Light(WARM.get(drift.verdict, "warning"), "Warm", drift.text),
            *light,
        ],
        numbers=_numbers(found),
        sections=[
            Section("Every pixel", figures=_maps(found)),
            Section("Over time", figures=_series(found)),
            Section("Offset over distance", figures=(*_offset(found), *_residuals(found)), html=_table(found)),
            Section("Noise of the target", figures=_noise(found)),
            Section("Valid, no data, outliers", figures=_shares(found), html=_near(found)),
            Section("Quantisation", figures=_steps(found)),
        ],
        warnings=[Light(level, "", text) for level, text in found.notes],
        settings=settings,
        command=command,
    )
    write_page(path, page)


def _offset_light(found: Evaluation) -> list[Light]:
    """The largest offset from the truth, where one is known: judged against the noise of a single depth."""
    known = [look.bias for look in found.looks if look.bias is not None and np.isfinite(look.bias.offset)]
    if not known:
        return []
    worst = max(known, key=lambda bias: abs(bias.offset) / bias.spread)
    judged = level(abs(worst.offset) / worst.spread, OFFSET_NOISES)
    said = f"Depth is off by {worst.offset * 1e3:+.1f} mm at {worst.distance:.2f} m, where one value scatters by "
    do = "Calibrate it: fusion calibrate depth." if judged != "ok" else ""
    return [Light(judged, "Offset", f"{said}{worst.spread * 1e3:.1f} mm.", do)]


def _numbers(found: Evaluation) -> list[Number]:
    numbers = [
        Number("Views", str(len(found.looks))),
        Number("Frames", str(sum(look.still.frames for look in found.looks))),
    ]
    look = found.longest
    std = look.still.depth.std
    if np.isfinite(std).any():
        numbers.append(Number(f"Noise of a pixel at {look.surface.distance:.2f} m", _mm(np.nanmedian(std)), "mm"))
    if found.quantization is not None and found.quantization.law in ("z^2", "constant"):
        unit = "mm z^2" if found.quantization.law == "z^2" else "mm"
        numbers.append(Number("Quantisation step", _mm(found.quantization.value), unit))
    for near in found.near:
        if np.isfinite(near.distance):
            kind = "" if near.surface == "all" else f", {near.surface}"
            most = "" if near.interval[0] > 0 else "at most "
            numbers.append(Number(f"Shortest distance{kind}", f"{most}{near.distance:.2f}", "m"))
    return numbers


def _chosen(found: Evaluation) -> list[StretchLook]:
    """Up to five stretches, evenly over their distances."""
    order = sorted(found.looks, key=lambda look: np.nan_to_num(look.surface.distance))
    places = np.unique(np.linspace(0, len(order) - 1, MOST).round().astype(int))
    return [order[i] for i in places]


def _title(look: StretchLook) -> str:
    return f"{look.surface.distance:.2f} m" if np.isfinite(look.surface.distance) else look.name[:24]


def _maps(found: Evaluation) -> tuple[Figure, ...]:
    looks = _chosen(found)
    columns = [_title(look) for look in looks]
    still = [look.still for look in looks]
    rows = [("mean depth", "depth [m]", [s.depth.mean for s in still], False)]
    if any(np.isfinite(s.depth.std).any() for s in still):
        rows.append(("noise", "std of the depth [mm]", [s.depth.std * 1e3 for s in still], False))
    text = Figure(
        headline("depth", still), "", "Maps of mean depth and of its standard deviation.",
        "Per pixel over all frames; missing values, outliers and moving things are left out. One colour scale a row.",
    )  # fmt: skip
    figures = [map_rows(rows, columns, "depth-maps", text)]
    with_ir = [s.ir for s in still if s.ir is not None]
    if len(with_ir) == len(still):
        rows = [("mean IR", "[count]", [x.mean for x in with_ir], False)]
        if any(np.isfinite(x.std).any() for x in with_ir):
            rows.append(("noise of IR", "std [count]", [x.std for x in with_ir], False))
        text = Figure(
            "IR: mean and noise of every pixel", "", "Maps of mean IR and its deviation.", "Zeros are left out."
        )
        figures.append(map_rows(rows, columns, "ir-maps", text))
    return (*figures, *_color(found.longest))


def _color(look: StretchLook) -> tuple[Figure, ...]:
    """Mean and noise of each colour channel of one stretch."""
    color = look.still.color
    if color is None:
        return ()
    channels = range(3)
    rows = [("mean", "[count]", [color.mean[..., c] for c in channels], False)]
    if np.isfinite(color.std).any():
        rows.append(("noise", "std [count]", [color.std[..., c] for c in channels], False))
    title = f"Colour of {look.name}: mean and noise of every pixel"
    text = Figure(title, "", title + ".", "Black pixels are left out.")
    return (map_rows(rows, ("red", "green", "blue"), "color-maps", text),)


def _series(found: Evaluation) -> tuple[Figure, ...]:
    look, figures = found.longest, []
    still = look.still
    v, u = still.pixel
    known = still.series[np.isfinite(still.series)]
    if len(known) > 1:
        title = f"Pixel ({u}, {v}) of {look.name}: {len(known)} depths, standard deviation {_mm(known.std(ddof=1))} mm"
        text = Figure(title, "", title + ".", "Another pixel: --pixel U V.")
        figures.append(pixel_figure(still.time, still.series, text))
    if np.isfinite(still.centre).sum() > 1:
        text = Figure(look.drift.text, "", look.drift.text, f"{look.name}: mean over the middle sixth of width and "
                      "height. The curve is the mean of all warm-ups that agree with the data.")  # fmt: skip
        figures.append(drift_figure(still.time, still.centre, look.drift, text))
    return tuple(figures)


def _offset(found: Evaluation) -> tuple[Figure, ...]:
    known = [look.bias for look in found.looks if look.bias is not None and np.isfinite(look.bias.offset)]
    if not known:
        return ()
    offset, std, spread = (np.array([getattr(b, name) for b in known]) for name in ("offset", "offset_std", "spread"))
    parts = [("as recorded", offset, LEVEL * std)]
    corrected = np.array([b.corrected for b in known])
    if np.isfinite(corrected).any() and np.nanmax(np.abs(corrected - offset)) > SAME:
        parts.append(("corrected by --sensor", corrected, LEVEL * std))
    title = f"The depth is off by {_span(offset, True)} mm"
    text = Figure(title, "", title + ".", "Middle of the image, the fitted plane's tilt taken out.")
    return (offset_figure(np.array([b.distance for b in known]), parts, spread, text),)


def _residuals(found: Evaluation) -> tuple[Figure, ...]:
    pairs = [(look, look.bias) for look in _chosen(found) if look.bias is not None]
    if not pairs:
        return ()
    rms = [bias.rms for _, bias in pairs]
    title = f"Residuals from the surface: {_span(rms)} mm rms"
    text = Figure(
        title, "", title + ".", "Mean of all frames less the fitted plane (or the stated mesh), all on one scale."
    )
    rows = [("residual", "[mm]", [bias.residual * 1e3 for _, bias in pairs], True)]
    return (map_rows(rows, [_title(look) for look, _ in pairs], "residual-maps", text),)


def _noise(found: Evaluation) -> tuple[Figure, ...]:
    known = [(look.noise, look.expected_sigma) for look in found.looks if look.noise is not None]
    if len(known) < 2 or not np.isfinite([n.axial for n, _ in known]).any():
        return ()  # one number needs no figure
    depth, axial = (np.array([getattr(n, name) for n, _ in known]) for name in ("depth", "axial"))
    lateral = np.array([n.lateral for n, _ in known])
    title = f"Axial noise {_span(axial)} mm"
    if np.isfinite(lateral).any():
        title += f", lateral {_span(lateral)} mm"
    text = Figure(
        title, "", title + ".", "Standard deviation of single depths at the target's middle, and of its edges."
    )
    return (noise_figure(depth, axial, np.array([e for _, e in known]), lateral, text),)


def _shares(found: Evaluation) -> tuple[Figure, ...]:
    parts = [part for part in found.shares.values() if len(part.low)]
    if not parts:
        return ()
    low = 100 * min(float(np.min(part.valid)) for part in parts)
    title = f"At least {low:.1f} % of the values are valid everywhere" if low > 1 else "In places nothing is valid"
    text = Figure(title, "", title + ".", "Outlier: further than six standard deviations (at least 3 cm and 2 %) from "
                  "the surface. Tiles of the image, all recordings together.")  # fmt: skip
    return (shares_figure(parts, text),)


def _near(found: Evaluation) -> str:
    if not found.near:
        return ""
    rows = []
    for near in found.near:
        low, high = near.interval
        value = f"{near.distance:.3f}" if np.isfinite(near.distance) else "none"
        rows.append([near.surface, value, f"{low:.3f} to {high:.3f}", str(len(near.distances))])
    return numbers_table(["surface", "usable from [m]", "between [m]", "distances"], rows)


def _steps(found: Evaluation) -> tuple[Figure, ...]:
    q = found.quantization
    if q is None:
        return ()
    title = step_sentence(q)
    return (step_figure(q, Figure(title, "", title + ".", "From the depths that occur at all: no repeats needed.")),)


def _table(found: Evaluation) -> str:
    rows = []
    for look in found.looks:
        bias = look.bias
        offset = _mm(bias.offset, True) if bias is not None else "unknown"
        noise = _mm(np.nanmedian(look.still.depth.std)) if np.isfinite(look.still.depth.std).any() else "unknown"
        shares = (f"{100 * look.valid:.1f}", f"{100 * look.missing:.1f}", f"{100 * look.outliers:.2f}")
        distance = f"{look.surface.distance:.3f}"
        rows.append([look.name, str(look.still.frames), distance, look.surface.kind, offset, noise, *shares])
    head = ["view", "frames", "distance [m]", "surface", "offset [mm]", "noise [mm]", "valid [%]", "no data [%]",
            "outliers [%]"]  # fmt: skip
    return numbers_table(head, rows)


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:].rstrip(".") + "."


def _span(values: Any, signed: bool = False) -> str:
    """From the least to the largest, in mm; one number where they read alike."""
    low, high = (_mm(edge, signed) for edge in (np.nanmin(values), np.nanmax(values)))
    return low if low == high else f"{low} to {high}"


def _mm(value: Any, signed: bool = False) -> str:
    if not np.isfinite(value):
        return "unknown"
    return f"{value * 1e3:+.2f}" if signed else f"{value * 1e3:.2f}"
