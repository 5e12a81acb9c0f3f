"""The textured mesh beside its photographs: from the same place, cut to the object, the same colours."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "coloring"))
from painted import HALF, cube, off, paint, scene

from fusion.errors import RecordingError
from fusion.texture.shown import beside_photographs, seen_texture
from fusion.texture.textured import texture_mesh


@pytest.fixture(scope="module")
def made():
    taken = scene(lambda _: [cube()])
    return texture_mesh(off(cube(), 0.001), [(taken.recording, taken.poses)], triangles=1500)


def test_photographs_are_spread_and_cut_to_the_object(made):
    pairs = list(beside_photographs(made, 4))
    frames = [pair.frame for pair in pairs]
    assert len(set(frames)) == 4 and np.ptp(frames) > len(made.views.frames) // 2
    for pair in pairs:
        assert pair.photograph.shape == pair.texture.shape == (*pair.shown.shape, 3)
        assert 0.3 < pair.shown.mean() < 1
        inner = pair.shown & np.roll(pair.shown, 3, 0) & np.roll(pair.shown, -3, 0)
        apart = np.abs(pair.photograph.astype(int) - pair.texture)[inner].max(axis=1)
        assert np.median(apart) < 6 and np.quantile(apart, 0.9) < 15
    assert len(list(beside_photographs(made, 1000))) == len(made.views.frames)


def test_what_a_camera_sees_is_the_paint_where_it_looks(made):
    source, T = made.views.sources[0], made.views.T_world_color[0]
    colors, depth = seen_texture(made, source.camera, T)
    v, u = np.nonzero(np.isfinite(depth))
    rays = np.dstack([source.camera.rays(), np.ones(source.camera.shape)])
    points = (rays * np.where(np.isfinite(depth), depth, 0)[..., None])[v, u] @ T[:3, :3].T + T[:3, 3]
    assert np.abs(points).max() < HALF + 0.004
    wrong = np.abs(colors[v, u] - paint(np.clip(points, -HALF, HALF))).max(axis=1)
    assert np.median(wrong) < 8
    assert not colors[~np.isfinite(depth)].any()


def test_a_photograph_that_cannot_be_read_is_left_out(made):
    first = made.views.frames[0]

    class Damaged:
        def __init__(self, source):
            self.camera, self._source = source.camera, source

        def read(self, index):
            if index == first:
                raise RecordingError("damaged", "here")
            return self._source.read(index)

    views = replace(made.views, sources=[Damaged(source) for source in made.views.sources])
    frames = [pair.frame for pair in beside_photographs(replace(made, views=views), 4)]
    assert len(frames) == 3 and first not in frames
