"""Comparison with a reference: laws on made shapes whose distances, pose and scale are known."""

import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from fusion.commands.main import main
from fusion.errors import MeshError
from fusion.mesh.alignment.align import Alignment, align_meshes
from fusion.mesh.alignment.similarity import IDENTITY
from fusion.mesh.alignment.units import UNITS, in_metres
from fusion.mesh.comparison.compare import CompareSettings, compare, write_comparison
from fusion.mesh.comparison.distances import surface_of
from fusion.mesh.comparison.mirrored import mirrored, mirrored_note
from fusion.mesh.comparison.surface_samples import sample_surface
from fusion.mesh.files import read_mesh, write_mesh
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_kept
from fusion.results.comparison import judge_comparison

STAND = CompareSettings(align=False, samples=20_000)
FEW = CompareSettings(samples=10_000)


def _made(shape):
    return Mesh(np.array(shape.vertices, np.float64), np.array(shape.faces, np.int32))


def _ball(radius):
    return _made(trimesh.creation.icosphere(4, radius))


def _object(rounds=4):
    """A bumpy shape of 0.2 m without symmetry, closed."""
    ball = trimesh.creation.icosphere(rounds, 0.1)
    x, y, z = np.asarray(ball.vertices).T / 0.1
    bumps = 1 + 0.2 * np.sin(3 * x + 1) + 0.15 * np.cos(4 * y - z) + 0.1 * np.sin(5 * z + 2 * x)
    return Mesh(np.asarray(ball.vertices) * bumps[:, None] * [1.0, 0.8, 0.6], np.asarray(ball.faces, np.int32))


def _moved(mesh, seed=3, scale=1.0):
    turn = Rotation.random(random_state=seed).as_matrix()
    return replace(mesh, vertices=scale * mesh.vertices @ turn.T + [0.3, -0.4, 1.2]), turn


def _turn_error_deg(T, turn):
    return np.rad2deg(np.linalg.norm(Rotation.from_matrix(T[:3, :3] @ turn.T).as_rotvec()))


def test_larger_ball_stands_outside_by_the_difference():
    found = compare(_ball(0.102), _ball(0.100), STAND)
    # the facets of an icosphere of 5120 faces lie up to 0.05 % of the radius below it, on both balls alike: 0.01 mm
    assert found.accuracy.mean_signed == pytest.approx(0.002, abs=1e-5)
    assert found.completeness.mean_signed == pytest.approx(-0.002, abs=1e-5)  # the reference is inside the mesh
    assert found.accuracy.std < 1e-4
    assert found.accuracy.within["0.001"] == 0
    assert found.fscore["0.005"] == 1
    assert np.mean(found.mesh.scalars["signed_distance"]) == pytest.approx(0.002, abs=2e-5)
    assert sum(found.histogram["counts"]) == STAND.samples


@pytest.mark.parametrize("turned", [0.02, 2.0])
def test_a_pose_that_is_said_to_be_near_is_refined_or_looked_for(turned):
    shape = _object()
    turn = Rotation.from_rotvec([0.0, 0.0, turned]).as_matrix()
    moved = replace(shape, vertices=shape.vertices @ turn.T + [0.001, -0.002, 0.001])
    near = compare(moved, shape, replace(FEW, near=True))
    assert _turn_error_deg(near.T_reference_mesh, turn.T) < 0.05
    assert near.accuracy.rms == pytest.approx(compare(moved, shape, FEW).accuracy.rms, abs=2e-5)
    assert near.alignment.status == ("kept" if turned < 0.1 else "moved")


def test_samples_are_even_over_area_not_over_triangles():
    near, far = trimesh.creation.box((1, 1, 1e-4)), trimesh.creation.box((1, 1, 1e-4))
    for _ in range(4):
        near = near.subdivide()  # 256 times the triangles of the far plate
    far.apply_translation([0, 0, 0.01])
    both = _made(trimesh.util.concatenate([near, far]))
    found = compare(both, _made(near), replace(STAND, max_distance=0.1))
    # two plates of equal area; 20 000 stratified samples leave less than 1 %
    assert found.accuracy.within["0.005"] == pytest.approx(0.5, abs=0.01)


