"""Scenes of flat things, and what they are built from: one rectangle, one reflectance."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from fusion.errors import SceneError
from fusion.geometry.pose import Array
from fusion.mesh.mesh import Mesh
from fusion.simulation.scene.course import SimulatedCourse, looking_at, stamps, standing
from fusion.simulation.scene.scene import TRANSLUCENT, Part, Scene, StatedPoses

SURVEY_M, SURVEY_RAD = 0.0005, 0.0005  # guess: a good total station and a careful mount
WARM_S = 3600.0  # [s] since switch-on: a depth camera is warm after 40 to 50 minutes


def panel(corners: ArrayLike, reflectance: float) -> Part:
    """A flat quadrangle (4, 3) [m], corners counter-clockwise seen from its front, in one grey."""
    grey = np.full((4, 3), round(255 * min(max(reflectance, 0.0), 1.0)), np.uint8)
    mesh = Mesh(np.asarray(corners, float), np.array([[0, 1, 2], [0, 2, 3]], np.int32), colors=grey)
    return Part(mesh, reflectance)


def upright(y: tuple[float, float], z: tuple[float, float], x: float, reflectance: float) -> Part:
    """A rectangle in the plane of one x [m] that faces +x."""
    return panel([(x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1])], reflectance)


def before(distance: float, tilt_deg: float = 0.0) -> Array:
    """The pose (4, 4) of a camera before the plane x = 0: its axis meets the origin after `distance` [m]."""
    if not (np.isfinite(distance) and 0 < distance <= 1000):
        raise SceneError("the distance cannot be used", found=distance, expected="above 0 m")
    if not abs(tilt_deg) < 90:
        raise SceneError("the tilt cannot be used", found=tilt_deg, expected="less than 90 degrees")
    tilt = np.deg2rad(tilt_deg)
    return looking_at(distance * np.array([np.cos(tilt), np.sin(tilt), 0.0]), np.zeros(3))


def wall(
    distance_m: tuple[float, ...] = (1.0,),
    tilt_deg: tuple[float, ...] = (0.0,),
    reflectance: float = 0.8,
    frames: int = 10,
    ambient_lux: float = 300.0,
    sigma_m: float = SURVEY_M,
    sigma_rad: float = SURVEY_RAD,
) -> Scene:
    """a flat wall; each distance (along the optical axis) at each tilt for some frames"""
    placements = [(d, t) for t in tilt_deg for d in distance_m]
    course = standing([before(d, t) for d, t in placements], frames, start_s=WARM_S)
    return Scene(
        name="wall",
        parts=(upright((-20.0, 20.0), (-10.0, 10.0), 0.0, reflectance),),
        course=course,
        poses=StatedPoses("surveyed", sigma_m, sigma_rad),
        ambient_lux=ambient_lux,
        telemetry={"distance_m": np.repeat([float(d) for d, _ in placements], frames)},
    )


def approach(near_m: float = 0.6, far_m: float = 1.2, frames: int = 30, tilt_deg: float = 0.0) -> Scene:
    """a flat wall that the camera rolls towards on a rail, from far to near, at 30 frames a second"""
    times = stamps(frames, 1 / 30, WARM_S)
    places = [before(d, tilt_deg) for d in np.linspace(far_m, near_m, frames)]
    return Scene(
        name="approach",
        parts=(upright((-20.0, 20.0), (-10.0, 10.0), 0.0, 0.8),),
        course=SimulatedCourse(times, np.array(places), continuous=True),
        poses=StatedPoses("surveyed", SURVEY_M, SURVEY_RAD),
        ambient_lux=300.0,
    )


def step(
    distance_m: float = 1.0,
    step_m: float = 0.3,
    slant_deg: float = 5.0,
    near_reflectance: float = 0.8,
    far_reflectance: float = 0.8,
    width_m: float = 0.0,
    frames: int = 10,
) -> Scene:
    """a near plate before a wall, one edge slanted, or both of one so wide: blur, mixed pixels, shadow"""
    lean = np.tan(np.deg2rad(slant_deg))
    # the plate covers the camera's left half, or its middle: +y of the world is to its right
    half, far = width_m / 2, -4.0
    left = [(-half - 3 * lean, -3), (-half + 3 * lean, 3)] if width_m else [(far, -3), (far, 3)]
    corners = [left[0], (half - 3 * lean, -3), (half + 3 * lean, 3), left[1]]
    near = panel([(step_m, y, z) for y, z in corners], near_reflectance)
    parts = (near, upright((-20.0, 20.0), (-10.0, 10.0), 0.0, far_reflectance))
    return _surveyed("step", parts, before(distance_m + step_m), frames)


def _surveyed(name: str, parts: Sequence[Part], T_world_camera: Array, frames: int) -> Scene:
    """From one place that was surveyed, by a warm camera, in a room's light."""
    return Scene(
        name=name,
        parts=tuple(parts),
        course=standing([T_world_camera], frames, start_s=WARM_S),
        poses=StatedPoses("surveyed", SURVEY_M, SURVEY_RAD),
        ambient_lux=300.0,
    )


