"""What a report shows of an explanation: residuals without likely pose errors, and what each claim changes in them."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from fusion.discrepancy.explain import Explanation, variables_of
from fusion.discrepancy.gauge import Gauge, gauge_of
from fusion.discrepancy.observations import Observations, Patch, observe

Vector = NDArray[np.float64]


def cleaned(gauge: Gauge, white: Vector) -> Vector:
    """(n,) native units: what stays of whitened tiles when the likeliest pose and known-parameter errors are undone."""
    inverse = solve_triangular(gauge.root, white, lower=True, trans="T", check_finite=False)
    return np.asarray(gauge.bare @ (gauge.bare.T @ inverse))


@dataclass(frozen=True)
class Compared:
    """The same frames under the model as given and as extended.

    Attributes:
        before, after: tiles under both models.
        gauge: how far tiles may be off for known reasons.
        held_out: True when the frames took no part in any fit.
    """

    before: Observations
    after: Observations
    gauge: Gauge
    held_out: bool

    @cached_property
    def white(self) -> tuple[Vector, Vector]:
        """(n,) residuals before and after as independent numbers of unit spread."""
        return self.gauge.whiten(self.before.residual), self.gauge.whiten(self.after.residual)

    @cached_property
    def clean(self) -> tuple[Vector, Vector]:
        """(n,) residuals before and after in native units, without likely pose errors."""
        return cleaned(self.gauge, self.white[0]), cleaned(self.gauge, self.white[1])

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

    def recordings(self) -> list[tuple[str, float, float]]:
        """Name, chi2 per tile before and after, of each recording."""
        place = self.before.place
        first, second = (white**2 for white in self.white)
        return [
            (name, float(first[place == number].mean()), float(second[place == number].mean()))
            for number, name in recording_names(self.before).items()
        ]


def compared(found: Explanation) -> Compared:
    """Held-out frames under both models; the fitted ones where a recording has none, or where the tiles differ.

    Where the noise itself was wrong, both are measured by the noise that was found.
    """
    held = [look.held for look in found.looks if look.held is not None]
    if {look.place for look in held} == {look.place for look in found.looks}:
        before = observe(found.before.sensor, held).as_loose_as(found.before)
        changed = found.named.steps or found.spread or found.unknown
        after = observe(found.sensor, held).as_loose_as(found.before) if changed else before
        if len(before.residual) == len(after.residual):
            return Compared(before, after, gauge_of(after if found.spread else before), True)
    after = observe(found.mean_sensor, found.looks) if found.unknown else found.named.observations
    if len(after.residual) != len(found.before.residual):
        after = found.named.observations
    return Compared(found.before, after, found.gauge, False)


def recording_names(observations: Observations) -> dict[int, str]:
    """Folder name of each recording by its number."""
    return {patch.look.place: patch.look.stage.recording.path.name for patch in observations.patches}


def depth_per_native(observations: Observations) -> Vector:
    """(n,) metres of depth per native unit."""
    with np.errstate(all="ignore"):
        return np.concatenate([patch.tiles.mean(1.0 / patch.native) for patch in observations.patches])


def painted(patch: Patch, values: Vector) -> NDArray[np.float64]:
    """(h, w) tiles painted into the image, NaN elsewhere."""
    out = np.append(values, np.nan)
    return np.asarray(out[patch.tiles.label])


@dataclass(frozen=True)
class Claim:
    """One entry of the verdict against the fitted frames.

    Attributes:
        number: its place in the verdict.
        entry: of the verdict.
        white: (n,) what it changes, whitened.
        left: (n,) what all claims together leave, whitened.
    """

    number: int
    entry: dict[str, Any]
    white: Vector
    left: Vector

    def mask(self, found: Explanation) -> NDArray[np.uint8]:
        """(h, w) how much each pixel tells for the claim: 255 the most, 0 nothing or never seen."""
        model, rest = cleaned(found.gauge, self.white), cleaned(found.gauge, self.left)
        energy = (
            np.maximum(model * (model + rest), 0)
            / spread(found.gauge) ** 2
            * inside(found, self.entry["where"]["region"])
        )
        return mask_of(found, energy)


def mask_of(found: Explanation, energy: Vector) -> NDArray[np.uint8]:
    """(h, w) mean over the looks of what each tile (n,) tells: 255 the most, 0 nothing or never seen."""
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


def claims_of(found: Explanation, verdict: dict[str, Any]) -> list[Claim]:
    """The established claims of a verdict on the mean depth, with their footprints."""
    beyond = found.beyond.law.footprint if found.beyond is not None and found.unknown else np.zeros_like(found.white)
    left = found.named.white - beyond
    out = []
    for number, entry in enumerate(verdict["missing"]):
        if entry["channel"] != "bias":
            continue
        own = [step.footprint for step in found.named.steps if step.effect.name == entry["effect"]]
        if not own and entry["effect"] != "unknown":
            continue  # steps of the stored depths: tiles do not show them
        white = beyond if entry["effect"] == "unknown" else np.sum([np.zeros_like(left), *own], axis=0)
        out.append(Claim(number, entry, white, left))
    return out


def spread(gauge: Gauge) -> Vector:
    """(n,) standard deviation of the tiles in native units, poses known."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", gauge.bare, gauge.bare)))


def inside(found: Explanation, region: list[dict[str, Any]]) -> NDArray[np.bool_]:
    """(n,) True for tiles in the region of a claim; bounds on variables that tiles do not have are passed over."""
    known = variables_here(found)
    out = np.ones(len(found.white), bool)
    for bound in region:
        values = known.get(bound["variable"])
        if values is not None:
            out &= (values >= bound["low"]) & (values <= bound["high"])
    return out


def variables_here(found: Explanation) -> dict[str, Vector]:
    """What is known of the tiles (n,), in the units of verdicts, range and disparity too."""
    known = dict(variables_of(found.before))
    patches = found.before.patches
    known["range"] = np.concatenate([p.tiles.mean(p.depth * p.view.stretch) for p in patches])
    if not patches[0].view.time_of_flight:
        known["disparity"] = np.concatenate([p.tiles.mean(p.view.focal_baseline / p.depth) for p in patches])
    angle = np.concatenate([np.full(len(p.tiles), p.view.moment.table_angle) for p in patches])
    if np.ptp(angle) > 0:
        known["table_angle"] = angle
    painted_on = [p.tiles.mean(p.view.reflectance) for p in patches if p.view.reflectance is not None]
    if len(painted_on) == len(patches):
        known["reflectance"] = np.concatenate(painted_on)
    return known