def test_what_was_seen_tells_a_box_from_the_same_one_upside_down():
    """A scan without a bottom fits a box both ways; where it ought to be seen, it can stand one way only."""
    box = trimesh.creation.box((0.10, 0.14, 0.18))
    for _ in range(4):
        box = box.subdivide()
    whole, points = _made(box), np.asarray(trimesh.sample.sample_surface(box, 4000, seed=0)[0])
    seen = points[points[:, 2] > -0.089]
    scan = box.submesh([np.flatnonzero(box.triangles_center[:, 2] > -0.089)], append=True)
    for seed in range(4):
        moved, turn = _moved(_made(scan), seed=seed)
        found = compare(moved, whole, replace(CompareSettings(), samples=5000, seen=seen))
        up = found.alignment.T_reference_mesh[:3, :3] @ turn @ [0, 0, 1]
        assert up[2] > 0.999 and found.completeness.within["0.005"] > 0.999


@pytest.mark.slow
def test_pose_and_scale_are_recovered():
    mesh = _object(3)
    reference, turn = _moved(mesh, 3, 1.02)
    found, again = (align_meshes(mesh, reference, scale=True) for _ in range(2))
    assert _turn_error_deg(found.T_reference_mesh, turn) < 0.05
    assert found.scale == pytest.approx(1.02, rel=2e-4)
    assert np.linalg.norm(found.T_reference_mesh[:3, 3] - [0.3, -0.4, 1.2]) < 1e-4
    assert found.status == "moved"
    assert np.array_equal(found.T_reference_mesh, again.T_reference_mesh)  # chance has no say


@pytest.mark.slow
def test_scale_interval_holds_the_scale_under_noise():
    mesh = _object()
    reference, _ = _moved(mesh, 5, 0.985)
    rng = np.random.default_rng(0)
    noisy = replace(mesh, vertices=mesh.vertices + rng.normal(0, 5e-4, mesh.vertices.shape))
    found = align_meshes(noisy, reference, scale=True)
    low, high = found.scale_interval
    assert low < 0.985 < high
    assert high - low < 0.01  # 0.5 mm of noise on 2562 vertices of a 0.2 m object says the scale well below 1 %


@pytest.mark.slow
def test_good_pose_of_a_symmetric_shape_stays():
    box = _made(trimesh.creation.box((0.2, 0.2, 0.2)))
    found = align_meshes(box, box)
    assert found.status == "kept"
    assert np.abs(found.T_reference_mesh - np.eye(4)).max() < 1e-5  # float32 closest points


UNIT_NAMES = {"cm": "centimetres", "mm": "millimetres", "inch": "inches"}


@pytest.mark.parametrize("unit", UNIT_NAMES)
def test_units_are_recognised_and_can_be_named(unit):
    mesh = _object(3)
    reference = replace(mesh, vertices=mesh.vertices / UNITS[unit])
    found = compare(mesh, reference, replace(STAND, seen=reference.vertices[:50]))
    assert UNIT_NAMES[unit] in found.notes[0] and "--unit" in found.notes[0]
    assert found.accuracy.rms < 1e-6
    assert found.completeness.rms < 1e-6
    named = compare(mesh, reference, replace(STAND, unit=unit))
    assert named.notes == () and named.accuracy.rms < 1e-6
    assert compare(reference, mesh, STAND).accuracy.rms < 1e-6  # the mesh in another unit


def test_a_unit_that_makes_the_reference_tiny_is_refused():
    """Both are in metres: a reference of 0.3 mm would make a millimetre of the mesh as well, and all would fit."""
    mesh = _object(3)
    with pytest.raises(MeshError, match="too small in its stated unit"):
        compare(mesh, mesh, replace(STAND, unit="mm"))


@pytest.mark.parametrize("times", [15, 62, 250])
def test_sizes_that_tell_no_unit_are_said(times):
    mesh = _object(2)
    other = replace(mesh, vertices=mesh.vertices * times)
    for pair in ((mesh, other), (other, mesh)):
        *_, factors, notes = in_metres(*pair)
        assert factors == (1, 1)
        assert "--unit" in notes[0] and "differ much" in notes[0]


@pytest.mark.parametrize("part", [0.5, 1.0, 1.8])
def test_units_are_told_from_a_part_or_with_a_plate(part):
    """The scan shows less than the reference, or has a plate that is larger than the object."""
    mesh = _object(2)
    for unit in ("cm", "mm", "inch"):
        reference = replace(mesh, vertices=mesh.vertices / UNITS[unit] / part)
        factors, notes = in_metres(mesh, reference)[2:]
        # never the wrong one: told right, or said to be unclear
        assert factors == (1, UNITS[unit]) or (factors == (1, 1) and "--unit" in notes[0])


