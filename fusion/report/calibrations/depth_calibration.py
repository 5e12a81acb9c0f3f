"""The report of a depth calibration: the curve, the maps, the candidates, what cannot be seen."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.calibration import DepthCalibration
from fusion.report.calibrations.depth_bias import SHOWN, candidates_figure, curve_figure, maps_figure
from fusion.report.kit.page import Figure, Number, Page, Section, write_page
from fusion.report.kit.tables import folded, numbers_table
from fusion.results.light import Light, level
from fusion.sensor.words.description import MapSummary, description

LONGEST = 20  # rows of a table that is open
LITTLE = 0.2  # share of the image below which one picture's map tells nothing
SHARE_LEFT = (0.5, 0.9)  # of the error that a correction may leave over: good up to, a problem above (guesses)


def depth_report(path: Path, found: DepthCalibration, command: str = "", settings: Mapping | None = None) -> None:
    """Write `report.html` of a depth calibration."""
    page = Page(
        title="Depth calibration",
        subtitle=f"{_count(found)}; {found.camera.principle}, {found.camera.width} x {found.camera.height} px",
        summary=_summary(found),
        numbers=_numbers(found),
        sections=[
            Section("Error over distance", figures=_curve(found), html=_walls(found)),
            Section("Error over the image", figures=(_maps(found),)),
            Section("Which law", figures=(_bars(found),), html=_candidates(found)),
            Section("What was found", _lead(found), html=_parameters(found)),
            Section("What these recordings can show", html=_visible(found)),
        ],
        warnings=[Light(severity, "", text) for severity, text in found.notes],
        settings=settings,
        command=command,
    )
    write_page(path, page)


def _summary(found: DepthCalibration) -> list[Light]:
    before, after = found.before.error, found.best.error
    if len(found.walls) > 1:
        text = f"On walls that were left out the error falls from {before * 1e3:.2f} to {after * 1e3:.2f} mm rms"
        text += ", what the board's gloss mirrors taken out too." if "gloss" in found.best.law.keys else "."
        lines = [Light(level(after / before if before else 1.0, SHARE_LEFT), "Correction", text)]
        lines.append(Light("ok", "Law", f"Chosen of {len(found.judged)} candidates: {found.best.candidate.name}."))
    else:
        lines = [Light("bad", "Correction", "None: of a single wall nothing can be left out to judge a law.")]
    seen = {v.term.effect for v in found.visibility if v.seen}
    hidden = sorted({v.term.effect for v in found.visibility if not v.seen} - seen)
    if hidden:
        lines.append(Light("warning", "Not seen", "These recordings say nothing about: " + ", ".join(hidden) + "."))
    if any(wall.by_board for wall in found.walls):
        text = "Its printed size looks like a scale of all depths, and its flatness is not known: measure it."
        lines.append(Light("warning", "Board", text))
    if found.fitted.scatter > 0:
        text = f"The walls scatter by {found.fitted.scatter * 1e3:.1f} mm more than their stated distances would."
        lines.append(Light("warning", "Distances", text))
    return lines


def _count(found: DepthCalibration) -> str:
    return "one wall" if len(found.walls) == 1 else f"{len(found.walls)} walls"


def _numbers(found: DepthCalibration) -> list[Number]:
    numbers = [
        Number("Walls", str(len(found.walls))),
        Number("Frames", str(sum(wall.frames for wall in found.walls))),
        Number("Error before", f"{found.before.error * 1e3:.2f}", "mm"),
        Number("Error left, held out", f"{found.best.error * 1e3:.2f}", "mm"),
    ]
    limit = found.radial_limit
    numbers.append(
        Number("As good up to a radius of", "everywhere" if limit is None else f"{limit:.0f}", "px" if limit else "")
    )
    if found.curve is not None:
        widest = float(np.max(found.curve.half_width)) * 1e3
        numbers.append(Number("Widest half of the 90 % interval", f"{widest:.2f}", "mm"))
    return numbers


def _curve(found: DepthCalibration) -> tuple[Figure, ...]:
    if found.curve is None:
        return ()
    distance = np.array([wall.distance for wall in found.walls])
    return (curve_figure(found.curve, distance, found.offset, found.offset_std),)


def _walls(found: DepthCalibration) -> str:
    rows = []
    for wall, offset, after in zip(found.walls, found.offset, found.best.rms, strict=True):
        stated = f"{wall.distance:.4f}" if np.isfinite(wall.distance) else "unknown"
        off = f"{offset * 1e3:+.2f}" if np.isfinite(offset) else "unknown"
        share = f"{100 * wall.mask.mean():.2g}" if wall.mask.mean() < 0.1 else f"{100 * wall.mask.mean():.0f}"
        rows.append([wall.name, str(wall.frames), stated, off, f"{np.degrees(wall.plane.tilt):.2f}", share,
                     f"{after * 1e3:.2f}"])  # fmt: skip
    head = ["wall", "frames", "distance [m]", "error on the axis [mm]", "tilt [deg]", "of the image [%]",
            "left, held out [mm]"]  # fmt: skip
    return _folded(head, rows, "walls")


def _folded(head: list[str], rows: list[list[str]], what: str) -> str:
    """A table, which opens on a click where it is long."""
    table = numbers_table(head, rows)
    return table if len(rows) <= LONGEST else folded(f"All {len(rows)} {what}", table)


def _maps(found: DepthCalibration) -> Figure:
    evidence = found.fitted.evidence
    seen = np.array([np.isfinite(e.tiles.image(e.rest)).mean() for e in evidence])
    alone = seen.max() < LITTLE  # boards without walls: those of like distances together
    large = np.flatnonzero(alone | (seen >= seen.max() / 2))  # boards beside walls show little of the image
    order = large[np.argsort([found.walls[i].depth_there for i in large])]
    if alone:
        groups = [group for group in np.array_split(order, SHOWN) if len(group)]
    else:
        groups = [order[[i]] for i in np.unique(np.linspace(0, len(order) - 1, SHOWN).round().astype(int))]
    images: list[tuple[str, NDArray[np.floating], NDArray[np.floating]]] = []
    for group in groups:
        low, high = (f"{found.walls[i].depth_there:.2f}" for i in (group[0], group[-1]))
        name = f"{low} m" if len(group) == 1 else f"{low} to {high} m, {len(group)} boards"
        before, after = (
            _mean([evidence[i].tiles.image(j.residual[i]) for i in group]) for j in (found.before, found.best)
        )
        images.append((name, before, after))
    return maps_figure(images)


def _mean(images: list[NDArray[np.floating]]) -> NDArray[np.floating]:
    """Mean (rows, columns) of what is known."""
    stack = np.array(images)
    known = np.isfinite(stack).sum(axis=0)
    return np.where(known > 0, np.nansum(stack, axis=0) / np.maximum(known, 1), np.nan)


def _bars(found: DepthCalibration) -> Figure:
    errors = np.array([j.error for j in found.judged])
    offsets = np.array([j.axis_error for j in found.judged])
    return candidates_figure([j.candidate.name for j in found.judged], errors, offsets, found.chosen)


def _candidates(found: DepthCalibration) -> str:
    total = sum(len(e.rest) for e in found.fitted.evidence)
    rows = [
        [
            j.candidate.name + (" (chosen)" if i == found.chosen else ""),
            str(j.candidate.numbers),
            f"{j.error * 1e3:.3f}",
            "unknown" if np.isnan(j.axis_error) else f"{j.axis_error * 1e3:.3f}",
            f"{j.chi2.sum() / total:.3f}",
        ]
        for i, j in enumerate(found.judged)
    ]
    head = ["law", "numbers", "held-out error [mm]", "on the axis [mm]", "weighted, per tile"]
    return _folded(head, rows, "candidates")


def _lead(found: DepthCalibration) -> str:
    bound = " ".join(filter(None, (found.sensor.sensor, found.sensor.serial and f"serial {found.sensor.serial}")))
    return f"Bound to {bound}." if bound else "Bound to no unit: camera.json names neither sensor nor serial."


def _parameters(found: DepthCalibration) -> str:
    old = {id(effect) for effect in found.fitted_from.effects}
    new = {effect.name for effect in found.sensor.effects if id(effect) not in old}
    rows = []
    for effect in description(found.sensor).effects:
        for name, row in effect.parameters.items():
            if effect.effect in new:
                rows.append([f"{effect.effect}.{name}", _short(row.value), _short(row.std), row.unit])
    return numbers_table(["effect", "value", "standard deviation", "unit"], rows)


def _short(value: object) -> str:
    if value is None:
        return "unknown"
    if isinstance(value, MapSummary):
        return f"{' x '.join(map(str, value.shape))} values, rms {value.rms:.4g}"
    if isinstance(value, list):
        if len(value) <= 8 or not isinstance(value[0], float):
            return ", ".join(map(_short, value)) if len(value) <= 8 else f"{len(value)} values"
        return f"{len(value)} values from {min(value):.3g} to {max(value):.3g}"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _visible(found: DepthCalibration) -> str:
    rows, waves = [], 0
    for v in found.visibility:
        if v.term.key.startswith(("sin", "cos", "curve")):
            waves += not v.seen
            continue
        smallest = (
            f"{v.smallest:.2g} {'' if v.term.unit == '1' else v.term.unit}" if np.isfinite(v.smallest) else "none"
        )
        rows.append([f"{v.term.effect}.{v.term.parameter} ({v.term.key})", f"{100 * v.share:.1f}", smallest,
                     "yes" if v.seen else "no: record " + v.record])  # fmt: skip
    return numbers_table(["number", "survives free tilts [%]", "found from, alone", "seen"], rows)