BLACK = 0.03  # black velvet or foil


def corner(
    distance_m: float = 1.5,
    angle_deg: float = 90.0,
    reflectance: float = 0.8,
    black: bool = False,
    frames: int = 10,
) -> Scene:
    """two walls that meet in a vertical line, seen along their bisector; black=yes darkens the second"""
    half = np.deg2rad(angle_deg) / 2
    ends = 3.0 * np.array([[np.cos(half), np.sin(half)], [np.cos(half), -np.sin(half)]])
    walls = []
    for (x, y), value in zip(ends, (reflectance, BLACK if black else reflectance), strict=True):
        corners = [(x, y, -1.5), (0, 0, -1.5), (0, 0, 1.5), (x, y, 1.5)]
        walls.append(panel(corners if y > 0 else corners[::-1], value))
    return _surveyed("corner", walls, looking_at(np.array([distance_m, 0.0, 0.0]), np.zeros(3)), frames)


def slab(
    distance_m: float = 0.8,
    tilt_deg: float = 0.0,
    size_m: float = 0.4,
    thick_m: float = 0.03,
    slab_reflectance: float = 0.6,
    reflectance: float = 0.8,
    covered: bool = False,
    frames: int = 10,
) -> Scene:
    """a slab of soap, wax or marble against a paper wall; covered=yes: with a sheet of paper over it"""
    half = size_m / 2
    near = upright((-half, half), (-half, half), thick_m, reflectance if covered else slab_reflectance)
    paper = upright((-20.0, 20.0), (-10.0, 10.0), 0.0, reflectance)
    parts = _of_material(near, 0.0 if covered else 1.0), _of_material(paper, 0.0)  # paper lets no light in
    name = "slab, covered" if covered else "slab"
    return _surveyed(name, parts, before(distance_m + thick_m, tilt_deg), frames)


def _of_material(part: Part, translucent: float) -> Part:
    scalars = {TRANSLUCENT: np.full(len(part.mesh.vertices), translucent, np.float32)}
    return replace(part, mesh=replace(part.mesh, scalars=scalars))


def near_card(
    card: bool = True,
    distance_m: float = 2.0,
    card_distance_m: float = 0.4,
    reflectance: float = 0.3,
    card_reflectance: float = 0.9,
    frames: int = 10,
) -> Scene:
    """a wall, and a bright card near the camera (card=no: the same recording without it)"""
    parts = [upright((-20.0, 20.0), (-10.0, 10.0), 0.0, reflectance)]
    if card:
        x = distance_m - card_distance_m
        # the left fifth of a picture of 60 degrees
        left, right = np.array([-0.9, -0.28]) * card_distance_m
        parts.append(upright((left, right), (-0.3 * card_distance_m, 0.3 * card_distance_m), x, card_reflectance))
    name = "near-card" if card else "near-card, without the card"
    return _surveyed(name, parts, before(distance_m), frames)


ROOM_C, RISE_C, RISE_S = 23.0, 9.0, 900.0  # guess: a closed camera of 5 to 15 W


def warm_up(
    distance_m: float = 1.2, frames: int = 20, minutes: float = 50.0, start_s: float = 60.0, reflectance: float = 0.7
) -> Scene:
    """a plate before a wall, few frames over a long time from switch-on, with the temperature"""
    frame_s = 60.0 * minutes / max(frames - 1, 1)
    times = stamps(frames, frame_s, start_s)
    warming = np.exp(-times / RISE_S)
    near = upright((-0.35, 0.05), (-0.25, 0.2), 0.35, reflectance)
    return Scene(
        name="warm-up",
        parts=(upright((-20.0, 20.0), (-10.0, 10.0), 0.0, reflectance), near),
        course=standing([before(distance_m)], frames, frame_s, start_s),
        poses=StatedPoses("surveyed", SURVEY_M, SURVEY_RAD),
        ambient_lux=300.0,
        telemetry={"temperature_c": ROOM_C + RISE_C * (1 - warming)},
    )
