"""Edge places: profiles across edges against a model, wherever poses, camera file and outline let the edges stand."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.decisions import DETECTED, FAR, NOISE_ALONE
from fusion.discrepancy.edges.rims import BIN_PX, SIDES, Displaced, Rims
from fusion.discrepancy.inference.camera_file import USUAL
from fusion.discrepancy.observe.frames import filter_window
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

OUTLINE_M = 0.001  # by which a thing is larger than its mesh, where nobody said: sawn and measured by hand (guess)
ROUGH_PX = 0.1  # by which a straight edge is not straight, and rays not those of the file (guess)
LEFT = 0.01  # of a gap: what a model of one side leaves open
OWN = 3  # unknowns of a placement
STEP = 0.1  # of the share of a filter, by which its change is told
TURNS = 12  # steps of Gauss and Newton at most


@dataclass(frozen=True)
class EdgeFit:
    """A model at the likeliest places of all edges."""

    costs: Vector  # (placements,) chi2 of the bins of each and of its own displacement
    common: float  # the same of what all placements share
    moved: Vector  # (k,) displacements, see `EdgePlaces.prior`
    profiles: Matrix  # (3, n) of all bins, see `Rims.profiles`

    @property
    def cost(self) -> float:
        return float(self.costs.sum()) + self.common


@dataclass(frozen=True)
class EdgePlaces:
    """The rims of all placements, and where their edges may stand.

    Args:
        rims: one for each placement.
        factor: by which poses are worse than stated.
    """

    rims: tuple[Rims, ...]
    factor: float = 1.0

    @cached_property
    def place(self) -> NDArray[np.intp]:
        """(n,) number of the placement of each bin."""
        return np.repeat(np.arange(len(self.rims)), [len(rims) for rims in self.rims])

    @cached_property
    def _shapes(self) -> list[str]:
        return sorted({rims.patch.block.stage.shape for rims in self.rims})

    @property
    def _common(self) -> int:
        """Where the unknowns that placements share begin."""
        return OWN * len(self.rims)

    @cached_property
    def _windows(self) -> list[float]:
        """(placements,) [px^2] of the filter that the noise of each shows; one that keeps edges shows less there."""
        return [filter_window(rims.patch.alike) for rims in self.rims]

    def _outline(self, rims: Rims) -> int:
        """Number of the unknown outline of what stands before a camera."""
        return self._common + 2 + self._shapes.index(rims.patch.block.stage.shape)

    @cached_property
    def prior(self) -> Vector:
        """(k,) standard deviations: of u, v [px] and turn [rad] of each placement, of the camera's centre [px], of each
        outline [m], of the share of a filter that edges show.

        What is stated of poses is often too small: their tails are those of a Cauchy distribution.
        """
        out = np.full(self._common + 3 + len(self._shapes), USUAL.cx)
        out[-1] = 1.0
        for k, rims in enumerate(self.rims):
            stage, focal = rims.patch.block.stage, rims.patch.view.camera.fx
            off = focal * np.hypot(stage.sigma_rad, stage.sigma_m / float(np.median(rims.depth)))
            out[OWN * k :][:OWN] = self.factor * np.array([off, off, stage.sigma_rad])
            out[self._outline(rims)] = np.hypot(stage.mesh_sigma_m or 0.0, OUTLINE_M)
        return out

    def moved(self, k: int, at: Vector) -> Displaced:
        """By how much the edges of a placement are displaced, as rims take it."""
        (u, v, roll), (cx, cy) = at[OWN * k :][:OWN].tolist(), at[self._common :][:2].tolist()
        return Displaced(u + cx, v + cy, roll, at[self._outline(self.rims[k])] * self.rims[k].patch.view.camera.fx)

    @cached_property
    def _towards_far(self) -> Matrix:
        """(n, k) displacement of each bin's edge towards the far side [px] by each unknown."""
        out = np.zeros((len(self.place), len(self.prior)))
        for k, rims in enumerate(self.rims):
            rows = self.place == k
            out[rows, OWN * k : OWN * (k + 1)] = rims.normal
            out[rows, self._common : self._common + 2] = rims.normal[:, :2]
            out[rows, self._outline(rims)] = rims.patch.view.camera.fx / rims.depth
        return out

    @cached_property
    def recorded(self) -> Matrix:
        """(3, n)"""
        return np.concatenate([rims.recorded for rims in self.rims], axis=1)

    def agrees(self, fit: EdgeFit) -> bool:
        """True where a model leaves no more than noise in the numbers that a hard edge would not show."""
        return fit.cost <= NOISE_ALONE * self.telling(fit)

    def telling(self, fit: EdgeFit) -> int:
        """Numbers of bins that are not what a hard edge in its stated place would show, recorded or by a model."""
        hard = np.zeros(self.recorded.shape)
        hard[0] = np.concatenate([rims.at for rims in self.rims]) > 0
        off = np.maximum(np.abs(self.recorded - hard), np.abs(fit.profiles - hard))
        return max(1, int(np.count_nonzero(off > LEFT)))

    @cached_property
    def _sigma(self) -> Matrix:
        """(3, n) from what was recorded: the same under every model."""
        slopes = np.concatenate([_slopes(rims, rims.recorded) for rims in self.rims], axis=1)
        # where frames shake, pixels beside an edge are on both sides of it
        wander = np.hypot(ROUGH_PX * slopes, np.concatenate([rims.shaken for rims in self.rims]) * slopes[0])
        doubt = np.concatenate([rims.doubt for rims in self.rims], axis=1)
        return np.asarray(np.sqrt(doubt**2 + wander**2 + LEFT**2))

    def under(self, sensor: Sensor, start: Vector | None = None) -> EdgeFit:
        """The profiles of a model at the likeliest places of the edges; from a start (k,) on, where one is known."""
        best = self._at(sensor, np.zeros(len(self.prior)) if start is None else start)
        for turn in range(TURNS):
            off = self.recorded - best.profiles
            if turn == 0 and start is None:  # how far edges stand apart as a whole, however steep they are
                A, white = self._summed(off[0])
            else:
                A, white = self._straight(sensor, best), np.concatenate(off / self._sigma)
            tried = self._at(sensor, self._solved(A, white + A @ best.moved, best.moved))
            if turn and tried.cost >= best.cost - 0.1:
                break
            best = min(best, tried, key=lambda fit: fit.cost)
        return best

    def tells(self, one: Sensor, other: Sensor) -> bool:
        """True where two models differ by five standard deviations, and by more than what counts as agreement, where no
        displacement makes one of the other."""
        still = np.zeros(len(self.prior))
        fit = self._at(one, still)
        white = np.concatenate((self._at(other, still).profiles - fit.profiles) / self._sigma)
        A = self._straight(one, fit)
        left = white - A @ self._solved(A, white, still)
        return float(left @ left) > max(DETECTED**2, NOISE_ALONE * self.telling(fit))

    @property
    def opposite(self) -> bool:
        """True where edges face both ways in one block."""
        return any(np.any(np.isin((rims.side // 2 + 2) % 4, rims.side // 2)) for rims in self.rims)

    def _straight(self, sensor: Sensor, fit: EdgeFit) -> Matrix:
        """(3 n, k) change of the whitened profiles of a fit by each unknown."""
        ends = np.cumsum([len(rims) for rims in self.rims])[:-1]
        parts = zip(self.rims, np.split(fit.profiles, ends, axis=1), strict=True)
        slopes = np.concatenate([_slopes(rims, own, signed=True) for rims, own in parts], axis=1)
        out = np.concatenate(-(slopes / self._sigma)[:, :, None] * self._towards_far)
        if any(self._windows):
            more = fit.moved + STEP * (np.arange(len(fit.moved)) == len(fit.moved) - 1)
            out[:, -1] = np.concatenate((self._at(sensor, more).profiles - fit.profiles) / self._sigma) / STEP
        return out

    def _summed(self, off: Vector) -> tuple[Matrix, Vector]:
        """The displacement of each side of each block as one equation, to `ROUGH_PX`."""
        number = SIDES * self.place + np.concatenate([rims.side for rims in self.rims])
        used = np.unique(number)
        rows = [self._towards_far[number == k].mean(axis=0) / ROUGH_PX for k in used]
        return np.array(rows), np.array([-BIN_PX * off[number == k].sum() / ROUGH_PX for k in used])

    def _solved(self, A: Matrix, white: Vector, at: Vector) -> Vector:
        own = np.arange(len(at)) < self._common
        for _ in range(6):  # Cauchy tails as weights
            weights = np.where(own, 2.0 / (self.prior**2 + at**2), 1.0 / self.prior**2)
            at = np.linalg.solve(A.T @ A + np.diag(weights), A.T @ white)
        return np.asarray(at)

    def _at(self, sensor: Sensor, at: Vector) -> EdgeFit:
        at = np.append(at[:-1], np.clip(at[-1], 0.0, 1.0))  # a filter makes nothing sharper
        every = zip(self.rims, self._windows, strict=True)
        parts = [rims.predicted(sensor, self.moved(k, at), at[-1] * w) for k, (rims, w) in enumerate(every)]
        profiles = np.concatenate(parts, axis=1)
        size = np.abs(self.recorded - profiles) / self._sigma
        tamed = np.where(size > FAR, 2 * FAR * size - FAR**2, size**2).sum(axis=0)
        squares, own = (at / self.prior) ** 2, self._common
        tails = 2 * np.log1p(squares[:own])
        costs = np.bincount(self.place, weights=tamed)
        return EdgeFit(costs + tails.reshape(-1, OWN).sum(axis=1), float(squares[own:].sum()), at, profiles)


def _slopes(rims: Rims, profiles: Matrix, signed: bool = False) -> Matrix:
    """(3, n) change per pixel of profiles at each bin, between its neighbours; the steeper side where not signed."""
    out = np.zeros(profiles.shape)
    for side in np.unique(rims.side):
        rows = np.flatnonzero(rims.side == side)
        if len(rows) > 1:
            steps = np.diff(profiles[:, rows]) / np.diff(rims.at[rows])
            before, after = np.column_stack([steps[:, :1], steps]), np.column_stack([steps, steps[:, -1:]])
            out[:, rows] = 0.5 * (before + after) if signed else np.maximum(np.abs(before), np.abs(after))
    return out
