"""Masks: matched to the frames by name or stamp, nonzero is the object, and one clear line when they do not fit."""

import cv2
import numpy as np
import pytest
from synthetic import CAMERA, frames

from fusion.errors import RecordingError
from fusion.recording.images.masks import open_masks
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording

COUNT = 6
OBJECT = np.zeros(CAMERA.shape, np.uint8)
OBJECT[30:80, 40:100] = 1  # any value above zero


@pytest.fixture
def recording(tmp_path):
    write_recording(tmp_path / "rec", CAMERA, frames(COUNT))
    return open_recording(tmp_path / "rec")


def moved(index):
    return np.roll(OBJECT, 3 * index, axis=1)


def written(folder, names, image=moved):
    folder.mkdir()
    for index, name in enumerate(names):
        assert cv2.imwrite(str(folder / f"{name}.png"), image(index))
    return folder


def stems(recording):
    return [name.split("/")[-1].removesuffix(".png") for name in recording.files.depth]


def test_one_mask_serves_all_frames(recording, tmp_path):
    file = written(tmp_path / "m", ["only"]) / "only.png"
    masks = open_masks(file, recording)
    assert not masks.moving and all(np.array_equal(masks[i], OBJECT > 0) for i in range(COUNT))


@pytest.mark.parametrize("by", ["name", "stamp", "stamp of the colour camera"])
def test_a_folder_has_one_for_each_frame(recording, tmp_path, by):
    stamps = recording.timestamps + (0.011 if "colour" in by else 0.0)
    names = stems(recording) if by == "name" else [f"{t:.6f}" for t in stamps]
    masks = open_masks(written(tmp_path / "m", names), recording)
    assert masks.moving and all(np.array_equal(masks[i], moved(i) > 0) for i in range(COUNT))


def test_colours_and_transparency_mark_as_well(recording, tmp_path):
    color = np.zeros((*CAMERA.shape, 3), np.uint8)
    color[OBJECT > 0] = [0, 0, 200]
    cut_out = np.full((*CAMERA.shape, 4), 90, np.uint8)  # an image whose background was made transparent
    cut_out[..., 3] = np.where(OBJECT, 255, 0)
    for place, image in enumerate((color, cut_out, 255 * OBJECT.astype(np.uint16))):
        file = tmp_path / f"{place}.png"
        cv2.imwrite(str(file), image)
        assert np.array_equal(open_masks(file, recording)[0], OBJECT > 0)


def bad(kind, recording, tmp_path):
    folder = tmp_path / "m"
    if kind == "nothing there":
        return folder
    if kind == "no PNG in it":
        folder.mkdir()
        (folder / "mask.txt").write_text("1")
        return folder
    if kind == "two frames without":
        return written(folder, stems(recording)[:-2])
    if kind == "other names":
        return written(folder, [f"mask{i}" for i in range(COUNT)])
    if kind == "one of another size":
        return written(folder, stems(recording), lambda i: moved(i)[: 60 if i == 3 else None])
    if kind == "a JPEG":
        cv2.imwrite(str(tmp_path / "m.jpg"), OBJECT)
        return tmp_path / "m.jpg"
    if kind == "cut off":
        whole = (written(folder, ["m"]) / "m.png").read_bytes()
        (folder / "m.png").write_bytes(whole[: len(whole) // 2])
        return folder / "m.png"
    image = {"empty": np.zeros_like(OBJECT), "full": np.ones_like(OBJECT)}[kind]
    return written(folder, stems(recording), lambda i: image)


TOLD = {
    "nothing there": "does not exist",
    "no PNG in it": "no mask",
    "two frames without": "2 of 6 frames",
    "other names": "6 of 6 frames",
    "one of another size": "160 x 60",
    "a JPEG": "not a PNG",
    "cut off": "cut off",
    "empty": "marks nothing",
    "full": "marks everything",
}


@pytest.mark.parametrize(("kind", "told"), TOLD.items(), ids=TOLD)
def test_what_does_not_fit_is_told_in_one_line(recording, tmp_path, kind, told):
    with pytest.raises(RecordingError, match=told) as caught:
        open_masks(bad(kind, recording, tmp_path), recording)
    assert "\n" not in str(caught.value)


def test_the_file_of_another_size_is_named(recording, tmp_path):
    with pytest.raises(RecordingError, match=rf"{stems(recording)[3]}\.png"):
        open_masks(bad("one of another size", recording, tmp_path), recording)