@pytest.mark.slow
def test_partial_scan_is_aligned_and_the_rest_counts_as_never_seen():
    whole = _object()
    part = vertices_kept(whole, whole.vertices[:, 2] + 0.3 * whole.vertices[:, 0] > -0.005)
    reference, turn = _moved(whole, 4)
    found = compare(part, reference, FEW)
    assert _turn_error_deg(found.T_reference_mesh, turn) < 0.05
    assert found.accuracy.rms < 1e-4
    assert 0.2 < found.unseen_share < 0.6
    # what is left out begins 10 mm behind the border: what stays is within that
    assert found.completeness.max <= 0.0101
    assert found.completeness_all.max > 0.02
    assert any("never seen" in note for note in found.notes)


def test_what_an_open_reference_cannot_judge_is_said():
    """A whole scan against a view of one side: the rest is no error, and its side is not known."""
    whole = _object(3)
    reference = vertices_kept(whole, whole.vertices[:, 2] > 0)
    found = compare(whole, reference, STAND)
    assert any("beyond where the reference ends" in note and "--max-distance" in note for note in found.notes)
    left = compare(whole, reference, replace(STAND, max_distance=0.01))
    assert left.accuracy.median < 1e-6 and not any("beyond where" in note for note in left.notes)


def test_missing_part_of_a_closed_scan_is_not_excused():
    ball, bar = trimesh.creation.icosphere(3, 0.1), trimesh.creation.box((0.02, 0.02, 0.4))
    bar.apply_translation([0, 0, 0.35])  # beside the ball
    found = compare(_made(ball), _made(trimesh.util.concatenate([ball, bar])), STAND)
    assert found.unseen_share == 0
    assert found.completeness.max > 0.09


def test_what_stands_within_the_reference_is_not_asked_for():
    """A bar through a ball: half of its sides is inside, where no camera looks; the other half is missing."""
    ball, bar = trimesh.creation.icosphere(3, 0.1), trimesh.creation.box((0.02, 0.02, 0.4))
    found = compare(_made(ball), _made(trimesh.util.concatenate([ball, bar])), STAND)
    area, inside = ball.area + bar.area, 4 * 0.02 * 0.2
    assert found.unseen_share == pytest.approx(inside / area, abs=0.01)
    missing = (bar.area - inside) / (area - inside)
    # at the bar's foot a strip is within 2 mm of the ball
    assert 1 - found.completeness.within["0.002"] == pytest.approx(missing, abs=4 * 0.02 * 2 * 0.004 / area + 0.005)
    assert any("nothing can see it" in note for note in found.notes)


def test_walls_from_inside_are_not_asked_for():
    outer, inner = trimesh.creation.box((0.12, 0.1, 0.08)), trimesh.creation.box((0.114, 0.094, 0.074))
    inner.invert()
    found = compare(_made(outer), _made(trimesh.util.concatenate([outer, inner])), STAND)
    assert found.unseen_share == pytest.approx(inner.area / (outer.area + inner.area), abs=0.01)
    assert found.completeness.within["0.001"] == 1 and found.completeness_all.within["0.002"] < 0.6


def test_the_back_of_a_plate_scanned_from_above_is_unseen():
    plate = trimesh.creation.box((0.2, 0.15, 0.005)).subdivide_to_size(0.01)
    top = vertices_kept(_made(plate), plate.vertices[:, 2] > 0)
    moved, _ = _moved(top)
    found = compare(moved, _made(plate), FEW)
    assert 0.45 < found.unseen_share < 0.52
    assert found.completeness.within["0.002"] > 0.9
    # the other side lies behind the mesh, which is laid on one of both from outside
    assert found.completeness_all.mean_signed == pytest.approx(-0.0025, abs=0.0003)
    assert any("that may have been seen (5" in light.reason for light in judge_comparison(found).lights)


@pytest.mark.parametrize(("unseen", "level"), [(0.49, "ok"), (0.55, "warning"), (0.95, "bad")])
def test_a_reference_that_was_hardly_seen_is_not_complete(unseen, level):
    """What counts as seen is there wholly: an eighth of an object was complete."""
    told = {"completeness": {"within": {"0.005": 1.0}}, "unseen_share": unseen}
    (light,) = judge_comparison(told).lights
    assert (light.subject, light.level) == ("Completeness", level) and bool(light.do) == (level != "ok")


