"""Images of a raycast are used again, but not as long as somebody holds them."""

import numpy as np
import pytest
import scenes

from fusion.compute.start import start
from fusion.geometry.camera import Camera
from fusion.volume.raycasting.image_pool import MOST, ImagePool
from fusion.volume.volume import Volume, VolumeSettings

CAMERA = Camera(117, 83, 100.0, 100.0, 58.0, 41.0)  # rows that are no whole pieces
EYES = ([0.0, 0.0, -0.8], [0.9, 0.0, 0.3], [0.0, 0.5, -1.6])
HALF = 3.0  # [m] from the sphere, which is small there


pytestmark = pytest.mark.skipif(start() != "cpu", reason="plain kernels run on a card: they make images anew")


@pytest.fixture(scope="module")
def volume():
    volume = Volume(VolumeSettings(0.01, 0.04))
    for eye in EYES:
        T = scenes.look_at(np.array(eye), np.zeros(3))
        volume.integrate(scenes.sphere(CAMERA, T, np.zeros(3), 0.2), CAMERA, T)
    return volume


def _images(volume, eye):
    seen = volume.raycast(CAMERA, scenes.look_at(np.array(eye), np.zeros(3)))
    return np.dstack([seen.depth, seen.points, seen.normals])


def test_what_is_held_stays_what_it_is(volume):
    kept = [volume.raycast(CAMERA, scenes.look_at(np.array(eye), np.zeros(3))) for eye in EYES]
    row, before = kept[0].points[40], [seen.depth.copy() for seen in kept]
    held = row.copy()
    kept[0] = kept[0].depth  # of the first one a row of points and the depth are held, nothing else
    for _ in range(2 * MOST):
        _images(volume, EYES[1])
    assert np.array_equal(row, held, equal_nan=True) and np.isfinite(row).any()
    assert np.array_equal(kept[0], before[0], equal_nan=True)
    assert all(np.array_equal(s.depth, z, equal_nan=True) for s, z in zip(kept[1:], before[1:], strict=True))


def test_used_again_they_show_nothing_of_what_was_seen_before(volume):
    far = [0.0, 0.0, -HALF]
    fresh = _images(volume, far)
    for eye in EYES:  # all of the image
        assert np.isfinite(_images(volume, eye)[..., 0]).sum() > 3 * np.isfinite(fresh[..., 0]).sum()
        assert np.array_equal(_images(volume, far), fresh, equal_nan=True)


def test_they_cannot_be_changed_where_the_next_raycast_would_show_it(volume):
    seen = volume.raycast(CAMERA, scenes.look_at(np.array(EYES[0]), np.zeros(3)))
    for image in (seen.depth, seen.points, seen.normals, seen.depth[3:], seen.points.reshape(-1)):
        with pytest.raises(ValueError, match="read-only"):
            image[np.isnan(image)] = 0.0


def test_memory_is_taken_again_and_bounded():
    mine = ImagePool()
    canvas = mine.take(7, 5)
    assert mine.take(7, 5) is not canvas  # while it is being written to
    depth = canvas.shown()[0][2:, 1]  # a view of a view
    mine.give_back(canvas)
    assert canvas.held() and mine.take(7, 5) is not canvas
    del depth
    assert mine.take(7, 5) is canvas
    taken = [mine.take(7, 5) for _ in range(3 * MOST)]
    for canvas in taken:
        mine.give_back(canvas)
    again = [mine.take(7, 5) for _ in taken]
    assert sum(any(a is b for b in taken) for a in again) == MOST


@pytest.mark.parametrize("hold", [np.ravel, np.atleast_3d, memoryview, lambda image: image.T[1:], np.asarray])
def test_whatever_refers_to_an_image_keeps_it(hold):
    canvas = ImagePool().take(6, 4)
    for n in range(3):
        held = hold(canvas.shown()[n])
        assert canvas.held()
        del held
        assert not canvas.held()


def test_an_image_cannot_be_made_writable(volume):
    seen = volume.raycast(CAMERA, np.eye(4))
    for image in (seen.depth, seen.points, seen.normals):
        with pytest.raises(ValueError, match="WRITEABLE"):
            image.flags.writeable = True
