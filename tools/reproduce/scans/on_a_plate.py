"""Things of known volume on a plate: does a scan end where they stand?

    python -m tools.reproduce.scans.on_a_plate -o OUT                  all five, a minute or two each
    python -m tools.reproduce.scans.on_a_plate -o OUT --only slabs     one kind of things

High and low things, sloped sides, noisy and quiet sensors, a plate that is not square to its axis: 24 images of
480 x 360 of 1.1 turns, simulated, scanned with the table's log. Height along the plate's normal, volume as the scan
tells it.
"""

import argparse
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import fusion
from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.mesh.mesh import Mesh
from fusion.simulation.demo.demo import looking_at
from fusion.simulation.scene.course import turning
from fusion.simulation.scene.scene import Part, Scene
from fusion.simulation.scene.shapes import disc, joined
from fusion.simulation.scene.turntable import Turntable

Array = NDArray[np.float64]
CAMERA = Camera(480, 360, 570.0, 570.0, 239.5, 179.5)
FRAMES = 24
LEANS = (1.0, 0.3, 0.0)  # about which a plate is tilted


class Case(NamedTuple):
    """Which things, the sensor that sees them, and the tilt of the plate [deg]."""

    things: str
    sensor: str
    tilt: float


CASES = (
    Case("block, puck, cone, slab", "realsense-d405", 0.0),
    Case("block, puck, cone, slab", "kinect-v1", 0.0),
    Case("slabs", "realsense-d435", 0.0),
    Case("cylinder and block", "realsense-d405", 4.0),
    Case("slabs", "kinect-v1", 3.0),
)


def main() -> None:
    """Make, scan, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--only", choices=sorted({case.things for case in CASES}))
    options = parser.parse_args()
    for number, case in enumerate(CASES):
        if options.only in (None, case.things):
            print(line(case, options.output / f"recording_{number}"), flush=True)


def line(case: Case, folder: Path) -> str:
    """One case, made unless it is there, scanned and compared with what it is."""
    bodies = things(case.things)
    if not folder.exists():
        fusion.write_simulation(folder, fusion.simulate(scene(case, bodies), fusion.read_sensor(case.sensor), seed=7))
    scan = fusion.scan_turntable(fusion.open_recording(folder))
    volume, high = sum(body.volume for body in bodies), max(body.bounds[1][2] for body in bodies)
    found, facts = scan.facts.shape.volume, scan.facts
    up = pose.about_axis((0, 0, 0), LEANS, np.deg2rad(case.tilt))[:3, 2]
    turned = scan.trajectory.poses[0][:3, :3] @ T_world_camera()[:3, :3].T  # object from world, at the first frame
    height = float(np.ptp(scan.mesh.vertices @ (turned @ up)))
    assert facts.table is not None
    told = "none" if found is None else f"{found * 1e6:.0f}"
    return (
        f"{case.things:<24} {case.sensor:<15} tilt {case.tilt:g} deg: hidden {facts.table.hidden * 1e3:.1f} mm, "
        f"volume {told} of {volume * 1e6:.0f} cm3, "
        f"height {height * 1e3:.1f} of {high * 1e3:.0f} mm, {scan.judgement.worth.line()}"
    )


def T_world_camera() -> Array:
    """(4, 4) of the camera that stands still."""
    return looking_at(np.array([0.58, 0.0, 0.36]), np.array([0.0, 0.0, 0.04]))


def scene(case: Case, bodies: list[Any]) -> Scene:
    """The things on their plate."""
    lean = pose.about_axis((0, 0, 0), LEANS, np.deg2rad(case.tilt))
    body = joined([_mesh(body, number) for number, body in enumerate(bodies)])
    parts = (body, disc(0.16, -0.012, 0.0, lambda points: _print(points, 9)))
    stood = [Mesh(pose.transform(lean, m.vertices), m.faces, colors=m.colors) for m in parts]
    table = Turntable(degrees_per_frame=1.1 * 360 / FRAMES, frames=FRAMES)
    return Scene(
        name=case.things,
        parts=(Part(stood[0], turns=True), Part(stood[1], turns=True, scanned=False)),
        course=turning(table, T_world_camera(), start_s=600),
        camera=CAMERA,
        ambient_lux=100.0,
    )


def things(name: str) -> list[Any]:
    """Closed bodies on z = 0 [m]."""
    from trimesh import creation, transformations

    def at(made: Any, x: float, y: float, turn: float = 0.0) -> Any:
        made.apply_transform(transformations.rotation_matrix(turn, [0, 0, 1]))
        made.apply_translation([x, y, -made.bounds[0][2]])
        return made

    if name == "slabs":
        slabs = [
            at(creation.box((0.13, 0.09, 0.015)), 0, 0, 0.5),
            at(creation.box((0.04, 0.03, 0.01)), -0.08, -0.04, 0.2),
        ]
        return [*slabs, at(creation.cylinder(0.02, 0.022, sections=90), 0.09, 0.03)]
    if name == "cylinder and block":
        return [
            at(creation.cylinder(0.045, 0.16, sections=90), 0.02, 0.0),
            at(creation.box((0.06, 0.04, 0.12)), -0.06, 0.03, 0.3),
        ]
    return [
        at(creation.box((0.07, 0.05, 0.09)), -0.02, 0.02, 0.4),
        at(creation.cylinder(0.028, 0.012, sections=90), 0.06, -0.03),
        at(creation.cone(0.03, 0.06, sections=90), 0.03, 0.07),
        at(creation.box((0.05, 0.03, 0.006)), -0.05, -0.06, 0.9),
    ]


def _mesh(body: Any, number: int) -> Mesh:
    while len(body.vertices) < 6000:
        body = body.subdivide()
    vertices = np.array(body.vertices)
    return Mesh(vertices, np.asarray(body.faces, np.int32), colors=_print(vertices, number).astype(np.uint8))


def _print(points: Array, seed: int) -> Array:
    """(n, 3) speckle of 8 mm."""
    from scipy.ndimage import map_coordinates

    field = np.random.default_rng(seed).random((40, 40, 40))
    grey = map_coordinates(field, (np.asarray(points) / 0.008 + 3.1 * seed).T, order=1, mode="grid-wrap")
    return np.asarray(np.clip(60 + 190 * grey, 0, 255)[:, None] * [1.0, 0.9, 0.8])


if __name__ == "__main__":
    main()
