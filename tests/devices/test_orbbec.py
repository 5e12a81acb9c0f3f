"""Orbbec's adapter against a library that is made up, and its names against the real one where that is installed.

That says nothing of cameras: nobody has tried one, and the source says so.
"""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from fusion.devices.open import open_source
from fusion.devices.orbbec import UNTRIED
from fusion.errors import DeviceError

LENS = SimpleNamespace(width=8, height=6, fx=9.0, fy=9.0, cx=3.5, cy=2.5)
BENT = SimpleNamespace(**dict.fromkeys(("k2", "p1", "p2", "k3", "k4", "k5", "k6"), 0.0), k1=0.1)


def profile():
    place = SimpleNamespace(rot=np.eye(3, dtype=np.float32), transform=np.array([10, 0, 0], np.float32))
    return SimpleNamespace(
        get_intrinsic=lambda: LENS,
        get_distortion=lambda: BENT,
        get_fps=lambda: 30,
        get_extrinsic_to=lambda other: place,
    )


def picture(data, form="", number=0):
    return SimpleNamespace(
        get_height=lambda: 6,
        get_width=lambda: 8,
        get_data=lambda: data.reshape(-1).view(np.uint8),
        get_format=lambda: form,
        get_depth_scale=lambda: 0.5,
        get_timestamp_us=lambda: 1_000_000 + 33_333 * number,
        get_system_timestamp_us=lambda: 1_700_000_000_000_000 + 33_333 * number,
        get_index=lambda: number,
    )


class Library:
    """What is used of pyorbbecsdk."""

    OBError = type("OBError", (Exception,), {})
    OBSensorType = SimpleNamespace(DEPTH_SENSOR=1, COLOR_SENSOR=2)
    OBFrameAggregateOutputMode = SimpleNamespace(ANY_SITUATION=2)
    OBFormat = SimpleNamespace(MJPG="mjpg", RGB="rgb", BGR="bgr", YUYV="yuyv", UYVY="uyvy")
    numbers = (0, 1, 4)

    class Config:
        def enable_stream(self, one):
            pass

        def set_frame_aggregate_output_mode(self, mode):
            assert mode == 2

    class Context:
        def query_devices(self):
            info = SimpleNamespace(
                get_serial_number=lambda: "AB1", get_firmware_version=lambda: "1.2", get_name=lambda: "Orbbec Gemini 2"
            )
            device = SimpleNamespace(get_device_info=lambda: info)
            return SimpleNamespace(
                get_count=lambda: 1,
                get_device_serial_number_by_index=lambda i: "AB1",
                get_device_by_index=lambda i: device,
            )

    class Pipeline:
        def __init__(self, device):
            self.left = list(Library.numbers)

        def get_stream_profile_list(self, sensor):
            return SimpleNamespace(get_default_video_stream_profile=profile)

        def start(self, config):
            pass

        def stop(self):
            pass

        def wait_for_frames(self, wait):
            number = self.left.pop(0)
            counts = np.full((6, 8), 2000 + number, np.uint16)
            counts[0, 0] = 0
            colors = np.full((6, 8, 3), (1, 2, 3), np.uint8)
            return SimpleNamespace(
                get_depth_frame=lambda: picture(counts, number=number), get_color_frame=lambda: picture(colors, "bgr")
            )


def test_frames_and_camera_are_those_of_the_library(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyorbbecsdk", Library)
    with open_source("orbbec:AB1") as source:
        frames = [frame for _, frame in zip(range(3), source.frames(), strict=False)]
    told = source.describe()
    assert told.notes == (UNTRIED,)
    assert (told.camera.principle, told.serial) == ("active_stereo", "AB1")
    np.testing.assert_allclose(told.camera.T_color_depth[:3, 3], [0.01, 0, 0])
    for frame, number in zip(frames, Library.numbers, strict=True):
        np.testing.assert_allclose(frame.depth[1:], (2000 + number) * 0.0005)
        assert np.isnan(frame.depth[0, 0])
        assert (frame.color_apart == (3, 2, 1)).all()
    assert [frame.missed for frame in frames] == [0, 0, 2]
    for name, words in (("orbbec:99", "no such Orbbec camera"), ("orbbec", "infrared")):
        with pytest.raises(DeviceError, match=words):
            open_source(name, infrared=True)


def test_the_names_are_those_of_the_real_library():
    sdk = pytest.importorskip("pyorbbecsdk", reason="pyorbbecsdk2, of the extra orbbec, is not installed")
    used = {
        "Pipeline": "get_stream_profile_list start stop wait_for_frames",
        "Config": "enable_stream set_frame_aggregate_output_mode",
        "Context": "query_devices",
        "DeviceList": "get_count get_device_serial_number_by_index get_device_by_index",
        "Device": "get_device_info",
        "DeviceInfo": "get_serial_number get_firmware_version get_name",
        "StreamProfileList": "get_default_video_stream_profile",
        "VideoStreamProfile": "get_intrinsic get_distortion get_fps get_extrinsic_to",
        "FrameSet": "get_depth_frame get_color_frame",
        "DepthFrame": "get_height get_width get_data get_depth_scale get_timestamp_us get_system_timestamp_us "
        "get_index",
        "OBFormat": "MJPG RGB BGR YUYV UYVY",
        "OBSensorType": "DEPTH_SENSOR COLOR_SENSOR",
        "OBFrameAggregateOutputMode": "ANY_SITUATION",
        "OBCameraIntrinsic": "width height fx fy cx cy",
        "OBCameraDistortion": "k1 k2 p1 p2 k3 k4 k5 k6",
        "OBExtrinsic": "rot transform",
    }
    assert [
        f"{kind}.{n}" for kind, names in used.items() for n in names.split() if not hasattr(getattr(sdk, kind), n)
    ] == []
    assert issubclass(sdk.OBError, Exception)
