"""The noise of a target: over distance and tilt with its law, at edges, as histograms, and what came back at all."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.laws.axial import AxialLaw
from fusion.calibration.noise.laws.lateral import LateralForm, LateralLaw, TargetEdges
from fusion.calibration.noise.poses import Pose
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, GREEN, GREY, INK, ORANGE, RED, SEQUENTIAL, new_figure, styled, to_svg

HISTOGRAMS = 6  # poses shown
TILT_STEP = 15.0  # [deg] poses nearer than half of it share a curve
Array = NDArray[np.floating]


def axial_figure(law: AxialLaw) -> Figure:
    """Noise over distance, one curve per tilt, and over tilt, one curve per distance: points, law, 90 % band."""
    z, tilt = law.places.depth, law.places.tilt
    title = f"Axial noise from {np.min(law.sigma) * 1e3:.1f} to {np.max(law.sigma) * 1e3:.1f} mm; the law leaves "
    title += f"{law.best.rms * 1e3:.2f} mm rms"
    with styled():
        figure = new_figure(11.0, 4.6)
        left, right = figure.subplots(1, 2, sharey=True)
        tilts = np.round(np.rad2deg(tilt) / TILT_STEP) * TILT_STEP
        along = np.linspace(np.min(z), max(np.max(z), np.min(z) * 1.001), 80)
        for color, group in _colored(np.unique(tilts)):
            own = np.deg2rad(float(np.median(np.rad2deg(tilt[tilts == group]))))
            _curve(left, (along, *law.at(along, np.full_like(along, own))), color)
            _points(left, law, tilts == group, z, color=color, label=f"{group:.0f} deg")
        left.set_xlabel("distance [m]")
        left.set_ylabel("axial noise [mm]")
        left.legend(loc="upper left", title="tilt")
        distances = _groups(z)
        turned = np.linspace(0, max(float(np.max(tilt)), 0.01), 80)
        shown = np.unique(distances)
        shown = shown[np.unique(np.linspace(0, len(shown) - 1, 5).round().astype(int))]
        for color, group in _colored(shown):
            own = float(z[distances == group].mean())
            _curve(right, (np.rad2deg(turned), *law.at(np.full_like(turned, own), turned)), color)
            _points(right, law, distances == group, np.rad2deg(tilt), color=color, label=f"{own:.2f} m")
        right.set_xlabel("tilt of the target [deg]")
        right.legend(loc="upper left", title="distance")
        left.set_ylim(bottom=0)
        svg = to_svg(figure, "axial-noise")
    caption = (
        "Points: standard deviation over the frames, rounding taken out, with its own deviation. Lines: the fitted "
    )
    caption += "law at the tilt or distance of the points; bands: its 90 % interval, from the scatter between poses."
    return Figure(title, svg, title + ".", caption)


def residual_figure(law: AxialLaw) -> Figure:
    """Measured over fitted noise of each pose, as a map over distance and tilt."""
    ratio = law.sigma / law.form.predict(law.best.numbers)
    off = float(np.max(np.abs(ratio - 1)))
    title = f"Measured over fitted noise: all within {100 * off:.1f} %"
    half = max(off, 0.01) * 100
    with styled():
        figure = new_figure(11.0, 3.6)
        ax = figure.subplots()
        drawn = ax.scatter(law.places.depth, np.rad2deg(law.places.tilt), c=100 * (ratio - 1), s=90, cmap="RdBu_r",
                           vmin=-half, vmax=half, edgecolors=GREY, linewidths=0.6)  # fmt: skip
        ax.set_xlabel("distance [m]")
        ax.set_ylabel("tilt [deg]")
        ax.margins(y=0.1)
        figure.colorbar(drawn, ax=ax, label="measured over fitted - 1 [%]")
        svg = to_svg(figure, "axial-residuals")
    text = "A region of one colour would be noise that the law does not hold."
    return Figure(title, svg, title + ".", text)


def lateral_figure(law: LateralLaw) -> Figure:
    """Jitter of the edges over distance and tilt, with the 90th percentiles."""
    edges = law.edges
    title = "Lateral noise: " + ", ".join(
        f"90 % of the edges {text} below {value * 1e3:.2f} mm"
        for text, value in (("without shadow", law.percentile), ("beside a shadow", law.percentile_shadow))
        if np.isfinite(value)
    )
    with styled():
        figure = new_figure(11.0, 4.2)
        left, right = figure.subplots(1, 2, sharey=True)
        for name, which, color, mark, line in (
            ("without shadow", ~edges.shadowed, BLUE, "o", law.percentile),
            ("beside a shadow", edges.shadowed, ORANGE, "s", law.percentile_shadow),
        ):
            for ax, x in ((left, edges.depth), (right, np.rad2deg(edges.tilt))):
                if which.any():
                    ax.errorbar(x[which], edges.sigma[which] * 1e3, edges.sigma_std[which] * 1e3, fmt=mark, color=color,
                                markersize=3.5, elinewidth=0.7, label=name)  # fmt: skip
                    ax.axhline(line * 1e3, color=color, linestyle="--", linewidth=1, label="90th percentile")
        _lateral_law(left, law, edges)
        left.set_xlabel("distance of the edge [m]")
        left.set_ylabel("lateral noise [mm]")
        right.set_xlabel("tilt of the target [deg]")
        left.set_ylim(0, 1.4e3 * float(np.max(edges.sigma)))
        left.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, borderaxespad=0.1)
        svg = to_svg(figure, "lateral-noise")
    caption = (
        "Spread of the pixels in which a target ends, over rows and frames, times distance over focal length; the "
    )
    return Figure(title, svg, title + ".", caption + "rounding to pixels is taken out.")


def histograms_figure(poses: Sequence[Pose]) -> Figure:
    """Histograms of single depths about their pixel's mean, with the fitted normal."""
    known = [pose for pose in poses if len(pose.seen.z_scores) > 100]
    some = (
        [known[i] for i in np.unique(np.linspace(0, len(known) - 1, HISTOGRAMS).round().astype(int))] if known else []
    )
    everything = np.concatenate([pose.seen.z_scores for pose in known]) if known else np.zeros(1)
    wide = float((np.abs(everything) > 3).mean())
    title = f"{100 * wide:.2f} % of the depths are more than three standard deviations off (normal: 0.27 %)"
    with styled():
        figure = new_figure(11.0, 2.6)
        axes = figure.subplots(1, max(len(some), 1), squeeze=False, sharey=True)[0]
        for ax, pose in zip(axes, some, strict=False):
            # steps of the rounding, where they are coarse, or a quarter of a standard deviation
            step = pose.seen.step / pose.seen.axial if pose.seen.axial > 0 else 0.25
            bins = np.arange(-4.125, 4.2, max(0.25, step))
            ax.hist(pose.seen.z_scores, bins=bins, density=True, color=BLUE, alpha=0.5)
            mean, std = float(np.mean(pose.seen.z_scores)), float(np.std(pose.seen.z_scores))
            x = np.linspace(-4, 4, 120)
            ax.plot(x, np.exp(-0.5 * ((x - mean) / std) ** 2) / (std * np.sqrt(2 * np.pi)), color=INK, linewidth=1)
            ax.set_title(f"{pose.depth:.2f} m, {np.rad2deg(pose.tilt):.0f} deg", fontsize=8.5)
            ax.set_yticks([])
        axes[0].set_ylabel("density")
        figure.supxlabel("depth less its pixel's mean [standard deviations]", fontsize=9)
        svg = to_svg(figure, "noise-histograms")
    return Figure(title, svg, title + ".", "Line: the normal distribution with the mean and the deviation of the bars.")


