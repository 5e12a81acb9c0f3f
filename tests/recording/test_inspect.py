"""The doctor: every planted defect is found, a clean recording is left in peace."""

import json
import os
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import synthetic

from fusion.commands.main import main
from fusion.geometry.pose import from_tum, inverse, to_tum
from fusion.geometry.trajectory import Trajectory
from fusion.recording.looking.inspect import fingerprint, inspect
from fusion.recording.native.camera_file import write_camera
from fusion.recording.native.trajectory_file import write_trajectory
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording

SHARED = Path(os.environ.get("FUSION_SHARED", Path(__file__).parents[3] / "shared"))

# what other programs call the axes of a camera: (4, 4) from OpenCV's x right, y down, z forward
OPENGL = np.diag([1.0, -1, -1, 1])  # y up, z back
BODY = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])  # to x forward, y left, z up
LEFT = np.diag([1.0, -1, 1, 1])  # y up, and left-handed


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "r"
    write_recording(path, synthetic.CAMERA, synthetic.frames(12, color=True), synthetic.trajectory(12))
    return path


def edit(path, change):
    path.write_text("".join(change(path.read_text().splitlines(keepends=True))))


def recount(folder, change):
    for path in sorted((folder / "depth").iterdir()):
        counts = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(str(path), np.rint(change(counts.astype(float))).astype(np.uint16))


def recamera(folder, **changes):
    write_camera(folder / "camera.json", replace(synthetic.CAMERA, **changes))


def truncated(folder):
    path = folder / "depth/000005.png"
    path.write_bytes(path.read_bytes()[:-2000])


def bit_error(folder):
    path = folder / "depth/000005.png"
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 16
    path.write_bytes(bytes(data))


def as_range(folder):
    recount(folder, lambda counts: counts * np.sqrt(1 + (synthetic.CAMERA.rays() ** 2).sum(axis=-1)))


def other_code(folder):
    recount(folder, lambda counts: np.where(counts == 0, 8191, counts))


def two_codes(folder):
    dark = np.indices(synthetic.CAMERA.shape).sum(axis=0) % 2 == 0
    recount(folder, lambda counts: np.where(counts == 0, np.where(dark, 32001, 32002), counts))


def poses_with(folder, change):
    given = synthetic.trajectory(12)
    write_trajectory(folder / "groundtruth.txt", Trajectory(given.timestamps, change(given.poses)))


def with_w_first(poses):
    """As a file of qw qx qy qz is read."""
    values = [to_tum(T) for T in poses]
    return np.stack([from_tum([*v[:3], v[6], v[3], v[4], v[5]]) for v in values])


def millimetres(poses):
    return np.concatenate([poses[:, :3] * [1, 1, 1, 1000], poses[:, 3:]], axis=1)


def scattered(poses):
    """Off by 10 cm each: more than what agrees at 2 m."""
    off = poses.copy()
    off[:, :3, 3] += np.random.default_rng(3).normal(0, 0.1, (len(poses), 3))
    return off


def shuffled(lines):
    return lines[:4] + lines[4:7][::-1] + lines[7:]


