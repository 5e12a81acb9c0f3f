"""A finished mesh takes its colours from the images: the best views of each vertex, what disagrees left out.

The volume could fuse colours too, but it does not know what a later frame shows to stand in the way, mixes all views
of a voxel, good and bad, and needs three times the memory. The mesh knows its rims.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from fusion.coloring.images import ColorImages, color_images
from fusion.coloring.surface import RayMesh
from fusion.coloring.visible import VisibleVertices, visible
from fusion.errors import RecordingError
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.progress import each
from fusion.recording.ahead import ahead
from fusion.recording.recording import Recording

# images used, as different as can be: all of a turn, a tenth of a long walk, so that colour costs a tenth of the whole
ENOUGH, SHARE = 60, 0.1
# [m] colours are carried so far along the surface to where no image looked (guess); absolute: a rim or a hand hides so
# much of a thing of any size, and farther on a colour is made up
FILLED = 0.03
NEUTRAL = 180  # grey of what no image shows, as of a mesh without colours
KEPT = 8  # views of a vertex: enough that two or three bad ones are outvoted, few enough to stay sharp (guess)
ALIKE = 20.0  # [counts] views that differ by more from the middle one hardly count: another thing, or a gloss (guess)
BLOCK = 65536  # vertices at once


class BestViews:
    """Colours of each vertex in the views that show it best; memory does not grow with the number of views."""

    def __init__(self, vertices: int) -> None:
        self._weights = np.zeros((vertices, KEPT), np.float32)
        self._colors = np.zeros((vertices, KEPT, 3), np.uint8)

    def add(self, index: NDArray[np.int64], weight: NDArray[np.float32], colors: NDArray[np.float32]) -> None:
        """A view of the vertices `index` (k,), each once, with weights (k,) above 0 and colours (k, 3)."""
        slot = self._weights[index].argmin(axis=1)
        better = weight > self._weights[index, slot]
        index, slot = index[better], slot[better]
        self._weights[index, slot] = weight[better]
        self._colors[index, slot] = np.rint(colors[better])

    def counts(self) -> NDArray[np.int64]:
        """(n,) views that each vertex has its colour from."""
        return np.asarray((self._weights > 0).sum(axis=1))

    def blended(self) -> NDArray[np.float32]:
        """Colours (n, 3): the mean of the views near to the weighted median; 0 where there is none."""
        colors = np.empty((len(self._weights), 3), np.float32)
        for start in range(0, len(colors), BLOCK):
            block = slice(start, start + BLOCK)
            colors[block] = _blended(self._colors[block].astype(np.float32), self._weights[block])
        return colors


def _blended(colors: NDArray[np.float32], weights: NDArray[np.float32]) -> NDArray[np.float32]:
    """(n, 3) from colours (n, views, 3) and weights (n, views), 0 where there is no view."""
    total = weights.sum(axis=1, keepdims=True)
    share = np.asarray(weights / np.where(total > 0, total, 1), np.float32)
    order = colors.argsort(axis=1)
    ordered = np.take_along_axis(colors, order, axis=1)
    below = np.take_along_axis(np.broadcast_to(share[..., None], colors.shape), order, axis=1).cumsum(axis=1)
    half = (below < 0.5).sum(axis=1, keepdims=True).clip(max=colors.shape[1] - 1)
    median = np.take_along_axis(ordered, half, axis=1)
    apart = ((colors - median) ** 2).sum(axis=2)
    trust = share * np.exp(-apart / (2 * ALIKE**2))
    # the median itself counts a little: it need not be near to any view where these disagree in all channels
    little = 1e-3
    mean = (trust[..., None] * colors).sum(axis=1) + little * median[:, 0]
    return np.asarray(mean / (trust.sum(axis=1) + little)[:, None] * (total > 0), np.float32)


@dataclass(frozen=True, kw_only=True)
class ColorFigures:
    """How the colours came about: whether there are any, then as in `Colored`."""

    color: bool
    color_images: int
    color_images_lost: int
    uncolored_share: float | None
    neutral_share: float | None


@dataclass(frozen=True)
class Colored:
    """A mesh with colours, and how they came about."""

    # its scalars "color_views" say how many images each vertex has its colour from; 0 where no image shows it: there
    # the colour is that of its neighbours, or grey far from any. Without colours where the recording has no colour
    # image that can be used.
    mesh: Mesh
    images: int = 0  # how many were used
    lost: int = 0  # how many could not be, being damaged, missing or of another size
    uncolored_share: float | None = None  # of the vertices, shown by no image; None without images
    neutral_share: float | None = None  # of the vertices, grey; None without images

    def figures(self) -> ColorFigures:
        """In few numbers."""
        return ColorFigures(
            color=self.mesh.colors is not None,
            color_images=self.images,
            color_images_lost=self.lost,
            uncolored_share=self.uncolored_share,
            neutral_share=self.neutral_share,
        )


def color_mesh(mesh: Mesh, recording: Recording, trajectory: Trajectory) -> Colored:
    """Colour a mesh from the recording that it was made from.

    Args:
        mesh: triangles in the world of the trajectory.
        recording: with the camera that the mesh was made with; its colour images may be in the depth camera's pixels
            or those of a colour camera beside it.
        trajectory: (frames) `T_world_camera` of the depth camera, NaN for frames without a pose.
    """
    return color_from(mesh, [(recording, trajectory)])


def color_from(mesh: Mesh, taken: Sequence[tuple[Recording, Trajectory]]) -> Colored:
    """Colour a mesh from several recordings, each with the trajectory (frames) of its camera in the mesh's world."""
    plain = replace(mesh, colors=None)
    sources = [(source, course) for one, course in taken if (source := color_images(one)) is not None]
    if not sources or not len(mesh.faces):
        return Colored(plain)
    surface, best, images, lost = RayMesh(mesh), BestViews(len(mesh.vertices)), 0, 0
    for source, course in sources:
        used, failed = _looked_at(surface, best, source, course)
        images, lost = images + used, lost + failed
    if not images:
        return Colored(plain, lost=lost)
    views = best.counts()
    colors, known = filled(mesh, best.blended(), views > 0, FILLED)
    colors[~known] = NEUTRAL
    return Colored(
        replace(
            mesh,
            colors=np.rint(colors).astype(np.uint8),
            scalars=mesh.scalars | {"color_views": views.astype(np.float32)},
        ),
        images,
        lost,
        float(np.mean(views == 0)),
        float(np.mean(~known)),
    )


