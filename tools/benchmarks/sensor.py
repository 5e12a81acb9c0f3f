"""How long a simulated frame takes: rendering by channel, sampling it with twelve effects, and undoing a depth law.

    python -m tools.benchmarks.sensor [--runs 9] [--json FILE]
    python -m tools.benchmarks.sensor --ideal [PRESET ...]    perfect depth through sensors, 640 x 480

Medians on this machine, in milliseconds of the clock, and beside them of the processors (all threads together), which
tell more where other programs run. Preparing the mesh (Embree's tree) is not in the times of a frame.
"""

import argparse
import json
import os
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fusion.geometry.camera import Camera, Principle
from fusion.geometry.pose import Array
from fusion.mesh.mesh import Mesh
from fusion.sensor.correction.estimate import estimated_view
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.moment import Moment
from fusion.sensor.parameter import parameters
from fusion.sensor.presets import PRESETS, preset
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image, View
from fusion.simulation.demo.demo import CAMERA, demo_truth, looking_at, plate, surroundings
from fusion.simulation.ideal.frame import IdealFrame
from fusion.simulation.ideal.sense import sense
from fusion.simulation.rendering.indirect import Bounce
from fusion.simulation.rendering.render import Channels, RayCaster
from fusion.simulation.scene.shapes import joined, sheet

RENDERED_MS, SAMPLED_MS, SENSED_MS = 150.0, 60.0, 20.0  # what a frame may take on two cores
AS_FAST = 1.3  # times a curve: what undoing a stack may take
SENSOR_CAMERA = Camera(512, 424, 365.0, 365.0, 255.5, 211.5, principle=Principle.TIME_OF_FLIGHT)
PERFECT_CAMERA = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)
Times = dict[str, tuple[float, float]]  # [ms] of the clock and of the processors
# with the ones of the preset, twelve
ADDED = {
    "kinect-v2-indoors": ("multipath", "stray_light", "temperature_drift"),
    "kinect-v1": (
        "edge_fattening",
        "disparity_distortion",
        "speckle_noise",
        "pixel_locking",
        "projector_thermal_drift",
        "temperature_drift",
        "fixed_pattern",
    ),
}
ALL = Channels(edges=True, lit=0.075, motion=True)
RENDERED = {
    "depth, incidence, normals": Channels(color=False),
    "and colour, reflectance": Channels(),
    "and edges": Channels(edges=True),
    "and projector": Channels(lit=0.075),
    "all but indirect light": ALL,
    "indirect light": Channels(indirect=Bounce()),
    "indirect light, no shadows": Channels(indirect=Bounce(shadows=False)),
}


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=9)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--ideal", nargs="*", metavar="PRESET", help="time fusion.sense instead (default: all presets)")
    options = parser.parse_args()
    if options.ideal is not None:
        times = sensing(options.ideal or list(PRESETS), options.runs)
        print(f"asked for: {SENSED_MS:.0f} ms of two processors for a frame")
        told(options.json, times)
        return
    mesh, T_world_camera = scene()
    began = time.perf_counter()
    caster = RayCaster(mesh)
    caster.view(SENSOR_CAMERA, T_world_camera)  # the tree is made for the first ray
    print(f"{len(mesh.faces)} triangles, first view after {time.perf_counter() - began:.2f} s, {os.cpu_count()} cores")
    times = {}
    for name, channels in RENDERED.items():
        runs = 1 if channels.indirect else options.runs
        times[name] = measured(partial(caster.view, CAMERA, T_world_camera, channels), runs)
    depth = np.asarray(caster.view(CAMERA, T_world_camera).depth)
    times["estimated view"] = measured(partial(estimated_view, depth, CAMERA, projector=0.075), options.runs)
    for name in ADDED:
        times[f"twelve effects on {name}"] = sampling(name, caster, T_world_camera, options.runs)
    times |= correcting(options.runs)
    for name, (clock, cores) in times.items():
        print(f"{name:40s} {clock:7.1f} ms   {cores:7.1f} ms of the processors")
    print(f"asked for: {RENDERED_MS:.0f} ms for all but indirect light, {SAMPLED_MS:.0f} ms for twelve effects")
    curve, stack = (cores for name, (_, cores) in times.items() if name.startswith("undoing"))
    print(f"a stack takes {stack / curve:.2f} times the time of a curve (asked for: as fast, {AS_FAST} at most)")
    told(options.json, times)


def scene() -> tuple[Mesh, Array]:
    """The demo's owl on its plate before a table, a wall and another one: 200 000 triangles."""
    x, y, z = np.eye(3)
    side = sheet(-0.55 * x - 0.9 * y - 0.5 * z, 1.0 * x, 1.8 * z, lambda p: np.full((len(p), 3), 150.0))
    mesh = joined((demo_truth(), plate(), *surroundings(), side))
    return mesh, looking_at(np.array([0.66, 0.06, 0.38]), np.array([0.0, 0.0, 0.085]))


