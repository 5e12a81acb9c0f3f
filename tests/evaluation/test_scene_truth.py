"""A stated mesh with surveyed poses is the truth."""

import numpy as np
import pytest
from made_stills import CAMERA, frames, recording

from fusion.errors import FusionError
from fusion.evaluation.evaluate import evaluate
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.files import write_mesh
from fusion.mesh.mesh import Mesh


def test_a_surveyed_mesh_tells_the_offset(tmp_path):
    # a wall 1.2 m from the origin, seen by a camera that stands 0.1 m behind it
    corners = np.array([[-3, -3, 1.2], [3, -3, 1.2], [3, 3, 1.2], [-3, 3, 1.2]], float)
    write_mesh(tmp_path / "scene.ply", Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32)))
    pose = np.eye(4)
    pose[2, 3] = -0.1
    poses = Trajectory(np.array([0.0]), pose[None])
    scene = {"mesh": "scene.ply", "poses": {"source": "surveyed", "sigma_m": 1e-3}}
    rng = np.random.default_rng(0)
    flat = frames(5, change=lambda i, z: (1.303 + 1e-3 * rng.standard_normal(CAMERA.shape)).astype(np.float32))
    made = recording(flat, scene=scene, poses=poses, name=str(tmp_path))
    look = evaluate([made]).looks[0]
    assert look.surface.kind == "scene" and look.bias.truth == "scene"
    assert look.bias.offset == pytest.approx(0.003, abs=2e-4)  # 190 px x 5 frames of 1 mm
    (tmp_path / "scene.ply").unlink()
    with pytest.raises(FusionError, match="mesh of the scene does not exist"):
        evaluate([made])
    tracked = recording(flat, scene=scene | {"poses": {"source": "tracked"}}, poses=poses, name=str(tmp_path))
    assert evaluate([tracked]).looks[0].surface.kind == "plane"
