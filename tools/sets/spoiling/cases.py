"""What spoils a scan, and data that are hard: each once, beside the same scan without it."""

from dataclasses import dataclass
from typing import Literal

What = Literal["", "plate light", "flying", "wobble", "warm-up", "moved", "hand", "shiny"]


@dataclass(frozen=True)
class Spoiled:
    """One scan.

    Attributes:
        name: of the case.
        said: regular expression that a warning, a footnote or the refusal must hold; "" where nothing need be said.
        shape, camera: names in THINGS (making.py) and in CAMERAS.
        what: is planted.
        frames, degrees: of the scan; steps are drawn between `uneven` of the mean step and its opposite.
        height: of the object [m].
        log: the table's angles are in the recording.
        plain: the object has no print.
        options: of `fusion turntable`.
    """

    name: str
    said: str = ""
    shape: str = "bricks"
    camera: str = "kinect-v2"
    what: What = ""
    frames: int = 36
    degrees: float = 350.0
    uneven: float = 0.0
    height: float = 0.18
    log: bool = True
    plain: bool = False
    options: tuple[str, ...] = ()


PLATE_LIGHT = r"light|multipath|plate.*bend|bent outwards"
CASES = (
    Spoiled("clean, kinect-v2"),
    Spoiled("clean, kinect-v1", camera="kinect-v1"),
    Spoiled("the plate's light", PLATE_LIGHT, shape="box", what="plate light"),
    Spoiled("the plate's light, told", "taken out", "box", what="plate light", options=("--plate-reflectance", "0.6")),
    Spoiled("flying pixels", what="flying"),
    Spoiled("the table wobbles by 1 deg", r"rock|wobbl", camera="kinect-v1", what="wobble"),
    Spoiled("warm-up by 8 mm", r"warm|drift", what="warm-up"),
    Spoiled("warm-up by 0.4 px", r"warm|drift", camera="kinect-v1", what="warm-up"),
    Spoiled("moved by 5 mm and 3 deg", r"moved|doubled", camera="kinect-v1", what="moved"),
    Spoiled("thin rods and fins", r"thin", shape="thin", camera="kinect-v1"),
    Spoiled("8 views", frames=8, uneven=0.25, log=False, degrees=315, camera="kinect-v1"),
    Spoiled("turned by hand", frames=30, uneven=0.6, log=False, camera="kinect-v1"),
    Spoiled("a hand in the picture", what="hand", log=False, camera="kinect-v1"),
    Spoiled("4 cm", height=0.04, log=False, camera="d435"),
    Spoiled("half a turn", r"turn|side|seen", degrees=180, log=False, camera="kinect-v1"),
    Spoiled("symmetric, plain", r"log|symmetr|round|turn", shape="vase", plain=True, log=False, camera="kinect-v1"),
    Spoiled("shiny", r"shin|gloss|dull|missing|holes|open", what="shiny", log=False, camera="kinect-v1"),
)  # fmt: skip
