"""Recordings written as MCAP: others read them, and they come back as they were."""

from dataclasses import replace

import numpy as np
import pytest
import ros_bags
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from fusion.commands.main import main
from fusion.geometry.camera import Camera
from fusion.geometry.pose import from_tum, pose
from fusion.geometry.trajectory import Trajectory
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording

CAMERA = Camera(
    *ros_bags.SIZE, *ros_bags.LENGTHS, (0.1, -0.05, 0.001, 0.002, 0.01, 0.002, 0.003, 0.004), principle="itof",
    sensor="Some ToF", serial="7", std={"fx": 0.2},
)  # fmt: skip
PLACES = [from_tum(ros_bags.camera_place(frame)) for frame in range(ros_bags.FRAMES)]


def native(folder, scale=1000.0, start=ros_bags.START):
    camera = replace(CAMERA, depth_scale=scale)
    frames = []
    for index in range(ros_bags.FRAMES):
        depth = ros_bags.true_depth(index).astype(np.float32)
        depth[2:5, 3] = np.nan
        color = np.full((*camera.shape, 3), (10, 20, 30 + index), np.uint8)
        ir = np.full(camera.shape, 1000 + index, np.uint16)
        frames.append(Frame(index, start + index * 0.7, depth, color, ir))
    stamps = np.array([frame.timestamp for frame in frames])
    log = {"timestamp": stamps, "turntable_deg": 5.0 * np.arange(len(stamps))}
    scene = {"T_world_camera": np.eye(4).tolist()}
    write_recording(folder, camera, frames, Trajectory(stamps, np.array(PLACES)), log, scene)
    return open_recording(folder)


@pytest.mark.parametrize("start", [0.0, ros_bags.START])
@pytest.mark.parametrize("scale", [1000.0, 5000.0, 10000.0])
def test_round_trip(tmp_path, scale, start):
    one = native(tmp_path / "native", scale, start)
    assert main(["convert", str(tmp_path / "native"), str(tmp_path / "out.mcap"), "--format", "mcap"]) == 0
    two = open_recording(tmp_path / "out.mcap")
    assert two.camera == one.camera and two.scene == one.scene and not two.warnings
    np.testing.assert_array_equal(two.telemetry_at_frames("turntable_deg"), one.telemetry_at_frames("turntable_deg"))
    np.testing.assert_allclose(two.timestamps, one.timestamps, atol=1e-6)
    np.testing.assert_allclose(two.poses.poses, one.poses.at(one.timestamps).poses, atol=1e-6)
    for left, right in zip(one, two, strict=True):
        np.testing.assert_array_equal(left.depth, right.depth)
        np.testing.assert_array_equal(left.color, right.color)
        np.testing.assert_array_equal(left.ir, right.ir)
    assert main(["convert", str(tmp_path / "out.mcap"), str(tmp_path / "back")]) == 0
    for left, right in zip(one, open_recording(tmp_path / "back"), strict=True):
        np.testing.assert_array_equal(left.depth, right.depth)


def test_colour_of_another_camera_keeps_its_place(tmp_path):
    given = open_recording(ros_bags.write(tmp_path / "given", "sqlite3"))
    assert main(["convert", str(given.path), str(tmp_path / "out.mcap"), "--format", "mcap"]) == 0
    found = open_recording(tmp_path / "out.mcap")
    assert found.camera.color == given.camera.color
    np.testing.assert_allclose(found.camera.T_color_depth, given.camera.T_color_depth, atol=1e-9)
    for index in range(len(given)):
        np.testing.assert_array_equal(found.color_apart(index), given.color_apart(index))


def test_others_read_it(tmp_path):
    one = native(tmp_path / "native")
    assert main(["convert", str(tmp_path / "native"), str(tmp_path / "out.mcap"), "--format", "mcap"]) == 0
    # the format's own reader: header, summary, counts
    with (tmp_path / "out.mcap").open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        counted = {
            reader.get_summary().channels[number].topic: count
            for number, count in reader.get_summary().statistics.channel_message_counts.items()
        }
        assert counted["/camera/depth/image_raw"] == counted["/tf"] == ros_bags.FRAMES
        assert sum(1 for _ in reader.iter_messages()) == sum(counted.values())
    # rosbags, by the definitions in the file alone
    with AnyReader([tmp_path / "out.mcap"], default_typestore=get_typestore(Stores.EMPTY)) as bag:
        depths = [
            bag.deserialize(data, c.msgtype) for c, _, data in bag.messages() if c.topic.endswith("depth/image_raw")
        ]
        infos = [
            bag.deserialize(data, c.msgtype) for c, _, data in bag.messages() if c.topic.endswith("depth/camera_info")
        ]
        places = [bag.deserialize(data, c.msgtype) for c, _, data in bag.messages() if c.topic == "/tf"]
    counts = depths[1].data.view("<u2").reshape(one.camera.shape)
    np.testing.assert_array_equal(counts, np.nan_to_num(one[1].depth * 1000).round())
    assert depths[1].encoding == "16UC1" and infos[0].distortion_model == "rational_polynomial"
    np.testing.assert_allclose(infos[0].d, CAMERA.distortion)
    moved = places[2].transforms[0]
    shift = moved.transform.translation
    np.testing.assert_allclose(pose(np.eye(3), [shift.x, shift.y, shift.z])[:3, 3], PLACES[2][:3, 3], atol=1e-9)
    assert (moved.header.frame_id, moved.child_frame_id) == ("world", "camera_depth_optical_frame")


def test_an_earlier_file_is_replaced_only_when_asked(tmp_path, capsys):
    native(tmp_path / "native")
    words = ["convert", str(tmp_path / "native"), str(tmp_path / "out.mcap"), "--format", "mcap"]
    assert main(words) == 0 and main(words) == 1
    assert "exists already" in capsys.readouterr().err
    assert main([*words, "--overwrite"]) == 0
    inside = ["convert", str(tmp_path / "out.mcap"), str(tmp_path / "out.mcap"), "--format", "mcap", "--overwrite"]
    assert main(inside) == 1 and "the output is the input" in capsys.readouterr().err
