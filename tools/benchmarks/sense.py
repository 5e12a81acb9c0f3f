"""How long a perfect frame of 640 x 480 takes to become what each preset's sensor would have made of it.

    python -m tools.benchmarks.sense [--frames 16]

A wall, and a room with many edges, each with a reflectance, so that all effects of light act. For each preset, in
milliseconds: of one `fusion.sense` the median time, what it costs the processor, and what of that its own thread does
(the infrared image and kernels have others); of a frame in `fusion.sense_all` on two threads the time, and what it
costs the processor: half of that is what it takes of two cores that nobody else uses.
"""

import argparse
import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import fusion
from fusion.sensor.presets import PRESETS
from fusion.simulation.scenes import built_in
from fusion.simulation.simulate import simulate

CAMERA = fusion.Camera(640, 480, 525.0, 525.0, 319.5, 239.5)


def measured(depth: NDArray[np.float32], sensor: fusion.Sensor, frames: int) -> tuple[float, ...]:
    """Wall, processor and own thread's time [ms] of one frame (medians), then the first two of one among many."""
    ideal = fusion.IdealFrame(depth, reflectance=0.6)
    fusion.sense(ideal, CAMERA, sensor)  # compiles
    single = []
    for index in range(frames):
        begin = np.array([time.perf_counter(), time.process_time(), time.thread_time()])
        fusion.sense(ideal, CAMERA, sensor, 1, index)
        single.append([time.perf_counter(), time.process_time(), time.thread_time()] - begin)
    begin = np.array([time.perf_counter(), time.process_time()])
    for _ in fusion.sense_all([ideal] * frames, CAMERA, sensor, 1):
        pass
    many = [time.perf_counter(), time.process_time()] - begin
    return tuple(1e3 * np.concatenate([np.median(single, axis=0), many / frames]))


def main() -> None:
    """Measure every preset and print a line for each scene."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=16)
    options = parser.parse_args()
    room = replace(built_in("room", {"frames": 1}), camera=CAMERA)
    depths = {"wall": np.full(CAMERA.shape, 2.0, np.float32), "room": next(simulate(room).frames()).depth}
    print(f"{'[ms]':<27}{'one':>10}{'processor':>10}{'thread':>10}{'of many':>10}{'processor':>10}")
    for name in PRESETS:
        sensor = fusion.read_sensor(name)
        for scene, depth in depths.items():
            found = measured(depth, sensor, options.frames)
            print(f"{name:<20}{scene:<7}" + "".join(f"{value:>10.1f}" for value in found), flush=True)


if __name__ == "__main__":
    main()
