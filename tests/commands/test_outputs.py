"""No command that writes touches its input or what another one made; that is told in one line, before any work."""

import shutil
from argparse import Namespace
from pathlib import Path

import pytest
from test_main import ARGUMENTS, one_line, status, typed

from fusion.commands.options.inputs import inputs
from fusion.files.output.claim import claimed

WRITING = [name for name, words in ARGUMENTS.items() if "OUT" in words]
READING = [name for name in WRITING if any("IN" in word for word in ARGUMENTS[name])]


def words(command: str, given: Path, out: Path | str, *more: str) -> list[str]:
    return [*typed(command, given, out), *more]


@pytest.fixture
def recording(tmp_path):
    """What every command would refuse as an input if it looked at it."""
    folder = tmp_path / "all" / "rec"
    folder.mkdir(parents=True)
    (folder / "depth.txt").write_text("mine")
    (tmp_path / "link").symlink_to(folder)
    return folder


def content(folder: Path) -> dict[str, str]:
    return {
        str(p.relative_to(folder)): p.read_text() for p in folder.rglob("*") if p.is_file() and "link" not in p.parts
    }


@pytest.mark.parametrize(
    ("given", "out", "how"),
    [
        ("all/rec", "all/rec", "is"),
        ("all/rec", "all/rec/", "is"),
        ("all/rec", "all/../link", "is"),
        ("link", "all/rec", "is"),
        ("all/rec", "all/rec/new/out", "lies in"),
        ("all/rec", "link/out", "lies in"),
        ("all/rec", "all", "holds"),
        ("link", "all", "holds"),
    ],
)
@pytest.mark.parametrize("command", READING)
def test_an_output_in_or_around_the_input_is_refused(
    command, given, out, how, recording, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    for more in ((), ("--overwrite",)):
        assert status(words(command, Path(given), out, *more)) == 1
        told = capsys.readouterr().err
        assert one_line(told)
        assert f"the output {how} the input" in told
    assert content(tmp_path) == {"all/rec/depth.txt": "mine"}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["all", "link"]


@pytest.mark.parametrize("command", WRITING)
def test_a_folder_that_others_filled_is_refused(command, recording, tmp_path, capsys):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "mesh.ply").write_text("mine")
    with claimed(tmp_path / "made", "another") as claim, claim.folder() as partial:
        (partial / "mesh.ply").write_text("made")
    before = content(tmp_path)
    for name in ("other", "made"):
        for more in ((), ("--overwrite",)):
            assert status(words(command, recording, tmp_path / name, *more)) == 1
            told = capsys.readouterr().err
            assert one_line(told)
            assert "the output is not empty" in told
    assert content(tmp_path) == before


@pytest.mark.parametrize("command", [name for name in WRITING if name != "convert"])
def test_a_file_where_the_folder_should_be_is_refused(command, recording, tmp_path, capsys):
    (tmp_path / "taken").write_text("mine")
    for out in ("taken", "taken/out"):
        assert status(words(command, recording, tmp_path / out, "--overwrite")) == 1
        told = capsys.readouterr().err
        assert one_line(told)
        assert "the output is not a folder" in told or "the output cannot be written" in told
    assert (tmp_path / "taken").read_text() == "mine"


def test_a_recording_becomes_no_file_and_a_mesh_no_folder(recording, tmp_path, capsys):
    (tmp_path / "ball.ply").write_text("no mesh, but that is not looked at")
    (tmp_path / "folder").mkdir()
    for given, out, said in [
        ("all/rec", "x.ply", "becomes no mesh file"),
        ("all/rec", "x.STL", "becomes no mesh file"),
        ("ball.ply", "folder", "unknown mesh format"),
        ("ball.ply", "x.gltf", "only read"),
        ("ball.ply", "new", "unknown mesh format"),
    ]:
        assert status(["convert", str(tmp_path / given), str(tmp_path / out)]) == 1
        told = capsys.readouterr().err
        assert one_line(told)
        assert said in told
    assert sorted(path.name for path in tmp_path.iterdir()) == ["all", "ball.ply", "folder", "link"]


@pytest.mark.parametrize(("option", "value"), [("scene", "wall"), ("sensor", "kinect-v1"), ("camera", "kinect-v1")])
def test_a_folder_called_like_a_known_thing_is_no_input(option, value, tmp_path, monkeypatch):
    """`fusion simulate wall -o wall` reads the built-in scene, also when its result stands there already."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / value).mkdir()
    (tmp_path / "mine").mkdir()
    assert inputs(Namespace(**{option: value}, recordings=[Path("mine")], folder=Path(value))) == [
        Path("mine"),
        Path(value),
    ]
    assert inputs(Namespace(**{option: f"./{value}"})) == [Path(value)]
    assert inputs(Namespace(**{option: "mine"})) == [Path("mine")]
    shutil.rmtree(tmp_path / "mine")
    assert inputs(Namespace(**{option: "mine"})) == []
