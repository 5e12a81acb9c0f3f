"""A mesh has the paint of the thing and of nothing behind or before it; what no image shows is told from black."""

import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
from painted import CAMERA, HALF, around, cube, off, paint, scene

from fusion.coloring.color_mesh import ENOUGH, NEUTRAL, color_mesh
from fusion.coloring.images import color_images
from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import exp, inverse
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording
from fusion.results.color_light import color_lights
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.shapes import box, joined
from fusion.volume.volume import Volume, VolumeSettings

MISPLACED = {"sigma_rad": 0.003, "shift": 2}  # of one pixel and two, as trackers and registered images are off


def error(colors, vertices):
    """(n,) largest difference over the channels from the paint, taken at the box's own surface [counts]."""
    true = paint(np.clip(vertices, -HALF, HALF)).astype(float)
    return np.abs(colors.astype(float) - true).max(axis=1)


def at_rim(vertices, within=0.008):
    """(n,) vertices near an edge of the box."""
    near = np.abs(np.abs(vertices) - HALF) < within
    return near.sum(axis=1) >= 2


def greenish(colors):
    """(n,) a fifth or more is the room's green: the paint has 20 of it, the room 255."""
    return colors[:, 1] > 20 + 0.2 * 235


@pytest.fixture(scope="module")
def turned():
    """The box from all sides, the mesh 2 mm too large, poses and colour some pixels off."""
    made = scene(lambda _: [cube()], **MISPLACED)
    return made, color_mesh(off(cube(), 0.002), made.recording, made.poses)


def test_the_paint_comes_out_and_no_background(turned):
    made, found = turned
    mesh = found.mesh
    seen = mesh.vertices[:, 2] > -HALF + 0.005  # no camera looks at the bottom
    rim = seen & at_rim(mesh.vertices)
    wrong = error(mesh.colors, mesh.vertices)
    assert found.images == len(made.recording) and rim.sum() > 1000
    # a shift of two pixels is 4 mm, in paint of up to 2.6 counts a millimetre; beside it 2 mm and a pixel
    assert np.median(wrong[seen]) < 8 and np.quantile(wrong[seen], 0.95) < 15
    assert np.median(wrong[rim]) < 8 and np.quantile(wrong[rim], 0.95) < 15
    # measured 0.003: at the edge of the bottom, a rim in every picture, where three pixels and the 2 mm add up
    assert greenish(mesh.colors[rim]).mean() < 0.006


def test_the_volume_alone_would_mix_the_background_in(turned):
    """Without care the same images leave green rims: the test above can fail."""
    made = turned[0]
    volume = Volume(VolumeSettings(0.004, 0.016, color=True, bounds=((-0.12,) * 3, (0.12,) * 3)))
    for frame, T in zip(made.recording, made.poses.poses, strict=True):
        volume.integrate(frame.depth, CAMERA, T, color=frame.color)
    mesh = volume.surface()
    rim = at_rim(mesh.vertices) & (mesh.vertices[:, 2] > -0.08)
    assert greenish(mesh.colors[rim]).mean() > 0.06  # measured 0.14


def test_what_stands_before_the_thing_leaves_no_colour():
    """A magenta board that is no part of the mesh covers half the box in every other picture."""
    poses = around(14)

    def things(i):
        if i % 2:
            return [cube()]
        corner = poses[i] @ np.array([0.0, 0.0, 0.35, 1.0])
        across, up = poses[i][:3, 0], poses[i][:3, 1]
        corners = np.stack(
            [corner[:3] + s * 0.2 * across + t * 0.1 * up for s, t in ((0, -1), (1, -1), (1, 1), (0, 1))]
        )
        board = np.array([[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]], np.int32)
        return [cube(), Mesh(corners, board, colors=np.tile(np.array([255, 0, 255], np.uint8), (4, 1)))]

    made = scene(things)
    found = color_mesh(off(cube(), 0.001), made.recording, made.poses).mesh
    top = found.vertices[:, 2] > -HALF + 0.005
    # a pixel of 2 mm and a millimetre, in paint of up to 2.6 counts a millimetre; magenta is 55 and more away
    assert np.quantile(error(found.colors, found.vertices)[top], 0.99) < 25


def test_what_no_image_shows_is_carried_over_or_grey_and_counted():
    made = scene(lambda _: [cube()], at=around(14)[:1])
    found = color_mesh(cube(), made.recording, made.poses)
    views, colors = found.mesh.scalars["color_views"], found.mesh.colors
    assert set(np.unique(views)) == {0, 1}
    assert found.uncolored_share == pytest.approx((views == 0).mean())
    away = found.mesh.vertices[:, 0] < -HALF + 0.04  # from the side that the camera looks at
    assert (views[away & (found.mesh.vertices[:, 2] < HALF)] == 0).all()
    grey = (colors == NEUTRAL).all(axis=1)
    assert grey[away & (found.mesh.vertices[:, 2] < HALF - 0.04)].all()
    assert found.neutral_share == pytest.approx(grey.mean(), abs=0.001)
    # just round the edge no camera looked, and the paint goes on: 1 cm at 2.6 counts a millimetre
    beside = (
        (views == 0) & (np.abs(found.mesh.vertices[:, 1]) > HALF - 1e-6) & (found.mesh.vertices[:, 0] > HALF - 0.01)
    )
    assert beside.sum() > 50 and np.quantile(error(colors, found.mesh.vertices)[beside], 0.95) < 40
    assert not (colors == 0).all(axis=1).any()


