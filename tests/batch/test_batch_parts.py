"""What a batch is made of, without a cluster: lists, keys, the warm process, tables and the page."""

import csv
import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
import trimesh

from fusion.batch import cluster
from fusion.batch.fingerprint import fingerprint, key_of
from fusion.batch.job import Job, JobLimits, JobRow, filled, plain_name
from fusion.batch.listing import items_in
from fusion.batch.page import write_index
from fusion.batch.run import Batch
from fusion.batch.table import columns_of
from fusion.batch.warm import Warm
from fusion.batch.work import keep, kept, light_of, numbers_in, unread_in
from fusion.commands.main import main
from fusion.errors import FusionError
from fusion.files.output.claim import MARK

RUNNER = "light_command:run"
REFUSED = JobRow("b", "b", "refused", "failed", "no frames", key="0124")
ROW = JobRow("a", "a", "done", "good", folder="a-0123", key="0123", numbers={"x.y": 1.5, "x.n": 3})


@pytest.fixture
def scans(tmp_path):
    """A folder of three recordings and other things."""
    for name in ("b10", "b9", "result", ".hidden"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "habit.txt").write_text("good")
    (tmp_path / "result" / MARK).write_text("{}")
    (tmp_path / "notes.txt").write_text("no recording")
    return tmp_path


def test_a_folder_gives_its_recordings_as_a_person_counts(scans):
    items, notes = items_in(scans)
    assert [item.named for item in items] == ["b9", "b10"]
    assert len(notes) == 2 and "notes.txt" in " ".join(notes) and "result" in " ".join(notes)


def test_a_list_gives_columns_and_finds_files_beside_it(scans):
    (scans / "list.csv").write_text("rec,reference,unit\nb9,notes.txt,7\n\nb9,notes.txt,7\nb10,,8\n")
    items, _ = items_in(scans / "list.csv")
    assert [item.named for item in items] == ["b9", "b10"]  # what stands twice is one job
    assert items[0].columns == {"reference": str(scans / "notes.txt"), "unit": "7"}


@pytest.mark.parametrize("text", ["", "name\nb9\n", "rec,rec\nb9,b9\n", "rec,x\nb9\n", "rec\n"])
def test_lists_that_cannot_be_read_are_refused(scans, text):
    (scans / "list.csv").write_text(text)
    with pytest.raises(FusionError):
        items_in(scans / "list.csv")


def test_words_are_filled_and_unknown_ones_told():
    assert filled(["x", "{rec}", "{out}/a", "--n={unit}"], {"rec": "r", "unit": "7"}) == ("x", "r", "{out}/a", "--n=7")
    with pytest.raises(FusionError, match="refernce"):
        filled(["{refernce}"], {"rec": "r"})


def test_a_fingerprint_is_of_the_content_and_not_of_the_place(scans):
    (scans / "copy").mkdir()
    (scans / "copy" / "habit.txt").write_text("good")
    assert fingerprint(scans / "copy") == fingerprint(scans / "b9") == fingerprint(scans / "b10")
    before = fingerprint(scans / "b9")
    (scans / "b9" / "habit.txt").write_text("Good")
    changed = fingerprint(scans / "b9")
    (scans / "b9" / "habit.txt").rename(scans / "b9" / "habits.txt")
    assert len({before, changed, fingerprint(scans / "b9")}) == 3


def test_a_map_that_a_sensor_names_is_part_of_it(scans):
    (scans / "sensor.json").write_text('{"effects": [{"parameters": {"map": {"value": "map.npy"}}}]}')
    (scans / "map.npy").write_bytes(b"1")
    before = fingerprint(scans / "sensor.json")
    (scans / "map.npy").write_bytes(b"2")
    assert fingerprint(scans / "sensor.json") != before


def test_a_key_is_of_version_words_and_content():
    words, files = ["do", "/a/rec", "--n", "1"], {"/a/rec": "content"}
    keys = {
        key_of("1", words, files),
        key_of("2", words, files),
        key_of("1", [*words, "-x"], files),
        key_of("1", words, {"/a/rec": "other"}),
    }
    assert len(keys) == 4
    assert key_of("1", ["do", "/b/rec", "--n", "1"], {"/b/rec": "content"}) == key_of("1", words, files)


