"""What lies between camera and recorder: the recorder gets every frame, whatever becomes of the view."""

import threading

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fusion.devices.source import Description, SourceFrame
from fusion.geometry.camera import Camera
from fusion.live.feed import FEW, PATIENCE, WAITING, Feed
from fusion.live.grow import Turned
from fusion.live.session import strike
from fusion.live.state import SECTORS, LiveState

CAMERA = Camera(32, 24, fx=30.0, fy=30.0, cx=15.5, cy=11.5)


class Steady:
    """A source of so many empty frames; `given` of them were asked for."""

    def __init__(self, count: int, stepped: bool = False) -> None:
        self.count, self.stepped, self.given = count, stepped, 0

    def describe(self) -> Description:
        return Description("steady", CAMERA, stepped=self.stepped)

    def frames(self):
        for k in range(self.count):
            self.given += 1
            yield SourceFrame(k, k / 30, np.ones(CAMERA.shape, np.float32), missed=int(k == 5))

    def start(self) -> None:
        pass

    def stop(self) -> None:
        pass


def test_a_view_that_takes_nothing_costs_the_recorder_nothing():
    feed = Feed(Steady(200))
    assert [frame.index for frame in feed.frames()] == list(range(200))
    assert (feed.recorded, feed.lost, feed.dropped) == (200, 1, 200 - WAITING)
    taken = [feed.take() for _ in range(WAITING)]
    assert [one[0].index for one in taken] == list(range(200 - WAITING, 200))
    assert feed.take() is None


def waited(feed: Feed, until: float, each: float) -> list[float]:
    """How old [s] each frame is when a view begins with it that takes `each` seconds, at 30 frames a second."""
    now, index, ages = 0.0, 0, []
    while now < until:
        while index / 30 <= now:
            feed.offer(SourceFrame(index, index / 30, np.ones(CAMERA.shape, np.float32)), index / 30)
            index += 1
        if feed.offered:
            ages.append(now - feed.offered.popleft()[1])
            now += 0.5 if len(ages) == 30 else each  # one step that takes long
        else:
            now = index / 30
    return ages


def test_a_view_that_keeps_up_makes_up_for_a_long_step_and_loses_nothing():
    feed = Feed(Steady(0))
    feed.room = FEW
    ages = waited(feed, 5.0, 0.02)
    assert feed.dropped == 0
    assert max(ages) > 0.4
    assert np.median(ages) < 0.05


def test_a_view_that_is_too_slow_is_never_long_behind():
    feed = Feed(Steady(0))
    feed.room = FEW
    ages = waited(feed, 10.0, 0.05)
    assert 60 < feed.dropped < 130  # a third of 300
    patient = int(PATIENCE / 0.05)  # frames taken until then
    assert max(ages[patient:]) <= (FEW + 1) / 30 + 0.05


def test_frames_of_a_pause_are_in_neither():
    feed = Feed(Steady(10), paused=True)
    assert list(feed.frames()) == []
    assert feed.take() is None


def test_a_stepped_table_waits_in_a_pause_and_loses_no_place():
    source = Steady(10, stepped=True)
    feed = Feed(source)
    frames = feed.frames()
    taken = [next(frames).index for _ in range(4)]
    feed.paused = True
    rest = threading.Thread(target=lambda: taken.extend(one.index for one in frames))
    rest.start()
    rest.join(0.3)
    assert rest.is_alive() and source.given == 4  # nothing is taken, so the table is not sent on
    feed.paused = False
    rest.join(30)
    assert taken == list(range(10))


def test_a_stepped_table_can_be_stopped_in_a_pause():
    source = Steady(10, stepped=True)
    feed = Feed(source, paused=True)
    threading.Timer(0.2, feed.stop).start()
    assert list(feed.frames()) == []
    assert source.given == 0


@pytest.mark.parametrize("sign", [1, -1])
def test_turns_add_up_past_a_whole_one_and_fill_the_ring(sign):
    turned = Turned()
    for degrees in range(0, 401, 4):
        T = np.eye(4)
        T[:3, :3] = Rotation.from_rotvec(sign * np.deg2rad(degrees) * np.array([0.1, 0.9, -0.3]) / 0.954).as_matrix()
        turned.placed(T)
    # the axis above has a length of 0.9539: its turns are as much shorter
    assert np.rad2deg(turned.angle) == pytest.approx(400 * 0.9539 / 0.954, abs=0.1)
    assert turned.seen.sum() == SECTORS


def test_frames_that_were_taken_back_leave_the_lists_and_nothing_else(tmp_path):
    (tmp_path / "depth.txt").write_text("# depth\n" + "".join(f"{k / 10:.6f} depth/{k}.png\n" for k in range(10)))
    (tmp_path / "rgb.txt").write_text("# color\n0.300000 rgb/3.png\n0.800000 rgb/8.png\n")
    assert strike(tmp_path, [(0.2, 0.6)]) == 3
    kept = [line.split()[1] for line in (tmp_path / "depth.txt").read_text().splitlines()[1:]]
    assert kept == [f"depth/{k}.png" for k in (0, 1, 2, 6, 7, 8, 9)]
    assert (tmp_path / "rgb.txt").read_text() == "# color\n0.800000 rgb/8.png\n"
    assert "rgb/3.png" in (tmp_path / "undone.txt").read_text()


def test_a_line_says_why_tracking_is_not_good():
    assert "tracking lost: nothing turns yet" in LiveState().line()
    assert "tracking good;" in LiveState(tracking="good", reason="").line()
