"""Out through each written format, on through each other one, and back: counts, colours, stamps and poses stay."""

from dataclasses import replace

import numpy as np
import pytest
import synthetic

from fusion import Trajectory, open_recording, write_recording
from fusion.commands.main import main
from fusion.commands.recording.convert import RECORDINGS

FRAMES, LOST = 3, 1
LENS = (0.1, -0.05, 0.001, -0.002, 0.01)


def written(path, scale=1000.0, lens=(), start=1_732_600_000.123457, lost=None, still=False):
    """A native folder whose depth holds counts from 1 to 65534 by chance, missing ones among them."""
    camera = replace(synthetic.CAMERA, depth_scale=scale, distortion=lens)
    random = np.random.default_rng(3)
    stamps, frames = start + np.arange(FRAMES) / 30, []
    for i, stamp in enumerate(stamps):
        counts = random.integers(0, 65535, camera.shape)
        depth = np.where(counts == 0, np.nan, counts / scale).astype(np.float32)
        frames.append(replace(synthetic.frames(FRAMES, color=True)[i], depth=depth, timestamp=float(stamp)))
    poses = synthetic.poses(FRAMES)
    poses[:, :3, 3] += [12.3456789, -3.2, 55.1]
    poses = np.repeat(poses[:1], FRAMES, axis=0) if still else poses
    if lost is not None:
        poses[lost] = np.nan
    write_recording(path, camera, frames, Trajectory(stamps, poses))
    return open_recording(path)


def through(path, kind, camera):
    """The converted recording; of a TUM folder the camera is said, as it holds none."""
    out = path.with_name(f"{path.name}_{kind}")
    said = ["--camera", str(camera)] if open_recording(path, camera).format == "tum" else []
    assert main(["convert", str(path), str(out), "--format", kind, *said]) == 0
    return open_recording(out, camera if kind == "tum" else None)


def same(one, other):
    assert len(one) == len(other) and one.camera.depth_scale == pytest.approx(other.camera.depth_scale, rel=1e-12)
    assert np.abs(one.timestamps - other.timestamps).max() < 1e-6
    for a, b in zip(one, other, strict=True):
        counts = [np.nan_to_num(np.rint(frame.depth.astype(float) * one.camera.depth_scale)) for frame in (a, b)]
        assert np.array_equal(*counts) and np.array_equal(a.depth, b.depth, equal_nan=True)
        assert np.array_equal(a.color, b.color)
    places = [r.poses.at(r.timestamps).poses for r in (one, other)]
    assert np.array_equal(*(np.isfinite(T) for T in places))
    assert np.nanmax(np.abs(places[0] - places[1])) < 1e-6


@pytest.mark.parametrize("second", RECORDINGS)
@pytest.mark.parametrize("first", RECORDINGS)
@pytest.mark.parametrize(
    "given", [{}, {"scale": 10_000.0, "lens": LENS}, {"scale": 4000.0, "start": 12.5, "still": True}],
    ids=["millimetres", "tenths, a lens", "a camera that stands still"],
)  # fmt: skip
def test_counts_stamps_and_poses_come_back(tmp_path, given, first, second, caplog):
    original = written(tmp_path / "r", **given)
    camera = tmp_path / "r" / "camera.json"
    middle = through(original.path, first, camera)
    same(original, middle)
    same(original, through(middle.path, second, camera))
    assert "rounded" not in caplog.text and "no count" not in caplog.text


@pytest.mark.parametrize("kind", sorted(set(RECORDINGS) - {"nerfstudio"}))
def test_a_frame_without_a_pose_stays_without(tmp_path, kind):
    original = written(tmp_path / "r", lost=LOST)
    back = through(original.path, kind, tmp_path / "r" / "camera.json")
    same(original, back)
    assert not np.isfinite(back.poses.at(back.timestamps).poses[LOST]).any()


@pytest.mark.parametrize("kind", RECORDINGS)
def test_metres_are_kept_or_what_they_lose_is_told(tmp_path, kind, caplog):
    """Depth that is stored as real numbers: MCAP holds it, counts round it, and far ones they have none for."""
    (tmp_path / "r").mkdir()
    depth = np.linspace(0.5, 20.0, 80 * 60, dtype=np.float32).reshape(60, 80)
    depth[0, 0] = 0.00005
    np.save(tmp_path / "r" / "0.npy", depth)
    given = open_recording(tmp_path / "r", "70,70,40,30")
    given = replace(given, poses=Trajectory(given.timestamps, np.eye(4)[None]))
    words = ["convert", str(tmp_path / "r"), str(tmp_path / "out"), "--format", kind, "--camera", "70,70,40,30"]
    if kind == "nerfstudio":  # there is no colour for splats
        assert main(words) == 1
        return
    assert main(words) == 0
    back = open_recording(tmp_path / "out", given.camera if kind == "tum" else None)[0].depth
    if kind == "mcap":
        assert np.array_equal(back, depth) and "rounded" not in caplog.text
        return
    kept = np.isfinite(back)
    assert np.abs(back - depth)[kept].max() < 0.5 / given.camera.depth_scale + 1e-6
    assert f"{(~kept).sum() - 1} pixels from 13.1 m on have no count: left out" in caplog.text
    assert "1 pixels nearer than 0.1 mm have no count" in caplog.text
    assert "rounded to whole counts of 0.2 mm, by up to 0.1 mm" in caplog.text
