"""Numbers that a user may give, each with its unit and what is possible: one place for options and settings."""

from dataclasses import dataclass

from fusion.errors import FusionError

Corners = tuple[tuple[float, float, float], tuple[float, float, float]]
FAR = 100.0  # [m] no depth camera sees so far (guess: four times the farthest maker's claim)


@dataclass(frozen=True)
class Quantity:
    """A number that has a meaning."""

    name: str  # for a person; option: where it is given
    option: str
    unit: str  # of `low` and `high`, and of what is checked
    # low, high: what is possible, both included; of the size where either sign is allowed
    low: float
    high: float
    signed: bool = False  # either sign is allowed

    def check(self, value: float | None) -> float | None:
        """The value; None, which means that nothing was given, is good.

        Raises:
            FusionError: it is not finite, or not possible.
        """
        size = 0.0 if value is None else abs(value) if self.signed else value
        if value is not None and not self.low <= size <= self.high:  # never true of what is not finite
            try:
                found = f"{value:g} {self.unit}".rstrip()
            except OverflowError:  # a whole number of hundreds of digits
                found = "a number too large to be shown"
            raise FusionError(f"the {self.name} is not possible", self.option, found, self.possible)
        return value

    @property
    def possible(self) -> str:
        """`0.0001 to 0.1 m`."""
        return f"{self.low:g} to {self.high:g} {self.unit}".rstrip() + (", of either sign" if self.signed else "")


# the finest that a depth camera tells at its nearest, and what holds no shape of a room any more (guesses)
VOXEL = Quantity("voxel size", "--voxel", "m", 1e-4, 0.1)
TRUNCATION = Quantity("truncation", "--truncation", "m", 1e-4, 1.0)
MAX_DEPTH = Quantity("largest depth", "--max-depth", "m", 0.01, FAR)
STEP = Quantity("turn between frames", "--step", "deg", 0.01, 180.0, signed=True)
TEXEL = Quantity("edge of a texel", "--texel", "m", 1e-5, 0.1)
CORNER = Quantity("corner of the box", "--box", "m", 0.0, FAR, signed=True)
REFLECTANCE = Quantity("reflectance of the plate", "--plate-reflectance", "1", 0.0, 1.0)
HOLES = Quantity("perimeter of holes to close", "fill_holes", "m", 0.0, FAR)
MAX_DISTANCE = Quantity("largest distance", "--max-distance", "m", 1e-6, FAR)
DIAMETER = Quantity("diameter of the spheres", "--diameter", "m", 1e-4, FAR)
SPACING = Quantity("distance between the spheres", "--spacing", "m", 1e-4, FAR)
WORKING_DISTANCE = Quantity("working distance", "--distance", "m", 0.01, 1000.0)
DISTANCE_STD = Quantity("standard deviation of the distances", "--distance-std", "m", 0.0, 1.0)
RADIAL_LIMIT = Quantity("radial limit", "--radial-limit", "px", 10.0, 1e5)  # a smaller disc tells no tilt of a wall
FRAMES = Quantity("number of frames", "--frames", "", 12, 10_000)
REPLAY_SPEED = Quantity("speed of the replay", "replay:REC@SPEED", "times", 0.01, 1000.0)
RECORDED = Quantity("number of frames", "--frames", "", 1, 10_000_000)  # 92 hours at 30 a second
LOOKED_AT = Quantity("time to look at a source", "--seconds", "s", 0.1, 86_400.0)
SETTLE = Quantity("time to come to rest", "--settle", "s", 0.0, 600.0)
EVERY = Quantity("frames of which one is recorded", "--every", "", 1, 10_000)
WORKERS = Quantity("number of workers", "--workers", "", 1, 1024)
JOB_SECONDS = Quantity("time limit of a job", "--time-limit", "s", 0.1, 1e7)
JOB_GIGABYTES = Quantity("memory limit of a job", "--memory-limit", "GB", 0.05, 1e5)
MEMORY = Quantity("memory of the process", "--memory", "GB", 0.7, 1e5)
TRIANGLES = Quantity("number of triangles", "--triangles", "", 100, 100_000_000)
SMOOTH = Quantity("number of steps of smoothing", "--smooth", "", 0, 1000)
WALL = Quantity("thinnest wall", "--thin", "m", 1e-5, 1.0)
PORT = Quantity("port", "--port", "", 1, 65535)
FINER = Quantity("passes", "--passes", "", 1, 128)
SEED = Quantity("seed", "--seed", "", 0, 2**63 - 1)


def check_volume(voxel: float | None, truncation: float | None, box: Corners | None) -> None:
    """FusionError when no volume can be made of these; None means that nothing was given, and is good."""
    VOXEL.check(voxel)
    TRUNCATION.check(truncation)
    if voxel is not None and truncation is not None and not voxel <= truncation <= 64 * voxel:
        found, expected = f"{truncation:g} m with voxels of {voxel:g} m", "1 to 64 voxels, best 3 to 5"
        raise FusionError("the truncation does not suit the voxels", "--truncation", found, expected)
    for value in [] if box is None else [*box[0], *box[1]]:
        CORNER.check(value)
    if box is not None and not all(a < b for a, b in zip(*box, strict=True)):
        expected = "X0 < X1, Y0 < Y1, Z0 < Z1 [m], in the first camera's frame (x right, y down, z forward)"
        raise FusionError("the corners enclose no box", "--box", " and ".join(map(_words, box)), expected)


def _words(corner: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{value:g}" for value in corner) + ")"