def shares_figure(poses: Sequence[Pose]) -> Figure:
    """Valid, no-data and outlier shares of the target, stacked, over distance and tilt."""
    least = min(pose.seen.valid for pose in poses)
    title = f"At least {100 * least:.0f} % of the target's pixels are valid at every pose"
    if least < 0.9:
        title = f"Valid pixels fall to {100 * least:.0f} %"
    with styled():
        figure = new_figure(11.0, 3.4)
        left, right = figure.subplots(1, 2, sharey=True)
        tilts = np.round(np.rad2deg([pose.tilt for pose in poses]) / TILT_STEP) * TILT_STEP
        distances = _groups(np.array([pose.depth for pose in poses]))
        for ax, groups, label in (
            (left, distances, "distance [m]"), (right, tilts, "tilt [deg]")
        ):  # fmt: skip
            shown = np.unique(groups)
            stacks = np.array([
                np.mean([(p.seen.valid, p.seen.no_data, p.seen.outliers)
                         for p, g in zip(poses, groups, strict=True) if g == group], axis=0)
                for group in shown
            ])  # fmt: skip
            bottom = np.zeros(len(shown))
            for share, name, color in zip(
                100 * stacks.T, ("valid", "no data", "outliers"), (GREEN, GREY, RED), strict=True
            ):
                ax.bar(np.arange(len(shown)), share, bottom=bottom, color=color, width=0.75, label=name)
                bottom += share
            texts = [f"{g:.2f}" if ax is left else f"{g:.0f}" for g in shown]
            ax.set_xticks(np.arange(len(shown)), texts)
            ax.grid(axis="x", visible=False)
            ax.set_xlabel(label)
        left.set_ylabel("pixels of the target [%]")
        left.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, borderaxespad=0.1)
        svg = to_svg(figure, "noise-shares")
    text = (
        "Means over the poses at each distance and at each tilt. Outliers: more than six standard deviations and 3 cm "
    )
    return Figure(title, svg, title + ".", text + "off the target's plane.")


def _lateral_law(ax: Any, law: LateralLaw, edges: TargetEdges) -> None:
    """The law that the sensor model holds, over distance."""
    z = np.linspace(np.min(edges.depth), np.max(edges.depth), 50)
    effect = law.effect
    assert isinstance(law.held.form, LateralForm)
    fx = law.held.form.fx
    ax.plot(z, 1e3 * (float(effect.sigma) + float(effect.sigma_px) * z / fx), color=INK, linewidth=1.2, label="law")


def _groups(z: Array) -> Array:
    """(n,) the mean of the values that are within some per cent of each other."""
    order = np.argsort(z)
    label = np.zeros(len(z), int)
    label[order] = np.insert(np.cumsum(np.diff(z[order]) > 0.05 * z[order][:-1]), 0, 0)
    means = np.array([z[label == i].mean() for i in range(label.max() + 1)])
    return np.asarray(means[label])


def _colored(groups: Array) -> list[tuple[Any, float]]:
    """A colour for each group, in order."""
    from matplotlib import colormaps

    shades = colormaps[SEQUENTIAL](np.linspace(0.05, 0.85, len(groups)))
    return [(tuple(shade), float(group)) for shade, group in zip(shades, groups, strict=True)]


def _curve(ax: Any, curve: tuple[Array, Array, Array], color: Any) -> None:
    x, value, half = curve
    ax.plot(x, value * 1e3, color=color, linewidth=1.2)
    ax.fill_between(x, (value - half) * 1e3, (value + half) * 1e3, color=color, alpha=0.15, linewidth=0)


def _points(ax: Any, law: AxialLaw, which: NDArray[np.bool_], x: Array, **style: Any) -> None:
    ax.errorbar(x[which], law.sigma[which] * 1e3, law.sigma_std[which] * 1e3, fmt="o", markersize=3.5,
                elinewidth=0.8, **style)  # fmt: skip
