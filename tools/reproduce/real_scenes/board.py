"""The Kinect v2's checkerboard: every picture a recording of its own, the board's pose from its corners."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.boards.detect import find_checkerboard
from fusion.calibration.lens.boards.pictures import read_picture
from fusion.calibration.lens.fit.solve import placed
from fusion.calibration.lens.intrinsics import fit_camera
from fusion.calibration.lens.views import view_of
from fusion.geometry.camera import Camera
from fusion.geometry.pose import inverse
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording
from tools.reproduce.real_scenes.scene import flat_mesh, write_scene

BOARD, SIZE = Board(5, 7, 0.03), (512, 424)
KINECT: dict[str, Any] = {"principle": "itof", "depth_scale": 1000.0, "sensor": "Kinect v2"}
CORNER_PX = 0.1  # [px] what is left of the corners' reprojection
FLAT_M = 0.001  # [m] a printed sheet on a chair: guess
REACH_M = 0.08  # [m] of the corners from their middle
LOST_M = 0.1  # [m] from the board: a lost phase, dropped as the recording's notes do
SATURATED = 65535


def own_camera(source: Path) -> Camera:
    """The camera that these pictures give, lens and all."""
    views = []
    for path in sorted(source.glob("*_ir.png")):
        found = find_checkerboard(read_picture(path), BOARD)
        views += [] if found is None else [view_of(path.stem, found.pixels, BOARD)]
    return replace(fit_camera(views, SIZE).judged.solution.camera(SIZE), **KINECT)


def author_camera(source: Path) -> Camera:
    """The camera of the recording's author: spoiled by four bad views, its focal length is 3 % too long."""
    text = (source / "calib_ir.yaml").read_text()
    numbers = [[float(x) for x in block.split(",")] for block in re.findall(r"data: \[(.*?)\]", text, re.S)]
    K, distortion = numbers[0], numbers[1]
    return Camera(*SIZE, K[0], K[4], K[2], K[5], tuple(distortion[:5]), **KINECT)


def write_boards(source: Path, camera: Camera, folder: Path) -> list[Path]:
    """One recording per pair of IR and depth in which the board is found; their folders."""
    written = []
    for path in sorted(source.glob("*_depth.png")):
        name = path.name.removesuffix("_depth.png")
        ir = read_picture(source / f"{name}_ir.png")
        found = find_checkerboard(ir, BOARD)
        if found is None:
            continue
        pose = placed(view_of(name, found.pixels, BOARD), _parameters(camera))
        if pose is None:
            continue
        depth = read_picture(path).astype(np.float32) / 1000
        depth[(depth == 0) | (ir >= SATURATED)] = np.nan
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = cv2.Rodrigues(pose[:3])[0], pose[3:]
        out = folder / name
        frames = iter([Frame(0, 0.0, _without_lost(depth, T, camera), ir=ir)])
        write_recording(out, camera, frames, Trajectory(np.zeros(1), inverse(T)[None]))
        sigma = _sigma(found.pixels, float(T[2, 3]), camera)
        write_scene(out, _mesh(), ("tracked", *sigma), FLAT_M, from_images=True)
        written.append(out)
    return written


def _parameters(camera: Camera) -> NDArray[np.float64]:
    return np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion], float)


def _mesh() -> Mesh:
    """The printed squares, one ring of them around the corners; the board's frame of `placed`."""
    s = BOARD.square_m
    return flat_mesh((-s, BOARD.columns * s), (-s, BOARD.rows * s))


def _without_lost(depth: NDArray[np.floating], T: NDArray[np.float64], camera: Camera) -> NDArray[np.float32]:
    """Depth without what is far from the board's plane and would be called an outlier by anybody."""
    normal, distance = T[:3, 2], float(T[:3, 2] @ T[:3, 3])
    with np.errstate(all="ignore"):
        plane = distance / (np.dstack([camera.rays(), np.ones(camera.shape)]) @ normal)
        return np.where(np.abs(depth - plane) < LOST_M, depth, np.float32(np.nan)).astype(np.float32)


def _sigma(pixels: NDArray[np.floating], distance: float, camera: Camera) -> tuple[float, float]:
    """Standard deviation of the board's place [m] and angle [rad] from so many corners over so many pixels."""
    reach = float(np.sqrt(((pixels - pixels.mean(axis=0)) ** 2).sum(axis=1).mean()))
    # the distance comes from the size of the board in the image
    share = CORNER_PX / np.sqrt(len(pixels)) / reach
    # the tilt from one side being larger than the other: by how much depends on the perspective
    return distance * share, share * distance / REACH_M
