"""What a turntable scan gives back."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.sigma import Sure
from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import shape_of
from fusion.results.facts import Gap, ScanFacts, SureFacts, TableFacts, median_of, rms_of
from fusion.results.judgement import Judgement
from fusion.scan.evidence import Evidence
from fusion.scan.judgement import judge
from fusion.turntable.circle import Circle
from fusion.turntable.motion import Motion
from fusion.turntable.steps import Steps

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Scan:
    """A scanned object; its frame has the origin on the axis at the plate, z up along the axis.

    Attributes:
        mesh: the object; mesh_raw: from the poses before the post-pass.
        trajectory, trajectory_raw: (n) `T_object_camera`, NaN for rejected frames.
        motion, steps: what the table did.
        circle: fitted to the raw centres.
        closure, closure_raw: closing gap after and before, None when the turn is not full.
        residual, inlier_share: (n,) [m], [1].
        wobble: rms rocking of the axis over the freely tracked poses [rad].
        camera: used for the result (refined when asked for).
        settings: what was asked for and chosen, plain values.
        evidence: what its judgement rests on.
        told: (n,) table angles that the log or the stated step says [rad], None when nothing was said.
        sure: where `mesh.scalars["sigma"]`, the standard deviation of each vertex along its normal [m], comes from.
    """

    mesh: Mesh
    mesh_raw: Mesh
    trajectory: Trajectory
    trajectory_raw: Trajectory
    motion: Motion
    steps: Steps
    circle: Circle
    closure: Gap | None
    closure_raw: Gap | None
    residual: Array
    inlier_share: Array
    wobble: float
    camera: Camera
    settings: dict[str, Any]
    evidence: Evidence
    told: Array | None = None
    sure: Sure | None = None

    def __repr__(self) -> str:
        placed = f"{int(self.trajectory.valid.sum())} of {len(self.trajectory)} frames placed"
        turned = f"{np.rad2deg(self.steps.mean):.2f} deg a frame, {len(self.steps.slips)} slips"
        looks = len(self.judgement.warnings)
        return f"<Scan: {placed}, {turned}, {looks} warnings;\n {self.mesh!r}>"

    def _repr_png_(self) -> bytes | None:
        """A picture for notebooks."""
        return self.mesh._repr_png_()

    @cached_property
    def facts(self) -> ScanFacts:
        """Every number that terminal, page and JSON tell."""
        slips = tuple(slip.frame for slip in self.steps.slips)
        # None: the plate is round, or none was seen
        cut = self.motion.table is not None and not self.settings["keep_plate"]
        return ScanFacts(
            shape=shape_of(self.mesh, np.array([0.0, 0.0, 1.0])),
            frames=len(self.trajectory),
            placed=int(self.trajectory.valid.sum()),
            residual=rms_of(self.residual),
            inlier_share=median_of(self.inlier_share),
            table=TableFacts(self.steps.mean, self.steps.std, slips, self.closure, self.closure_raw, cut),
            sure=SureFacts.of(self.sure),
        )

    @cached_property
    def judgement(self) -> Judgement:
        """What is good, doubtful or wrong about this scan, the worst first."""
        return judge(self)

    def turntable(self) -> dict[str, Any]:
        """The content of `turntable.json` (CONTRACT)."""

        def gap(found: Gap | None) -> dict[str, float | None]:
            if found is None:
                return dict.fromkeys(("angle_rad", "distance", "deviations"))
            return {"angle_rad": found.angle, "distance": found.distance, "deviations": found.deviations}

        axis, worth = self.motion.axis, self.judgement.worth
        return {
            "frame": "the first camera's: x right, y down, z forward; mesh.ply: z up along the axis, plate at z = 0",
            "axis_point": axis.point.tolist(),
            "axis_direction": axis.direction.tolist(),
            "plate_seen": self.motion.plate is not None,
            "radius": float(axis.distance(np.zeros((1, 3)))[0][0]),
            "angles_rad": [None if np.isnan(a) else float(a) for a in self.motion.angles],
            "angles_std_rad": [None if np.isnan(a) else float(a) for a in self.motion.angle_std],
            "told_rad": None if self.told is None else [float(a) for a in self.told],
            "verdict": worth.word,
            "reasons": worth.sentences(),
            "direction": self.steps.direction,
            "radial_rms": self.circle.radial_rms,
            "axial_rms": self.circle.axial_rms,
            "closure": gap(self.closure),
            "closure_raw": gap(self.closure_raw),
            "wobble_rad": self.wobble,
            "step_mean_rad": self.steps.mean,
            "step_std_rad": self.steps.std,
            "rejected_frames": sorted(self.motion.rejected),
            "rejected_reasons": {str(k): v for k, v in sorted(self.motion.rejected.items())},
            "slips": [{"frame": s.frame, "angle_rad": s.angle} for s in self.steps.slips],
            "camera": {k: getattr(self.camera, k) for k in ("fx", "fy", "cx", "cy")}
            | {"refined": self.evidence.refined},
            "focal_length_check": {
                "relative": self.evidence.focal.relative,
                "std": self.evidence.focal.std,
                "fx": self.evidence.stated_camera.fx * (1 + self.evidence.focal.relative),
            },
            "depth_taken_out": self.motion.taken_out.depth_errors(),
            "sigma": None if self.sure is None else self.sure.values(),
        }
