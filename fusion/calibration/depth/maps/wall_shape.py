"""What walls themselves may look like: a bow or things on them stay in place on the wall, and move over the image.

Walls are often one wall, before which the camera went to and fro: those left out have the shape of the others, so that
any law over the image seems to help on them. Its rival is that neighbours show the wall's own shape.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from fusion.calibration.depth.laws.choice import choose, less
from fusion.calibration.depth.laws.information import Information, WallEvidence
from fusion.calibration.depth.laws.selection import JudgedLaw, Problem, judge
from fusion.calibration.depth.maps.surface import filled, smooth_map
from fusion.calibration.depth.walls.wall import Wall
from fusion.geometry.camera import Camera

FEWEST = 4  # walls, of fewer none has neighbours enough
Array = NDArray[np.floating]


@dataclass(frozen=True)
class WallShapes:
    """The shape of each of w walls by what its nearest neighbours, nearer and farther, leave of laws over distance."""

    evidence: list[WallEvidence]
    maps: list[Array]  # per wall (rows, columns) of what is left on it [m]
    beside: JudgedLaw  # the law over distance that suits the walls without them best

    def at(self, which: int, rays: Array, camera: Camera) -> Array:
        """(...) shape [m] of a wall at rays (2, ...)."""
        place, depths = rays * self.evidence[which].wall.depth_there, [e.wall.depth_there for e in self.evidence]
        nearer = [n for n in range(len(depths)) if depths[n] < depths[which]]
        farther = [n for n in range(len(depths)) if depths[n] > depths[which]]
        near = [max(nearer, key=depths.__getitem__)] if nearer else []
        near += [min(farther, key=depths.__getitem__)] if farther else []
        seen = [_read(self.maps[n], place / depths[n], self.evidence[n], camera) for n in near]
        inside, values = (np.array(part) for part in zip(*seen, strict=True))
        weight = np.where(inside.any(axis=0), inside, 1)  # where none saw it, as what they saw next to it
        return np.asarray((values * weight).sum(axis=0) / weight.sum(axis=0))

    def beside_centre(self, which: int, rays: Array, camera: Camera) -> Array:
        """(...) the same less what it is where the wall's distance was measured."""
        return self.at(which, rays, camera) - self.at(which, np.array(self.evidence[which].wall.centre), camera)

    def hold(self, judged: Sequence[JudgedLaw]) -> bool:
        """True where they explain more, in both measures, than any law but a stack; that is a map for each wall."""
        laws = [j for j in judged if j.candidate.surface != "stack"]
        return _less(self.beside, laws[choose(laws)])

    def allow(self, judged: JudgedLaw) -> bool:
        """False of a law that speaks of the image where they explain more: of a stack, where they do as well."""
        if judged.candidate.surface == "stack":
            return _less(judged, self.beside)
        return not judged.candidate.shaped or not _less(self.beside, judged)

    def told(self, camera: Camera) -> str:
        """The sentence about them."""
        off = [self.at(i, _rays(e, camera), camera) for i, e in enumerate(self.evidence)]
        size = 1e3 * float(np.sqrt(np.mean(np.concatenate(off) ** 2)))
        return (
            f"the walls are not flat, by {size:.1f} mm rms: what laws over distance leave stays in its place on the "
            "wall, and moves over the image with the distance; it is taken out as the wall's, and no map is made of "
            "it; to be sure, record another wall too, or this one with the camera turned by a quarter"
        )

    def without(self, camera: Camera) -> list[Wall]:
        """The walls made flat; where their distance was measured they stay."""
        x, y = np.moveaxis(camera.rays().astype(float), -1, 0)
        flat = []
        for which, wall in enumerate(e.wall for e in self.evidence):
            off = self.beside_centre(which, np.array([x, y]), camera)
            flat.append(replace(wall, measured=wall.measured - off, depth=wall.depth - off))
        return flat


def wall_shapes(problem: Problem, judged: Sequence[JudgedLaw], camera: Camera) -> WallShapes | None:
    """The shapes of walls beside the law over distance that suits them best; None of boards, or of too few walls."""
    evidence = problem.evidence
    if any(e.wall.by_board for e in evidence) or len(evidence) < FEWEST:
        return None
    flat = [j for j in judged if not j.candidate.shaped]
    base = flat[choose(flat)]
    maps = [smooth_map(e, one, np.ones(len(one)))[0] for e, one in zip(evidence, base.residual, strict=True)]
    shapes = WallShapes(evidence, [filled(one) for one in maps], base)
    left = [replace(e, rest=e.rest - shapes.beside_centre(i, _rays(e, camera), camera)) for i, e in enumerate(evidence)]
    told = [_told(e, one) for e, one in zip(left, problem.information, strict=True)]
    without = Problem(problem.keys, left, told)
    again = [judge(without, j.candidate) for j in flat if j is base or not j.candidate.waves]
    return replace(shapes, beside=again[choose(again)])


def _less(one: JudgedLaw, other: JudgedLaw) -> bool:
    """Whether one errs less on walls left out, in millimetres and as the tiles weigh them."""
    return less(one.rms**2, other.rms**2) and less(one.chi2, other.chi2)


def _told(e: WallEvidence, before: Information) -> Information:
    """The sums of a wall after its rest has changed."""
    Py = e.projected(e.rest)
    return replace(before, b=e.terms.T @ Py, c=float(e.rest @ Py))


def _rays(e: WallEvidence, camera: Camera) -> Array:
    """(2, t) x / z and y / z of the tiles."""
    rays = camera.rays().astype(float)
    return np.array([e.tiles.mean(rays[..., axis]) for axis in (0, 1)])


def _read(values: Array, rays: Array, e: WallEvidence, camera: Camera) -> tuple[NDArray[np.bool_], Array]:
    """Whether rays (2, ...) are in the image of a map of tiles, and the map there (...), held beyond."""
    u, v = camera.fx * rays[0] + camera.cx, camera.fy * rays[1] + camera.cy
    place = (np.array([v, u]) - (e.tiles.side - 1) / 2) / e.tiles.side
    inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    return inside, np.asarray(map_coordinates(values, place.reshape(2, -1), order=1, mode="nearest")).reshape(u.shape)
