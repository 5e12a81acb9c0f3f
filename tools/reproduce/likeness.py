"""Likeness: does a simulation look like the recordings? A test of two samples, with recordings as replicates."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.scatter import MUCH
from fusion.discrepancy.inference.tile_covariance import TileCovariance
from fusion.discrepancy.naming.evidence import inflation
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.unknown.families import shapes_of
from fusion.discrepancy.unknown.unrestricted import Group, groups_of
from fusion.errors import FusionError

Vector = NDArray[np.float64]

FLIPS = 4000
NEVER = 0.02  # p-value from which on a likeness is refused


@dataclass(frozen=True)
class Likeness:
    """How alike two sets of recordings of the same scenes are."""

    probability: float  # that two sets of one sensor differ as much or more
    chi2_per_dof: float  # of their difference; 1 when both are of one sensor and the covariance is right
    inflation: float  # of the bulk of their difference, over the variance that is known to be there
    differs: tuple[str, ...]  # variables along which they differ most, where they do

    @property
    def alike(self) -> bool:
        return self.probability > NEVER and self.inflation < MUCH


def likeness(recorded: Observations, simulated: Observations, covariance: TileCovariance, seed: int = 0) -> Likeness:
    """Compare recordings with simulations of them, tile by tile, under one sensor model.

    The sign of a difference is turned for whole recordings at once: what all recordings share stands out, the error of
    one pose does not. Smooth functions and waves of all variables are what is looked at.

    Args:
        covariance: of the recordings.
    Raises:
        FusionError: they do not show the same.
    """
    places = [[patch.block.place for patch in one.patches] for one in (recorded, simulated)]
    if places[0] != places[1]:
        raise FusionError(
            "recordings and simulations do not show the same",
            found=f"{len(places[0])} and {len(places[1])} blocks of frames",
            do="simulate the scenes of the recordings with their cameras and poses",
        )
    difference = covariance.whiten(_difference(recorded, simulated)) / np.sqrt(2)
    groups = [*groups_of(recorded, covariance), *_waves(recorded, covariance)]
    signs = _signs(recorded.place, seed)
    power = np.stack([_power(group.basis, difference, recorded.place, signs) for group in groups], axis=1)
    # each group in units of its own usual size, so that none drowns the others; the largest counts
    usual = power[1:].mean(axis=0) + 1e-12
    spread = power[1:].std(axis=0) + 1e-12
    largest = ((power - usual) / spread).max(axis=1)
    probability = float((1 + (largest[1:] >= largest[0] * (1 - 1e-12)).sum()) / len(largest))
    ranked = np.argsort(-(power[0] - usual) / spread)
    chi2 = float(np.mean(difference**2))
    differs = groups[ranked[0]].variables if probability <= NEVER else ()
    return Likeness(probability, chi2, inflation(difference), differs)


def _difference(recorded: Observations, simulated: Observations) -> Vector:
    """(n,) in native units; nothing where only one of both has a tile."""
    out = np.zeros(len(recorded.residual))
    for (rows, own), other in zip(recorded.rows(), simulated.patches, strict=True):
        at = {tuple(cell): k for k, cell in enumerate(other.tiles.cell.tolist())}
        for k, cell in enumerate(own.tiles.cell.tolist()):
            if tuple(cell) in at:
                out[rows.start + k] = own.residual[k] - other.residual[at[tuple(cell)]]
    return out


def _waves(observations: Observations, covariance: TileCovariance) -> list[Group]:
    """What swings along a variable faster than smooth functions of it can: each wave for itself.

    All together could follow any turning of signs, so that nothing would stand out.
    """
    out = []
    for name, values in observations.variables.items():
        waves = [shape.columns(values) for shape in shapes_of(name, values) if "wave" in shape.kind]
        if waves:
            white = covariance.whiten(np.concatenate(waves, axis=1))
            ends = np.cumsum([wave.shape[1] for wave in waves])
            out += [Group((name,), np.linalg.qr(part)[0]) for part in np.split(white, ends[:-1], axis=1)]
    return out


def _signs(place: NDArray[np.intp], seed: int) -> Vector:
    """(flips + 1, recordings) of +-1; the first row turns nothing."""
    n = len(np.unique(place))
    drawn = np.random.default_rng(seed).choice([-1.0, 1.0], (FLIPS, n))
    return np.vstack([np.ones(n), drawn])


def _power(basis: Vector, difference: Vector, place: NDArray[np.intp], signs: Vector) -> Vector:
    """(flips + 1,) squared length of the difference along a group's columns."""
    parts = np.stack([basis[place == g].T @ difference[place == g] for g in np.unique(place)])
    return np.asarray(((signs @ parts) ** 2).sum(axis=1))
