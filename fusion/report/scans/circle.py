"""Where the camera stood around the turntable's axis: the centres, the fitted circle and the deviations from it."""

from dataclasses import dataclass

import numpy as np

from fusion.geometry.pose import Array
from fusion.geometry.trajectory import Trajectory
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, GREY, INK, ORANGE, new_figure, styled, to_svg
from fusion.results.table_motion import TableMotion


@dataclass(frozen=True)
class Cylinder:
    """Camera centres in coordinates of the axis, each (n,); NaN where a frame has no pose."""

    # x, y: [m] across the axis, x towards the first camera
    x: Array
    y: Array
    azimuth: Array  # [rad]
    radial: Array  # [m] distance from the axis, less the circle's radius
    axial: Array  # [m] height along the axis, less the middle height


@dataclass(frozen=True)
class Paths:
    """The trajectory before and after the post-pass, and the axis; each may be missing."""

    raw: Trajectory | None
    corrected: Trajectory | None
    turntable: TableMotion

    def named(self) -> list[tuple[str, str, Cylinder]]:
        """(name, colour, centres about the axis) of those that are there and hold a pose."""
        pairs = [("raw", ORANGE, self.raw), ("corrected", BLUE, self.corrected)]
        return [(n, c, about_axis(t, self.turntable)) for n, c, t in pairs if t is not None and t.valid.any()]


def has_axis(turntable: TableMotion | None) -> bool:
    """True when there is a finite axis to draw about."""
    if turntable is None:
        return False
    known = np.isfinite([turntable.axis_point, turntable.axis_direction]).all()
    return bool(known and np.linalg.norm(turntable.axis_direction) > 1e-9)


def about_axis(trajectory: Trajectory, turntable: TableMotion) -> Cylinder:
    """The camera centres in coordinates of the axis."""
    direction = turntable.axis_direction / np.linalg.norm(turntable.axis_direction)
    offset = trajectory.centres - turntable.axis_point
    height = offset @ direction
    across = offset - height[:, None] * direction
    known = np.flatnonzero(np.isfinite(height))
    first = across[known[0]] if len(known) else np.zeros(3)
    helper = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    ex = first / np.linalg.norm(first) if np.linalg.norm(first) > 1e-9 else helper / np.linalg.norm(helper)
    x, y = across @ ex, across @ np.cross(direction, ex)
    distance = np.hypot(x, y)
    middle = np.median(height[known]) if len(known) else 0.0
    return Cylinder(x, y, np.arctan2(y, x), distance - _radius(turntable, distance), height - middle)


def circle_points(trajectory: Trajectory, turntable: TableMotion, count: int = 181) -> Array:
    """Points (count, 3) [m] of the fitted circle in the trajectory's frame."""
    c = about_axis(trajectory, turntable)
    d = turntable.axis_direction / np.linalg.norm(turntable.axis_direction)
    known = trajectory.centres[trajectory.valid]
    point = turntable.axis_point
    height = np.median((known - point) @ d)
    spoke = known[0] - point - ((known[0] - point) @ d) * d
    ex = spoke / max(np.linalg.norm(spoke), 1e-12)
    radius = np.nanmedian(np.hypot(c.x, c.y) - c.radial)
    turn = np.linspace(0, 2 * np.pi, count)[:, None]
    return point + height * d + radius * (np.cos(turn) * ex + np.sin(turn) * np.cross(d, ex))


def circle_figure(paths: Paths) -> Figure:
    """Top view of the centres with the fitted circle, and how far they stand off it radially and axially."""
    lines = paths.named()
    rms = {name: (_rms(c.radial) * 1000, _rms(c.axial) * 1000) for name, _, c in lines}
    said = "; ".join(f"{name} {r:.2f} mm radial, {a:.2f} mm axial" for name, (r, a) in rms.items())
    with styled():
        figure = new_figure(11.0, 4.6)
        axes = figure.subplot_mosaic([["top", "radial"], ["top", "axial"]], width_ratios=[1, 1.5], sharex=False)
        _top_view(axes["top"], lines)
        for kind in ("radial", "axial"):
            _deviations(axes[kind], lines, kind)
        axes["axial"].set_xlabel("position along the circle [deg]")
        axes["radial"].tick_params(labelbottom=False)
        svg = to_svg(figure, "circle")
    return Figure(
        f"Off the fitted circle (rms): {said}",
        svg,
        f"Top view of the camera centres around the fitted circle, and their deviations. Rms: {said}.",
        "Left: seen along the axis, x points to the first camera. Right: distance from the fitted circle, in its "
        "plane (radial) and out of it (axial). A corrected trajectory that is made of one rigid axis stands on the "
        "circle by construction; its raw deviations are what the tracking had wrong.",
    )


def _top_view(ax, lines) -> None:
    for name, color, c in lines:
        ax.plot(c.x * 1000, c.y * 1000, ".", color=color, markersize=6, label=name)
    c = lines[-1][2]
    radius = np.nanmedian(np.hypot(c.x, c.y) - c.radial) * 1000
    turn = np.linspace(0, 2 * np.pi, 361)
    ax.plot(radius * np.cos(turn), radius * np.sin(turn), color=GREY, linewidth=1, zorder=1, label="fitted circle")
    ax.plot(0, 0, "+", color=INK, markersize=9)
    ax.annotate("axis", (0, 0), (6, 6), textcoords="offset points", fontsize=9)
    ax.set_aspect("equal", "datalim")
    ax.set_xlabel("x [mm]")
    ax.set_ylabel("y [mm]")
    ax.set_title(f"Top view, radius {radius:.1f} mm")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=3, handletextpad=0.4, columnspacing=1.2)


def _deviations(ax, lines, kind: str) -> None:
    ax.axhline(0, color=GREY, linewidth=1)
    for name, color, c in lines:
        degrees, values = np.degrees(c.azimuth) % 360, getattr(c, kind) * 1000
        order = np.argsort(degrees)
        ax.plot(degrees[order], values[order], "o-", color=color, markersize=3.2, linewidth=1, label=name)
    ax.set_xlim(0, 360)
    ax.set_xticks(np.arange(0, 361, 45))
    ax.set_ylabel("[mm]")
    ax.set_title(f"{kind.capitalize()} deviation")


def _radius(turntable: TableMotion, distance: Array) -> float:
    if np.isfinite(turntable.radius):
        return turntable.radius
    known = distance[np.isfinite(distance)]
    return float(np.median(known)) if len(known) else 0.0


def _rms(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")
