"""ROS bags from rosbags' writers: size, place, unit, clock, lens, poses and colours come out as they went in."""

import sys

import box_scene
import cv2
import numpy as np
import pytest
import ros_bags
from scipy.spatial.transform import Rotation

from fusion.commands.main import main
from fusion.errors import RecordingError
from fusion.geometry.pose import from_tum, inverse
from fusion.recording.formats.bags.transforms import Link
from fusion.recording.looking.inspect import inspect
from fusion.recording.open import open_recording
from fusion.recording.writing.convert import convert_recording

KINDS = ["ros1", "ros1-lz4", "ros1-bz2", "sqlite3", "sqlite3-packed", "mcap", "mcap-packed"]
STAMP_S = 1e-6  # a header holds nanoseconds, a number of seconds since 1970 some 0.2 us


def check_scene(recording, tolerance):
    """The same scene through the camera that the file states: a fifth of a pixel would be 2 mm on the tilted plane."""
    camera = recording.camera
    for index, frame in enumerate(recording):
        expected = box_scene.depth(camera.rays().astype(float), index)
        known = np.isfinite(frame.depth)
        assert (~known).sum() == 1 and not known[5, 7]
        np.testing.assert_allclose(frame.depth[known], expected[known], atol=tolerance)


@pytest.mark.parametrize("encoding", ["16UC1", "32FC1"])
@pytest.mark.parametrize("kind", KINDS)
def test_scene(tmp_path, kind, encoding):
    recording = open_recording(ros_bags.write(tmp_path / "bag", kind, encoding))
    assert len(recording) == ros_bags.FRAMES and recording.format == ("ros1" if kind.startswith("ros1") else "ros2")
    np.testing.assert_allclose(recording.timestamps, ros_bags.stamps(), atol=STAMP_S)
    np.testing.assert_allclose(recording.camera.parameters[:4], ros_bags.LENGTHS)
    check_scene(recording, ros_bags.ANSWERS[encoding])
    assert inspect(recording).severity != "error" and not recording.warnings


def test_a_fisheye_lens(tmp_path):
    """120 degrees over the corners, rays by OpenCV's fisheye functions."""
    lengths, k = (45.0, 45.5, 47.1, 36.2), (0.03, -0.02, 0.008, -0.001)
    v, u = np.mgrid[0 : ros_bags.SIZE[1], 0 : ros_bags.SIZE[0]].astype(float)
    K = np.array([[lengths[0], 0, lengths[2]], [0, lengths[1], lengths[3]], [0, 0, 1]])
    rays = cv2.fisheye.undistortPoints(np.dstack([u, v]).reshape(-1, 1, 2), K, np.array(k)).reshape(*u.shape, 2)
    bag = ros_bags.Writer(tmp_path / "bag", "mcap")
    bag.info("/d/camera_info", ros_bags.SIZE, lengths, 1.0, "d", k, model="equidistant")
    bag.image("/d/image_raw", box_scene.depth(rays).astype(np.float32), "32FC1", 1.0, "d")
    bag.bag.close()
    recording = open_recording(tmp_path / "bag")
    found, depth = recording.camera.points(recording[0].depth), box_scene.depth(rays)
    shown = depth > 0  # a face lies behind the camera there else
    assert shown.mean() > 0.3
    np.testing.assert_array_equal(np.isfinite(found[..., 2]), shown)
    seen, _ = cv2.fisheye.projectPoints(found.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), K, np.array(k))
    # what lenses brought into the program's own form are held to
    np.testing.assert_allclose(seen.reshape(*u.shape, 2)[shown], np.dstack([u, v])[shown], atol=0.02)
    np.testing.assert_allclose(found[shown, 2], depth[shown], atol=1e-6)


@pytest.mark.parametrize("kind", ["ros1", "sqlite3", "mcap"])
def test_a_bare_file_is_as_good_as_its_folder(tmp_path, kind):
    path = ros_bags.write(tmp_path / "bag", kind)
    if path.is_dir():
        (path,) = (part for part in path.iterdir() if part.suffix != ".yaml")
    renamed = path.rename(tmp_path / "no_ending")
    check_scene(open_recording(renamed), ros_bags.ANSWERS["16UC1"])


