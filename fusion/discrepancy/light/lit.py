"""Lit tiles: how bright those of each recording are against the model, and what beside the sensor may be the cause."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.sizes import orthonormal, sizes_of
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.geometry.pose import transform
from fusion.sensor.effect import Effect
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

LEAST_TILES = 30  # of a recording: twice the numbers of a field of its own
LEAST_SEEN = 0.5  # of a tile's pixels, that must be lit
ALIKE = 0.05  # of a reflectance, as a logarithm: what differs by less is one material
BRIGHTEST = 65535  # [count] of a 16-bit image: as bright or brighter
LOBES = np.deg2rad(np.arange(0.0, 81.0, 5.0))  # angles of incidence, between which light falls evenly: gloss is wider
TINY = 1e-10  # variance of a logarithm: no amplitude is known better
SMOOTH, ROUGH = 2, 4  # degrees of fields over an image


@dataclass(frozen=True)
class LitTiles:
    """Tiles (n,) of all recordings with an amplitude image, one look at each.

    Attributes:
        patches: one per recording.
        tiles: (n,) which of each patch's tiles these are, one after the other.
        place: (n,) recording.
        excess: (n,) logarithm of measured over predicted amplitude.
        causes: (n, k) what it may be without the sensor: each material's brightness in each recording; how light falls
            with the angle of incidence and the distance, how counts grow with light; print on a wall that all saw.
        fields: (n, m) what a lamp or lens may do: smooth over the image, the same in all recordings.
        own: columns that each recording has for itself, smooth ones and rougher ones: what nobody said of its target.
    """

    patches: tuple[Patch, ...]
    tiles: tuple[NDArray[np.intp], ...]
    place: NDArray[np.intp]
    excess: Vector
    causes: Matrix
    fields: Matrix
    own: tuple[Matrix, ...]

    def change(self, sensor: Sensor, effect: Effect) -> Vector:
        """(n,) of the logarithm of the amplitude, by an effect that the sensor lacks."""
        return self._logarithms(sensor.having(effect)) - self._logarithms(sensor)

    def _logarithms(self, sensor: Sensor) -> Vector:
        found = []
        for patch, some in zip(self.patches, self.tiles, strict=True):
            found.append(np.log(np.maximum(patch.tiles.mean(_predicted(patch, sensor))[some], 1e-9)))
        return np.concatenate(found)

    def whitened(self, columns: Matrix) -> Matrix:
        """(n, k) columns in units of what a tile may be off, with the sizes of that as they are found here."""
        out = np.array(columns, float)
        for rows, factor in self._factors():
            out[rows] = np.linalg.solve(factor, columns[rows])
        return out

    def _factors(self) -> Iterator[tuple[NDArray[np.intp], Matrix]]:
        """Rows of each recording, and the root of its covariance."""
        known = orthonormal(np.column_stack([self.causes, self.fields]))

        def beyond(columns: Matrix) -> Matrix:
            return np.asarray(columns - known @ (known.T @ columns))

        free = len(self.excess) - known.shape[1]
        sizes = sizes_of(beyond(self.excess), [beyond(part) for part in self.own], free)
        shares = (*sizes.variances, *[0.0] * (len(self.own) - len(sizes.variances)))
        for one in np.unique(self.place):
            rows = np.asarray(np.flatnonzero(self.place == one))
            whole = max(sizes.noise, TINY) * np.eye(len(rows))
            for size, part in zip(shares, self.own, strict=True):
                whole += size * part[rows] @ part[rows].T
            yield rows, np.asarray(np.linalg.cholesky(whole), float)


def lit_of(observations: Observations) -> LitTiles | None:
    """The tiles whose amplitude is known; None where no recording has enough of them."""
    first: dict[int, Patch] = {}
    for patch in observations.patches:
        view = patch.block.view
        told = view.ir is not None and view.reflectance is not None and view.incidence is not None
        if told and view.time_of_flight and patch.block.given is None:
            first.setdefault(patch.block.place, patch)
    parts = [(patch, *_bright(patch, observations.sensor)) for patch in first.values()]
    parts = [part for part in parts if len(part[1]) >= LEAST_TILES]
    if not parts:
        return None
    patches, tiles, excess = zip(*parts, strict=True)
    place = np.repeat(np.arange(len(parts)), [len(some) for some in tiles])

    def means(of: Sequence[Image]) -> Vector:
        return np.concatenate([p.tiles.mean(x)[some] for p, x, some in zip(patches, of, tiles, strict=True)])

    x, y = (means([p.view.camera.rays()[..., k] for p in patches]) for k in (0, 1))
    smooth = _powers((x, y), range(1, SMOOTH + 1))
    rough = _powers((x, y), range(SMOOTH + 1, ROUGH + 1))
    single = place[:, None] == np.arange(len(parts))
    own = tuple(np.concatenate([part * one[:, None] for one in single.T], axis=1) for part in (smooth, rough))
    causes = np.column_stack([
        _levels(place, means([np.nan_to_num(p.view.reflectance) for p in patches])),
        _hats(means([np.nan_to_num(p.view.incidence) for p in patches])),
        _powers((np.log(means([p.depth * p.view.stretch for p in patches])),), range(1, 3)),
        _powers((np.log(means([_predicted(p, observations.sensor) for p in patches])),), range(1, 3)),
        _powers([means([_in_the_world(p)[..., k] for p in patches]) for k in range(3)], range(1, 3)),
    ])  # fmt: skip
    fields = np.column_stack([smooth, rough])
    if len(place) < 2 * (causes.shape[1] + fields.shape[1]):
        return None  # the causes would take all that is seen
    return LitTiles(patches, tiles, place, np.concatenate(excess), causes, fields, own)


def _in_the_world(patch: Patch) -> Image:
    """(h, w, 3) [m] of what is seen."""
    return transform(patch.block.T_world_camera, patch.view.camera.points(patch.depth).astype(float))


def _predicted(patch: Patch, sensor: Sensor) -> Image:
    """(h, w) amplitude; 0 where none is."""
    light = sensor.amplitude(sensor.seen(replace(patch.block.view, ir=None)))
    assert light is not None
    return np.maximum(np.nan_to_num(light), 0.0)


def _bright(patch: Patch, sensor: Sensor) -> tuple[NDArray[np.intp], Vector]:
    """Tiles of a patch that are lit, and the logarithm of measured over predicted amplitude of each."""
    light, measured = _predicted(patch, sensor), np.asarray(patch.block.view.ir, float)
    seen = (measured > 0) & (measured < BRIGHTEST) & (light > 0)
    share = patch.tiles.mean(seen.astype(float))
    some = np.flatnonzero(share > LEAST_SEEN)
    ratio = patch.tiles.mean(np.where(seen, measured / np.where(seen, light, 1.0), 0.0))
    return some, np.log(ratio[some] / share[some])


def _levels(place: NDArray[np.intp], reflectance: Vector) -> Matrix:
    """(n, k) 1 where a tile is of one material in one recording."""
    material = np.round(np.log(np.maximum(reflectance, 1e-3)) / ALIKE)
    group = np.unique(np.column_stack([place, material]), axis=0, return_inverse=True)[1].ravel()
    return np.asarray(group[:, None] == np.arange(group.max() + 1), float)


def _hats(incidence: Vector) -> Matrix:
    """(n, k) of straight lines between `LOBES`."""
    return np.column_stack([np.interp(incidence, LOBES, row) for row in np.eye(len(LOBES))])


def _powers(values: Sequence[Vector], degrees: range) -> Matrix:
    """(n, k) products of so many of the values, each about its mean and of length one."""
    scaled = [(v - v.mean()) / max(float(np.std(v)), 1e-9) for v in values]
    return np.column_stack([
        np.prod([scaled[k] for k in some], axis=0)
        for degree in degrees for some in combinations_with_replacement(range(len(scaled)), degree)
    ])  # fmt: skip
