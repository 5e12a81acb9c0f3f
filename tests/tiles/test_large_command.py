"""`fusion reconstruct --memory`: the mesh tile by tile, the rest from an overview."""

import json

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.mesh.files import read_mesh


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    """A few frames of a simulated room."""
    path = tmp_path_factory.mktemp("large") / "room"
    words = ["simulate", "room", "--set", "frames=6", "--set", "sweep_deg=20", "--seed", "2", "--sensor", "kinect-v1"]
    assert main([*words, "--quiet", "-o", str(path)]) == 0
    return path


def reconstructed(room, out, *words) -> int:
    told = ["--poses", "stated", "--voxel", "0.02", "--no-report", "--no-color", "--quiet", "--overwrite"]
    return main(["reconstruct", str(room), "-o", str(out), *told, *words])


def ordered(mesh):
    """Coordinates and normals of all corners of all faces, in an order that they alone decide."""
    rows = np.concatenate([mesh.vertices, mesh.normals], axis=1)[mesh.faces]
    first = np.lexsort(np.moveaxis(rows, -1, 0)[::-1], axis=-1)[:, :1]
    rows = np.take_along_axis(rows, ((first + np.arange(3)) % 3)[..., None], axis=1).reshape(len(rows), -1)
    return rows[np.lexsort(rows.T[::-1])]


def test_the_mesh_is_that_of_one_volume_and_the_page_says_what_it_shows(room, tmp_path):
    assert reconstructed(room, tmp_path / "whole") == 0
    assert reconstructed(room, tmp_path / "large", "--memory", "0.7") == 0
    whole, large = (read_mesh(tmp_path / name / "mesh.ply") for name in ("whole", "large"))
    np.testing.assert_array_equal(ordered(large), ordered(whole))
    names = {path.name for path in (tmp_path / "large").iterdir()}
    assert {"mesh.ply", "overview.ply", "trajectory.txt", "settings.json"} <= names and "tiles" not in names
    told = json.loads((tmp_path / "large" / "settings.json").read_text())
    assert told["tiles"]["faces"] == len(whole.faces) and told["tiles"]["voxel_m"] == 0.02
    said = " ".join(str(light) for light in told["judgement"])
    assert f"{len(whole.faces):,} triangles" in said and "overview in voxels of" in said


@pytest.mark.slow
def test_workers_give_the_same_file(room, tmp_path):
    pytest.importorskip("distributed")
    assert reconstructed(room, tmp_path / "one", "--memory", "0.7") == 0
    assert reconstructed(room, tmp_path / "two", "--memory", "0.7", "--workers", "2") == 0
    assert (tmp_path / "one" / "mesh.ply").read_bytes() == (tmp_path / "two" / "mesh.ply").read_bytes()


@pytest.mark.parametrize(
    "words, said",
    [
        (["--workers", "2"], "nothing to share between workers"),
        (["--scheduler", "tcp://127.0.0.1:1"], "nothing to share between workers"),
        (["--memory", "0.1"], "--memory"),
        (["--memory", "0.7", "--max-depth", "0.1"], "no depth in the recording"),
        (["--memory", "0.7", "--box", "50", "50", "50", "51", "51", "51"], "nothing was fused"),
    ],
)
def test_what_cannot_be_is_one_line_and_leaves_nothing(room, tmp_path, capsys, words, said):
    try:
        status = reconstructed(room, tmp_path / "out", *words)
    except SystemExit as stop:
        status = stop.code
    assert status in (1, 2) and not (tmp_path / "out").exists()
    assert said in capsys.readouterr().err