# defect: (how to plant it, severity, check, a word of what is seen, a word of what to do)
DEFECTS = {
    "scale 5000 for 1000": (lambda f: recamera(f, depth_scale=20000), "error", "depth", "median", "1000"),
    "scale 100 for 1000": (lambda f: recamera(f, depth_scale=100), "error", "depth", "median", "1000"),
    "scale against the poses": (lambda f: recamera(f, depth_scale=500), "error", "depth", "agrees", "1000"),
    "millimetres times five": (lambda f: recount(f, lambda c: 5 * c), "warning", "depth", "multiples of 5", "5000"),
    "range": (as_range, "error", "range or z", "bow", "along the ray"),
    "inverted poses": (lambda f: poses_with(f, inverse), "error", "poses", "inverted", "world to camera"),
    "poses of OpenGL": (lambda f: poses_with(f, lambda T: T @ OPENGL), "error", "poses", "y up", "convention opengl"),
    "view matrices": (
        lambda f: poses_with(f, lambda T: inverse(T @ OPENGL)),
        "error",
        "poses",
        "inverted, with",
        "convention opengl-view",
    ),
    "poses of a robot": (lambda f: poses_with(f, lambda T: T @ BODY.T), "error", "poses", "z up", "convention ros"),
    "poses of Unity": (
        lambda f: poses_with(f, lambda T: LEFT @ T @ LEFT),
        "error",
        "poses",
        "left",
        "convention unity",
    ),
    "w first": (lambda f: poses_with(f, with_w_first), "error", "poses", "w first", "convention w-first"),
    "poses roughly known": (lambda f: poses_with(f, scattered), "warning", "poses", "both see agrees", "few percent"),
    "poses in millimetres": (lambda f: poses_with(f, millimetres), "error", "poses", "1000", "millimetres"),
    "poses on another clock": (
        lambda f: write_trajectory(f / "groundtruth.txt", Trajectory(np.arange(12.0) * 99, synthetic.poses(12))),
        "error",
        "poses",
        "within 0.02 s",
        "clock",
    ),
    "unsorted": (lambda f: edit(f / "depth.txt", shuffled), "warning", "stamps", "back", "sort"),
    "duplicate": (
        lambda f: edit(f / "depth.txt", lambda t: t[:5] + t[4:]),
        "warning",
        "stamps",
        "one before",
        "doubled",
    ),
    "gap": (
        lambda f: edit(f / "depth.txt", lambda t: [*t, "109.9 depth/000000.png\n"]),
        "warning",
        "stamps",
        "gap",
        "missing",
    ),
    "unassociated": (
        lambda f: edit(f / "rgb.txt", lambda t: [x.replace("100.", "555.") for x in t]),
        "warning",
        "stamps",
        "rgb.txt",
        "clock",
    ),
    "truncated": (truncated, "error", "files", "cut off", "again"),
    "bit error": (bit_error, "error", "files", "check sum", "again"),
    "missing file": (lambda f: (f / "depth/000003.png").unlink(), "error", "files", "missing", "again"),
    "size": (lambda f: recamera(f, width=320, height=240, cx=160, cy=120), "error", "files", "160 x 120", "--camera"),
    "principal point": (lambda f: recamera(f, cx=159.5, cy=119.5), "error", "intrinsics", "cx", "320"),
    "focal length": (lambda f: recamera(f, fx=1300, fy=1300), "warning", "intrinsics", "field of view", "--camera"),
    "another code": (other_code, "warning", "depth", "8191", "missing"),
    "two other codes": (two_codes, "warning", "depth", "32001 and 32002", "missing"),
    "no depth": (lambda f: recount(f, lambda c: 65535 + 0 * c), "error", "depth", "no valid", "look"),
}


def test_a_clean_recording_is_left_in_peace(folder):
    findings = inspect(open_recording(folder))
    assert findings.severity == "ok", findings
    assert {"files", "stamps", "depth", "intrinsics", "resolution", "range or z", "poses"} == {
        f.check for f in findings.findings
    }
    assert findings.summary["frames"] == 12
    # 30 Hz with stamps of six decimals
    assert findings.summary["frames_per_second"] == pytest.approx(30, rel=1e-4)
    json.dumps(findings.to_dict(), allow_nan=False)


@pytest.mark.slow
@pytest.mark.parametrize("name", DEFECTS)
def test_defect(folder, name):
    plant, severity, check, seen, do = DEFECTS[name]
    plant(folder)
    findings = inspect(open_recording(folder))
    hits = [f for f in findings.findings if f.check == check and f.severity == severity and seen in f.seen]
    assert hits and any(do in hit.do for hit in hits), findings.findings


def test_fingerprint_tells_recordings_apart(folder):
    before = fingerprint(open_recording(folder))
    assert before == fingerprint(open_recording(folder))
    recamera(folder, fx=131.0)
    assert before != fingerprint(open_recording(folder))


def test_command(folder, capsys, tmp_path):
    assert main(["info", str(folder)]) == 0
    assert "160 x 120" in capsys.readouterr().out
    assert main(["info", str(folder), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["severity"] == "ok"
    truncated(folder)
    assert main(["info", str(folder), "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["severity"] == "error"
    assert main(["info", str(tmp_path / "nothing")]) == 1
    assert capsys.readouterr().err.count("\n") == 1


def test_convert_command(folder, capsys, tmp_path):
    assert main(["convert", str(folder), str(tmp_path / "n")]) == 0
    assert open_recording(tmp_path / "n").camera == synthetic.CAMERA
    truncated(folder)
    assert main(["convert", str(folder), str(tmp_path / "m")]) == 1
    assert "000005.png" in capsys.readouterr().err and not (tmp_path / "m").exists()


@pytest.mark.real
@pytest.mark.parametrize(
    "name",
    ["kleenex_turntable", "tum_fr1_rpy", "ycbv_0000", "robot_arm_boxes", "turntable", "dev_00", "dev_01", "dev_07"],
)
def test_no_false_alarm_on_real_recordings(name):
    data, challenges = SHARED / "data", SHARED / "challenges"
    folders = [data / name, *challenges.glob(f"{name}/*/scan"), *challenges.glob(f"cases/{name}/rec_*")]
    folders = [path for path in folders if (path / "depth.txt").is_file()]
    if not folders:
        pytest.skip("the recordings are not here")
    for path in folders:
        findings = inspect(open_recording(path, "tum-fr1" if name == "tum_fr1_rpy" else None))
        assert findings.severity == "ok", (path, findings.findings)
