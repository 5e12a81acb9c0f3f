"""How far the object turned from frame to frame, beside what the table was told."""

from typing import Any

import numpy as np

from fusion.geometry.pose import Array
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, GREY, RED, new_figure, styled, to_svg
from fusion.results.facts import TableFacts
from fusion.results.table_motion import SlipFound, TableMotion
from fusion.results.words import table_words


def step_degrees(turntable: TableMotion) -> Array:
    """(n,) turn since the previous frame [deg]; NaN at the first frame and beside rejected ones."""
    return np.degrees(np.diff(turntable.angles_rad, prepend=np.nan))


def expected_degrees(turntable: TableMotion) -> tuple[Array, str]:
    """(n,) how far the table should have turned [deg], in the direction of `angles_rad`, and by what: "log" or "even".

    The log where `told_rad` holds it, otherwise even steps of the median size.
    """
    steps = step_degrees(turntable)
    told = turntable.told_rad
    if told is not None and len(told) == len(steps) and np.isfinite(told).sum() > 1:
        change = np.degrees(np.diff(told, prepend=np.nan))
        sign = np.sign(np.nansum(change * steps)) or 1.0
        return np.asarray(sign * np.degrees(told)), "log"
    usual = float(np.nanmedian(steps)) if np.isfinite(steps).any() else 0.0
    return np.asarray(usual * np.arange(len(steps)), float), "even"


def excess_degrees(turntable: TableMotion) -> Array:
    """(n,) how much further each frame was turned than expected [deg], 0 on average over the frames before any slip."""
    excess = np.degrees(turntable.angles_rad) - expected_degrees(turntable)[0]
    first = min([slip.frame for slip in _slips(turntable)], default=len(excess))
    start = excess[:first]
    return excess - (np.nanmean(start) if np.isfinite(start).any() else 0.0)


def steps_figure(turntable: TableMotion, table: TableFacts | None = None) -> Figure:
    """Turn per frame beside the expected one, and how far they have come apart; slips marked in both."""
    steps = step_degrees(turntable)
    slips = _slips(turntable)
    expected, source = expected_degrees(turntable)
    against = "its log" if source == "log" else "even steps"
    title = "How the table turned" if table is None else f"The table turned {table_words(table)}"
    with styled():
        figure = new_figure(11.0, 5.0)
        above, below = figure.subplots(2, 1, sharex=True)
        _steps(above, steps, np.diff(expected, prepend=np.nan), slips)
        above.plot([], [], color=GREY, linewidth=1.4, label=against)
        above.legend(loc="upper center", bbox_to_anchor=(0.5, 1.2), ncols=3)
        _excess(below, turntable, slips, against)
        below.xaxis.get_major_locator().set_params(integer=True)
        svg = to_svg(figure, "steps")
    caption = (
        f"Beside {against}. Gaps are rejected frames. A slip's mark stands at the first frame after it. Below: the "
        "same added up, so that a slip stays as a jump and uneven steps wander; the band is two standard deviations of "
        "the angle's own fit."
    )
    return Figure(title, svg, title + ".", caption)


def _slips(turntable: TableMotion) -> list[SlipFound]:
    return [slip for slip in turntable.slips if 0 <= slip.frame < len(turntable.angles_rad)]


def _dots(frames: int) -> Any:
    return {"marker": "o", "markersize": 3.5} if frames < 400 else {}


def _steps(ax, steps: Array, expected: Array, slips: list[SlipFound]) -> None:
    frames = np.arange(len(steps))
    ax.plot(frames, expected, color=GREY, linewidth=1.4, zorder=1)
    ax.plot(frames, steps, color=BLUE, linewidth=1, label="step found", **_dots(len(steps)))
    for place, slip in enumerate(slips):
        _mark_slip(ax, slip, steps, "slip" if place == 0 else "_")
    ax.set_ylabel("turn since the\nframe before [deg]")
    ax.margins(x=0.01, y=0.2)


def _excess(ax, turntable: TableMotion, slips: list[SlipFound], against: str) -> None:
    excess = excess_degrees(turntable)
    frames = np.arange(len(excess))
    ax.axhline(0, color=GREY, linewidth=1)
    if turntable.angles_std_rad is not None:
        std = np.degrees(turntable.angles_std_rad)
        ax.fill_between(frames, excess - 2 * std, excess + 2 * std, color=BLUE, alpha=0.2, linewidth=0)
    ax.plot(frames, excess, color=BLUE, linewidth=1, **_dots(len(excess)))
    for slip in slips:
        ax.axvline(slip.frame - 0.5, color=RED, linewidth=1, linestyle=(0, (4, 3)))
    ax.set_xlabel("frame")
    ax.set_ylabel(f"turned further than\n{against} [deg]")
    ax.margins(x=0.01, y=0.15)


def _mark_slip(ax, slip: SlipFound, steps: Array, label: str) -> None:
    frame, amount = slip.frame, np.degrees(slip.angle_rad)
    height = steps[frame] if np.isfinite(steps[frame]) else 0.0
    ax.plot(frame, height, "D", color=RED, markersize=7, markerfacecolor="none", markeredgewidth=1.6, label=label)
    right = frame > 0.8 * len(steps)  # there the words would leave the picture
    ax.annotate(
        f"frame {frame}: {amount:+.1f} deg", (frame, height), (-9 if right else 9, 4), textcoords="offset points",
        ha="right" if right else "left", fontsize=9,
    )  # fmt: skip
