"""Nothing is replaced but an earlier result of the same command, and that only when asked for."""

import json
import os
from pathlib import Path

import pytest

from fusion.errors import FusionError
from fusion.files.output.claim import MARK, claimed


def make(path: Path, *names: str, command: str = "turntable", **more) -> None:
    with claimed(path, command, **more) as claim, claim.folder() as partial:
        for name in names:
            (partial / name).parent.mkdir(exist_ok=True)
            (partial / name).write_text(f"{command} {name}")


def refused(path: Path, message: str, **more) -> None:
    with pytest.raises(FusionError, match=message), claimed(path, "convert", **more):
        raise AssertionError("no work is done")


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.name != MARK)


def test_a_new_or_empty_folder_is_taken_and_marked(tmp_path):
    (tmp_path / "empty").mkdir()
    for name in ("new", "empty"):
        make(tmp_path / name, "mesh.ply", "depth/0.png")
        mark = json.loads((tmp_path / name / MARK).read_text())
        assert (mark["command"], mark["files"]) == ("turntable", ["depth/0.png", "mesh.ply"])


def test_an_earlier_result_is_replaced_only_when_asked_for(tmp_path):
    make(tmp_path / "out", "mesh.ply", "camera.json", "depth/0.png")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    (tmp_path / "out" / "depth" / "notes.txt").write_text("mine")
    with pytest.raises(FusionError, match=r"exists already.*out.*--overwrite"):
        make(tmp_path / "out", "mesh.ply")
    make(tmp_path / "out", "mesh.ply", overwrite=True)
    # what only the earlier run made would be taken for a part of this one; what a person put there stays
    assert names(tmp_path / "out") == ["depth", "mesh.ply", "notes.txt"]
    assert names(tmp_path / "out" / "depth") == ["notes.txt"]
    make(tmp_path / "out", "mesh.ply", "camera.json", overwrite=True)
    assert names(tmp_path / "out") == ["camera.json", "depth", "mesh.ply", "notes.txt"]


def test_a_file_of_a_person_gives_way_to_a_new_one_of_its_name_but_is_kept(tmp_path, caplog):
    make(tmp_path / "out", "mesh.ply")
    (tmp_path / "out" / "report.html").write_text("mine")
    make(tmp_path / "out", "mesh.ply", "report.html", overwrite=True)
    assert names(tmp_path / "out") == ["mesh.ply", "report.html", "report.kept1.html"]
    assert (tmp_path / "out" / "report.kept1.html").read_text(encoding="utf-8") == "mine"
    assert "report.html was not made by fusion: kept as report.kept1.html" in caplog.text


def test_marks_that_name_folders_are_understood(tmp_path):
    """As fusion 0.1 wrote them."""
    make(tmp_path / "out", "depth/0.png", "depth/1.png")
    mark = json.loads((tmp_path / "out" / MARK).read_text())
    (tmp_path / "out" / MARK).write_text(json.dumps(mark | {"files": ["depth"]}))
    make(tmp_path / "out", "depth/0.png", overwrite=True)
    assert names(tmp_path / "out" / "depth") == ["0.png"]


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


def test_what_appears_while_the_work_goes_on_is_not_replaced(tmp_path):
    with (
        pytest.raises(FusionError, match="not empty"),
        claimed(tmp_path / "out", "turntable") as claim,
        claim.folder(),
    ):
        (tmp_path / "out").mkdir()
        (tmp_path / "out" / "mesh.ply").write_text("mine")
    assert (tmp_path / "out" / "mesh.ply").read_text() == "mine"
    assert names(tmp_path) == ["out"]


def test_two_runs_do_not_make_the_same_output(tmp_path):
    with claimed(tmp_path / "out", "turntable") as first:
        with pytest.raises(FusionError, match=r"being made.*out.*another run.*\.partial-"):
            make(tmp_path / "out", "mesh.ply")
        make(tmp_path / "beside", "mesh.ply")
        with first.folder() as partial:
            (partial / "mesh.ply").write_text("first")
    assert names(tmp_path) == ["beside", "out"]