@pytest.mark.parametrize("encoding", ["16UC1", "32FC1"])
def test_compressed_depth(tmp_path, encoding):
    recording = open_recording(ros_bags.write(tmp_path / "bag", "mcap", encoding, packed=True))
    # floating depth goes through steps of the inverse: z^2 / 10100 for each, 0.1 mm here
    check_scene(recording, ros_bags.ANSWERS["16UC1"])


def test_colour_of_another_camera_is_kept_apart_with_lens_and_place(tmp_path):
    recording = open_recording(ros_bags.write(tmp_path / "bag", "mcap"))
    color = recording.camera.color
    np.testing.assert_allclose(color.parameters[:9], [*ros_bags.COLOR_LENGTHS, *ros_bags.COLOR_LENS], rtol=1e-6)
    np.testing.assert_allclose(recording.camera.T_color_depth, inverse(from_tum(ros_bags.COLOR_PLACE)), atol=1e-9)
    for index in range(len(recording)):
        assert recording[index].color is None
        np.testing.assert_array_equal(recording.color_apart(index), box_scene.color(*ros_bags.COLOR_SIZE, index))


def test_registered_colour_is_in_the_frames(tmp_path):
    recording = open_recording(ros_bags.write(tmp_path / "bag", "ros1", color="registered"))
    for index, frame in enumerate(recording):
        np.testing.assert_array_equal(frame.color, box_scene.color(*ros_bags.SIZE, index))
    assert recording.camera.color is None


@pytest.mark.parametrize("kind", ["ros1", "mcap"])
def test_poses_come_from_the_tree_of_frames(tmp_path, kind):
    recording = open_recording(ros_bags.write(tmp_path / "bag", kind))
    expected = [from_tum(ros_bags.camera_place(frame)) for frame in range(ros_bags.FRAMES)]
    np.testing.assert_allclose(recording.poses.poses, expected, atol=1e-6)
    still = open_recording(ros_bags.write(tmp_path / "still", kind, poses=False))
    assert still.poses is None


def test_several_depth_streams_are_listed_and_chosen_by_topic(tmp_path, capsys):
    out = ros_bags.Writer(tmp_path / "bag", "mcap")
    for name, far in (("a", 1.0), ("b", 2.0)):
        for index in range(2):
            out.info(f"/{name}/depth/camera_info", ros_bags.SIZE, ros_bags.LENGTHS, 5 + index, name)
            counts = np.full(ros_bags.SIZE[::-1], far * 1000, np.uint16)
            out.image(f"/{name}/depth/image_rect_raw", counts, "16UC1", 5 + index, name)
    out.bag.close()
    with pytest.raises(RecordingError, match=r"several depth streams.*/a/depth/image_rect_raw, /b/.*--topic"):
        open_recording(tmp_path / "bag")
    for topic in ("/b/depth/image_rect_raw", "b/depth"):
        assert open_recording(tmp_path / "bag", topic=topic)[0].depth[0, 0] == 2.0
    with pytest.raises(RecordingError, match="no such depth stream"):
        open_recording(tmp_path / "bag", topic="/c")
    assert main(["info", str(tmp_path / "bag"), "--topic", "/a/depth/image_rect_raw"]) == 0
    assert "1.000 to 1.000 m" in capsys.readouterr().out


def test_rectified_images_are_those_of_p(tmp_path):
    out = ros_bags.Writer(tmp_path / "bag", "sqlite3")
    other = (80.0, 81.0, 40.0, 30.0)
    p = [80.0, 0, 40.0, 0, 0, 81.0, 30.0, 0, 0, 0, 1, 0]
    for topic in ("image_rect", "image_raw"):
        image = np.full(ros_bags.SIZE[::-1], 900, np.uint16)
        for seconds in (5.0, 6.0):
            out.image(f"/depth/{topic}", image, "16UC1", seconds, "d")
    out.info("/depth/camera_info", ros_bags.SIZE, ros_bags.LENGTHS, 5.0, "d", (0.1, 0, 0, 0, 0), p)
    out.bag.close()
    rectified = open_recording(tmp_path / "bag", topic="/depth/image_rect").camera
    np.testing.assert_allclose(rectified.parameters, [*other, *[0] * 8])
    raw = open_recording(tmp_path / "bag", topic="/depth/image_raw").camera
    np.testing.assert_allclose(raw.parameters, [*ros_bags.LENGTHS, 0.1, *[0] * 7], rtol=1e-6)