@pytest.fixture
def warm(monkeypatch, tmp_path):
    """Runs a habit in a warm process, which is returned with the answer."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    made = []

    def run(habit: str, limits: JobLimits | None = None):
        if not made or not made[0].alive:
            made[:] = [Warm(RUNNER)]
        given = tmp_path / habit.split()[0]
        given.mkdir(exist_ok=True)
        (given / "habit.txt").write_text(habit)
        out = tmp_path / f"out{len(list(tmp_path.iterdir()))}"
        return made[0], made[0].run(["do", str(given), out.name], str(tmp_path), limits or JobLimits())

    yield run
    made[0].stop()


def test_one_process_runs_one_command_after_another(warm):
    first, one = warm("good")
    second, bad = warm("bad")
    assert first is second and first.alive
    assert (one.status, bad.status) == (0, 1) and "the recording is broken" in bad.said


def test_what_dies_or_takes_too_long_is_told_and_its_process_gone(warm):
    process, crashed = warm("crash")
    assert crashed.status is None and "signal 11" in crashed.said and not process.alive
    process, late = warm("sleep", JobLimits(seconds=0.5))
    assert late.status is None and "longer than 0.5 s" in late.said and not process.alive
    assert warm("good")[1].status == 0


def test_what_takes_too_much_memory_is_stopped(warm):
    pytest.importorskip("psutil", reason="comes with the extra batch")
    process, answer = warm("hog", JobLimits(gigabytes=0.2, seconds=50))
    assert answer.status is None and "0.2 GB" in answer.said and not process.alive


def test_a_process_ends_with_whoever_asked(tmp_path):
    import subprocess

    command = [sys.executable, "-m", "fusion.batch.child", RUNNER]
    child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert child.stdin is not None and child.stdout is not None
    child.stdin.close()
    assert child.wait(timeout=30) == 3
    child.stdout.close()


def test_the_books_forget_what_is_gone_and_what_was_stopped(tmp_path):
    job = Job("a", "a", "0123", (), str(tmp_path), RUNNER)
    assert kept(tmp_path, job) is None
    (tmp_path / job.folder).mkdir()
    keep(tmp_path, job, ROW)
    assert kept(tmp_path, job) == ROW
    assert kept(tmp_path, replace(job, key="0124", name="a")) is None
    (tmp_path / job.folder).rmdir()
    assert kept(tmp_path, job) is None
    keep(tmp_path, job, replace(ROW, status="stopped", folder=""))
    assert kept(tmp_path, job) is None
    keep(tmp_path, job, replace(ROW, status="refused", folder=""))
    assert kept(tmp_path, job) is not None


def test_numbers_and_light_come_from_whatever_a_command_wrote(tmp_path):
    (tmp_path / "turntable.json").write_text(
        '{"radius": 0.3, "a": {"b": true}, "verdict": "doubtful", "reasons": ["x"]}'
    )
    (tmp_path / "settings.json").write_text('{"voxel": 0.001, "result": {"frames": 7}}')
    (tmp_path / "broken.json").write_text("{")
    assert numbers_in(tmp_path) == {
        "settings.result.frames": 7, "turntable.a.b": True, "turntable.radius": 0.3, "turntable.reasons.0": "x",
        "turntable.verdict": "doubtful",
    }  # fmt: skip
    assert light_of(tmp_path) == ("doubtful", "x")


@pytest.mark.parametrize("name", ["comparison", "repeat", "settings", "whatever"])
def test_lights_make_a_verdict_whichever_command_wrote_them(tmp_path, name):
    """As scans have it: red is doubtful, failed where a light says so, and what one should look at is still good."""
    ok, look = (
        {"level": "ok", "subject": "Bias", "reason": "None."},
        {"level": "warning", "subject": "A", "reason": "B."},
    )
    red = {"level": "bad", "subject": "Accuracy", "reason": "20 mm off.", "do": "Look where.", "fails": False}
    for lights, expected in [
        ([look, ok], ("good", "")),
        ([red, look, ok], ("doubtful", "Accuracy: 20 mm off. Look where.")),
        ([red | {"fails": True}, look], ("failed", "Accuracy: 20 mm off. Look where.")),
        ([], ("done", "")),
        ([{"of": "something else"}], ("done", "")),
    ]:
        (tmp_path / f"{name}.json").write_text(json.dumps({"judgement": lights}))
        assert light_of(tmp_path) == expected


def test_a_comparison_that_sees_a_problem_is_no_green_row(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.05)
    ball.export(tmp_path / "a.ply")
    ball.apply_translation([0.02, 0, 0]).export(tmp_path / "b.ply")
    words = ["compare", str(tmp_path / "b.ply"), str(tmp_path / "a.ply"), "--no-align", "--no-report"]
    assert main([*words, "-o", str(tmp_path / "out")]) == 0
    light, reason = light_of(tmp_path / "out")
    assert light == "doubtful" and reason.startswith("Accuracy: The mesh stands")


def test_entries_of_short_lists_are_numbers_and_unread_frames_are_told(tmp_path):
    stretches = [{"frames_unreadable": 2, "noise": {"axial_m": 0.002}}, {"frames_unreadable": 1, "of": []}]
    (tmp_path / "evaluation.json").write_text(json.dumps({"stretches": stretches, "curve": [0.5] * 9, "range": [1, 2]}))
    found = numbers_in(tmp_path)
    assert found == {
        "evaluation.stretches.0.frames_unreadable": 2, "evaluation.stretches.0.noise.axial_m": 0.002,
        "evaluation.stretches.1.frames_unreadable": 1, "evaluation.range.0": 1, "evaluation.range.1": 2,
    }  # fmt: skip
    assert unread_in(found) == "3 frames could not be read" and unread_in({"x.frames_unreadable": 0}) == ""


def test_columns_have_one_type_each():
    columns = columns_of([ROW, replace(ROW, numbers={"x.y": 2, "x.n": "seven"})])
    assert columns["x.y"] == [1.5, 2.0] and columns["x.n"] == ["3", "seven"]
    assert columns_of([ROW, replace(ROW, numbers={})])["x.n"] == [3, None]


def test_the_tables_are_the_same_bytes_each_time(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="comes with the extra batch")
    from fusion.batch.table import write_tables

    rows = [ROW, replace(ROW, recording='a "b", c', reason="line\nfeed", numbers={})]
    write_tables(tmp_path, rows)
    first = [(tmp_path / name).read_bytes() for name in ("results.csv", "results.parquet")]
    write_tables(tmp_path, rows)
    assert first == [(tmp_path / name).read_bytes() for name in ("results.csv", "results.parquet")]
    with (tmp_path / "results.csv").open(newline="") as file:
        read = list(csv.DictReader(file))
    assert read[1]["recording"] == 'a "b", c' and float(read[0]["x.y"]) == 1.5
    assert parquet.read_table(tmp_path / "results.parquet").to_pydict()["x.y"] == [1.5, None]


def test_the_page_escapes_names_and_holds_all_rows(tmp_path):
    write_index(tmp_path, [ROW, replace(ROW, recording="<script>alert(1)</script>", light="failed")], ["do", "{rec}"])
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert page.count('<tr data-light="') == 2 and "<script>alert" not in page and "://" not in page
    first = page
    write_index(tmp_path, [ROW, replace(ROW, recording="<script>alert(1)</script>", light="failed")], ["do", "{rec}"])
    assert (tmp_path / "index.html").read_text(encoding="utf-8") == first


def test_names_for_folders_are_plain(tmp_path):
    assert plain_name(tmp_path / "a scan/ü.x") == "x" and plain_name(Path("..")) == "job"


@pytest.mark.parametrize(
    "words",
    [
        "nowhere -o out -- turntable {rec} -o {out}",
        "SCANS -o out -- turntabel {rec} -o {out}",
        "SCANS -o out -- turntable {rec} -o there",
        "SCANS -o out -- turntable rec -o {out}",
        "SCANS -o out -- batch {rec} -o {out}",
        "SCANS -o SCANS/out -- turntable {rec} -o {out}",
        "SCANS -o SCANS/notes.txt/out -- turntable {rec} -o {out}",
        "SCANS -o out --workers 0 -- turntable {rec} -o {out}",
        "SCANS -o out --time-limit -1 -- turntable {rec} -o {out}",
    ],
)
def test_wrong_input_is_one_line_and_makes_nothing(scans, tmp_path_factory, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path_factory.mktemp("here"))
    assert main(["batch", *words.replace("SCANS", str(scans)).split()]) == 1
    assert capsys.readouterr().err.count("\n") == 1 and not Path("out").exists() and not (scans / "out").exists()


@pytest.mark.parametrize(("rows", "status"), [([ROW], 0), ([ROW, REFUSED], 0), ([REFUSED, REFUSED], 1)])
def test_a_batch_of_which_nothing_is_done_fails(scans, tmp_path_factory, monkeypatch, capsys, rows, status):
    monkeypatch.setattr("fusion.batch.run.run_batch", lambda *_: Batch(tuple(rows), ()))
    home = str(tmp_path_factory.mktemp("here") / "out")
    given = ["batch", str(scans), "-o", home, "--", "turntable", "{rec}", "-o", "{out}"]
    assert main(given) == status
    assert "no frames" in capsys.readouterr().out or REFUSED not in rows


def test_a_folder_that_no_batch_made_is_left_alone(scans, tmp_path_factory, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path_factory.mktemp("here"))
    Path("mine").mkdir()
    Path("mine/thesis.txt").write_text("mine", encoding="utf-8")
    assert main(["batch", str(scans), *["-o", "mine", "--", "turntable", "{rec}", "-o", "{out}"]]) == 1
    assert "the output is not empty" in capsys.readouterr().err
    assert [path.name for path in Path("mine").iterdir()] == ["thesis.txt"]


def test_workers_that_do_not_come_back_are_replaced(monkeypatch):
    monkeypatch.setattr(cluster, "LOOK_S", 0.01)
    monkeypatch.setattr(cluster, "MISSED_S", 0.1)
    asked: list[int] = []
    alive = {"a": 1}  # of two

    def scale(total: int) -> None:
        asked.append(total)
        alive["c"] = 1

    made = SimpleNamespace(scheduler=SimpleNamespace(workers=alive), worker_spec={0: 1, 1: 1}, scale=scale)
    with cluster._kept_up(made, 2):
        for _ in range(300):
            if asked:
                break
            time.sleep(0.01)
        time.sleep(0.3)  # enough are there again: no more
    assert asked == [3]
