"""What is scanned twice: six objects before three cameras, and pairs of passes that must not be merged."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import trimesh

from tools.sets.fresh.statue import statue
from tools.sets.hard.cameras import HALF, Stereo
from tools.sets.hard.things import lifted, shape
from tools.sets.planted.devices import DEVICES, Device, Flight
from tools.sets.planted.shapes import SHAPES, Rng, joined
from tools.sets.planted.stage import Pinhole

# a Kinect v2's image: 70 deg over 512 columns; its indoor spread is that of tools/sets/planted/devices.py
CAMERAS: dict[str, Device | Stereo] = {
    "kinect-v1": DEVICES["matching"],
    "kinect-v2": Flight(Pinhole(512, 424, 366.0, 255.5, 211.5)),
    "d435": Stereo(HALF, baseline=0.05, noise=0.06, shared=1.5),
}
FAR = {"kinect-v1": 0.65, "kinect-v2": 0.65, "d435": 0.45}  # [m] nearest distance of the object's middle


def mug(rng: Rng, height: float) -> trimesh.Trimesh:
    """A closed cylinder with a handle: only the handle tells how far it is turned."""
    body = lifted(trimesh.creation.cylinder(0.36 * height, height, sections=180))
    ring = trimesh.creation.torus(0.26 * height, 0.06 * height, major_sections=64, minor_sections=24)
    ring.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    ring.apply_translation([0.38 * height, 0, height * rng.uniform(0.4, 0.6)])
    return joined([body, ring])


def box(rng: Rng, height: float) -> trimesh.Trimesh:
    """A closed box: four ways to lie in itself, which only its print tells apart."""
    return shape(rng, "box", height)


OBJECTS: dict[str, Callable[[Rng, float], trimesh.Trimesh]] = {
    "lumpy": SHAPES["lumpy"], "tower": SHAPES["tower"], "bricks": SHAPES["bricks"], "statue": statue, "mug": mug,
    "box": box,
}  # fmt: skip


@dataclass(frozen=True)
class Way:
    """How a pass is recorded where it is not as the first one is.

    Attributes:
        camera: name in CAMERAS.
        degrees: of the table.
        down: by how much the camera looks down [deg]; None draws it.
        farther: than the first pass's camera stands [m].
    """

    camera: str
    degrees: float = 350.0
    down: float | None = None
    farther: float = 0.0


@dataclass(frozen=True)
class Case:
    """Two passes.

    Attributes:
        shape, camera: names in OBJECTS and CAMERAS.
        second: shape of what stands on the plate in the second pass; "" for the same object.
        color: the recordings have colour images.
        degrees: of the table, in each pass that says nothing else.
        other: how the second pass is recorded; None as the first one is.
        refused: why `fusion merge` ought to refuse: different, symmetric or overlap; "" where it ought to merge.
    """

    shape: str
    camera: str
    second: str = ""
    color: bool = True
    degrees: float = 350.0
    other: Way | None = None
    refused: str = ""

    def way(self, number: int) -> Way:
        """How pass 1 or 2 is recorded."""
        return self.other if number == 2 and self.other else Way(self.camera, self.degrees)


CASES = tuple(Case(name, camera) for name in OBJECTS for camera in CAMERAS)
RELATED = (
    Case("lumpy", "kinect-v2", other=Way("kinect-v2", degrees=180)),
    Case("statue", "kinect-v1", degrees=220, other=Way("kinect-v1", degrees=220)),
    Case("tower", "kinect-v1", other=Way("kinect-v2")),
    Case("bricks", "d435", other=Way("kinect-v1")),
    Case("statue", "kinect-v2", other=Way("d435", degrees=270)),
    Case("mug", "kinect-v2", other=Way("kinect-v2", down=50, farther=0.3)),
    Case("bricks", "kinect-v1", other=Way("kinect-v1", down=8)),
    Case("lumpy", "d435", other=Way("d435", degrees=200, down=55, farther=0.2)),
    Case("box", "kinect-v2", other=Way("kinect-v1", down=45)),
)  # partial turns, other heights and distances of the camera, other cameras
REFUSED = (
    Case("lumpy", "kinect-v2", second="statue", refused="different"),
    Case("bricks", "kinect-v1", second="tower", refused="different"),
    Case("box", "kinect-v2", color=False, refused="symmetric"),
    Case("box", "d435", color=False, refused="symmetric"),
    Case("lumpy", "kinect-v2", degrees=50.0, refused="overlap"),
)


def made(name: str, rng: Rng, height: float) -> trimesh.Trimesh:
    """A closed object that stands at z = 0."""
    return OBJECTS[name](rng, height)
