"""A finished mesh takes its colours from the images: the best views of each vertex, what disagrees left out.

The volume could fuse colours too, but it does not know what a later frame shows to stand in the way, mixes all views
of a voxel, good and bad, and needs three times the memory. The mesh knows its rims.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.coloring.best_views import BestViews
from fusion.coloring.fill import filled
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
FILLED = 0.03  # [m] colours are carried so far along the surface to where no image looked (guess)
NEUTRAL = 180  # grey of what no image shows, as of a mesh without colours


@dataclass(frozen=True)
class Colored:
    """A mesh with colours, and how they came about.

    Attributes:
        mesh: its scalars "color_views" say how many images each vertex has its colour from; 0 where no image shows it:
            there the colour is that of its neighbours, or grey far from any. Without colours where the recording has no
            colour image that can be used.
        images: how many were used.
        lost: how many could not be, being damaged, missing or of another size.
        uncolored_share: of the vertices, shown by no image; None without images.
        neutral_share: of the vertices, grey; None without images.
    """

    mesh: Mesh
    images: int = 0
    lost: int = 0
    uncolored_share: float | None = None
    neutral_share: float | None = None

    def values(self) -> dict[str, float | None]:
        """What `settings.json` tells of it."""
        return {
            "color": self.mesh.colors is not None,
            "color_images": self.images,
            "color_images_lost": self.lost,
            "uncolored_share": self.uncolored_share,
            "neutral_share": self.neutral_share,
        }


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
