"""Compared: the same frames under the model as given and as extended, without likely errors of poses."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from fusion.discrepancy.decisions import NOISE_ALONE
from fusion.discrepancy.inference.tile_covariance import TileCovariance, covariance_of
from fusion.discrepancy.observe.observations import Observations, observe

if TYPE_CHECKING:
    from fusion.discrepancy.explain import Explanation

Vector = NDArray[np.float64]


def cleaned(covariance: TileCovariance, white: Vector) -> Vector:
    """(n,) native units: what stays of whitened tiles when the likeliest pose and known-parameter errors are undone."""
    inverse = solve_triangular(covariance.root, white, lower=True, trans="T", check_finite=False)
    return np.asarray(covariance.free @ inverse)


def beyond_noise(white: Vector, metres: Vector) -> float:
    """Mean square [m^2] of residuals that their noise does not explain; 0 where noise alone is that large."""
    chi2 = float(np.mean(white**2))
    return 0.0 if chi2 <= NOISE_ALONE else float(np.mean(metres**2)) * (1.0 - 1.0 / chi2)


@dataclass(frozen=True)
class Compared:
    """The same frames under the model as given and as extended."""

    # before, after: tiles under both models
    before: Observations
    after: Observations
    covariance: TileCovariance  # how far tiles may be off for known reasons
    held_out: bool  # True when the frames took no part in any fit

    @cached_property
    def white(self) -> tuple[Vector, Vector]:
        """(n,) residuals before and after as independent numbers of unit spread."""
        return self.covariance.whiten(self.before.residual), self.covariance.whiten(self.after.residual)

    @cached_property
    def clean(self) -> tuple[Vector, Vector]:
        """(n,) residuals before and after in native units, without likely pose errors."""
        return cleaned(self.covariance, self.white[0]), cleaned(self.covariance, self.white[1])

    @cached_property
    def metres(self) -> tuple[Vector, Vector]:
        """(n,) the same as depth [m]."""
        per_native = depth_per_native(self.before)
        return self.clean[0] * per_native, self.clean[1] * per_native

    @property
    def changed(self) -> bool:
        """True when the extended model predicts anything else."""
        return not np.array_equal(*self.white)

    @property
    def misfit(self) -> tuple[float, float]:
        """Chi2 per degree of freedom before and after; 1 is noise alone."""
        return float(np.mean(self.white[0] ** 2)), float(np.mean(self.white[1] ** 2))

    @property
    def beyond_noise(self) -> tuple[float, float]:
        """Error of the depth [m], root mean square, before and after, beyond what its noise explains."""
        before, after = (np.sqrt(beyond_noise(*part)) for part in zip(self.white, self.metres, strict=True))
        return float(before), float(after)

    def recordings(self) -> list[tuple[str, float, float]]:
        """Name, chi2 per tile before and after, of each recording."""
        place = self.before.place
        first, second = (white**2 for white in self.white)
        return [
            (name, float(first[place == number].mean()), float(second[place == number].mean()))
            for number, name in recording_names(self.before).items()
        ]


def compared(found: "Explanation") -> Compared:
    """Held-out frames under both models; the fitted ones where a recording has none.

    Where the noise itself was wrong, both are measured by the noise that was found.
    """
    held = found.held.observations
    if held is not None and set(held.place.tolist()) == {block.place for block in found.blocks}:
        changed = found.named.steps or found.spread or found.unknown
        after = held.under(found.channels.sensor) if changed else held
        return Compared(held, after, covariance_of(after) if found.spread else found.held.covariance, True)
    after = observe(found.mean_sensor, found.blocks) if found.unknown else found.named.observations
    if len(after.residual) != len(found.before.residual):
        after = found.named.observations
    return Compared(found.before, after, found.covariance, False)


def recording_names(observations: Observations) -> dict[int, str]:
    """Folder name of each recording by its number; of a placement that was recorded again all of them."""
    names: dict[int, dict[str, None]] = {}
    for patch in observations.patches:
        names.setdefault(patch.block.place, {})[patch.block.stage.recording.path.name] = None
    return {place: " + ".join(own) for place, own in names.items()}


def depth_per_native(observations: Observations) -> Vector:
    """(n,) metres of depth per native unit."""
    with np.errstate(all="ignore"):
        return np.concatenate([patch.tiles.mean(1.0 / patch.native) for patch in observations.patches])
