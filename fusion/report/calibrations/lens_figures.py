"""What a camera calibration rests on and is good for: corners, what they leave over, and how well rays are known."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.lens.fit.solve import NAMES
from fusion.calibration.lens.intrinsics import CameraFit
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, DIVERGING, GREY, ORANGE, RED, SEQUENTIAL, new_figure, styled, to_svg

LONGEST_PX = 480  # of a picture on the page: enough to see the corners, small enough for many
ARROW = 0.06  # of the picture's width: length of the 95th percentile of the residuals


@dataclass(frozen=True)
class BoardPicture:
    """A picture of the board: what it is called, its grey values (h, w) uint8, corners (n, 2) [px], whether used."""

    name: str
    grey: NDArray[np.uint8]
    corners: NDArray
    used: bool


def brief(value: float) -> str:
    """Two digits, and no power of ten where there are zeros to write: 0.043, 6.2, 1200."""
    return f"{float(f'{value:.2g}'):g}"


def corners_figure(pictures: Sequence[BoardPicture], name: str) -> Figure:
    """A few of the pictures with the corners found in them."""
    columns = min(len(pictures), 4)
    rows = -(-len(pictures) // columns)
    height, width = pictures[0].grey.shape
    with styled():
        figure = new_figure(11.0, rows * (11.0 / columns * height / width + 0.3))
        grid = np.ravel(figure.subplots(rows, columns, squeeze=False))
        for ax, shown in zip(grid, pictures, strict=False):
            step = -(-max(shown.grey.shape) // LONGEST_PX)
            extent = (-0.5, width - 0.5, height - 0.5, -0.5)
            ax.imshow(shown.grey[::step, ::step], cmap="gray", vmin=0, vmax=255, extent=extent)
            color = BLUE if shown.used else RED
            ax.plot(*shown.corners.T, ".", color=color, markersize=3)
            ax.set_title(shown.name + ("" if shown.used else ": left out"), fontsize=8.5)
        for ax in grid:
            ax.set_axis_off()
        svg = to_svg(figure, f"corners-{name}")
    title = "The corners in some of the pictures"
    return Figure(title, svg, title + ".", "Contrast stretched. Left-out views, if any, come first.")


def residuals_figure(fit: CameraFit, name: str) -> Figure:
    """Every corner where it was seen, with an arrow of what the camera leaves over, and their scatter."""
    solution = fit.judged.solution
    pixels = np.concatenate([view.pixels for view in fit.judged.views])
    left = np.concatenate(solution.residuals)
    usual = float(np.percentile(np.linalg.norm(left, axis=1), 95))
    width, height = fit.camera.width, fit.camera.height
    scale = ARROW * width / max(usual, 1e-9)
    title = f"{len(pixels)} corners in {fit.coverage:.0%} of the picture leave {solution.rms:.3f} px rms"
    with styled():
        figure = new_figure(11.0, 11.0 * 0.68 * height / width * 0.85 + 0.6)
        axes: Any = figure.subplots(1, 2, width_ratios=[2.1, 1])
        ax = axes[0]
        ends = pixels + left * scale
        ax.plot(
            *np.stack([pixels, ends, np.full_like(ends, np.nan)], axis=1).reshape(-1, 2).T, color=BLUE, linewidth=0.6
        )
        ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), aspect="equal", xlabel="u [px]", ylabel="v [px]")
        ax.set_title(f"Seen minus predicted, {scale:.0f} times as long")
        axes[1].plot(*left.T, ".", color=BLUE, markersize=2, alpha=0.5)
        limit = float(np.abs(left).max()) * 1.05 + 1e-9
        axes[1].set(xlim=(-limit, limit), ylim=(limit, -limit), aspect="equal", xlabel="du [px]", ylabel="dv [px]")
        svg = to_svg(figure, f"residuals-{name}")
    caption = (
        "A lens that is described well leaves arrows without a pattern. Where no corners are, nothing was measured."
    )
    return Figure(title, svg, title + ".", caption)


def uncertainty_figure(fit: CameraFit, name: str) -> Figure:
    """How well it is known where rays go, over the picture, in pixels and millimetres."""
    known = fit.uncertainty
    at = known.numbers()
    title = (
        f"Rays are known to {brief(at['centre_px'])} px at the centre and {brief(at['worst_px'])} px in the worst "
        f"corner: {brief(at['centre_mm'])} and {brief(at['worst_mm'])} mm at {at['distance_m']:.2f} m"
    )
    seen = np.concatenate([view.pixels for view in fit.judged.views])
    with styled():
        figure = new_figure(11.0, 3.9)
        axes: Any = figure.subplots(1, 2)
        maps = ((known.sigma_px, "px"), (known.sigma_m * 1000, f"mm at {known.distance:.2f} m"))
        for ax, (values, unit) in zip(axes, maps, strict=True):
            # steps of the logarithm: the middle and the corners differ by orders of magnitude
            shown = np.log10(np.maximum(values, 1e-6))
            mesh = ax.contourf(known.pixels[..., 0], known.pixels[..., 1], shown, levels=12, cmap=SEQUENTIAL)
            ax.plot(*seen.T, ".", color=GREY, markersize=1)
            ax.set(aspect="equal", ylim=(fit.camera.height - 1, 0), xlabel="u [px]", ylabel="v [px]", title=f"[{unit}]")
            ax.grid(visible=False)
            bar = figure.colorbar(mesh, ax=ax, shrink=0.9)
            ticks = [float(tick) for tick in bar.get_ticks()]
            bar.set_ticks(ticks, labels=[brief(10**tick) for tick in ticks])
            bar.outline.set_visible(False)
        svg = to_svg(figure, f"uncertainty-{name}")
    caption = (
        "Standard deviation in the worst direction, a turn of the whole camera taken out. Grey: the corners that were "
        "seen; the further from them, the less is known."
    )
    return Figure(title, svg, title + ".", caption)


def views_figure(fit: CameraFit, name: str) -> Figure:
    """The error of every view, outliers too, and how far the camera moves without it."""
    judged, known = fit.judged, fit.spread
    used = {view.name: float(rms) for view, rms in zip(judged.views, judged.solution.view_rms, strict=True)}
    out = {o.name: o.rms_px for o in judged.outliers if np.isfinite(o.rms_px)}
    names = sorted(used | out)
    place = {view: i for i, view in enumerate(names)}
    title = f"{len(judged.outliers)} of {len(names)} views do not fit the others"
    with styled():
        figure = new_figure(11.0, 4.6)
        axes: Any = figure.subplots(2, 1, sharex=True)
        axes[0].bar([place[v] for v in used], list(used.values()), color=BLUE, label="used")
        if out:
            axes[0].bar([place[v] for v in out], list(out.values()), color=RED, label="does not fit", width=0.4)
            axes[0].set_yscale("log")
            axes[0].legend(ncols=2)
        axes[0].set_ylabel("error [px rms]")
        sigmas = known.shifts / known.std
        for column, color in ((0, BLUE), (2, ORANGE)):
            axes[1].plot(
                [place[v.name] for v in judged.views], sigmas[:, column], ".", color=color, label=NAMES[column]
            )
        axes[1].axhline(0, color=GREY, linewidth=1)
        axes[1].set_ylabel("moves without it [std]")
        axes[1].legend(ncols=2)
        if len(names) <= 40:
            axes[1].set_xticks(range(len(names)), names, rotation=90, fontsize=7)
        else:
            axes[1].set_xlabel("view")
        svg = to_svg(figure, f"views-{name}")
    caption = "Below: focal length and principal point without each view, in standard deviations."
    return Figure(title, svg, title + ".", caption)


def correlation_figure(fit: CameraFit, name: str) -> Figure:
    """Which parameters the views cannot tell apart."""
    correlation = fit.spread.correlation
    names = fit.judged.solution.names
    off = np.abs(correlation - np.eye(len(names)))
    i, j = np.unravel_index(int(np.argmax(off)), off.shape)
    title = f"{names[i]} and {names[j]} are told apart least: correlation {correlation[i, j]:+.2f}"
    with styled():
        figure = new_figure(6.4, 4.4)
        ax: Any = figure.subplots()
        ax.imshow(correlation, cmap=DIVERGING, vmin=-1, vmax=1)
        for (row, column), value in np.ndenumerate(correlation):
            color = "white" if abs(value) > 0.7 else "#222222"
            ax.text(column, row, f"{value:+.2f}", ha="center", va="center", fontsize=7.5, color=color)
        ax.set_xticks(range(len(names)), names)
        ax.set_yticks(range(len(names)), names)
        ax.grid(visible=False)
        svg = to_svg(figure, f"correlation-{name}")
    caption = "A strong correlation is no error; the pair is known better together than each alone."
    return Figure(title, svg, title + ".", caption)
