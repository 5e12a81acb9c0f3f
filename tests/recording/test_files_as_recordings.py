"""A recording may be one file: what is none, or is known and not read, is one line that says what it is."""

import shutil
import sqlite3
from contextlib import closing

import pytest

from fusion import open_recording
from fusion.commands.main import main
from fusion.errors import RecordingError
from fusion.files.extra import extra


def database(path, tables):
    with closing(sqlite3.connect(path)) as base:
        for name in tables:
            base.execute(f"CREATE TABLE {name} (id INTEGER)")
        base.commit()


BEGINNINGS = {
    b"EVENTS1\0": "Kinect Studio",
    b"\x28\xb5\x2f\xfd": "zstd",
    b"\0\0\0\x18ftypqt  ": "video",
    b"\x89PNG\r\n\x1a\n": "one picture",
    b"ply\nformat ascii 1.0\n": "a mesh",
    b"hello": "no recording.*hello",
    b"": "an empty file",
}


@pytest.mark.parametrize("start", BEGINNINGS)
def test_what_a_file_is_comes_from_its_content(tmp_path, start):
    path = tmp_path / "recorded.bag"
    path.write_bytes(start)
    with pytest.raises(RecordingError, match=BEGINNINGS[start]):
        open_recording(path)


@pytest.mark.parametrize(
    ("tables", "what"),
    [
        (["Node", "Data", "Link"], "RTAB-Map.*rtabmap-export"),
        (["cameras", "images", "keypoints"], "COLMAP.*export nerfstudio's transforms.json"),
        (["books"], "no known recording"),
    ],
)
def test_whose_a_database_is_comes_from_its_tables(tmp_path, tables, what):
    database(tmp_path / "x.db", tables)
    with pytest.raises(RecordingError, match=what):
        open_recording(tmp_path / "x.db")


def test_folders_that_are_known_and_not_read(tmp_path):
    model, project = tmp_path / "sparse", tmp_path / "scan"
    for folder, names in ((model, ("cameras.bin", "images.bin", "points3D.bin")), (project, ("mine.fix_prj",))):
        folder.mkdir()
        for name in names:
            (folder / name).touch()
    project_of_colmap = tmp_path / "of_colmap"
    shutil.copytree(model, project_of_colmap / "sparse" / "0")
    packets = tmp_path / "packets"
    packets.mkdir()
    with (packets / "12345_depth_1.depth").open("wb") as file:
        file.truncate(2_984_960)
    with pytest.raises(RecordingError, match=r"Kinect v2 packets.*16-bit PNG"):
        open_recording(packets)
    for folder in (model, model.parent, project_of_colmap, project_of_colmap / "sparse"):
        with pytest.raises(RecordingError, match=r"COLMAP model.*no metric depth.*export nerfstudio's transforms.json"):
            open_recording(folder)
    with pytest.raises(RecordingError, match=r"hand scanner.*export a mesh"):
        open_recording(project)


def test_a_library_that_is_not_there_is_named_with_its_command():
    with pytest.raises(RecordingError, match=r'pip install "fusion-scan\[bags\]"'):
        extra("no_such_package.inner", "bags", "a packed bag", "x.bag", RecordingError)


@pytest.mark.parametrize("words", [["info", "{}"], ["convert", "{}", "out"], ["reconstruct", "{}", "-o", "out"]])
def test_commands_say_the_same_in_one_line(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    database(tmp_path / "map.db", ["Node", "Data", "Link"])
    assert main([word.format("map.db") for word in words]) == 1
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and "RTAB-Map" in told
    assert not (tmp_path / "out").exists()


def test_a_folder_has_no_topics(tmp_path):
    (tmp_path / "depth.txt").write_text("0.0 depth/0.png\n")
    with pytest.raises(RecordingError, match="no topics"):
        open_recording(tmp_path, "kinect-v1", topic="/depth")
