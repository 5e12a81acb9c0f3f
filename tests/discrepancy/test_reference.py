"""A mesh that was made of the recordings themselves: the verdict says what it may hold."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.observe.scene.stage import RECONSTRUCTED_M, KnownScene, stage_of
from fusion.discrepancy.verdict.reference import reference_of
from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.files import write_mesh
from fusion.mesh.mesh import Mesh
from fusion.recording.recording import Recording


def observed(reconstructed):
    sensor = sensor_of("itof")
    sigma = RECONSTRUCTED_M if reconstructed else 0.0
    blocks = [
        replace(
            block, stage=KnownScene(None, block.place, None, 0.001, 0.001, sigma, "wall", reconstructed=reconstructed)
        )
        for block in looks_at(sensor, 1)[:4]
    ]
    observations = observe(sensor, blocks)
    covariance = covariance_of(observations)
    return observations, covariance, candidates_of(observations, covariance)


def test_what_is_wrong_from_every_side_is_hidden_and_a_short_wave_is_not():
    said = reference_of(*observed(reconstructed=True))
    assert said is not None and said.mesh == "reconstruction"
    assert "fixed_pattern" in said.hides and "fixed_pattern" in said.text
    # its period is shorter than any dent of the mesh
    assert "cyclic_error" not in said.hides


def test_a_mesh_of_another_origin_hides_nothing():
    assert reference_of(*observed(reconstructed=False)) is None


def test_the_scene_file_says_where_the_mesh_is_from(tmp_path):
    corners = np.array([[0, 0, 1.0], [1, 0, 1], [0, 1, 1]])
    write_mesh(tmp_path / "scene.ply", Mesh(corners, np.array([[0, 1, 2]], np.int32)))
    camera = Camera(8, 6, 8.0, 8.0, 3.5, 2.5)
    poses = Trajectory(np.zeros(1), np.eye(4)[None])

    def stage(**scene):
        scene = {"mesh": "scene.ply", **scene}
        return stage_of(Recording(tmp_path, "native", camera, np.zeros(1), lambda index: None, poses, {}, scene), 0)

    own = stage(mesh_from="reconstruction")
    assert own.reconstructed and own.mesh_sigma_m == RECONSTRUCTED_M
    assert stage(mesh_from="reconstruction", mesh_sigma_m=0.001).mesh_sigma_m == 0.001
    assert not stage().reconstructed and stage().mesh_sigma_m is None
    with pytest.raises(RecordingError, match="mesh_from"):
        stage(mesh_from="scanner")
