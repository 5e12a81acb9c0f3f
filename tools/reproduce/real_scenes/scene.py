"""Scenes beside recordings: a mesh, and how well its pose is known."""

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.files import write_mesh
from fusion.mesh.mesh import Mesh

Poses = tuple[str, float, float]  # source, sigma [m], sigma [rad]


def flat_mesh(x: tuple[float, float], y: tuple[float, float]) -> Mesh:
    """A rectangle of the plane z = 0 [m] that looks to -z, as a board in OpenCV's frame looks to the camera."""
    corners = np.array([[x[0], y[0], 0], [x[1], y[0], 0], [x[1], y[1], 0], [x[0], y[1], 0]], float)
    return Mesh(corners, np.array([[0, 2, 1], [0, 3, 2]], np.int32))


def write_scene(
    recording: Path, mesh: Mesh, poses: Poses, mesh_sigma_m: float | None, from_images: bool = False
) -> None:
    """`scene.json` and its mesh, into a folder that holds a recording; `from_images`: where its poses come from.

    A mesh without `mesh_sigma_m` was reconstructed from the recording itself.
    """
    write_mesh(recording / "scene.ply", mesh)
    about: dict[str, str | float] = {"source": poses[0], "sigma_m": poses[1], "sigma_rad": poses[2]}
    about |= {"from": "images"} if from_images else {}
    known = {"mesh_from": "reconstruction"} if mesh_sigma_m is None else {"mesh_sigma_m": mesh_sigma_m}
    scene = {"mesh": "scene.ply", "poses": about, **known}
    (recording / "scene.json").write_text(json.dumps(scene, indent=1) + "\n")


def sensor_file(path: Path, principle: str, effects: dict[str, dict[str, tuple[float, str, float]]]) -> Path:
    """A sensor model of (value, unit, standard deviation) per parameter and effect."""
    entries = [
        {
            "effect": name,
            "parameters": {key: {"value": v, "unit": unit, "std": std} for key, (v, unit, std) in parameters.items()},
            "source": "what is known before the recording is looked at",
        }
        for name, parameters in effects.items()
    ]
    content = {"format": "fusion-sensor/1", "name": path.stem, "principle": principle, "effects": entries}
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return path


def root_mean_square(values: NDArray[np.floating]) -> float:
    """Of an array with NaN."""
    return float(np.sqrt(np.nanmean(np.square(values))))