def sensing(names: list[str], runs: int) -> Times:
    """Times [ms] of a frame of perfect depth with reflectance through sensors: a wall, the owl, and many edges."""
    caster = RayCaster(scene()[0])
    owl = np.asarray(caster.view(PERFECT_CAMERA, scene()[1], Channels(color=False)).depth)
    scenes = {"wall": np.full(PERFECT_CAMERA.shape, 2.0, np.float32), "owl": owl, "60 cards": cards()}
    times = {}
    for name in names:
        sensor, line = preset(name), f"{name:20s}"
        for seen, depth in scenes.items():
            frame = IdealFrame(depth, reflectance=0.5)
            times[f"{name}, {seen}"] = clock, cores = measured(
                partial(sense, frame, PERFECT_CAMERA, sensor, 1), max(runs, 2)
            )
            line += f"   {seen}: {clock:6.1f} ms, {cores:6.1f} ms of the processors"
        print(line, flush=True)
    return times


def cards() -> Image:
    """Depth (h, w) [m] of 60 cards before a wall: a quarter of the pixels lie within 4 px of an edge."""
    rng, depth = np.random.default_rng(0), np.full(PERFECT_CAMERA.shape, 2.5, np.float32)
    for _ in range(60):
        v, u, height, width = (int(x) for x in rng.uniform((0, 0, 20, 20), (440, 600, 120, 120)))
        depth[v : v + height, u : u + width] = rng.uniform(0.8, 2.3)
    return depth


def told(path: Path | None, times: Times) -> None:
    """Write the times to a file, where one is asked for."""
    if path is not None:
        path.write_text(json.dumps({name: {"clock_ms": a, "cpu_ms": b} for name, (a, b) in times.items()}))


def sampling(name: str, caster: RayCaster, T_world_camera: Array, runs: int) -> tuple[float, float]:
    """Time [ms] of one frame 512 x 424 with the effects of a preset and those of ADDED."""
    kinds = {kind.name: kind for kind in EFFECTS}
    sensor = preset(name)
    sensor = replace(sensor, effects=(*sensor.effects, *(typical(kinds[added]) for added in ADDED[name])))
    assert len(sensor.effects) == 12
    camera = replace(SENSOR_CAMERA, principle=sensor.principle)
    channels = replace(ALL, indirect=Bounce(16, shadows=False))
    moment = Moment(time=600.0, temperature=30.0, unit=1, placement=2)
    view = replace(caster.view(camera, T_world_camera, channels), moment=moment)
    rng = np.random.default_rng(0)
    return measured(partial(one_frame, sensor, view, rng), runs)


def correcting(runs: int) -> dict[str, tuple[float, float]]:
    """Times [ms] of undoing a curve, and a stack of maps that holds the same curve, of 640 x 480 and 27 walls."""
    camera = Camera(640, 480, 585.0, 585.0, 319.5, 239.5, principle=Principle.STRUCTURED_LIGHT)
    rng, u = np.random.default_rng(0), np.arange(640)
    depth = (1.2 + 0.3 * np.sin(u / 90) + rng.normal(0, 0.003, camera.shape)).astype(np.float32)
    walls = np.linspace(0.6, 3.2, 27)
    curve, tiles = 0.005 * np.sin(3 * walls), (np.arange(15.5, 480, 32), np.arange(15.5, 640, 32))
    grid = tuple(tuple(map(float, nodes)) for nodes in (*tiles, walls))
    maps = curve + rng.normal(0, 0.003, (len(tiles[0]), len(tiles[1]), 1)) * (1 + 0.2 * np.sin(2 * walls))
    laws = {"curve": Tabulated(("depth",), grid[2:], curve), "stack": Tabulated(("v", "u", "depth"), grid, maps)}
    return {
        f"undoing a {name} of 27 walls": measured(
            partial(Sensor(principle=Principle.STRUCTURED_LIGHT, effects=(law,)).correct, depth, camera), runs
        )
        for name, law in laws.items()
    }


def one_frame(sensor: Sensor, view: View, rng: np.random.Generator) -> None:
    """Amplitude and depth of one frame."""
    sensor.sample(np.asarray(view.depth), replace(view, ir=sensor.amplitude(view)), None, rng)


def typical(kind: type[Effect]) -> Effect:
    """An effect at its parameters' typical values."""
    values: dict[str, Any] = {about.name: about.typical for about in parameters(kind).values()}
    return kind(**values)


def measured(work: Callable[[], object], runs: int) -> tuple[float, float]:
    """Median time [ms] of the clock and of the processors, after a first run that fills caches."""
    if runs > 1:
        work()
    times = []
    for _ in range(runs):
        clock, cores = time.perf_counter(), time.process_time()
        work()
        times.append((1e3 * (time.perf_counter() - clock), 1e3 * (time.process_time() - cores)))
    clock_ms, cores_ms = np.median(times, axis=0)
    return float(clock_ms), float(cores_ms)


if __name__ == "__main__":
    main()
