"""Laws of the volume: what goes in comes out, whatever the camera; sums are sums; bad input is met before harm."""

import numpy as np
import pytest
import scenes
import trimesh
from scipy.spatial import cKDTree
from volume_twin import crossings_twin, integrate_twin, raycast_twin

from fusion.errors import VolumeError
from fusion.geometry.camera import Camera
from fusion.volume.blocks import by_voxel
from fusion.volume.extraction.cubes import table
from fusion.volume.volume import Volume, VolumeSettings

CAMERAS = {
    "pinhole": Camera(160, 120, 140.0, 140.0, 79.5, 59.5),
    "odd and distorted": Camera(161, 121, 140.0, 142.0, 79.3, 61.2, (0.1, -0.05, 0.001, -0.002, 0.01)),
    "rational": Camera(157, 119, 120.0, 120.0, 80.0, 58.0, (0.3, 0.05, 0.0, 0.0, 0.01, 0.25, 0.06, 0.0)),
    "barrel that folds back": Camera(160, 120, 110.0, 110.0, 79.5, 59.5, (-0.28, 0.05, 0.0005, 0.0, 0.0)),
}
CENTRE, RADIUS = np.array([0.010, -0.020, 0.013]), 0.1
SETTINGS = VolumeSettings(voxel=0.005, truncation=0.02)


