"""A known scene seen for a stretch of time: what was measured there, and what stood before the camera."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.unrounded import next_level
from fusion.discrepancy.observe.frames import FrameSeries
from fusion.discrepancy.observe.interior import interior
from fusion.discrepancy.observe.outliers import Stays
from fusion.discrepancy.observe.scene.stage import KnownScene
from fusion.discrepancy.observe.scene.stage import stage_of as stage_of
from fusion.discrepancy.observe.tiles import Tiling, tiling
from fusion.discrepancy.simulated import GivenImages, seen_in
from fusion.errors import RecordingError
from fusion.geometry.pose import Array
from fusion.progress import each
from fusion.recording.looking.copies import Prints, print_of
from fusion.recording.native.scene_file import stated_scene
from fusion.recording.recording import Recording
from fusion.sensor.laws.surface import moved_beyond
from fusion.sensor.moment import Moment
from fusion.sensor.moments import moments_of
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View
from fusion.simulation.rendering.casting import Body
from fusion.simulation.rendering.indirect import Bounce
from fusion.simulation.rendering.render import Channels, view_of

TOGETHER_S = 10.0  # frames within this time are one block: nothing warms up or drifts that fast
MOST_BLOCKS = 20  # a longer series is grouped
HELD_OUT = 3  # one frame in three takes no part in the fit
SCENE_FRAMES = 16  # of a block, in which what stays there is looked for, and what swings
LONG = 6  # blocks of a recording that make it a series


@dataclass(frozen=True)
class TileCourse:
    """How tiles of a block went from frame to frame."""

    tiles: Tiling
    depth: NDArray[np.float64]  # (frames, tiles) [m], less its mean
    pixels: NDArray[np.float64]  # (tiles,) that had a value, on average


@dataclass(frozen=True)
class FrameBlock:
    """Frames of one recording that are close in time, from one pose."""

    stage: KnownScene  # whose frames
    frames: tuple[int, ...]  # indices in the recording
    view: View  # what stood before the camera, with the amplitude of the recording where there is one
    # mean, std: (h, w) of the measured depth [m], NaN where no value (no second one) is
    mean: Image
    std: Image  # over its frames; of single frames that others follow from the same pose, over these
    count: NDArray[np.int32]  # (h, w) frames with a value
    T_world_camera: Array = field(default_factory=lambda: np.eye(4))  # (4, 4) stated pose
    # the same pose and time in frames that take no part in any fit; None where there are too few
    held: "FrameBlock | None" = None
    # (h, w) half the mean square of the change from a frame to the next [m^2]; None where not known
    succession: Image | None = None
    # (2, k) correlation of the noise of pixels 0, 1, ... apart along u and along v; None where not known.
    alike: NDArray[np.float64] | None = None
    given: GivenImages | None = None  # what another simulator predicts; None where the sensor model alone does
    prints: Prints = frozenset()  # what tells its frames, and those held out, from all others
    course: TileCourse | None = None  # how its tiles went from frame to frame; None of single frames
    # standard deviations [rad], [m] of the motions of its frames; empty of a camera that stood still
    shaken: tuple[float, ...] = ()
    times: tuple[float, ...] = ()  # [s] of its frames, or of some of many; empty where all are as in its middle
    passed: int = 0  # number of frames, with those held out, before which something passes: it is out of them
    # likely error of the pose, as a motion (6,) of the scene in the camera frame [rad, m]; tiles are linear in errors
    # about this one. Empty where it is too small to matter.
    moved: tuple[float, ...] = ()

    @property
    def place(self) -> int:
        return self.stage.place

    @cached_property
    def moved_beyond(self) -> Image | float:
        """(h, w) [m] what the likely error of the pose changes beyond its first order, whatever the sensor model."""
        if not self.moved or self.view.depth is None:
            return 0.0
        return moved_beyond(self.view.depth, np.array(self.moved), self.view)


def blocks_of(stage: KnownScene, channels: Channels, sensor: Sensor | None = None) -> list[FrameBlock]:
    """All stretches of a recording, in order. RecordingError when no frame is at the time of a pose.

    Args:
        sensor: what is known of how depths are rounded.
    """
    blocks = [_block_of(stage, frames, channels, sensor) for frames in each(_blocks(stage), stage.recording.path.name)]
    if len(blocks) < LONG or any(block.held for block in blocks):
        return blocks
    blocks = _with_scatter(blocks)
    # a series of single frames holds out every third of them, whole
    pairs = zip(blocks, [*blocks[1:], None], strict=True)
    kept = [replace(block, held=after) if k % HELD_OUT == 1 else block for k, (block, after) in enumerate(pairs)]
    return [block for k, block in enumerate(kept) if k % HELD_OUT != 2]


def _with_scatter(blocks: list[FrameBlock]) -> list[FrameBlock]:
    """Single frames from one pose with their scatter about the line through those before and after: drift is none."""
    means = np.array([block.mean for block in blocks])
    if not all(np.array_equal(block.T_world_camera, blocks[0].T_world_camera) for block in blocks):
        return blocks
    bends = (means[:-2] - 2 * means[1:-1] + means[2:]) ** 2 / 6
    known = np.isfinite(bends)
    std = np.sqrt(np.where(known, bends, 0.0).sum(axis=0) / np.where(known.any(axis=0), known.sum(axis=0), np.nan))
    return [replace(block, std=std) if len(block.frames) == 1 else block for block in blocks]


def wanted_channels(baseline: float | None, indirect: bool) -> Channels:
    """What effects may ask of a view."""
    return Channels(edges=True, lit=baseline, motion=True, indirect=Bounce() if indirect else None, area=True)


def _blocks(stage: KnownScene) -> list[tuple[int, ...]]:
    """Frame indices that belong together: close in time and with the same pose."""
    recording, poses = stage.recording, stage.recording.poses
    assert poses is not None
    match = stage.simulated[0] if stage.simulated else None
    at_frames = poses.at(recording.timestamps)
    blocks: list[list[int]] = []
    for i, stamp in enumerate(recording.timestamps):
        if not at_frames.valid[i] or (match and match.partner[i] < 0):
            continue
        last = blocks[-1] if blocks else None
        if (
            last
            and stamp - recording.timestamps[last[0]] < TOGETHER_S
            and np.allclose(at_frames.poses[i], at_frames.poses[last[0]], atol=1e-9)
            and (match is None or match.same(last[0], i))
        ):
            last.append(i)
        else:
            blocks.append([i])
    size = -(-len(blocks) // MOST_BLOCKS)
    same = match is None and all(
        np.allclose(at_frames.poses[b[0]], at_frames.poses[blocks[0][0]], atol=1e-9) for b in blocks
    )
    if size > 1 and same:
        blocks = [[i for block in blocks[k : k + size] for i in block] for k in range(0, len(blocks), size)]
    if not blocks:
        raise RecordingError(
            "no frame is at the time of a pose",
            recording.path,
            f"frames {_span(recording.timestamps)}, poses {_span(poses.timestamps[poses.valid])}",
            "poses at the times of the frames",
            "check the time stamps in depth.txt and groundtruth.txt",
        )
    return [tuple(block) for block in blocks]


def _span(stamps: NDArray[np.float64]) -> str:
    return f"from {stamps.min():.10g} to {stamps.max():.10g} s"


def _block_of(stage: KnownScene, frames: tuple[int, ...], channels: Channels, sensor: Sensor | None) -> FrameBlock:
    recording = stage.recording
    assert recording.poses is not None
    T_world_camera = recording.poses.at(recording.timestamps).poses[frames[0]]
    view, given = _seen(stage, frames, T_world_camera, channels)
    moment = _moment(recording, frames)
    if stage.table is not None:
        point, direction = stage.table.in_camera(T_world_camera)
        moment = replace(moment, axis_point=point, axis_direction=direction)
    view = replace(view, moment=moment)
    kept = len(frames) - (len(frames) // HELD_OUT if len(frames) > 3 else 0)
    some = np.array([stage.recording[i].depth for i in frames[:: -(-len(frames) // SCENE_FRAMES)]])
    stays = Stays(some, lambda depth: 0.0 if sensor is None else next_level(sensor, depth, recording.camera))
    block = replace(_measured(stage, frames[:kept], view, T_world_camera, stays), given=given)
    if kept == len(frames):
        return block
    held = replace(_measured(stage, frames[kept:], view, T_world_camera, stays), given=given)
    return replace(block, held=held, prints=block.prints | held.prints, passed=block.passed + held.passed)


def _seen(
    stage: KnownScene, frames: tuple[int, ...], T_world_camera: Array, channels: Channels
) -> tuple[View, GivenImages | None]:
    """What stood before the camera, with the amplitude that was recorded, and what a simulation predicts."""
    ir = _infrared(stage.recording, frames)
    if stage.simulated:
        match, sensor = stage.simulated
        view, given = seen_in(match, frames, sensor)
        return (
            (view, given)
            if view.ir is not None or ir is None
            else (replace(view, ir=np.asarray(ir, np.float32)), given)
        )
    assert stage.caster is not None
    twist = None if stage.twists is None else stage.twists[list(frames)].mean(axis=0)
    body = Body(stage.caster, turning=stage.table is not None)
    view = view_of((body,), stage.recording.camera, T_world_camera, channels, twist)
    view = replace(view, placed_by_images=stage.placed_by_images)
    return replace(view, ir=None if ir is None else np.asarray(ir, np.float32)), None


def _measured(
    stage: KnownScene, frames: tuple[int, ...], view: View, T_world_camera: Array, stays: Stays
) -> FrameBlock:
    tiles = tiling(np.isfinite(view.depth) & interior(view)) if view.depth is not None and len(frames) > 1 else None
    series, prints, passed = FrameSeries(view.camera.shape, tiles), set(), 0
    for i in frames:
        depth = stage.recording[i].depth
        before = stays.hidden(depth)
        series.add(np.where(before, np.nan, depth))
        prints.add(print_of(depth))
        passed += bool(before.any())
    pixels = series.pixels
    return FrameBlock(
        stage,
        frames,
        view,
        pixels.mean,
        pixels.std,
        pixels.count,
        T_world_camera,
        succession=series.succession if len(frames) > 1 else None,
        alike=series.alike,
        prints=frozenset(prints - {b""}),
        course=None if tiles is None or series.course is None else TileCourse(tiles, series.course, series.seen),
        times=tuple(stage.recording.timestamps[list(frames[:: -(-len(frames) // SCENE_FRAMES)])].tolist()),
        passed=passed,
    )


def _infrared(recording: Recording, frames: tuple[int, ...]) -> NDArray[np.uint16] | None:
    """The infrared image of the first of these frames that has one: recordings often hold one only, so any from the
    same pose will do.
    """
    has = recording.has_ir
    if has is None:
        return recording[frames[0]].ir
    assert recording.poses is not None
    poses = recording.poses.at(recording.timestamps).poses
    near = (i for i in (*frames, *map(int, np.flatnonzero(has))) if has[i])
    found = next((i for i in near if np.allclose(poses[i], poses[frames[0]], atol=1e-9)), None)
    return None if found is None else recording[found].ir


def _moment(recording: Recording, frames: tuple[int, ...]) -> Moment:
    logged, some = moments_of(recording), list(frames)
    ambient = float(np.mean(logged.ambient[some]))
    return Moment(
        # stamps as they are: dates too tell one block from the next
        time=float(np.mean(recording.timestamps[some])),
        temperature=float(np.mean(logged.temperature[some])),
        ambient=ambient if np.isfinite(ambient) else stated_scene(recording).ambient_lux or 0.0,
        table_angle=float(np.nan_to_num(np.mean(logged.table_angle[some]))),
    )
