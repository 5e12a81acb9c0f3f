"""What a person should know about a depth calibration, in sentences."""

from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

from fusion.calibration.depth.laws.fitted import Fitted
from fusion.calibration.depth.laws.selection import JudgedLaw
from fusion.calibration.depth.maps.left_out import AxisErrors
from fusion.calibration.depth.visibility import TermVisibility
from fusion.calibration.depth.walls.gloss import FRESNEL
from fusion.calibration.depth.walls.wall import Wall
from fusion.recording.checks.depth_values import implausible
from fusion.recording.readable import unread_text

ORDERED = 4  # walls: fewer go up or down by chance
MOVED = 0.005  # [m] by what is mirrored: plainly more than a square scatters
UNLIKELY = 0.01
MISFIT = 9.0  # weighted square per tile: 0.3 where a law holds, 3.5 for boards whose size is not known
# share by which a depth camera is never wrong all over: uncalibrated ones are by 2 to 4 %; beside walls, by 1 or 2 more
# at one distance than at another
APART, APART_FROM_WALLS = 0.08, 0.05
NO_LAW = "no law helps on walls left out by more than its own uncertainty: none is written"
OF_BOARDS = (
    "a board tells distances in units of its printed squares: squares that are 1 % larger than board.json says look "
    "exactly like depths that are 1 % too large, so measure the printed board with a ruler, or record one wall at a "
    "measured distance too; how flat the board is, these pictures do not tell"
)


class Chosen(NamedTuple):
    """Of all laws as judged: none at all, the one in use, and one that was refused."""

    before: JudgedLaw
    best: JudgedLaw
    left: JudgedLaw | None
    errors: AxisErrors | None  # that are left by the one in use


def notes_on(seen: list[TermVisibility], walls: list[Wall], judged: Chosen, fitted: Fitted) -> list[tuple[str, str]]:
    """("ok", "warning" or "bad", sentence) of each."""
    before, best, left, errors = judged
    notes = []
    hidden: dict[tuple[str, str], list[TermVisibility]] = {}
    for one in seen:
        if not one.seen:
            hidden.setdefault((f"{one.term.effect}.{one.term.parameter}", one.record), []).append(one)
    for (name, record), ones in hidden.items():
        share = max(one.share for one in ones)
        text = f"{name} cannot be seen in these recordings ({100 * share:.1f} % of it survives the walls' free "
        notes.append(("warning", text + f"tilts and distances); to see it, record {record}"))
    if fitted.scatter > 0:
        stated = float(np.median([wall.distance_std for wall in walls])) * 1e3
        text = f"the walls scatter by {fitted.scatter * 1e3:.1f} mm about the law, where distances with a deviation of "
        notes.append(("warning", text + f"{stated:.1f} mm would not; intervals hold that"))
    elif (off := beyond_laser(best, walls)) > 0:
        text = (
            f"on walls left out the law errs by {off * 1e3:.2f} mm on the axis, more than their stated distances do by "
        )
        text += "chance: objects of other distances or brightness will be off by as much"
        notes.append(("warning", f"{text}; {more_walls(walls)}"))
    if any(wall.by_board for wall in walls):
        notes.append(("warning", OF_BOARDS))
        notes += [("bad", text)] if (text := wrong_squares(walls)) else []
    if "gloss" in fitted.numbers.value:
        notes.append(("ok", _of_gloss(fitted)))
    per_tile = float(best.chi2.sum()) / max(sum(len(e.rest) for e in fitted.evidence), 1)
    if per_tile > MISFIT:
        text = f"on walls left out the law errs {np.sqrt(per_tile):.0f} times as much as their tiles scatter: "
        notes.append(("warning", text + "no candidate describes this camera; was it calibrated (--camera)?"))
    notes += [("warning", f"{wall.name}: {unread_text(wall.unread)}") for wall in walls if wall.unread]
    if text := implausible(float(np.median([wall.depth_there for wall in walls]))):
        notes.append(("bad", text))
    if errors is not None and (text := of_one_distance(before, walls, errors)):
        notes.append(("warning", text))
    if best is not before and (text := in_order_of_time(walls)):
        notes.append(("warning", text))
    if len(walls) < 2:
        notes.append(("bad", "one wall only: nothing can be left out to judge a law, so none is written"))
    elif len(walls) < 5:
        text = f"{len(walls)} walls: five or more tell which law over distance holds"
        more = (
            "; this is the simplest that helps on walls left out, and errors of usual size that it leaves out, as far "
        )
        more += "as these walls allow them, are counted in what is left"
        notes.append(("warning", text + more * (errors is not None)))
    if best is before and len(walls) > 1:
        notes.append(("ok", f"{NO_LAW}; if one is expected, {more_walls(walls)}"))
    if left is not None and best is not before:
        text = f"{left.candidate.name} follows the walls' shape closer, but errs by {left.error * 1e3:.2f} mm on walls "
        notes.append(
            ("ok", f"{text}left out, this law by {best.error * 1e3:.2f} mm; to tell more, {more_walls(walls)}")
        )
    return notes


