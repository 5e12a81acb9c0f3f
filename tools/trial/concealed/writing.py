"""Writes what the engine may see: recordings, meshes as stated, poses as stated, the known part of the sensor model."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial.transform import Rotation

from tools.trial.concealed.decks import SIGMA_M, SIGMA_RAD
from tools.trial.concealed.rays import Panel
from tools.trial.concealed.shot import Shot

Array = NDArray[np.float64]


def write_recording(
    folder: Path, shots: list[Shot], taken: list[tuple[Array, Array | None]], about: dict[str, Any]
) -> None:
    """One recording of one or more shots; `about` holds `scale`, `mesh_sigma_m`, `temperature`, `grey`."""
    shot, flight = shots[0], taken[0][1] is not None
    for name in ("depth", "ir") if flight else ("depth",):
        (folder / name).mkdir(parents=True)
    c = shot.camera
    camera: dict[str, Any] = {"width": c.width, "height": c.height, "fx": c.f, "fy": c.f, "cx": c.cx, "cy": c.cy}
    camera |= {"distortion": [0.0] * 5, "depth_scale": about["scale"]}
    camera |= {"principle": "itof" if flight else "structured_light", "sensor": "trial"}
    (folder / "camera.json").write_text(json.dumps(camera))
    (folder / "scene.json").write_text(json.dumps(_scene(shots, about)))
    (folder / "scene.ply").write_text(shot.kept.get("mesh") or mesh_text(shot.panels, about["grey"]))
    times = np.concatenate([one.times for one in shots])
    names = [f"depth/{t:.6f}.png" for t in times]
    for name, z in zip(names, np.concatenate([depth for depth, _ in taken]), strict=True):
        Image.fromarray(np.clip(np.round(z * about["scale"]), 0, 65534).astype(np.uint16)).save(folder / name)
    _lines(folder / "depth.txt", [f"{t:.6f} {name}" for t, name in zip(times, names, strict=True)])
    lit = [(one.times[0], ir) for one, (_, ir) in zip(shots, taken, strict=True) if ir is not None]
    for t, ir in lit:
        Image.fromarray(np.clip(np.round(ir), 0, 65535).astype(np.uint16)).save(folder / f"ir/{t:.6f}.png")
    if lit:
        _lines(folder / "ir.txt", [f"{t:.6f} ir/{t:.6f}.png" for t, _ in lit])
    _lines(folder / "groundtruth.txt", [line for one in shots for line in _poses(one)])
    _log(folder, shots, about["temperature"])


def _scene(shots: list[Shot], about: dict[str, Any]) -> dict[str, Any]:
    scene: dict[str, Any] = {"mesh": "scene.ply"}
    s = shots[0].sigma
    scene["poses"] = {"source": "surveyed", "sigma_m": s * SIGMA_M, "sigma_rad": s * SIGMA_RAD}
    if about["mesh_sigma_m"]:
        scene["mesh_sigma_m"] = about["mesh_sigma_m"]
    if shots[0].degrees is not None:  # poses and mesh in the frame of what turns
        axis = {"axis_point": [0.0, 0.0, 0.0], "axis_direction": [0.0, 0.0, 1.0]}
        scene["trajectory"] = {"turntable": axis, "continuous": len(shots[0].times) == 1}
    return scene


def _poses(shot: Shot) -> list[str]:
    pose = [*shot.stated[:3, 3], *Rotation.from_matrix(shot.stated[:3, :3]).as_quat()]
    text = " ".join(f"{x:.8f}" for x in pose)
    return [f"{t:.6f} {text}" for t in shot.times]


def _log(folder: Path, shots: list[Shot], temperature: bool) -> None:
    columns: dict[str, list[float]] = {}
    if shots[0].degrees is not None:
        columns["turntable_deg"] = [float(shot.degrees or 0.0) for shot in shots for _ in shot.times]
    if temperature:
        columns["temperature_c"] = [float(x) for shot in shots for x in shot.temperatures]
    if columns:
        times = [t for shot in shots for t in shot.times]
        rows = [
            ",".join([f"{t:.6f}", *(f"{x:.4f}" for x in row)]) for t, *row in zip(times, *columns.values(), strict=True)
        ]
        _lines(folder / "telemetry.csv", [",".join(["timestamp", *columns]), *rows])


def _lines(path: Path, lines: list[str]) -> None:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def mesh_text(panels: list[Panel], one_grey: bool) -> str:
    """ASCII PLY: every printed cell a square of its own; flat, whatever the surface really is."""
    vertices: list[Any] = []
    faces: list[Any] = []
    for panel in panels:
        rows, columns = panel.cells.shape
        for i in range(rows):
            for j in range(columns):
                grey = 128 if one_grey else round(float(panel.cells[i, j]) * 255)
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