def test_without_camera_info_a_camera_is_asked_for(tmp_path):
    path = ros_bags.write(tmp_path / "bag", "mcap", infos=False)
    with pytest.raises(RecordingError, match=r"no camera_info.*--camera"):
        open_recording(path)
    assert len(open_recording(path, "kinect-v1")) == ros_bags.FRAMES


def test_converted_to_a_native_folder_depth_stays_bit_for_bit(tmp_path):
    recording = open_recording(ros_bags.write(tmp_path / "bag", "mcap-packed"))
    convert_recording(recording, tmp_path / "native")
    native = open_recording(tmp_path / "native")
    np.testing.assert_allclose(native.timestamps, recording.timestamps, atol=STAMP_S)
    for index in range(len(recording)):
        np.testing.assert_array_equal(native[index].depth, recording[index].depth)
        np.testing.assert_array_equal(native.color_apart(index), recording.color_apart(index))
    turned = Rotation.from_matrix(native.poses.poses[-1][:3, :3]).as_rotvec()
    np.testing.assert_allclose(turned, [0, 0.002 * (ros_bags.FRAMES - 1), 0], atol=1e-6)


def test_no_depth_is_told_with_what_there_is(tmp_path):
    out = ros_bags.Writer(tmp_path / "bag", "mcap")
    out.image("/cam/image_raw", box_scene.color(8, 6), "rgb8", 5.0, "c")
    out.bag.close()
    with pytest.raises(RecordingError, match=r"no depth images.*/cam/image_raw"):
        open_recording(tmp_path / "bag")


@pytest.mark.parametrize("clock", [-1.7e9, 5.0, 0.4])
def test_colour_of_another_clock_is_joined_by_when_it_was_recorded(tmp_path, clock):
    """A colour camera without a clock of its own beside a depth camera on the computer's."""
    recording = open_recording(ros_bags.write(tmp_path / "bag", "mcap", color="registered", clock=clock))
    for index, frame in enumerate(recording):
        np.testing.assert_array_equal(frame.color, box_scene.color(*ros_bags.SIZE, index))
    (told,) = recording.warnings
    assert "/cam/depth/rgb" in told and f"{clock + 0.003:+.3f} s off" in told


@pytest.mark.parametrize("kind", ["ros1", "sqlite3", "mcap"])
def test_a_clock_that_was_set_back_is_told(tmp_path, kind, monkeypatch):
    given = ros_bags.stamps()
    monkeypatch.setattr(ros_bags, "stamps", lambda: [*given[:-1], given[0] - 2.0])
    recording = open_recording(ros_bags.write(tmp_path / "bag", kind, color=""))
    assert (np.diff(recording.timestamps) > 0).all()
    assert any("go back 1 times in the file" in finding.seen for finding in inspect(recording).findings)


def test_a_pose_whose_stamp_is_rounded_is_taken_as_it_is():
    """Stamps in nanoseconds and as numbers differ by parts of a microsecond: at 2 m/s more than poses are held to."""
    stamps = 1_764_000_000 + np.arange(3) / 30
    places = np.array([[2 * s, 0, 0, 0, 0, 0, 1] for s in np.arange(3) / 30])
    poses = Link("world", stamps, places).at(stamps + 4e-7)
    np.testing.assert_allclose(poses[:, 0, 3], places[:, 0], atol=1e-12)
    between = Link("world", stamps, places).at(stamps[:1] + 0.01)
    np.testing.assert_allclose(between[:, 0, 3], 0.02, atol=1e-6)


@pytest.mark.parametrize(
    ("kind", "module"), [("ros1-lz4", "lz4"), ("sqlite3-packed", "zstandard"), ("mcap-packed", "zstandard")]
)
def test_a_packed_bag_without_its_library_names_the_extra(tmp_path, monkeypatch, kind, module):
    path = ros_bags.write(tmp_path / "bag", kind)
    for name in [module, *(one for one in sys.modules if one.startswith(f"{module}."))]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(RecordingError, match=rf"needs the Python package {module}.*fusion-scan\[bags\]"):
        open_recording(path)
