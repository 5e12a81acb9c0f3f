"""Perfect depth as a sensor would have measured it, frame by frame, from arrays to arrays."""

import os
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera, Principle
from fusion.recording.recording import Frame
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image
from fusion.simulation.ideal.frame import IdealFrame, checked
from fusion.simulation.ideal.view import view_of_ideal
from fusion.simulation.rendering.light_level import infrared, with_light_level
from fusion.simulation.simulate import FRAME, INFRARED, PLACEMENT, measured, unit_seed


def sense(ideal: IdealFrame | Image, camera: Camera, sensor: Sensor, seed: int = 0, index: int = 0) -> Frame:
    """One frame of a sensor that stands where a perfect depth camera stood; the same arguments, the same bits.

    Args:
        ideal: perfect depth (h, w) [m] with what else is known; an array is depth alone.
        camera: that made it.
        sensor: what it does wrong.
        seed: of every random number; frames of one recording have one seed.
        index: of the frame in its recording: each has random numbers of its own.

    Raises:
        SensorError: an array or a map of the sensor does not fit the camera.

    >>> camera = fusion.Camera(640, 480, fx=525.0, fy=525.0, cx=319.5, cy=239.5)
    >>> wall = np.full(camera.shape, 2.0, np.float32)
    >>> frame = fusion.sense(wall, camera, fusion.read_sensor("kinect-v1"), seed=1)
    >>> 0.004 < float(np.nanstd(frame.depth)) < 0.02
    True
    """
    return _one(_as_ideal(ideal), camera, with_light_level(sensor), seed, index, 0, _aside())


def sense_all(
    ideals: Iterable[IdealFrame | Image], camera: Camera, sensor: Sensor, seed: int = 0, threads: int = 2
) -> Iterator[Frame]:
    """The same for frames one after another: a recording, or a batch (n, h, w); in their order, none is kept.

    What is frozen while a scene stands still stays so as long as the depth does not change, and a sensor that filters
    in time is given its own last frame. The bits do not depend on the number of threads.

    Raises:
        SensorError: as `sense`.

    >>> camera = fusion.Camera(64, 48, fx=52.5, fy=52.5, cx=31.5, cy=23.5)
    >>> batch = np.full((3, 48, 64), 1.5, np.float32)
    >>> frames = fusion.sense_all(batch, camera, fusion.read_sensor("kinect-v2-indoors"))
    >>> np.stack([frame.depth for frame in frames]).shape
    (3, 48, 64)
    """
    sensor = with_light_level(sensor)
    placed = _placed(map(_as_ideal, ideals))
    if sensor.effect("temporal_filtering") is not None or threads < 2:
        previous: Image | None = None
        for index, (frame, placement) in enumerate(placed):
            frame = replace(frame, moment=replace(frame.moment, previous=previous))
            made = _one(frame, camera, sensor, seed, index, placement)
            previous = made.depth
            yield made
        return
    with ThreadPoolExecutor(threads) as pool:
        waiting: deque[Future[Frame]] = deque()
        for index, (frame, placement) in enumerate(placed):
            waiting.append(pool.submit(_one, frame, camera, sensor, seed, index, placement))
            if len(waiting) > threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def stated_by(camera: Camera, sensor: Sensor) -> Camera:
    """The camera with the sensor's principle, name and number, as its recordings state it."""
    return replace(
        camera,
        principle=sensor.principle.or_else(camera.principle),
        sensor=sensor.sensor or sensor.name,
        serial=sensor.serial or camera.serial,
    )


def _as_ideal(ideal: IdealFrame | Image) -> IdealFrame:
    return ideal if isinstance(ideal, IdealFrame) else IdealFrame(np.asarray(ideal))


def _placed(frames: Iterable[IdealFrame]) -> Iterator[tuple[IdealFrame, int]]:
    """Each frame, and how often what it shows has been set up anew."""
    placement, last = -1, None
    for frame in frames:
        if last is None or not np.array_equal(frame.depth, last, equal_nan=True):
            placement += 1
        last = frame.depth
        yield frame, placement


@cache
def _aside() -> ThreadPoolExecutor:
    """A thread for the infrared image of a single frame, made beside its depth."""
    return ThreadPoolExecutor(1, "fusion-infrared")


os.register_at_fork(after_in_child=_aside.cache_clear)  # its thread stays with the parent


def _one(
    ideal: IdealFrame, camera: Camera, sensor: Sensor, seed: int, index: int, placement: int,
    aside: ThreadPoolExecutor | None = None,
) -> Frame:  # fmt: skip
    camera = stated_by(camera, sensor)
    ideal = checked(ideal, camera)
    frozen = int(np.random.SeedSequence([seed, PLACEMENT, placement]).generate_state(1)[0])
    moment = replace(ideal.moment, unit=unit_seed(sensor, camera), placement=frozen)
    view = view_of_ideal(replace(ideal, moment=moment), camera, sensor)
    with np.errstate(all="ignore"):
        view = replace(view, ir=sensor.amplitude(view))

    # generators of its own per frame, as the simulator has them
    def light() -> NDArray[np.uint16] | None:
        if sensor.principle == Principle.STRUCTURED_LIGHT:  # that sees its pattern
            return None
        return infrared(view, sensor, np.random.default_rng([seed, INFRARED, index]))

    beside = None if aside is None else aside.submit(light)
    depth = measured(view, sensor, (0.0, 0.0), np.random.default_rng([seed, FRAME, index]))
    return Frame(index, moment.time, depth, None, light() if beside is None else beside.result())