@pytest.fixture(scope="module", autouse=True, params=["tuned", "plain"])
def kernels(request):
    """All of it holds for both."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FUSION_KERNELS", request.param)
        yield


def whole_sphere(camera, settings=SETTINGS, **options):
    volume = Volume(settings)
    for T in scenes.around(CENTRE, 0.4):
        volume.integrate(scenes.sphere(camera, T, CENTRE, RADIUS), camera, T, **options)
    return volume


@pytest.fixture(scope="module")
def sphere():
    return whole_sphere(CAMERAS["odd and distorted"])


@pytest.fixture(scope="module")
def one_view():
    """A sphere in front of a slanted wall, one frame, some pixels missing: (volume, camera, pose, depth)."""
    camera = Camera(61, 47, 60.0, 61.0, 29.6, 22.8, (0.1, -0.05, 0.001, -0.002, 0.01))
    T = scenes.look_at(np.array([0.5, 0.1, 0.2]), CENTRE)
    wall = scenes.plane(camera, T, np.array([-0.15, 0.0, 0.0]), np.array([0.9, 0.1, 0.3]))
    depth = np.fmin(wall, scenes.sphere(camera, T, CENTRE, RADIUS))
    depth[5:9, 11:20] = np.nan
    volume = Volume(VolumeSettings(0.01, 0.04))
    volume.integrate(depth, camera, T)
    return volume, camera, T, depth


@pytest.mark.parametrize("name", CAMERAS)
def test_a_sphere_comes_back(name):
    mesh = whole_sphere(CAMERAS[name]).surface(min_weight=0.5)
    error = np.linalg.norm(mesh.vertices - CENTRE, axis=1) - RADIUS
    # pixels of 3 mm seen at a slant on voxels of 5 mm: interpolation of a curved field leaves some hundredths
    assert np.median(np.abs(error)) < 0.05 * SETTINGS.voxel
    assert abs(np.median(error)) < 0.03 * SETTINGS.voxel


def test_a_whole_sphere_is_watertight_and_outward(sphere):
    mesh = sphere.surface()
    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert solid.is_watertight and solid.is_winding_consistent and solid.euler_number == 2
    # 20 voxels across the radius: a few hundredths of a voxel in radius are about half a percent of volume
    assert solid.volume == pytest.approx(4 / 3 * np.pi * RADIUS**3, rel=0.01)
    outward = (mesh.vertices - CENTRE) / np.linalg.norm(mesh.vertices - CENTRE, axis=1, keepdims=True)
    cosine = (outward * mesh.normals).sum(axis=1)
    assert cosine.min() > 0.8 and np.median(cosine) > np.cos(np.radians(4))


@pytest.mark.parametrize("slant", [0.0, 30.0, 60.0])
@pytest.mark.parametrize("name", CAMERAS)
def test_a_plane_comes_back_at_any_slant(name, slant):
    camera, point = CAMERAS[name], np.array([0.003, 0.001, 0.502])
    normal = np.array([np.sin(np.radians(slant)), 0.05, -np.cos(np.radians(slant))])
    normal /= np.linalg.norm(normal)
    depth = scenes.plane(camera, np.eye(4), point, normal)
    depth[depth > 0.8] = np.nan
    volume = Volume(SETTINGS)
    volume.integrate(depth, camera, np.eye(4))
    mesh = volume.surface(min_weight=0.5)
    # a plane is nearly linear in the pixel, so only the interpolation of z instead of 1/z remains
    assert np.median(np.abs((mesh.vertices - point) @ normal)) < 0.02 * SETTINGS.voxel
    assert np.median(mesh.normals @ normal) > 0.99


@pytest.mark.parametrize("name", CAMERAS)
def test_raycast_gives_back_what_went_in(name):
    camera = CAMERAS[name]
    volume = whole_sphere(camera)
    T = scenes.look_at(CENTRE + np.array([0.3, 0.15, 0.2]), CENTRE)
    truth, seen = scenes.sphere(camera, T, CENTRE, RADIUS), volume.raycast(camera, T)
    inner = np.isfinite(truth) & np.isfinite(seen.depth)
    assert inner.sum() > 0.97 * np.isfinite(truth).sum()
    # the rim, seen along the surface, is where depth differs most; most of the disc is close
    assert np.median(np.abs(seen.depth - truth)[inner]) < 0.1 * SETTINGS.voxel
    assert np.allclose(seen.points[inner][:, 2], seen.depth[inner])
    local = CENTRE - T[:3, 3]
    outward = seen.points - local @ T[:3, :3]
    outward /= np.linalg.norm(outward, axis=-1, keepdims=True)
    cosine = (outward * seen.normals).sum(-1)
    assert np.nanmedian(cosine) > np.cos(np.radians(4))
    towards = (seen.normals * seen.points).sum(-1)
    assert (towards[np.isfinite(towards)] < 0).all()


def test_integrate_equals_its_twin(one_view):
    volume, camera, T, depth = one_view
    blocks = volume.blocks.coordinates[: volume.block_count : 4]  # every fourth: the twin is slow
    twin = integrate_twin(blocks, depth, camera, T, 0.01, 0.04).reshape(len(blocks), -1, 2)
    found = by_voxel(volume.blocks.voxels[: volume.block_count : 4])
    # single precision may put a voxel on the other side of a rounding limit (pixel, edge, truncation)
    distance = np.isclose(found[..., 0], twin[..., 0], rtol=8e-3, atol=2e-6)  # scale and slopes are rounded
    weight = np.isclose(found[..., 1], twin[..., 1], rtol=8e-3)  # two factors of one part in 256 each
    assert (distance & weight).mean() > 0.999
    assert np.median(np.abs(found - twin)[..., 0]) < 1e-5  # [m] a thousandth of a voxel


def test_every_voxel_near_the_surface_has_a_block(one_view):
    volume, camera, T, depth = one_view
    points = camera.points(depth)[np.isfinite(depth)].astype(float)
    for share in np.linspace(-1, 1, 9):  # the whole band along the ray
        moved = points * (1 + share * 0.04 / points[:, 2:]) @ T[:3, :3].T + T[:3, 3]
        voxels = np.round(moved / 0.01)  # those that the same pixel sees at a depth within the band
        local = (voxels * 0.01 - T[:3, 3]) @ T[:3, :3]
        u, v = np.round(camera.project(local)).astype(int).T.clip(0, np.array([[60], [46]]))
        near = np.abs(depth[v, u] - local[:, 2]) < 0.04
        assert near.mean() > 0.4  # at the ends, rounding leads half of them out of the band
        assert (volume.blocks.find(np.floor(voxels[near] / 8).astype(np.int32)) >= 0).all()


def test_fusing_marks_the_same_octants(one_view):
    blocks = one_view[0].blocks
    found = blocks.solid[: blocks.count].copy()
    blocks.mark(slice(0, blocks.count))
    assert (found == blocks.solid[: blocks.count]).all() and found.any()


def test_raycast_equals_its_twin(one_view):
    volume, camera, T, _ = one_view
    seen = volume.raycast(camera, T, near=0.2, far=1.5).depth
    rng = np.random.default_rng(0)
    pixels = [(int(v), int(u)) for v, u in zip(rng.integers(0, 47, 12), rng.integers(0, 61, 12), strict=True)]
    twin = np.array([raycast_twin(volume, camera, T, pixel, (0.2, 1.5)) for pixel in pixels])
    found = np.array([seen[pixel] for pixel in pixels])
    both = np.isfinite(twin) & np.isfinite(found)
    # a ray that grazes an unseen voxel may end on either side of it: one in twelve may differ
    assert (np.isfinite(twin) != np.isfinite(found)).sum() <= 1 and both.sum() >= 6
    assert np.sort(np.abs(twin - found)[both])[: both.sum() - 1].max() < 1e-2 * 0.01


def test_surface_equals_its_twin(one_view):
    volume = one_view[0]
    found, twin = volume.surface().vertices, crossings_twin(volume)
    assert len(found) == len(twin) > 200
    assert cKDTree(twin).query(found)[0].max() < 1e-6  # [m] single against double precision


def test_a_torn_field_has_the_triangles_of_its_known_cells():
    """Random signs and unseen voxels across blocks, some missing: every row of eight voxels meets every neighbour."""
    rng = np.random.default_rng(1)
    volume = Volume(VolumeSettings(1.0, 4.0))
    places = np.argwhere(rng.random((3, 3, 3)) < 0.8).astype(np.int32)
    volume.blocks.insert(places)
    weight = np.zeros((24, 24, 24), np.float32)
    distance = rng.choice([-1.0, 1.0], weight.shape).astype(np.float32)
    for n, (x, y, z) in enumerate(places * 8):
        weight[x : x + 8, y : y + 8, z : z + 8] = rng.random((8, 8, 8)) < 0.95
        block = np.s_[x : x + 8, y : y + 8, z : z + 8]
        rows = np.stack([distance[block] * weight[block], weight[block]], axis=2)  # (8, 8, 2, 8)
        volume.blocks.voxels[n] = rows.reshape(64, 2, 8)
    mesh = volume.surface()
    corners = [np.s_[o // 4 : o // 4 + 23, o // 2 % 2 : o // 2 % 2 + 23, o % 2 : o % 2 + 23] for o in range(8)]
    known = np.all([weight[c] > 0 for c in corners], axis=0)
    case = sum((distance[c] < 0).astype(int) << o for o, c in enumerate(corners))[known]
    assert len(mesh.faces) == ((table()[case] >= 0).sum(axis=1) // 3).sum()
    assert np.array_equal(np.unique(mesh.faces), np.arange(len(mesh.vertices)))  # each vertex once, none for nothing
    size = np.linalg.norm(np.ptp(mesh.vertices[mesh.faces], axis=1), axis=1)
    assert size.max() <= np.sqrt(3)  # [m] no triangle leaves its cell of one metre


def test_sample_is_the_field(sphere):
    mesh = sphere.surface(min_weight=0.5)
    distance, gradient, weight = sphere.sample(mesh.vertices)
    # vertices lie on voxel edges, where the trilinear field is linear: zero to rounding
    assert np.nanmax(np.abs(distance)) < 1e-4 * SETTINGS.voxel * 20
    assert (weight[np.isfinite(distance)] > 0).all()
    cosine = (gradient * mesh.normals).sum(1) / np.linalg.norm(gradient, axis=1)
    assert np.nanmedian(cosine) > 0.99  # slope within one cell against central differences
    nothing = sphere.sample(np.array([[5.0, 0, 0], [np.nan, 0, 0], [1e9, 0, 0], [np.inf, 0, 0]]))
    assert np.isnan(nothing[0]).all() and np.isnan(nothing[1]).all() and (nothing[2] == 0).all()


def test_sums_are_sums():
    camera = CAMERAS["pinhole"]
    poses = scenes.around(CENTRE, 0.4)[:9]
    settings = VolumeSettings(0.005, 0.02, color=True)
    parts = [Volume(settings) for _ in range(3)]
    whole = Volume(settings)
    for n, T in enumerate(poses):
        depth = scenes.sphere(camera, T, CENTRE, RADIUS)
        color = np.full((*camera.shape, 3), 20 * n, np.uint8)
        parts[n % 3].integrate(depth, camera, T, color=color)
        whole.integrate(depth, camera, T, color=color)

    def total(*order):
        volume = Volume(settings)
        for n in order:
            volume.add(parts[n])
        return volume

    left, right = total(0, 1, 2), total(2, 1, 0)
    # a block that one part lacks has not been carved by that part's frames: compare what all of them hold
    assert left.block_count == right.block_count == whole.block_count
    ids = right.blocks.find(left.blocks.coordinates[: left.block_count])
    assert np.allclose(left.blocks.voxels[: left.block_count], right.blocks.voxels[ids], rtol=1e-6, atol=1e-7)
    assert np.allclose(left.blocks.colors[: left.block_count], right.blocks.colors[ids], rtol=1e-6, atol=1e-3)


def test_parts_of_the_same_blocks_add_up_to_the_whole():
    camera, T = CAMERAS["odd and distorted"], scenes.around(CENTRE, 0.4)[4]
    depth = scenes.sphere(camera, T, CENTRE, RADIUS)
    whole, part = Volume(SETTINGS), Volume(SETTINGS)
    for shift in (0.0, 0.001, 0.002, 0.003):
        whole.integrate(depth + np.float32(shift), camera, T)
    part.integrate(depth, camera, T)
    part.integrate(depth + np.float32(0.001), camera, T)
    other = Volume(SETTINGS)
    other.integrate(depth + np.float32(0.002), camera, T)
    other.integrate(depth + np.float32(0.003), camera, T)
    part.add(other)
    common = part.blocks.find(whole.blocks.coordinates[: whole.block_count])
    assert (common >= 0).all()
    same = np.isclose(part.blocks.voxels[common], whole.blocks.voxels[: whole.block_count], rtol=1e-5, atol=1e-6)
    # blocks first touched by a later frame miss the earlier frames in the whole as in the parts, but not equally
    assert same.mean() > 0.97
    mesh, twin = part.surface(0.5), whole.surface(0.5)
    assert np.median(cKDTree(twin.vertices).query(mesh.vertices)[0]) < 1e-6


def test_volumes_that_differ_do_not_add():
    with pytest.raises(VolumeError, match="do not add up"):
        Volume(SETTINGS).add(Volume(VolumeSettings(0.004, 0.02)))


def test_two_opposite_cameras_see_both_sides():
    camera, volume = CAMERAS["pinhole"], Volume(SETTINGS)
    for side in (1.0, -1.0):
        T = scenes.look_at(CENTRE + np.array([0.4 * side, 0.0, 0.0]), CENTRE)
        volume.integrate(scenes.sphere(camera, T, CENTRE, RADIUS), camera, T)
    x = volume.surface().vertices[:, 0] - CENTRE[0]
    assert x.max() > 0.99 * RADIUS and x.min() < -0.99 * RADIUS


def test_free_space_is_carved_and_missing_pixels_carve_nothing():
    camera, T = CAMERAS["pinhole"], np.eye(4)
    volume = Volume(SETTINGS)
    volume.integrate(np.full(camera.shape, 0.5, np.float32), camera, T)
    volume.integrate(np.full(camera.shape, np.nan, np.float32), camera, T)
    assert np.nanmedian(volume.raycast(camera, T).depth) == pytest.approx(0.5, abs=1e-5)
    for _ in range(9):
        volume.integrate(np.full(camera.shape, 0.9, np.float32), camera, T)
    # nine looks through the first wall outvote the one that saw it
    inner = volume.raycast(camera, T).depth[20:-20, 20:-20]
    assert np.median(inner) == pytest.approx(0.9, abs=1e-5)


def test_what_is_no_depth_is_ignored():
    camera, T = CAMERAS["pinhole"], np.eye(4)
    clean, dirty = Volume(SETTINGS), Volume(SETTINGS)
    depth = np.full(camera.shape, 0.5, np.float32)
    holes = depth.copy()
    holes[10:14, 20:90] = np.nan
    clean.integrate(holes, camera, T)
    for n, bad in enumerate([np.inf, -np.inf, -0.5, 0.0, 1.7e7, np.nan]):
        holes[10:14, 20 + 10 * n : 30 + 10 * n] = bad
    dirty.integrate(holes, camera, T)
    assert dirty.block_count == clean.block_count
    assert np.array_equal(dirty.blocks.voxels[: clean.block_count], clean.blocks.voxels[: clean.block_count])
    nothing = Volume(SETTINGS)
    nothing.integrate(depth, camera, T, weight=np.zeros(camera.shape, np.float32))
    nothing.integrate(depth, camera, T, weight=np.full(camera.shape, np.nan, np.float32))
    assert nothing.block_count == 0


def test_weights_weigh():
    camera, T = CAMERAS["pinhole"], np.eye(4)
    volume = Volume(SETTINGS)
    for z, w in ((0.500, 3.0), (0.504, 1.0)):
        volume.integrate(np.full(camera.shape, z, np.float32), camera, T, weight=np.full(camera.shape, w, np.float32))
    assert np.nanmedian(volume.raycast(camera, T).depth) == pytest.approx(0.501, abs=2e-5)


def test_color_is_kept():
    volume = Volume(VolumeSettings(0.005, 0.02, color=True))
    camera, T = CAMERAS["pinhole"], scenes.around(CENTRE, 0.4)[3]
    color = np.full((*camera.shape, 3), (200, 100, 50), np.uint8)
    volume.integrate(scenes.sphere(camera, T, CENTRE, RADIUS), camera, T, color=color)
    mesh, seen = volume.surface(), volume.raycast(camera, T)
    assert (mesh.colors == [200, 100, 50]).all()
    assert (seen.colors[np.isfinite(seen.depth)] == [200, 100, 50]).mean() > 0.95


def test_memory_runs_out_before_anything_is_fused():
    camera, T = CAMERAS["pinhole"], np.eye(4)
    volume = Volume(VolumeSettings(0.005, 0.02, max_bytes=3 << 20))
    volume.integrate(np.where(np.arange(160) < 60, 0.5, np.nan)[None].repeat(120, 0), camera, T)
    before, count = volume.blocks.voxels[: volume.block_count].copy(), volume.block_count
    with pytest.raises(VolumeError, match="take voxels of at least"):
        volume.integrate(np.full(camera.shape, 3.0, np.float32), camera, T)
    assert volume.block_count == count and np.array_equal(volume.blocks.voxels[:count], before)
    assert volume.bytes <= 3 << 20


def test_bounds_bound():
    camera, T = CAMERAS["pinhole"], np.eye(4)
    low, high = (-0.05, -0.05, 0.4), (0.05, 0.05, 0.6)
    volume = Volume(VolumeSettings(0.005, 0.02, bounds=(low, high)))
    volume.integrate(np.full(camera.shape, 0.5, np.float32), camera, T)
    vertices = volume.surface().vertices
    # whole blocks of 40 mm are kept at the border
    assert (vertices > np.array(low) - 0.04).all() and (vertices < np.array(high) + 0.04).all() and len(vertices)


def test_an_empty_volume_is_empty():
    volume = Volume(SETTINGS)
    mesh = volume.surface()
    assert mesh.vertices.shape == (0, 3) and mesh.faces.shape == (0, 3)
    seen = volume.raycast(CAMERAS["pinhole"], np.eye(4))
    assert np.isnan(seen.depth).all() and np.isnan(seen.points).all() and np.isnan(seen.normals).all()
    assert np.isnan(volume.sample(np.zeros((2, 3)))[0]).all()
    volume.add(Volume(SETTINGS))
    assert volume.block_count == 0


def test_wrong_use_is_told():
    camera, volume = CAMERAS["pinhole"], Volume(SETTINGS)
    with pytest.raises(VolumeError, match="does not fit the camera"):
        volume.integrate(np.ones((5, 5), np.float32), camera, np.eye(4))
    with pytest.raises(VolumeError, match="not a rigid motion"):
        volume.integrate(np.ones(camera.shape, np.float32), camera, np.full((4, 4), np.nan))
    for voxel, truncation in ((0.0, 1.0), (np.nan, 1.0), (0.01, 0.001), (0.01, np.inf)):
        with pytest.raises(VolumeError):
            VolumeSettings(voxel, truncation)


def test_save_and_load(tmp_path, sphere):
    sphere.save(tmp_path / "volume.npz")
    again = Volume.load(tmp_path / "volume.npz")
    assert again.settings == sphere.settings
    assert np.array_equal(again.surface().vertices, sphere.surface().vertices)
    (tmp_path / "broken.npz").write_bytes(b"PK no")
    for name in ("broken.npz", "absent.npz"):
        with pytest.raises(VolumeError, match="the volume cannot be read"):
            Volume.load(tmp_path / name)


def test_far_from_the_origin_and_rotated():
    camera, shift = CAMERAS["pinhole"], np.array([3.0, -2.0, 1.5])
    T = scenes.look_at(np.array([0.3, 0.2, 0.2]) + shift, shift)
    volume = Volume(SETTINGS)
    volume.integrate(scenes.sphere(camera, T, shift, RADIUS), camera, T)
    error = np.linalg.norm(volume.surface(0.5).vertices - shift, axis=1) - RADIUS
    assert np.median(np.abs(error)) < 0.05 * SETTINGS.voxel
