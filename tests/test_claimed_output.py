"""Nothing is replaced but an earlier result of the same command, and that only when asked for."""

import json
from pathlib import Path

import pytest

from fusion.errors import FusionError
from fusion.output import MARK, claimed, output_folder


def make(path: Path, *names: str, command: str = "turntable", **more) -> None:
    with claimed(path, command, **more), output_folder(path) as partial:
        for name in names:
            (partial / name).write_text(f"{command} {name}")


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.name != MARK)


def test_a_new_or_empty_folder_is_taken_and_marked(tmp_path):
    make(tmp_path / "new", "mesh.ply")
    (tmp_path / "empty").mkdir()
    make(tmp_path / "empty", "mesh.ply")
    for name in ("new", "empty"):
        mark = json.loads((tmp_path / name / MARK).read_text())
        assert (mark["command"], mark["files"]) == ("turntable", ["mesh.ply"])


def test_an_earlier_result_is_replaced_only_when_asked_for(tmp_path):
    make(tmp_path / "out", "mesh.ply", "camera.json")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    with pytest.raises(FusionError, match=r"exists already.*out.*--overwrite"):
        make(tmp_path / "out", "mesh.ply")
    make(tmp_path / "out", "mesh.ply", overwrite=True)
    # what only the earlier run made would be taken for a part of this one; what a person put there stays
    assert names(tmp_path / "out") == ["mesh.ply", "notes.txt"]
    make(tmp_path / "out", "mesh.ply", "camera.json", overwrite=True)
    assert names(tmp_path / "out") == ["camera.json", "mesh.ply", "notes.txt"]


@pytest.mark.parametrize("overwrite", [False, True])
def test_results_of_others_are_never_replaced(tmp_path, overwrite):
    make(tmp_path / "other", "mesh.ply", command="reconstruct")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "mesh.ply").write_text("mine")
    for name, found in (("other", "fusion reconstruct"), ("mine", "did not mark")):
        with pytest.raises(FusionError, match=f"not empty.*{name}.*{found}"):
            make(tmp_path / name, "mesh.ply", overwrite=overwrite)
    assert (tmp_path / "other" / "mesh.ply").read_text() == "reconstruct mesh.ply"
    assert (tmp_path / "mine" / "mesh.ply").read_text() == "mine"


@pytest.mark.parametrize("text", ["", "{", "[]", '{"command": "turntable"}', '{"command": "turntable", "files": 3}'])
def test_a_broken_mark_is_no_mark(tmp_path, text):
    (tmp_path / MARK).write_text(text)
    with pytest.raises(FusionError, match="not empty"):
        make(tmp_path, "mesh.ply", overwrite=True)


def test_a_mark_reaches_no_further_than_its_folder(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    make(tmp_path / "out", "mesh.ply")
    mark = json.loads((tmp_path / "out" / MARK).read_text())
    mark["files"] = ["../mine.txt", str(tmp_path / "mine.txt"), ".."]
    (tmp_path / "out" / MARK).write_text(json.dumps(mark))
    make(tmp_path / "out", "mesh.ply", overwrite=True)
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_a_failed_run_leaves_the_earlier_result_and_its_mark(tmp_path):
    make(tmp_path / "out", "mesh.ply", "camera.json")
    with pytest.raises(ValueError, match="broken"), claimed(tmp_path / "out", "turntable", overwrite=True):
        raise ValueError("broken")
    assert names(tmp_path / "out") == ["camera.json", "mesh.ply"]
    make(tmp_path / "out", "mesh.ply", overwrite=True)


@pytest.mark.parametrize(
    ("given", "out", "how"), [("rec", "rec", "is"), ("rec", "rec/out", "lies in"), ("all/rec", "all", "holds")]
)
@pytest.mark.parametrize("overwrite", [False, True])
def test_an_input_is_never_written_into_nor_replaced(tmp_path, given, out, how, overwrite):
    (tmp_path / given).mkdir(parents=True)
    (tmp_path / given / "depth.txt").write_text("mine")
    with pytest.raises(FusionError, match=f"output {how} the input"):
        make(tmp_path / out, "mesh.ply", inputs=[tmp_path / given], overwrite=overwrite)
    assert [path.name for path in (tmp_path / given).iterdir()] == ["depth.txt"]


def test_beside_an_input_is_no_input(tmp_path):
    (tmp_path / "rec").mkdir()
    make(tmp_path / "rec_out", "mesh.ply", inputs=[tmp_path / "rec"])


def test_an_input_that_a_link_leads_to_is_known(tmp_path):
    (tmp_path / "rec").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "rec")
    with pytest.raises(FusionError, match="output lies in the input"):
        make(tmp_path / "link" / "out", "mesh.ply", inputs=[tmp_path / "rec"])


def test_a_file_is_replaced_only_when_asked_for(tmp_path):
    target = tmp_path / "mesh.stl"
    target.write_text("older")
    with pytest.raises(FusionError, match=r"exists already.*--overwrite"), claimed(target, "convert"):
        raise AssertionError("no work is done")
    with claimed(target, "convert", overwrite=True):
        target.write_text("newer")
    assert target.read_text() == "newer"
