"""What two surfaces say of each other by their relief, and not by the noise of their normals.

A wall resists sliding along itself only by the noise of its normals. Noise that stands in both factors of a product
adds up to a false information; the normals of two views err independently, so products of one view's normal with the
other's have no such part.
"""

import numpy as np

from fusion.geometry.depth import PointMap
from fusion.geometry.pose import Array
from fusion.geometry.robust import robust_std
from fusion.tracking.equations import Points
from fusion.tracking.pairs import CUT, tukey

LEAST = 1e-6  # [m] a depth without a stated noise


def by_relief(information: Array, source: Points, model: PointMap, T_model_source: Array, reach: float) -> Array:
    """The information (6, 6) of an alignment that both surfaces' normals bear out; no direction has less than none.

    Args:
        information: (6, 6) as the alignment gives it, by the model's normals alone.
        source: points that were aligned.
        model: with what.
        T_model_source: (4, 4) as aligned.
        reach: largest distance of a pair [m].
    """
    rows = np.moveaxis(source.lanes, 1, 0).reshape(7, -1)
    rows = rows[:, rows[6] >= 0].T.astype(float)
    points = rows[:, :3] @ T_model_source[:3, :3].T + T_model_source[:3, 3]
    normals = rows[:, 3:6] @ T_model_source[:3, :3].T
    camera = model.camera
    pixels = np.rint(camera.project(points))
    inside = np.isfinite(pixels).all(axis=1) & (points[:, 2] > 0) & (pixels >= 0).all(axis=1)
    inside &= (pixels < (camera.width, camera.height)).all(axis=1)
    u, v = pixels[inside].astype(int).T
    points, normals, sigma = points[inside], normals[inside], rows[inside, 6]
    there, theirs = model.points[v, u].astype(float), model.normals[v, u].astype(float)
    apart = np.einsum("ij,ij->i", points - there, theirs)
    met = np.linalg.norm(points - there, axis=1) < 2 * reach  # beside each other along the surface, too
    met &= np.isfinite(apart) & (np.abs(apart) < reach)
    if not met.any():
        return np.zeros((6, 6))
    spread = np.maximum(np.hypot(sigma, model.sigma[v, u])[met], LEAST)
    scale = max(robust_std(apart[met] / spread), 1.0)
    weight = tukey(apart[met] / (scale * spread), CUT) / spread**2
    arm = points[met] - (T_model_source[:3, :3] @ source.centre + T_model_source[:3, 3])
    here, other = (np.hstack([np.cross(arm, n), n]) for n in (normals[met], theirs[met]))
    both, alone = here.T @ (weight[:, None] * other), other.T @ (weight[:, None] * other)
    values, vectors = np.linalg.eigh((both + both.T) / 2 * np.trace(information) / np.trace(alone))
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)
