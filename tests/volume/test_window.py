"""Where rays have to look: no place where one may end is left out."""

import numpy as np
import pytest
from scenes import look_at

from fusion.geometry.camera import Camera
from fusion.geometry.pose import inverse
from fusion.volume.raycasting.window import TILE, window
from fusion.volume.settings import BLOCK, VolumeSettings
from fusion.volume.volume import Volume

LENS = (-0.28, 0.12, 1e-3, -2e-3, -0.02, 0.0, 0.0, 0.0)
CAMERAS = {
    "pinhole": Camera(200, 150, 180.0, 175.0, 101.0, 73.0),
    "lens": Camera(200, 150, 180.0, 175.0, 101.0, 73.0, LENS),
    "odd": Camera(61, 47, 50.0, 52.0, 29.0, 24.5),
}
VOXEL = 0.01


@pytest.mark.parametrize("distance", [0.1, 0.5, 2.0])
@pytest.mark.parametrize("name", CAMERAS)
def test_what_may_be_seen_lies_within_the_range_of_its_tile(name, distance):
    camera, rng = CAMERAS[name], np.random.default_rng(7)
    volume = Volume(VolumeSettings(VOXEL, 4 * VOXEL))
    blocks = volume.blocks
    blocks.insert(np.unique(rng.integers(-4, 4, (40, 3)), axis=0).astype(np.int32))
    behind = rng.random((blocks.count, 2, 2, 2)) < 0.3
    fine = behind.repeat(4, axis=1).repeat(4, axis=2).repeat(4, axis=3)
    blocks.voxels[: blocks.count, :, 0] = np.where(fine, -1.0, 1.0).reshape(blocks.count, BLOCK * BLOCK, BLOCK)
    blocks.mark(slice(0, blocks.count))
    T = look_at(np.array([0.3, 0.2, 1.0]) * distance, np.array([0.02, 0.0, 0.05]))
    reach = (0.05, 3.0)
    seen = window(blocks, camera, T, reach)
    n, *octant = np.nonzero(behind)
    corner = blocks.coordinates[n] * BLOCK + 4.0 * np.stack(octant, axis=1) - 1.0  # one voxel around
    for _ in range(20):
        points = (corner + 5.0 * rng.random(corner.shape)) * VOXEL
        local = points @ inverse(T)[:3, :3].T + inverse(T)[:3, 3]
        z = local[:, 2]
        front = (z > reach[0]) & (z < reach[1])
        u, v = np.round(camera.project(local[front])).astype(int).T
        slant = np.hypot(*(local[front, :2] / z[front, None]).T)
        inside = (u >= 0) & (v >= 0) & (u < camera.width) & (v < camera.height)
        inside &= slant < np.hypot(*np.moveaxis(camera.rays(), 2, 0)).max()  # the lens model folds back far outside
        tile = v[inside] >> TILE, u[inside] >> TILE
        assert (seen.first[tile] <= z[front][inside] + 1e-6).all()
        assert (seen.last[tile] >= z[front][inside] - 1e-6).all()


def test_octants_tell_where_the_inside_is():
    volume = Volume(VolumeSettings(VOXEL, 4 * VOXEL))
    volume.blocks.insert(np.array([[0, 0, 0], [3, 0, 0]], np.int32))
    field = np.ones((BLOCK, BLOCK, BLOCK), np.float32)
    field[1, 6, 2] = field[7, 7, 7] = -0.5
    volume.blocks.voxels[1, :, 0] = field.reshape(BLOCK * BLOCK, BLOCK)
    volume.blocks.mark(slice(0, 2))
    assert volume.blocks.solid[:2].tolist() == [0, 1 << 2 | 1 << 7]


def test_a_stray_block_far_away_is_reached():
    volume = Volume(VolumeSettings(0.001, 0.004))
    camera = Camera(32, 24, 40000.0, 40000.0, 15.5, 11.5)
    depth = np.full(camera.shape, np.nan, np.float32)
    depth[8:16, 12:20] = 90.0
    volume.integrate(depth, camera, np.eye(4))
    seen = volume.raycast(camera, np.eye(4), far=100.0).depth  # a step is less than what single precision holds
    assert np.allclose(seen[10:14, 14:18], 90.0, atol=1e-3)
