"""How well each frame fitted: residual, inlier share, and which frames were rejected and why."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fusion.geometry.pose import Array
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, GREEN, GREY, RED, new_figure, styled, to_svg

NAMED = 6  # rejected frames that get their reason written into the picture


def frames_figure(residual: Array | None, inlier_share: Array | None, rejected: Mapping[int, str]) -> Figure:
    """Residual [mm] and inlier share [%] per frame, each (n,) or None, with the rejected frames marked."""
    series = [
        ("residual [mm]", BLUE, None if residual is None else np.asarray(residual, float).ravel() * 1000),
        ("inlier share [%]", GREEN, None if inlier_share is None else np.asarray(inlier_share, float).ravel() * 100),
    ]
    present = [(name, color, values) for name, color, values in series if values is not None]
    count = max([len(values) for _, _, values in present] + [max(rejected, default=-1) + 1])
    title = f"{count - len(rejected)} of {count} frames used"
    with styled():
        figure = new_figure(11.0, 1.1 + 1.75 * len(present))
        axes = figure.subplots(len(present), 1, squeeze=False, sharex=True)[:, 0]
        for ax, (name, color, values) in zip(axes, present, strict=True):
            _draw(ax, values, color, name, rejected)
        _reasons(axes[0], rejected)
        axes[-1].set_xlabel("frame")
        axes[-1].set_xlim(-0.5, max(count, 1) - 0.5)
        svg = to_svg(figure, "frames")
    return Figure(
        title,
        svg,
        f"{title}. Frames rejected: {', '.join(map(str, sorted(rejected))) or 'none'}.",
        "Residual: distance of the frame's inliers from the model they were placed on (rms). Dashed lines mark "
        "rejected frames; their reasons stand in the table below." if rejected else
        "Residual: distance of the frame's inliers from the model they were placed on (rms).",
    )  # fmt: skip


def _draw(ax, values: Array, color: str, name: str, rejected: Mapping[int, str]) -> None:
    frames = np.arange(len(values))
    marker: Any = {"marker": "o", "markersize": 3.2} if len(values) < 400 else {}
    ax.plot(frames, values, color=color, linewidth=1, **marker)
    known = values[np.isfinite(values)]
    if len(known):
        middle = np.median(known)
        ax.axhline(middle, color=GREY, linewidth=1)
        ax.annotate(
            f"median {middle:.3g}", (1, middle), (4, 0), xycoords=("axes fraction", "data"), fontsize=8.5,
            textcoords="offset points", va="center", annotation_clip=False,
        )  # fmt: skip
    else:
        ax.text(0.5, 0.5, "no frame has a value", transform=ax.transAxes, ha="center", va="center")
    top = max(float(np.max(known)) * 1.15 if len(known) else 1.0, 1e-3)
    ax.set_ylim(0, min(top, 104) if "%" in name else top)
    ax.set_ylabel(name)
    for frame in rejected:
        ax.axvline(frame, color=RED, linewidth=1, linestyle=(0, (4, 3)))


def _reasons(ax, rejected: Mapping[int, str]) -> None:
    for frame in sorted(rejected):
        ax.plot(frame, 1.0, "x", color=RED, markersize=6, clip_on=False, transform=ax.get_xaxis_transform())
    if len(rejected) > NAMED:
        return
    for frame, reason in sorted(rejected.items()):
        short = reason if len(reason) <= 34 else reason[:33] + "\u2026"
        ax.annotate(
            f"{frame}: {short}", (frame, 1.0), (3, 6), xycoords=ax.get_xaxis_transform(),
            textcoords="offset points", rotation=12 if len(rejected) > 1 else 0, fontsize=8.5, annotation_clip=False,
        )  # fmt: skip
