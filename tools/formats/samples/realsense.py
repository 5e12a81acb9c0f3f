"""A RealSense recording of a rendered scene by the maker's own recorder, without a camera.

    python -m tools.formats.samples.realsense OUT.bag    needs pyrealsense2 2.56 (the last that writes .bag)
    python -m tools.formats.samples.realsense OUT.db3    needs pyrealsense2 2.58 or later

Each in an environment of its own with numpy: `python -m venv sdk; sdk/bin/pip install numpy pyrealsense2==2.56.5.9235`.
The samples in tests/recording/bags/ were made so. `--check FILE` prints what the SDK itself reads of a file.
"""

import sys
import time
from pathlib import Path

import numpy as np
import pyrealsense2 as rs

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "tests" / "recording" / "bags"))
import box_scene

DEPTH = {"size": (64, 48), "lengths": (55.0, 56.0, 31.25, 23.5), "lens": [0.0] * 5}
COLOR = {"size": (56, 40), "lengths": (50.0, 51.0, 27.75, 19.5), "lens": [0.08, -0.12, 0.002, -0.001, 0.03]}
UNIT_M = 0.0001
ANGLE, SHIFT = 0.1, [0.015, 0.001, 0.0002]  # from the depth to the colour camera: about z, and [m]
FRAMES, STEP_MS, LATE_MS = 3, 33.25, 4.0


def profile(kind: rs.stream, uid: int, form: rs.format, bytes_each: int, camera: dict, model: rs.distortion):
    """A stream of the device that is made up."""
    stream, lens = rs.video_stream(), rs.intrinsics()
    stream.type, stream.index, stream.uid, stream.fmt, stream.fps, stream.bpp = kind, 0, uid, form, 30, bytes_each
    (stream.width, stream.height), (lens.fx, lens.fy, lens.ppx, lens.ppy) = camera["size"], camera["lengths"]
    lens.width, lens.height, lens.model, lens.coeffs = stream.width, stream.height, model, camera["lens"]
    stream.intrinsics = lens
    return stream


def record(path: str) -> None:
    """Push frames of the scene through the SDK's recorder."""
    device = rs.software_device()
    device.register_info(rs.camera_info.name, "Intel RealSense D405")
    device.register_info(rs.camera_info.serial_number, "0123")
    sensors = [device.add_sensor("Stereo Module"), device.add_sensor("RGB Camera")]
    depth = sensors[0].add_video_stream(
        profile(rs.stream.depth, 1, rs.format.z16, 2, DEPTH, rs.distortion.brown_conrady)
    )
    color = sensors[1].add_video_stream(
        profile(rs.stream.color, 2, rs.format.rgb8, 3, COLOR, rs.distortion.inverse_brown_conrady)
    )
    sensors[0].add_read_only_option(rs.option.depth_units, UNIT_M)
    place = rs.extrinsics()
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    place.rotation, place.translation = [c, s, 0, -s, c, 0, 0, 0, 1], SHIFT  # columns one after the other
    depth.register_extrinsics_to(color, place)
    recorder = rs.recorder(path, device)
    taps, queue = recorder.query_sensors(), rs.frame_queue(100)
    for tap in taps:
        tap.open(tap.get_stream_profiles())
        tap.start(queue)
    rays = box_scene.rays(*DEPTH["size"], *DEPTH["lengths"])
    for number in range(FRAMES):
        counts = np.rint(box_scene.depth(rays, number) / UNIT_M).astype(np.uint16)
        images = (counts, box_scene.color(*COLOR["size"], number))
        for sensor, one, pixels, late in zip(sensors, (depth, color), images, (0.0, LATE_MS), strict=True):
            frame = rs.software_video_frame()
            frame.pixels, frame.bpp = np.ascontiguousarray(pixels), pixels.itemsize * (pixels.ndim * 2 - 3 or 1)
            frame.stride = pixels.shape[1] * frame.bpp
            frame.timestamp, frame.domain = 1000 + number * STEP_MS + late, rs.timestamp_domain.hardware_clock
            frame.frame_number, frame.profile = number, one.as_video_stream_profile()
            sensor.on_video_frame(frame)
    time.sleep(0.5)  # the recorder writes in a thread of its own
    for tap in taps:
        tap.stop()
        tap.close()


def check(path: str) -> None:
    """What the SDK reads of a file: the judge of unit, lens and places."""
    device = rs.context().load_device(path)
    profiles = [one for sensor in device.query_sensors() for one in sensor.get_stream_profiles()]
    depth, color = (next(p for p in profiles if p.stream_type() == kind) for kind in (rs.stream.depth, rs.stream.color))
    print(depth.as_video_stream_profile().get_intrinsics(), color.as_video_stream_profile().get_intrinsics())
    print(depth.get_extrinsics_to(color))


if __name__ == "__main__":
    check(sys.argv[2]) if sys.argv[1] == "--check" else record(sys.argv[1])
