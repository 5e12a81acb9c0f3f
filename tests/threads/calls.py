"""A call of every public entry point: what it is made with, and what it gives."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from inputs import CAMERA, POINTS, Inputs

import fusion

Call = Callable[[Inputs, Path], Any]  # with a place of its own for what it writes
BAGS = Path(__file__).resolve().parents[1] / "recording" / "bags"  # by RealSense's own recorders
COARSE = fusion.VolumeSettings(voxel=0.01, truncation=0.04, color=True)


def camera(given: Inputs, out: Path) -> Any:
    seen = fusion.find_camera("kinect-v2")
    one = fusion.Camera(96, 72, 86.0 + given.seed, 86.0, 48.0, 36.0, (0.05, -0.1, 0.001, 0.002), depth_scale=5000.0)
    fusion.write_camera(out / "camera.json", one)
    points = one.points(given.depth)
    return (
        seen,
        one.rays(),
        one.blind(),
        points,
        one.project(points[np.isfinite(given.depth)]),
        one.halved().rays(),
        one.resized(64, 48),
        out,
    )


def poses(given: Inputs, out: Path) -> Any:
    course = fusion.built_in("room", {"frames": 5}).course.T_world_camera
    trajectory = fusion.Trajectory(np.arange(5.0), course)
    return trajectory.at(np.arange(5.0) + 0.01 * given.seed), trajectory.valid, trajectory.centres


def recordings(given: Inputs, out: Path) -> Any:
    one = fusion.open_recording(given.place("wall_0"))
    fusion.convert_recording(one, out / "converted")
    frames = [fusion.Frame(n, float(n), given.depth + np.float32(0.01 * n)) for n in range(3)]
    log = {"timestamp": np.arange(3.0), "turntable_deg": 5.0 * np.arange(3)}
    fusion.write_recording(out / "written", CAMERA, frames, telemetry=log)
    again = fusion.open_recording(out / "written")
    found = fusion.inspect(one)
    stored = one.depth_counts(0), one.color_apart(0), one.without_color()[0].color
    return [*one], stored, again.telemetry_at_frames("turntable_deg"), found, out


def bags(given: Inputs, out: Path) -> Any:
    one = fusion.open_recording(BAGS / ("realsense_2_56.bag" if given.seed == 1 else "realsense_2_59.db3"))
    return [*one], one.depth_counts(0), [one.color_apart(n) for n in range(len(one))]


def sources(given: Inputs, out: Path) -> Any:
    source = fusion.open_source(f"replay:{given.place('wall_0')}@max")
    source.start()
    frames = [replace(frame, host_time=0.0) for frame in source.frames()]
    source.stop()
    with source:
        recorded = fusion.record_source(source, out / "recorded")
    return frames, source.describe(), recorded.frames, [*fusion.open_recording(out / "recorded")]


def meshes(given: Inputs, out: Path) -> Any:
    read = fusion.read_mesh(given.folder / "ball.ply")
    for ending in ("ply", "stl", "obj"):
        fusion.write_mesh(out / f"mesh.{ending}", read)
    turned = fusion.Mesh.from_trimesh(read.to_trimesh()), fusion.Mesh.from_open3d(read.to_open3d())
    settings = fusion.CompareSettings(samples=500, align=False)
    found = fusion.compare(replace(read, vertices=read.vertices * 1.01 + 1e-3), given.ball, settings)
    return read, turned, found, found.to_dict(), out


def alignments(given: Inputs, out: Path) -> Any:
    turned = fusion.Mesh(given.ball.vertices[:, [1, 2, 0]] * 1.01 + 1e-3, given.ball.faces)
    settings = fusion.RepeatSettings(diameter=0.1)
    repeated = fusion.repeat([given.ball, turned], settings)
    said = repeated.mean, repeated.offsets(), repeated.to_dict()
    printed = fusion.print_ready(given.ball, fusion.PrintSettings(triangles=400, smooth=1))
    said = said, printed.mesh, printed.figures(), printed.lines()
    return fusion.compare(turned, given.ball, fusion.CompareSettings(samples=500, scale=True)), said


def sensors(given: Inputs, out: Path) -> Any:
    sensor = fusion.read_sensor(given.folder / "sensor.json")
    fusion.write_sensor(out / "sensor.json", sensor)
    view, rng = fusion.View(CAMERA, given.depth), np.random.default_rng(given.seed)
    effect = sensor.effects[0]
    values = [sensor.predict(given.depth, view), sensor.sample(given.depth, view, None, rng)]
    values += [sensor.sigma(given.depth, None, CAMERA), sensor.weight(given.depth, None, CAMERA)]
    values += [sensor.correct(given.depth, view), sensor.why_not_corrected(effect), sensor.usual(effect)]
    values += [sensor.doubt(given.depth, view), view.cut((slice(2, 9), slice(3, 12))).depth]
    values += [sensor.repeated(given.depth, view), sensor.dropout(given.depth, view), sensor.amplitude(view)]
    others = [sensor.effect(effect.name), sensor.having(effect)]
    return values, others, sensor.true_camera(CAMERA), sensor.seen(view), out


@dataclass(frozen=True)
class BentGlass(fusion.Effect):
    """An effect that no catalogue has."""

    name: ClassVar[str] = "bent_glass"
    variables: ClassVar[tuple[str, ...]] = ("radius",)

    sag: float = fusion.parameter("m", (0, 0.02), "depth that is missing in the middle", "a test", typical=0.004)

    def bias(self, depth: Any, view: fusion.View) -> Any:
        return (-self.sag / (1 + view.radius / 40)).astype(depth.dtype)

    def noise(self, depth: Any, view: fusion.View) -> Any:
        return np.full_like(depth, self.sag / 4)


def effects(given: Inputs, out: Path) -> Any:
    """One of one's own, and those of a sensor."""
    view, depth = fusion.View(CAMERA, given.depth, ir=np.full(CAMERA.shape, 900.0)), given.depth
    sigma, found = np.full_like(depth, 0.001), []
    for one in (BentGlass(sag=0.002 * given.seed), *given.sensor.effects):
        rng = np.random.default_rng(given.seed)
        found.append(
            [one.bias(depth, view), one.change(depth, view), one.corrected(depth, view), one.noise(depth, view)]
        )
        found.append(
            [
                one.dropout(depth, view),
                one.loses_with(depth, view),
                one.lit_from(),
                one.other_zero(view),
                one.spread(sigma, depth, view),
            ]
        )
        found.append([one.light(view.ir, depth, view), one.sampled(depth, view, rng)])
        found.append([one.repeated(depth, sigma, view), one.window(view), one.why_not_corrected()])
        found.append([one.summary(0.001), one.changes("bias")])
    return found


