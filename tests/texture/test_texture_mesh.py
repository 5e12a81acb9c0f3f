"""A texture of a painted box: its colours where the paint is known, no background, every triangle covered."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "coloring"))
from painted import HALF, cube, off, paint, scene

from fusion.coloring.images import bilinear
from fusion.errors import MeshError, RecordingError
from fusion.mesh.comparison.surface_samples import face_areas, sample_surface
from fusion.mesh.mesh import Mesh
from fusion.texture import atlas as atlas_module
from fusion.texture.atlas import laid_flat
from fusion.texture.lighting.exposure import SampledView
from fusion.texture.lighting.levels import levels_of
from fusion.texture.lighting.light import Facings
from fusion.texture.textured import texels_of, texture_mesh

GREEN_SHARE = 20 + 0.2 * 235  # of the paint's 20 and the room's 255


def colors_on(made, count=20_000):
    """Points spread over a textured mesh, and the colour of its picture there, as a viewer looks it up."""
    faces = made.mesh.faces
    rng = np.random.default_rng(1)
    area = face_areas(made.mesh)
    face = rng.choice(len(faces), count, p=area / area.sum())
    share = rng.dirichlet([1, 1, 1], count)[..., None]
    points = (made.mesh.vertices[faces[face]] * share).sum(axis=1)
    uv = (made.uv[faces[face]] * share).sum(axis=1)
    h, w = made.image.shape[:2]
    return points, bilinear(made.image, np.column_stack([uv[:, 0] * w - 0.5, (1 - uv[:, 1]) * h - 0.5]))


@pytest.fixture(scope="module")
def made():
    """The box from all sides, the mesh 2 mm too large, poses and colour some pixels off."""
    taken = scene(lambda _: [cube()], sigma_rad=0.003, shift=2)
    return texture_mesh(off(cube(), 0.002), [(taken.recording, taken.poses)], triangles=3000)


def test_the_paint_comes_out_and_no_background(made):
    points, colors = colors_on(made)
    seen = points[:, 2] > -HALF + 0.005  # no camera looks at the bottom
    true = paint(np.clip(points, -HALF, HALF)).astype(float)
    wrong = np.abs(colors - true).max(axis=1)[seen]
    # two pixels are 4 mm, in paint of up to 2.6 counts a millimetre; beside it 2 mm and a pixel
    assert np.median(wrong) < 8 and np.quantile(wrong, 0.95) < 15
    rim = seen & ((np.abs(np.abs(points) - HALF) < 0.008).sum(axis=1) >= 2) & (points[:, 2] > -HALF + 0.02)
    assert rim.sum() > 500 and (colors[rim, 1] > GREEN_SHARE).mean() == 0


def test_places_and_triangles_lie_in_the_picture(made):
    assert made.uv.min() >= 0 and made.uv.max() <= 1 and len(made.uv) == len(made.mesh.vertices)
    h, w = made.image.shape[:2]
    corners = made.uv[made.mesh.faces] * [w, h]
    (x, y), (z, t) = ((corners[:, i] - corners[:, 0]).T for i in (1, 2))
    flat = np.abs(x * t - y * z) / 2
    assert (flat > 0).all()  # none is a line
    # each triangle is as large in the picture as on the box, within what flattening bends
    a, b, c = (made.mesh.vertices[made.mesh.faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2 / made.texel**2
    assert np.quantile(flat / area, [0.01, 0.99]) == pytest.approx([1, 1], abs=0.3)


def test_the_surface_is_that_of_the_mesh(made):
    assert len(made.mesh.faces) <= 3000
    box = np.abs(sample_surface(made.mesh, 5000).points)
    assert np.abs(box.max(axis=1) - (HALF + 0.002)).max() < 0.0005
    assert made.moved[0] < 1e-4
    assert made.unseen_share == pytest.approx(1 / 6, abs=0.03)  # the bottom


def test_finer_than_the_vertices(made):
    """A few large triangles carry as much print as many: what a vertex's colour cannot."""
    taken = scene(lambda _: [cube()])
    few = texture_mesh(off(cube(), 0.0005), [(taken.recording, taken.poses)], triangles=100)
    points, colors = colors_on(few)
    seen = points[:, 2] > -HALF + 0.005
    wrong = np.abs(colors - paint(np.clip(points, -HALF, HALF)).astype(float)).max(axis=1)[seen]
    assert len(few.mesh.faces) <= 100 and np.median(wrong) < 4


@pytest.mark.parametrize("library", ["xatlas", "open3d"])
def test_no_two_triangles_share_a_texel(library, monkeypatch):
    if library == "open3d":
        monkeypatch.setitem(sys.modules, "xatlas", None)
    mesh = cube(cells=6)
    flat = laid_flat(mesh, 0.002)
    assert flat.width <= atlas_module.LARGEST and flat.height <= atlas_module.LARGEST
    texels = texels_of(flat)
    # as many texels as the surface has: overlapping parts would have fewer
    share = len(texels.at) * 0.002**2 / (6 * (2 * HALF) ** 2)
    assert share == pytest.approx(1, abs=0.02 if library == "xatlas" else 0.5)
    on_box = np.abs(texels.points.vertices).max(axis=1)
    np.testing.assert_allclose(on_box, HALF, atol=1e-6)
    outward = (texels.points.vertices * texels.points.normals).sum(axis=1)
    assert (outward > 0).all()
    np.testing.assert_array_equal(flat.mesh.vertices, mesh.vertices[flat.of])


