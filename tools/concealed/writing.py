"""Writes what the engine may see: recordings, meshes as stated, poses as stated, the known part of the sensor model."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial.transform import Rotation

from concealed.decks import SIGMA_M, SIGMA_RAD
from concealed.rays import Panel
from concealed.shot import Shot

Array = NDArray[np.float64]


def write_recording(folder: Path, shot: Shot, depth: Array, amplitude: Array | None, about: dict[str, Any]) -> None:
    """One recording; `about` holds `scale`, `mesh_sigma_m`, `telemetry`."""
    flight = amplitude is not None
    for name in ("depth", "ir") if flight else ("depth",):
        (folder / name).mkdir(parents=True)
    c = shot.camera
    camera: dict[str, Any] = {"width": c.width, "height": c.height, "fx": c.f, "fy": c.f, "cx": c.cx, "cy": c.cy}
    camera |= {"distortion": [0.0] * 5, "depth_scale": about["scale"]}
    camera |= {"principle": "itof" if flight else "structured_light", "sensor": "trial"}
    scene = {"mesh": "scene.ply", "poses": {"source": "surveyed", "sigma_m": SIGMA_M, "sigma_rad": SIGMA_RAD}}
    if about["mesh_sigma_m"]:
        scene["mesh_sigma_m"] = about["mesh_sigma_m"]
    (folder / "camera.json").write_text(json.dumps(camera))
    (folder / "scene.json").write_text(json.dumps(scene))
    (folder / "scene.ply").write_text(_mesh(shot.panels))
    names = [f"depth/{t:.6f}.png" for t in shot.times]
    for name, z in zip(names, depth, strict=True):
        Image.fromarray(np.clip(np.round(z * about["scale"]), 0, 65534).astype(np.uint16)).save(folder / name)
    _lines(folder / "depth.txt", [f"{t:.6f} {name}" for t, name in zip(shot.times, names, strict=True)])
    if amplitude is not None:
        name = f"ir/{shot.times[0]:.6f}.png"
        Image.fromarray(np.clip(np.round(amplitude), 0, 65535).astype(np.uint16)).save(folder / name)
        _lines(folder / "ir.txt", [f"{shot.times[0]:.6f} {name}"])
    pose = [*shot.stated[:3, 3], *Rotation.from_matrix(shot.stated[:3, :3]).as_quat()]
    text = " ".join(f"{x:.8f}" for x in pose)
    _lines(folder / "groundtruth.txt", [f"{t:.6f} {text}" for t in shot.times])
    if about["telemetry"]:
        rows = [f"{t:.6f},{x:.3f}" for t, x in zip(shot.times, shot.temperatures, strict=True)]
        (folder / "telemetry.csv").write_text("\n".join(["timestamp,temperature_c", *rows]) + "\n")


def _lines(path: Path, lines: list[str]) -> None:
    path.write_text("\n".join(lines) + "\n")


def _mesh(panels: list[Panel]) -> str:
    """ASCII PLY: every printed cell a square of its own; flat, whatever the surface really is."""
    vertices: list[Any] = []
    faces: list[Any] = []
    for panel in panels:
        rows, columns = panel.cells.shape
        for i in range(rows):
            for j in range(columns):
                grey = round(float(panel.cells[i, j]) * 255)
                first = len(vertices)
                for s, t in ((j, i), (j + 1, i), (j + 1, i + 1), (j, i + 1)):
                    x = panel.corner + panel.a * s / columns + panel.b * t / rows
                    vertices.append(f"{x[0]:.7f} {x[1]:.7f} {x[2]:.7f} {grey} {grey} {grey}")
                faces += [f"3 {first} {first + 1} {first + 2}", f"3 {first} {first + 2} {first + 3}"]
    head = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
    head += [f"property float {axis}" for axis in "xyz"] + [
        f"property uchar {name}" for name in ("red", "green", "blue")
    ]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    return "\n".join(head + vertices + faces) + "\n"


def sensor_file(effects: list[dict[str, Any]], flight: bool) -> str:
    """The text of sensor.json."""
    content = {"format": "fusion-sensor/1", "name": "trial", "principle": "itof" if flight else "structured_light"}
    return json.dumps({**content, "effects": effects}, indent=1)


def entry(effect: str, **values: tuple[float, str, float]) -> dict[str, Any]:
    """One effect; every value is (number, unit, standard deviation)."""
    parameters = {name: {"value": v, "unit": unit, "std": std} for name, (v, unit, std) in values.items()}
    return {"effect": effect, "parameters": parameters, "source": "trial"}
