"""Bags by rosbags' writers (ROS 1, and ROS 2 in SQLite and MCAP), with messages as drivers send them."""

import struct
import sys
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "tests" / "recording" / "bags"))
import ros_bags

from tools.formats.folders import quaternion
from tools.formats.take import Array, Take

WORLD, BASE, EYE = "map", "base_link", "camera_depth_optical_frame"
# the camera on its carrier: an optical frame (z forward) on a body frame (x forward), as drivers publish it
MOUNT = np.array([[0.0, 0, 1, 0.02], [-1, 0, 0, -0.015], [0, -1, 0, 0.04], [0, 0, 0, 1]])


def place(T: Array) -> tuple[float, ...]:
    """tx ty tz qx qy qz qw."""
    return *T[:3, 3], *quaternion(T)


def bag(take: Take, path: Path, kind: str, encoding: str = "16UC1", packed: bool = False) -> Path:
    """Depth, colour registered to it, their camera_info, the camera's way in /tf and /tf_static."""
    out, size = ros_bags.Writer(path, kind), (take.lens.width, take.lens.height)
    stamps = take.stamps + (ros_bags.START if take.stamps[0] < 1e6 else 0)  # bags hold times since 1970
    bend, model = take.lens.bend, "rational_polynomial" if any(take.lens.bend[5:]) else "plumb_bob"
    bend = bend if model == "rational_polynomial" else bend[:5]
    topic = "/camera/depth/image_rect_raw" if not any(bend) else "/camera/depth/image_raw"  # as drivers call them
    out.transform("/tf_static", BASE, EYE, place(MOUNT), float(stamps[0]))
    counts = take.counts(0.001)
    for i, stamp in enumerate(stamps.tolist()):
        k = i % len(counts)
        if take.poses is not None:
            out.transform("/tf", WORLD, BASE, place(take.poses[i] @ np.linalg.inv(MOUNT)), stamp)
        out.info("/camera/depth/camera_info", size, take.lens.four, stamp, EYE, bend, model=model)
        pixels = counts[k] if encoding == "16UC1" else lost(take.depth[k])
        if packed:
            data = struct.pack("<iff", 0, 0.0, 0.0) + cv2.imencode(".png", pixels)[1].tobytes()
            form = f"{encoding}; compressedDepth png"
            out.packed(f"{topic}/compressedDepth", data, form, stamp, EYE)
        else:
            out.image(topic, pixels, encoding, stamp, EYE)
        if take.color is not None:
            out.info("/camera/color/camera_info", size, take.lens.four, stamp, EYE, bend, model=model)
            out.image("/camera/color/image_raw", take.color[i], "rgb8", stamp, EYE)
    out.bag.close()
    return path


def lost(depth: np.ndarray) -> np.ndarray:
    """REP 118: NaN where there is nothing."""
    return np.where(depth > 0, depth, np.nan).astype(np.float32)
