"""What is chosen from a bag, and how it becomes a recording."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.geometry.trajectory import Trajectory
from fusion.recording.formats.bags.containers.store import Topic
from fusion.recording.formats.bags.messages.values import header_stamps
from fusion.recording.formats.bags.pictures import color_image, depth_image, grey_image
from fusion.recording.images.frame_files import ASSOCIATION_SECONDS, associate, in_time
from fusion.recording.images.load_frame import counts_to_metres
from fusion.recording.recording import Frame, FrameStreams, Recording

# counts a metre for depth that is stored as floating numbers, when it is written as counts: TUM's, 0.2 mm to 13 m
METRES_SCALE = 5000.0
# unpacking a bag only for the stamps inside its messages takes a second for each 1 GB or so
PACKED_BYTES = 1e9


@dataclass(frozen=True)
class BagStream:
    """Images of one camera in a bag."""

    topic: Topic  # its messages
    stamps: NDArray[np.float64]  # (n,) [s], of each message, in any order
    camera: Camera | None = None  # as the bag states it, or None

    @property
    def arrivals(self) -> NDArray[np.float64]:
        """(n,) [s] when each message was recorded."""
        return np.asarray(self.topic.stamps / 1e9)


@dataclass(frozen=True)
class ChosenStreams:
    """What a recording is made of.

    Attributes:
        format: its name.
        depth, color, ir: the streams; the depth's camera is known.
        metres: depth is stored in metres.
        T_color_depth: (4, 4) maps points of the depth camera to the colour camera, or None where that is not known.
        same_pixels: colour is in the depth camera's pixels, as the bag says.
        telemetry, scene, settings: as in a recording.
        poses: stated poses at some stamps, or None.
        warnings: one sentence each.
    """

    format: str
    depth: BagStream
    color: BagStream | None = None
    ir: BagStream | None = None
    metres: bool = False
    T_color_depth: Array | None = None
    same_pixels: bool = False
    telemetry: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    scene: dict[str, Any] = field(default_factory=dict)
    poses: Callable[[NDArray[np.float64]], Trajectory | None] = field(default=lambda stamps: None)
    warnings: tuple[str, ...] = ()
    settings: dict[str, str] = field(default_factory=dict)


def stream_stamps(topic: Topic, size: int, warnings: list[str]) -> NDArray[np.float64]:
    """Stamps (n,) [s] of a topic's messages: those in their headers, else the recorder's.

    Args:
        topic: of messages with a header.
        size: bytes of one message, about.
        warnings: what is to be told is appended.
    """
    if topic.packed and size * len(topic) > PACKED_BYTES:
        warnings.append(f"{topic.name}: time stamps are the recorder's, as the bag is packed: some milliseconds late")
        return np.asarray(topic.stamps / 1e9)
    stamps, _ = header_stamps(topic)
    # a driver without a clock leaves one number in all
    if len(stamps) > 1 and (stamps == stamps[0]).all():
        warnings.append(f"{topic.name}: all headers have one time stamp: the recorder's are used")
        stamps = topic.stamps
    return np.asarray(stamps / 1e9)


def recording_of(path: Path, chosen: ChosenStreams) -> Recording:
    """The recording of what was chosen; images are read when they are asked for. Raises RecordingError."""
    camera, depth, warnings = chosen.depth.camera, chosen.depth, list(chosen.warnings)
    assert camera is not None
    order = np.argsort(depth.stamps, kind="stable")
    stamps = depth.stamps[order]
    if not np.isfinite(stamps).all():
        raise RecordingError("a time stamp is not finite", path, depth.topic.name, "seconds")
    color, apart, camera = _placed_color(chosen, camera, warnings)
    ir = chosen.ir
    if ir is not None and ir.camera is not None and ir.camera.shape != camera.shape:
        warnings.append("infrared is not in the depth camera's pixels and left out")
        ir = None
    (at_color, lost_color), (at_ir, lost_ir) = (_matched(stream, depth, order, warnings) for stream in (color, ir))
    load = partial(_load, depth.topic, camera, order, stamps, None if apart else color, at_color, ir, at_ir)
    streams = FrameStreams(
        color=at_color >= 0,
        ir=at_ir >= 0,
        counts=None if chosen.metres else lambda index: depth_image(depth.topic, int(order[index]), camera.shape),  # type: ignore[arg-type,return-value]
        color_apart=partial(_apart, color, at_color) if apart and color is not None else None,
        steps_back=max(depth.topic.steps_back, int((np.diff(depth.stamps) < 0).sum())),
        arrivals=depth.arrivals[order],
        unmatched={
            s.topic.name: (lost, len(s.stamps)) for s, lost in ((color, lost_color), (ir, lost_ir)) if s is not None
        },
    )
    for name, (lost, total) in streams.unmatched.items():
        if lost:
            warnings.append(f"{lost} of {total} images of {name} have no depth frame within {ASSOCIATION_SECONDS:g} s")
    return Recording(
        path=path,
        format=chosen.format,
        camera=camera,
        timestamps=stamps,
        load=load,
        poses=chosen.poses(stamps),
        telemetry=chosen.telemetry,
        scene=chosen.scene,
        warnings=tuple(dict.fromkeys(warnings)),
        streams=streams,
        settings=chosen.settings,
    )


def _placed_color(chosen: ChosenStreams, camera: Camera, warnings: list[str]) -> tuple[BagStream | None, bool, Camera]:
    """The colour stream, whether it has pixels of its own, and the camera with the colour camera beside it."""
    color = chosen.color
    if color is None:
        return None, False, camera
    seen = color.camera
    if chosen.same_pixels and (seen is None or seen.shape == camera.shape):
        return color, False, camera
    if seen is not None and chosen.T_color_depth is not None:
        T = chosen.T_color_depth
        alike = np.allclose(seen.parameters, camera.parameters, rtol=1e-3) and seen.shape == camera.shape
        if alike and np.allclose(T, np.eye(4), atol=1e-6):
            return color, False, camera
        return color, True, replace(camera, color=seen, T_color_depth=T)
    reason = "its camera is not stated" if seen is None else "the bag does not say where the colour camera stands"
    warnings.append(f"colour is not registered to depth and left out: {reason}")
    return None, False, camera


def _matched(
    stream: BagStream | None, depth: BagStream, order: NDArray[np.intp], warnings: list[str]
) -> tuple[NDArray[np.intp], int]:
    """Message of a stream that belongs to each depth frame, -1 where there is none, and how many belong to none.

    Where its clock is another one than the depth's (a device's beside a computer's) the moment of recording counts;
    that is told.
    """
    if stream is None:
        return np.full(len(order), -1, np.intp), 0
    stamps = depth.stamps[order]
    found, most = associate(stamps, stream.stamps), min(len(stamps), len(stream.stamps))
    if 2 * int((found >= 0).sum()) >= most:
        return found, int((~in_time(stream.stamps, stamps)).sum())
    arrivals = depth.arrivals[order]
    by_arrival = associate(arrivals, stream.arrivals)
    if (by_arrival >= 0).sum() <= (found >= 0).sum():
        return found, int((~in_time(stream.stamps, stamps)).sum())
    there = by_arrival >= 0
    apart = float(np.median(stream.stamps[by_arrival[there]] - stamps[there]))
    warnings.append(
        f"the clock of {stream.topic.name} is {apart:+.3f} s off that of the depth: images are joined that were "
        "recorded at the same moment"
    )
    return by_arrival, int((~in_time(stream.arrivals, arrivals)).sum())


def _apart(stream: BagStream, places: NDArray[np.intp], index: int) -> NDArray[np.uint8] | None:
    return color_image(stream.topic, int(places[index])) if places[index] >= 0 else None


def _load(  # one argument per part of a frame
    topic: Topic,
    camera: Camera,
    order: NDArray[np.intp],
    stamps: NDArray[np.float64],
    color: BagStream | None,
    at_color: NDArray[np.intp],
    ir: BagStream | None,
    at_ir: NDArray[np.intp],
    index: int,
) -> Frame:
    stored = depth_image(topic, int(order[index]), camera.shape)
    in_counts = stored.dtype == np.uint16
    depth = counts_to_metres(stored.astype(np.uint16), camera.depth_scale) if in_counts else stored.astype(np.float32)
    unfit = []
    colors = _apart(color, at_color, index) if color is not None else None
    if colors is not None and colors.shape[:2] != camera.shape:
        colors, unfit = None, ["color"]
    amplitude = grey_image(ir.topic, int(at_ir[index])) if ir is not None and at_ir[index] >= 0 else None
    if amplitude is not None and amplitude.shape != camera.shape:
        amplitude, unfit = None, [*unfit, "ir"]
    return Frame(index, float(stamps[index]), depth, colors, amplitude, tuple(unfit))
