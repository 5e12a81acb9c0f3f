"""The stage that places every frame about the object: by the motion that was found, and tracked freely."""

from dataclasses import dataclass

from fusion.errors import TrackingError
from fusion.geometry.trajectory import Trajectory
from fusion.scan.finding.object import choose_volume
from fusion.scan.finding.poses import FreeCourse, constrained, track_freely, wobble
from fusion.scan.motion import FoundMotion
from fusion.turntable.circle import Circle, fit_circle, onto_circle
from fusion.turntable.steps import Steps, judge_steps
from fusion.volume.settings import VolumeSettings

FEWEST = 3  # centres of a circle


@dataclass(frozen=True)
class PlacedFrames:
    """Where the frames stand."""

    found: FoundMotion  # the motion, and before it the recording
    volume: VolumeSettings  # what the object is fused in
    course: Trajectory  # the camera in the object's frame as it is used
    free: FreeCourse  # the same tracked freely
    circle: Circle  # fitted to the free centres
    steps: Steps  # of the table, judged
    wobble: float  # rms rocking of the axis over the free poses [rad]


def place(found: FoundMotion) -> PlacedFrames:
    """Poses of all frames.

    Raises:
        VolumeError: the voxel settings make no sense or do not fit into memory.
        TrackingError: hardly a frame shows what the others show.
    """
    seen, settings = found, found.opened.settings
    motion = seen.motion
    volume = choose_volume(settings, seen.recording.camera, seen.frames, seen.region, motion)
    course = constrained(seen.recording, motion)
    free = track_freely(seen.frames, seen.region, course, volume)
    rocked = wobble(free.course, motion)
    steps = judge_steps(motion.angles, motion.angle_std, seen.told)
    circle = _circle(free.course)
    if settings.strength == "circle":  # a log that misses a slip would put all later centres in the wrong place
        course, circle = onto_circle(free.course, None if steps.slips else seen.told)
    return PlacedFrames(found, volume, course, free, circle, steps, rocked)


def _circle(free: Trajectory) -> Circle:
    """The circle of the freely tracked centres; few of them are told as what it means for a scan."""
    placed = int(free.valid.sum())
    if placed < FEWEST:
        raise TrackingError(
            "the views do not show one thing that turns",
            found=f"{placed} of {len(free)} frames follow the model of the others",
            expected=f"{FEWEST} or more",
            do="keep hands and people out of the picture, or give --box or --mask of what turns; what is moved freely, "
            "on no turntable, `fusion reconstruct` with --box follows",
        )
    return fit_circle(free.centres)
