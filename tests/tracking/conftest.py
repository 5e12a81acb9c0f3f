"""The rooms are imported by name from tests/reference."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "reference"))

from small_room import Room, room_mesh

from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.shapes import box


@pytest.fixture(scope="session")
def room() -> Room:
    return Room(RayCaster(room_mesh()))


@pytest.fixture(scope="session")
def wall() -> Room:
    """Nothing but a plane."""
    return Room(RayCaster(box((-5, -5, 1.2), (5, 5, 1.3), (128, 128, 128))))
