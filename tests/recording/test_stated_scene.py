"""`scene.json` of a recording: checked when the recording is opened, typed wherever it is asked for."""

import json
from dataclasses import replace

import pytest
import synthetic

from fusion.errors import RecordingError
from fusion.recording.native.scene_file import scene_mesh, stated_scene
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("stated") / "r"
    write_recording(path, synthetic.CAMERA, synthetic.frames(1), synthetic.trajectory(1))
    return path


def opened(folder, text):
    (folder / "scene.json").write_text(text)
    return open_recording(folder)


WRONG = [
    ('{"reflectance": NaN}', '"reflectance" cannot be used; .*found NaN; expected a finite number'),
    ('{"reflectance": 1.5}', '"reflectance" of the scene cannot be used.*from 0 to 1'),
    ('{"poses": {"source": "guessed"}}', '"poses.source" of the scene .*"surveyed"'),
    ('{"poses": {"sigma_m": -1}}', r'"poses.sigma_m" of the scene .*of at least 0, below 10 .*\[m\]'),
    ('{"poses": {"from": "thin air"}}', '"poses.from" of the scene .*expected "images"'),
    ('{"ambient_lux": "bright"}', '"ambient_lux" of the scene'),
    ('{"mesh_sigma_m": 40}', "40 looks like millimetres|below 10"),
    ('{"mesh": 7}', "a file's name"),
    ('{"mesh": "a.ply", "mesh": "b.ply"}', '"mesh" twice'),
    ('{"trajectory": {"turntable": {"axis_point": [0, 0]}}}', '"trajectory.turntable.axis_point".*three numbers'),
]


@pytest.mark.parametrize(("text", "said"), WRONG, ids=[text for text, _ in WRONG])
def test_a_wrong_scene_is_told_when_the_recording_is_opened(folder, text, said):
    with pytest.raises(RecordingError, match=said) as caught:
        opened(folder, text)
    assert "scene.json" in str(caught.value) and "\n" not in str(caught.value)


def test_what_is_stated_is_typed_and_the_content_stays_as_it_is(folder):
    text = {"mesh": "a.ply", "poses": {"source": "surveyed", "from": "images"}, "ambient_lux": 300, "own": [1, {}]}
    recording = opened(folder, json.dumps(text))
    stated = stated_scene(recording)
    assert recording.scene == text  # also what others wrote into it
    assert stated.ambient_lux == 300.0 and stated.stated_poses.from_ == "images" and stated.reflectance is None
    assert scene_mesh(recording) == folder / "a.ply"


def test_a_scene_that_was_made_in_memory_is_checked_where_it_is_used(folder):
    recording = replace(opened(folder, "{}"), scene={"reflectance": float("nan")})
    with pytest.raises(RecordingError, match='"reflectance" of the scene'):
        stated_scene(recording)


@pytest.mark.parametrize("name", ["/etc/passwd", "../outside.ply"])
def test_a_mesh_outside_the_recording_is_refused(folder, name):
    with pytest.raises(RecordingError, match="outside its folder"):
        scene_mesh(opened(folder, json.dumps({"mesh": name})))
