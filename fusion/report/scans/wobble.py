"""What one rigid axis leaves over: how the axis seems to rock, and the gap where a turn closes."""

from typing import Any

import numpy as np

from fusion.geometry.pose import Array
from fusion.geometry.trajectory import Trajectory
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, GREY, ORANGE, PURPLE, new_figure, styled, to_svg
from fusion.results.table_motion import TableMotion
from fusion.turntable.wobble import rocking


def wobble_figure(raw: Trajectory, turntable: TableMotion) -> Figure:
    """Tilt of the axis over the turn, and the gap where it closes, before and after the post-pass."""
    found = rocking(raw.poses[:, :3, :3], turntable.axis_direction)
    tilt, rms = np.degrees(found.tilt), float(np.degrees(found.rms))
    gaps = _gaps(turntable)
    title = f"The axis seems to rock by {rms:.2f} deg (rms)" + ("; " + _said(gaps) if gaps else "")
    with styled():
        figure = new_figure(11.0, 3.4)
        if gaps:
            axes = figure.subplots(1, 3, width_ratios=[2.2, 1, 1])
            for ax, unit, column in zip(axes[1:], ("mm", "deg"), (0, 1), strict=True):
                _bars(ax, gaps, column, unit)
        else:
            axes = [figure.subplots()]
        _rocking(axes[0], tilt, turntable)
        svg = to_svg(figure, "wobble")
    caption = (
        "From the freely tracked poses, before the post-pass: a table that wobbles repeats the same curve in every "
        "turn; what does not repeat is the tracking's own error, which the rigid axis takes out."
    )
    if gaps:
        caption += " Right: how far the two ends of a full turn miss each other, against their direct alignment."
    return Figure(title, svg, title + ".", caption)


def _gaps(turntable: TableMotion) -> list[tuple[str, str, tuple[float, float]]]:
    """(name, colour, (distance [mm], angle [deg])) of the closing gaps that are known."""
    out = []
    for name, color, gap in (("before", ORANGE, turntable.closure_raw), ("after", BLUE, turntable.closure)):
        if gap.distance is not None and gap.angle_rad is not None:
            out.append((name, color, (gap.distance * 1e3, float(np.degrees(gap.angle_rad)))))
    return out


def _said(gaps: list[tuple[str, str, tuple[float, float]]]) -> str:
    said = " and ".join(f"{gap[0]:.2f} mm, {gap[1]:.2f} deg {name}" for name, _, gap in gaps)
    return f"closing gap {said} the post-pass"


def _bars(ax, gaps: list[tuple[str, str, tuple[float, float]]], column: int, unit: str) -> None:
    for place, (_, color, gap) in enumerate(gaps):
        ax.bar(place, gap[column], color=color, width=0.6)
        ax.annotate(f"{gap[column]:.2f}", (place, gap[column]), (0, 3), textcoords="offset points", ha="center")
    ax.set_xticks(range(len(gaps)), [name for name, _, _ in gaps])
    ax.set_xlim(-0.7, len(gaps) - 0.3)
    ax.set_title(f"Closing gap [{unit}]")
    ax.margins(y=0.2)
    ax.grid(axis="x", visible=False)


def _rocking(ax, tilt: Array, turntable: TableMotion) -> None:
    angles = np.degrees(turntable.angles_rad)
    turned = angles if len(angles) == len(tilt) else np.arange(len(tilt)).astype(float)
    marker: Any = {"marker": "o", "markersize": 2.8} if len(tilt) < 400 else {}
    ax.axhline(0, color=GREY, linewidth=1)
    for column, (name, color) in enumerate((("away from the camera", BLUE), ("sideways", PURPLE))):
        ax.plot(turned, tilt[:, column], color=color, linewidth=1, label=name, **marker)
    ax.set_xlabel("object turned by [deg]" if len(angles) == len(tilt) else "frame")
    ax.set_ylabel("tilt [deg]")
    ax.set_title("How the axis seems to rock")
    ax.legend(loc="upper right", ncols=2)
    ax.margins(x=0.01, y=0.25)
