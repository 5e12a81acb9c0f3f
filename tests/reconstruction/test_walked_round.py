"""Who walks round one thing scans an object; who looks about, or walks along or across, scans a room."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.geometry.pose import exp
from fusion.geometry.trajectory import Trajectory
from fusion.reconstruction.pipeline import reconstruct
from fusion.reconstruction.planning import plan
from fusion.reconstruction.settings import ReconstructSettings
from fusion.reconstruction.walked_round import StandingView, walked_round
from fusion.recording.recording import Frame, Recording
from fusion.sensor.presets import default_sensor
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.course import looking_at
from fusion.simulation.scene.shapes import box, joined

CAMERA = Camera(160, 120, 144.0, 144.0, 79.5, 59.5)  # 58 x 45 deg
THING = np.array([0.0, 0.0, 0.85])  # the middle of what stands on the table
GREY = (120, 120, 120)
FREE = ReconstructSettings(color=False)


def room():
    """4.4 x 4 x 2.5 m, z up, a cupboard and a shelf along the walls, a table in the middle with a thing on it."""
    walls = [
        box((-2.3, -2.1, -0.1), (2.3, 2.1, 0.0), GREY), box((-2.3, -2.1, 2.5), (2.3, 2.1, 2.6), GREY),
        box((-2.3, -2.1, 0.0), (-2.2, 2.1, 2.5), GREY), box((2.2, -2.1, 0.0), (2.3, 2.1, 2.5), GREY),
        box((-2.2, -2.1, 0.0), (2.2, -2.0, 2.5), GREY), box((-2.2, 2.0, 0.0), (2.2, 2.1, 2.5), GREY),
    ]  # fmt: skip
    things = [
        box((-2.2, -1.0, 0.0), (-1.8, 0.3, 1.8), GREY), box((0.2, 1.6, 0.0), (1.6, 2.0, 0.9), GREY),
        box((1.7, -1.5, 0.0), (2.2, -0.7, 1.2), GREY), box((-0.6, -2.0, 0.9), (0.5, -1.7, 1.3), GREY),
    ]  # fmt: skip
    table = [
        box((-0.5, -0.35, 0.69), (0.5, 0.35, 0.72), GREY), box((-0.07, -0.05, 0.72), (0.07, 0.05, 0.98), GREY),
        box((0.07, -0.03, 0.8), (0.16, 0.03, 0.86), GREY), box((0.2, 0.12, 0.72), (0.3, 0.2, 0.78), GREY),
        box((-0.35, -0.2, 0.72), (-0.25, -0.1, 0.8), GREY),
    ]  # fmt: skip
    return joined(walls + things + table)


@pytest.fixture(scope="module")
def caster():
    return RayCaster(room())


def unsteady(poses, seed=0):
    """The same in a hand: 1 cm and 1.5 deg."""
    rng = np.random.default_rng(seed)
    return [T @ exp(np.r_[rng.normal(0, 0.026, 3), rng.normal(0, 0.01, 3)]) for T in poses]


def round_it(arc, far, aside=0.0, count=24):
    """Round the thing, `far` [m] off, an arc [deg]; the axes pass it by `aside` [m]."""
    around = np.deg2rad(np.linspace(0, arc, count))
    eyes = THING + far * np.stack([0.85 * np.cos(around), 0.85 * np.sin(around), np.full(count, 0.53)], axis=1)
    return unsteady([looking_at(eye, np.add(THING, [0, 0, aside])) for eye in eyes])


def about(sweep, count=24):
    """On the spot, 1.5 m from a corner, looking about; a hand's sway moves the camera."""
    yaw = np.deg2rad(np.linspace(0, sweep, count))
    eye = np.array([1.0, -0.8, 1.4])
    targets = eye + np.stack([np.cos(yaw), np.sin(yaw), np.full(count, -0.3)], axis=1)
    return unsteady([looking_at(eye + 0.05 * np.sin(5 * y), t) for y, t in zip(yaw, targets, strict=True)])


def along(count=24):
    """Sideways past a wall, facing it."""
    x = np.linspace(-1.2, 1.2, count)
    return unsteady([looking_at(np.array([s, -0.9, 1.3]), np.array([s, 2.0, 1.0])) for s in x])


def across(count=36):
    """Round the room before its walls, looking to the other side: all axes meet in the air in the middle."""
    around = np.linspace(0, 2 * np.pi, count)
    eyes = np.stack([1.3 * np.cos(around), 1.1 * np.sin(around), np.full(count, 1.6)], axis=1)
    return unsteady([looking_at(eye, np.array([0.0, 0.0, 1.4])) for eye in eyes])


def outwards(count=36):
    """The same way, looking at the wall that is next."""
    around = np.linspace(0, 2 * np.pi, count)
    eyes = np.stack([0.9 * np.cos(around), 0.9 * np.sin(around), np.full(count, 1.5)], axis=1)
    return unsteady([looking_at(eye, eye * [2, 2, 0.7]) for eye in eyes])


def views(caster, poses, camera=CAMERA):
    depths = [caster.view(camera, T).depth.astype(np.float32) for T in poses]
    return [StandingView(T, point_map(depth, camera, 0.002)) for T, depth in zip(poses, depths, strict=True)]


