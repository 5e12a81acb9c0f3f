"""Looks for what turns are taken at once, or beside who shows the images."""

from concurrent.futures import Executor, Future

import numpy as np
import pytest

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.live import looking
from fusion.live.looking import FEWEST, SOON, Looking
from fusion.sensor.presets import default_sensor
from fusion.turntable.turning.moving import Moving

CAMERA = Camera(32, 24, 30.0, 30.0, 15.5, 11.5)
FLAT = np.ones(CAMERA.shape, np.float32)
FOUND = Moving(np.zeros((0, 3)), np.zeros(3), np.ones(3), FLAT > 2, np.full(CAMERA.shape, np.nan, np.float32))


class WhenTold(Executor):
    """Does its work when it is told to."""

    def __init__(self) -> None:
        self.waiting = []

    def submit(self, work, /, *args):
        future = Future()
        self.waiting.append((future, work, args))
        return future

    def work(self) -> None:
        for future, work, args in self.waiting:
            try:
                future.set_result(work(*args))
            except Exception as error:
                future.set_exception(error)
        self.waiting.clear()


def show(one: Looking, first: int, last: int) -> None:
    for index in range(first, last):
        one.see(float(index), FLAT)


def made(monkeypatch, beside, find) -> Looking:
    monkeypatch.setattr(looking, "find_moving", find)
    one = Looking(CAMERA, default_sensor(CAMERA))
    one.beside = beside
    return one


def test_who_shows_the_images_need_not_wait(monkeypatch):
    beside, shown = WhenTold(), []
    one = made(monkeypatch, beside, lambda samples, *_: shown.append(len(samples)) or FOUND)
    show(one, 0, 2 * FEWEST)
    assert one.region is None and len(beside.waiting) == 1  # not a second look while the first is under way
    beside.work()
    show(one, 2 * FEWEST, 2 * FEWEST + 1)
    assert one.region is not None and one.finds == 1 and shown == [FEWEST]


def test_at_once_it_looks_again_soon_after_it_found_something(monkeypatch):
    shown = []
    one = made(monkeypatch, None, lambda samples, *_: shown.append(len(samples)) or FOUND)
    show(one, 0, FEWEST + SOON)
    assert shown == [FEWEST, FEWEST + SOON] and one.finds == 2


@pytest.mark.parametrize("beside", [None, WhenTold()])
def test_nothing_turns_yet(monkeypatch, beside):
    def nothing(*_):
        raise TrackingError("nothing moves")

    one = made(monkeypatch, beside, nothing)
    show(one, 0, FEWEST)
    if beside is not None:
        beside.work()
    show(one, FEWEST, FEWEST + 2)
    assert one.region is None and one.finds == 0


def test_what_goes_wrong_beside_is_told_to_who_shows_the_images(monkeypatch):
    def wrong(*_):
        raise ValueError("broken")

    beside = WhenTold()
    one = made(monkeypatch, beside, wrong)
    show(one, 0, FEWEST)
    beside.work()
    with pytest.raises(ValueError, match="broken"):
        show(one, FEWEST, FEWEST + 1)
