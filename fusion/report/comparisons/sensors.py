"""The page of `fusion sensor compare`: two sides over depth, and as each would see a step."""

import zlib
from pathlib import Path

import numpy as np

from fusion.geometry.camera import Camera
from fusion.report.kit.page import Figure, Number, Page, Section, write_page
from fusion.report.kit.palette import BLUE, DIVERGING, ORANGE, new_figure, styled, to_svg
from fusion.report.kit.tables import numbers_table
from fusion.sensor.sensor import Sensor
from fusion.simulation.exporting.compare import SensorComparison
from fusion.simulation.ideal.frame import IdealFrame
from fusion.simulation.ideal.sense import sense

NEAR, FAR = 1.0, 1.3  # [m] of the step that both look at


def write_comparison_page(path: Path, found: SensorComparison, models: list[Sensor], camera: Camera) -> None:
    """The page, whole or not at all; `models` are pictured, one or two."""
    sections = [Section("Over depth", "", (curves(found),), html=_table(found))]
    sections.append(Section("A step as each sees it", "", tuple(step(model, camera) for model in models)))
    if found.parameters:
        sections.append(Section("Parameters", "", html=_parameters(found)))
    apart = 1e3 * found.apart
    page = Page(
        title=f"{found.one.name} and {found.other.name}",
        subtitle="two sensors side by side",
        numbers=[
            Number("apart, at most", f"{np.nanmax(apart):.3g}", "mm"),
            Number("at least", f"{np.nanmin(apart):.3g}", "mm"),
        ],
        sections=sections,
        warnings=[],
    )
    write_page(path, page)


def curves(found: SensorComparison) -> Figure:
    """Mean error and spread over depth."""
    with styled():
        figure = new_figure(11.0, 3.6)
        axes = figure.subplots(1, 2)
        for ax, what, name in zip(axes, ("bias", "sigma"), ("mean error", "spread"), strict=True):
            for side, color, marker in ((found.one, BLUE, "o"), (found.other, ORANGE, "s")):
                ax.plot(
                    found.depths, 1e3 * getattr(side, what), marker=marker, color=color, label=side.name, markersize=4
                )
            ax.set_xlabel("depth [m]")
            ax.set_ylabel(f"{name} [mm]")
        axes[1].legend(loc="upper left")
        svg = to_svg(figure, "over-depth")
    alt = f"Mean error and spread of {found.one.name} and {found.other.name} over depth."
    return Figure(
        "Mean error and spread", svg, alt, "Before frontal walls, over the image; a recording has no mean error."
    )


def step(model: Sensor, camera: Camera) -> Figure:
    """The error of one frame of a step between two walls."""
    depth = np.full(camera.shape, NEAR, np.float32)
    depth[:, camera.width // 2 :] = FAR
    seen = sense(IdealFrame(depth, reflectance=0.5), camera, model, seed=1).depth
    error = 1e3 * (seen - depth)
    limit = float(np.nanpercentile(np.abs(error), 95)) if np.isfinite(error).any() else 1.0
    with styled():
        figure = new_figure(7.0, 4.2)
        ax = figure.subplots()
        ax.grid(False)
        shown = ax.imshow(error, cmap=DIVERGING, vmin=-limit, vmax=limit, interpolation="nearest")
        figure.colorbar(shown, ax=ax, label="error [mm]")
        svg = to_svg(figure, f"step-{zlib.crc32(repr(model).encode()):08x}", photos=True)
    lost = float(np.isnan(error).mean())
    title = f"{model.name}: {100 * lost:.1f} % of the pixels have no value"
    caption = f"Error of one frame; walls at {NEAR:g} m (left) and {FAR:g} m (right), of half the reflectance of white."
    return Figure(title, svg, f"Errors of {model.name} at a step.", caption)


def _table(found: SensorComparison) -> str:
    head = ["depth [m]", f"{found.one.name}: mean error [mm]", "spread [mm]", "missing"]
    head += [f"{found.other.name}: mean error [mm]", "spread [mm]", "missing", "apart [mm]"]
    rows = []
    for row, depth in enumerate(found.depths):
        cells = [f"{depth:.3g}"]
        for side in (found.one, found.other):
            cells += [_mm(side.bias[row]), _mm(side.sigma[row]), f"{100 * side.missing[row]:.1f} %"]
        rows.append([*cells, _mm(found.apart[row])])
    return numbers_table(head, rows)


def _parameters(found: SensorComparison) -> str:
    rows = [[name, _value(a), _value(b)] for name, (a, b) in found.parameters.items()]
    return numbers_table(["parameter", found.one.name, found.other.name], rows)


def _mm(value: float) -> str:
    return "" if not np.isfinite(value) else f"{1e3 * value:.2f}"


def _value(value: float | None) -> str:
    return "" if value is None else f"{value:.5g}"