def test_parts_keep_their_distance():
    """Between parts lies a gutter: a texel's neighbours within two belong to the same side of the box, or to none."""
    texels = texels_of(laid_flat(cube(cells=6), 0.002))
    side = np.zeros(texels.shape[0] * texels.shape[1], int)
    at = np.abs(texels.points.vertices).argmax(axis=1)
    side[texels.at] = 1 + at * 2 + (texels.points.vertices[np.arange(len(at)), at] > 0)
    picture = side.reshape(texels.shape)
    wide = sum(int(((picture[:, :-k] != picture[:, k:]) & (picture[:, :-k] > 0) & (picture[:, k:] > 0)).sum())
               for k in (1, 2))  # fmt: skip
    folded = 12 * 100 * 2 * 2  # edges of the box that stay together in a part: 100 texels each, seen across
    assert wide <= folded


def look(index, low, fine=1.0, facing=None):
    """A view of points that all face it, at one place, if nothing else is said."""
    count = len(index)
    front = Facings(np.zeros((count, 3), np.float32), np.tile(np.float32([0, 0, -1]), (count, 1)))
    weight = np.ones(count, np.float32)
    low = low.astype(np.float32)
    return SampledView(0, index, facing or front, weight, low, fine * weight)


def test_exposure_is_evened_out():
    rng = np.random.default_rng(0)
    true, gains = rng.uniform(40, 200, (500, 3)), np.array([0.8, 1.0, 1.25, 1.0])
    looks = []
    for gain in gains:
        index = np.sort(rng.permutation(500)[:300])
        looks.append(look(index, true[index] * gain))
    found = levels_of(looks, 500)
    np.testing.assert_allclose(found.gain * gains[:, None], 1, atol=0.01)
    assert found.trust.min() > 0.9


def test_white_is_not_made_whiter():
    true = np.random.default_rng(0).uniform(100, 180, (500, 3))
    true[:100] = 240  # paper, taken by the darker exposures only
    looks = []
    for k, gain in enumerate([0.8, 0.8, 1.25, 1.25]):
        index = np.arange(0 if k < 2 else 100, 500)
        looks.append(look(index, true[index] * gain))
    found = levels_of(looks, 500)
    even = np.stack([look.low[-1] * gain for look, gain in zip(looks, found.gain, strict=True)])
    np.testing.assert_allclose(even, even[:1].repeat(4, axis=0), rtol=0.01)
    assert (looks[0].low[:100] * found.gain[0]).max() <= 255 * 1.001


def test_a_lamp_beside_the_table_is_no_exposure():
    """Sides of one object brighter in some views, others darker: what is left over is as large as what views share."""
    rng = np.random.default_rng(0)
    true, side = rng.uniform(60, 150, (600, 3)), np.arange(600) // 100
    looks = []
    for _ in range(12):
        shown = rng.permutation(6)[:3]  # a view shows three sides
        index = np.flatnonzero(np.isin(side, shown))
        light = np.exp(0.1 * rng.standard_normal(6))[side[index], None]
        looks.append(look(index, true[index] * light))
    assert np.log(levels_of(looks, 600).gain).std() < 0.03  # half of what a mean over three sides would say


def test_a_view_of_something_else_is_not_trusted():
    true = np.random.default_rng(0).uniform(80, 200, (500, 3)).astype(np.float32)
    looks = [look(np.arange(500), true.copy()) for _ in range(5)]
    looks[2].low[100:150] = 10  # a hand
    found = levels_of(looks, 500)
    assert found.trust[2, 100:150].max() < 0.1 and found.trust[2, 200:].min() > 0.5 and found.trust[0].min() > 0.5


def test_a_blurred_view_counts_less():
    looks = [look(np.arange(500), np.full((500, 3), 99), fine) for fine in (20, 5, 20)]
    sharp = levels_of(looks, 500).sharp
    assert sharp[1] < 0.5 and sharp[0] == pytest.approx(1, abs=0.01)


def test_what_makes_no_texture_is_told():
    taken = scene(lambda _: [cube()])
    good = [(taken.recording, taken.poses)]
    with pytest.raises(MeshError, match="needs triangles"):
        texture_mesh(Mesh(cube().vertices), good)
    dark = replace(taken.recording, load=lambda i: replace(taken.recording[i], color=None))
    with pytest.raises(RecordingError, match="no colour image"):
        texture_mesh(off(cube(), 0.002), [(dark, taken.poses)])
    small = replace(taken.recording, load=lambda i: replace(taken.recording[i], color=np.zeros((12, 16, 3), np.uint8)))
    with pytest.raises(RecordingError, match="colour image"):
        texture_mesh(off(cube(), 0.002), [(small, taken.poses)])
