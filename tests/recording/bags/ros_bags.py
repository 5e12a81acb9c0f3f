"""Bags by another hand: rosbags' writers, ROS 1 and ROS 2, with the scene in every way that drivers send it."""

import struct
from pathlib import Path

import box_scene
import cv2
import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import Rotation

SIZE, LENGTHS = (96, 72), (90.0, 91.0, 46.3, 37.2)
COLOR_SIZE, COLOR_LENGTHS, COLOR_LENS = (120, 80), (110.0, 111.0, 60.5, 39.2), (0.05, -0.08, 0.001, -0.002, 0.01)
COLOR_PLACE = (
    0.025,
    -0.003,
    0.004,
    *Rotation.from_rotvec([0.01, 0.03, -0.02]).as_quat(),
)  # colour camera in the depth's
FRAMES, START, STEP_S = 4, 1_700_000_000.25, 1 / 30
TF = "tf2_msgs/msg/TFMessage"
DEPTH, COLOR = "/cam/depth", "/cam/color"
ANSWERS = {"16UC1": 0.51e-3, "32FC1": 1e-6}  # [m] half a millimetre, and single precision


class Writer:
    """One way to write messages into a file of one kind: "ros1", "ros1-lz4", "ros1-bz2", "sqlite3", "mcap"..."""

    def __init__(self, path: Path, kind: str) -> None:
        self.one = kind.startswith("ros1")
        self.store = get_typestore(Stores.ROS1_NOETIC if self.one else Stores.ROS2_HUMBLE)
        if self.one:  # its types lack those of tf2
            self.store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TF))
            self.bag = rosbag1.Writer(path)
            if "-" in kind:
                self.bag.set_compression(rosbag1.Writer.CompressionFormat[kind.partition("-")[2].upper()])
        else:
            plugin = rosbag2.StoragePlugin.MCAP if kind.startswith("mcap") else rosbag2.StoragePlugin.SQLITE3
            self.bag = rosbag2.Writer(path, version=9, storage_plugin=plugin)
            if kind.endswith("-packed"):
                mcap = plugin is rosbag2.StoragePlugin.MCAP
                mode = rosbag2.CompressionMode.STORAGE if mcap else rosbag2.CompressionMode.MESSAGE
                self.bag.set_compression(mode, rosbag2.CompressionFormat.ZSTD)
        self.bag.open()
        self.topics = {}

    def make(self, name, **fields):
        return self.store.types[name](**fields)

    def header(self, seconds, frame):
        whole = int(seconds)
        stamp = self.make("builtin_interfaces/msg/Time", sec=whole, nanosec=round((seconds - whole) * 1e9))
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **({"seq": 0} if self.one else {}))

    def put(self, topic, kind, message, seconds):
        if topic not in self.topics:
            self.topics[topic] = self.bag.add_connection(topic, kind, typestore=self.store)
        data = (self.store.serialize_ros1 if self.one else self.store.serialize_cdr)(message, kind)
        self.bag.write(self.topics[topic], round((seconds + 0.004) * 1e9), data)  # a recorder is some milliseconds late

    def info(self, topic, size, lengths, seconds, frame, lens=(0.0,) * 5, p=None, model="plumb_bob"):
        fx, fy, cx, cy = lengths
        k = np.array([fx, 0, cx, 0, fy, cy, 0, 0, 1.0])
        p = np.array([fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0.0]) if p is None else np.array(p, float)
        names = ("D", "K", "R", "P") if self.one else ("d", "k", "r", "p")
        matrices = dict(zip(names, (np.array(lens, float), k, np.eye(3).ravel(), p), strict=True))
        roi = self.make("sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
        made = self.make(
            "sensor_msgs/msg/CameraInfo", header=self.header(seconds, frame), height=size[1], width=size[0],
            distortion_model=model, binning_x=0, binning_y=0, roi=roi, **matrices,
        )  # fmt: skip
        self.put(topic, "sensor_msgs/msg/CameraInfo", made, seconds)

    def image(self, topic, pixels, encoding, seconds, frame, pad=0, clock=0.0):
        rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(pixels.shape[0], -1)
        rows = np.pad(rows, ((0, 0), (0, pad)), constant_values=77)  # drivers may fill up rows
        made = self.make(
            "sensor_msgs/msg/Image", header=self.header(seconds + clock, frame),
            height=pixels.shape[0], width=pixels.shape[1],
            encoding=encoding, is_bigendian=0, step=rows.shape[1], data=rows.reshape(-1),
        )  # fmt: skip
        self.put(topic, "sensor_msgs/msg/Image", made, seconds)

    def packed(self, topic, data, form, seconds, frame):
        header = self.header(seconds, frame)
        made = self.make(
            "sensor_msgs/msg/CompressedImage", header=header, format=form, data=np.frombuffer(data, np.uint8)
        )
        self.put(topic, "sensor_msgs/msg/CompressedImage", made, seconds)

    def transform(self, topic, parent, child, place, seconds):
        x, y, z, *q = (float(value) for value in place)
        moved = self.make(
            "geometry_msgs/msg/Transform",
            translation=self.make("geometry_msgs/msg/Vector3", x=x, y=y, z=z),
            rotation=self.make("geometry_msgs/msg/Quaternion", x=q[0], y=q[1], z=q[2], w=q[3]),
        )
        stamped = self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(seconds, parent),
            child_frame_id=child,
            transform=moved,
        )
        self.put(topic, TF, self.make(TF, transforms=[stamped]), seconds)


