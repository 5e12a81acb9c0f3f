import numpy as np
from small_room import Room, room_mesh, sway

from fusion.geometry.pose import angle, exp, inverse
from fusion.simulation.rendering.render import RayCaster
from fusion.tracking.landmarks import meet
from fusion.tracking.shapes import shape_landmarks


def shown(room: Room, T, seed: int):
    surface = room.frame(T, seed)
    known = np.isfinite(surface.normals[..., 0])
    return shape_landmarks(surface.points[known].astype(float), surface.normals[known].astype(float))


def test_a_room_is_recognised_by_its_shapes():
    room = Room(RayCaster(room_mesh()))
    a, b = sway(0.0), sway(1.0) @ exp([0.05, 0.15, 0, 0, 0, 0])
    met = meet(shown(room, a, 0), shown(room, b, 1))
    apart = inverse(inverse(a) @ b) @ met.T_a_b
    # near enough for the surfaces to be aligned, whose narrowest first reach is 8 cm
    assert np.linalg.norm(apart[:3, 3]) < 0.08 and angle(apart) < 0.05


def test_a_bare_wall_has_few_landmarks_and_meets_nothing(wall):
    a, b = (shown(wall, T, seed) for seed, T in enumerate((sway(0.0), sway(0.5))))
    met = meet(a, b)
    assert met is None or met.count < 40


def test_too_few_points_have_none():
    assert len(shape_landmarks(np.zeros((0, 3)), np.zeros((0, 3)))) == 0
