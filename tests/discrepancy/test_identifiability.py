"""What a free pose would swallow: on planes, every error of the disparity that is affine in the image."""

import numpy as np
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.observations import observe
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.effects.triangulation.disparity_offset import DisparityOffset
from fusion.sensor.effects.triangulation.pixel_locking import PixelLocking
from fusion.sensor.surface import moved_rigidly


def survival(observations, column: np.ndarray) -> float:
    """Share of a column that is left when every recording's pose is free."""
    left = []
    for rows, patch in observations.rows():
        moves = [moved_rigidly(patch.depth, 1e-7 * np.eye(6)[k], patch.view) * patch.native for k in range(6)]
        poses = np.column_stack([patch.tiles.mean(move) for move in moves])
        basis = np.linalg.svd(poses, full_matrices=False)
        span = basis[0][:, basis[1] > 1e-6 * basis[1][0]]
        left.append(column[rows] - span @ (span.T @ column[rows]))
    return float(np.linalg.norm(np.concatenate(left)) / np.linalg.norm(column))


def test_scale_offset_and_tilt_of_a_triangulating_sensor_vanish_on_walls_with_free_poses():
    sensor = sensor_of("structured_light")
    observations = observe(sensor, looks_at(sensor, 0))
    small = [DepthScale(1e-7), DisparityOffset(1e-7)]
    tilt = np.concatenate([p.tiles.mean(np.broadcast_to(p.view.u, p.depth.shape)) for p in observations.patches])
    columns = [*observations.columns(small).T, tilt]
    for column in columns:
        assert survival(observations, column) < 1e-6
    # and what is not affine stays to be seen
    assert survival(observations, observations.columns([PixelLocking(0.01)])[:, 0]) > 0.3
