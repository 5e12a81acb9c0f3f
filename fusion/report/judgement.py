"""The summary of a scan: five lines with a traffic light each."""

from typing import TYPE_CHECKING

import numpy as np

from fusion.report.figures.circle import Paths, has_axis
from fusion.report.figures.coverage import THIN
from fusion.results.light import Light, level

if TYPE_CHECKING:
    from fusion.report.scan import ScanReport

# below the first: good; above the second: a problem (guesses, for objects of some decimetres before a depth camera)
REJECTED_SHARE = (0.05, 0.3)
RESIDUAL_M = (0.003, 0.01)
RADIAL_M = (0.005, 0.03)
THIN_SHARE = (0.1, 0.35)


def scan_summary(report: "ScanReport") -> list[Light]:
    """What the data says about frames, fit, turntable, coverage and mesh; lines without data are left out."""
    lines = [_frames(report), _fit(report), _turntable(report), _coverage(report), _mesh(report)]
    return [line for line in lines if line is not None]


def _frames(report: "ScanReport") -> Light | None:
    total = max([len(t) for t in (report.trajectory, report.trajectory_raw) if t is not None]
                + [len(v) for v in (report.residual, report.inlier_share) if v is not None] + [0])  # fmt: skip
    if total == 0:
        return None
    lost = len(report.rejected)
    reason = f"{total - lost} of {total} frames were used"
    reason += "." if lost == 0 else f"; {lost} rejected, most often: {_commonest(list(report.rejected.values()))}."
    return Light(level(lost / total, REJECTED_SHARE), "Frames used", reason)


def _fit(report: "ScanReport") -> Light | None:
    if report.residual is None:
        return None
    middle = _median(report.residual)
    if not np.isfinite(middle):
        return Light("bad", "Fit of the frames", "No frame has a residual: none could be placed on the model.")
    reason = f"The median residual of a frame against the model is {middle * 1000:.2f} mm."
    return Light(level(middle, RESIDUAL_M), "Fit of the frames", reason)


def _turntable(report: "ScanReport") -> Light | None:
    table = report.turntable
    if not table:
        return None
    slips = table.get("slips") or []
    radial = table.get("radial_rms")
    radial = float("nan") if radial is None else float(radial)
    judged = level(radial, RADIAL_M)
    if slips and judged == "ok":
        judged = "warning"
    reason = f"Tracked centres stand {radial * 1000:.1f} mm (rms) off the fitted circle"
    where = ", ".join(str(s.get("frame")) for s in slips[:5])
    reason += f"; the table slipped at frame {where}." if slips else " and no slip was found."
    return Light(judged, "Turntable", reason if np.isfinite(radial) else "No circle could be fitted to the centres.")


def _coverage(report: "ScanReport") -> Light | None:
    if report.times_seen is None or not len(report.times_seen):
        gap = _gap_degrees(report)
        if gap is None:
            return None
        reason = f"The largest gap between neighbouring views is {gap:.0f} deg."
        return Light(level(gap, (45, 120)), "Coverage", reason)
    thin = float(np.mean(np.asarray(report.times_seen) < THIN))
    reason = f"{thin:.0%} of the surface was seen in fewer than {THIN} frames."
    return Light(level(thin, THIN_SHARE), "Coverage", reason)


def _gap_degrees(report: "ScanReport") -> float | None:
    """Largest gap around the axis between neighbouring camera centres [deg]; None when nothing turned."""
    best = report.trajectory or report.trajectory_raw
    if best is None or not best.valid.any() or not has_axis(report.turntable):
        return None
    (_, _, centres), *_ = Paths(None, best, report.turntable or {}).named()
    around = np.sort(centres.azimuth[np.isfinite(centres.azimuth)])
    return float(np.degrees(np.diff(np.append(around, around[0] + 2 * np.pi)).max()))


def _mesh(report: "ScanReport") -> Light:
    mesh = report.mesh
    if len(mesh.faces) == 0:
        return Light("bad", "Mesh", "The mesh has no triangles.")
    if not np.isfinite(mesh.vertices).all():
        return Light("warning", "Mesh", "Some vertices are not finite; they are left out of the pictures.")
    # an edge of a closed surface belongs to two triangles
    edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1).astype(np.int64)
    _, times = np.unique(edges[:, 0] * (len(mesh.vertices) + 1) + edges[:, 1], return_counts=True)
    border = float(np.mean(times == 1))
    closed = "is closed" if border == 0 else f"is open along {border:.1%} of its edges"
    return Light("ok", "Mesh", f"{len(mesh.faces):,} triangles; the surface {closed}.")


def _commonest(reasons: list[str]) -> str:
    return max(sorted(set(reasons)), key=reasons.count).rstrip(".")


def _median(values) -> float:
    known = np.asarray(values, float)
    known = known[np.isfinite(known)]
    return float(np.median(known)) if len(known) else float("nan")