@pytest.mark.parametrize("text", ["", "{", "[]", '{"command": "turntable"}', '{"command": "turntable", "files": 3}'])
def test_a_broken_mark_is_no_mark(tmp_path, text):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / MARK).write_text(text)
    with pytest.raises(FusionError, match="not empty"):
        make(tmp_path / "out", "mesh.ply", overwrite=True)


def test_a_mark_that_is_a_pipe_is_not_waited_for(tmp_path):
    (tmp_path / "out").mkdir()
    os.mkfifo(tmp_path / "out" / MARK)
    with pytest.raises(FusionError, match="not empty"):
        make(tmp_path / "out", "mesh.ply", overwrite=True)


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
    for stop in (ValueError("broken"), KeyboardInterrupt()):
        with (
            pytest.raises(type(stop)),
            claimed(tmp_path / "out", "turntable", overwrite=True) as claim,
            claim.folder() as partial,
        ):
            (partial / "mesh.ply").write_text("half")
            raise stop
        assert not claim.kept
        assert "nothing was written" in claim.outcome
    assert names(tmp_path) == ["out"]
    assert names(tmp_path / "out") == ["camera.json", "mesh.ply"]
    assert (tmp_path / "out" / "mesh.ply").read_text() == "turntable mesh.ply"
    make(tmp_path / "out", "mesh.ply", overwrite=True)


def test_who_is_stopped_after_the_result_stands_is_told_so(tmp_path):
    with pytest.raises(KeyboardInterrupt), claimed(tmp_path / "out", "turntable") as claim:
        with claim.folder() as partial:
            (partial / "mesh.ply").write_text("whole")
        raise KeyboardInterrupt
    assert claim.kept
    assert "nothing" not in claim.outcome


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
    assert (tmp_path / "rec_out" / "mesh.ply").is_file() and not any((tmp_path / "rec").iterdir())


def test_an_input_that_a_link_leads_to_is_known(tmp_path):
    (tmp_path / "rec").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "rec")
    with pytest.raises(FusionError, match="output lies in the input"):
        make(tmp_path / "link" / "out", "mesh.ply", inputs=[tmp_path / "rec"])
    with pytest.raises(FusionError, match="output is the input"):
        make(tmp_path / "rec", "mesh.ply", inputs=[tmp_path / "link"])


@pytest.mark.parametrize("out", [".", "../out", "{}"])
def test_the_folder_that_one_stands_in_is_not_taken_away(tmp_path, monkeypatch, out):
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path / "out")
    with pytest.raises(FusionError, match="folder you stand in"):
        make(Path(out.format(tmp_path / "out")), "mesh.ply")
    make(Path("inside/"), "mesh.ply")
    assert names(tmp_path / "out" / "inside") == ["mesh.ply"]


def test_a_file_is_replaced_only_when_asked_for(tmp_path):
    target = tmp_path / "mesh.stl"
    target.write_text("older")
    refused(target, r"exists already.*--overwrite", folder=False)
    with claimed(target, "convert", overwrite=True, folder=False) as claim, claim.file() as partial:
        partial.write_text("newer")
    assert claim.kept
    assert target.read_text() == "newer"


def test_a_file_of_a_result_is_not_replaced_alone(tmp_path):
    make(tmp_path / "out", "mesh.ply")
    refused(tmp_path / "out" / "mesh.ply", r"part of a result of fusion turntable", overwrite=True, folder=False)


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_file_is_no_folder_and_a_folder_no_file(tmp_path, overwrite):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "folder").mkdir()
    for name, folder in (("file", True), ("folder", False)):
        expected = f"is not a {'folder' if folder else 'file'}.*{name}"
        refused(tmp_path / name, expected, overwrite=overwrite, folder=folder)
    os.mkfifo(tmp_path / "pipe")
    for folder in (True, False):
        refused(tmp_path / "pipe", r"is not a f.*pipe", overwrite=overwrite, folder=folder)
