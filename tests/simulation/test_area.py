"""Few pixels see large parts of the scene: the mean over them, against rays counted one by one."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.pose import about_axis
from fusion.mesh.mesh import Mesh
from fusion.simulation.rendering.render import Channels, RayCaster, render
from fusion.simulation.scene.shapes import box, joined, sheet

AREA = Channels(edges=True, area=True)
X, Y, Z = np.eye(3)
TILTED = about_axis([0.0, 0.0, 1.0], [0.3, 1.0, 0.0], 0.6)
MANY = (np.arange(41) + 0.5) / 41 - 0.5  # px: places in a pixel


def zones(principle: str) -> Camera:
    return Camera(8, 8, 8.1, 7.9, 3.5, 3.6, principle=principle)


def grey(points: np.ndarray) -> np.ndarray:
    return np.full((len(points), 3), 128.0)


def wall(distance: float) -> Mesh:
    return sheet(-9 * X - 9 * Y + distance * Z, 18 * X, 18 * Y, grey)


def seen_by_rays(camera: Camera) -> np.ndarray:
    """(8, 8, 41, 41) depth [m] of a wall at 1 m, along many rays of each pixel of a tilted camera, in closed form."""
    v, u = np.mgrid[0 : camera.height, 0 : camera.width].astype(float)[:, :, :, None, None]
    a, b = np.broadcast_arrays((u + MANY - camera.cx) / camera.fx, (v + MANY[:, None] - camera.cy) / camera.fy)
    along = np.stack([a, b, np.ones_like(a)], -1) @ TILTED[:3, :3].T
    return (1.0 - TILTED[2, 3]) / along[..., 2]


def test_time_of_flight_is_the_mean_length_of_rays_weighed_by_their_light():
    camera = zones("itof")
    z = seen_by_rays(camera)
    v, u = np.mgrid[0:8, 0:8].astype(float)[:, :, :, None, None]
    length = z * np.sqrt(1 + ((u + MANY - 3.5) / 8.1) ** 2 + ((v + MANY[:, None] - 3.6) / 7.9) ** 2)
    middle = np.sqrt(1 + ((u[..., 0, 0] - 3.5) / 8.1) ** 2 + ((v[..., 0, 0] - 3.6) / 7.9) ** 2)
    # the slant against a plane: its distance over the length
    expected = (length**-2).sum(axis=(2, 3)) / (length**-3).sum(axis=(2, 3)) / middle
    view, plain = render(wall(1.0), camera, TILTED, AREA), render(wall(1.0), camera, TILTED)
    far = np.abs(expected - plain.depth).max()
    assert far > 0.002  # of one ray each
    assert np.abs(view.depth - expected).max() < 0.05 * far
    assert view.bent.max() < 1e-4 * expected.max()  # planes are not bent


def test_disparities_are_those_of_the_middle_on_a_plane():
    camera = zones("structured_light")
    view, plain = render(wall(1.0), camera, TILTED, AREA), render(wall(1.0), camera, TILTED)
    # a stereo's mean disparity of a plane is linear, so no figure of the mean itself: none may be added
    assert np.abs(view.depth - plain.depth).max() < 1e-4


def test_a_crease_is_bent_and_an_edge_is_not_averaged():
    crease = joined([wall(1.5), sheet(0.1 * X - 9 * Y + 1.5 * Z, 6 * X - 6 * Z, 18 * Y, grey)])
    bent = render(crease, zones("itof"), np.eye(4), AREA).bent
    column = int(np.argmax(np.where(np.isfinite(bent[4]), bent[4], 0)))
    assert column == 4 and 0.002 < bent[4, 4] < 0.05
    assert np.nanmax(bent[4, :3]) < 1e-4
    before = joined([wall(2.0), box([-0.1, -0.1, 1.0], [0.13, 0.12, 1.2], (128, 128, 128))])
    view, plain = render(before, zones("itof"), np.eye(4), AREA), render(before, zones("itof"), np.eye(4))
    across = np.isinf(view.bent)
    assert across.any() and not across.all()
    assert np.array_equal(view.depth[across], plain.depth[across])


@pytest.mark.parametrize("width", [64, 160])
def test_usual_images_are_as_they_were(width):
    camera = Camera(width, 80, 90.0, 90.0, 50.0, 40.0, principle="itof")
    view = RayCaster(wall(1.0)).view(camera, TILTED, AREA)
    assert view.bent is None
    assert np.array_equal(view.depth, render(wall(1.0), camera, TILTED).depth, equal_nan=True)
