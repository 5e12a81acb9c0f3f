"""Scatter, drift, poses, shapes: what differs from tile to tile and from recording to recording, and follows no law."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from fusion.discrepancy.decisions import FAR, SURE
from fusion.discrepancy.inference.covariance import BENDS_M
from fusion.discrepancy.inference.loose import Loose
from fusion.discrepancy.inference.shapes import room_columns, shape_columns
from fusion.discrepancy.inference.sizes import sizes_of
from fusion.discrepancy.inference.spreads import Left, Spreads, likeliest
from fusion.discrepancy.inference.tile_covariance import TileCovariance, drift_columns, frame_columns, pose_columns
from fusion.discrepancy.naming.effect_part import FIELD
from fusion.discrepancy.naming.evidence import inflation
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.unknown.unrestricted import Group

Vector = NDArray[np.float64]

MUCH = (
    4.0  # times the covariance's variance: real scenes (second bounces, bent boards, traced labels), not its own faults
)
MOST_COLUMNS = 0.7  # of the tiles: with more, what is left says nothing
FAINT = 1e-8  # of the largest direction: rounding


def loose_of(
    observations: Observations, covariance: TileCovariance, candidates: Sequence[Candidate], groups: Sequence[Group]
) -> Loose:
    """The kinds of errors, told apart by how smooth they are and what they have in common.

    All forms and all smooth functions together are taken out first, so that nothing that could have a name is called
    scatter, drift, or an error of a pose; maps too, where there are recordings enough.
    """
    basis = spanned(candidates, groups)
    if basis is None:
        return Loose()
    white = covariance.whiten(observations.residual)
    white = white - basis @ (basis.T @ white)
    far = FAR * np.sqrt(inflation(white))
    white = np.clip(white, -far, far)
    alone = len(np.unique(observations.place)) < 2  # it may be off as a law has it

    poses, drift = np.column_stack(pose_columns(observations)), drift_columns(observations)
    parts = [poses, drift, frame_columns(observations), *shape_columns(observations), *room_columns(observations)]
    found = sizes_of(white, [beside_laws(covariance, basis, columns) for columns in parts], len(white) - basis.shape[1])
    more, drifting, frames, *bends = np.sqrt(found.variances).tolist()
    own, common = tuple(bends[: len(BENDS_M)]), tuple(bends[len(BENDS_M) :])
    smooth = Loose(0.0, 0.0 if alone else drifting, (), float(np.hypot(1.0, more)), own, common, frames=frames)
    if found.noise < MUCH:
        return smooth
    if more or frames or smooth.bent:
        return replace(smooth, drift=0.0)  # what is rough is looked at beside them
    rough = _spreads(observations, covariance, basis, white)
    return Loose(rough.scatter, 0.0 if alone else rough.drift, rough.uneven)


def _spreads(observations: Observations, covariance: TileCovariance, basis: Vector, white: Vector) -> Spreads:
    """Sizes of errors beside the covariance, and in which recordings, from what no law reaches of residuals (n,)."""
    beside, drift = qr(basis)[0][:, basis.shape[1] :], drift_columns(observations)
    left = Left(beside.T @ white, covariance.pulled(beside), drift, observations.place)
    more = max(float(left.white @ left.white) / len(left.white) - 1.0, 1.0)
    start = float(np.sqrt(more * len(left.white) / (left.rough**2).sum()))
    rough = likeliest(left, Spreads(start))
    if not beside_laws(covariance, basis, drift).any():
        return rough
    both = likeliest(left, replace(rough, drift=rough.scatter))
    return both if rough.cost - both.cost > SURE else rough


def beside_laws(covariance: TileCovariance, basis: Vector, columns: Vector) -> Vector:
    """Columns (n, k) without what laws follow, in units of the noise; 0 where these follow all of them.

    What is left then is rounding, and as a part of the covariance would be blown up to what is seen.
    """
    seen = covariance.whiten(columns)
    left = seen - basis @ (basis.T @ seen)
    return np.asarray(left * (np.linalg.norm(left) > np.sqrt(FAINT) * np.linalg.norm(seen)))


def spanned(candidates: Sequence[Candidate], groups: Sequence[Group]) -> Vector | None:
    """(n, r) orthonormal columns that span all forms and smooth functions; None where too little is left beside."""
    forms, smooth = [c.basis for c in candidates], [g.basis for g in groups]
    # few recordings: maps with a square for nearly every tile would follow anything; few tiles: so do smooth functions
    unmapped = [c.basis for c in candidates if not c.form.map]
    plain = [c.basis for c in candidates if c.columns.shape[1] < FIELD]
    for bases in ([*forms, *smooth], [*unmapped, *smooth], plain):
        whole = _directions(bases)
        if whole.shape[1] <= MOST_COLUMNS * len(whole):
            return whole
    return None


def _directions(bases: Sequence[Vector]) -> Vector:
    """(n, r) orthonormal columns that span all of them."""
    columns = np.concatenate(bases, axis=1)
    power, directions = np.linalg.eigh(columns.T @ columns)
    kept = power > FAINT * power[-1]
    return np.asarray(columns @ (directions[:, kept] / np.sqrt(power[kept])))
