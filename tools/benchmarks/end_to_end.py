"""What a person waits for, as whole processes: a scan of the real box, one of 180 simulated frames, a hand-held one,
an explanation, a comparison of 1 million points, a merge of two passes; each split by stage, beside Open3D's script for
the same work.

    python -m tools.benchmarks.end_to_end [--shared ../shared] [--only box frames tum explain compare merge]
    [--peers] [-o out/end_to_end]

Other programs on the machine lengthen wall time, so beside it stands what two free cores would take: the processor time
of the main thread, and half of what other threads take, which run while it waits. Marked are stages that take more than
a third of the whole. Kernels that are not compiled yet count: run it twice on a new machine.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

ASKED_S = {"box": 6.0, "frames": 15.0, "tum": 15.0, "merge": 30.0}
CLOCKS = (time.perf_counter, time.thread_time, time.process_time)
MEASURE = "--measure"  # this file runs a command in its own process: measure(FILE, ARGUMENTS)
# the same work as scripts of Open3D's users do it: frame to model, and unsigned distances; it has no turntable
OPEN3D_TUM = """
import sys, cv2, numpy as np, open3d as o3d
D = sys.argv[1] + "/"
rows = [l.split() for l in open(D + "depth.txt") if l[0] != "#"]
t, core, cpu = o3d.t.pipelines.slam, o3d.core, o3d.core.Device("CPU:0")
K = core.Tensor([[517.3, 0, 318.6], [0, 516.5, 255.3], [0, 0, 1.0]])
T = core.Tensor(np.eye(4))
model = t.Model(0.01, 16, 20000, T, cpu)
frame, cast = t.Frame(480, 640, K, cpu), t.Frame(480, 640, K, cpu)
black = o3d.t.geometry.Image(np.zeros((480, 640, 3), np.uint8))
for i, row in enumerate(rows):
    frame.set_data_from_image("depth", o3d.t.geometry.Image(cv2.imread(D + row[1], -1)))
    frame.set_data_from_image("color", black)
    if i:
        method = o3d.t.pipelines.odometry.Method.PointToPlane
        T = T @ model.track_frame_to_model(frame, cast, 5000.0, 4.0, 0.07, method).transformation
    model.update_frame_pose(i, T)
    model.integrate(frame, 5000.0, 4.0, 8.0)
    model.synthesize_model_frame(cast, 5000.0, 0.1, 4.0, 8.0, False)
mesh = model.extract_trianglemesh()
o3d.t.io.write_triangle_mesh(sys.argv[2] + ".ply", mesh)
"""
OPEN3D_COMPARE = """
import sys, numpy as np, open3d as o3d
mesh = o3d.t.io.read_triangle_mesh(sys.argv[2])
points = o3d.t.io.read_point_cloud(sys.argv[1])
fit = o3d.pipelines.registration.registration_icp(
    points.to_legacy(), mesh.to_legacy().sample_points_uniformly(500000), 0.01, np.eye(4),
    o3d.pipelines.registration.TransformationEstimationPointToPoint())
points.transform(fit.transformation)
scene = o3d.t.geometry.RaycastingScene()
scene.add_triangles(mesh)
print(np.sqrt(np.mean(scene.compute_distance(points.point.positions).numpy() ** 2)))
"""


def main() -> None:
    """Run what was asked for and print tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=Path(os.environ.get("FUSION_SHARED", "../shared")))
    parser.add_argument("--only", nargs="+", choices=tuple(JOBS), default=list(JOBS), metavar="JOB")
    parser.add_argument("--peers", action="store_true", help="Open3D's scripts too")
    parser.add_argument("-o", "--output", type=Path, default=Path("out/end_to_end"))
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    for job in options.only:
        arguments, script = JOBS[job](options.shared, options.output)
        stages = in_its_own_process(arguments, options.output / job)
        print(table(job, stages), flush=True)
        if options.peers and script:
            begin, before = time.perf_counter(), os.times()
            program, *rest = script
            subprocess.run([sys.executable, "-c", program, *rest], check=True, capture_output=True)
            used = sum(os.times()[2:4]) - sum(before[2:4])
            print(
                f"  Open3D's script{time.perf_counter() - begin:13.1f} s wall, {used:.1f} s of processor\n", flush=True
            )


def box(shared: Path, out: Path) -> tuple[list[str], list[str]]:
    """23 frames of a real cardboard box."""
    return ["turntable", str(shared / "data" / "kleenex_turntable")], []


def frames(shared: Path, out: Path) -> tuple[list[str], list[str]]:
    """180 simulated frames of 640 x 480 px, made once."""
    from fusion.simulation.demo.demo import write_demo_recording

    if not (out / "simulated").exists():
        write_demo_recording(out / "simulated", frames=180)
    return ["turntable", str(out / "simulated" / "recording"), "--sensor", str(out / "simulated" / "sensor.json")], []


def tum(shared: Path, out: Path) -> tuple[list[str], list[str]]:
    """A hand-held camera that turns about itself before a desk."""
    folder = str(shared / "data" / "tum_fr1_rpy")
    return ["reconstruct", folder, "--camera", "tum-fr1"], [OPEN3D_TUM, folder, str(out / "tum_open3d")]


