"""After the walk: frames are fused again where their course has changed, or where the walk has shown what is meant."""

from dataclasses import replace

from fusion.errors import VolumeError
from fusion.reconstruction.course import Straightened
from fusion.reconstruction.planning import Plan, object_after_all
from fusion.reconstruction.settings import ReconstructSettings
from fusion.reconstruction.walk import Walk, WalkedFrames, fused, fused_again
from fusion.reconstruction.walked_round import StandingView
from fusion.tracking.tracker import Tracked
from fusion.volume.volume import Volume


def settled(
    frames: WalkedFrames, settings: ReconstructSettings, walk: Walk, straight: Straightened
) -> tuple[Volume, Plan, list[Tracked]]:
    """The volume that suits the settled course, how it was fused, and the results of all frames.

    Raises:
        RecordingError: a frame that was read before cannot be read any more.
        VolumeError: the volume does not fit into its memory.
    """
    results, plan = straight.results, walk.plan
    found = [(results[frame.index], frame.surface) for frame in walk.keyframes]
    views = [StandingView(result.T_world_camera, surface) for result, surface in found if result.ok]
    finer = object_after_all(plan, frames.recording, settings, views)
    if finer is not None:
        try:
            return _fused(frames, walk, straight, finer)
        except VolumeError as error:
            plan = replace(plan, reason=f"{plan.reason}; as an object: {error.what}")
    if straight.between is None:
        return walk.volume, plan, results
    return _fused(frames, walk, straight, plan)


def _fused(frames: WalkedFrames, walk: Walk, straight: Straightened, plan: Plan) -> tuple[Volume, Plan, list[Tracked]]:
    if straight.between is not None:
        volume, results = fused_again(frames, straight.results, plan, straight.between)
        return volume, plan, results
    placed = [i for i, result in enumerate(straight.results) if result.ok]
    return fused(frames, straight.results, plan, placed), plan, straight.results
