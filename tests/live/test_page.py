"""The page: what it says, what it refuses, and that it does without viser."""

import socket

import numpy as np
import pytest

from fusion.errors import DeviceError
from fusion.live.page import SURE, UNSURE, LivePage, _motor, colors_of, panel
from fusion.live.state import LiveState


def test_the_panel_tells_why_and_where_to_go_back_to():
    seen = (True,) * 9 + (False,) * 27
    text = panel(LiveState(tracking="lost", reason="a < b", back_to=-10.0, seen=seen, left=300.0))
    for words in ("tracking lost", "a &lt; b", "go back to about 350&deg;", ">90&deg;<", "5 min left", "not known yet"):
        assert words in text
    assert text.count("#3fb950") == 9


def test_a_camera_is_warm_after_half_an_hour():
    assert "warming up" in panel(LiveState(warm=60.0))
    assert ">warm<" in panel(LiveState(warm=1801.0))


def test_sure_is_green_and_unsure_is_red():
    green, red = colors_of(np.array([SURE, UNSURE], np.float32))
    assert green[1] == 255
    assert green[0] == 0
    assert red[0] == 255
    assert red[1] == 0


def test_a_taken_port_is_one_line():
    pytest.importorskip("viser", reason="needs viser: pip install 'fusion-scan[live]'")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(DeviceError, match=rf"the page's port cannot be had; in port {port}"):
            LivePage(port)


def test_without_viser_it_is_told_how_to_get_it(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "viser", None)
    with pytest.raises(DeviceError, match=r"fusion-scan\[live\]"):
        LivePage(8080)


def test_a_camera_whose_motor_does_not_answer_is_not_tilted_and_the_page_opens():
    class Mute:
        @property
        def motor(self):
            raise DeviceError("this Kinect's motor does not answer")

    assert _motor(Mute()) is None
    assert _motor(object()) is None


def test_what_is_told_is_a_plain_string():
    assert type(panel(LiveState())) is str  # viser sends no other
