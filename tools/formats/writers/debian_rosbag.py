"""A take through ROS 1's own recorder library, Debian's rosbag, which rosbags has no part in.

python3 -m tools.formats.writers.debian_rosbag TAKE.npz OUT.bag none|lz4|bz2, with Debian's packages on PYTHONPATH.
"""

import sys

import genpy
import numpy as np
import rosbag
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

START, LATE_S = 1_700_000_000, 0.004
WORLD, EYE = "map", "camera_depth_optical_frame"


def main() -> None:
    """Write the file: depth of whole millimetres, its camera, colour in its pixels, the camera's way in /tf."""
    take = np.load(sys.argv[1])
    millimetres = np.rint(take["depth"] * float(take["unit"]) * 1000).astype(np.uint16)
    h, w = millimetres.shape[1:]
    fx, fy, cx, cy = take["lens"].tolist()
    with rosbag.Bag(sys.argv[2], "w", compression=sys.argv[3]) as bag:
        for i, stamp in enumerate(take["stamps"].tolist()):
            ns = round(stamp * 1e9)
            time = genpy.Time(START + ns // 10**9, ns % 10**9)
            late = time + genpy.Duration(0, int(LATE_S * 1e9))
            if "poses" in take:
                bag.write("/tf", TFMessage([transform(take["poses"][i], time)]), late)
            head = Header(stamp=time, frame_id=EYE)
            said = {"D": [0.0] * 5, "K": [fx, 0, cx, 0, fy, cy, 0, 0, 1], "P": [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0]}
            info = CameraInfo(
                header=head, height=h, width=w, distortion_model="plumb_bob", R=np.eye(3).ravel().tolist(), **said
            )
            bag.write("/camera/depth/camera_info", info, late)
            bag.write("/camera/depth/image_rect_raw", image(head, millimetres[i % len(millimetres)], "16UC1"), late)
            if "color" in take:
                bag.write("/camera/color/camera_info", info, late)
                bag.write("/camera/color/image_raw", image(head, take["color"][i], "rgb8"), late)


def image(head: Header, pixels: np.ndarray, encoding: str) -> Image:
    """sensor_msgs/Image."""
    step = pixels.nbytes // pixels.shape[0]
    data = np.ascontiguousarray(pixels).tobytes()
    return Image(header=head, height=pixels.shape[0], width=pixels.shape[1], encoding=encoding, step=step, data=data)


def transform(T: np.ndarray, time: genpy.Time) -> TransformStamped:
    """The camera in the world; the quaternion from the matrix by its trace, as turns here are small."""
    w = np.sqrt(1 + np.trace(T[:3, :3])) / 2
    x, y, z = (T[2, 1] - T[1, 2], T[0, 2] - T[2, 0], T[1, 0] - T[0, 1]) / (4 * w)
    turned = Transform(translation=Vector3(*T[:3, 3]), rotation=Quaternion(x, y, z, w))
    return TransformStamped(header=Header(stamp=time, frame_id=WORLD), child_frame_id=EYE, transform=turned)


if __name__ == "__main__":
    main()
