"""Depth where the stated lens has no ray is left out and told: a point there would stand anywhere."""

from dataclasses import replace

import numpy as np
import synthetic

from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording


def test_depth_beyond_the_lens_is_left_out(tmp_path):
    camera = replace(synthetic.CAMERA, fx=80.0, fy=80.0, distortion=(-0.3,))
    write_recording(tmp_path, camera, synthetic.frames(2))
    recording = open_recording(tmp_path)
    blind = camera.blind()
    assert 0.1 < blind.mean() < 0.9
    depth, stored = recording[0].depth, synthetic.frames(1)[0].depth
    assert np.isnan(depth[blind]).all() and (np.isfinite(depth) == np.isfinite(stored) & ~blind).all()
    assert [f"{blind.mean():.1%}" in said for said in recording.warnings] == [True]