def _looked_at(surface: RayMesh, best: BestViews, source: ColorImages, trajectory: Trajectory) -> tuple[int, int]:
    """Add what well spread images show of a surface: how many there were, and how many could not be used."""
    images = lost = 0
    most = max(ENOUGH, int(SHARE * len(trajectory)))

    def look(index: int) -> tuple[VisibleVertices, NDArray[np.float32]] | None:
        image = source.read(index)
        if image is None:
            return None
        shown = visible(surface, source.seen(image, source.T_world_color(trajectory.poses[index])))
        return shown, image.sampled(shown.pixels)

    some = source.spread(trajectory, most)
    for looked in each(ahead(look, some), "colour", len(some)):
        try:
            found = looked()
        except RecordingError:
            lost += 1
            continue
        if found is not None:
            shown, colors = found
            best.add(shown.index, shown.weight, colors)
            images += 1
    return images, lost


def filled(
    mesh: Mesh, colors: NDArray[np.float32], known: NDArray[np.bool_], reach: float
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Colours (n, 3) of a mesh in which unknown vertices took the mean of their neighbours', and who has one (n,).

    Ring by ring along the edges of the mesh, as far as about `reach` [m].

    Args:
        colors: (n, 3); of unknown vertices they have no meaning.
        known: (n,) vertices with a colour.
        reach: how far colours are carried [m].
    """
    edges = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    lost = ~known
    edges = edges[lost[edges].any(axis=1)]  # only these pass a colour on
    if not len(edges):
        return colors, known
    length = float(np.median(np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)))
    both = np.concatenate([edges, edges[:, ::-1]])
    shape = (len(known), len(known))
    beside = coo_array((np.ones(len(both), np.float32), (both[:, 0], both[:, 1])), shape).tocsr()
    colors, known = colors.copy(), known.copy()
    for _ in range(int(np.ceil(reach / max(length, 1e-9)))):
        rest = np.flatnonzero(~known)
        around = beside[rest]
        count = around @ known.astype(np.float32)
        new = count > 0
        if not new.any():
            break
        total = around[np.flatnonzero(new)] @ (colors * known[:, None])
        colors[rest[new]] = total / count[new, None]
        known[rest[new]] = True
    return colors, known
