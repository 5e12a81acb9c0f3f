"""A take through Intel's own recorder: run by an environment that has pyrealsense2, with numpy alone beside it.

    SDK/bin/python -m tools.formats.writers.realsense TAKE.npz OUT.bag|OUT.db3 [drop] [jump] [plain] [fast]

2.56 writes .bag, 2.58 and later .db3. `drop`: frames 5, 9 and 14 are never handed over, while the counter runs on;
`jump`: the device's clock goes back by 2 s at frame 12; `plain`: not packed (the recorder packs by itself).
"""

import sys
import time

import numpy as np
import pyrealsense2 as rs

DROPPED, JUMP_AT, JUMP_MS = (5, 9, 14), 12, -2000.0


def profile(kind: rs.stream, uid: int, form: rs.format, deep: int, size: tuple, four: tuple, bend: list):
    """A stream; its lens by Brown and Conrady, k1, k2, p1, p2, k3."""
    stream, lens = rs.video_stream(), rs.intrinsics()
    stream.type, stream.index, stream.uid, stream.fmt, stream.fps, stream.bpp = kind, 0, uid, form, 30, deep
    stream.height, stream.width = size
    lens.width, lens.height = stream.width, stream.height
    lens.fx, lens.fy, lens.ppx, lens.ppy = map(float, four)
    lens.model, lens.coeffs = rs.distortion.brown_conrady, [float(k) for k in bend]
    stream.intrinsics = lens
    return stream


def main() -> None:
    """Write the file."""
    take, path, flags = np.load(sys.argv[1]), sys.argv[2], sys.argv[3:]
    device = rs.software_device()
    device.register_info(rs.camera_info.name, "Intel RealSense D405")
    device.register_info(rs.camera_info.serial_number, "0123")
    sensor = device.add_sensor("Stereo Module")
    streams = [profile(rs.stream.depth, 1, rs.format.z16, 2, take["depth"].shape[1:], take["lens"], [0.0] * 5)]
    images, sensors = [take["depth"]], [sensor]
    if "color" in take:
        sensors.append(device.add_sensor("RGB Camera"))
        form = take["color"].shape[1:3], take["color_lens"], take["color_bend"][:5]
        streams.append(profile(rs.stream.color, 2, rs.format.rgb8, 3, *form))
        images.append(take["color"])
    made = [one.add_video_stream(stream) for one, stream in zip(sensors, streams, strict=True)]
    sensor.add_read_only_option(rs.option.depth_units, float(take["unit"]))
    sensor.add_read_only_option(rs.option.exposure, 8500.0)
    sensor.add_read_only_option(rs.option.laser_power, 150.0)
    sensor.add_read_only_option(rs.option.visual_preset, 3.0)
    if len(made) > 1:
        place = rs.extrinsics()
        place.rotation, place.translation = take["T"][:3, :3].T.ravel().tolist(), take["T"][:3, 3].tolist()
        made[0].register_extrinsics_to(made[1], place)
    recorder = rs.recorder(path, device, False) if "plain" in flags else rs.recorder(path, device)
    taps, queue = recorder.query_sensors(), rs.frame_queue(1000)
    for tap in taps:
        tap.open(tap.get_stream_profiles())
        tap.start(queue)
    for number, stamp in enumerate(take["stamps"]):
        if "drop" in flags and number in DROPPED:
            continue
        late = JUMP_MS if "jump" in flags and number >= JUMP_AT else 0.0
        for one, stream, pixels in zip(sensors, made, images, strict=True):
            push(one, stream, np.ascontiguousarray(pixels[number % len(pixels)]), stamp * 1000 + late, number)
        time.sleep(
            0.002 if "fast" in flags else 0.01
        )  # the recorder writes in a thread of its own and drops what comes too fast
    time.sleep(1.0)
    for tap in taps:
        tap.stop()
        tap.close()


def push(sensor: rs.software_sensor, stream: rs.stream_profile, pixels: np.ndarray, ms: float, number: int) -> None:
    """One frame."""
    frame = rs.software_video_frame()
    frame.pixels, frame.bpp = pixels, pixels.itemsize * (3 if pixels.ndim == 3 else 1)
    frame.stride = pixels.shape[1] * frame.bpp
    frame.timestamp, frame.domain = ms, rs.timestamp_domain.hardware_clock
    frame.frame_number, frame.profile = number, stream.as_video_stream_profile()
    sensor.on_video_frame(frame)


if __name__ == "__main__":
    main()
