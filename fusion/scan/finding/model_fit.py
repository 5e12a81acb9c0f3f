"""The motion of every frame against the model of all."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.progress import stage
from fusion.scan.finding.alone import object_alone
from fusion.scan.finding.object import choose_volume
from fusion.scan.finding.pair_fit import Asked, PairFit
from fusion.scan.finding.relieved import relieved
from fusion.turntable.axis import Axis, Turns, about_axis
from fusion.turntable.model.finish import How, finish
from fusion.turntable.model.rays import Rays, rays_of
from fusion.turntable.motion import Motion
from fusion.turntable.selfcheck import SelfCheck, prior_of
from fusion.turntable.views import Region
from fusion.turntable.whole import whole
from fusion.volume.prepared import Prepared, fused
from fusion.volume.volume import Volume, VolumeSettings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ModelFit:
    """A motion, and the last model of all frames with the turns that it was made by; None where none was made."""

    motion: Motion
    model: tuple[Volume, Turns] | None = None


def fit_model(frames: list[Prepared | None], asked: Asked, region: Region, fit: PairFit) -> ModelFit:
    """The motion of pairs made better, where a model of all frames can do so; arguments as of `fit_pairs`."""
    motion, camera = fit.motion, asked.recording.camera
    # a model is sharp only where camera and depth fit the motion, and it has one axis
    if motion.shifts is not None or (motion.camera_check.values != motion.taken_out.values).any():
        return ModelFit(motion)
    cut = region.cut(region.window(camera))
    rays = [None if f is None else rays_of(f.surface, whole(f.depth, f.surface, cut)) for f in frames]
    with stage("motion"):
        frames = object_alone(frames, cut, motion)
        volume = choose_volume(asked.settings, camera, frames, cut, motion)
        doubt = None
        if fit.known is not None:
            seen = np.concatenate([some.values[::20, :3] for some in rays if some is not None]).astype(float)
            doubt = prior_of(camera, fit.known, seen, motion.taken_out)
        how = How(rounds=1, held=True, doubt=doubt) if motion.held else How(doubt=doubt)
        return _finished(frames, rays, volume, motion, how)


def _finished(
    frames: list[Prepared | None], rays: list[Rays | None], settings: VolumeSettings, motion: Motion, how: How
) -> ModelFit:
    def model_of(axis: Axis, angles: Array, check: SelfCheck) -> Volume:
        return fused(settings, relieved(frames, check), about_axis(axis, angles), "model")

    found = finish(rays, Turns(motion.axis, motion.angles), model_of, motion.taken_out, how)
    sure = replace(motion, axis_std=found.axis_std, size_std=found.size_std)
    if motion.held:  # print tells the axis too: by shape, which blur flattens, those of cylinders came 0.3 mm nearer
        return ModelFit(sure, found.model)
    moved = replace(sure, axis=found.axis, angles=found.angles, angle_std=found.angle_std)
    return ModelFit(replace(moved, camera_check=found.check, taken_out=found.check), found.model)
