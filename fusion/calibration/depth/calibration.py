"""Depth correction from walls: read, judge the candidate laws on walls they have not seen, fit the best."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.known import Start, start
from fusion.calibration.depth.laws.candidates import CandidateLaw, candidates_for, richer, richest, terms_for
from fusion.calibration.depth.laws.choice import choose, promising, refused
from fusion.calibration.depth.laws.fitted import FitSetting, Fitted, finish
from fusion.calibration.depth.laws.harmonics import harmonics
from fusion.calibration.depth.laws.information import evidence_of, information_of
from fusion.calibration.depth.laws.misstated import BETTER, MOST, misstated, stands_wrong, told
from fusion.calibration.depth.laws.placed import placed
from fusion.calibration.depth.laws.selection import JudgedLaw, Problem, fit, judge, judge_all, level
from fusion.calibration.depth.laws.terms import LawTerm, gloss_term
from fusion.calibration.depth.laws.variance import spread_of, with_variance
from fusion.calibration.depth.maps.axis_curve import axis_curve, rivals_of
from fusion.calibration.depth.maps.curve import DepthCurve, span
from fusion.calibration.depth.maps.errors_left import errors_left
from fusion.calibration.depth.maps.left_out import AxisErrors, Laws, axis_errors, straight
from fusion.calibration.depth.maps.pixel_pattern import pixel_pattern
from fusion.calibration.depth.maps.radial_limit import radial_limit, within
from fusion.calibration.depth.maps.surface import LEAST_WALLS, MapStack, judge_surface, native, stack_of
from fusion.calibration.depth.maps.surface_sensor import with_surface
from fusion.calibration.depth.maps.wall_shape import wall_shapes
from fusion.calibration.depth.notes import Chosen, notes_on
from fusion.calibration.depth.rays import ByWalls, along_own, plainly_less, told_again
from fusion.calibration.depth.rays import told as told_of_rays
from fusion.calibration.depth.visibility import TermVisibility, visibilities
from fusion.calibration.depth.walls.board_walls import board_walls
from fusion.calibration.depth.walls.lamp import ir_reference, ir_span, with_lamp
from fusion.calibration.depth.walls.steady import that_stood_still
from fusion.calibration.depth.walls.wall import Wall, check_distances, read_walls
from fusion.calibration.lens.boards.board import Board
from fusion.errors import FusionError
from fusion.geometry.camera import Camera, Principle
from fusion.progress import each, stage
from fusion.quantity import DISTANCE_STD as POSSIBLE_STD
from fusion.quantity import RADIAL_LIMIT
from fusion.recording.looking.copies import refuse_repeated
from fusion.recording.readable import moving_notes
from fusion.recording.recording import Recording
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import MODULATIONS_HZ, stretch

NODE = 0.04  # [m] a fifth of the shortest wave that matters: c / 2f over six at 120 MHz
CHECK_BOARD = "check board.json, and that there are IR images in the depth camera's pixels"
DISTANCE_STD = 0.001  # [m] of a stated distance: what makers of laser distance meters promise


@dataclass(frozen=True)
class DepthSettings:
    """What a depth calibration may be told.

    Attributes:
        camera: calibrated camera; None takes that of the recordings.
        sensor: what is already known of the sensor.
        distance_std: standard deviation of the stated distances [m].
        surface: False leaves maps and stacks out.
        board: each picture that shows it is a wall; recordings without one are walls, as all are when None.
        force: take recordings or models of another camera.
        radial_limit: distance [px] from the principal point beyond which no pixel is used; None uses all.
    """

    camera: Camera | None = None
    sensor: Sensor | None = None
    distance_std: float = DISTANCE_STD
    surface: bool = True
    force: bool = False
    board: Board | None = None
    radial_limit: float | None = None

    def __post_init__(self) -> None:
        POSSIBLE_STD.check(self.distance_std)
        if self.distance_std == 0:  # weights would be without bounds
            raise FusionError("distances are never exact", "--distance-std", 0, "above 0 m")
        RADIAL_LIMIT.check(self.radial_limit)


@dataclass(frozen=True)
class DepthCalibration:
    """A depth law with its evidence; w walls."""

    sensor: Sensor  # the model with the law's effects
    camera: Camera  # that it belongs to
    walls: list[Wall]  # as they were read
    # every candidate with its errors on walls left out; `chosen` is the index of the one in use
    judged: list[JudgedLaw]
    chosen: int
    fitted: Fitted  # the law in the end
    stack: MapStack | None  # what is left per pixel, when the law has a surface
    curve: DepthCurve | None  # bias over distance on the axis; None when no distance is known
    left: AxisErrors | None  # of the corrected depth, within the walls' distances and beyond; None of no law
    # offset, offset_std: (w,) error of each wall on the axis before the correction [m]
    offset: NDArray[np.floating]
    offset_std: NDArray[np.floating]
    visibility: list[TermVisibility]  # which numbers can be seen
    notes: tuple[tuple[str, str], ...]  # ("ok", "warning" or "bad", sentence)
    fitted_from: Sensor  # the model before the law was added

    def __repr__(self) -> str:
        gain = f"{1e3 * self.before.error:.2f} to {1e3 * self.best.error:.2f} mm rms on walls left out"
        return f"<DepthCalibration by {len(self.walls)} walls: {gain};\n {self.sensor!r}>"

    @property
    def before(self) -> JudgedLaw:
        """The errors without any correction."""
        return self.judged[0]

    @property
    def radial_limit(self) -> float | None:
        """Radius [px] beyond which the corrected depth is twice as bad as elsewhere; None when it nowhere is."""
        return radial_limit(self.fitted.evidence, self.best, self.camera)

    @property
    def best(self) -> JudgedLaw:
        """The candidate in use."""
        return self.judged[self.chosen]


def calibrate_depth(recordings: Sequence[Recording], settings: DepthSettings | None = None) -> DepthCalibration:
    """Find the depth error of a camera from recordings of walls.

    Args:
        recordings: one per wall, its distance in `distance_m` of the telemetry where it is known.
        settings: camera, known sensor and so on.
    Raises:
        FusionError: no recording, one that is given twice, recordings of different cameras, no wall in view.

    >>> found = fusion.calibrate_depth([fusion.open_recording(f"wall_{i}") for i in range(5)])
    >>> fusion.write_sensor("sensor.json", found.sensor)
    """
    settings = settings or DepthSettings()
    if not recordings:
        raise FusionError("no recording of a wall", found=0, expected="walls at five or more distances")
    refuse_repeated(recordings)
    check_distances(recordings)
    begin = start(recordings, settings.camera, settings.sensor, settings.force)
    walls = [wall for recording in each(recordings, "reading") for wall in walls_of(recording, begin, settings)]
    if settings.board is None and settings.radial_limit is None:  # each of them leaves walls out as well
        used = sum(wall.frames + len(wall.unread) for wall in walls)
        begin = replace(begin, notes=(*begin.notes, *moving_notes(recordings, used)))
    if settings.board is not None and not any(any(wall.centre) for wall in walls):
        raise FusionError("no picture shows the board", found=f"{len(recordings)} recordings", do=CHECK_BOARD)
    walls, moved = that_stood_still(walls)
    begin = replace(begin, notes=(*begin.notes, *(("warning", text) for text in moved)))
    with stage("fitting"):
        return calibrate_walls(walls, begin, settings.surface)


def calibrate_walls(walls: list[Wall], begin: Start, surface: bool = True) -> DepthCalibration:
    """The same from reduced walls, along the stated rays or, where walls left out say so, the calibrated ones."""
    found = _without_misstated(walls, begin, surface)
    if begin.ratio is None:
        return found
    own = along_own(begin)
    other = _without_misstated([told_again(wall, own.camera, own.known) for wall in walls], own, surface)
    if not plainly_less(ByWalls(other.walls, other.best), ByWalls(found.walls, found.best)):
        return found
    return replace(other, notes=(told_of_rays(other.best.error, found.best.error), *other.notes))


def _without_misstated(walls: list[Wall], begin: Start, surface: bool) -> DepthCalibration:
    """By all walls but those whose stated distance cannot be, which are named."""
    first = _calibrated(walls, begin, surface)
    if first.chosen and any(not np.isfinite(wall.distance) for wall in walls):
        first = _calibrated(placed(walls, first.sensor, begin.camera), begin, surface)
    found = first
    flight, left = begin.known.principle == Principle.TIME_OF_FLIGHT, []
    for _ in range(int(MOST * len(walls))):
        if (which := misstated(found.walls, found.judged, found.chosen, flight)) is None:
            return first
        left.append(found.walls[which])
        found = _calibrated([wall for wall in found.walls if wall is not left[-1]], begin, surface)
        wrong = all(stands_wrong(wall, found.sensor, found.camera, found.best) for wall in left)
        if wrong and found.best.error < BETTER * first.best.error:
            named = [("warning", told(wall, found.sensor, found.camera, len(found.walls))) for wall in left]
            return replace(found, notes=(*named, *found.notes))
    return first


def _calibrated(walls: list[Wall], begin: Start, surface: bool) -> DepthCalibration:
    camera, known = begin.camera, begin.known
    nodes, light = _nodes(walls, begin), ir_reference(walls)
    have = {effect.name for effect in begin.uncorrected.effects}
    periods = harmonics(known.frequencies or MODULATIONS_HZ) if known.principle == Principle.TIME_OF_FLIGHT else ()
    terms = [term for term in terms_for(known.principle, nodes, light, periods) if term.effect not in have]
    terms += [gloss_term()] if any(wall.gloss is not None for wall in walls) else []
    problem, seen = _problem(walls, begin, terms)
    judged = judge_all(problem, _candidates(known.principle, seen, walls, periods))
    if "radius^4" in {v.term.key for v in seen if v.seen}:
        bent = [j.candidate for j in promising(judged) if "radius^2" in j.candidate.keys]
        judged += [judge(problem, richer(candidate)) for candidate in bent]
    shapes = wall_shapes(problem, judged, camera)
    setting = FitSetting(camera, begin.uncorrected, nodes, light or 1000.0, begin.ratio, ir_span(walls))
    units = [native(e, known) for e in problem.evidence]
    if surface and len(walls) >= LEAST_WALLS:
        base = judged[choose(judged)]
        for kind in ("map", "stack"):
            effects = ("tabulated",) if kind == "stack" else ("disparity_distortion", "fixed_pattern")
            # a sensor holds one table: a curve of straight pieces or of the brightness is one already
            if not have & set(effects) and (kind == "map" or not base.candidate.tabulated):
                judged.append(judge_surface(problem, base, units, kind))
    if surface and shapes is not None and shapes.hold(judged):
        begin = replace(begin, notes=(*begin.notes, ("warning", shapes.told(camera))))
        return replace(_calibrated(shapes.without(camera), begin, False), walls=walls)
    chosen = choose(judged, [shapes is None or shapes.allow(j) for j in judged])
    fitted = finish(problem, judged[chosen].law, terms, setting)
    kind = judged[chosen].candidate.surface
    stack = stack_of(fitted.evidence, units, kind) if kind else None
    sensor = fitted.sensor if stack is None else with_surface(fitted.sensor, camera, stack)
    pattern = pixel_pattern(walls, sensor, camera) if surface and chosen > 0 else None
    sensor = _named(sensor if pattern is None else pattern.added(sensor), begin, walls, judged[chosen])
    if any(key.startswith("amplitude") for key in judged[chosen].law.keys):
        sensor = with_lamp(sensor, walls, camera)  # the correction of recordings without IR images asks for it
    rivals = rivals_of(judged, chosen, terms)
    curve, offset, deviation = axis_curve(walls, rivals, fitted, setting)
    left = None
    if chosen > 0:
        unseen = [v.term for v in seen if not v.seen]
        laws = Laws(rivals, fitted, straight(terms, judged[chosen].law.keys))
        left = axis_errors(walls, laws, setting)
        sensor = replace(sensor, depth_errors=errors_left(walls, laws, unseen, stack, setting))
    chosen_of = Chosen(judged[0], judged[chosen], refused(judged, chosen), left)
    notes = (*begin.notes, *notes_on(seen, walls, chosen_of, fitted), *(() if pattern is None else (pattern.note,)))
    evidence = (fitted, stack, curve, left, offset, deviation, seen, notes, begin.uncorrected)
    return DepthCalibration(sensor, camera, walls, judged, chosen, *evidence)


def walls_of(recording: Recording, begin: Start, settings: DepthSettings) -> list[Wall]:
    """Every picture of a recording that shows the board, or the walls that it shows; inside the radial limit."""
    found: list[Wall] = []
    if settings.board is not None:
        found = board_walls(recording, begin.camera, begin.known, settings.board)
    try:
        found = found or read_walls(recording, begin.camera, begin.known, settings.distance_std)
    except FusionError as error:
        if settings.board is None:
            raise
        what = f"no picture shows the board, and as a wall: {error.what}"
        raise FusionError(what, error.where, error.found, error.expected, CHECK_BOARD) from error
    if settings.radial_limit is None:
        return found
    inside = within(begin.camera, settings.radial_limit)
    return [replace(wall, mask=wall.mask & inside) for wall in found if (wall.mask & inside).any()]


def _problem(walls: list[Wall], begin: Start, terms: list[LawTerm]) -> tuple[Problem, list[TermVisibility]]:
    """The linear problems with their variances, and what can be seen."""
    first = [evidence_of(wall, begin.camera, begin.known, terms) for wall in walls]
    keys = tuple(term.key for term in terms)
    rich = richest(candidates_for(begin.known.principle, terms), keys)
    evidence = first
    for _ in range(2):  # the first law weighs the tiles as their frames' noise says, the second as they really scatter
        problem = Problem(keys, evidence, [information_of(e, terms) for e in evidence])
        law = fit(problem, problem.total, rich)
        columns = problem.columns(law.keys)
        rests = [level(e, e.rest - e.terms[:, columns] @ law.numbers) for e in evidence]
        usual = float(np.median([spread_of(r) for r in rests]))
        evidence = [with_variance(e, r, usual) for e, r in zip(first, rests, strict=True)]
    problem = Problem(keys, evidence, [information_of(e, terms) for e in evidence])
    measured = sum(bool(np.isfinite(wall.distance)) for wall in walls)
    return problem, visibilities(terms, problem, measured)


def _candidates(
    principle: Principle, seen: list[TermVisibility], walls: list[Wall], periods: tuple[float, ...]
) -> list[CandidateLaw]:
    """Those made of terms that can be seen, and not richer than the walls: half as many numbers over distance."""
    left = [v.term for v in seen if v.seen]
    enough = max(len(walls) // 2, 1)
    # a wall's range grows to its corners, so one wall tells a piece of the curve
    flight = principle == Principle.TIME_OF_FLIGHT
    return [c for c in candidates_for(principle, left, periods) if flight or c.over_distance <= enough]


def _nodes(walls: list[Wall], begin: Start) -> tuple[float, ...]:
    """Nodes of the curve of straight pieces: one for two walls; for time of flight one every 8 cm of range."""
    low, high = span(walls)
    if begin.known.principle == Principle.TIME_OF_FLIGHT:
        longest = float(np.percentile(stretch(begin.camera), 95))
        count = int(np.clip((high * longest - low) / NODE, 2, 100))
        return tuple(float(r) for r in np.linspace(low, high * longest, count))
    count = int(np.clip(len(walls) // 2, 2, 12))
    return tuple(float(z) for z in np.linspace(low, max(high, low + 0.01), count))


def _named(sensor: Sensor, begin: Start, walls: list[Wall], best: JudgedLaw) -> Sensor:
    """The sensor bound to its camera, with the source of every new effect."""
    low, high = span(walls)
    said = f"fusion calibrate depth: {len(walls)} walls, {low:.2f} to {high:.2f} m, {best.candidate.name}; "
    said += f"error on a wall left out {best.error * 1e3:.2f} mm rms"
    before = {id(e) for e in begin.uncorrected.effects}
    new = {e.name: said for e in sensor.effects if id(e) not in before}
    return replace(sensor, sources=sensor.sources | new, sensor=begin.sensor, serial=begin.serial, left_out=())
