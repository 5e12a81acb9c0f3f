"""Statistics of still frames: what was put in is measured, what walks by spoils nothing, broken input is told."""

from dataclasses import replace

import numpy as np
import pytest
from made_stills import CAMERA, NOISE, frames, recording, stated, wall

from fusion.calibration.stretches import still_stretches
from fusion.errors import FusionError
from fusion.evaluation.evaluate import EvaluationSettings, evaluate
from fusion.evaluation.still.statistics import KEPT, sample_of
from fusion.recording.recording import Frame

COUNT = 40


def walker(i: int, depth: np.ndarray) -> np.ndarray:
    """A person, 30 px wide, who walks through in front of the wall within the frames."""
    out = depth.copy()
    left = 3 * i - 15
    out[20:70, max(left, 0) : max(left + 30, 0)] = 0.8
    return out


def test_statistics_are_those_of_numpy():
    made = frames(COUNT)
    rng = np.random.default_rng(1)
    for frame in made:
        frame.depth[rng.random(CAMERA.shape) < 0.1] = np.nan
    look = evaluate([recording(made)], EvaluationSettings(pixel=(30, 20))).looks[0]
    stack = np.array([frame.depth for frame in made], float)
    assert np.allclose(look.still.depth.mean, np.nanmean(stack, axis=0), rtol=1e-6)
    # differences from the first value are taken in single precision: 1e-7 m of 2 mm
    assert np.allclose(look.still.depth.std, np.nanstd(stack, axis=0, ddof=1), rtol=1e-3)
    ir, color = (np.array([getattr(frame, name) for frame in made], float) for name in ("ir", "color"))
    assert np.allclose(look.still.ir.mean, ir.mean(axis=0)) and np.allclose(look.still.ir.std, ir.std(axis=0, ddof=1))
    assert np.allclose(look.still.color.std, color.std(axis=0, ddof=1))
    assert np.array_equal(look.still.series, stack[:, 20, 30], equal_nan=True)
    # the median of the robust deviation is that of the noise: 40 values a pixel, 7000 pixels, a few % of bias
    assert abs(np.nanmedian(look.still.robust) / NOISE - 1) < 0.06
    assert abs(look.missing - 0.1) < 0.01 and look.outliers == 0


def test_someone_who_walks_by_spoils_nothing():
    quiet, walked = (evaluate([recording(frames(COUNT, change=change))]).looks[0] for change in (None, walker))
    assert len(walked.still.disturbed) > 0.6 * COUNT
    # nowhere in the way does the deviation grow: 40 - 10 values leave 13 % at one sigma, five sigma are seen by chance
    known = np.isfinite(walked.still.depth.std)
    assert known.all() and np.nanmax(walked.still.depth.std) < 1.7 * NOISE
    assert abs(np.median(walked.still.depth.std) / np.median(quiet.still.depth.std) - 1) < 0.03
    assert np.abs(walked.still.depth.mean - wall()).max() < 6 * NOISE / np.sqrt(20)
    assert any("something moves" in text for _, text in evaluate([recording(frames(COUNT, change=walker))]).notes)


def test_a_recording_of_several_distances_is_split():
    made = [*frames(10, 1.0), *frames(10, 1.5)]
    made = [replace(frame, index=i, timestamp=i / 30) for i, frame in enumerate(made)]
    by_image = still_stretches(recording(made))
    assert [stretch.frames for stretch in by_image] == [(0, 10), (10, 20)]
    log = {"timestamp": np.arange(20) / 30, "distance_m": np.repeat([1.0, 1.5], 10)}
    assert [s.frames for s in still_stretches(recording(made, telemetry=log))] == [(0, 10), (10, 20)]


def test_the_sample_does_not_grow_with_the_recording():
    many = recording(frames(3 * KEPT))
    assert len(sample_of(still_stretches(many)[0]).frames) == KEPT


def test_a_broken_frame_is_told_and_left_out(tmp_path):
    from made_stills import folder

    opened = folder(tmp_path / "wall", frames(10))
    (tmp_path / "wall/depth/000003.png").write_bytes(b"no image")
    found = evaluate([opened])
    assert found.looks[0].still.frames == 9
    assert any("1 frame could not be read" in text for _, text in found.notes)


def test_one_frame_says_what_it_can():
    found = evaluate([recording(frames(1))])
    assert found.looks[0].noise is None and found.looks[0].drift.verdict == "too short to say"
    assert any("one frame only" in text for _, text in found.notes)


def test_noise_that_all_pixels_share_is_told():
    rng = np.random.default_rng(5)
    shifts = 0.003 * rng.standard_normal(COUNT)
    found = evaluate([recording(frames(COUNT, change=lambda i, z: z + np.float32(shifts[i])))])
    assert abs(found.looks[0].common / shifts.std(ddof=1) - 1) < 0.05  # 190 px of 2 mm leave 0.15 mm
    assert any("shared by all pixels" in text for _, text in found.notes)


def nothing(i: int, depth: np.ndarray) -> np.ndarray:
    return np.full_like(depth, np.nan)


def turning_camera(i: int, depth: np.ndarray) -> np.ndarray:
    return depth * np.float32(1 + 0.05 * i)


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: [recording(frames(3, change=nothing))], "no frame has a depth"),
        (lambda: [recording(frames(8, change=turning_camera))], "nothing stands still"),
        (lambda: [recording([])], "no frames"),
        (list, "no recording"),
        (lambda: [recording(frames(2)), _small()], "different sizes"),
        (lambda: [recording(frames(2), telemetry=stated(-1.0))], "stated distance is not usable"),
    ],
)
def test_what_cannot_be_evaluated_is_told_in_one_line(made, message):
    with pytest.raises(FusionError, match=message) as told:
        evaluate(made())
    assert "\n" not in str(told.value)


def _small():
    camera = replace(CAMERA, width=48, height=36)
    return recording([Frame(0, 0.0, np.ones(camera.shape, np.float32))], camera=camera)


def test_a_pixel_beside_the_image_is_told():
    with pytest.raises(FusionError, match="not in the image"):
        evaluate([recording(frames(2))], EvaluationSettings(pixel=(96, 0)))