def explain(shared: Path, out: Path) -> tuple[list[str], list[str]]:
    """A case of the open challenges."""
    case = shared / "challenges" / "cases" / "dev_03"
    return ["explain", *map(str, sorted(case.glob("rec_*"))), "--sensor", str(case / "sensor.json")], []


def compare(shared: Path, out: Path) -> tuple[list[str], list[str]]:
    """A cloud of 1 million points, shifted and noisy, and the demo's mesh that it was taken from."""
    import numpy as np

    from fusion.mesh.comparison.surface_samples import sample_surface
    from fusion.mesh.files import write_mesh
    from fusion.mesh.mesh import Mesh
    from fusion.simulation.demo.demo import demo_truth

    cloud, reference = out / "cloud.ply", out / "reference.ply"
    if not cloud.exists():
        truth, rng = demo_truth(), np.random.default_rng(0)
        points = sample_surface(truth, 1_000_000).points
        moved = points + rng.normal(0, 5e-4, points.shape) + np.array([0.002, -0.001, 0.003])
        write_mesh(cloud, Mesh(moved, np.zeros((0, 3), np.int32)))
        write_mesh(reference, truth)
    return ["compare", str(cloud), str(reference)], [OPEN3D_COMPARE, str(cloud), str(reference)]


def merge(shared: Path, out: Path) -> tuple[list[str], list[str]]:
    """Two passes of 90 simulated frames of 640 x 480 px of a box that its print tells apart, scanned once."""
    import numpy as np

    from tools.sets.two_passes.cases import Case
    from tools.sets.two_passes.making import make

    folder = out / "passes"
    if not folder.exists():
        make(Case("box", "kinect-v1"), folder, np.random.default_rng(411), 90)
    scans = [str(folder / f"scan_{number}") for number in (1, 2)]
    for number, scan in enumerate(scans, 1):
        if not Path(scan).exists():
            in_its_own_process(["turntable", str(folder / f"pass_{number}")], Path(scan))
    return ["merge", *scans], []


JOBS: dict[str, Callable[[Path, Path], tuple[list[str], list[str]]]] = {
    "box": box, "frames": frames, "tum": tum, "explain": explain, "compare": compare,
    "merge": merge,
}  # fmt: skip


def in_its_own_process(arguments: list[str], place: Path) -> dict[str, list[float]]:
    """Wall, main thread's and processor time [s] of each stage, and of Python's own start and end."""
    told = place.with_suffix(".json")
    command = [
        sys.executable,
        "-m",
        "tools.benchmarks.end_to_end",
        MEASURE,
        str(told),
        *arguments,
        "-o",
        str(place),
        "--overwrite",
    ]
    begin, before = time.perf_counter(), os.times()
    # as on most machines: Python keeps what it compiled
    keeps = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=keeps)
    wall, used = time.perf_counter() - begin, sum(os.times()[2:4]) - sum(before[2:4])
    if done.returncode:
        raise SystemExit(f"error: fusion {' '.join(arguments)}\n{done.stderr}")
    stages: dict[str, list[float]] = json.loads(told.read_text(encoding="utf-8"))
    rest = used - sum(row[2] for row in stages.values())
    stages["start and end of Python"] = [wall - sum(row[0] for row in stages.values()), rest, rest]
    return stages


def measure(told: Path, arguments: list[str]) -> int:
    """Run a command as the console program does, and write where its time went.

    Nothing here imports NumPy before the command line does, which says first how many threads its products get.
    """
    from fusion.compute.process import tune_process

    tune_process()
    from fusion import progress

    spent: dict[str, list[float]] = {}
    since = [clock() for clock in CLOCKS]

    def counted(name: str) -> None:
        row = spent.setdefault(name, [0.0] * len(CLOCKS))
        for k, clock in enumerate(CLOCKS):
            now = clock()
            row[k], since[k] = row[k] + now - since[k], now

    def count(run: progress._Run) -> None:
        counted(run.open[0].name if run.open else "no stage")

    progress._Run.count = count  # type: ignore[method-assign, assignment]
    from fusion.commands.main import main as fusion

    counted("import of the command line")
    status = fusion(arguments)
    counted("after the last stage")
    told.write_text(json.dumps(spent), encoding="utf-8")
    return status


def free(row: list[float]) -> float:
    """What two free cores would take [s]."""
    _, thread, process = row
    return thread + (process - thread) / 2


def table(job: str, stages: dict[str, list[float]]) -> str:
    """A line a stage, the longest first."""
    total = sum(map(free, stages.values()))
    lines = [f"{job:26} {'two free cores':>14} {'processor':>10} {'wall':>8}"]
    for name, row in sorted(stages.items(), key=lambda item: -free(item[1])):
        mark = "  more than a third" if free(row) > total / 3 else ""
        lines.append(f"  {name:24} {free(row):12.2f} s {row[2]:8.2f} s {row[0]:6.1f} s{mark}")
    asked = f"  asked {ASKED_S[job]:g} s" if job in ASKED_S else ""
    used, wall = sum(row[2] for row in stages.values()), sum(row[0] for row in stages.values())
    return "\n".join([*lines, f"  {'all':24} {total:12.2f} s {used:8.2f} s {wall:6.1f} s{asked}", ""])


if __name__ == "__main__":
    if MEASURE in sys.argv[:2]:
        from fusion.commands.console import leave

        leave(measure(Path(sys.argv[2]), sys.argv[3:]))
    main()
