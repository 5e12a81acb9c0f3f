"""What a report shows of an explanation: what each claim changes in the residuals, and where."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.compared import cleaned
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.inference.tile_covariance import TileCovariance
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.discrepancy.verdict.claim import Claim
from fusion.discrepancy.verdict.content import Verdict
from fusion.sensor.where import BoundFields

Vector = NDArray[np.float64]


def painted(patch: Patch, values: Vector) -> NDArray[np.float64]:
    """(h, w) tiles painted into the image, NaN elsewhere."""
    out = np.append(values, np.nan)
    return np.asarray(out[patch.tiles.label])


@dataclass(frozen=True)
class Footprint:
    """What a claim of the verdict changes in the fitted frames."""

    number: int  # its place in the verdict
    claim: Claim  # of the verdict
    white: Vector  # (n,) what it changes, whitened
    left: Vector  # (n,) what all claims together leave, whitened

    def mask(self, found: Explanation) -> NDArray[np.uint8]:
        """(h, w) how much each pixel tells for the claim: 255 the most, 0 nothing or never seen."""
        model, rest = cleaned(found.covariance, self.white), cleaned(found.covariance, self.left)
        tells = np.maximum(model * (model + rest), 0) / spread(found.covariance) ** 2
        energy = tells * inside(found, self.claim.where.region)
        return mask_of(found, energy)


def mask_of(found: Explanation, energy: Vector) -> NDArray[np.uint8]:
    """(h, w) mean over the blocks of what each tile (n,) tells: 255 the most, 0 nothing or never seen."""
    return painted_mask(found.before, energy)


def painted_mask(observations: Observations, energy: Vector) -> NDArray[np.uint8]:
    """The same for the tiles of any observations."""
    shape = observations.patches[0].view.camera.shape
    total, seen = np.zeros(shape), np.zeros(shape)
    for rows, patch in observations.rows():
        image = painted(patch, np.maximum(energy[rows], 0))
        total += np.nan_to_num(image)
        seen += np.isfinite(image)
    share = total / np.maximum(seen, 1)
    most = float(np.percentile(share[seen > 0], 99)) if seen.any() else 0.0
    return np.asarray(np.clip(share / most, 0, 1) * 255 if most > 0 else share * 0).round().astype(np.uint8)


def footprints_of(found: Explanation, verdict: Verdict) -> list[Footprint]:
    """The established claims of a verdict on the mean depth, with their footprints."""
    left = found.white_left
    out = []
    for number, claim in enumerate(verdict.missing):
        if claim.channel != "bias":
            continue
        own = [step.footprint for step in found.named.steps if step.effect.name == claim.effect]
        if not own and not claim.unknown:
            continue  # steps of the stored depths: tiles do not show them
        white = found.named.white - left if claim.unknown else np.sum([np.zeros_like(left), *own], axis=0)
        out.append(Footprint(number, claim, white, left))
    return out


def spread(covariance: TileCovariance) -> Vector:
    """(n,) standard deviation of the tiles in native units, poses known."""
    return np.asarray(np.sqrt(np.diag(covariance.free)))


def inside(found: Explanation, region: Sequence[BoundFields]) -> NDArray[np.bool_]:
    """(n,) True for tiles in the region of a claim; bounds on variables that tiles do not have are passed over."""
    known = found.before.variables
    out = np.ones(len(found.white), bool)
    for bound in region:
        values = known.get(bound.variable)
        if values is not None:
            out &= (values >= bound.low) & (values <= bound.high)
    return out