def recording_of(caster, poses, stated=None):
    stamps = 10.0 + np.arange(len(poses)) / 30
    rng = np.random.default_rng(1)
    depths = [caster.view(CAMERA, T).depth for T in poses]
    depths = [(z + 0.0015 * z**2 * rng.standard_normal(z.shape)).astype(np.float32) for z in depths]
    load = lambda i: Frame(i, float(stamps[i]), depths[i].copy())  # noqa: E731
    return Recording(Path("made"), "made", CAMERA, stamps, load), Trajectory(stamps, np.stack(poses))


@pytest.mark.parametrize("far", [0.5, 0.8, 1.1])
@pytest.mark.parametrize("arc", [60, 120, 360, 800])
def test_a_walk_round_a_thing_is_seen(caster, arc, far):
    found = walked_round(views(caster, round_it(arc, far)))
    # the table is 1 m long, and the picture is as wide as the distance
    assert found is not None and not found.subject.room and found.subject.size < 1.1 * far
    assert np.linalg.norm(found.middle - THING) < 0.4 * far
    assert found.subject.distance == pytest.approx(far, rel=0.35)


def test_what_stands_beside_the_middle_of_the_pictures_counts_too(caster):
    assert walked_round(views(caster, round_it(200, 0.8, aside=0.15))) is not None


def test_a_few_frames_that_look_elsewhere_do_not_count(caster):
    walk = round_it(300, 0.8)
    walk[5:12] = about(90)[5:12]
    assert walked_round(views(caster, walk)) is not None


@pytest.mark.parametrize(
    "poses", [about(50), about(120), about(360), along(), across(), outwards(), outwards()[:12], across()[:12]],
    ids=["about 50", "about 120", "about 360", "along", "across", "outwards", "part outwards", "part across"],
)  # fmt: skip
def test_other_walks_are_not(caster, poses):
    assert walked_round(views(caster, poses)) is None


def test_a_camera_that_only_sways_goes_round_nothing(caster):
    assert walked_round(views(caster, unsteady([round_it(1, 0.8)[0]] * 20))) is None


def test_a_thing_as_large_as_a_room_is_none(caster):
    """The same walk, everything four times as large."""
    small = views(caster, round_it(360, 0.8))
    large = []
    for view in small:
        T = view.T_world_camera.copy()
        T[:3, 3] *= 4
        large.append(StandingView(T, replace(view.surface, points=4 * view.surface.points)))
    assert walked_round(small) is not None and walked_round(large) is None


def test_it_does_not_matter_where_the_world_stands(caster):
    walk, moved = round_it(200, 0.8), exp([0.0, 1.5, 0.3, 5.0, -2.0, 9.0])
    here, there = (walked_round(views(caster, walk)), walked_round([
        StandingView(moved @ v.T_world_camera, v.surface) for v in views(caster, walk)
    ]))  # fmt: skip
    # a median along other axes is another point of the table; the size is measured along the axes
    assert np.linalg.norm(moved[:3, :3] @ here.middle + moved[:3, 3] - there.middle) < 0.1
    assert there.subject.size == pytest.approx(here.subject.size, rel=0.5)
    assert there.subject.distance == pytest.approx(here.subject.distance)


def test_nothing_seen_is_nothing_gone_round(caster):
    blank = point_map(np.full(CAMERA.shape, np.nan, np.float32), CAMERA, 0.002)
    assert walked_round([]) is None
    assert walked_round([StandingView(np.eye(4), blank)] * 3) is None


def test_a_thing_on_a_table_is_scanned_as_an_object(caster):
    recording, _ = recording_of(caster, round_it(90, 0.8, count=46))
    result = reconstruct(recording, FREE)
    assert result.settings.kind == "object" and "went round" in result.settings.kind_reason
    assert result.settings.voxel_m <= 0.002 and not result.rejected
    # the room around is left out: the box reaches twice the size to both sides, and blocks stick out
    assert np.ptp(result.mesh.vertices, axis=0).max() < 4 * 0.9 + 0.1
    assert reconstruct(recording, replace(FREE, room=True)).settings.kind == "room"


def test_stated_poses_say_it_before_the_start(caster):
    recording, truth = recording_of(caster, round_it(300, 0.8))
    sensor = default_sensor(CAMERA)
    told = replace(FREE, poses=truth)
    assert plan(recording, FREE, sensor).kind == "room"
    chosen = plan(recording, told, sensor)
    assert chosen.kind == "object" and chosen.volume.bounds is not None
    assert plan(recording, replace(told, room=True), sensor).kind == "room"
    assert plan(recording, replace(told, voxel=0.01), sensor).kind == "room"
    box_of_the_user = ((-0.5, -0.5, 0.5), (0.5, 0.5, 1.2))
    assert plan(recording, replace(told, box=box_of_the_user), sensor).volume.bounds == box_of_the_user
    # what does not fit as an object stays a room
    assert plan(recording, replace(told, max_bytes=64 << 20), sensor).kind == "room"
    recording, truth = recording_of(caster, about(120))
    assert plan(recording, replace(FREE, poses=truth), sensor).kind == "room"


def test_an_object_that_does_not_fit_after_all_stays_a_room(caster, monkeypatch):
    recording, _ = recording_of(caster, round_it(90, 0.8, count=46))
    monkeypatch.setattr("fusion.reconstruction.planning.forecast_bytes", lambda *_: 0)  # a forecast may be wrong
    result = reconstruct(recording, replace(FREE, max_bytes=24 << 20))
    assert result.settings.kind == "room" and "does not fit into its memory" in result.settings.kind_reason
    assert len(result.mesh.faces)