def test_a_mesh_that_is_inside_out_is_still_laid_on_its_reference():
    whole = _object(3)
    part = vertices_kept(whole, whole.vertices[:, 2] > -0.03)
    moved, turn = _moved(replace(part, faces=part.faces[:, ::-1]))
    found = compare(moved, whole, FEW)
    assert found.alignment.status == "moved" and _turn_error_deg(found.T_reference_mesh, turn.T) < 0.1


def test_part_of_a_plane_slides_and_tells_no_scale():
    """The middle of a plate: noise alone seems to ask for a smaller scale, down to the end of what is allowed."""
    plate = trimesh.creation.box((0.2, 0.15, 0.005)).subdivide_to_size(0.004)
    inner = (plate.vertices[:, 2] > 0) & (np.abs(plate.vertices[:, :2]) < [0.06, 0.05]).all(axis=1)
    middle = vertices_kept(_made(plate), inner)
    rough = np.random.default_rng(5).normal(0, 3e-4, len(middle.vertices))
    moved, _ = _moved(replace(middle, vertices=middle.vertices + rough[:, None] * [0, 0, 1]))
    found = compare(moved, _made(plate), replace(FEW, scale=True))
    assert found.alignment.status == "moved" and found.scale == 1 and found.scale_interval == (0, np.inf)
    assert found.alignment.slides > 0 and any("slid by" in note for note in found.notes)
    assert any(light.subject == "Scale" and light.level == "warning" for light in judge_comparison(found).lights)
    whole = compare(_moved(_object(3))[0], _object(3), FEW)
    assert not whole.alignment.slides


@pytest.mark.slow
def test_plate_around_the_object_is_left_out():
    whole = _object()
    plate = trimesh.creation.cylinder(0.15, 0.004)
    plate.apply_translation([0, 0, whole.vertices[:, 2].min()])
    shape = trimesh.util.concatenate([trimesh.Trimesh(whole.vertices, whole.faces), plate])
    reference, turn = _moved(whole, 6)
    found = compare(_made(shape), reference, replace(FEW, max_distance=0.005))
    assert _turn_error_deg(found.T_reference_mesh, turn) < 0.05
    assert found.left_out_share > 0.2
    # plate within 5 mm of the object's foot stays in; it is a small share
    assert found.accuracy.median < 1e-4


def test_what_is_left_out_is_judged():
    """A ball beside a far smaller part: nearly all of the mesh has no say, and the rest is perfect."""
    ball, part = trimesh.creation.icosphere(3, 0.1), trimesh.creation.icosphere(2, 0.02)
    part.apply_translation([0.3, 0, 0])
    mesh = _made(trimesh.util.concatenate([ball, part]))
    found = compare(mesh, _made(part), replace(STAND, max_distance=0.001))
    (light,) = [light for light in judge_comparison(found).lights if light.level == "bad"]
    assert light.subject == "Left out" and "96.2% of the mesh" in light.reason
    whole = compare(_made(ball), _made(ball), replace(STAND, max_distance=0.001))
    assert "Left out" not in [light.subject for light in judge_comparison(whole).lights]


def test_where_no_pose_fits_nothing_else_is_judged():
    fits = compare(_ball(0.1), _ball(0.1), STAND)
    poor = replace(fits, alignment=Alignment(np.eye(4), status="poor"))
    for told in (poor, poor.to_dict()):
        judgement = judge_comparison(told)
        assert [light.subject for light in judgement.lights] == ["Alignment"] and judgement.worth.word == "failed"
    assert judge_comparison(fits).level == "ok"


def test_a_file_named_twice_is_told():
    ball = _ball(0.1)
    again = replace(ball, vertices=np.add(ball.vertices, [0, 0, 1e-6]))
    assert any("number by number" in note for note in compare(ball, ball, STAND).notes)
    assert not any("number by number" in note for note in compare(again, ball, STAND).notes)


def test_a_mirror_image_is_told():
    mesh = _object(3)
    reference = mirrored(_moved(mesh)[0])
    (said,) = mirrored_note(mesh, reference, surface_of(reference), IDENTITY, 0.005)
    assert "mirror image fits" in said and "left for right" in said


