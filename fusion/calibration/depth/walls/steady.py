"""Walls that stood still while they were recorded: of others the mean of the frames is no place."""

from fusion.calibration.depth.walls.wall import Wall
from fusion.calibration.shared_noise import SharedNoise
from fusion.errors import FusionError


def that_stood_still(walls: list[Wall]) -> tuple[list[Wall], list[str]]:
    """The walls but those that moved while they were recorded, and a sentence on each of these.

    Raises:
        FusionError: all moved.
    """
    told = [f"{wall.name}: {_motion(wall.shared)}" for wall in walls if wall.shared is not None and wall.moved]
    if told and len(told) == len(walls):
        what = "camera or wall moved in every recording"
        raise FusionError(what, found=told[0], expected="walls that stand still", do="record a still scene")
    left_out = [f"{text}: camera or wall moved, and it is left out; record a still scene" for text in told]
    return [wall for wall in walls if not wall.moved], left_out


def _motion(shared: SharedNoise) -> str:
    return shared.drift_text or shared.text()
