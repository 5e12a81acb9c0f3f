"""Belonging: whether a recording shows the scene that is said to have stood before the camera at all."""

from collections.abc import Sequence

import numpy as np

from fusion.discrepancy.decisions import FAR
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.wrapping import NEAR, WRAPS
from fusion.errors import RecordingError
from fusion.geometry.camera import Principle
from fusion.geometry.robust import robust_std
from fusion.recording.checks.range_or_z import PLAIN, SURE
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import LIGHT_SPEED, MODULATIONS_HZ, Image

FAR_OFF = 0.25  # of the depth, over half of the image: no effect of a sensor but a lost phase (guess)

FEWEST, ROUNDS = 500, 4  # pixels that tell a bow, and how often those far from it are left out


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


def refuse_ranges(blocks: Sequence[FrameBlock]) -> None:
    """Distances along the rays where depth is stated are told as such: no effect bends the scene as they do.

    Raises:
        RecordingError: half of the blocks or more are bent as a range is.
    """
    bows = [bow for block in blocks if (bow := _bow(block)) is not None]
    if not bows or abs(float(np.median(bows)) - 1.0) >= PLAIN:
        return
    raise RecordingError(
        "depth that is the distance along the ray",
        blocks[0].stage.recording.path,
        f"a scene that bows by {float(np.median(bows)):.2f} of what ranges are longer than depth (0: depth, 1: range), "
        f"over {len(bows)} stretches of frames",
        "depth along the optical axis",
        "convert it with z = d / sqrt(1 + x^2 + y^2)",
    )


def _bow(block: FrameBlock) -> float | None:
    """How much of what its ray is longer than 1 a pixel is farther than the scene; None where that is not told."""
    if block.view.depth is None:
        return None
    with np.errstate(all="ignore"):
        off = block.mean / block.view.depth - 1.0
    inside = np.isfinite(off)
    rays = block.view.camera.rays()
    rows = np.dstack([np.ones(off.shape), rays, np.sqrt(1.0 + (rays**2).sum(axis=-1)) - 1.0])
    for _ in range(ROUNDS):
        A, b = rows[inside].astype(float), off[inside]
        if len(b) < FEWEST:
            return None
        inverse = np.linalg.pinv(A.T @ A)  # four numbers from all pixels of an image
        fit = inverse @ (A.T @ b)
        left = off - rows @ fit
        usual = max(robust_std(left[inside]), 1e-9)
        std = usual * np.sqrt(inverse[3, 3])
        inside = np.isfinite(off) & (np.abs(left) < FAR * usual)
    return float(fit[3]) if std < SURE else None


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
