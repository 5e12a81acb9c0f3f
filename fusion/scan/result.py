"""What a turntable scan gives back."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.sigma import Sure
from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import shape_of
from fusion.results.choices import ScanChoices
from fusion.results.facts import Gap, ScanFacts, SureFacts, TableFacts, median_of, rms_of
from fusion.results.judgement import Judgement
from fusion.results.table_motion import FRAME, NO_PLATE, ClosingGap, FocalFigures, SlipFound, TableMotion, UsedCamera
from fusion.scan.judging.evidence import Evidence
from fusion.scan.judging.judge import judge
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
        settings: what was asked for and chosen.
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
    settings: ScanChoices
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
        cut = self.motion.table is not None and not self.settings.keep_plate
        return ScanFacts(
            shape=shape_of(self.mesh, np.array([0.0, 0.0, 1.0])),
            frames=len(self.trajectory),
            placed=int(self.trajectory.valid.sum()),
            residual=rms_of(self.residual),
            inlier_share=median_of(self.inlier_share),
            table=TableFacts(
                self.steps.mean,
                self.steps.std,
                slips,
                self.closure,
                self.closure_raw,
                cut,
                self.evidence.hidden,
                self.steps.rests,
            ),
            sure=SureFacts.of(self.sure),
        )

    @cached_property
    def judgement(self) -> Judgement:
        """What is good, doubtful or wrong about this scan, the worst first."""
        return judge(self)

    def turntable(self) -> TableMotion:
        """The content of `turntable.json`."""
        motion, worth, focal = self.motion, self.judgement.worth, self.evidence.focal
        seen = self.camera
        return TableMotion(
            frame=NO_PLATE if motion.plate is None else FRAME,
            axis_point=motion.axis.point,
            axis_direction=motion.axis.direction,
            plate_seen=motion.plate is not None,
            hidden_m=self.evidence.hidden,
            radius=float(motion.axis.distance(np.zeros((1, 3)))[0][0]),
            angles_rad=motion.angles,
            angles_std_rad=motion.angle_std,
            told_rad=self.told,
            verdict=worth.word,
            reasons=tuple(worth.sentences()),
            direction=self.steps.direction,
            radial_rms=self.circle.radial_rms,
            axial_rms=self.circle.axial_rms,
            closure=_gap(self.closure),
            closure_raw=_gap(self.closure_raw),
            wobble_rad=self.wobble,
            step_mean_rad=self.steps.mean,
            step_std_rad=self.steps.std,
            rejected_frames=tuple(sorted(motion.rejected)),
            rejected_reasons=dict(sorted(motion.rejected.items())),
            slips=tuple(SlipFound(slip.frame, slip.angle) for slip in self.steps.slips),
            camera=UsedCamera(seen.fx, seen.fy, seen.cx, seen.cy, self.evidence.refined),
            focal_length_check=FocalFigures(
                focal.relative, focal.std, self.evidence.stated_camera.fx * (1 + focal.relative)
            ),
            depth_taken_out=motion.taken_out.depth_errors(),
            sigma=None if self.sure is None else self.sure.values(),
        )


def _gap(found: Gap | None) -> ClosingGap:
    return ClosingGap() if found is None else ClosingGap(found.angle, found.distance, found.deviations)
