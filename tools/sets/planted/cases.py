"""Six clean scans and twelve with one planted fault each, and what a user must be told about them.

Left out, for the scan itself cannot show them: an error of the depth's scale by some percent (a similarity: the same
pictures of a larger object farther away), a mirrored table direction, wrong time stamps that nothing else refers to.
"""

from dataclasses import dataclass, replace

LEVELS = ("ok", "warning", "bad")


@dataclass(frozen=True)
class Expected:
    """The right answer.

    Attributes:
        about: regular expression that a light on the first page (subject or reason) or the refusal must hold;
            empty for a clean scan.
        least: lowest level of that light where the mesh is right nevertheless; a wrong mesh asks for `bad`.
        refusal: "never", "may" or "must" the run end with status 1 and one line.
        mended: the mesh has to be right, for the fault can be undone.
        camera_kept: the stated camera must not be replaced.
    """

    about: str = ""
    least: str = "ok"
    refusal: str = "never"
    mended: bool = False
    camera_kept: bool = False


@dataclass(frozen=True)
class Case:
    """One scan.

    Attributes:
        planted: the fault in words, empty where there is none.
        camera: "calibrated" (wrong within the stated std) or "nominal" (no std; right unless that is the fault).
        degrees: how far the table turns.
    """

    name: str
    shape: str
    device: str
    log: bool
    camera: str
    planted: str = ""
    expected: Expected = Expected()
    degrees: float = 396.0
    frames: int = 67


CLEAN = (
    Case("clean-1", "lumpy", "matching", True, "calibrated"),
    Case("clean-2", "bricks", "matching-half", False, "calibrated"),
    Case("clean-3", "tower", "flight", True, "nominal"),
    Case("clean-4", "tower", "matching-half", False, "nominal"),
    Case("clean-5", "bricks", "flight", True, "calibrated"),
    Case("clean-6", "lumpy", "flight", False, "nominal", degrees=382, frames=64),
)

_BASE = Case("", "lumpy", "matching-half", True, "calibrated")


def _fault(name: str, planted: str, expected: Expected, **other: object) -> Case:
    return replace(_BASE, name=name, planted=planted, expected=expected, **other)  # type: ignore[arg-type]


FOCAL = r"focal|\bfx\b|intrinsic|\bscale\b"
FAULTS = (
    _fault(
        "focal-nominal", "focal length stated 8 % wrong, no calibration",
        Expected(FOCAL, mended=True), camera="nominal", device="matching",
    ),
    _fault(
        "focal-calibrated", "focal length stated 8 % wrong, with a standard deviation of 0.1 %",
        Expected(FOCAL, "bad", camera_kept=True), shape="tower",
    ),
    _fault(
        "unit", "depth_scale is not that of the files (5, 10 or 0.1 times)",
        Expected(r"unit|depth_scale|millimet|counts", "bad", "may"), camera="nominal", shape="tower",
    ),
    _fault(
        "range", "the files hold the range along the ray, not z",
        Expected(r"\brange\b|along the ray|radial|planar z|not z", refusal="may"), device="flight", shape="lumpy",
    ),
    _fault(
        "slip", "the table slips by 12 deg, the log does not know",
        Expected(r"slip|jump|log\b.*(contradict|disagree|differ|off)"), shape="bricks",
    ),
    _fault(
        "log-wrong", "the log is not in degrees of the table (radians, or a gear of 1.5)",
        Expected(r"\blog\b|turntable_deg|logged|telemetry", refusal="may"), shape="tower", device="flight",
    ),
    _fault(
        "nudged", "the object is moved on the plate by 8 mm and 5 deg midway",
        Expected(
            r"moved|shifted|nudge|slip|rigid|same place|not fit|disagree|do not agree|contradict|double|consistent"
            r"|residual|beyond|closing|closure|gap", "warning", "may",
        ), shape="bricks",
    ),
    _fault(
        "partial", "the table turns by 200 deg only",
        Expected(r"turn|closed|closing|loop|open|cover|not seen|unseen|incomplete|whole", "warning", "may"),
        degrees=200, frames=35, log=False, shape="tower",
    ),
    _fault(
        "black", "40 % of the surface gives no depth",
        Expected(r"open|hole|missing|no depth|without depth|cover|incomplete|fragment|valid|unseen", "warning", "may"),
        shape="lumpy",
    ),
    _fault(
        "bent-depth", "the disparity is off by waves of up to 0.9 px over the image (13 mm at 0.8 m)",
        Expected(r"depth|distort|calibrat|residual|bias", "warning", "may"), camera="nominal", shape="tower",
    ),
    _fault(
        "bumped", "the camera is turned by 2 deg and shifted by 5 mm midway",
        Expected(r"camera.*(move|bump|still|stood|shift|push)|background|tripod|surrounding", refusal="may"),
        shape="lumpy",
    ),
    _fault(
        "still", "nothing turns",
        Expected(r"still|not turn|does not move|nothing (moves|turns)|no motion|same view|all alike", refusal="must"),
        degrees=0, frames=60, log=False, shape="bricks", camera="nominal",
    ),
)  # fmt: skip

CASES = (*CLEAN, *FAULTS)
