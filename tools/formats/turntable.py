"""The turn that goes through the formats: an object that the planted scans also use, cast along any camera's rays.

Two cameras: 640 x 480 without a lens, matching; and Azure Kinect's 640 x 576 along rays of the maker's own library.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tools.formats.take import Array, Lens, Take
from tools.sets.planted.devices import Device, Flight, Matching
from tools.sets.planted.shapes import SHAPES
from tools.sets.planted.stage import Pinhole, stage_of, turned

FRAMES, START, STEP_S = 40, 100.0, 0.25
SQUARE = Lens(640, 480, 604.25, 605.5, 322.75, 236.125)  # numbers that single precision holds


@dataclass(frozen=True)
class Seen(Pinhole):
    """A camera that is given by its rays (h, w, 2)."""

    given: Array | None = None

    @cached_property
    def rays(self) -> Array:
        assert self.given is not None
        return np.dstack([self.given, np.ones(self.given.shape[:2])])


def turn(
    lens: Lens, rays: Array | None, seed: int, unit: float, flight: bool, color: tuple[Lens, Array] | None = None
) -> Take:
    """One turn of the object; depth is rounded to `unit` [m] for all formats alike.

    `color`: another camera that takes the colours, and points of the depth camera in its frame, (4, 4).
    """
    rng = np.random.default_rng(seed)
    given = lens.rays() if rays is None else rays
    blind = ~np.isfinite(given[..., 0])
    camera = Seen(lens.width, lens.height, lens.fx, lens.cx, lens.cy, np.nan_to_num(given))
    device: Device = Flight(camera) if flight else Matching(camera)
    item = SHAPES["lumpy"](rng, 0.2)
    item.apply_translation([0.008, -0.005, 0])
    stage = stage_of(rng, camera, item, 0.75)
    backdrop = stage.backdrop(stage.T_world_camera)
    if color is not None:
        apart = replace(stage, camera=Seen(color[0].width, color[0].height, 1, 0, 0, color[0].rays()))
        behind = apart.backdrop(stage.T_world_camera @ np.linalg.inv(color[1]))
    depth, colors = [], []
    for angle in np.linspace(0, 360, FRAMES, endpoint=False) + 0.05 * rng.standard_normal(FRAMES):
        hits, painted = stage.seen(backdrop, turned(angle), turned(angle))
        z = np.where(blind, 0.0, device.depth(hits, 0.0, rng))
        depth.append((np.rint(z / unit) * unit).astype(np.float32))
        colors.append(painted if color is None else apart.seen(behind, turned(angle), turned(angle))[1])
    stamps = START + STEP_S * np.arange(FRAMES)
    return Take(lens, np.stack(depth), stamps, np.stack(colors), lens if color is None else color[0], unit=unit)
