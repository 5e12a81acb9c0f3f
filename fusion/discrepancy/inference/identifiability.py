"""Identifiability: before any statistics, how much of each effect this data could show, and what looks alike."""

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray
from scipy.special import ndtri

from fusion.discrepancy.decisions import ALIKE, CONFIDENCE, DETECTED, TYPICAL
from fusion.discrepancy.inference.tile_covariance import TileCovariance
from fusion.discrepancy.naming.search.candidates import Candidate, unit_of
from fusion.geometry.camera import Principle
from fusion.sensor.effects import EFFECTS
from fusion.sensor.forms import ANGLES
from fusion.sensor.parameter import parameters

Matrix = NDArray[np.float64]

UNSEEN = 0.01  # share of a footprint that must survive poses and known parameters, or it counts as invisible
ROOMY = 6  # columns more than the other: so many follow anything, and tell nothing about likeness
NOT_SIZES = (*ANGLES, "columns")


class Identifiability(Struct, frozen=True, kw_only=True):
    """What this data could show of one effect in its most visible form."""

    effect: str
    visible_share: Annotated[float, Meta(description="of its footprint's norm, that poses and known numbers leave")]
    parameter: Annotated[str, Meta(description="its size")]
    detectable: Annotated[float | None, Meta(description="smallest size that stands out; null: none does")]
    unit: str
    shape: Annotated[dict[str, float], Meta(description="values of the searched shape at which this holds")]
    looks_like: Annotated[tuple[str, ...], Meta(description="effects with the same footprint in this data")]

    @property
    def visible(self) -> bool:
        """True where a fair share of it survives, or usual sizes stand out all the same, and what stands out is a size
        that sensors have."""
        return self.detectable is not None


def visibilities(candidates: Sequence[Candidate], covariance: TileCovariance) -> list[Identifiability]:
    """One entry per effect of the catalogue that changes anything here, the best visible first."""
    chosen: dict[str, Candidate] = {}
    for candidate in candidates:
        if not candidate.where and np.any(candidate.white):
            best = chosen.get(candidate.name)
            if best is None or _detectable(candidate) < _detectable(best):
                chosen[candidate.name] = candidate
    out = [_visibility(candidate, candidates, covariance) for candidate in chosen.values()]
    return sorted(out, key=lambda entry: -entry.visible_share)


def unseen(found: Sequence[Identifiability], principle: Principle) -> list[str]:
    """Names of effects that such a sensor can have and that the mean depth here cannot show."""
    seen = {entry.effect for entry in found if entry.visible}
    could = [kind for kind in EFFECTS if not kind.principles or principle in kind.principles]
    return [kind.name for kind in could if kind.name not in seen]


def stands_out(candidate: Candidate) -> bool:
    """True when an effect of usual size would stand out by five standard deviations."""
    return bool(_detectable(candidate) < parameters(candidate.form.kind)[_size_name(candidate)].typical)


def _visibility(candidate: Candidate, candidates: Sequence[Candidate], covariance: TileCovariance) -> Identifiability:
    share = covariance.visible(candidate.columns)
    about = parameters(candidate.form.kind)[_size_name(candidate)]
    shape = {name: float(value) for name, value in candidate.form.fixed.items() if np.ndim(value) == 0}
    size = _detectable(candidate)
    # a larger one no sensor can have, or next to none has
    possible = size <= min(max(abs(about.low), abs(about.high)), about.typical * np.exp(ndtri(CONFIDENCE) * TYPICAL))
    visible = possible and (share >= UNSEEN or size < about.typical)
    alike = _alike(candidate, candidates) if visible else ()
    return Identifiability(
        effect=candidate.name,
        visible_share=min(share, 1.0),
        parameter=about.label,
        detectable=size if visible else None,
        unit=about.unit,
        shape=shape,
        looks_like=alike,
    )


def _detectable(candidate: Candidate) -> float:
    """Size at which the footprint is five standard deviations long; of waves the mean over their phases."""
    power = float((candidate.white**2).sum(axis=0).mean())
    if candidate.form.map:
        # a square of the map: a whole map has as many as there are
        return DETECTED * unit_of(candidate.form) / np.sqrt(power) if power > 0 else np.inf
    name = _size_name(candidate)
    size = max(float(np.max(np.abs(np.asarray(atom.get(name, 0.0), float)))) for atom in candidate.form.atoms)
    return DETECTED * size / np.sqrt(power) if power > 0 and size > 0 else np.inf


def _size_name(candidate: Candidate) -> str:
    if candidate.form.map:
        return candidate.form.map
    return next(key for key in candidate.form.atoms[0] if key not in NOT_SIZES)


def _alike(candidate: Candidate, candidates: Sequence[Candidate]) -> tuple[str, ...]:
    """Names with a form that spans this footprint, whatever its phase."""
    length = max(float(np.linalg.norm(candidate.basis)), 1e-300)
    width = candidate.basis.shape[1]
    out: dict[str, None] = {}
    for other in candidates:
        if other.name == candidate.name or other.where or other.basis.shape[1] > width + ROOMY:
            continue
        if float(np.linalg.norm(other.basis.T @ candidate.basis)) > ALIKE * length:
            out[other.name] = None
    return tuple(out)
