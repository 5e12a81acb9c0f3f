"""The field as arrays is the field that rays and points are asked of."""

import numpy as np
import pytest
import scenes
from scipy.ndimage import map_coordinates

from fusion.errors import VolumeError
from fusion.geometry.camera import Camera
from fusion.volume.volume import Volume, VolumeSettings

CAMERA = Camera(160, 120, 140.0, 140.0, 79.5, 59.5)
CENTRE, RADIUS, VOXEL = np.array([0.010, -0.020, 0.013]), 0.1, 0.005
BOX = ((-0.061, -0.058, -0.052), (0.083, 0.049, 0.121))  # cuts through blocks


@pytest.fixture(scope="module")
def sphere():
    volume = Volume(VolumeSettings(VOXEL, 0.02))
    for T in scenes.around(CENTRE, 0.4):
        volume.integrate(scenes.sphere(CAMERA, T, CENTRE, RADIUS), CAMERA, T)
    return volume


def places(field):
    steps = np.stack(np.meshgrid(*map(np.arange, field.distance.shape), indexing="ij"), axis=-1)
    return field.origin + field.voxel * steps


@pytest.mark.parametrize("box", [None, BOX])
def test_every_voxel_is_what_the_volume_says_there(sphere, box):
    field = sphere.to_numpy(box)
    distance, _, weight = sphere.sample(places(field).reshape(-1, 3))
    known = weight > 0
    assert known.any()
    # points fall beside the voxel by the rounding of their coordinates
    assert np.abs(distance - field.distance.reshape(-1))[known].max() < 1e-4 * VOXEL
    assert np.array_equal(np.isnan(field.distance), field.weight == 0)


def test_its_zero_is_the_surface(sphere):
    field, mesh = sphere.to_numpy(), sphere.surface()
    at = (mesh.vertices - field.origin) / field.voxel
    found = map_coordinates(np.nan_to_num(field.distance), at.T, order=1)
    # vertices lie where the edge of a cell is crossed: what is left is the rounding of float32
    assert np.abs(found).max() < 1e-3 * VOXEL


def test_distance_is_truth_near_the_surface(sphere):
    field = sphere.to_numpy()
    true = np.linalg.norm(places(field) - CENTRE, axis=-1) - RADIUS
    near = np.abs(field.distance) < VOXEL
    # pixels of 3 mm seen at a slant on voxels of 5 mm
    assert np.median(np.abs(field.distance - true)[near]) < 0.05 * VOXEL


def test_what_was_never_seen_is_nan(sphere):
    field = sphere.to_numpy()
    inside = np.linalg.norm(places(field) - CENTRE, axis=-1) < RADIUS - 0.05  # deeper than the band reaches
    assert inside.any() and np.isnan(field.distance[inside]).all() and not field.weight[inside].any()


def test_a_box_is_cut_to_its_corners(sphere):
    field = sphere.to_numpy(BOX)
    corners = places(field)
    assert (corners[0, 0, 0] >= BOX[0]).all() and (corners[0, 0, 0] - BOX[0] < VOXEL).all()
    assert (corners[-1, -1, -1] <= BOX[1]).all() and (BOX[1] - corners[-1, -1, -1] < VOXEL).all()
    whole, start = sphere.to_numpy(), np.rint((field.origin - sphere.to_numpy().origin) / VOXEL).astype(int)
    same = whole.distance[tuple(slice(a, a + n) for a, n in zip(start, field.distance.shape, strict=True))]
    assert np.array_equal(same, field.distance, equal_nan=True)


def test_a_box_where_nothing_is_holds_nothing(sphere):
    field = sphere.to_numpy(((5.0, 5.0, 5.0), (5.02, 5.03, 5.04)))
    assert field.distance.shape == (5, 7, 9) and np.isnan(field.distance).all()


def test_an_empty_volume_gives_an_empty_array():
    assert Volume(VolumeSettings(VOXEL, 0.02)).to_numpy().distance.shape == (0, 0, 0)


@pytest.mark.parametrize(
    ("box", "says"),
    [
        (((0, 0, 0), (-1, 1, 1)), "no voxel"),
        (((0, 0, np.nan), (1, 1, 1)), "not usable"),
        (((0, 0), (1, 1)), "not usable"),
        (((-9, -9, -9), (9, 9, 9)), "does not fit"),
    ],
)
def test_a_box_that_cannot_be_is_refused(sphere, box, says):
    with pytest.raises(VolumeError, match=says):
        sphere.to_numpy(box)
