"""A take through Foxglove's own MCAP writer (mcap, mcap-ros2-support), which rosbags has no part in.

ENV/bin/python -m tools.formats.writers.foxglove_mcap TAKE.npz OUT.mcap [16UC1|32FC1]
"""

import sys
from pathlib import Path

import numpy as np
from mcap_ros2.writer import Writer

HEADER = "std_msgs/Header header\n"
PARTS = {
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
}
IMAGE = HEADER + "uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n"
ROI = {
    "sensor_msgs/RegionOfInterest": "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"
}
INFO = HEADER + (
    "uint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\n"
    "uint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n"
)
START, LATE_S = 1_700_000_000, 0.004


def definition(text: str, parts: dict) -> str:
    """A message definition with those that it names."""
    line = "=" * 80
    return text + "".join(f"{line}\nMSG: {name}\n{body}" for name, body in parts.items())


def main() -> None:
    """Write the file."""
    take, path = np.load(sys.argv[1]), Path(sys.argv[2])
    encoding = sys.argv[3] if len(sys.argv) > 3 else "16UC1"
    counts, (fx, fy, cx, cy) = take["depth"], take["lens"].tolist()
    h, w = counts.shape[1:]
    with path.open("wb") as file:
        out = Writer(file)
        image = out.register_msgdef("sensor_msgs/msg/Image", definition(IMAGE, PARTS))
        info = out.register_msgdef("sensor_msgs/msg/CameraInfo", definition(INFO, PARTS | ROI))
        for i, stamp in enumerate(take["stamps"].tolist()):
            k = i % len(counts)
            ns = round(stamp * 1e9) + START * 10**9
            head = {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}, "frame_id": "depth_optical"}
            roi = {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}
            said = {"header": head, "height": h, "width": w, "distortion_model": "plumb_bob", "d": [0.0] * 5}
            said |= {"k": [fx, 0, cx, 0, fy, cy, 0, 0, 1.0], "r": np.eye(3).ravel().tolist(), "binning_x": 0}
            said |= {"p": [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1.0, 0], "binning_y": 0, "roi": roi}
            metres = np.where(counts[k] > 0, counts[k] * float(take["unit"]), np.nan).astype(np.float32)
            millimetres = np.rint(counts[k] * float(take["unit"]) * 1000).astype(np.uint16)
            pixels = {"32FC1": metres, "16UC1": millimetres}[encoding]
            times = {"log_time": ns + int(LATE_S * 1e9), "publish_time": ns}
            out.write_message("/depth/camera_info", info, said, **times)
            out.write_message("/depth/image_raw", image, pictured(head, pixels, encoding), **times)
            if "color" in take:
                out.write_message("/color/camera_info", info, said, **times)
                out.write_message("/color/image_raw", image, pictured(head, take["color"][i], "rgb8"), **times)
        out.finish()


def pictured(head: dict, pixels: np.ndarray, encoding: str) -> dict:
    """sensor_msgs/Image."""
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(pixels.shape[0], -1)
    held = {"header": head, "height": pixels.shape[0], "width": pixels.shape[1], "encoding": encoding}
    return held | {"is_bigendian": 0, "step": rows.shape[1], "data": rows.tobytes()}


if __name__ == "__main__":
    main()