def sensing(given: Inputs, out: Path) -> Any:
    """Perfect depth through a sensor."""
    ideal = fusion.IdealFrame(given.depth, reflectance=0.5)
    one = fusion.sense(ideal, CAMERA, given.sensor, given.seed)
    made = fusion.export_sensor(given.sensor, "isaac", CAMERA)
    beside = fusion.compare_sensors(given.sensor, fusion.Sensor(), CAMERA)
    return (
        one,
        made.parameters,
        made.loss,
        beside,
        fusion.json_values(beside),
        [*fusion.sense_all([ideal, given.depth], CAMERA, given.sensor, given.seed)],
    )


def scenes(given: Inputs, out: Path) -> Any:
    """From a file, with a sensor's noise, indirect light and shadow."""
    scene = fusion.read_scene(given.place("wall_0") / "scene.json")
    made = fusion.simulate(scene, given.sensor, given.seed)
    fusion.write_simulation(out / "made", made)
    return [*made.frames()], made.mesh, made.truth_mesh, made.moment(1), out


def rooms(given: Inputs, out: Path) -> Any:
    """A built-in scene with a moving camera."""
    scene = replace(fusion.built_in("room", {"frames": 2, "sweep_deg": 1 + given.seed}), camera=CAMERA)
    return [*fusion.simulate(scene, fusion.Sensor(), given.seed).frames()]


