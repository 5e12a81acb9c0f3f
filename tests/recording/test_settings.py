"""How a device was set is read from the file, shown, and kept by a conversion."""

import json
import shutil
from pathlib import Path

import numpy as np
import synthetic

from fusion.commands.main import main
from fusion.recording.open import open_recording
from fusion.recording.writing.convert import convert_recording
from fusion.recording.writing.write import write_recording

SAMPLES = Path(__file__).parent / "bags"


def test_settings_of_a_realsense_recording_are_kept_by_a_conversion(tmp_path, capsys):
    recording = open_recording(shutil.copy(SAMPLES / "realsense_2_56.bag", tmp_path / "a.bag"))
    assert recording.settings["Name"] == "Intel RealSense D405" and recording.settings["Depth Units"] == "0.0001"
    convert_recording(recording, tmp_path / "native")
    assert open_recording(tmp_path / "native").settings == recording.settings
    assert main(["convert", str(tmp_path / "a.bag"), str(tmp_path / "a.mcap"), "--format", "mcap"]) == 0
    assert open_recording(tmp_path / "a.mcap").settings == recording.settings
    capsys.readouterr()
    assert main(["info", str(tmp_path / "native"), "--quick"]) == 0
    told = capsys.readouterr().out
    assert "Depth Units 0.0001" in told and "0.1 mm a count" in told and "clock: " in told


def test_cameras_unit_and_clock_are_shown(tmp_path, capsys):
    from dataclasses import replace

    beside = replace(synthetic.CAMERA, distortion=(0.1, 0.0, 0.0, 0.0, -0.02, 0.0, 0.0, 0.0))
    T = np.eye(4)
    T[:3, 3] = [0.03, 0.04, 0.0]
    camera = replace(synthetic.CAMERA, color=beside, T_color_depth=T)
    frames = [replace(frame, timestamp=1_400_000_000.0 + frame.timestamp) for frame in synthetic.frames(2)]
    write_recording(tmp_path, camera, frames)
    main(["info", str(tmp_path), "--quick"])
    told = capsys.readouterr().out
    assert "lens of 2 values, 50.0 mm from the depth camera" in told and "(2014-05-13 " in told


def test_a_device_file_that_is_broken_costs_no_frame(tmp_path):
    write_recording(tmp_path, synthetic.CAMERA, synthetic.frames(2))
    (tmp_path / "device.json").write_text('{"settings": {"gain": 16, "odd": [1]}, "serial": "A1", "tables": {}}')
    assert open_recording(tmp_path).settings == {"serial": "A1", "gain": "16"}
    for text in ("{", "[1]", json.dumps({"settings": 3})):
        (tmp_path / "device.json").write_text(text)
        recording = open_recording(tmp_path)
        assert recording.settings == {} and len(recording)
        assert any("device.json" in said for said in recording.warnings) == (text[:2] != '{"')
