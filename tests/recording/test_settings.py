"""How a device was set is read from the file, shown, and kept by a conversion."""

import json
import shutil
from pathlib import Path

import synthetic

from fusion.commands.main import main
from fusion.recording.convert import convert_recording
from fusion.recording.open import open_recording
from fusion.recording.write import write_recording

SAMPLES = Path(__file__).parent / "bags"


def test_settings_of_a_realsense_recording_are_kept_by_a_conversion(tmp_path, capsys):
    recording = open_recording(shutil.copy(SAMPLES / "realsense_2_56.bag", tmp_path / "a.bag"))
    assert recording.settings["Name"] == "Intel RealSense D405" and recording.settings["Depth Units"] == "0.0001"
    convert_recording(recording, tmp_path / "native")
    assert open_recording(tmp_path / "native").settings == recording.settings
    assert main(["info", str(tmp_path / "native"), "--quick"]) == 0
    assert "Depth Units 0.0001" in capsys.readouterr().out


def test_a_device_file_that_is_broken_costs_no_frame(tmp_path):
    write_recording(tmp_path, synthetic.CAMERA, synthetic.frames(2))
    (tmp_path / "device.json").write_text('{"settings": {"gain": 16, "odd": [1]}, "serial": "A1", "tables": {}}')
    assert open_recording(tmp_path).settings == {"serial": "A1", "gain": "16"}
    for text in ("{", "[1]", json.dumps({"settings": 3})):
        (tmp_path / "device.json").write_text(text)
        recording = open_recording(tmp_path)
        assert recording.settings == {} and len(recording)
        assert any("device.json" in said for said in recording.warnings) == (text[:2] != '{"')
