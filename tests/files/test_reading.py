"""What comes from outside: regular, bounded, inside."""

import os

import pytest

from fusion.errors import FusionError, RecordingError
from fusion.files import reading
from fusion.files.inside import all_inside, inside
from fusion.files.reading import open_regular, read_bytes, read_text


@pytest.mark.parametrize("name", ["/dev/zero", "/dev/null", "/", "absent", "a\0b"])
def test_only_regular_files_are_opened(name):
    with pytest.raises(RecordingError):
        open_regular(name, RecordingError)


def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FusionError, match="a pipe"):
        read_bytes(tmp_path / "pipe")


def test_a_large_file_is_refused_before_it_is_read(tmp_path, trusting):
    with (tmp_path / "large").open("wb") as file:
        file.truncate(3_000_000_000)  # sparse: takes no room
    with pytest.raises(FusionError, match=r"3 GB.*--allow-gb"):
        read_bytes(tmp_path / "large")
    trusting(4.0, False)
    assert read_bytes(tmp_path / "large", most=1) == b"\0"


def test_a_text_that_would_take_too_much_is_refused_before_it_is_read(tmp_path, monkeypatch):
    with (tmp_path / "large").open("wb") as file:
        file.truncate(300_000_000)
    monkeypatch.setattr(reading.os, "fdopen", lambda *_: pytest.fail("it is read"))
    with pytest.raises(FusionError, match=r"3 GB.*--allow-gb"):
        read_text(tmp_path / "large")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_text_is_the_same_however_it_was_saved(tmp_path, encoding, end):
    (tmp_path / "text").write_bytes(f"größe 1{end}2{end}".encode(encoding))
    assert read_text(tmp_path / "text") == "größe 1\n2\n"


def test_bytes_that_are_no_text_are_told(tmp_path):
    (tmp_path / "text").write_bytes(b"abc\xff")
    with pytest.raises(FusionError, match="byte 255 at 3"):
        read_text(tmp_path / "text")


@pytest.mark.parametrize("one", [inside, lambda folder, name, error: all_inside(folder, ["a.png", name], error)])
def test_names_that_no_file_can_have_are_refused_in_a_short_line(tmp_path, one):
    with pytest.raises(RecordingError, match="too long") as told:
        one(tmp_path, "x" * 5_000_000, RecordingError)
    assert len(str(told.value)) < 700


def test_names_stay_inside(tmp_path):
    home, other = tmp_path / "home", tmp_path / "other"
    home.mkdir(), other.mkdir()
    (home / "link").symlink_to(other)
    (home / "loop").symlink_to(home / "loop")
    assert inside(home, "depth/a.png") == home / "depth/a.png"
    for name in ["../other/a", "/etc/passwd", "link/a", "depth/../../other", "a\0b"]:
        with pytest.raises(RecordingError):
            inside(home, name, RecordingError)
