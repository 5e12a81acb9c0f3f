"""Shapes that are nearly symmetric: a small feature tells the right pose, or nothing does and that is said."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from fusion.mesh.alignment.align import align_meshes
from fusion.mesh.comparison.compare import CompareSettings, compare
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_kept
from fusion.results.comparison import judge_comparison

FEW = CompareSettings(samples=10_000)
NOISE = 3e-4  # [m]


def _made(shape) -> Mesh:
    return Mesh(np.array(shape.vertices, np.float64), np.array(shape.faces, np.int32))


def _scan(reference: Mesh, seen, seed: int, scale: float = 1.0):
    """Of the part that is `seen`, with noise, and moved; the rotation."""
    fine = trimesh.Trimesh(*trimesh.remesh.subdivide_to_size(reference.vertices, reference.faces, 0.004))
    part = vertices_kept(_made(fine), seen(fine.vertices))
    rough = np.random.default_rng(seed).normal(0, NOISE, part.vertices.shape)
    turn = Rotation.random(random_state=seed).as_matrix()
    return replace(part, vertices=scale * (part.vertices + rough) @ turn.T + [0.3, -0.4, 1.2]), turn


def _off_deg(T, turn) -> float:
    return float(np.rad2deg(np.linalg.norm(Rotation.from_matrix(T[:3, :3] @ turn).as_rotvec())))


def _prism() -> Mesh:
    """A hexagonal prism 0.1 m high, one of its sides with a pocket 8 mm deep, closed."""
    prism = trimesh.creation.cylinder(0.05, 0.1, sections=6)
    fine = trimesh.Trimesh(*trimesh.remesh.subdivide_to_size(prism.vertices, prism.faces, 0.004))
    face = fine.face_normals[np.argmax(fine.face_normals[:, 0])]
    middle = 0.05 * np.cos(np.pi / 6) * face + [0, 0, 0.02]
    away = fine.vertices - middle
    pocket = (np.abs(away @ face) < 1e-6) & (np.abs(away - (away @ face)[:, None] * face).max(axis=1) < 0.009)
    return Mesh(fine.vertices - 0.008 * pocket[:, None] * face, np.array(fine.faces, np.int32))


@pytest.mark.parametrize("seed", [1, 2])
def test_a_pocket_tells_one_side_of_a_prism_from_the_others(seed):
    reference = _prism()
    scan, turn = _scan(reference, lambda at: at[:, 2] > -0.049, seed)
    found = align_meshes(scan, reference)
    assert _off_deg(found.T_reference_mesh, turn) < 0.5
    assert not found.turns


def test_a_symmetric_part_is_said_to_be_so():
    """A box without a lid, seen from one corner: turned by 180 degrees it is the same."""
    outer = trimesh.creation.box((0.16, 0.1, 0.08))
    scan, _ = _scan(_made(outer), lambda at: (at[:, 0] > 0.0799) | (at[:, 1] > 0.0499) | (at[:, 2] > 0.0399), 3)
    found = align_meshes(scan, _made(outer))
    assert found.status == "moved" and any(abs(np.rad2deg(turn) - 180) < 2 for turn in found.turns)


def test_a_spiked_thin_plate_lies_on_its_own_side():
    plate = _made(trimesh.creation.box((0.2, 0.14, 0.004)))
    scan, turn = _scan(plate, lambda at: at[:, 2] > 0.0019, 5)
    spiked = np.random.default_rng(5).random(len(scan.vertices)) < 0.02
    up = turn @ [0.0, 0.0, 1.0]
    scan = replace(scan, vertices=scan.vertices + spiked[:, None] * 0.03 * up)
    found = compare(scan, plate, replace(FEW, max_distance=0.003))
    assert abs(found.accuracy.median) < 3e-4 and found.alignment.slides == 0
    assert found.completeness_all.mean_signed == pytest.approx(-0.002, abs=3e-4)


def test_a_small_object_on_a_large_table_is_found():
    """A fifth of the mesh is the object, which it shows nearly whole."""
    bumps = trimesh.creation.icosphere(4, 0.05)
    x, y, z = np.asarray(bumps.vertices).T / 0.05
    shape = 1 + 0.2 * np.sin(3 * x + 1) + 0.15 * np.cos(4 * y - z) + 0.1 * np.sin(5 * z + 2 * x)
    thing = Mesh(np.asarray(bumps.vertices) * shape[:, None], np.array(bumps.faces, np.int32))
    low = thing.vertices[:, 2].min()
    table = trimesh.creation.box((0.36, 0.36, 0.001)).subdivide_to_size(0.01)
    table.apply_translation([0.06, 0.02, low])
    scan = trimesh.util.concatenate([trimesh.Trimesh(thing.vertices, thing.faces), table])
    moved, turn = _scan(_made(scan), lambda at: at[:, 2] > low + 0.0004, 7, scale=1.01)
    found = compare(moved, thing, replace(FEW, scale=True))
    assert found.alignment.status == "moved" and _off_deg(found.T_reference_mesh, turn) < 0.5
    assert found.scale == pytest.approx(1 / 1.01, abs=0.002)
    (bias,) = [light for light in judge_comparison(found).lights if light.subject == "Bias"]
    assert "--max-distance" in bias.do and "--scale" not in bias.do


def test_scale_is_judged_only_where_it_was_asked_for():
    ball = _made(trimesh.creation.icosphere(3, 0.05))
    found = compare(ball, ball, replace(FEW, align=False))
    assert "Scale" not in [light.subject for light in judge_comparison(found).lights]
    told = found.to_dict() | {"scale": 1.012, "scale_interval": [0.99, 1.034]}
    (light,) = [light for light in judge_comparison(told).lights if light.subject == "Scale"]
    assert light.level == "ok" and "0.99000 to 1.03400" in light.reason
    (light,) = [
        one for one in judge_comparison(told | {"scale_interval": [1.01, 1.014]}).lights if one.subject == "Scale"
    ]
    assert light.level == "bad"
