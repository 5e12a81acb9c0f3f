"""A scene of known size and no symmetry, seen by cameras of any convention; shares nothing with the program.

A floor, a wall that leans and a box of 0.4 x 0.25 x 0.3 m that stands askew. World axes: x right, y up, z towards the
viewer; metres.
"""

import numpy as np

# planes n . p = d, n to the side that is seen
FLOOR = (np.array([0.0, 1.0, 0.0]), -0.4)
WALL = (np.array([0.3, 0.2, 1.0]) / np.linalg.norm([0.3, 0.2, 1.0]), -1.1)
_A = 0.6  # [rad] how the box is turned about y
BOX_AXES = np.array([[np.cos(_A), 0, -np.sin(_A)], [0, 1, 0], [np.sin(_A), 0, np.cos(_A)]])  # rows
BOX_CENTRE, BOX_HALF = np.array([0.12, -0.25, -0.55]), np.array([0.2, 0.15, 0.125])
_SIDES = [
    (side * axis, side * axis @ BOX_CENTRE + half)
    for axis, half in zip(BOX_AXES, BOX_HALF, strict=True)
    for side in (1.0, -1.0)
]
FACES = [FLOOR, WALL, *_SIDES]


def cameras(count=3):
    """(count, 4, 4) camera to world, x right, y up, looking along -z (OpenGL, ARKit), about 0.6 m from the box."""
    made = []
    for i in range(count):
        a, b = 0.12 * i - 0.1, -0.35 - 0.03 * i
        turn = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
        tilt = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
        made.append(np.eye(4))
        made[-1][:3, :3] = turn @ tilt
        made[-1][:3, 3] = [0.15 * i - 0.05, 0.1 + 0.04 * i, 0.15]
    return np.stack(made)


def depth(T, width, height, fx, fy, ox, oy, bent=None):
    """(h, w) depth along the axis [m] and (h, w) index into FACES, 0 and -1 where nothing is.

    T: as of `cameras`; fx, fy, ox, oy: [px], the principal point from the image's upper left CORNER; bent: takes
    (h, w, 2) to the right and down in focal lengths, as a lens has them, to where they were without.
    """
    right = (np.arange(width) + 0.5 - ox) / fx
    down = (np.arange(height) + 0.5 - oy) / fy
    x, y = np.meshgrid(right, down)
    if bent is not None:
        x, y = np.moveaxis(bent(np.dstack([x, y])), -1, 0)
    rays = np.dstack([x, -y, -np.ones_like(x)]) @ T[:3, :3].T
    best, face = np.full((height, width), np.inf), np.full((height, width), -1)
    for index, (n, d) in enumerate(FACES):
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (d - n @ T[:3, 3]) / (rays @ n)
        hit = (rays @ n < 0) & (along > 0)
        if index >= 2:
            local = np.abs((T[:3, 3] + rays * np.where(hit, along, 0)[..., None] - BOX_CENTRE) @ BOX_AXES.T)
            hit &= (local <= BOX_HALF + 1e-9).all(axis=-1)
        nearer = hit & (along < best)
        best, face = np.where(nearer, along, best), np.where(nearer, index, face)
    return np.where(np.isfinite(best), best, 0.0), face


def errors(recording, faces):
    """By frame and face: median signed distance [m] of the points behind the face, in the recording's own poses.

    faces: (h, w) of each frame, as of `depth`. Faces of fewer than 150 pixels are left out.
    """
    found = []
    poses = recording.poses.at(recording.timestamps).poses
    for frame, T, face in zip(recording, poses, faces, strict=True):
        points = recording.camera.points(frame.depth) @ T[:3, :3].T + T[:3, 3]
        for index in range(len(FACES)):
            there = (face == index) & np.isfinite(frame.depth)
            if there.sum() >= 150:
                n, d = FACES[index]
                found.append(float(np.median(points[there] @ n - d)))
    return np.array(found)
