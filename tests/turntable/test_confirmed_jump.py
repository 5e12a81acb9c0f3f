"""A jump of free tracking counts where views before and after do not fit each other on the axis."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fusion.geometry import pose
from fusion.geometry.depth import point_map
from fusion.geometry.trajectory import Trajectory
from fusion.scan.judging import missed
from fusion.scan.judging.missed import confirmed
from fusion.turntable.axis import about_axis
from fusion.turntable.jumps import Jump
from fusion.turntable.views import Region

PUSHED = 8
EVERYWHERE = Region(np.full(3, -9.0), np.full(3, 9.0))


@pytest.fixture(scope="module")
def scan(owl_scene):
    """Frames of an owl, the region around it, and their places by the axis."""
    maps = [point_map(d.astype(np.float32), owl_scene.camera, 0.001) for d in owl_scene.depths]
    frames = [SimpleNamespace(surface=m) for m in maps]
    points = np.concatenate([v.points for v in owl_scene.views()])
    region = replace(EVERYWHERE, low=points.min(axis=0), high=points.max(axis=0))
    return frames, region, Trajectory(np.arange(float(len(frames))), about_axis(owl_scene.axis, owl_scene.angles))


def pushed(places, by):
    """The places that the axis gives where the object was pushed before a frame: wrong from then on."""
    moved = places.poses.copy()
    moved[PUSHED:] = pose.inverse(pose.pose(np.eye(3), np.array([by, 0, 0]))) @ moved[PUSHED:]
    return replace(places, poses=moved)


def test_a_push_is_confirmed_with_its_size(scan):
    frames, region, places = scan
    found = confirmed(Jump(PUSHED, 0.006, "object"), frames, region, pushed(places, 0.006))
    assert found is not None and found.frame == PUSHED
    assert found.distance == pytest.approx(0.006, rel=0.2)


def test_where_tracking_lost_its_way_nothing_moved(scan):
    frames, region, places = scan
    assert confirmed(Jump(PUSHED, 0.006, "object"), frames, region, places) is None
    assert confirmed(None, frames, region, places) is None


def test_views_that_slide_on_each_other_show_no_push(scan, monkeypatch):
    """They lie elsewhere when they are aligned directly, and fit no better there."""
    frames, region, places = scan
    aligned = missed.aligned

    def loose(*arguments):
        found = aligned(*arguments)
        return None if found is None else replace(found, information=1e-4 * found.information)

    monkeypatch.setattr(missed, "aligned", loose)
    assert confirmed(Jump(PUSHED, 0.006, "object"), frames, region, pushed(places, 0.006)) is None


def test_a_gap_is_told_in_deviations_of_what_the_two_views_tell(scan):
    """Where the axis is right the noise of the views explains it, where the object was pushed by 6 mm it does not."""
    frames, region, places = scan
    pair = (PUSHED - 1, PUSHED)
    direct = missed.aligned(frames, region, places, pair)
    right, wrong = (missed.gap_of(frames, region, t, pair, direct) for t in (places, pushed(places, 0.006)))
    assert right.deviations < 1 and wrong.deviations > 5
    assert wrong.distance == pytest.approx(0.006, rel=0.2)
    loose = replace(direct, information=1e-4 * direct.information)
    assert missed.gap_of(frames, region, pushed(places, 0.006), pair, loose).deviations < 1


def test_the_closing_gap_counts_in_what_other_views_miss_each_other_by(scan):
    """One turn and a little: closed it is no gap, left open by 6 mm it is one, unless all views miss by that."""
    frames, region, places = scan
    again, turns = [*frames, *frames[:2]], np.deg2rad(20.0) * np.arange(len(frames) + 2)
    whole = Trajectory(np.arange(float(len(again))), np.concatenate([places.poses, places.poses[:2]]))
    off = pose.inverse(pose.pose(np.eye(3), np.array([0.006, 0, 0])))
    opened = replace(whole, poses=np.concatenate([places.poses, off @ places.poses[:2]]))
    shaken = whole.poses.copy()
    shaken[1::2] = off @ shaken[1::2]
    # an odd frame lies 6 mm from the even ones all along; the last two are as far from the first two
    shaken[-2:] = opened.poses[-2:]
    closed, wide, usual = (
        missed.closing_gaps(again, region, (t, t), turns)[0] for t in (whole, opened, replace(whole, poses=shaken))
    )
    assert closed.deviations < 1 and wide.deviations > 5
    assert usual.deviations < 0.5 * wide.deviations
    assert missed.closing_gaps(frames[:8], region, (places, places), turns[:8]) == (None, None)
