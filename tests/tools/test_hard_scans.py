"""The hard set: what is drawn, what is rendered, what is planted, and the rules by which a scan is good."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from tools.sets import hard_scans
from tools.sets.hard import judged as judging
from tools.sets.hard.cameras import Stereo, shaded, smoothed
from tools.sets.hard.drawing import drawn
from tools.sets.hard.judged import Judged, summary
from tools.sets.hard.making import make
from tools.sets.hard.planting import PLANTED, STILL, SWAPPED, TIPPED, TUMBLED, UNIT, WALK
from tools.sets.hard.stage import OBJECT
from tools.sets.hard.turning import MOST, by_hand, whole
from tools.sets.judging.measured import Compared
from tools.sets.judging.said import Said
from tools.sets.planted.measure import Surface


def first(scan, count=2):
    """The first frames of a scan alone."""
    turns = scan.turning
    logged = None if turns.logged is None else turns.logged[:count]
    few = replace(
        turns, degrees=turns.degrees[:count], logged=logged, shift=turns.shift[:count], hand=turns.hand[:count]
    )
    scan.stage.T_world_camera = scan.stage.T_world_camera[:count]
    return replace(scan, turning=few, T_world_item=scan.T_world_item[:count], exposure=scan.exposure[:count])


def small(planted="", seed=1):
    """A scan by a camera of few pixels."""
    for k in range(seed, seed + 50):
        scan = drawn("scan", planted, np.random.default_rng(k))
        if scan.story["camera"] in ("d435-small", "kinect-v1-half"):
            return scan
    raise AssertionError


def test_the_object_is_where_its_poses_say(tmp_path):
    scan = first(small())
    make(scan, tmp_path / "scan", np.random.default_rng(0))
    points = np.load(tmp_path / "scan" / "truth" / "visible.npz")["points"]
    assert Surface(scan.item).distance(points[::20]).max() < 1e-3
    T = np.linalg.inv(scan.stage.T_world_camera[1]) @ scan.T_world_item[1]
    own = points[len(points) // 2 :] @ T[:3, :3].T + T[:3, 3]
    camera = scan.stage.camera
    u = np.rint(camera.f * own[:, 0] / own[:, 2] + camera.cx).astype(int)
    v = np.rint(camera.f * own[:, 1] / own[:, 2] + camera.cy).astype(int)
    for part, share in (("masked", 0.7), ("recording", 0.7)):
        file = sorted((tmp_path / "scan" / part / "depth").iterdir())[1]
        depth = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)[v, u] / 1000
        assert (depth > 0).mean() > share
        assert np.median(np.abs(depth - own[:, 2])[depth > 0]) < 0.004


def test_a_recording_holds_no_truth_and_is_made_of_its_seed(tmp_path):
    for name, seed in (("a", 0), ("b", 0), ("c", 1)):
        make(first(small()), tmp_path / name, np.random.default_rng(seed))
    files = sorted(p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*.png"))
    same = [(tmp_path / "a" / p).read_bytes() == (tmp_path / "b" / p).read_bytes() for p in files]
    other = [(tmp_path / "a" / p).read_bytes() == (tmp_path / "c" / p).read_bytes() for p in files]
    assert files and all(same) and not all(other)
    names = {p.name for p in (tmp_path / "a" / "recording").iterdir()}
    assert names - {"telemetry.csv"} == {"camera.json", "depth", "depth.txt", "rgb", "rgb.txt"}


def test_streams_are_apart_and_every_fourth_is_planted(tmp_path, monkeypatch):
    drawings = []

    def noted(name, planted, rng):
        drawings.append((planted, float(rng.random())))

    monkeypatch.setattr(hard_scans, "drawn", noted)
    monkeypatch.setattr(hard_scans, "make", lambda *_: None)
    for k in range(32):
        hard_scans.made((hard_scans.STREAMS[False], 1), k, tmp_path)
    hard_scans.made((hard_scans.STREAMS[True], 1), 0, tmp_path)
    assert [p for p, _ in drawings[:32] if p] == list(PLANTED)
    assert drawings[0][1] != drawings[32][1]


@pytest.mark.parametrize("kind", PLANTED)
def test_what_is_planted_is_there(kind):
    scan = small(kind, 3)
    turned = np.abs(np.diff(scan.T_world_item[:, :3, :3], axis=0)).max()
    camera = np.abs(np.diff(scan.stage.T_world_camera, axis=0)).max()
    assert (turned < 1e-12) == (kind in (STILL, WALK))
    assert (camera > 1e-3) == (kind in (WALK, "the camera is moved half way"))
    assert (scan.unit != 1) == (kind == UNIT)
    assert (sum(m.part == OBJECT for m in scan.stage.moving) == 2) == (kind == SWAPPED)
    plate = np.abs(np.diff(scan.stage.moving[1].poses[:, :3, :3], axis=0)).max()
    assert kind == SWAPPED or (plate < 1e-12) == (kind in (STILL, WALK, TUMBLED))
    upright = scan.T_world_item[-1, 2, 2] > 0.999
    assert upright == (kind not in (TIPPED, TUMBLED))


def test_a_hand_turns_by_no_more_than_sixty_degrees():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        degrees = whole(rng)
        turns = by_hand(rng, degrees, True)
        assert np.abs(np.diff(turns.degrees)).max() <= MOST
        assert degrees <= abs(turns.degrees[-1]) < degrees + MOST
        assert np.linalg.norm(turns.shift, axis=1).max() < 0.009


def test_a_filter_smooths_within_surfaces_only():
    d = np.where(np.arange(40) < 20, 10.0, 30.0) + 0.1 * np.random.default_rng(0).standard_normal((30, 40))
    out = smoothed(d, np.ones(d.shape, bool))
    assert out[:, :20].std() < 0.5 * d[:, :20].std()
    assert np.abs(out[:, 19] - 10).max() < 0.3 and np.abs(out[:, 20] - 30).max() < 0.3


def test_what_is_near_shades_the_left_of_itself():
    d = np.full((1, 60), 10.0)
    d[0, 30:40] = 18.0
    hidden = np.flatnonzero(shaded(d)[0])
    assert hidden.min() >= 22 and hidden.max() < 30 and len(hidden) >= 7
    assert Stereo.principle == "active_stereo"


def test_a_mesh_is_good_by_its_rms_and_what_it_covers(tmp_path, monkeypatch):
    (tmp_path / "truth").mkdir()
    told = {"planted": "", "angles_rad": [0.0, 0.1], "story": {}}
    for planted, rms, covered, good in (
        ("", 0.0014, 0.9, True), ("", 0.0016, 0.9, False), ("", 0.0010, 0.7, False), (STILL, 0.001, 0.9, False),
        (TIPPED, 0.001, 0.9, True),
    ):  # fmt: skip
        (tmp_path / "truth" / "truth.json").write_text(json.dumps(told | {"planted": planted}))
        found = iter([Compared(rms, rms, 1.0, covered), Compared(0.001, 0.001, 1.0, 0.95)])
        monkeypatch.setattr(judging, "compared", lambda *_, found=found: next(found))
        monkeypatch.setattr(judging, "fusion", lambda *_: judging_ran())
        assert judging.judged(tmp_path).good == good


def judging_ran():
    from tools.sets.judging.command import Ran

    return Ran(0, "", 1.0)


def test_false_words_are_counted():
    def one(name, good, verdict, planted=""):
        return Judged(name, planted, {}, Said(verdict, True, 0, ()), good, *[0.001] * 2, 1.0, 1.0, 0.1, 5, 1.0)

    told = summary(
        [one("a", True, "good"), one("b", False, "good"), one("c", True, "failed"), one("d", False, "failed", STILL)]
    )
    assert "false good: 1 of 4 b" in told
    assert "good, said failed: 1 c" in told
