"""The motion of a scan and the frames of the object alone, once the camera is settled."""

from dataclasses import replace

from fusion.scan.finding.attempt import Attempt
from fusion.scan.finding.model_fit import ModelFit, fit_model
from fusion.scan.finding.object import choose_volume
from fusion.scan.finding.plate_seen_whole import on_its_plate
from fusion.scan.finding.relieved import relieved
from fusion.turntable.all_views.log import with_log
from fusion.turntable.axis import about_axis
from fusion.turntable.motion import Motion
from fusion.volume.prepared import Prepared, fused
from fusion.volume.unmixed import matching_window, unmixed


def find_motion(found: Attempt) -> ModelFit:
    """Axis and angles of an attempt, every frame against the model of all; unreadable frames among the rejected."""
    asked, told = found.asked, found.fit.commanded
    fitted = fit_model(found.frames, asked, found.region, found.fit)
    motion = fitted.motion
    if told is not None:
        motion = replace(motion, angles=with_log(motion.angles, motion.angle_std, told))
    motion = replace(on_its_plate(motion, asked.recording, asked.sensor), rejected={**motion.rejected, **found.broken})
    return replace(fitted, motion=motion)


def turned(found: Attempt) -> tuple[Motion, list[Prepared | None]]:
    """The motion; the object's frames, without the errors of depth it was found with, and without what is mixed."""
    fitted = find_motion(found)
    motion = fitted.motion
    frames = relieved(found.of_object(motion).frames, motion.taken_out)
    if fitted.model is not None:  # how its surface bends does not ask for the last step of the motion
        model, turns = fitted.model
        poses = about_axis(*turns)
    else:
        cut = found.region.cut(found.region.window(found.camera))
        poses = about_axis(motion.axis, motion.angles, motion.shifts)
        model = fused(choose_volume(found.asked.settings, found.camera, frames, cut, motion), frames, poses, "model")
    return motion, unmixed(frames, model, poses, matching_window(found.asked.sensor, found.camera.fx))
