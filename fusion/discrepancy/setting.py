"""Setting: what the recordings say when no law is missing, and poses or targets are only worse than was stated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.camera_file import camera_columns
from fusion.discrepancy.inference.covariance import BENDS_M
from fusion.discrepancy.inference.loose import Loose
from fusion.discrepancy.inference.shapes import mesh_columns, room_columns, shape_columns
from fusion.discrepancy.inference.sizes import independent, sizes_of
from fusion.discrepancy.inference.tile_covariance import TileCovariance, covariance_of, frame_columns, pose_columns
from fusion.discrepancy.observe.observations import Observations

Matrix = NDArray[np.float64]

USUAL_SHAPE_M = 0.001  # of a target of which nobody said how flat it is: plasterboard bows by 1 to 3 mm over 2 m


@dataclass(frozen=True)
class Explained:
    """One way to explain the recordings."""

    # observations, covariance: with the sizes of errors that go with it
    observations: Observations
    covariance: TileCovariance
    cost: float  # -2 log of the marginal likelihood: misfit, volume of what could have been, and price of its laws


def with_laws(observations: Observations, covariance: TileCovariance, gain: float) -> Explained:
    """The recordings as laws explain them: `gain` is their drop of the chi2 less what their freedom costs."""
    return Explained(observations, covariance, _cost(observations, covariance) - gain)


def setting_parts(observations: Observations, covariance: TileCovariance) -> list[Matrix]:
    """What poses, mesh, camera file and shapes may move, each as columns (n, k), whitened; whatever laws there are."""
    poses = np.column_stack(pose_columns(observations)), frame_columns(observations)
    own = *poses, mesh_columns(observations), camera_columns(observations)
    bends = (*shape_columns(observations), *room_columns(observations))
    return [independent(covariance.whiten(part)) if np.any(part) else part for part in (*own, *bends)]


def without_laws(
    observations: Observations, covariance: TileCovariance, parts: Sequence[Matrix] | None = None
) -> Explained:
    """The likeliest setting in which nothing is missing: sizes of errors of poses and of shapes as all tiles say.

    Drifts are no part of it: they are what nobody understands, and would follow any law.

    Args:
        parts: `setting_parts` of them, where they are known already.
    """
    white = covariance.whiten(observations.residual)
    parts = setting_parts(observations, covariance) if parts is None else parts
    # as `_cost` has it: parts in their order
    unusual = [0.0, 0.0, 1.0, 1.0, *[USUAL_SHAPE_M**-2] * (len(parts) - 4)]
    more, frames, mesh, camera, *bent = np.sqrt(sizes_of(white, parts, len(white), unusual).variances).tolist()
    own, common = tuple(bent[: len(BENDS_M)]), tuple(bent[len(BENDS_M) :])
    loose = Loose(pose=float(np.hypot(1.0, more)), shape=own, room=common, mesh=mesh, camera=camera, frames=frames)
    if loose == Loose():
        return Explained(observations, covariance, _cost(observations, covariance))
    looser = replace(observations, loose=observations.loose.with_more(loose))
    wider = covariance_of(looser)
    return Explained(looser, wider, _cost(looser, wider))


def posterior(laws: Explained, setting: Explained) -> float:
    """Probability that laws are missing and not only the setting is worse than stated, at even odds before."""
    return float(1.0 / (1.0 + np.exp(np.clip(0.5 * (laws.cost - setting.cost), -700, 700))))


def _cost(observations: Observations, covariance: TileCovariance) -> float:
    white, loose = covariance.whiten(observations.residual), observations.loose
    # what was stated, and what is usual where nothing was, is likelier: a factor of e, a millimetre, a percent
    before = float(np.log(loose.poses)) ** 2 + (loose.bent / USUAL_SHAPE_M) ** 2 + loose.mesh**2 + loose.camera**2
    return float(white @ white) + 2 * float(np.log(np.diag(covariance.root)).sum()) + before