def volumes(given: Inputs, out: Path) -> Any:
    one, other = fusion.Volume(COARSE), fusion.Volume(COARSE)
    color = np.full((*CAMERA.shape, 3), 100 + given.seed, np.uint8)
    for n in range(3):
        T = np.eye(4)
        T[0, 3] = 0.01 * n
        one.integrate(given.depth, CAMERA, T, np.full(CAMERA.shape, 1.0 + n), color)
    other.integrate(given.depth + np.float32(0.02), replace(CAMERA, distortion=(0.1,)), np.eye(4))
    one.add(other)
    one.save(out / "volume.npz")
    again = fusion.Volume.load(out / "volume.npz")
    seen = [one.raycast(CAMERA, np.eye(4)), again.raycast(CAMERA.halved(), np.eye(4))]
    blocks = one.block_count
    return seen, one.sample(POINTS), one.to_numpy(), again.surface(), blocks, one.blocks.voxels[:blocks]


def reconstructions(given: Inputs, out: Path) -> Any:
    settings = fusion.ReconstructSettings(voxel=0.02, truncation=0.08)
    found = fusion.reconstruct(fusion.open_recording(given.place("room")), settings)
    return found, found.facts, found.judgement


def evaluations(given: Inputs, out: Path) -> Any:
    return fusion.evaluate(given.walls(2), fusion.EvaluationSettings())


def scans(given: Inputs, out: Path) -> Any:
    settings = fusion.ScanSettings(voxel=0.008, truncation=0.03, color=False)
    found = fusion.scan_turntable(fusion.open_recording(given.place("turning")), settings)
    return found, found.facts, found.judgement, found.turntable()


def _nudged(frame: fusion.Frame) -> fusion.Frame:
    """Another measurement of the same: a copy is refused."""
    return replace(frame, depth=frame.depth + np.float32(1e-6))


def merges(given: Inputs, out: Path) -> Any:
    one = fusion.open_pass(given.place("turning"))
    known = fusion.MergeSettings(transforms=np.tile(np.eye(4), (2, 1, 1)), voxel=0.008, truncation=0.03, color=False)
    # the same once more, as if another scan had found it
    mesh = replace(one.mesh, vertices=one.mesh.vertices + 1e-6)
    again = replace(one.recording, path=one.recording.path / "other", load=lambda i: _nudged(one.recording[i]))
    other = replace(one, recording=again, mesh=mesh)
    found = fusion.merge_passes([one, other], known)
    return found.mesh, found.facts, found.judgement, found.merge()


def depths(given: Inputs, out: Path) -> Any:
    return fusion.calibrate_depth(given.walls(3), fusion.DepthSettings())


def noises(given: Inputs, out: Path) -> Any:
    return fusion.calibrate_noise(given.walls(2), fusion.NoiseSettings())


def lenses(given: Inputs, out: Path) -> Any:
    board = fusion.read_board(given.place("board") / "board.json")
    return fusion.calibrate_intrinsics(given.place("board"), board, fusion.LensSettings())


def explanations(given: Inputs, out: Path) -> Any:
    found = fusion.explain(given.walls(1), given.sensor)
    return found, found.sensor, found.mean_sensor, found.compared, fusion.json_values(fusion.verdict_of(found))


# the light ones are made several times each in the quick tests, the heavy ones once
LIGHT: list[Call] = [
    camera, poses, recordings, bags, sources, meshes, sensors, effects, scenes, sensing, rooms, volumes, evaluations,
    reconstructions, noises,
]  # fmt: skip
HEAVY: list[Call] = [alignments, scans, merges, depths, lenses, explanations]