def of_one_distance(before: JudgedLaw, walls: list[Wall], left: AxisErrors) -> str:
    """A sentence where the walls do not tell an error that is the same at all distances from one that grows with it.

    The slope of a straight line through the walls' errors on the axis is known to its standard deviation; where twice
    that is above what a growing error would have, both are possible, and apart elsewhere.
    """
    known = np.isfinite(before.offset) & np.array([np.isfinite(wall.distance_std) for wall in walls])
    places = np.array([wall.depth_there for wall in walls])[known]
    if len(places) < 2:
        return ""
    std = np.sqrt(np.mean([walls[k].distance_std ** 2 for k in np.flatnonzero(known)]))
    error, middle = float(np.mean(before.offset[known])), float(np.mean(places))
    apart = float(np.sqrt(np.sum((places - middle) ** 2)))
    if abs(error) / middle * apart > 2 * std:
        return ""
    text = f"whether the {abs(error) * 1e3:.1f} mm at {middle:.2f} m are the same at all distances or grow with it, "
    text += f"walls between {places.min():.2f} and {places.max():.2f} m do not tell: the correction may leave "
    low, high = (f"{left.std[i] * 1e3:.1f} mm at {left.distance[i]:.2f} m" for i in (0, -1))
    return f"{text}{low}, {high} (one standard deviation); record walls nearer and farther"


def in_order_of_time(walls: list[Wall]) -> str:
    """A sentence where every wall is farther (or nearer) than the one before it, by their stamps; else nothing.

    What the sensor creeps by as it warms up is then a law over distance. Stamps that begin anew in each recording do
    not tell the order.
    """
    time = np.array([wall.moment.time for wall in walls])
    order = np.argsort(time)
    places = np.array([wall.depth_there for wall in walls])[order]
    if len(walls) < ORDERED or not (np.diff(time[order]) > 0).all():
        return ""
    steps = np.diff(places)
    if not ((steps > 0).all() or (steps < 0).all()):
        return ""
    text = "each wall is " + ("farther" if steps[0] > 0 else "nearer") + " than the one recorded before it, and none "
    text += "was recorded again: what the camera drifted by while it warmed up looks like a law over distance; record "
    return text + f"the wall at {places[0]:.2f} m again at the end"


def wrong_squares(walls: list[Wall]) -> str:
    """A sentence where the board's depth is plainly not where its squares say that it stands; else nothing."""
    by_squares = [_seen_over_stated(wall) for wall in walls if wall.by_board]
    measured = [_seen_over_stated(wall) for wall in walls if not wall.by_board and np.isfinite(wall.distance)]
    usual = float(np.median(measured)) if measured else 1.0
    ratio = float(np.median(by_squares)) / usual
    if abs(ratio - 1) < (APART_FROM_WALLS if measured else APART):
        return ""
    who = "walls of measured distance say" if measured else "the depth says"
    return f"{who} that the board is {ratio:.2f} times as far away as its squares say: check square_m (board.json)"


def _seen_over_stated(wall: Wall) -> float:
    return float(wall.plane.distance / wall.plane.inverse_at(*wall.centre)) / wall.distance


def beyond_laser(best: JudgedLaw, walls: list[Wall]) -> float:
    """Error on the axis of walls left out [m] where the stated distances' own would be as large in 1 of 100; else 0.

    What a wall left out is off by holds its own distance's error and those of the fit to the others: as many numbers as
    only distances tell, over as many walls, are lost.
    """
    known = np.isfinite(best.offset) & np.array([np.isfinite(wall.distance_std) for wall in walls])
    stated = np.array([wall.distance_std for wall in walls])[known]
    left = len(stated) - best.candidate.over_distance
    if left < 2:
        return 0.0
    squares = float(np.sum((best.offset[known] / stated) ** 2))
    return best.axis_error if squares > chdtri(len(stated), UNLIKELY) * len(stated) / left else 0.0


def more_walls(walls: list[Wall]) -> str:
    """What to record so that a law, or a richer one, can show itself."""
    places = np.sort([wall.depth_there for wall in walls])
    gap = int(np.argmax(np.diff(places)))
    between = f"most of all between {places[gap]:.2f} and {places[gap + 1]:.2f} m"
    unmeasured = any(not np.isfinite(wall.distance) for wall in walls)
    return f"record more walls, {between}" + (", with their distances measured" if unmeasured else "")


def _of_gloss(fitted: Fitted) -> str:
    share, std = (100 * numbers["gloss"] for numbers in (fitted.numbers.value, fitted.numbers.std))
    column = [term.key for term in fitted.terms].index("gloss")
    moved = np.array([np.abs(e.terms[:, column]).max() * abs(share) / 100 for e in fitted.evidence])
    text = f"the board mirrors {share:.1f} +- {std:.1f} % of the light ({100 * FRESNEL:.0f} % is usual of toner and "
    text += f"varnish): in {np.sum(moved > MOVED)} of {len(moved)} pictures that moves a square by more than "
    text += f"{1e3 * MOVED:.0f} mm, by {1e3 * moved.max():.0f} mm at most. It is the board's: the law is fitted beside "
    text += "it, and sensor.json does not hold it; errors held out are without it. A matt board, or nothing bright "
    return text + "near it, would not need it"
