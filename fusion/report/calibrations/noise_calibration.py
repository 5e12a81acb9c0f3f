"""The report of a noise calibration: laws over distance and tilt, edges, histograms, shares, what cannot be seen."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from fusion.calibration.noise.calibration import NoiseCalibration
from fusion.calibration.noise.laws.fit import NoiseFit
from fusion.report.calibrations.noise_laws import (
    axial_figure,
    histograms_figure,
    lateral_figure,
    residual_figure,
    shares_figure,
)
from fusion.report.kit.page import Number, Page, Section, write_page
from fusion.report.kit.tables import numbers_table
from fusion.results.light import Light, level
from fusion.sensor.parameter import parameters
from fusion.sensor.words.quantity import NOT_DETERMINED, fitted

# where a line turns yellow, and red (guesses)
WIDE_SHARE = (0.05, 0.2)  # half the 90 % interval over the noise, at the poses
SCATTER = (0.03, 0.1)  # by which poses scatter beyond their own errors


def noise_report(path: Path, found: NoiseCalibration, command: str = "", settings: Mapping | None = None) -> None:
    """Write `report.html` of a noise calibration."""
    page = Page(
        title="Noise calibration",
        subtitle=f"{len(found.poses)} poses of a target; {found.camera.principle}, "
        f"{found.camera.width} x {found.camera.height} px",
        summary=_summary(found),
        numbers=_numbers(found),
        sections=[
            Section("Axial noise", figures=(axial_figure(found.axial), residual_figure(found.axial)),
                    html=_parameters(found)),
            Section("Which law", html=_candidates(found.axial.fits, found.axial.chosen, 1e3)),
            Section("Lateral noise", figures=(lateral_figure(found.lateral),) if found.lateral else (),
                    html=_lateral(found)),
            Section("Distribution", figures=(histograms_figure(found.poses),)),
            Section("Valid pixels", figures=(shares_figure(found.poses),)),
            Section("Poses", html=_poses(found)),
        ],
        warnings=[Light(severity, "", text) for severity, text in found.notes],
        settings=settings,
        command=command,
    )  # fmt: skip
    write_page(path, page)


def _summary(found: NoiseCalibration) -> list[Light]:
    law = found.axial
    value, half = law.at(law.places.depth, law.places.tilt)
    widest = float(np.max(half / np.maximum(value, 1e-9)))
    text = f"Known to {100 * widest:.1f} % or better at every pose (90 % interval)."
    lines = [Light(level(widest, WIDE_SHARE), "Axial law", text)]
    lines.append(Light("ok", "Form", f"Chosen of {len(law.fits)} by held-out poses: {law.form.title}."))
    text = f"Beyond their measurements' own errors, poses scatter by {100 * law.best.scatter:.1f} % about it."
    lines.append(Light(level(law.best.scatter, SCATTER), "NoiseFit", text))
    if law.visible.hidden:
        text = "These recordings say nothing about: " + ", ".join(law.visible.hidden) + "."
        lines.append(Light("warning", "Not seen", text))
    if found.lateral is None:
        lines.append(Light("warning", "Lateral noise", "No target with a free left and right edge was seen."))
    return lines


def _numbers(found: NoiseCalibration) -> list[Number]:
    numbers = [
        Number("Poses", str(len(found.poses))),
        Number("Frames", str(sum(pose.seen.frames for pose in found.poses))),
        Number("Left over by the axial law", f"{found.axial.best.rms * 1e3:.3f}", "mm rms"),
    ]
    if found.lateral is not None:
        for name, value in (("Lateral, 90th percentile", found.lateral.percentile),
                            ("Beside a shadow", found.lateral.percentile_shadow)):  # fmt: skip
            if np.isfinite(value):
                numbers.append(Number(name, f"{value * 1e3:.2f}", "mm"))
    return numbers


def _parameters(found: NoiseCalibration) -> str:
    fits: list[tuple[str, NoiseFit]] = [("axial_noise", found.axial.best)]
    if found.lateral is not None:
        fits.append(("lateral_noise", found.lateral.held))
    rows = []
    for effect, fit in fits:
        model = found.sensor.effect(effect)
        assert model is not None
        units = {name: about.unit for name, about in parameters(model).items()}
        wide = fit.half_width()
        for i, (name, value, std) in enumerate(zip(fit.form.names, fit.numbers, fit.std, strict=True)):
            others = [f"{fit.form.names[k]} {fit.correlation[i, k]:+.2f}" for k in range(len(fit.numbers)) if k != i]
            least, most = (edge[i] for edge in fit.form.bounds())
            low, high = np.clip([value - wide * std, value + wide * std], least, most)
            said = [f"{value:.5g}", f"{std:.2g}", f"{low:.5g} to {high:.5g}"]
            if not fitted(model, name, value, std).determined:
                said = [NOT_DETERMINED, "", ""]
            rows.append([f"{effect}.{name}", *said, units[name], ", ".join(others)])
    if found.dropout is not None:
        for name, value, std in zip(("ir_threshold", "width"), found.dropout.numbers, found.dropout.std, strict=True):
            rows.append([f"amplitude_dropout.{name}", f"{value:.4g}", f"{std:.2g}", "", "count", ""])
    rows += [[f"axial_noise.{name}", f"{value:.5g}", "kept from --sensor", "", "", ""]
             for name, value in found.axial.kept.items()]  # fmt: skip
    return numbers_table(["number", "value", "standard deviation", "90 % interval", "unit", "correlation with"], rows)


def _candidates(fits: list[NoiseFit], chosen: int, scale: float) -> str:
    rows = [
        [fit.form.title + (" (chosen)" if i == chosen else ""), str(len(fit.numbers)), f"{fit.score:.2f}",
         f"{fit.rms * scale:.3f}", f"{100 * fit.scatter:.1f}"]
        for i, fit in enumerate(fits)
    ]  # fmt: skip
    head = ["law", "numbers", "held-out error over a measurement's own", "left over [mm rms]", "scatter of poses [%]"]
    return numbers_table(head, rows)


def _lateral(found: NoiseCalibration) -> str:
    law = found.lateral
    if law is None:
        return ""
    rows = []
    for i, fit in enumerate(law.fits):
        numbers = ", ".join(
            f"{name} {1e3 * v:.2f} +- {1e3 * s:.2f} mm" if name == "sigma" else f"{name} {v:.3f} +- {s:.3f}"
            for name, v, s in zip(fit.form.names, fit.numbers, fit.std, strict=True)
        )
        rows.append([fit.form.title + (" (chosen)" if i == law.chosen else ""), numbers, f"{fit.score:.2f}"])
    if law.shadow is not None:
        fit = law.shadow
        factor, unit = (1e3, "mm") if fit.form.names[0] == "sigma" else (1.0, "px")
        rows.append([fit.form.title, f"{factor * fit.numbers[0]:.2f} +- {factor * fit.std[0]:.2f} {unit}", ""])
    return numbers_table(["law", "numbers", "held-out error"], rows)


def _poses(found: NoiseCalibration) -> str:
    rows = []
    for pose in found.poses:
        seen = pose.seen
        edges = ", ".join(
            f"{x * 1e3:.2f}{' (shadow)' if s else ''}" for x, s in zip(seen.lateral, pose.shadowed, strict=True)
        )
        rows.append([pose.name, str(seen.frames), f"{pose.depth:.3f}", f"{np.rad2deg(pose.tilt):.1f}",
                     f"{pose.axial * 1e3:.2f} +- {pose.axial_std * 1e3:.2f}", edges, f"{100 * seen.valid:.1f}",
                     f"{100 * seen.no_data:.1f}", f"{100 * seen.outliers:.2f}"])  # fmt: skip
    head = ["pose", "frames", "distance [m]", "tilt [deg]", "axial noise [mm]", "lateral left, right [mm]", "valid [%]",
            "no data [%]", "outliers [%]"]  # fmt: skip
    return numbers_table(head, rows)
