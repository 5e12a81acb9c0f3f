"""Explain: recordings of known scenes against a sensor model, from frames to what is missing."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.belonging import refuse_ranges, refuse_strangers
from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.channels.channels import ChannelFindings, channels_of
from fusion.discrepancy.channels.grain import as_given, with_grain
from fusion.discrepancy.channels.lattice import lattice_steps
from fusion.discrepancy.compared import Compared, compared
from fusion.discrepancy.competing import beside_setting, in_likeliest_errors
from fusion.discrepancy.held_out import HeldOut
from fusion.discrepancy.inference.loose import Loose
from fusion.discrepancy.inference.scatter import loose_of
from fusion.discrepancy.inference.shaking import SHAKES, Shaking, shaking_of, steadied
from fusion.discrepancy.inference.tile_covariance import TileCovariance, covariance_of
from fusion.discrepancy.levels import at_levels
from fusion.discrepancy.mean import MeanFindings, MeasuredForms
from fusion.discrepancy.naming.deviations import with_deviations
from fusion.discrepancy.naming.naming import Named
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.observe.frame_block import FrameBlock, blocks_of, wanted_channels
from fusion.discrepancy.observe.likely_pose import at_likely_poses
from fusion.discrepancy.observe.observations import Observations, observe
from fusion.discrepancy.observe.placements import joined
from fusion.discrepancy.observe.scene.stage import simulated_stage, stage_of
from fusion.discrepancy.observe.single_pixels import SinglePixel, single_pixels, without
from fusion.discrepancy.setting import Explained
from fusion.discrepancy.simulated import matched
from fusion.discrepancy.unknown.unknown import Unknown
from fusion.discrepancy.unknown.unrestricted import UnrestrictedGain
from fusion.discrepancy.wrapping import clear_of_turns, wrapping_of
from fusion.errors import FusionError
from fusion.geometry.camera import Principle
from fusion.progress import each, stage
from fusion.recording.looking.copies import Prints, refuse_copies
from fusion.recording.recording import Recording
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]

TURNS = 4  # in which sizes of errors are found: what is rough hides what is smooth until it is known


@dataclass(frozen=True)
class Explanation:
    """All that was found.

    Attributes:
        blocks: what was measured.
        before: observations under the given model.
        covariance: how far tiles may be off for known reasons.
        white: (n,) residual before, in units of the covariance.
        named: effects that were added for the mean depth, and the model with them.
        channels: what was found beside the mean, and the model with that too.
        possible: what smooth functions of all variables could explain before.
        left: the same, of what the named effects leave.
        candidates: all forms that change anything here, under the given model.
        held: frames that took no part.
        beyond: what is left and no entry of the catalogue explains, established or not; None when it is little.
        posterior: probability that laws are missing in the mean, and not only poses or targets worse than stated.
        alone: pixels that stand alone in most recordings; they take no part.
        rival: errors of poses, targets, mesh or camera file that may be all there is to what is likely.
    """

    blocks: tuple[FrameBlock, ...]
    before: Observations
    covariance: TileCovariance
    white: Vector
    named: Named
    channels: ChannelFindings
    possible: UnrestrictedGain
    left: UnrestrictedGain
    candidates: tuple[Candidate, ...]
    held: HeldOut
    beyond: Unknown | None = None
    posterior: float = 1.0
    alone: tuple[SinglePixel, ...] = ()
    rival: Explained | None = None

    def __repr__(self) -> str:
        found = dict.fromkeys(step.effect.name for step in self.named.steps)
        found |= dict.fromkeys(step.effect.name for step in self.channels.steps if step.established and step.effect)
        found |= {"something unknown": None} if self.unknown else {}
        return f"<Explanation of {len(self.blocks)} blocks of frames: {', '.join(found) or 'nothing'} missing>"

    @property
    def sensor(self) -> Sensor:
        """The model with all that was found, and how well every number of it is known: as it is written."""
        return with_deviations(self.channels.sensor, self.named.steps)

    @cached_property
    def compared(self) -> Compared:
        """The frames that took no part in the fit, where there are any, under the model before and after."""
        return compared(self)

    @property
    def mean_sensor(self) -> Sensor:
        """The model with all that was found for the mean depth."""
        return _extended(self.named, self.beyond)

    @property
    def white_left(self) -> Vector:
        """(n,) residual that the laws of the mean leave, in units of the covariance."""
        return self.named.white - (self.beyond.law.footprint if self.beyond is not None and self.unknown else 0.0)

    @property
    def spread(self) -> bool:
        """True when the noise is not what the given model says."""
        return bool(self.channels.of("noise"))

    @property
    def unknown(self) -> bool:
        """True when something is missing that no effect of the catalogue explains, and new recordings show it too."""
        return self.beyond is not None and self.beyond.law.replicated


def explain(
    recordings: Sequence[Recording],
    sensor: Sensor,
    simulated: Sequence[Recording] = (),
) -> Explanation:
    """Compare recordings of known scenes with a sensor model, and add what is missing.

    Args:
        recordings: with `scene.json`, mesh and poses.
        sensor: what is already known.
        simulated: what any simulator made of the same scenes, in the same order: it stands for the prediction, and
            no mesh is needed. The sensor model counts as in it.
    Raises:
        FusionError: a scene or pose is not known or is another one's, depth is a range, cameras differ, frames do not
            match, a recording is given twice, or no tile is left.

    >>> walls = [fusion.open_recording(f"wall_{i}") for i in range(5)]
    >>> found = fusion.explain(walls, fusion.read_sensor("kinect-v2-indoors"))
    >>> fusion.verdict_of(found).nothing_missing
    True
    """
    _same_cameras(recordings, sensor)
    baseline = sensor.baseline if sensor.principle.triangulates else None
    blocks: list[FrameBlock] = []
    prints: list[tuple[Path, Prints]] = []
    matches = matched(recordings, simulated) if simulated else []
    recordings = recordings if matches else at_levels(recordings, sensor)  # simulations are rounded as these are
    for place, recording in enumerate(each(recordings, "looking")):
        set_up = simulated_stage(matches[place], place, sensor) if matches else stage_of(recording, place)
        seen = blocks_of(set_up, wanted_channels(baseline, sensor.principle == Principle.TIME_OF_FLIGHT), sensor)
        prints.append((recording.path, frozenset().union(*(block.prints for block in seen))))
        refuse_copies(prints)
        blocks += seen
    refuse_ranges(blocks)
    wrapping = wrapping_of(blocks, sensor)  # all recordings together tell it from another scene
    if wrapping is not None:
        sensor, blocks = wrapping.added_to(sensor), clear_of_turns(blocks, wrapping)
    refuse_strangers(blocks, sensor)
    return explained_looks(joined(blocks), sensor, () if wrapping is None else (wrapping.step,))


def explained_looks(blocks: Sequence[FrameBlock], sensor: Sensor, told: tuple[ChannelStep, ...] = ()) -> Explanation:
    """What blocks of frames of known scenes show beyond a sensor model.

    Args:
        blocks: in any order.
        sensor: what is already known.
        told: what of that these blocks themselves have told.
    Raises:
        FusionError: too few tiles are left.
    """
    # a model that holds shaking says itself how much of it there is
    shaking = None if sensor.effect(SHAKES.name) else shaking_of(blocks)
    blocks = blocks if shaking is None else steadied(blocks, shaking)
    alone = single_pixels(blocks)
    blocks = without(blocks, alone)
    with stage("predicting"):
        before = observe(sensor, blocks)
    if len(before.residual) < 20:
        raise FusionError(
            "too little of the scene is seen to compare anything",
            found=f"{len(before.residual)} tiles with a depth and a prediction",
            expected="20 or more",
            do="check the poses, the mesh and its unit with fusion info",
        )
    stepped, steps = lattice_steps(before)
    if any(step.established for step in steps):  # the values that occur tell it whatever else is missing
        sensor, told = stepped, (*told, *steps)
        before = observe(sensor, blocks)
    grainy, _ = with_grain(before)  # how far tiles may be off; what of it is grain is told beside the mean's laws
    if grainy is not sensor:
        before = before.under(grainy)
    with stage("trying every effect"):
        covariance = covariance_of(before)  # whatever the likely poses are
        blocks = at_likely_poses(blocks, before, covariance)
        ways = _with_covariance(MeasuredForms.of(blocks, before.seen_again(blocks), covariance))
    with stage("naming"):
        mean = beside_setting(in_likeliest_errors(ways, grainy), ways[0], grainy).telling
    with stage("noise"):
        mean, grain = _judged(mean, sensor)
        first = (*told, *(() if shaking is None else (_shaken(shaking),)), *grain)
        channels = _channels(mean.named, mean.beyond, mean.seen.blocks, first)
    seen = mean.seen
    return Explanation(
        seen.blocks, seen.observations, seen.covariance, seen.white, mean.named, channels, mean.possible, mean.left,
        seen.candidates, mean.held, mean.beyond, mean.posterior, tuple(alone), mean.rival,
    )  # fmt: skip


def _with_covariance(stated: MeasuredForms) -> list[MeasuredForms]:
    """The recordings with errors as stated; and, where they show others that no law follows, with these as well."""
    seen = stated
    for _ in range(TURNS):
        # what is rough hides what is smooth until it is known
        loose = loose_of(seen.observations, seen.covariance, seen.candidates, seen.groups)
        if loose == Loose():
            break
        before = replace(seen.observations, loose=seen.observations.loose.with_more(loose))
        seen = MeasuredForms.of(seen.blocks, before, covariance_of(before))
    if seen is stated:
        return [stated]
    if seen.observations.loose.poses > 1.0:  # their errors are larger than was taken for likely
        blocks = tuple(at_likely_poses(seen.blocks, seen.observations, seen.covariance))
        seen = replace(seen, blocks=blocks, observations=seen.observations.seen_again(blocks))
    return [stated, seen]


def _judged(mean: MeanFindings, given: Sensor) -> tuple[MeanFindings, tuple[ChannelStep, ...]]:
    """The findings under the model with no grain but what is given, and the grain that all laws of the mean leave."""
    named, better = mean.named, as_given(mean.named.sensor, given, {step.effect.name for step in mean.named.steps})
    if better is not named.sensor:
        named = replace(named, sensor=better, observations=named.observations.under(better))
    laws = named.observations if mean.beyond is None else named.observations.under(mean.beyond.added_to(better))
    return replace(mean, named=named), with_grain(laws)[1]


def _extended(named: Named, beyond: Unknown | None) -> Sensor:
    """The model with what was found for the mean, and the source of each."""
    count = len(np.unique(named.observations.place))
    told = {step.effect.name: f"explained: what {count} recordings lack without it" for step in named.steps}
    better = replace(named.sensor, sources={**named.sensor.sources, **told})
    return better if beyond is None or not beyond.law.replicated else beyond.added_to(better)


def _channels(
    named: Named, beyond: Unknown | None, blocks: Sequence[FrameBlock], first: tuple[ChannelStep, ...]
) -> ChannelFindings:
    """What is found beside the mean, under the model with all that was found for the mean and `first`."""
    found = channels_of(named.observations, blocks)
    # the size of an effect that the mean has just been given is no number of the given model that is wrong
    given = {effect.name for effect in named.sensor.effects} - {step.effect.name for step in named.steps}
    kept = (s for s in found.steps if not s.corrected or s.effect is None or s.effect.name in given)
    found = replace(found, steps=(*first, *kept))
    sensor = _extended(named, beyond)
    for step in found.steps:
        sensor = step.added_to(sensor)
    std = {**sensor.std, **{key: value for key, value in found.sensor.std.items() if sensor.effect(key[0])}}
    return replace(found, sensor=replace(sensor, std=std))


def _shaken(shaking: Shaking) -> ChannelStep:
    std = {"sigma_m": shaking.std_m, "sigma_rad": shaking.std_rad}
    return ChannelStep("noise", shaking.effect, std, False, shaking.gain, shaking.share, shaking.probability)


def _same_cameras(recordings: Sequence[Recording], sensor: Sensor) -> None:
    if not recordings:
        raise FusionError("nothing to explain", found="no recordings", expected="one or more, better ten")
    first = recordings[0].camera
    if sensor.principle.or_else(first.principle) != first.principle.or_else(sensor.principle):
        raise FusionError(
            "the sensor model is of another kind than the camera",
            recordings[0].path,
            f"a {sensor.principle} model for a {first.principle} camera",
            do="check --sensor",
        )
    for recording in recordings[1:]:
        if recording.camera.shape != first.shape or recording.camera.principle != first.principle:
            raise FusionError(
                "the recordings are not of one camera",
                recording.path,
                f"{recording.camera.width} x {recording.camera.height}, {recording.camera.principle}",
                f"{first.width} x {first.height}, {first.principle}",
                "explain one camera at a time",
            )
