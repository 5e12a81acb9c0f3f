"""Along which rays a time-of-flight camera made depth of its ranges: those that are stated, or those that it truly has.

A maker may divide by the rays of the data sheet, or by those that the unit was measured to have in the factory, of
which camera.json need not know. Along the wrong ones a wall is bent by up to a percent of its distance, which no law
over range and image describes: walls left out tell.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fusion.calibration.depth.known import ALONG_STATED, Start
from fusion.calibration.depth.laws.choice import less
from fusion.calibration.depth.laws.selection import JudgedLaw
from fusion.calibration.depth.walls.plane import plane_through
from fusion.calibration.depth.walls.wall import Wall
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View


def along_own(begin: Start) -> Start:
    """The start of a camera that makes depth along its own rays, whatever is stated: nothing is to be undone."""
    notes = tuple(note for note in begin.notes if note != ALONG_STATED)
    return replace(begin, known=begin.uncorrected, ratio=None, notes=notes)


def told_again(wall: Wall, camera: Camera, known: Sensor) -> Wall:
    """The wall as another known sensor has it: its pixels stay, and where a board told its tilts they do too."""
    ir = None if wall.ir is None else np.nan_to_num(wall.ir)
    depth = known.correct(wall.measured, View(camera, wall.measured, ir=ir, moment=wall.moment))
    mask = wall.mask & np.isfinite(depth)
    plane = plane_through(depth, mask, camera)
    if np.isfinite(wall.tilt_std):
        seen = plane.distance / plane.inverse_at(*wall.centre)
        plane = replace(wall.plane, distance=seen * wall.plane.inverse_at(*wall.centre))
    return replace(wall, depth=depth, plane=plane, mask=mask)


class ByWalls(NamedTuple):
    """A law, and the walls that it was judged by."""

    walls: Sequence[Wall]
    law: JudgedLaw


def plainly_less(one: ByWalls, other: ByWalls) -> bool:
    """Whether a law errs less than another on walls left out, of those that both were judged by."""
    errors = [{wall.name: rms for wall, rms in zip(walls, law.rms, strict=True)} for walls, law in (one, other)]
    both = [name for name in errors[0] if name in errors[1]]
    squares = (np.array([every[name] for name in both]) ** 2 for every in errors)
    return len(both) > 1 and less(*squares)


def told(own: float, stated: float) -> tuple[str, str]:
    """The note of a camera that makes depth along its own rays, by the errors on walls left out [m] of both."""
    text = "depth is along the rays of --camera and not along those that the recordings state: a wall left out errs by "
    return "ok", f"{text}{own * 1e3:.2f} mm, along the stated rays by {stated * 1e3:.2f} mm"