@pytest.mark.parametrize("noise", [0.0, 2e-4])
def test_a_nearly_symmetric_mirror_image_is_told(noise):
    """A face with one cheek a little fuller, 1.4 mm rms in 0.25 m: it fits its own mirror image well enough to pass."""
    ball = trimesh.creation.icosphere(4, 0.1)
    x, y, z = np.asarray(ball.vertices).T / 0.1
    bumps = 1 + 0.2 * np.sin(3 * z + 1) + 0.15 * np.cos(4 * y - z) + 0.06 * np.exp(-4 * ((x - 0.6) ** 2 + y**2 + z**2))
    bumps += np.random.default_rng(4).normal(0, noise / 0.1, len(bumps))
    truth = np.asarray(ball.vertices) * bumps[:, None] * [0.9, 1.0, 1.2]
    mesh = Mesh(truth, np.asarray(ball.faces, np.int32))
    right, wrong = (compare(_moved(one)[0], mesh, FEW) for one in (mesh, mirrored(mesh)))
    assert 0.0003 < wrong.accuracy.rms < 0.0025
    assert any("mirror image" in note for note in wrong.notes) and not any("mirror" in note for note in right.notes)


def test_where_no_pose_fits_the_command_fails_and_keeps_what_it_found_where_asked(tmp_path, capsys):
    write_mesh(tmp_path / "ring.ply", _moved(_made(trimesh.creation.torus(0.05, 0.02)))[0])
    write_mesh(tmp_path / "plate.ply", _made(trimesh.creation.box((0.2, 0.15, 0.005))))
    given = [str(tmp_path / "ring.ply"), str(tmp_path / "plate.ply"), "-o", str(tmp_path / "out"), "--quiet"]
    assert main(["compare", *given, "--no-report"]) == 1
    assert "--keep-failed" in capsys.readouterr().err and not (tmp_path / "out").exists()
    assert main(["compare", *given, "--no-report", "--keep-failed"]) == 1
    assert "fits the reference in no pose" in (told := capsys.readouterr()).err and told.err.count("\n") == 1
    assert json.loads((tmp_path / "out/comparison.json").read_text())["alignment"] == "poor"
    assert "distance.ply" in {path.name for path in (tmp_path / "out").iterdir()}


@pytest.mark.slow
def test_point_cloud_reference():
    mesh = _object()
    reference, turn = _moved(mesh, 7)
    points = sample_surface(reference, 20_000).points
    found = compare(mesh, Mesh(points), FEW)
    # planes through neighbours 2 mm apart on curved ground miss the surface by some 0.05 mm
    assert _turn_error_deg(found.T_reference_mesh, turn) < 0.1
    assert found.accuracy.rms < 2e-4
    assert found.completeness.rms < 2e-4


def test_files_hold_the_contract(tmp_path):
    found = compare(_ball(0.101), _ball(0.1), STAND)
    write_comparison(tmp_path, found)
    content = json.loads((tmp_path / "comparison.json").read_text())
    assert {"scale", "T_reference_mesh", "accuracy", "completeness", "fscore"} <= content.keys()
    for name in ("accuracy", "completeness"):
        keys = {"mean_signed", "mean", "rms", "std", "median", "p95", "max", "within"}
        assert content[name].keys() == keys
        assert content[name]["within"].keys() == {"0.001", "0.002", "0.005"}
    assert content["scale"] == 1
    back = read_mesh(tmp_path / "distance.ply")
    assert np.array_equal(back.scalars["signed_distance"], found.mesh.scalars["signed_distance"])


@pytest.mark.parametrize(
    ("mesh", "settings", "said"),
    [
        (Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32)), STAND, "no area"),
        (Mesh(np.zeros((2, 3))), STAND, "too few points"),
        (_ball(0.1), replace(STAND, max_distance=-1.0), "largest distance"),
        (_ball(0.1), replace(STAND, seen=np.zeros((0, 3))), "seen points"),
        (_ball(0.1), replace(STAND, unit="feet"), "unit"),
        (Mesh(_ball(0.1).vertices + 5, _ball(0.1).faces), replace(STAND, max_distance=0.01), "nothing of the mesh"),
    ],
)
def test_bad_input_is_one_line(mesh, settings, said):
    with pytest.raises(MeshError, match=said) as raised:
        compare(mesh, _ball(0.1), settings)
    assert "\n" not in str(raised.value)


def test_command_refuses_in_one_line(tmp_path, capsys):
    write_mesh(tmp_path / "ball.ply", _ball(0.1))
    (tmp_path / "seen.npz").write_bytes(b"nothing")
    ball = str(tmp_path / "ball.ply")
    assert main(["compare", ball, ball, "-o", str(tmp_path / "out"), "--seen", str(tmp_path / "seen.npz")]) == 1
    assert main(["compare", ball, str(tmp_path / "none.ply"), "-o", str(tmp_path / "out")]) == 1
    assert len(capsys.readouterr().err.splitlines()) == 2
    assert not (tmp_path / "out").exists()