def test_black_paint_stays_black():
    def black(points):
        return np.zeros(points.shape, np.uint8)

    made = scene(lambda _: [cube(painted=black)])
    found = color_mesh(off(cube(), 0.001), made.recording, made.poses)
    seen = found.mesh.scalars["color_views"] > 0
    # the bottom and its lowest rim are what no camera sees: a sixth, and what lies by its edge
    assert 1 / 6 - 0.01 < found.uncolored_share < 1 / 6 + 0.05
    assert np.quantile(found.mesh.colors[seen], 0.99) < 10


def test_a_colour_camera_beside_the_depth_camera(tmp_path):
    """Before a wall stands a box: what the colour camera sees of the wall, the box hides from the depth camera."""
    beside = Camera(400, 300, 380.0, 381.0, 201.3, 148.2, distortion=(0.05, -0.1))
    T_color_depth = exp([0.0, 0.05, 0.01, -0.12, 0.01, 0.005])  # 12 cm to the right of it
    front = box((-0.06, -0.3, 0.6), (0.06, 0.3, 0.7), (200, 30, 30))
    wall = box((-1.0, -1.0, 1.0), (1.0, 1.0, 1.1), (20, 40, 210))
    caster = RayCaster(joined([front, wall]))
    poses = np.stack([exp([0, 0.02 * i, 0, 0.03 * i, 0, 0]) for i in (-1, 0, 1)])
    camera = replace(CAMERA, color=beside, T_color_depth=T_color_depth)
    views = [caster.view(CAMERA, T) for T in poses]
    made = scene(lambda _: [], at=poses).recording
    frames = [replace(f, depth=v.depth.astype(np.float32), color=None) for f, v in zip(made, views, strict=True)]
    folder = tmp_path / "r"
    write_recording(folder, camera, frames)
    (folder / "rgb").mkdir()
    lines = []
    for frame, T in zip(frames, poses, strict=True):
        picture = caster.view(beside, T @ inverse(T_color_depth)).color
        cv2.imwrite(str(folder / f"rgb/{frame.index}.png"), picture[..., ::-1])
        lines.append(f"{frame.timestamp:.6f} rgb/{frame.index}.png\n")
    (folder / "rgb.txt").write_text("".join(lines))
    recording = open_recording(folder)
    assert not recording.warnings and recording[0].color is None
    found = color_mesh(_fine(joined([front, wall])), recording, Trajectory(recording.timestamps, poses)).mesh
    seen = found.scalars["color_views"] > 0
    expected = np.where(found.vertices[:, 2:] < 0.8, (200, 30, 30), (20, 40, 210))
    for part in (found.vertices[:, 2] < 0.8, found.vertices[:, 2] > 0.8):
        assert (seen & part).sum() > 100
    # plain colours and exact poses: what differs was taken from the wrong thing, or is a pixel's mixture
    assert (np.abs(found.colors[seen].astype(int) - expected[seen]).max(axis=1) > 5).mean() < 0.001


def _fine(mesh: Mesh) -> Mesh:
    """Each triangle in 4 x 4 x 4 x 4 x 4 small ones."""
    import open3d as o3d

    raw = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(mesh.vertices), o3d.utility.Vector3iVector(mesh.faces))
    raw = raw.subdivide_midpoint(5)
    return Mesh(np.asarray(raw.vertices), np.asarray(raw.triangles, np.int32))


def test_a_recording_without_colour_gives_a_mesh_without():
    made = scene(lambda _: [cube()], at=around(2))
    blind = replace(made.recording, load=lambda i: replace(made.recording.load(i), color=None))
    found = color_mesh(cube(), blind, made.poses)
    assert found.mesh.colors is None and found.uncolored_share is None and found.images == 0


def test_a_picture_that_cannot_be_read_is_passed_over():
    made = scene(lambda _: [cube()], at=around(6))

    def load(i):
        if i == 2:
            raise RecordingError("the image is cut off", "rgb/2.png")
        return made.recording.load(i)

    found = color_mesh(cube(), replace(made.recording, load=load), made.poses)
    assert (found.images, found.lost) == (5, 1)
    assert "1 of 6 colour images" in color_lights(found)[0].reason


def test_many_pictures_are_thinned_to_a_bounded_number_from_everywhere():
    """Most of the time the camera stands still; what it saw on its short way around must not be lost."""
    still, moving = np.repeat(around(36)[:1], 2000, axis=0), around(36)
    poses = np.concatenate([still, moving])
    made = scene(lambda _: [], at=poses)
    chosen = color_images(made.recording).spread(made.poses, ENOUGH)
    assert len(chosen) <= ENOUGH and set(range(2001, 2036)) <= set(chosen)
