"""A slab on a round plate is the object's own; one close above a table is the plate."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_up_scan import good_scan

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.recording.recording import Frame, Recording
from fusion.scan.finding.plate_seen_whole import on_its_plate
from fusion.sensor.presets import default_sensor
from fusion.simulation.demo.demo import looking_at
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.shapes import box, disc, joined
from fusion.turntable.axis import Axis

CAMERA = Camera(160, 120, 140.0, 140.0, 79.5, 59.5)
GREY = (180, 180, 180)
BOOK = box((-0.1, -0.065, 0.0), (0.1, 0.065, 0.02), GREY)
PLATE = disc(0.2, -0.012, 0.0, lambda p: np.full((len(p), 3), 180))
TABLE = box((-1.0, -1.0, -0.02), (0.5, 1.0, 0.0), GREY)
DESK = box((-1.0, -1.0, -0.32), (0.5, 1.0, -0.3), GREY)


@pytest.mark.parametrize(("below", "round_plate"), [((PLATE, DESK), True), ((TABLE,), False)], ids=["plate", "table"])
def test_what_lies_below_a_slab_is_told_by_its_rim(below, round_plate):
    T = looking_at(np.array([0.75, 0.05, 0.55]), np.array([0.0, 0.0, 0.0]))
    depth = RayCaster(joined([BOOK, *below])).view(CAMERA, T).depth.astype(np.float32)
    stamps = np.arange(6.0)
    recording = Recording(Path("made"), "made", CAMERA, stamps, lambda i: Frame(i, float(stamps[i]), depth.copy()))
    T_camera_world = pose.inverse(T)
    up = T_camera_world[:3, 2]
    slab = replace(
        good_scan().motion,
        axis=Axis(T_camera_world[:3, 3] + 0.02 * up, up),
        table=-0.02,
        plate=0.0,
        bottom=-0.02,
        top=0.1,
    )
    found = on_its_plate(slab, recording, default_sensor(CAMERA))
    assert (found.table is None) == round_plate
    if round_plate:  # the axis' point lies on the round plate, and heights count from there
        assert np.allclose(found.axis.point, T_camera_world[:3, 3])
        assert found.bottom == pytest.approx(0.0) and found.top == pytest.approx(0.12)
    assert on_its_plate(replace(slab, table=None), recording, default_sensor(CAMERA)).table is None
