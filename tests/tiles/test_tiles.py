"""A mesh made tile by tile is the mesh of one volume, bit for bit."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.errors import RecordingError, VolumeError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import exp, pose, transform
from fusion.mesh.cleanup import without_crumbs
from fusion.mesh.files import read_mesh
from fusion.mesh.ply import write_ply
from fusion.recording.recording import Frame
from fusion.sensor.presets import default_sensor
from fusion.tiles.fusing import changed, one_by_one, pieces, reached
from fusion.tiles.stream import stream
from fusion.tiles.tile import Tile, tiles_of
from fusion.volume.prepared import fuse, prepare
from fusion.volume.settings import BLOCK, VolumeSettings
from fusion.volume.volume import Volume

CAMERA = Camera(96, 72, 80.0, 82.0, 47.0, 36.0, distortion=(0.05, -0.02, 0.001, -0.001, 0.0))
SETTINGS = VolumeSettings(0.02, 0.08)


def scan(count: int, seed: int) -> tuple[list, np.ndarray]:
    """Frames of a wavy wall with specks before it, seen from all over, and their poses."""
    rng, sensor = np.random.default_rng(seed), default_sensor(CAMERA)
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    frames, poses = [], []
    for index in range(count):
        depth = 1.2 + 0.15 * np.sin(u / rng.uniform(5, 20)) + 0.1 * np.cos(v / rng.uniform(5, 20))
        depth[rng.random(depth.shape) < 0.01] = np.nan
        depth[10:14, 20:24] = 0.5  # hangs in the air: a crumb
        frames.append(prepare(Frame(index, index / 30, depth.astype(np.float32)), CAMERA, sensor))
        poses.append(pose(exp(rng.normal(0, 0.5, 6))[:3, :3], rng.normal(0, 0.6, 3)))
    return frames, np.stack(poses)


def at_once(frames, poses, settings) -> Volume:
    volume = Volume(settings)
    for frame, T in zip(frames, poses, strict=True):
        if np.isfinite(T).all():
            fuse(volume, frame, T)
    return volume


def ordered(mesh):
    """Vertices with normals, and faces, in an order that the mesh alone decides."""
    rows = np.concatenate([mesh.vertices, mesh.normals], axis=1)
    order = np.lexsort(rows.T[::-1])
    faces = np.argsort(order)[mesh.faces]
    first = faces.argmin(axis=1)[:, None]
    faces = np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
    return rows[order], faces[np.lexsort(faces.T[::-1])]


@pytest.mark.parametrize("kib, crumb", [(1 << 20, 0.0), (600, 0.0), (150, 0.4), (118, 0.4)])
@pytest.mark.parametrize("bounds", [None, ((-0.7, -0.5, -0.9), (0.9, 0.8, 1.3))])
def test_tiles_of_any_size_give_the_mesh_of_one_volume(tmp_path, kib, crumb, bounds):
    frames, poses = scan(7, seed=1)
    poses[3] = np.nan
    settings = replace(SETTINGS, bounds=bounds)
    whole = without_crumbs(at_once(frames, poses, settings).surface(), crumb)
    found = pieces(frames, poses, replace(settings, max_bytes=kib << 10), tmp_path, one_by_one)
    told = stream(found, tmp_path / "mesh.ply", crumb)
    write_ply(tmp_path / "whole.ply", whole)
    ours, theirs = (ordered(read_mesh(tmp_path / name)) for name in ("mesh.ply", "whole.ply"))
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_array_equal(one, other)
    assert (told.vertices, told.faces) == (len(whole.vertices), len(whole.faces)) and told.faces > 1000
    assert (told.low, told.high) == (tuple(whole.vertices.min(0)), tuple(whole.vertices.max(0)))
    assert len(found) > (1 if kib < 1 << 20 else 0)


def test_a_frame_changes_nothing_outside_of_its_boxes():
    frames, poses = scan(8, seed=2)
    volume = at_once(frames, poses, SETTINGS)  # all blocks that there will be
    for frame, T in zip(frames, poses, strict=True):
        before = volume.blocks.voxels.copy()
        fuse(volume, frame, T)
        blocks = np.flatnonzero((volume.blocks.voxels != before).any(axis=(1, 2, 3)))
        boxes = changed(frame.depth, CAMERA, T, SETTINGS.truncation)
        edge = SETTINGS.voxel * BLOCK
        for corner in volume.blocks.coordinates[blocks].tolist():
            tile = Tile(tuple(corner), tuple(x + 1 for x in corner))
            assert tile.reached(boxes, edge)
        assert len(blocks) > 50


def test_nothing_far_away_is_reached():
    frames, poses = scan(1, seed=3)
    boxes = changed(frames[0].depth, CAMERA, poses[0], SETTINGS.truncation)
    behind = transform(poses[0], np.array([0.0, 0.0, -2.0]))
    at = np.floor(behind / (SETTINGS.voxel * BLOCK)).astype(int).tolist()
    assert not Tile(tuple(at), tuple(x + 1 for x in at)).reached(boxes, SETTINGS.voxel * BLOCK)


@pytest.mark.parametrize("low, high", [((0, 0, 0), (8, 8, 8)), ((-3, 5, 7), (-2, 9, 8)), ((1, 1, 1), (4, 2, 6))])
def test_parts_of_a_tile_are_all_of_it_once(low, high):
    tile = Tile(low, high)
    grid = np.stack(np.meshgrid(*(np.arange(a - 2, b + 2) for a, b in zip(low, high, strict=True))), -1).reshape(-1, 3)
    held = sum(part.holds(grid).astype(int) for part in tile.parts())
    np.testing.assert_array_equal(held, tile.holds(grid).astype(int))
    assert Tile((0, 0, 0), (1, 1, 1)).divisible is False and tile.divisible


def test_tiles_hold_every_box():
    boxes = np.array([[[-0.1, 0.0, 0.3], [0.9, 0.1, 0.3]], [[5.0, 5.0, 5.0], [5.0, 5.0, 5.0]]])
    found = tiles_of(boxes, 0.1, 4)
    assert {tile.low for tile in found} == {(-4, 0, 0), (0, 0, 0), (4, 0, 0), (8, 0, 0), (48, 48, 48)}


def test_frames_that_cannot_be_read_or_have_no_pose_are_left_out(tmp_path):
    frames, poses = scan(3, seed=4)
    poses[1] = np.nan

    class Broken(list):
        def __getitem__(self, index):
            if index == 0:
                raise RecordingError("a broken file")
            return super().__getitem__(index)

    assert list(reached(Broken(frames), poses, SETTINGS, tmp_path).boxes) == [2]


def test_a_block_that_does_not_fit_is_told(tmp_path):
    frames, poses = scan(1, seed=5)
    with pytest.raises(VolumeError, match="a tile of one block does not fit"):
        pieces(frames, poses, replace(SETTINGS, max_bytes=1000), tmp_path, one_by_one)


def test_no_surface_is_told(tmp_path):
    with pytest.raises(VolumeError, match="nothing was fused"):
        stream([], tmp_path / "mesh.ply", 0.0)
    assert not (tmp_path / "mesh.ply").exists()
