"""Light by way of the plate: how far it reaches, what it does to a block, and that it is taken out."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.mesh.mesh import Mesh
from fusion.recording.recording import Frame
from fusion.scan.cleaning.plate_light import plate_light, plate_reach, without
from fusion.simulation.rendering.casting import Body
from fusion.simulation.rendering.render import RayCaster, view_of
from fusion.volume.prepared import Prepared

CAMERA = Camera(120, 100, 150.0, 150.0, 59.5, 49.5, principle="itof")
HIGH, HALF, RADIUS = 0.12, 0.04, 0.15
FRAMES = 8


def block():
    """Its sides and top in cells of a centimetre, normals outwards."""
    vertices, faces, normals = [], [], []
    a, z = np.linspace(-HALF, HALF, 9), np.linspace(0, HIGH, 13)
    for turn in range(4):
        c, s = np.cos(turn * np.pi / 2), np.sin(turn * np.pi / 2)
        R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        grid = np.array([[x, -HALF, h] for h in z for x in a]) @ R.T
        start = sum(map(len, vertices))
        for i in range(12):
            for j in range(8):
                k = start + 9 * i + j
                faces += [[k, k + 1, k + 10], [k, k + 10, k + 9]]
        vertices.append(grid)
        normals.append(np.tile(R @ [0, -1, 0], (len(grid), 1)))
    start = sum(map(len, vertices))
    vertices.append(
        np.array([[-HALF, -HALF, HIGH], [HALF, -HALF, HIGH], [HALF, HALF, HIGH], [-HALF, HALF, HIGH], [0, 0, HIGH]])
    )
    normals.append(np.tile([0, 0, 1.0], (5, 1)))
    faces += [[start + k, start + (k + 1) % 4, start + 4] for k in range(4)]
    return Mesh(np.vstack(vertices), np.array(faces, np.int32), np.vstack(normals).astype(np.float32))


def disc():
    angle = np.linspace(0, 2 * np.pi, 61)[:-1]
    rim = np.column_stack([RADIUS * np.cos(angle), RADIUS * np.sin(angle), np.zeros(60)])
    faces = np.column_stack([np.zeros(60), 1 + np.arange(60), 1 + (np.arange(60) + 1) % 60])
    return Mesh(np.vstack([np.zeros(3), rim]), faces.astype(np.int32))


def looking(angle):
    centre = 0.6 * np.array([np.cos(angle) * 0.87, np.sin(angle) * 0.87, 0.5])
    z = (np.array([0, 0, 0.05]) - centre) / np.linalg.norm(np.array([0, 0, 0.05]) - centre)
    x = np.cross(z, [0, 0, 1])
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3] = np.stack([x, np.cross(z, x), z, centre], axis=1)
    return T


@pytest.fixture(scope="module")
def scene():
    bodies = (Body(RayCaster(block())), Body(RayCaster(disc())))
    poses = np.array([looking(a) for a in np.linspace(0, 2 * np.pi, FRAMES, endpoint=False) + 0.3])
    frames = []
    for i, T in enumerate(poses):
        depth = view_of(bodies, CAMERA, T).depth.astype(np.float32)
        surface = point_map(depth, CAMERA, np.full(depth.shape, 0.001, np.float32))
        frames.append(Prepared(depth, surface, np.ones_like(depth), Frame(i, i / 10, depth)))
    return frames, poses


def test_the_plate_is_found_to_its_rim(scene):
    frames, poses = scene
    assert plate_reach(frames[0].depth, CAMERA, poses[0], 0.06) == pytest.approx(RADIUS, abs=0.015)


def test_sides_near_the_plate_are_the_most_wrong_and_the_top_is_not(scene):
    mesh, light = block(), plate_light(block(), *scene, 0.07, 0.5)
    z, side = mesh.vertices[:, 2], np.abs(mesh.normals[:, 2]) < 0.5
    low, high = (np.median(light.offset[side & (z > a) & (z < b)]) for a, b in ((0.005, 0.035), (0.085, 0.115)))
    assert 1e-4 < low < 4e-3 and 0 <= high < 0.5 * low
    assert abs(light.offset[-1]) < 0.05 * low  # the middle of the top


def test_a_plate_that_reflects_half_as_much_does_half_of_it(scene):
    whole, half = (plate_light(block(), *scene, RADIUS, share).offset for share in (0.6, 0.3))
    np.testing.assert_allclose(half.mean(), whole.mean() / 2, rtol=0.08)  # phasors of two paths are not quite a sum


def test_it_is_taken_out_along_the_normals_only_where_it_was_told(scene):
    mesh = block()
    light = plate_light(mesh, *scene, RADIUS, 0.5)
    moved = without(mesh, light)
    np.testing.assert_allclose(np.sum((moved.vertices - mesh.vertices) * mesh.normals, axis=1), light.offset, atol=1e-7)
    assert light.taken_out and "taken out" in str(light)
    unknown = plate_light(mesh, *scene, RADIUS)
    assert not unknown.taken_out and "--plate-reflectance" in str(unknown)
