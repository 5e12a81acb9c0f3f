"""What a reconstruction gives back, and what it knows of its own faults as lights for terminal, page and JSON."""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.sigma import Sure
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.drawing.shading import png
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import shape_of
from fusion.reconstruction.leap import leap_of
from fusion.results.choices import ReconstructionChoices
from fusion.results.course import Course, OffCourse
from fusion.results.facts import ScanFacts, SureFacts, median_of, rms_of
from fusion.results.judgement import Judgement
from fusion.results.light import LEVELS, Light, frames_light, level, worst_first
from fusion.volume.volume import Volume

# good up to the first, a problem above the second (guesses); a truncation is the band in which noise is fused
FIT_BANDS = (0.5, 1.0)
COURSE_BANDS = (1.0, 3.0)
WEAK_SHARE = (0.1, 0.6)
UNMEASURED = (0.03, 0.1)  # of the way, what no surface fixed; the first as what is usual of drift (guesses)
CRUMB_SHARE = (0.05, 0.2)
APART = (0.5, 1.0)  # of a truncation, places seen twice: beyond, walls are doubled
RELIEF = "Keep more relief in view: corners, furniture, things at several depths."


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
        known: frames that the key frames around them place in all directions.
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
    known: frozenset[int] = frozenset()
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


def judge(result: Reconstruction) -> Judgement:
    """All lights of a reconstruction, the worst first."""
    lights = [frames_light(len(result.trajectory), result.rejected), _surface(result), *result.notes]
    told = (_fit(result), _leap(result), _directions(result), _drift(result), _course(result))
    lights += [light for light in told if light is not None]
    return Judgement(worst_first(lights), result.footnotes)


def _fit(result: Reconstruction) -> Light | None:
    known = result.residual[np.isfinite(result.residual)]
    if not len(known):  # poses were given
        return None
    found = float(np.median(known))
    judged = level(found / result.settings.tracked_band_m, FIT_BANDS)
    do = "Calibrate the depth, and move slower." if judged != "ok" else ""
    return Light(judged, "Fit", f"Frames lie {found * 1e3:.2f} mm (median) off the model.", do)


def _leap(result: Reconstruction) -> Light | None:
    if result.course is None:
        return None
    return leap_of(result.trajectory, result.settings.truncation_m, np.isfinite(result.residual))


def _directions(result: Reconstruction) -> Light | None:
    weak = Counter(name for names in _open(result).values() for name in names)
    if not weak:
        return None
    name, count = weak.most_common(1)[0]
    lost, known = _unmeasured(result), float(np.nansum(_fixed(result)))
    share = 1.0 if np.isinf(lost) else lost / max(known + lost, 1e-9)
    judged = max(level(count / len(result.trajectory), WEAK_SHARE), level(share, UNMEASURED), key=LEVELS.index)
    others = f", {', '.join(other for other, _ in weak.most_common()[1:])} in fewer" if len(weak) > 1 else ""
    said = f"{name} is fixed by neither the surface nor other views in {count} of {len(result.trajectory)} frames"
    said += others
    if np.isinf(lost):
        said += ": how far the camera went is not known"
    elif share > UNMEASURED[0]:
        said += f": at the pace of the others {lost:.2g} m of a way of {known + lost:.2g} m are not measured"
    return Light(judged, "Directions", f"{said[:1].upper()}{said[1:]}.", RELIEF if judged != "ok" else "")


def _open(result: Reconstruction) -> dict[int, tuple[str, ...]]:
    """Directions of frames that neither the surface nor the key frames around fix."""
    return {i: names for i, names in result.unconstrained.items() if i not in result.known}


def _sliding(result: Reconstruction) -> NDArray[np.intp]:
    """Those of the steps along which the surface may have slid on itself."""
    frames = [i for i, names in _open(result).items() if any(name.startswith("shift") for name in names)]
    return np.array([i - 1 for i in frames if i > 0], np.intp)


def _fixed(result: Reconstruction) -> NDArray[np.float64]:
    """The other steps from frame to frame [m]; NaN beside a frame without a place."""
    steps = np.linalg.norm(np.diff(result.trajectory.centres, axis=0), axis=1)
    return np.delete(steps, _sliding(result))


def _unmeasured(result: Reconstruction) -> float:
    """The way [m] that frames took along what their surface does not fix, at the pace of the others; infinite where
    these are fewer, and 0 where a place was seen again, as loops correct it."""
    count, fixed = len(_sliding(result)), _fixed(result)
    fixed = fixed[np.isfinite(fixed)]
    if not count or (result.course is not None and result.course.met):
        return 0.0
    return float(count * np.median(fixed)) if len(fixed) >= count else float("inf")


def _surface(result: Reconstruction) -> Light:
    shape = result.facts.shape
    judged = level(shape.crumb_share, CRUMB_SHARE)
    said = f"The surface is in {shape.fragments:,} parts" if shape.fragments > 1 else "The surface hangs together"
    said += f", {shape.crumb_share:.0%} of it in small ones" if shape.crumb_share > 0 else ""
    larger = "--voxel" if result.settings.kind == "room" else "--voxel, --room"
    do = f"Larger voxels ({larger}), a nearer --max-depth, or more frames join them." if judged != "ok" else ""
    return Light(judged, "Surface", f"{said}.", do)


def _drift(result: Reconstruction) -> Light | None:
    """What is known of the drift: corrected where a place was seen again, else what is to be expected."""
    course = result.course
    if course is None or result.facts.placed < 2:  # one frame cannot drift
        return None
    band = result.settings.truncation_m
    if course.met:
        many = f"{course.met} pairs of views show a place seen before" if course.met > 1 else "One place was seen again"
        said = f"{many}; they moved the camera by up to {course.moved * 1e3:.0f} mm"
        left = "" if np.isnan(course.after) else f" and lie {course.after * 1e3:.1f} mm apart now"
        judged = "ok" if np.isnan(course.after) else level(course.after / band, APART)
        return Light(judged, "Loops", f"{said}{left}.", "Walk the loop again, slower." if judged != "ok" else "")
    lost = _unmeasured(result)
    if course.in_view and not course.moved and lost < band:
        return Light("ok", "Drift", "The camera kept in view what it had seen.")
    judged = "warning" if course.drift + lost > band else "ok"
    seen = "The surface alone did not hold the camera" if course.in_view else "Nothing was seen again after it was left"
    said = f"{seen}, on a way of {course.path:.1f} m: drift is not checked"
    if course.moved:
        said += f", and landmarks of neighbouring views moved the camera by up to {course.moved * 1e3:.0f} mm"
    do = "End where you began, with the same things in view." if judged != "ok" else ""
    said += f"; {course.drift * 1e3:.0f} mm would be usual"
    if lost > band:
        missing = "nobody knows how much" if np.isinf(lost) else f"{lost * 1e3:.0f} mm"
        said += f", and {missing} may be missing where the surface slid along itself"
    return Light(judged, "Drift", f"{said}.", do)


def _course(result: Reconstruction) -> Light | None:
    if result.off_course is None:
        return None
    judged = level(result.off_course.error.rmse / result.settings.truncation_m, COURSE_BANDS)
    do = "Use the stated poses (--poses stated), or move slower with more relief in view." if judged != "ok" else ""
    return Light(judged, "Course", f"The tracked camera is off by {result.off_course.words()}.", do)
