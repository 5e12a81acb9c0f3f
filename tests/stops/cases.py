"""Every command that writes, on small inputs: how it is called, and what of it is computed once for all stops."""

import json
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fusion.commands.main import main
from fusion.geometry.camera import Camera
from fusion.mesh.files import write_mesh
from fusion.mesh.mesh import Mesh
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording

CAMERA = Camera(32, 24, fx=30.0, fy=30.0, cx=15.5, cy=11.5, principle="structured_light")


@dataclass(frozen=True)
class Case:
    """One command.

    Attributes:
        name: as it is typed.
        arguments: its arguments, with IN for the folder of the inputs and OUT for the output.
        once: functions that are computed once for all stops: `module:name`, or `module:Class.name`.
        file: the output is a file.
        quick: all its stops take a second.
        every: which stops are tried: each, or each so many (all were tried once).
    """

    name: str
    arguments: str
    once: tuple[str, ...] = ()
    file: bool = False
    quick: bool = False
    every: int = 1

    def run(self, inputs: Path, out: Path) -> int:
        """Run the command in this process; returns its exit status."""
        given = {"IN": str(inputs), "OUT": str(out)}
        words = f"{self.name} {self.arguments} --overwrite --quiet".split()
        return main([re.sub("^(IN|OUT)", lambda found: given[found[0]], word) for word in words])


FRAMES, SIGHT = "fusion.simulation.simulate:Simulation.frames", "fusion.simulation.write:check_sight"
SCAN, COMPARE = "fusion.scan.pipeline:scan_turntable", "fusion.mesh.comparison.compare:compare"
EXPLAIN = ("fusion.discrepancy.explain:explain", "fusion.discrepancy.verdict.verdict:verdict_of")
CASES = [
    Case("convert", "IN/ball.ply OUT", file=True, quick=True),
    Case("convert", "IN/scan OUT"),
    Case("simulate", "IN/wall/scene.json -o OUT --camera IN/other.json", (FRAMES, SIGHT)),
    Case("simulate", "--ideal IN/scan -o OUT --sensor kinect-v1", ("fusion.simulation.ideal.recording:sense_all",)),
    Case("compare", "IN/ball.ply IN/ball.ply -o OUT --no-report", (COMPARE,)),
    Case("repeat", "IN/ball.ply IN/moved.ply -o OUT --no-report", ("fusion.repeatability.repeat:repeat",)),
    Case("evaluate", "IN/walls -o OUT --no-report", ("fusion.evaluation.evaluate:evaluate",)),
    Case(
        "reconstruct",
        "IN/walls -o OUT --poses stated --voxel 0.02 --no-report",
        ("fusion.reconstruction.pipeline:reconstruct",),
    ),
    Case("turntable", "IN/table -o OUT --no-report", (SCAN,)),
    Case("demo", "-o OUT --frames 12 --no-report", (FRAMES, SCAN, COMPARE), every=11),
    Case("explain", "IN/walls --sensor kinect-v1 -o OUT --no-report", EXPLAIN),
    Case(
        "calibrate intrinsics",
        "IN/boards --board IN/boards/board.json -o OUT --no-report",
        ("fusion.calibration.lens.intrinsics:calibrate_intrinsics",),
    ),
    Case("calibrate depth", "IN/walls -o OUT --no-report", ("fusion.calibration.depth.calibration:calibrate_depth",)),
    Case("calibrate noise", "IN/target -o OUT --no-report", ("fusion.calibration.noise.calibration:calibrate_noise",)),
]
TABLE = CASES[7]
# what is recorded for them, of 160 x 120 pixels
RECORDED = {
    "walls": "wall --set distance_m=0.8,1.2,1.6 --set frames=6 --sensor kinect-v1",
    "target": "target --set frames=6 --sensor kinect-v1",
    "boards": "checkerboard --set frames=12",
    "table": "turntable --set frames=24",
}


def make_inputs(folder: Path) -> None:
    """A recording, a simulated wall, a mesh, another camera."""
    ball = _ball()
    wall = np.full(CAMERA.shape, 1.2, np.float32)
    grey = np.full((*CAMERA.shape, 3), 90, np.uint8)
    frames = [Frame(i, i / 30, wall + 0.01 * i, grey) for i in range(2)]
    write_recording(folder / "scan", CAMERA, frames, scene={"mesh": "ball.ply"})
    write_mesh(folder / "scan" / "ball.ply", ball)
    write_mesh(folder / "ball.ply", ball)
    write_mesh(folder / "moved.ply", Mesh(ball.vertices + 0.001, ball.faces))
    _write_camera(folder / "other.json", 32, 24)
    simulated(folder / "wall", "wall --set frames=1")
    shutil.copy(folder / "other.json", folder / "wall" / "camera.json")


def make_slow_inputs(folder: Path) -> None:
    """Recordings for the commands that compute."""
    _write_camera(folder / "camera.json", 160, 120)
    for name, words in RECORDED.items():
        simulated(folder / name, f"{words} --camera {folder / 'camera.json'}")


def simulated(folder: Path, words: str) -> None:
    """A recording of a built-in scene."""
    assert main(["simulate", *words.split(), "-o", str(folder), "--quiet"]) == 0


def _write_camera(path: Path, width: int, height: int) -> None:
    fields = {"width": width, "height": height, "fx": 0.9 * width, "fy": 0.9 * width}
    fields |= {"cx": width / 2 - 0.5, "cy": height / 2 - 0.5, "depth_scale": 5000}
    path.write_text(json.dumps(fields | {"principle": "structured_light"}), encoding="utf-8")


def _ball() -> Mesh:
    corners = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]], float)
    faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    return Mesh(0.1 * corners, np.array(faces, np.int32))
