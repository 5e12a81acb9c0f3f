"""Three objects of YCB-Video 0000 before an Asus Xtion: a recording each, the scanned mesh at its annotated pose."""

import json
from pathlib import Path

import cv2
import numpy as np

from fusion.geometry.pose import inverse
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.files import read_mesh
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording
from tools.reproduce.real_scenes.scene import write_scene

ANNOTATED = (0.002, 0.01)  # [m], [rad] guess: poses set by hand and refined
MESH_M = 0.0007  # [m] other copies of the same products, scanned: guess
BORDER = 2  # [px] of a label that may hold its neighbour


def write_objects(source: Path, folder: Path) -> list[Path]:
    """One recording per object, with the depth inside its label; their folders."""
    poses = json.loads((source / "poses.json").read_text())
    recording = open_recording(source)
    names = [entry["name"] for entry in poses[0]["objects"]]
    written = []
    for name in names:
        views, frames = [], []
        for i, about in enumerate(poses):
            entry = next(e for e in about["objects"] if e["name"] == name)
            label = cv2.imread(str(source / f"label/{about['frame']}.png"), cv2.IMREAD_UNCHANGED)
            assert label is not None
            kernel = np.ones((2 * BORDER + 1, 2 * BORDER + 1), np.uint8)
            mask = cv2.erode((label == entry["class_id"]).astype(np.uint8), kernel) > 0
            depth = np.where(mask, recording[i].depth, np.float32(np.nan))
            frames.append(Frame(i, i / 30, depth))
            views.append(inverse(np.vstack([entry["T_camera_object_3x4"], [0, 0, 0, 1]])))
        out = folder / name
        write_recording(out, recording.camera, iter(frames), Trajectory(np.arange(len(frames)) / 30, np.stack(views)))
        write_scene(out, read_mesh(source / f"mesh/{name}.ply"), ("tracked", *ANNOTATED), MESH_M)
        written.append(out)
    return written
