"""What the view needs is compiled before the first frame comes."""

import pytest

from fusion.compute import launch
from fusion.geometry.camera import Camera
from fusion.live.grow import Grower
from fusion.live.session import get_ready


@pytest.mark.parametrize("camera", [Camera(160, 120, 144.0, 144.0, 79.5, 59.5), Camera(32, 24, 30.0, 30.0, 15.5, 11.5)])
def test_the_ball_is_placed_and_fused(camera, monkeypatch):
    taken, surfaces, take, surface = [], [], Grower.take, Grower.surface
    monkeypatch.setattr(Grower, "take", lambda self, frame: taken.append(take(self, frame)) or taken[-1])
    monkeypatch.setattr(Grower, "surface", lambda self: surfaces.append(surface(self)))
    get_ready(camera)
    if camera.width == 160:  # in fewer pixels too little of it shows, and that is no error
        assert [one.tracked.ok for one in taken] == [True, True]
        assert len(surfaces[0].points) > 1000
    slow = []  # calls that the back end has to read a kernel for
    reading = launch.reading
    monkeypatch.setattr(launch, "reading", lambda: slow.append(1) or reading())
    get_ready(camera)
    assert not slow or not launch.KNOWN
