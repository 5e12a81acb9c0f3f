"""The report of a camera calibration."""

from pathlib import Path

import numpy as np

from fusion.calibration.lens.boards.detect import stretched
from fusion.calibration.lens.boards.pictures import read_picture
from fusion.calibration.lens.boards.search import Search
from fusion.calibration.lens.fit.solve import NAMES
from fusion.calibration.lens.intrinsics import POOR, CameraFit, Intrinsics
from fusion.report.calibrations.lens_figures import (
    BoardPicture,
    brief,
    corners_figure,
    correlation_figure,
    residuals_figure,
    uncertainty_figure,
    views_figure,
)
from fusion.report.kit.page import Number, Page, Section, write_page
from fusion.report.kit.tables import numbers_table
from fusion.results.light import Light

PICTURES = 8
# where a line turns yellow, and red (guesses, from calibrations that made good meshes and bad ones)
FOCAL_SHARE = (0.003, POOR)
RMS_PX = (0.3, 1.0)
COVERAGE = (0.5, 0.25)
TILT_DEG = (25.0, 12.0)
SWAY = (1.5, 3.0)
TITLES = {"ir": "IR camera", "color": "Colour camera"}


def lens_report(result: Intrinsics, path: Path, recording: Path, command: str = "") -> None:
    """Write the page of a calibration."""
    summary, figures_and_tables, key_numbers = [], [], []
    for name, fit in result.fits.items():
        title = TITLES[name]
        summary += _summary(fit, result.searches[name], title)
        key_numbers += _numbers(fit, title)
        figures_and_tables.append(_section(fit, result.searches[name], name))
    if result.pair is not None:
        summary.append(_pair_light(result))
    page = Page(
        title=f"Camera calibration of {Path(recording).name}",
        subtitle=", ".join(f"{TITLES[n]}: {len(f.judged.views)} views" for n, f in result.fits.items()),
        summary=summary,
        numbers=key_numbers,
        sections=figures_and_tables,
        warnings=[Light("warning", "", text) for text in result.warnings],
        settings={"board": result.board.file()},
        fingerprint={"folder": str(recording)},
        command=command,
    )
    write_page(path, page)


def _summary(fit: CameraFit, search: Search, title: str) -> list[Light]:
    p, std = fit.camera, fit.camera.std
    share = std["fx"] / p.fx
    total = len(search.views) + len(search.missed)
    view, sway = fit.most_influential
    tilt = fit.tilt
    lines = [
        Light(_above(share, FOCAL_SHARE), f"{title}: focal length", f"{p.fx:.2f} +- {std['fx']:.2f} px ({share:.2%})."),
        Light(_above(fit.judged.solution.rms, RMS_PX), "Reprojection", f"{fit.judged.solution.rms:.3f} px rms."),
        Light(_below(fit.coverage, COVERAGE), "Coverage", f"Corners in {fit.coverage:.0%} of the picture, "
              f"board found in {len(search.views)} of {total} pictures."),
        Light(_below(tilt, TILT_DEG), "Tilt", f"The board was tilted by up to {tilt:.0f} degrees (95th percentile)."),
        Light(_above(sway, SWAY), "Stability", f"Without {view} a parameter moves by {sway:.1f} standard deviations."),
    ]  # fmt: skip
    if fit.k3_held:
        reason = f"The views do not establish it (+- {std['k3']:.2g}): it is held at 0."
        lines.append(Light("warning", "k3", reason, "Record views with the board in the corners of the picture."))
    if fit.judged.outliers:
        said = "; ".join(f"{o.name}: {o.reason}" for o in fit.judged.outliers[:6])
        lines.append(Light("warning", "Outliers", f"{len(fit.judged.outliers)} views do not fit: {said}."))
    return lines


def _numbers(fit: CameraFit, title: str) -> list[Number]:
    p, at = fit.camera, fit.uncertainty.numbers()
    rows = [Number(f"{title}, {name}", f"{getattr(p, name):.2f} +- {p.std[name]:.2f}", "px") for name in NAMES[:4]]
    return [
        *rows,
        Number(
            f"{title}, rays at {at['distance_m']:.2f} m", f"{brief(at['centre_mm'])} to {brief(at['worst_mm'])}", "mm"
        ),
    ]


def _section(fit: CameraFit, search: Search, name: str) -> Section:
    figures = (
        residuals_figure(fit, name),
        uncertainty_figure(fit, name),
        views_figure(fit, name),
        correlation_figure(fit, name),
        corners_figure(_shown(fit, search), name),
    )
    lead = "The model is OpenCV's: focal lengths, principal point, k1 k2 k3 radial, p1 p2 tangential."
    if "k4" in fit.judged.solution.names:
        lead += " The lens is wide: k4 k5 k6 divide the radial part; each alone is known badly, together they are."
    return Section(TITLES[name], lead, figures, _table(fit) + _missed(search))


def _table(fit: CameraFit) -> str:
    known = fit.spread
    rows = [
        [name, f"{value:.6g}", f"{std:.2g}", f"{scatter:.2g}", f"{jackknife:.2g}", f"{np.nanmax(np.abs(shift)):.2g}"]
        for name, value, std, scatter, jackknife, shift in zip(
            fit.judged.solution.names,
            fit.judged.solution.parameters,
            known.std,
            known.scatter,
            known.jackknife,
            known.shifts.T,
            strict=True,
        )
    ]
    head = ["", "value", "std", "from the scatter", "from leaving out views", "largest move"]
    return numbers_table(head, rows)


def _missed(search: Search) -> str:
    rows = [[name, "board not found"] for name in search.missed[:30]]
    rows += [[name, reason] for name, reason in list(search.unread.items())[:30]]
    return numbers_table(["picture", "not used because"], rows) if rows else ""


def _shown(fit: CameraFit, search: Search) -> list[BoardPicture]:
    """Outliers first, then used views, evenly over the recording."""
    used = {view.name for view in fit.judged.views}
    out = [view for view in search.views if view.name not in used][: PICTURES // 2]
    rest = [view for view in search.views if view.name in used]
    picked = np.unique(np.linspace(0, len(rest) - 1, min(PICTURES - len(out), len(rest))).astype(int))
    return [
        BoardPicture(view.name, stretched(read_picture(search.pictures[view.name])), view.pixels, view.name in used)
        for view in [*out, *(rest[i] for i in picked)]
    ]


def _pair_light(result: Intrinsics) -> Light:
    assert result.pair is not None
    T, std = result.pair.T_color_depth, result.pair.std_translation
    moved = ", ".join(f"{1000 * x:.1f} +- {1000 * s:.1f}" for x, s in zip(T[:3, 3], std, strict=True))
    left = f"; left out: {', '.join(result.pair.left_out)}" if result.pair.left_out else ""
    reason = f"({moved}) mm from {len(result.pair.used)} pairs, {result.pair.rms_px:.2f} px rms{left}."
    return Light(_above(result.pair.rms_px, RMS_PX), "Colour camera's place", reason)


def _above(value: float, limits: tuple[float, float]) -> str:
    return "ok" if value <= limits[0] else "warning" if value <= limits[1] else "bad"


def _below(value: float, limits: tuple[float, float]) -> str:
    return "ok" if value >= limits[0] else "warning" if value >= limits[1] else "bad"
