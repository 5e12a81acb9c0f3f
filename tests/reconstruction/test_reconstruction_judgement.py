"""Every fault that a reconstruction knows of turns on its own light; a good one has none."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from fusion.geometry.trajectory import Trajectory, trajectory_error
from fusion.mesh.mesh import Mesh
from fusion.reconstruction.result import Reconstruction
from fusion.results.choices import LensUsed, ReconstructionChoices
from fusion.results.course import Course, OffCourse
from fusion.results.light import Light
from fusion.sensor.correction.summary import CorrectionFigures
from fusion.volume.volume import Volume, VolumeSettings

COUNT = 20
SETTINGS = ReconstructionChoices(
    sensor="none", correction=CorrectionFigures("nothing", {}, (), ()), camera=LensUsed(500.0, 500.0, 320.0, 240.0, ()),
    voxel_m=0.01, truncation_m=0.03, volume_bytes=1, color=False, color_images=0, color_images_lost=0,
    uncolored_share=None, neutral_share=None, tracked_band_m=0.03, room=True, kind="room", kind_reason="as told",
    max_depth_m=None, box_m=None, poses="tracked",
)  # fmt: skip


def crumbled(parts: int) -> Mesh:
    """One box, and boxes a sixth as large beside it."""
    boxes = [trimesh.creation.box((1, 1, 1))]
    boxes += [trimesh.creation.box((1 / 6,) * 3).apply_translation((2.0 + k, 0, 0)) for k in range(parts)]
    whole = trimesh.util.concatenate(boxes)
    return Mesh(np.asarray(whole.vertices, float), np.asarray(whole.faces, np.int32))


def good() -> Reconstruction:
    poses = np.tile(np.eye(4), (COUNT, 1, 1))
    poses[:, 0, 3] = 0.02 * np.arange(COUNT)
    poses[:, 1, 3] = 0.1 * np.sin(np.arange(COUNT))
    return Reconstruction(
        mesh=crumbled(0), trajectory=Trajectory(np.arange(COUNT) / 10, poses), residual=np.full(COUNT, 0.005),
        inlier_share=np.full(COUNT, 0.9), information=np.zeros((COUNT, 6, 6)), unconstrained={}, rejected={},
        settings=SETTINGS, volume=Volume(VolumeSettings(0.01, 0.03)),
    )  # fmt: skip


def off_by(size: float) -> OffCourse:
    moved = good().trajectory.poses.copy()
    moved[::2, 2, 3] += 2 * size
    error = trajectory_error(Trajectory(good().trajectory.timestamps, moved), good().trajectory)
    assert error is not None
    return OffCourse(error, "its own poses")


PLANTED = {
    "Frames": [("bad", lambda r: replace(r, rejected=dict.fromkeys(range(10), "too little overlap")))],
    "Fit": [("bad", lambda r: replace(r, residual=np.full(COUNT, 0.05)))],
    "Directions": [
        ("warning", lambda r: replace(r, unconstrained=dict.fromkeys(range(4), ("rotation z",)))),
        ("bad", lambda r: replace(r, unconstrained=dict.fromkeys(range(16), ("rotation z",)))),
        # of the way, too, which is then longer than what was tracked
        ("warning", lambda r: replace(r, unconstrained={7: ("shift x",)})),
        ("bad", lambda r: replace(r, unconstrained=dict.fromkeys(range(4), ("shift x",)))),
    ],
    "Surface": [
        ("warning", lambda r: replace(r, mesh=crumbled(3))),
        ("bad", lambda r: replace(r, mesh=crumbled(12))),
    ],
    "Course": [("bad", lambda r: replace(r, off_course=off_by(0.2)))],
}


def test_a_good_one_has_only_good_lights():
    assert good().judgement.level == "ok" and good().judgement.warnings == ()


@pytest.mark.parametrize(("subject", "level", "plant"), [(n, *rest) for n, cases in PLANTED.items() for rest in cases])
def test_a_planted_fault_turns_on_its_own_light(subject, level, plant):
    first, *others = plant(good()).judgement.lights
    assert (first.subject, first.level) == (subject, level) and first.do
    assert all(light.level == "ok" for light in others)


@pytest.mark.parametrize("kind", ["room", "object"])
def test_a_room_is_not_told_to_be_taken_for_a_room(kind):
    first = replace(good(), mesh=crumbled(12), settings=replace(SETTINGS, kind=kind)).judgement.lights[0]
    assert ("--room" in first.do) == (kind == "object")


def test_a_way_along_a_bare_wall_is_said_to_be_missing():
    """Nearly half of the frames slid along it: as much of the way as the others took is not measured."""
    poses = good().trajectory.poses.copy()
    poses[:, :3, 3] = 0.0
    poses[:11, 0, 3] = 0.1 * np.arange(11)
    poses[11:, 0, 3] = poses[10, 0, 3]
    slid = replace(
        good(),
        trajectory=Trajectory(np.arange(COUNT) / 10, poses),
        unconstrained=dict.fromkeys(range(11, 20), ("shift x",)),
        course=Course(1.0, True, 1, 1),
    )
    told = {light.subject: light for light in slid.judgement.lights}
    assert "0.9 m of a way of 1.9 m" in told["Directions"].reason and told["Directions"].level == "bad"
    assert "900 mm may be missing" in told["Drift"].reason and told["Drift"].level == "warning"
    seen_again = {x.subject: x for x in replace(slid, course=replace(slid.course, met=2)).judgement.lights}
    assert "not measured" not in seen_again["Directions"].reason
    everywhere = replace(slid, unconstrained=dict.fromkeys(range(4, 20), ("shift x",)))
    told = {light.subject: light for light in everywhere.judgement.lights}
    assert "not known" in told["Directions"].reason and told["Directions"].level == "bad"
    assert "nobody knows" in told["Drift"].reason and told["Drift"].level == "warning"


def test_what_the_doctor_said_stands_among_them():
    told = Light("warning", "Recording", "Odd.")
    assert replace(good(), notes=(told,)).judgement.lights[0] == told
    assert replace(good(), footnotes=("usual",)).judgement.footnotes == ("usual",)


def test_frames_are_judged_by_the_model_that_they_were_held_against():
    """An object may be fused in a band that is narrower than that of the room in which it was tracked."""
    known = replace(good(), settings=replace(SETTINGS, truncation_m=0.004))
    assert next(x for x in known.judgement.lights if x.subject == "Fit").level == "ok"
