"""Belonging: whether a recording shows the scene that is said to have stood before the camera at all."""

from collections.abc import Sequence

import numpy as np

from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.wrapping import NEAR, WRAPS
from fusion.errors import RecordingError
from fusion.geometry.camera import Principle
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import LIGHT_SPEED, MODULATIONS_HZ, Image

FAR_OFF = 0.25  # of the depth, over half of the image: no effect of a sensor but a lost phase (guess)


def refuse_strangers(blocks: Sequence[FrameBlock], sensor: Sensor) -> None:
    """Another scene, another pose or another unit is told as such: every law would be bent to make up for it.

    Raises:
        RecordingError: half of what is seen lies elsewhere by more than any effect moves it.
    """
    wraps = sensor.effect(WRAPS.name)
    for block in blocks:
        if block.view.depth is None:
            continue
        apart = block.mean - block.view.depth
        if wraps is not None:
            apart = apart - wraps.bias(block.view.depth, block.view)
        seen = np.isfinite(apart)
        if not seen.any() or np.median(np.abs(apart[seen]) / block.view.depth[seen]) < FAR_OFF:
            continue
        off = float(np.median(apart[seen]))
        if sensor.principle == Principle.TIME_OF_FLIGHT and _lost_phase(off, sensor.frequencies or MODULATIONS_HZ):
            continue
        raise RecordingError(
            "recording and scene do not belong together",
            block.stage.recording.path,
            f"depth that is {abs(off):.2f} m {'farther' if off > 0 else 'nearer'} than scene and poses say (median)",
            f"less than {FAR_OFF:.0%} of the depth",
            "check scene.json, the mesh and its unit, the poses (camera to world) and depth_scale, and whether "
            "somebody stands before the camera" + _or_wrapped(block, apart, sensor),
        )


def _or_wrapped(block: FrameBlock, apart: Image, sensor: Sensor) -> str:
    """What to do where ranges are short by the same all over a view, as they are where a phase wraps."""
    if sensor.principle != Principle.TIME_OF_FLIGHT or sensor.effect(WRAPS.name) is not None:
        return ""
    lost = -(apart * block.view.stretch)[np.isfinite(apart)]
    one = float(np.median(lost))
    if one <= 0 or np.median(np.abs(lost - one)) > NEAR:
        return ""
    return (
        f"; where the camera wraps beyond {one:.2f} m, which is the phase of {LIGHT_SPEED / 2e6 / one:.1f} MHz, add "
        f'{{"effect": "{WRAPS.name}", "range": {one:.3f}}} to the effects of the sensor file, or record walls '
        f"on both sides of {one:.2f} m"
    )


def _lost_phase(off: float, frequencies: Sequence[float]) -> bool:
    periods = LIGHT_SPEED / (2 * np.asarray(frequencies))
    return bool((np.abs(off - periods * np.round(off / periods))[np.round(off / periods) != 0] < NEAR).any())
