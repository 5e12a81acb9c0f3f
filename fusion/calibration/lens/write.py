"""The result of a calibration as the content of files: numbers that JSON can hold."""

from typing import Any

import numpy as np

from fusion.calibration.lens.boards.search import Search
from fusion.calibration.lens.intrinsics import CameraFit, Intrinsics
from fusion.recording.native.camera_file import camera_to_dict


def camera_content(result: Intrinsics) -> dict[str, Any]:
    """The content of `camera.json`, with how it came about under "calibration"; readers ignore that."""
    return camera_to_dict(result.camera) | {"calibration": numbers(result)}


def numbers(result: Intrinsics) -> dict[str, Any]:
    """All numbers of a result."""
    content: dict[str, Any] = {
        "board": result.board.to_dict(),
        "cameras": {name: _fit(fit, result.searches[name]) for name, fit in result.fits.items()},
        "warnings": list(result.warnings),
    }
    if result.pair is not None:
        content["pair"] = {
            "T_color_depth": result.pair.T_color_depth.tolist(),
            "std_rotation_rad": result.pair.std_rotation.tolist(),
            "std_translation_m": result.pair.std_translation.tolist(),
            "rms_px": result.pair.rms_px,
            "pairs": len(result.pair.used),
            "left_out": result.pair.left_out,
        }
    return content


def _fit(fit: CameraFit, search: Search) -> dict[str, Any]:
    known, judged = fit.spread, fit.judged
    view, sigmas = fit.most_influential
    named = {outlier.name for outlier in judged.outliers}
    names = judged.solution.names
    return {
        "parameters": dict(zip(names, map(float, judged.solution.parameters), strict=True)),
        "std": dict(zip(names, map(float, known.std), strict=True)),
        "std_scatter": dict(zip(names, map(float, known.scatter), strict=True)),
        "std_jackknife": {n: _number(x) for n, x in zip(names, known.jackknife, strict=True)},
        "correlation": {"names": list(names), "matrix": np.round(known.correlation, 6).tolist()},
        "rms_px": judged.solution.rms,
        "sigma_px": known.sigma_px,
        "pictures": len(search.views) + len(search.missed),
        "found": len(search.views),
        "used": len(judged.views),
        "missed": search.missed,
        "unread": search.unread,
        "outliers": [{"view": o.name, "rms_px": _number(o.rms_px), "reason": o.reason} for o in judged.outliers],
        "outliers_kept": bool(named & {v.name for v in judged.views}),
        "corners_left_out": judged.wild,
        "most_influential": {"view": view, "sigmas": sigmas},
        "uncertainty": fit.uncertainty.numbers(),
        "coverage": fit.coverage,
        "k3_held": fit.k3_held,
        "row_pitch": {"ratio": fit.pitch[0], "std": _number(fit.pitch[1])},
    }


def _number(value: float) -> float | None:
    """A number that JSON can hold, or None."""
    return float(value) if np.isfinite(value) else None
