"""The facts of a scan: every number that terminal, page and JSON tell, computed once."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fusion.certainty.sigma import Sure
from fusion.geometry.pose import Array
from fusion.mesh.shape import MeshShape
from fusion.results.course import Course, OffCourse


@dataclass(frozen=True)
class Gap:
    """How far two views about a full turn apart miss each other."""

    angle: float  # [rad]
    distance: float  # [m]
    deviations: float  # the same, in standard deviations of what the two tell, over that of other views: 1 is usual


@dataclass(frozen=True)
class TableFacts:
    """What the turntable did."""

    # step_mean, step_std: of the turn from frame to frame, slips left out [rad]
    step_mean: float
    step_std: float
    slips: tuple[int, ...] = ()  # frames after a slip
    # gap, gap_raw: closing gap after and before the post-pass; None without a full turn
    gap: Gap | None = None
    gap_raw: Gap | None = None
    slab_cut: bool = False  # what the object stands on is no round plate, was told as a slab that turns, and is cut off
    hidden: float = 0.0  # so far above the plate the object cannot be told from it; its sides are carried down [m]
    rests: int = 0  # frames that show the object turned as the one before, where there are many


@dataclass(frozen=True)
class SureFacts:
    """How sure the vertices are."""

    # middle, high: median and 95th percentile of `sigma`, a standard deviation along the normal [m]
    middle: float
    high: float
    common: float | None  # part of it that all vertices share, from calibration, rms [m]; None where nobody calibrated
    unknown: tuple[str, ...]  # what is not in it, as nothing tells it

    @classmethod
    def of(cls, sure: Sure | None) -> "SureFacts | None":
        """None where nothing is known."""
        known = np.zeros(0) if sure is None else sure.sigma[np.isfinite(sure.sigma)]
        if sure is None or not len(known):
            return None
        middle, high = np.percentile(known, [50, 95])
        return cls(float(middle), float(high), sure.parts["calibration"], sure.unknown)


@dataclass(frozen=True)
class ScanFacts:
    """What a scan says about its object and about itself."""

    shape: MeshShape  # the mesh in numbers
    # frames, placed: in the recording, and those with a pose
    frames: int = 0
    placed: int = 0
    residual: float | None = None  # rms over the frames of their residual against the model [m]; None without tracking
    inlier_share: float | None = None  # median over the frames; None without tracking
    table: TableFacts | None = None  # None when nothing turned
    # error of the trajectory against poses that the recording states; None without them
    off_course: OffCourse | None = None
    # how the trajectory of a moving camera hangs together; None where it was not tracked freely
    course: Course | None = None
    sure: SureFacts | None = None  # how sure the vertices are; None where that was not asked

    def values(self) -> dict[str, Any]:
        """Plain values for JSON, SI units but where a name says otherwise."""
        shape = self.shape
        out: dict[str, Any] = {
            "frames": self.frames,
            "placed": self.placed,
            "residual_rms_m": self.residual,
            "inlier_share": self.inlier_share,
            "vertices": shape.vertices,
            "triangles": shape.triangles,
            "size_m": list(shape.size),
            "volume_m3": shape.volume,
            "bottom_open": shape.bottom_open,
            "holes": len(shape.other_holes),
            "open_share": shape.open_share,
            "fragments": shape.fragments,
            "largest_share": shape.largest_share,
            "crumb_share": shape.crumb_share,
        }
        table = self.table
        if table is not None:
            gaps = {"before": table.gap_raw, "after": table.gap}
            out |= {
                "step_mean_deg": float(np.rad2deg(table.step_mean)),
                "step_std_deg": float(np.rad2deg(table.step_std)),
                "closure_m": {when: None if gap is None else gap.distance for when, gap in gaps.items()},
                "closure_deg": {
                    when: None if gap is None else float(np.rad2deg(gap.angle)) for when, gap in gaps.items()
                },
                "slab_cut": table.slab_cut,
                "hidden_m": table.hidden,
                "frames_at_rest": table.rests,
            }
        if self.off_course is not None:
            out["trajectory_error"] = self.off_course.values()
        if self.course is not None:
            out["course"] = self.course.values()
        if self.sure is not None:
            out |= {
                "sigma_median_m": self.sure.middle,
                "sigma_p95_m": self.sure.high,
                "sigma_without": self.sure.unknown,
            }
        return out


def rms_of(values: Array) -> float | None:
    """Root mean square of the finite values (n,); None when there are none."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else None


def median_of(values: Array) -> float | None:
    """Median of the finite values (n,); None when there are none."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else None
