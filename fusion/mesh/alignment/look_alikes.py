"""Poses that lie nearly as well as one that was found: turned about the reference's own axes, or a layer off."""

from collections.abc import Callable
from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from fusion.mesh.alignment.coarse import ALIKE, NEAR, CoarseSurface, box_axes, principal_axes, rating
from fusion.mesh.alignment.similarity import Array, Matches, Similarity, held_axes

_STEP = 5.0  # [deg] of turns that are tried: ICP finds the rest
_TRIED = 600  # samples
# times the mesh's distance in the pose that was found: more is another shape, and no matter of refining (guess). What
# the reference's side differs by may be its samples' chance
MAYBE = 1.5
_APART = 2 * ALIKE
_KEPT = 24
_LAYERS = np.arange(-6, 7) / 6 * NEAR  # of the size


def turned_alike(mesh: CoarseSurface, reference: CoarseSurface, pose: Similarity) -> list[Similarity]:
    """The pose turned about each of the reference's axes, wherever few samples lie as well as in it, or nearly.

    A small feature may tell the right one of them from all others: a pocket, a keyway, a missing tooth.
    """
    few = mesh.points[:: max(1, len(mesh.points) // _TRIED)]
    back = reference.points[:: max(1, len(reference.points) // _TRIED)]
    middle = reference.points.mean(axis=0)

    def turned(turn: Array) -> Similarity:
        return Similarity(turn @ pose.rotation, turn @ (pose.shift - middle) + middle, pose.scale)

    of_poses = rating(mesh, reference, few, back, NEAR)

    def rated(turns: list[Array]) -> Array:
        return of_poses([turned(turn) for turn in turns])

    own = float(np.minimum(reference.tree.query(pose.apply(few))[0], NEAR * reference.size).mean())
    most = float(of_poses([pose])[0]) + (MAYBE - 1) * own + NEAR * reference.size / np.sqrt(len(back))
    axes = np.vstack([principal_axes(reference.points).T, box_axes(reference.points).T])
    about = [np.deg2rad(angle) * axis for axis in axes for angle in np.arange(_STEP, 360, _STEP)]
    found = _best(list(Rotation.from_rotvec(about).as_matrix()), rated, most)
    # one after the other they reach axes that are none of these, as the edges of a prism
    both = [one @ other for one, other in product(found, found)]
    return [turned(turn) for turn in _best([*found, *both], rated, most)]


def _best(turns: list[Array], rated: Callable[[list[Array]], Array], most: float) -> list[Array]:
    """The best of rotations that are rated no worse than `most`, none near another or near none at all."""
    ratings = rated(turns) if turns else np.zeros(0)
    kept: list[Array] = [np.eye(3)]
    for k in np.argsort(ratings, kind="stable"):
        if ratings[k] > most or len(kept) > _KEPT:
            break
        near = np.einsum("nij,ij->n", np.array(kept), turns[k])  # 1 + 2 cos of the angle between
        if near.max() < 1 + 2 * np.cos(_APART):
            kept.append(turns[k])
    return kept[1:]


def layers(pose: Similarity, matches: Matches, size: float) -> list[Similarity]:
    """The pose shifted along the way that most of what lies on each other looks: thin things lie on both sides."""
    along = held_axes(matches)[-1] * size
    return [Similarity(pose.rotation, pose.shift + off * along, pose.scale) for off in _LAYERS if off]
