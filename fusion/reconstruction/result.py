"""What a reconstruction gives back."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.sigma import Sure
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.drawing.shading import png
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import shape_of
from fusion.reconstruction.judgement import judge
from fusion.results.choices import ReconstructionChoices
from fusion.results.course import Course, OffCourse
from fusion.results.facts import ScanFacts, SureFacts, median_of, rms_of
from fusion.results.judgement import Judgement
from fusion.results.light import Light
from fusion.volume.volume import Volume


@dataclass(frozen=True)
class Reconstruction:
    """A mesh and the evidence for it; n is the number of frames of the recording.

    Attributes:
        mesh: in the world, which is the first placed camera's frame unless poses were given.
        trajectory: (n) `T_world_camera`, NaN for rejected frames.
        residual, inlier_share: (n,) of the alignment [m], [1]; NaN where a frame was not aligned.
        information: (n, 6, 6) as in `IcpResult`.
        unconstrained: frame to the directions that its surface does not fix.
        rejected: frame to reason.
        settings: what was asked for and chosen.
        notes: of the recording's doctor, of readers and of the correction.
        footnotes: sentences that come with nearly every reconstruction of such a sensor.
        volume: what was fused.
        off_course: the trajectory's error against poses that the recording states; None without them.
        course: how the trajectory hangs together; None where poses were given.
        sure: where `mesh.scalars["sigma"]`, the standard deviation of each vertex along its normal [m], comes from.
    """

    mesh: Mesh
    trajectory: Trajectory
    residual: NDArray[np.float64]
    inlier_share: NDArray[np.float64]
    information: NDArray[np.float64]
    unconstrained: dict[int, tuple[str, ...]]
    rejected: dict[int, str]
    settings: ReconstructionChoices
    volume: Volume
    notes: tuple[Light, ...] = ()
    footnotes: tuple[str, ...] = ()
    off_course: OffCourse | None = None
    course: Course | None = None
    sure: Sure | None = None

    def __repr__(self) -> str:
        placed = f"{int(self.trajectory.valid.sum())} of {len(self.trajectory)} frames placed"
        error = "" if self.off_course is None else f", {self.off_course.error.rmse * 1e3:.1f} mm off its stated poses"
        looks = len(self.judgement.warnings)
        return f"<Reconstruction: {self.settings.kind}, {placed}{error}, {looks} warnings;\n {self.mesh!r}>"

    def _repr_png_(self) -> bytes | None:
        """A picture for notebooks, up and front as the first camera has them."""
        return png(self.mesh, up=(0, -1, 0), front=(0, 0, -1))

    @cached_property
    def facts(self) -> ScanFacts:
        """Every number that terminal, page and JSON tell; up is where the first camera has it."""
        return ScanFacts(
            shape=shape_of(self.mesh, np.array([0.0, -1.0, 0.0])),
            frames=len(self.trajectory),
            placed=int(self.trajectory.valid.sum()),
            residual=rms_of(self.residual),
            inlier_share=median_of(self.inlier_share),
            off_course=self.off_course,
            course=self.course,
            sure=SureFacts.of(self.sure),
        )

    @cached_property
    def judgement(self) -> Judgement:
        """What is good, doubtful or wrong about it, the worst first."""
        return judge(self)
