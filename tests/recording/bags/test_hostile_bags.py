"""Bags that were cut off, or in which bytes are wrong: one error that names the file, or the frames that are whole."""

import random
import struct
from pathlib import Path

import pytest
import ros_bags

from fusion.commands.main import main
from fusion.errors import FusionError, RecordingError
from fusion.recording.formats.bags.containers.packed import unpack
from fusion.recording.formats.bags.messages.rvl import unpack_rvl
from fusion.recording.open import open_recording

HERE = Path(__file__).parent
KINDS = ["ros1", "ros1-lz4", "sqlite3", "sqlite3-packed", "mcap", "mcap-packed", "realsense-bag", "realsense-db3"]
SAMPLES = {"realsense-bag": "realsense_2_56.bag", "realsense-db3": "realsense_2_59.db3"}
TRIALS = 40  # for each kind: some seconds in all


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    made = {}
    for kind in KINDS:
        path = HERE / SAMPLES[kind] if kind in SAMPLES else ros_bags.write(tmp_path_factory.mktemp(kind) / "bag", kind)
        if path.is_dir():
            (path,) = (part for part in path.iterdir() if part.suffix != ".yaml")
        made[kind] = path.read_bytes()
    return made


def walk(path):
    """Frames that could be read; any error but the program's own fails the test."""
    try:
        recording = open_recording(path)
    except FusionError:
        return 0
    good = 0
    for index in range(len(recording)):
        try:
            recording[index]
            recording.color_apart(index)
            good += 1
        except FusionError:
            continue
    return good


@pytest.mark.parametrize("kind", KINDS)
def test_wrong_bytes(tmp_path, whole, kind):
    chance, found = random.Random(kind), []
    for trial in range(TRIALS):
        data = bytearray(whole[kind])
        for _ in range(chance.choice([1, 3, 30])):
            # lengths and counts stand at the ends as often as anywhere
            place = chance.choice([chance.randrange(len(data)), chance.randrange(400), -1 - chance.randrange(400)])
            data[place] = chance.choice([0, 1, 127, 128, 255, chance.randrange(256)])
        path = tmp_path / f"{trial}"
        path.write_bytes(data)
        found.append(walk(path))
    path.write_bytes(whole[kind])
    # nothing is made up, and one of the wrong bytes that leaves all frames as they are is hit
    assert max(found) == walk(path) >= 3


@pytest.mark.parametrize("kind", KINDS)
def test_cut_off(tmp_path, whole, kind):
    chance = random.Random(kind)
    for trial in range(TRIALS // 2):
        path = tmp_path / f"{trial}"
        path.write_bytes(whole[kind][: chance.randrange(len(whole[kind]))])
        assert 0 <= walk(path) <= ros_bags.FRAMES


@pytest.mark.parametrize("kind", ["mcap", "mcap-packed"])
def test_what_was_recorded_before_the_cut_is_there(tmp_path, whole, kind):
    path = tmp_path / "cut"
    path.write_bytes(whole[kind][:-200])  # the summary at the end is gone
    recording = open_recording(path)
    assert len(recording) == ros_bags.FRAMES and walk(path) == ros_bags.FRAMES
    assert any("cut off" in text for text in recording.warnings)


def test_a_ros1_bag_that_ends_in_its_last_chunk(tmp_path):
    path = ros_bags.write(tmp_path / "bag", "ros1")
    data = path.read_bytes()
    # the index behind the chunk is gone: its messages are looked for in it
    path.write_bytes(data[: data.index(b"op=\x04")])
    assert walk(path) == ros_bags.FRAMES
    # its last third is gone too: nothing in it is whole
    path.write_bytes(data[: data.rfind(b"op=\x05")] + data[data.rfind(b"op=\x05") :][: len(data) * 2 // 3])
    with pytest.raises(RecordingError, match="no depth images"):
        open_recording(path)


@pytest.mark.parametrize("kind", KINDS)
def test_commands_say_it_in_one_line(tmp_path, whole, kind, capsys):
    path = tmp_path / "short"
    path.write_bytes(whole[kind][:150])
    assert main(["info", str(path)]) == 1
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("how", ["", "bz2", "lz4", "zstd"])
def test_a_claim_of_size_is_looked_at_before_anything_is_taken(how):
    with pytest.raises(RecordingError, match="too large"):
        unpack(b"", how, 1 << 40, Path("claims"))


@pytest.mark.parametrize(
    "data", [b"", b"\0" * 8, b"\xff" * 64, b"\x77" * 4096, struct.pack("<I", 0x10000000) * 9], ids=range(5)
)
def test_rvl_that_leads_nowhere(data):
    with pytest.raises(ValueError, match="RVL"):
        unpack_rvl(data, 64, 48)