def stamps():
    return START + np.arange(FRAMES) * STEP_S


def true_depth(frame):
    """(h, w) [m] that a frame shows."""
    return box_scene.depth(box_scene.rays(*SIZE, *LENGTHS), frame)


def camera_place(frame):
    """tx ty tz qx qy qz qw of the camera's base in the world at a frame."""
    return (*(frame * box_scene.STEP), *Rotation.from_rotvec([0, 0.002 * frame, 0]).as_quat())


def stored(frame, encoding):
    """Depth as a driver stores it, one pixel missing."""
    depth = true_depth(frame)
    if encoding == "16UC1":
        counts = np.rint(depth * 1000).astype(np.uint16)
        counts[5, 7] = 0
        return counts
    metres = depth.astype(np.float32)
    metres[5, 7] = np.nan
    return metres


def packed_depth(frame, encoding):
    """compressedDepth as compressed_depth_image_transport makes it: twelve bytes, then a PNG."""
    if encoding == "16UC1":
        head, image = struct.pack("<iff", 0, 0.0, 0.0), stored(frame, encoding)
    else:  # the inverse in steps, finest for 10 m and quantisation 100, its defaults
        a = 100.0 * 101.0
        b = 1 - a / 10.0
        head, metres = struct.pack("<iff", 0, a, b), stored(frame, encoding)
        image = np.where(np.isfinite(metres), np.clip(a / np.nan_to_num(metres, nan=1.0) + b, 0, 65535), 0).astype(
            np.uint16
        )
    return head + cv2.imencode(".png", image)[1].tobytes()


def write(path, kind, encoding="16UC1", packed=False, color="apart", poses=True, infos=True, clock=0.0):
    """A bag of the scene; `color`: "apart", "registered" or ""; its header is `clock` seconds off the depth's."""
    out = Writer(path, kind)
    out.transform("/tf_static", "base", "depth_frame", (0, 0, 0, 0, 0, 0, 1), START)
    out.transform("/tf_static", "depth_frame", "color_frame", COLOR_PLACE, START)
    for frame, seconds in enumerate(stamps()):
        if poses:
            out.transform("/tf", "world", "base", camera_place(frame), seconds)
        if infos:
            out.info(f"{DEPTH}/camera_info", SIZE, LENGTHS, seconds, "depth_frame")
        if packed:
            out.packed(f"{DEPTH}/image_raw/compressedDepth", packed_depth(frame, encoding),
                       f"{encoding}; compressedDepth png", seconds, "depth_frame")  # fmt: skip
        else:
            out.image(f"{DEPTH}/image_raw", stored(frame, encoding), encoding, seconds, "depth_frame", pad=6)
        if color == "registered":
            image = box_scene.color(*SIZE, frame)[..., ::-1]
            out.image("/cam/depth/rgb", image, "bgr8", seconds + 0.003, "depth_frame", clock=clock)
        elif color:
            out.info(f"{COLOR}/camera_info", COLOR_SIZE, COLOR_LENGTHS, seconds, "color_frame", COLOR_LENS)
            out.image(f"{COLOR}/image_raw", box_scene.color(*COLOR_SIZE, frame), "rgb8", seconds + 0.003, "color_frame")
    out.bag.close()
    return path
