"""What the whole process shares is read only, or set by one thread at a time."""

import threading
import warnings

import matplotlib
import numpy as np
import pytest
from side_by_side import compared, switching_often

from fusion.calibration.noise import repeats
from fusion.geometry.camera import Camera
from fusion.report.kit.palette import new_figure, styled, to_svg
from fusion.sensor.effects.readout import lateral_noise
from fusion.sensor.effects.triangulation import vertical_banding
from fusion.sensor.laws.fields import frozen_field, frozen_map
from fusion.sensor.view import stretch
from fusion.simulation.demo.demo_object import demo_object
from fusion.simulation.rendering.casting import directions
from fusion.volume.extraction.cubes import table
from fusion.volume.integration.allocate import _span
from fusion.volume.integration.frame import geometry
from fusion.volume.lens import lens
from fusion.volume.raycasting.shade import slants
from fusion.volume.settings import VolumeSettings

CAMERA = Camera(64, 48, 60.0, 60.0, 31.5, 23.5, (0.1,))
KEPT = {
    "rays": lambda: [CAMERA.rays()],
    "stretch": lambda: [stretch(CAMERA)],
    "directions": lambda: [directions(CAMERA)],
    "lens": lambda: [lens(CAMERA)],
    "slants": lambda: slants(CAMERA),
    "geometry": lambda: [getattr(geometry(CAMERA), name) for name in ("x", "y", "bend", "cells")],
    "span": lambda: [_span(VolumeSettings(0.01, 0.04))],
    "cubes": lambda: [table()],
    "fields": lambda: [frozen_field((8, 9), 1.0, "a", 0), frozen_map((8, 9), 1.0, "a", 0)],
    "bands": lambda: [vertical_banding._frozen_steps(64, 1)],
    "shares": lateral_noise._normal_shares,
    "rounding": repeats._table,
}


@pytest.mark.parametrize("name", KEPT)
def test_kept_arrays_are_the_same_for_all_and_read_only(name):
    for first, again in zip(KEPT[name](), KEPT[name](), strict=True):
        assert np.shares_memory(first, again)
        with pytest.raises(ValueError, match="read-only"):
            first[...] = 0


def test_the_demo_object_is_the_callers():
    changed = demo_object()
    changed.vertices[:] = 0
    assert np.ptp(demo_object().vertices) > 0.2


def test_figures_of_two_threads_have_the_style_and_leave_none():
    def drawn(width: float) -> str:
        with styled():
            figure = new_figure(width, 2)
            figure.subplots().plot([1, 2, 3], label="line")
        return to_svg(figure, "name")

    before = dict(matplotlib.rcParams)
    assert not compared(lambda: drawn(3), lambda: drawn(5), rounds=3)
    assert dict(matplotlib.rcParams) == before


def test_frames_without_a_value_change_no_filter_of_warnings():
    """Filters are the whole process's: set back in the wrong order by two threads, all warnings would be lost."""
    squares = np.random.default_rng(0).random((40, 30))
    squares[7] = np.nan
    before, expected = list(warnings.filters), repeats.batch_error(squares)
    with switching_often():
        threads = [threading.Thread(target=lambda: [repeats.batch_error(squares) for _ in range(200)]) for _ in "ab"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert warnings.filters == before
    assert expected == pytest.approx(repeats.batch_error(np.delete(squares, 7, axis=0)))
