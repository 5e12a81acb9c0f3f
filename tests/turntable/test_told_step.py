"""A step that the images contradict is refused; the right one, of either sign, and one near it are not."""

import numpy as np
import pytest

from fusion.errors import RecordingError
from fusion.scan.finding import pair_fit as motion
from fusion.turntable.guess.told_step import refuse_contradicted_step
from fusion.turntable.views import Region


def around(views):
    """The box that holds what is seen."""
    points = np.concatenate([v.points for v in views])
    return Region(points.min(axis=0), points.max(axis=0))


def refused(views, step, all_views=None):
    """Why a step is, None where it is not."""
    try:
        refuse_contradicted_step(views, around(all_views or views), step)
    except RecordingError as error:
        return str(error)
    return None


@pytest.mark.parametrize("factor", [1.0, -1.0, 1.1])
def test_the_right_step_passes(owl_scene, factor):
    step = factor * float(owl_scene.angles[1])
    assert refused(owl_scene.views(), step) is None


@pytest.mark.parametrize("degrees", [8.0, 45.0, -45.0])
def test_another_step_is_refused_with_both_numbers(owl_scene, degrees):
    with pytest.raises(RecordingError, match="--step") as caught:
        refuse_contradicted_step(owl_scene.views(), around(owl_scene.views()), float(np.deg2rad(degrees)))
    assert f"{degrees:g} deg, as told" in str(caught.value)


def test_where_the_images_show_no_step_by_themselves_the_told_one_stands(owl_scene):
    views = owl_scene.views()
    # the first view and, of all others, too little to see any turn by
    lost = [views[0], *(v.of(np.arange(101)) for v in views[1:])]
    assert refused(lost, float(np.deg2rad(45)), views) is None


@pytest.mark.parametrize("unit", [1.0, np.pi / 180, 0.5, 400 / 360])
def test_the_owl_by_a_log_in_another_unit(owl_scene, unit):
    told = np.deg2rad(unit * np.rad2deg(owl_scene.angles))
    views = owl_scene.views()
    found, followed = motion._motion(views, around(views), motion._Known(told, None, True))
    steps = np.abs(np.diff(found.angles))
    assert np.rad2deg(steps) == pytest.approx(20.0, abs=0.5)
    assert (followed is not None) == (unit > 0.1)
