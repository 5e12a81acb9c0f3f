"""Candidates: every form of every effect that this sensor can have, as columns of what it would change."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.sizes import orthonormal
from fusion.discrepancy.inference.tile_covariance import TileCovariance
from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.forms import Form, forms_of
from fusion.sensor.parameter import parameters
from fusion.sensor.where import Bound

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Candidate:
    """One form of one effect.

    Attributes:
        form: what it is.
        columns: (n, k) change of the tiles per atom, in native units.
        white: (n, k) the same in units of the covariance.
        where: bounds outside which it does not act; empty: everywhere.
    """

    form: Form
    columns: Matrix
    white: Matrix
    where: tuple[Bound, ...] = ()

    @property
    def name(self) -> str:
        return self.form.kind.name

    @cached_property
    def basis(self) -> Matrix:
        """(n, r) orthonormal columns that span the whitened ones."""
        return orthonormal(self.white)


def candidates_of(observations: Observations, covariance: TileCovariance) -> list[Candidate]:
    """All forms that change anything here, whitened in one go."""
    forms, blocks = [], []
    for form in _forms(observations):
        columns = _columns(observations, form)
        if np.any(columns):
            forms.append(form)
            blocks.append(columns)
    if not blocks:
        return []
    white = covariance.whiten(np.concatenate(blocks, axis=1))
    ends = np.cumsum([block.shape[1] for block in blocks])
    parts = np.split(white, ends[:-1], axis=1)
    return [Candidate(form, block, part) for form, block, part in zip(forms, blocks, parts, strict=True)]


def _forms(observations: Observations) -> Iterator[Form]:
    shape = observations.patches[0].view.camera.shape
    principle = observations.sensor.principle
    flight = observations.patches[0].view.time_of_flight
    for kind in EFFECTS:
        if kind.changes("bias") and (not kind.principles or principle in kind.principles):
            yield from (form for form in forms_of(kind, shape) if not (flight and _in_disparity(form)))


def _in_disparity(form: Form) -> bool:
    """True when a form is the alternative in pixels of disparity to one in metres."""
    about = parameters(form.kind)
    used = [about[name] for atom in form.atoms for name in atom]
    return any(p.unit.startswith("px") and any(q.label == p.label for q in about.values() if q is not p) for p in used)


def candidate_of(
    observations: Observations, covariance: TileCovariance, form: Form, where: tuple[Bound, ...] = ()
) -> Candidate:
    """One form, acting everywhere or within bounds."""
    columns = _columns(observations, form, where)
    return Candidate(form, columns, covariance.whiten(columns), where)


def _columns(observations: Observations, form: Form, where: tuple[Bound, ...] = ()) -> Matrix:
    if form.map:
        return _mapped(observations, form, where)
    with np.errstate(all="ignore"):
        instances = [replace(one, where=where) for one in form.instances()]
        return np.nan_to_num(observations.columns(instances), posinf=0, neginf=0)


def _mapped(observations: Observations, form: Form, where: tuple[Bound, ...]) -> Matrix:
    """(n, cells) one column per square of the image: a map that is constant over each."""
    shape = observations.patches[0].view.camera.shape
    side = max(patch.tiles.side for patch in observations.patches)
    across = -(-shape[1] // side)
    cells = -(-shape[0] // side) * across
    whole: Effect = form.kind(**form.fixed, **{form.map: np.full(shape, unit_of(form))}, where=where)
    out = np.zeros((len(observations.residual), cells))
    for rows, patch in observations.rows():
        cell = patch.tiles.cell * patch.tiles.side // side
        out[np.arange(rows.start, rows.stop), cell[:, 0] * across + cell[:, 1]] = patch.column(whole)
    return out


def unit_of(form: Form) -> float:
    """Height of a map's squares: a millimetre, or a hundredth of a pixel."""
    return 1e-3 if parameters(form.kind)[form.map].unit == "m" else 1e-2


def map_of(observations: Observations, form: Form, weights: NDArray[np.float64]) -> Effect:
    """The effect whose map a linear fit found."""
    shape = observations.patches[0].view.camera.shape
    side = max(patch.tiles.side for patch in observations.patches)
    squares = np.asarray(weights).reshape(-(-shape[0] // side), -1) * unit_of(form)
    full = np.repeat(np.repeat(squares, side, axis=0), side, axis=1)[: shape[0], : shape[1]]
    values: dict[str, Any] = {**form.fixed, form.map: full}
    return form.kind(**values)
